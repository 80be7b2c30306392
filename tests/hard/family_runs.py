"""Runs of what ``families.py`` draws: a start with everything apart, the run from it, and what must never be in it."""

from __future__ import annotations

import time
import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np

from ccgen.runtime import Model, simulate

from ..support.endings import ending
from .families import Throw

LONG = {"scales"}
"""The families of runs that are long: their light links turn 10,000 times in one, which takes 100,000 steps."""
FASTEST = 30.0
"""Times the spin of a throw: no link turns faster at the start, however short it is beside the others of its loop."""


def begin(model: Any, thrown: Throw) -> tuple[Any, Any, Any]:
    """The model with the numbers of the throw, and a start (q, u) with everything apart."""
    rng = np.random.default_rng(thrown.seed)
    model = Model(model._descriptor, {**model.data, "law": thrown.law}).with_parameters(
        {name: value for name, value in thrown.values.items() if name in model.parameters}
    )
    for attempt in range(60):
        bend = thrown.bend * 0.9**attempt
        try:
            q, u = model.start()
            turns = rng.normal(size=q.size)
            turns[:2] *= q.size == u.size
            q, u = model.project(model.assemble(q + bend * turns), thrown.spin * rng.normal(size=u.size))
            most = FASTEST * thrown.spin
            u *= min(1.0, most / float(np.max(np.abs(model.velocities(q, u)[:, 2]))))
        except ValueError:
            continue
        _surround(model, q, thrown, rng)
        if model.gaps(q).min() > 0.0:
            return model, q, u
    raise ValueError(f"{thrown.family} {thrown.number}: no start with everything apart")


def _surround(model: Any, q: Any, thrown: Throw, rng: np.random.Generator) -> None:
    """Put grounds and limits of stops near the start."""
    gaps = dict(zip(model.contacts, model.gaps(q), strict=True))
    length = size(model)
    for ground in sorted({name for _, name in gaps if name.startswith("ground")}):
        least = min(gap for (_, name), gap in gaps.items() if name == ground)
        away = least - thrown.clear * length * rng.uniform(0.01, 1.0)
        normal = np.array([model.parameters[f"{ground}.normal.{axis}"] for axis in "xy"])
        for k, axis in enumerate("xy"):
            model.parameters[f"{ground}.point.{axis}"] += float(away * normal[k] / np.hypot(*normal))
    for (_, name), gap in gaps.items():
        if name.startswith("stop"):
            move = gap - rng.uniform(0.05, 1.0)
            model.parameters[name] += float(move if name.endswith("lowest") else -move)


def size(model: Any) -> float:
    """The largest distance of two points of a link."""
    points: dict[str, list[tuple[float, float]]] = {}
    for name, value in model.parameters.items():
        link, *rest = name.split(".")
        if rest and rest[0] == "points" and rest[2] == "x" and link != "ground":
            points.setdefault(link, []).append((value, model.parameters.get(f"{link}.points.{rest[1]}.y", 0.0)))
    found = [float(np.hypot(*np.subtract(a, b))) for at in points.values() for a in at for b in at]
    return max(found, default=0.25) or 0.25


@dataclass(frozen=True)
class Result:
    """What became of a throw."""

    run: Any
    wall: float
    wrong: tuple[str, ...]

    @property
    def end(self) -> str:
        try:
            return ending(self.run)
        except ValueError:
            return str(self.run.message)

    @property
    def stepped(self) -> float:
        """The part of the run's time that went by time stepping."""
        return sum(p.end - p.start for p in self.run.phases if p.kind == "steps") / max(self.run.t[-1], 1e-300)

    @property
    def eased(self) -> int:
        """How many impacts had less than their restitution."""
        return sum(impact.restitution_share < 1.0 for impact in self.run.impacts)


def run(model: Any, thrown: Throw, limit: float) -> Result:
    """Run a throw, for ``limit`` seconds of the wall clock at most."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", ".*masses differ so much")
        model, q, u = begin(model, thrown)
    began = time.monotonic()

    def watch(_: float) -> None:
        if time.monotonic() - began > limit:
            raise KeyboardInterrupt

    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", ".*masses differ so much")
        found = simulate(model, q, u, until=thrown.seconds, rtol=thrown.rtol, progress=watch, keep_interrupted=True)
    wall = time.monotonic() - began
    return Result(found, wall, tuple(faults(found, thrown.rtol, long=thrown.family in LONG)))


def scale_and_rise(found: Any) -> tuple[float, float]:
    """The scale of the energy (J), and by how much of it the energy rises."""
    kinetic, potential = found.model.energy(found.q, found.u)
    energy = kinetic + potential
    scale = float(kinetic.max() + np.ptp(potential)) or 1.0
    return scale, float(np.max(energy - np.minimum.accumulate(energy))) / scale


def faults(found: Any, rtol: float, *, long: bool = False) -> list[str]:
    """What must never be, whether the run reached its end or stopped and said why; by the scales of energy and length.

    Energy may rise by what a hundred tolerances, or roundings of accelerations that the run tells of, come to; in a
    ``long`` run by a tolerance in each of its steps.
    """
    model = found.model
    scale, rise = scale_and_rise(found)
    length = size(model)
    most = max(100.0, len(found.t) if long else 0.0) * max(rtol, found.acceleration_error)
    active = model.kernels.works
    depth = -float(found.model.gaps(found.q).min()) / length
    wrong = []
    if not (np.all(np.isfinite(found.q)) and np.all(np.isfinite(found.u))):
        wrong.append("numbers that are not finite")
    if not depth <= 1e-9:
        wrong.append(f"penetration of {depth:.2g} lengths")
    if not active and not rise <= most:
        wrong.append(f"energy rises by {rise:.2g} of its scale")
    if active and not found.energy_drift / scale <= most:
        wrong.append(f"energy drifts by {found.energy_drift / scale:.2g} of its scale")
    if not found.closure_max / length <= 1e-11:
        wrong.append(f"closure of {found.closure_max / length:.2g} lengths")
    least = min((impact.energy_loss for impact in found.impacts), default=0.0) / scale
    if not least >= -1e-13:
        wrong.append(f"an impact gains {-least:.2g} of the energy's scale")
    return wrong
