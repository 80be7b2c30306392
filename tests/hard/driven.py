"""Random runs of chains and loops with a driven joint that fall on rough ground, and what must never be in them."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ccgen.runtime import Model, simulate

SECONDS = 8.0
LAWS = ("newton", "poisson", "stronge")


@dataclass(frozen=True)
class Driven:
    """A run: of ``links`` rods in a ``kind`` of mechanism, whose first joint turns at ``speed`` (rad/s)."""

    kind: str
    links: int
    law: str
    friction: float
    restitution: float
    speed: float
    seed: int


def driven(count: int, seed: int) -> list[Driven]:
    """The first ``count`` runs of ``seed``: two thirds are chains of two to four rods, the others loops of five to
    seven; half of them without friction, the others with up to 2."""
    rng = np.random.default_rng(seed)
    found = []
    for _ in range(count):
        kind = ("chain", "chain", "loop")[rng.integers(3)]
        links = int(rng.integers(2, 5) if kind == "chain" else rng.integers(5, 8))
        friction = float(rng.choice([0.0, rng.uniform(0.0, 2.0)]))
        restitution = float(rng.choice([0.0, 0.5, 1.0, rng.uniform()]))
        speed = float(rng.uniform(-1.0, 1.0) * rng.choice([1.0, 5.0, 20.0]))
        law = LAWS[rng.integers(3)]
        found.append(Driven(kind, links, law, friction, restitution, speed, int(rng.integers(1 << 30))))
    return found


def scene(kind: str, links: int) -> str:
    """Rods of 1 m and 1 kg in a zigzag or a polygon; all joints and ends may touch the ground."""
    rods = "".join(
        f'[[link]]\nname = "r{i}"\nmass = 1.0\ninertia = {1 / 12}\ncom = [0.5, 0]\n'
        "points = { A = [0, 0], B = [1, 0] }\n"
        for i in range(links)
    )
    pairs = [(i, i + 1) for i in range(links - 1)] + [(links - 1, 0)] * (kind == "loop")
    joints = "".join(f'[[joint]]\nname = "j{i}"\nbetween = ["r{i}.B", "r{k}.A"]\n' for i, k in pairs)
    points = ['"r0.A"'] * (kind == "chain") + [f'"r{i}.B"' for i in range(links)]
    angles = [0.7 * (-1.0) ** i if kind == "chain" else 2.0 * np.pi * i / links for i in range(links)]
    return (
        f"{rods}{joints}[ground_link]\npoints = {{ O = [0, 0] }}\n[gravity]\ng = 9.81\n[[ground]]\nrestitution = 0.5\n"
        f'friction = 0.5\ncontacts = [{", ".join(points)}]\n[[drive]]\njoint = "j0"\nspeed = 3.0\n[start]\n'
        f"position = [0, 3]\nangles = {[float(angle) for angle in angles]}\n"
    )


def begin(model: Any, one: Driven) -> tuple[Any, Any, Any]:
    """The model with the numbers of a run, and a start (q, u) 0.2 m above the ground, at which the driven joint turns
    as it is to."""
    values = {"ground_0.restitution": one.restitution, "ground_0.friction": one.friction, "drive_0.speed": one.speed}
    model = Model(model._descriptor, {**model.data, "law": one.law}).with_parameters(values)
    rng = np.random.default_rng(one.seed)
    for attempt in range(60):
        q, u = model.start()
        turns, rates = 0.5 * 0.9**attempt * rng.normal(size=q.size), rng.normal(size=u.size)
        turns[:2] = 0.0
        rates[3 : None if one.kind == "loop" else 4] = rates[2]
        try:
            q, u = model.project(model.assemble(q + turns), u + rates)
        except ValueError:
            continue
        q[1] += 0.2 - model.gaps(q).min()
        return model, q, u
    raise ValueError(f"{one}: no start")


def run(workshop_model: Callable[[str], Any], one: Driven) -> Any:
    """The run of it."""
    model, q, u = begin(workshop_model(scene(one.kind, one.links)), one)
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", ".*masses differ so much")
        return simulate(model, q, u, until=SECONDS)


def faults(found: Any, one: Driven) -> list[str]:
    """What must never be, whether the run reached its end or not."""
    model, wrong = found.model, []
    spins = model.velocities(found.q, found.u)[:, :, 2]
    strays = float(np.max(np.abs(spins[:, 1] - spins[:, 0] - one.speed))) / max(1.0, abs(one.speed))
    scale = float(model.kernels.heaviest(found.q[0]) + np.max(np.abs(np.sum(model.energy(found.q, found.u), axis=0))))
    if not strays <= 1e-9:
        wrong.append(f"the driven joint strays from its speed by {strays:.2g}")
    if not found.penetration_max <= 1e-9:
        wrong.append(f"penetration of {found.penetration_max:.2g} m")
    if not found.closure_max <= 1e-11:
        wrong.append(f"closure of {found.closure_max:.2g} m")
    if not found.energy_drift <= 1e-4 * scale:
        wrong.append(f"energy drifts by {found.energy_drift / scale:.2g} of its scale")
    return wrong
