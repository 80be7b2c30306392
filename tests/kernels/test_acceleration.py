"""Accelerations, multipliers and joint forces of compiled models against dense and textbook references."""

from __future__ import annotations

from collections.abc import Callable
from itertools import islice
from typing import Any

import numpy as np
import pytest

from ..oracles import maximal, mechanisms, textbook
from ..oracles.maximal import Array, System
from ..oracles.mechanisms import Drawing
from ..support.dense_comparison import STATES, State, allowed, close, quasi_accelerations, states
from ..support.tiers import LARGE
from ..support.workshop import Workshop

MOST = (24, 96) if LARGE else (24,)
"""Links of those that are compiled for a minute together; one with a loop has 96 in every ``make hard``."""
CASES = [
    *(("floating", n) for n in (3, 4, 12, 24, 96)),
    *(("pinned", n) for n in (2, 3, 12, *MOST)),
    *(("open", n) for n in (2, 3, 12, *MOST)),
    *(("hinged", n) for n in (1, 2, 12, *MOST)),
    *(("two_loops", n) for n in (5, 12, *MOST)),
    *(("ladder", loops) for loops in (2, 3, 7)),
]


def still(model: Any) -> float:
    """Scale of a motion that must vanish because the mechanism cannot move: pinned chains of two links."""
    return 1.0 if model.dof == 0 else 0.0


Found = Callable[[int], list[State]]


QUICK = (("floating", 4), ("hinged", 2))
LARGEST = 10
"""Links, or loops of a ladder times five, of what is compiled in ``make test``."""


def _marks(family: str, n: int) -> tuple[pytest.MarkDecorator, ...]:
    if (family, n) in QUICK:
        return (pytest.mark.quick,)
    return (pytest.mark.hard,) if n * (5 if family == "ladder" else 1) > LARGEST else ()


MARKED = [pytest.param(case, marks=_marks(*case)) for case in CASES]


@pytest.fixture(scope="module", params=MARKED, ids=[f"{family}-{n}" for family, n in CASES])
def pair(request: pytest.FixtureRequest, workshop: Workshop) -> tuple[Any, Drawing]:
    family, n = request.param
    drawing = mechanisms.FAMILIES[family](n)
    return workshop.model(drawing.toml()), drawing


@pytest.fixture(scope="module")
def found(pair: tuple[Any, Drawing]) -> Found:
    """The first states of a model: each is found once, for all tests."""
    drawn, kept = states(*pair), list[State]()

    def first(count: int) -> list[State]:
        kept.extend(islice(drawn, count - len(kept)) if count > len(kept) else ())
        return kept[:count]

    return first


@pytest.mark.sample(3)
def test_states_are_consistent(pair: tuple[Any, Drawing], found: Found) -> None:
    """Assembled states close every joint and projected velocities keep them closed, by the reference's measure."""
    model, drawing = pair
    size = np.abs(drawing.poses[:, :2]).max() + 1
    for state in found(3):
        assert np.max(np.abs(model.closure(state.q)), initial=0.0) <= 1e-13
        assert maximal.opening(drawing.system, state.poses) <= 1e-14 * size * len(state.poses)
        centre = maximal.centre_velocities(drawing.system, state.poses, state.velocities).ravel()
        speeds = maximal.jacobian(drawing.system, state.poses[:, 2]) @ centre
        assert np.max(np.abs(speeds), initial=0.0) <= 1e-13 * size * np.max(np.abs(centre), initial=still(model))


def test_accelerations_are_those_of_the_dense_solve(pair: tuple[Any, Drawing], found: Found) -> None:
    model, drawing = pair
    for state in found(STATES):
        motion = maximal.accelerate(drawing.system, state.poses, state.velocities)
        wanted = quasi_accelerations(model, motion)
        assert close(model.acceleration(state.q, state.u), wanted, allowed(drawing.system), still(model))


def test_joint_forces_are_those_of_the_dense_solve(pair: tuple[Any, Drawing], found: Found) -> None:
    """Reactions on the second link of every joint, and the multipliers: forces on the second sides of the cuts."""
    model, drawing = pair
    for state in found(4):
        motion = maximal.accelerate(drawing.system, state.poses, state.velocities)
        reactions = model.reactions(state.q, state.u)
        assert reactions.shape == (len(drawing.system.pins), 3)
        assert not reactions[:, 2].any()
        weight = float(np.max(drawing.system.mass)) * drawing.system.gravity  # forces vanish in free fall
        assert close(reactions[:, :2], motion.forces, allowed(drawing.system), weight)
        cuts = [row for name in model.cuts for row in motion.forces[model.joints.index(name)]]
        scale = float(np.max(np.abs(motion.forces), initial=weight))
        multipliers = model.multipliers(state.q, state.u)
        assert multipliers.shape == (len(cuts),)
        assert np.max(np.abs(multipliers - np.array(cuts, float)), initial=0.0) <= allowed(drawing.system) * scale


