"""Runs in which the ends of a spring or damper meet, from which on there are no derivatives, or none that are known."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..arrays import FloatArray, IntArray
from ..model.model import Model
from ..model.part import Part
from ..record.in_force import APART
from ..record.motion_at_rows import motion_at_rows
from ..record.record import Record

MET = 1e-9
"""Ends that are nearer, against the mechanism's length or the longest that the line has been, meet: only short steps
end there, of which one ends within the rounding of places, 1e-12 lengths, however little the line moves."""

ALONG = 1e-9
"""Directions are one if they differ by less than this (rad): far more than by rounding of numbers along a guide, 1e-16,
and far less than by rounding of the places of ends that meet, which is a ten-thousandth of their distance."""


def meetings(run: Record, model: Model) -> Iterator[tuple[str, float, str]]:
    """Per line whose ends meet in the run, its name, the first time (s) at which they do, and why that matters.

    The force of a spring with a length at rest jumps there. That of a damper does not, but its derivative is one of
    directions over distances, and of ends a distance r apart a direction is known to rounding of places over r. Where
    the direction is that of a guide it is known, as is that derivative.
    """
    lengths = [k for k, (name, _) in enumerate(model.told) if name.endswith(".length") and name in model.parameters]
    told = motion_at_rows(run).told if lengths else np.zeros((0, 0))  # the forces of all rows are found for them
    for k in lengths:
        met = _met(model, told[:, k])
        if len(met):
            why = "its force jumps there, at an instant that is not differentiated"
            yield model.told[k][0].removesuffix(".length"), float(run.t[met[0]]), why
    for part in model.parts:
        if part.kind == "damper":
            met = _met(model, np.hypot(*_reach(model, part, run.q).T))
            if len(met) and _turns(model, part, run.q[met]):
                why = "its direction is rounding there, and with it the derivative of its force"
                yield part.name, float(run.t[met[0]]), why


def _met(model: Model, lengths: FloatArray) -> IntArray:
    """The rows, of ``lengths`` (rows,), at which ends meet; none of what is off."""
    longest = np.max(lengths, where=lengths < APART, initial=model.length)
    return np.flatnonzero(lengths <= MET * longest)


def _reach(model: Model, part: Part, q: FloatArray) -> FloatArray:
    """From the first end to the second at q (..., n), (..., 2) in m."""
    poses, ends = model.poses(q), list[FloatArray]()
    for link, (x, y) in zip(part.links, part.points, strict=True):
        at = poses[..., link, :] if link >= 0 else np.zeros((*poses.shape[:-2], 3))
        c, s = np.cos(at[..., 2]), np.sin(at[..., 2])
        ends.append(at[..., :2] + np.stack([c * x - s * y, s * x + c * y], axis=-1))
    return ends[1] - ends[0]


def _turns(model: Model, part: Part, q: FloatArray) -> bool:
    """Whether ends that meet at q (rows, n) are seen there in directions that are not one, or may be moved apart so."""
    steps = np.diag(1e-3 * model.coordinate_units)
    ways = np.concatenate([_reach(model, part, at) for at in (q, q[0] + steps, q[0] - steps)])
    sizes = np.hypot(*ways.T)
    way = ways[np.argmax(sizes)]
    aside = np.abs(ways[:, 0] * way[1] - ways[:, 1] * way[0])
    return bool(np.any(aside > ALONG * sizes * np.max(sizes)))
