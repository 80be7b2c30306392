"""Derivatives of runs along one direction, where there is no matrix: ``directional(model, {"q0": d}, ["tip.x"])``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .arrays import FloatArray
from .model.inputs import Given
from .model.model import Model
from .model.numbers import read_numbers
from .sensitivity.in_order import pass_in_order
from .sensitivity.jacobian import Sensitivities, run_sensitivities
from .sensitivity.moving import STARTS
from .sensitivity.told import TIMES, Output, read_outputs
from .simulate import simulate


def directional(
    model: Model,
    direction: Mapping[str, ArrayLike],
    outputs: Sequence[Output] | Output = ("q", "u"),
    q0: ArrayLike | None = None,
    u0: ArrayLike | None = None,
    *,
    at: ArrayLike | None = None,
    until: float | None = None,
    rtol: float | None = None,
    atol: float | None = None,
    method: str | None = None,
    step: float | None = None,
    params: Mapping[str, float] | None = None,
    inputs: Given = None,
) -> Sensitivities:
    """Simulate a model and derive its run along one direction, on the side to which it points.

    As :func:`sensitivities`, but for one ``direction``: entries (n,) of ``"q0"`` and ``"u0"``, a number of each
    parameter or input, all together. Where contacts strike together that it parts, as the feet of a chair by its angle,
    they strike in the order in which it brings them to the ground, and the derivative is the limit of differences for
    steps in this direction alone (the B-derivative: piecewise linear, twice the direction gives twice as much, the
    opposite one something else). The result has one column.

    Raises ``ValueError`` as :func:`sensitivities` does, and where such a run is not continuous: where strikes one after
    the other end with other rates than together. Times of impacts are no outputs, as there may be more of them.
    """
    if not isinstance(model, Model):
        raise TypeError(f"model: found {type(model).__name__}, expected a Model; load one with load_model(folder)")
    if not isinstance(direction, Mapping):
        found = type(direction).__name__
        raise TypeError(f"direction: found {found}, expected a mapping of names, as {{'q0': [0.0, 1.0, 0.0]}}")
    chosen = read_outputs(outputs)
    if TIMES in chosen:
        raise ValueError(f"outputs: found {TIMES}, expected others: along a direction there may be other impacts")
    options: dict[str, Any] = {"until": until, "rtol": rtol, "atol": atol, "method": method, "step": step}
    run = simulate(model, q0, u0, params=params, inputs=inputs, **options)
    if isinstance(run, list):
        raise ValueError(f"q0: found {len(run)} starts, expected one; derive them one by one")
    given = tuple(None if part is None else np.asarray(part, dtype=float) for part in (q0, u0))
    wrt = {name: _column(name, value, len(model.q_names)) for name, value in direction.items()}
    return run_sensitivities(run, wrt, chosen, at, (given[0], given[1]), "tangent", pass_in_order)


def _column(name: str, value: ArrayLike, n: int) -> FloatArray:
    """A direction as the one column that it is."""
    found = np.asarray(read_numbers(value, f"direction: {name}"), dtype=float)
    shape = (n,) if name in STARTS else ()
    found = found[0] if not shape and found.shape == (1,) else found
    if found.shape != shape or not np.all(np.isfinite(found)):
        what = "what is no finite number" if found.shape == shape else f"shape {found.shape}"
        raise ValueError(f"direction: {name}: found {what}, expected finite numbers of shape {shape}")
    return found.reshape(-1, 1)
