"""Values of a run's outputs at times, without their derivatives."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..arrays import FloatArray
from ..model.places import places_of
from ..record.outputs import values_of
from ..run import Run
from ..sensitivity.told import TIMES, WHOLE, Output, label, value_of


def output_values(run: Run, outputs: Sequence[Output], times: FloatArray) -> dict[str, FloatArray]:
    """Each output by its name, (times,) or (times, n) of what is no number; impact times (impacts,)."""
    places, found = places_of(run.model), dict[str, FloatArray]()
    states = dict(zip(WHOLE, run.at(times), strict=True))
    for output in outputs:
        name = label(output)
        if callable(output):
            rows = zip(times.tolist(), *states.values(), strict=True)
            found[name] = np.array([value_of(output, *row) for row in rows])
        elif output == TIMES:
            found[name] = np.array([impact.t for impact in run.impacts])
        elif output in WHOLE:
            found[name] = np.asarray(states[output])
        elif places[output][0] in WHOLE:
            of, index = places[output]
            found[name] = np.asarray(states[of][:, index[0]])
        else:
            found[name] = np.asarray(values_of(run, [output], times)[output])
    return found
