"""Lengths, masses, speeds and numbers of links far from one: accelerations and impacts against wider precision."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from ccgen.generator import chain, loop
from ccgen.runtime import simulate
from ccgen.runtime.model.assembly import rounding_of
from ccgen.runtime.model.samples import samples

from ..oracles import maximal, mechanisms, polygons
from ..oracles.maximal import Array, Pin, System
from ..oracles.mechanisms import Drawing
from ..support.reach import Reach
from ..support.tiers import LARGE, all_hard_but, hard
from ..support.workshop import Workshop

FAR = 1e9
"""Ratio of masses at which digits are lost."""


def error(model: Any, system: System, q: Array, u: Array) -> float:
    """Largest error of the angular accelerations, relative to the largest of them, against the dense wide solution."""
    angular = [k for k, name in enumerate(model.u_names) if name.startswith("w_")]
    links = [int(model.u_names[k][2:]) for k in angular]
    motion = maximal.accelerate(system, model.poses(q), model.velocities(q, u))
    wanted = motion.frames[links, 2]
    return float(np.max(np.abs(model.acceleration(q, u)[angular] - wanted)) / np.max(np.abs(wanted)))


def weigh(model: Any, system: System, factor: Array) -> System:
    """The drawn mechanism, and its model, with masses and inertias times ``factor``."""
    heavier = replace(system, mass=system.mass * factor, inertia=system.inertia * factor)
    values = {f"body_{k}.mass": float(m) for k, m in enumerate(heavier.mass)}
    model.parameters.update(values | {f"body_{k}.inertia": float(i) for k, i in enumerate(heavier.inertia)})
    return heavier


def bent(model: Any, drawing: Drawing, rng: np.random.Generator) -> tuple[Array, Array]:
    """A state of the drawn mechanism away from the drawing."""
    q, _ = model.state_from_poses(drawing.poses, np.zeros_like(drawing.poses))
    angles = [k for k, name in enumerate(model.q_names) if name.startswith("theta_")]
    q[angles] += rng.uniform(-0.35, 0.35, len(angles))
    state: tuple[Array, Array] = model.project(model.assemble(q), rng.normal(size=len(model.u_names)))
    return state


def heavy_last(n: int, rng: np.random.Generator) -> Array:
    return np.where(np.arange(n) == n - 1, 1.0, 1.0 / FAR)


def heavy_half(n: int, rng: np.random.Generator) -> Array:
    return np.where(np.arange(n) < n // 2, 1.0 / FAR, 1.0)


def in_turn(n: int, rng: np.random.Generator) -> Array:
    return np.where(np.arange(n) % 2, 1.0 / FAR, 1.0)


def one_heavy(n: int, rng: np.random.Generator) -> Array:
    return np.where(np.arange(n) == rng.integers(n), 1.0, 1.0 / FAR)


def at_random(n: int, rng: np.random.Generator) -> Array:
    return np.asarray(10.0 ** rng.uniform(-np.log10(FAR), 0.0, n))


Pattern = Callable[[int, np.random.Generator], Array]
PATTERNS: tuple[Pattern, ...] = (heavy_last, heavy_half, in_turn, one_heavy, at_random)
DRAWINGS = {
    "hinged chain of 6": mechanisms.hinged(6),
    "open chain of 6": mechanisms.open_chain(6),
    "ring of 6": mechanisms.floating(6),
    "ring of 24": mechanisms.floating(24),
    "6 between supports": mechanisms.pinned(6),
    "two loops of 12": mechanisms.two_loops(12),
    "ladder of 3": mechanisms.ladder(3),
}
SMALL = ("hinged chain of 6", "ring of 6", "two loops of 12")


@pytest.mark.sample(1)
@pytest.mark.parametrize("name", all_hard_but(*SMALL, of=DRAWINGS))
def test_masses_nine_orders_apart(name: str, workshop: Workshop, reach: Reach) -> None:
    """What the elimination loses is found when the masses are set, and given back."""
    drawing = DRAWINGS[name]
    model, system = workshop.model(drawing.toml()), drawing.system
    rng = np.random.default_rng(5)
    worst, lost = 0.0, 0.0
    for pattern in PATTERNS:
        for _ in range(4):
            weigh(model, system, np.ones(system.size))
            q, u = bent(model, drawing, rng)
            heavier = weigh(model, system, pattern(system.size, rng))
            lost = max(lost, float(np.divide(*model.kernels.rounding(q[None], u[None])[0])))
            worst = max(worst, error(model, heavier, q, u))
    reach(f"{name}, masses to 1e9 apart: acceleration without repair", lost, 1e-5)
    reach(f"{name}, masses to 1e9 apart: acceleration", worst, 1e-9)
    weigh(model, system, np.ones(system.size))


@pytest.mark.hard
def test_a_force_between_heavy_links_through_a_light_cut_is_told(workshop: Workshop, reach: Reach) -> None:
    """Two heavy links pull at each other through a light one that carries the cut: the multiplier's own last digit is
    as large as all forces on the light links. The warning says what is left."""
    drawing = DRAWINGS["two loops of 12"]
    model, system = workshop.model(drawing.toml()), drawing.system
    rng = np.random.default_rng(0)
    factor = np.where(np.isin(np.arange(12), (8, 10)), 1.0, 1.0 / FAR)
    worst, told = 0.0, 0.0
    for _ in range(8):
        weigh(model, system, np.ones(12))
        q, u = bent(model, drawing, rng)
        heavier = weigh(model, system, factor)
        with warnings.catch_warnings(record=True) as heard:
            warnings.simplefilter("always")
            found = error(model, heavier, q, u)
        assert bool(heard) == (model.kernels.inexact > 1e-9)
        worst, told = max(worst, found), max(told, model.kernels.inexact)
    assert told > 1e-9
    reach("heavy links through a light cut: acceleration", worst, 1e-6)
    reach("heavy links through a light cut: acceleration, over what is told", worst / told, 10.0)
    weigh(model, system, np.ones(12))


def test_an_impact_with_masses_nine_orders_apart(workshop: Workshop, reach: Reach) -> None:
    """A ring with one heavy link lands on a joint: velocities and impulse against the dense wide solution."""
    model = workshop.model(loop(6, gravity=True, ground=[{"restitution": 0.5}], start={"height": 1.0}))
    mass = np.where(np.arange(6) == 3, 1.0, 1.0 / FAR)
    heavier = model.with_parameters(
        {f"link_{k}.mass": float(m) for k, m in enumerate(mass)}
        | {f"link_{k}.inertia": float(m) / 12 for k, m in enumerate(mass)}
    )
    assert heavier.kernels.refined
    assert not model.kernels.refined
    system = replace(polygons.ring(6), mass=mass, inertia=mass / 12)
    q, u = model.state_from_poses(*polygons.perturbed(6))
    u[1] -= 3.0
    for joint in (0, 1, 2, 5):
        u_plus, impulses = heavier.impact(q, u, [(f"joint_{joint}", "ground_0")])
        velocities = heavier.velocities(q, u)
        jump = maximal.impact(system, heavier.poses(q), velocities, [polygons.corner(6, joint)], 0.5)
        wanted, found = jump.velocities, heavier.velocities(q, u_plus)
        scale = float(np.max(np.abs(wanted)))
        reach(f"heavy link 3, joint {joint} strikes: velocities", np.max(np.abs(found - wanted)) / scale, 1e-9)
        reach(f"heavy link 3, joint {joint} strikes: impulse", abs(impulses[0] / float(jump.impulses[0]) - 1.0), 1e-9)
    with pytest.warns(UserWarning, match="jumps are known to"):  # the heavy link is struck through a light one's end
        heavier.impact(q, u, [("joint_3", "ground_0")])


def test_a_heavy_load_on_light_links_falls(workshop: Workshop, reach: Reach) -> None:
    """A run keeps its energy where, without repair, rounding would move it."""
    model = workshop.model(chain(6, hinged=True, gravity=True))
    mass = heavy_last(6, np.random.default_rng(0))
    values = {f"link_{k}.mass": float(m) for k, m in enumerate(mass)}
    values |= {f"link_{k}.inertia": float(m) / 12 for k, m in enumerate(mass)}
    q = np.array([-0.3, 0.4, -0.5, 0.2, 0.6, -0.4])
    run = simulate(model, q, np.zeros(6), until=0.05, rtol=1e-12, params=values)
    assert run.success, run.message
    reach("heavy load on five light links: energy, J", run.energy_drift, 1e-9)
    reach("heavy load on five light links: acceleration_error", run.acceleration_error, 1e-9)


def rounding_at_samples(model: Any) -> float:
    """Largest rounding of the accelerations at the sample states, relative to the largest acceleration there."""
    lost, whole = model.kernels.rounding(*samples(model.q_names, model.length, model.time or 1.0, float)).T
    return float(lost.max() / whole.max())


@pytest.mark.parametrize("name", all_hard_but("ring of 6", of=DRAWINGS))
def test_usual_masses_need_no_repair(name: str, workshop: Workshop, reach: Reach) -> None:
    """No model with masses alike takes the repair: it has its accelerations at the usual price."""
    drawing, worst = DRAWINGS[name], 0.0
    model = workshop.model(drawing.toml())
    rng = np.random.default_rng(6)
    for _ in range(4):
        weigh(model, drawing.system, rng.uniform(0.1, 10.0, drawing.system.size))
        assert not model.kernels.refined
        worst = max(worst, rounding_at_samples(model))
    weigh(model, drawing.system, np.ones(drawing.system.size))
    reach(f"{name}, masses to 100 apart: rounding found where parameters are set", worst, 1e-13)


def ring_of(lengths: Array, mass: Array) -> System:
    """A free ring of uniform rods, each with its length and mass."""
    n = len(lengths)
    pins = tuple(Pin((k - 1) % n, (float(lengths[k - 1]), 0.0), k, (0.0, 0.0)) for k in range(n))
    com = np.column_stack([lengths / 2, np.zeros(n)])
    return System(mass, mass * lengths**2 / 12, com, pins)


def rods(model: Any, lengths: Array, mass: Array) -> Any:
    """The model of a ring with other lengths and masses."""
    values = {}
    for k, (length, m) in enumerate(zip(lengths.tolist(), mass.tolist(), strict=True)):
        values |= {f"link_{k}.length": length, f"link_{k}.mass": m}
        values |= {f"link_{k}.com.x": length / 2, f"link_{k}.inertia": m * length**2 / 12}
    return model.with_parameters(values)


LARGEST = [hard(200), hard(500)] if LARGE else []
"""They compile for two minutes."""


@pytest.mark.parametrize("n", [6, hard(100), *LARGEST])
def test_large_rings(n: int, workshop: Workshop, reach: Reach) -> None:
    """Neighbouring masses to 1e4 apart, spins to 1e4 rad/s, lengths 1e-3 to 1e3 m."""
    first = workshop.model(loop(n))
    rng = np.random.default_rng(n)
    for length in (1e-3, 1.0, 1e3):
        lengths = length * rng.uniform(0.8, 1.2, n)
        mass = 10.0 ** rng.uniform(-4.0, 0.0, n)
        model = rods(first, lengths, mass)
        q, u = model.start()
        q[:2] *= length
        q[2:] += rng.uniform(-0.3, 0.3, n)
        q, u = model.project(model.assemble(q), 1e4 * rng.normal(size=u.size))
        figure = error(model, ring_of(lengths, mass), q, u)
        reach(f"ring of {n} rods of {length:g} m at 1e4 rad/s, masses to 1e4 apart: acceleration", figure, 1e-9)


def test_long_beside_short(workshop: Workshop, reach: Reach) -> None:
    """A triangle of rods of 1 km whose corners are rods of 1 mm, and the other way round in mass."""
    lengths = np.array([1e3, 1e-3] * 3)
    angles = np.array([0.0, np.pi / 3, 2 * np.pi / 3, np.pi, 4 * np.pi / 3, 5 * np.pi / 3])
    rng = np.random.default_rng(1)
    for name, mass in (("equal masses", np.ones(6)), ("masses as lengths", lengths), ("as 1/lengths", 1 / lengths)):
        model = rods(workshop.model(loop(6)), lengths, mass)
        q, u = model.start()
        q[2:] = angles
        q, u = model.project(model.assemble(q), 1e2 * rng.normal(size=u.size))
        reach(f"rods of 1 km and 1 mm in turn, {name}: acceleration", error(model, ring_of(lengths, mass), q, u), 1e-9)


@pytest.mark.parametrize("n", [6, 60, 200, 500])
@pytest.mark.parametrize("length", [1e-3, 1.0, 1e3])
def test_loops_are_shut_to_the_rounding_of_their_sums(n: int, length: float) -> None:
    """What rounding takes from a ring's closure, against the same sum in a 64-bit mantissa, counts as shut: no more is
    asked of a ring of many rods, or of long ones, than numbers can tell."""
    rng = np.random.default_rng(n)
    for _ in range(100):
        rods = length * rng.uniform(0.8, 1.2, n)
        q = 2.0 * np.pi * np.arange(n) / n + rng.uniform(-0.3, 0.3, n)
        wide = np.cumsum(rods.astype(np.longdouble) * np.cos(q.astype(np.longdouble)))[-1]
        lost = abs(float(np.cumsum(rods * np.cos(q))[-1] - wide))
        allowed = rounding_of(np.array([-rods * np.sin(q), rods * np.cos(q)]), q)
        assert lost <= allowed <= 1e-14 * rods.sum() + 64.0 * np.finfo(float).eps
