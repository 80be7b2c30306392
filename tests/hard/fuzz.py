"""Random loops on random grounds: what must hold whatever happens. ``test_fuzz.py`` draws from here, and so does
``docs/scripts/laws.py``; every failure that is found becomes a named case of its own."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from ccgen.generator import loop
from ccgen.runtime import Model, simulate

from ..support.endings import ending

SECONDS = 10.0
RTOL = 1e-11
"""Tighter than the default: what rtol allows the energy to drift in flight would hide what is looked for."""
TILTS = (0.3, -0.4)
RESTITUTIONS = (0.0, 0.1, 0.3, 0.5, 0.7, 0.9, 1.0)
FRICTIONS = (0.05, 0.1, 0.3, 0.7, 1.2)
FAR = 1000.0
"""Metres below the level plane at which the second one lies where a toss has but one."""


@dataclass(frozen=True)
class Toss:
    """One run: a loop of ``n`` rods thrown onto one or two rough or smooth planes."""

    n: int
    planes: int
    rough: bool
    law: str
    restitution: float
    friction: float
    seed: int


def tosses(count: int, seed: int, rough: bool | None = None, law: str | None = None) -> Iterator[Toss]:
    """The first ``count`` tosses of ``seed``, all choices as likely as each other: the same on every machine.

    ``rough`` and ``law`` are drawn where they are not given; given, they make other tosses of the seed.
    """
    rng = np.random.default_rng(seed)
    for _ in range(count):
        yield Toss(
            n=int(rng.integers(3, 13)),
            planes=int(rng.integers(1, 3)),
            rough=bool(rng.integers(2)) if rough is None else rough,
            law=("newton", "poisson")[rng.integers(2)] if law is None else law,
            restitution=RESTITUTIONS[rng.integers(len(RESTITUTIONS))],
            friction=FRICTIONS[rng.integers(len(FRICTIONS))],
            seed=int(rng.integers(2**31)),
        )


def scene(n: int, rough: bool) -> Any:
    """The scene of all tosses that differ in numbers alone, so that few models are built for many tosses."""
    grounds = []
    for plane, tilt in enumerate(TILTS):
        ground: dict[str, Any] = {"restitution": 0.5, "normal": [tilt, 1.0], "point": [0.0, -float(plane) * FAR]}
        if rough:
            ground["friction"] = 0.5
        grounds.append(ground)
    return loop(n, gravity=True, start={"height": 1.0}, ground=grounds)


def numbers(toss: Toss, rng: np.random.Generator) -> dict[str, float]:
    """The grounds of the toss, lengths and masses. One plane alone is level, the other out of reach below it."""
    values = {"ground_1.point.y": 0.0 if toss.planes > 1 else -FAR}
    for plane in range(2):
        values[f"ground_{plane}.normal.x"] = TILTS[plane] if toss.planes > 1 else 0.0
        values[f"ground_{plane}.restitution"] = toss.restitution
        if toss.rough:
            values[f"ground_{plane}.friction"] = toss.friction
    for k in range(toss.n):
        values[f"link_{k}.length"] = float(rng.uniform(0.8, 1.3))
        values[f"link_{k}.mass"] = float(rng.uniform(0.5, 2.0))
    return values


def run(model: Any, toss: Toss, until: float = SECONDS, rtol: float = RTOL, method: str | None = None) -> Any:
    """Lengths, masses, start and velocities from the seed; ``model`` is that of :func:`scene`."""
    rng = np.random.default_rng(toss.seed)
    model = Model(model._descriptor, {**model.data, "law": toss.law}).with_parameters(numbers(toss, rng))
    q, u = model.start()
    u = u + 2.0 * rng.normal(size=u.size)
    q = q.copy()
    q[2:] += rng.normal()
    q, u = model.project(q, u)
    q[1] += 0.2 + 1.5 * max(0.0, -float(model.gaps(q).min()))
    return simulate(model, q, u, until=until, rtol=rtol, method=method)


def rise_of_energy(found: Any) -> float:
    """The most that the energy rises by, in parts of that at the start."""
    energy = np.sum(found.model.energy(found.q, found.u), axis=0)
    return float(np.max(energy - np.minimum.accumulate(energy))) / max(1.0, abs(float(energy[0])))


def faults(found: Any) -> list[str]:
    """What must never be, whether the run reached its end or not."""
    rise = rise_of_energy(found)
    depth = -float(found.model.gaps(found.q).min())
    wrong = []
    if not (np.all(np.isfinite(found.q)) and np.all(np.isfinite(found.u))):
        wrong.append("numbers that are not finite")
    if depth > 1e-9:
        wrong.append(f"penetration of {depth:.2g} m")
    if rise > 1e-9:
        wrong.append(f"energy rises by {rise:.2g} of that at the start")
    if found.closure_max > 1e-11:
        wrong.append(f"closure of {found.closure_max:.2g} m")
    try:
        ending(found)
    except ValueError as error:
        wrong.append(f"an end without a reason: {error}")
    return wrong
