"""``double_period(flip)``: from a flip to the motions of twice the period that begin there."""

from __future__ import annotations

import numpy as np

from .bifurcation import Bifurcation
from .corrector import Corrector, Missed
from .orbit import Orbit

TRIES = (0.004, 0.01, 0.002, 0.03)
"""How far from the flip a motion of twice the period is looked for, along the direction that turns round, in units of
the mechanism."""


def double_period(flip: Bifurcation) -> Orbit:
    """A periodic motion of twice the period beside a flip, at the value of the parameter at which there is one.

    It is looked for along the eigenvector of the multiplier -1, at which the two crossings part (R. Seydel, Practical
    Bifurcation and Stability Analysis, 2010, section 7.4.2). The parameter's value is that of the model of its run.
    Raises ``ValueError`` for what is no flip, and where there is no such motion near it.
    """
    if not isinstance(flip, Bifurcation) or flip.kind != "flip":
        found = flip.kind if isinstance(flip, Bifurcation) else type(flip).__name__
        raise ValueError(f"flip: found {found}, expected a flip among the bifurcations of a branch")
    orbit = flip.orbit
    model, chain = orbit.return_map.model, orbit.chain
    unit = max(abs(flip.value), model.parameters[flip.parameter]) or 1.0
    single, double = (Corrector(one, orbit.period, flip.parameter, unit) for one in (chain, chain.doubled()))
    times = len(double.chain.maps) // len(chain.maps)
    first = double.begin(np.tile(orbit.nodes, (times, 1)), flip.value)
    values, vectors = np.linalg.eig(orbit.matrix)
    step = [vectors[:, int(np.argmin(np.abs(values + 1.0)))].real]
    for block in double.chain.blocks(first.crossed)[:-1]:
        step.append(block @ step[-1])
    direction = double.along(first.crossed) @ np.concatenate([*step, [0.0]])
    direction /= np.linalg.norm(direction)
    # the branch of the single period lies in the plane normal to this, but for its curvature
    tangent = single.begin(orbit.nodes, flip.value).tangent
    tangent = np.append(np.tile(tangent[:-1], times) / np.sqrt(times), tangent[-1])
    normal = direction - float(direction @ tangent) * tangent
    normal /= np.linalg.norm(normal)
    for part in TRIES:
        try:
            point = double.point(first.place + part * direction, normal, first)
        except Missed:
            continue
        return point.orbit
    raise ValueError(f"{model.name}: found no motion of twice the period near the flip at {flip.value:.9g}")