def test_energy_is_that_of_the_bodies(pair: tuple[Any, Drawing], found: Found) -> None:
    model, drawing = pair
    for state in found(3):
        kinetic, potential = maximal.energy(drawing.system, state.poses, state.velocities)
        heights = np.abs(state.poses[:, 1]).max() + 1
        assert model.energy(state.q, state.u)[0] == pytest.approx(kinetic, rel=1e-13)
        bound = 1e-14 * drawing.system.gravity * drawing.system.mass.sum() * heights
        assert model.energy(state.q, state.u)[1] == pytest.approx(potential, abs=bound)


def test_projection_is_nearest_in_the_mass_matrix(pair: tuple[Any, Drawing], found: Found) -> None:
    """On a closed configuration only the velocity changes, and it is the reference's projection."""
    model, drawing = pair
    rng = np.random.default_rng(23)
    for state in found(2):
        wild = rng.normal(size=len(model.u_names))
        q, u = model.project(state.q, wild)
        assert np.max(np.abs(q - state.q)) <= 1e-13
        wanted = maximal.project(drawing.system, model.poses(q), model.velocities(q, wild))
        assert close(model.velocities(q, u), wanted, allowed(drawing.system), still(model))


def test_degrees_of_freedom(pair: tuple[Any, Drawing]) -> None:
    """3 per link, less 2 per joint: none of these mechanisms has redundant joints."""
    model, drawing = pair
    assert model.dof == 3 * drawing.system.size - 2 * len(drawing.system.pins)
    q, _ = model.state_from_poses(drawing.poses, 0 * drawing.poses)
    assert len(model.closure(q)) == len(model.u_names) - model.dof


def test_batches_are_the_single_states(pair: tuple[Any, Drawing], found: Found) -> None:
    model, _ = pair
    some = found(5)
    q, u = np.array([s.q for s in some]), np.array([s.u for s in some])
    for call in (model.acceleration, model.multipliers, model.reactions, model.velocities):
        single = np.array([call(s.q, s.u) for s in some])
        assert close(call(q, u), single, 1e-14, still(model))
    assert np.array_equal(model.poses(q), np.array([s.poses for s in some]))
    assert np.array_equal(model.closure(q), np.array([model.closure(s.q) for s in some]))


# --- sympy.physics.mechanics ------------------------------------------------------------------------------------------

SMALL = [
    *(("open", n) for n in (1, 2, 3)),
    *(("hinged", n) for n in (1, 2, 3)),
    *(("pinned", n) for n in (2, 3)),
    ("floating", 3),
]


@pytest.mark.sample(2)
@pytest.mark.parametrize(
    ("method", "family", "n"),
    [
        pytest.param(
            *(method, family, n),
            id=f"{method.__name__}-{family}-{n}",
            marks=pytest.mark.hard if n == 3 and (method, family) != (textbook.kane, "floating") else (),
        )
        for method in (textbook.kane, textbook.lagrange)
        for family, n in SMALL
        if (method, family, n) != (textbook.kane, "pinned", 2)  # SymPy's needs an independent speed
        if LARGE or (method, n) != (textbook.lagrange, 3) or family in ("pinned", "floating")  # others take as long
    ],
)
def test_accelerations_are_those_of_the_textbook(
    method: Callable[[System], textbook.Evaluate], family: str, n: int, workshop: Workshop
) -> None:
    drawing = mechanisms.FAMILIES[family](n)
    model = workshop.model(drawing.toml())
    system = mechanisms.in_a_row(drawing)
    free = not drawing.ground
    evaluate = method(system)
    for state in states(model, drawing, 5):
        q, u = (np.concatenate([x[0, :2], x[:, 2]] if free else [x[:, 2]]) for x in (state.poses, state.velocities))
        rates, force = evaluate(q, u)
        wanted = np.concatenate([_root_acceleration(model, drawing, state, rates), rates[2:]]) if free else rates
        assert close(model.acceleration(state.q, state.u), wanted, 1e-12, still(model))
        if force.size:
            weight = float(np.max(drawing.system.mass)) * drawing.system.gravity
            assert close(model.multipliers(state.q, state.u), _on_the_cut(model, drawing, state), 1e-12, weight)


def _root_acceleration(model: Any, drawing: Drawing, state: State, rates: Array) -> Array:
    """Acceleration of the root's frame from that of link 0 and the angular accelerations, along the links."""
    root = int(model.u_names[0].rsplit("_", 1)[1])
    place = rates[:2].copy()
    turn = rates[2:]
    for pin in mechanisms.in_a_row(drawing).pins[:root]:
        for sign, link, on in ((1, pin.a, pin.on_a), (-1, pin.b, pin.on_b)):
            x, y = maximal.turned(np.asarray(state.poses[link, 2]), on)
            spin = state.velocities[link, 2] ** 2
            place += sign * np.array([-turn[link] * y - spin * x, turn[link] * x - spin * y])
    return place


def _on_the_cut(model: Any, drawing: Drawing, state: State) -> Array:
    """The reference's force on the second side of the one cut joint."""
    (cut,) = model.cuts
    return maximal.accelerate(drawing.system, state.poses, state.velocities).forces[model.joints.index(cut)]
