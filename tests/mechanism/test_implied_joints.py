"""Joints that others imply: recognised, left out of the equations, and given the forces of least norm.

Pins are compared with dense least squares in maximal coordinates; of joints that slide, the forces are held against
the balance of the links alone.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from ccgen.generator.documents.assembled import implied_lines
from ccgen.generator.mechanism.implied import SAME, implied
from ccgen.generator.scene import Scene, SceneError, read_tables
from ccgen.runtime import Model, simulate

from ..oracles.least_squares import least_squares
from ..oracles.maximal import GROUND
from ..oracles.mechanisms import Drawing, draw
from ..support.dense_comparison import close
from ..support.tiers import all_hard_but
from ..support.workshop import Workshop

Array = np.ndarray[Any, Any]
PLACES = np.array([[0.0, 0.0], [0.9, 0.3], [1.7, -0.2], [1.2, 1.1], [2.4, 0.5], [0.1, 1.4]])

# bodies by the places that they reach, then joints (place, a, b); the last ``idle`` joints follow from the others
PINS: dict[str, tuple[list[tuple[int, ...]], list[tuple[int, int, int]], int]] = {
    "a joint twice": ([(0, 1), (1, 2)], [(0, GROUND, 0), (1, 0, 1), (1, 0, 1)], 1),
    "a joint twice, the other way round": ([(0, 1), (1, 2)], [(0, GROUND, 0), (1, 0, 1), (1, 1, 0)], 1),
    "a joint four times": ([(0, 1), (1, 2)], [(0, GROUND, 0), (1, 0, 1), *[(1, 0, 1)] * 3], 3),
    "a joint on the ground twice": ([(0, 1), (1, 2)], [(0, GROUND, 0), (1, 0, 1), (0, GROUND, 0)], 1),
    "three links on a pin": (
        [(0, 1), (1, 2), (1, 3)],
        [(0, GROUND, 0), (1, 0, 1), (1, 1, 2), (1, 2, 0)],
        1,
    ),
    "four links on a pin, each with each": (
        [(0, 1), (1, 2), (1, 3), (1, 5)],
        [(0, GROUND, 0), (1, 0, 1), (1, 0, 2), (1, 0, 3), (1, 1, 2), (1, 3, 2), (1, 1, 3)],
        3,
    ),
    "two links and the ground on a pin": ([(0, 1), (0, 2)], [(0, GROUND, 0), (0, GROUND, 1), (0, 0, 1)], 1),
    "in a loop": (
        [(0, 1), (1, 3), (3, 4)],
        [(0, GROUND, 0), (1, 0, 1), (3, 1, 2), (4, 2, GROUND), (3, 2, 1), (4, GROUND, 2)],
        2,
    ),
    "that floats": ([(0, 1), (1, 2), (1, 3)], [(1, 0, 1), (1, 1, 2), (1, 2, 0)], 1),
}


def drawn(case: str, idle: bool = True) -> Drawing:
    bodies, joints, count = PINS[case]
    name = "pins_" + "".join(letter for letter in case if letter.isalpha())
    return draw(name, PLACES, bodies, joints if idle else joints[:-count], np.random.default_rng(11))


def forces_on_b(model: Model, q: Array, u: Array) -> Array:
    """Force of every pin on its link ``b``, (pins, 2)."""
    found = model.reactions(q, u)
    assert np.all(found[:, 2] == 0.0)
    return found[:, :2]


@pytest.mark.sample(1)
@pytest.mark.parametrize("case", all_hard_but("a joint twice", "three links on a pin", "in a loop", of=PINS))
def test_redundant_pins_share_their_forces_by_least_norm(case: str, workshop: Workshop) -> None:
    """Accelerations and the forces of all pins are those of a dense least-norm solution that knows no tree."""
    drawing = drawn(case)
    model = workshop.model(drawing.toml())
    assert len(model.joints) == len(drawing.system.pins), "every joint keeps its name"
    rng = np.random.default_rng(3)
    q, u = model.state_from_poses(drawing.poses, np.zeros_like(drawing.poses))
    q, u = model.project(q, rng.normal(size=u.size))
    accelerations, forces = least_squares(drawing, model.poses(q), model.velocities(q, u))
    found = model.acceleration(q, u)
    assert close(found[[model.u_names.index(f"w_{k}") for k in range(len(drawing.poses))]], accelerations, 1e-11)
    assert close(forces_on_b(model, q, u), forces, 1e-11)


@pytest.mark.sample(1)
@pytest.mark.parametrize("case", all_hard_but("a joint twice", "three links on a pin", "in a loop", of=PINS))
def test_redundant_pins_change_no_motion(case: str, workshop: Workshop) -> None:
    """A run is that of the mechanism without them, to rounding, and as cheap."""
    with_idle, without = (workshop.model(drawn(case, idle).toml()) for idle in (True, False))
    assert (with_idle.q_names, with_idle.rows) == (without.q_names, without.rows), "no row is theirs"
    runs = [simulate(model, until=1.0, rtol=1e-10) for model in (with_idle, without)]
    assert all(run.success for run in runs)
    assert np.abs(runs[0].q[-1] - runs[1].q[-1]).max() <= 1e-12
    assert len(runs[0].t) == len(runs[1].t)


# -- joints that slide ----------------------------------------------------------------------------------------------

BAR = {"A": [0.0, 0.0], "B": [1.0, 0.0], "C": [0.2, 0.6], "D": [0.5, 0.0]}


def body(name: str) -> dict[str, Any]:
    return {"name": name, "mass": 1.3, "inertia": 0.11, "com": [0.4, 0.1], "points": dict(BAR)}


def joint(kind: str, first: str, second: str, **keys: Any) -> dict[str, Any]:
    return {"type": kind, "between": [first, second], **keys}


SLOT, RAIL, PIN = "pin-in-slot", "prismatic", "revolute"
FOOT = joint(PIN, "ground.O", "a.A")
GUIDE = joint(RAIL, "ground.O", "a.A", axis="20 deg")
SLIDES: dict[str, tuple[list[dict[str, Any]], dict[str, Any]]] = {
    "a pin and a slot": ([FOOT, joint(PIN, "a.B", "b.A")], joint(SLOT, "a.B", "b.A", axis=[0.3, 1.0])),
    "a pin and a slot through it": ([FOOT, joint(PIN, "a.B", "b.A")], joint(SLOT, "a.A", "b.A", axis=[1.0, 0.0])),
    "a slot before its pin": ([joint(PIN, "a.B", "b.A"), FOOT], joint(SLOT, "b.D", "a.B", axis=[-1.0, 0.0])),
    "a slot twice": ([FOOT, joint(SLOT, "a.A", "b.A", axis=[1, 0])], joint(SLOT, "a.A", "b.A", axis=[1, 0])),
    "a slot twice, the other way round": (
        [FOOT, joint(SLOT, "a.A", "b.A", axis="30 deg")],
        joint(SLOT, "a.A", "b.A", axis="210 deg"),
    ),
    "a slot twice, from another point": (
        [FOOT, joint(SLOT, "a.A", "b.A", axis=[1, 0])],
        joint(SLOT, "a.D", "b.A", axis=[1, 0]),
    ),
    "a rail twice": ([GUIDE, joint(PIN, "a.B", "b.A")], GUIDE),
    "a rail and a slot": ([GUIDE, joint(PIN, "a.B", "b.A")], joint(SLOT, "ground.O", "a.A", axis="20 deg")),
    "two rails": (
        [joint(RAIL, "ground.O", "a.A", axis=[1, 0]), joint(PIN, "a.B", "b.A")],
        joint(RAIL, "ground.P", "a.C", axis=[-1, 0]),
    ),
    "two rails, one read from the block": (
        [joint(RAIL, "a.A", "ground.O", axis=[1, 0]), joint(PIN, "a.B", "b.A")],
        joint(RAIL, "ground.P", "a.C", axis=[1, 0]),
    ),
    "three blocks on rails": (
        [joint(RAIL, "ground.O", "a.A", axis=[1, 0]), joint(RAIL, "a.C", "b.A", axis=[1, 0])],
        joint(RAIL, "b.C", "ground.Q", axis=[1, 0]),
    ),
}


def sliding(case: str, idle: bool = True) -> Scene:
    joints, extra = SLIDES[case]
    tables = {
        "ground_link": {"points": {"O": [0.0, 0.0], "P": [0.3, 0.6], "Q": [0.1, 1.2]}},
        "link": [body("a"), body("b")],
        "joint": [{**one, "name": f"j{k}"} for k, one in enumerate([*joints, *([extra] if idle else [])])],
        "gravity": {},
    }
    return read_tables(tables, case, "slides_" + "".join(letter for letter in case if letter.isalpha()))


def balance(scene: Scene, model: Model, q: Array) -> Array:
    """What every number of the reactions does to the links, (3 links, 3 joints): force x, y, moment about the frame.

    Slots push across their line only, and joints that slide have a force across theirs and a moment; what they cannot
    bear is zero.
    """
    poses, mechanism = model.poses(q), scene.mechanism
    found = np.zeros((3 * len(poses), 3 * len(mechanism.joints)))

    def place(ref: Any) -> complex:
        local = complex(*mechanism.point(ref).values())
        return local if ref.link < 0 else complex(*poses[ref.link, :2]) + local * np.exp(1j * poses[ref.link, 2])

    for k, one in enumerate(mechanism.joints):
        at = place(one.second if one.kind == "pin-in-slot" or one.second.link > one.first.link else one.first)
        bears = np.eye(3) if one.kind == "prismatic" else np.diag([1.0, 1.0, 0.0])
        if one.slides:
            angle = (one.axis.value if one.axis else 0.0) + (poses[one.first.link, 2] if one.first.link >= 0 else 0.0)
            across = np.array([-np.sin(angle), np.cos(angle)])
            bears[:2, :2] = np.outer(across, across)
        for link, sign in ((one.second.link, 1.0), (one.first.link, -1.0)):
            if link >= 0:
                arm = at - complex(*poses[link, :2])
                acts = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-arm.imag, arm.real, 1.0]])
                found[3 * link : 3 * link + 3, 3 * k : 3 * k + 3] = sign * acts @ bears
    return found


@pytest.mark.sample(1)
@pytest.mark.parametrize("case", all_hard_but("a pin and a slot", "a slot twice", "two rails", of=SLIDES))
def test_redundant_joints_that_slide_share_their_forces(case: str, workshop: Workshop) -> None:
    """The links feel what they feel without the joint, and no other reactions do that with a smaller norm."""
    (scene, model), (bare_scene, bare) = ((s, workshop.model(s)) for s in (sliding(case), sliding(case, idle=False)))
    assert (model.q_names, model.rows) == (bare.q_names, bare.rows), "no row is its"
    assert [scene.mechanism.joints[found.joint].name for found in implied(scene.mechanism)] == [model.joints[-1]]
    runs = [simulate(one, until=0.4, rtol=1e-10) for one in (model, bare)]
    assert np.abs(runs[0].q[-1] - runs[1].q[-1]).max() <= 1e-12
    q, u = runs[0].at(0.3)
    felt, whole = balance(bare_scene, bare, q) @ bare.reactions(q, u).ravel(), balance(scene, model, q)
    shared = model.reactions(q, u).ravel()
    assert np.abs(felt).max() > 1.0
    assert close(whole @ shared, felt, 1e-12)
    assert close(shared, np.linalg.pinv(whole, rcond=1e-9) @ felt, 1e-11)


def test_forces_of_contacts_and_impulses_are_shared_too(workshop: Workshop) -> None:
    """Two bars that fall on a floor and lie on it: each of two equal joints bears half of what one bears."""
    runs = []
    for count in (1, 2):
        tables = {
            "ground_link": {"points": {"O": [0.0, 0.3]}},
            "link": [body("a"), body("b")],
            "joint": [
                {"name": f"j{k}", "between": ends}
                for k, ends in enumerate([["ground.O", "a.A"], *[["a.B", "b.A"]] * count])
            ],
            "gravity": {},
            "ground": [{"restitution": 0.0, "friction": 0.4, "contacts": ["a.B", "b.B"]}],
        }
        runs.append(simulate(workshop.model(read_tables(tables, "bars", f"bars_{count}")), until=2.0, rtol=1e-10))
    bare, twice_held = runs
    assert twice_held.impacts and twice_held.phases[-1].kind == "contact"
    for t in (0.05, 0.15, 1.9):
        one, two = (run.reactions(t) for run in (bare, twice_held))
        assert close(two[0], one[0], 1e-8) and close(two[1], 0.5 * one[1], 1e-8) and close(two[2], two[1], 1e-12)
    for one_impact, two_impact in zip(bare.impacts, twice_held.impacts, strict=True):
        assert close(two_impact.reactions[1], 0.5 * one_impact.reactions[1], 1e-7)
        assert close(two_impact.reactions[2], two_impact.reactions[1], 1e-12)


def test_effects_see_a_joint_that_others_imply(workshop: Workshop) -> None:
    """A motor and friction at the second of two rails act as at the first."""
    runs = []
    for at in ("j0", "j2"):
        joints, extra = SLIDES["two rails"]
        tables = {
            "ground_link": {"points": {"O": [0.0, 0.0], "P": [0.0, 0.6]}},
            "link": [body("a"), body("b")],
            "joint": [{**one, "name": f"j{k}"} for k, one in enumerate([*joints, {**extra, "axis": [1, 0]}])],
            "gravity": {},
            "motor": [{"joint": at, "position": "0.3*sin(2*t)", "stiffness": 40.0, "damping": 3.0}],
            "joint_friction": [{"joints": [at], "viscous": 0.7}],
        }
        tables["link"][0]["points"]["C"] = [0.0, 0.6]  # type: ignore[index]
        runs.append(simulate(workshop.model(read_tables(tables, at, f"rail_{at}")), until=1.0, rtol=1e-11))
    assert np.abs(runs[0].q[-1] - runs[1].q[-1]).max() <= 1e-11
    assert np.abs(runs[0].q[-1] - runs[0].q[0]).max() > 0.1


def test_a_driven_joint_is_never_left_out(workshop: Workshop) -> None:
    """Of two joints at one place the driven one moves; two that are driven contradict each other."""

    def scene(*driven: str) -> Scene:
        tables = {
            "ground_link": {"points": {"O": [0.0, 0.0]}},
            "link": [body("a"), body("b")],
            "joint": [
                {"name": f"j{k}", "between": ends}
                for k, ends in enumerate([["ground.O", "a.A"], ["a.B", "b.A"], ["a.B", "b.A"]])
            ],
            "gravity": {},
            "drive": [{"joint": name, "speed": 2.0} for name in driven],
        }
        return read_tables(tables, "driven", "driven_" + "_".join(driven))

    runs = [simulate(workshop.model(scene(name)), until=1.0, rtol=1e-11) for name in ("j1", "j2")]
    assert np.abs(runs[0].q[-1] - runs[1].q[-1]).max() <= 1e-12
    turned = runs[1].q[:, 1] - runs[1].q[:, 0]
    assert np.abs(turned - turned[0] - 2.0 * runs[1].t).max() <= 1e-9
    with pytest.raises(SceneError, match="whose motion other drives or sliding joints give already"):
        scene("j1", "j2")


def test_rows_that_nothing_moves_are_solved_for(workshop: Workshop) -> None:
    """A pin where a rail ends locks the block: its rows vanish, but not both follow from others. Nothing crashes."""
    joints = [joint(RAIL, "ground.O", "a.A", axis=[1, 0]), joint(PIN, "a.B", "b.A"), joint(PIN, "ground.O", "a.A")]
    tables = {
        "ground_link": {"points": {"O": [0.0, 0.0]}},
        "link": [body("a"), body("b")],
        "joint": [{**one, "name": f"j{k}"} for k, one in enumerate(joints)],
        "gravity": {},
    }
    model = workshop.model(read_tables(tables, "locked", "locked"))
    run = simulate(model, until=0.5, rtol=1e-10)
    free = [name for name in model.q_names if name != "theta_1"]
    assert run.success and np.abs(run.q[:, [model.q_names.index(name) for name in free]]).max() <= 1e-12
    pendulum = body("b") | {"name": "b"}
    alone = {
        "ground_link": {"points": {"O": [1.0, 0.0]}},
        "link": [pendulum],
        "joint": [{"between": ["ground.O", "b.A"]}],
        "gravity": {},
    }
    swung = simulate(workshop.model(read_tables(alone, "alone", "alone")), until=0.5, rtol=1e-10)
    assert abs(run.q[-1, model.q_names.index("theta_1")] - swung.q[-1, 0]) <= 1e-9


# -- near misses ----------------------------------------------------------------------------------------------------


def twice(offset: float) -> Scene:
    """A joint and another beside it, at a point that is ``offset`` (m) away on both links."""
    tables: dict[str, Any] = {
        "ground_link": {"points": {"O": [0.0, 0.0]}},
        "link": [body("a"), body("b")],
        "joint": [
            {"name": f"j{k}", "between": ends}
            for k, ends in enumerate([["ground.O", "a.A"], ["a.B", "b.A"], ["a.B2", "b.A2"]])
        ],
        "gravity": {},
    }
    tables["link"][0]["points"]["B2"] = [1.0 + offset, 0.0]
    tables["link"][1]["points"]["A2"] = [offset, 0.0]
    return read_tables(tables, "twice", "twice")


@pytest.mark.parametrize("offset", [0.0, 1e-16, 0.1 * SAME])
def test_points_that_differ_by_rounding_are_one(offset: float) -> None:
    assert [found.joint for found in implied(twice(offset).mechanism)] == [2]


@pytest.mark.parametrize("offset", [1e-12, 1e-9, 1e-7])
def test_joints_that_almost_coincide_are_told(offset: float) -> None:
    """They would hold the angle by a lever too short to count."""
    with pytest.raises(SceneError) as caught:
        twice(offset)
    (fault,) = caught.value.faults
    assert fault.key == "joint[2]"
    for words in ("all but holds what j1 holds already", f"{offset:.3g} m apart", "name the same points"):
        assert words in fault.message


def test_joints_a_lever_apart_hold_an_angle() -> None:
    assert implied(twice(1e-3).mechanism) == ()


def test_what_a_joint_rests_on_cannot_change(workshop: Workshop) -> None:
    """Moving one of two points that coincide would open the joint that the equations leave out."""
    model = workshop.model(twice(0.0))
    for name in ("a.points.B.x", "a.points.B2.x"):
        with pytest.raises(ValueError, match=f"{name}: found 1.5, expected 1.0, because only with that j2 holds"):
            model.with_parameters({name: 1.5})
    model.with_parameters({"a.points.B.x": 1.0, "a.mass": 2.0})


def test_points_may_move_along_the_line_they_lie_on(workshop: Workshop) -> None:
    """A slot along a link's x axis holds a pin of that link wherever on the axis it is."""
    rod = {"mass": 1.0, "inertia": 0.1, "com": [0.5, 0.0], "points": {"A": [0.0, 0.0], "B": [1.0, 0.0]}}
    joints = [
        {"name": "j0", "between": ["ground.O", "a.A"]},
        {"name": "j1", "between": ["a.B", "b.A"]},
        {"name": "k", "type": "pin-in-slot", "axis": [1.0, 0.0], "between": ["a.A", "b.A"]},
    ]
    tables = {"ground_link": {"points": {"O": [0.0, 0.0]}}, "link": [{"name": "a", **rod}, {"name": "b", **rod}]}
    scene = read_tables(tables | {"joint": joints, "gravity": {}}, "slot", "slot")
    assert [found.joint for found in implied(scene.mechanism)] == [2]
    model = workshop.model(scene).with_parameters({"a.points.B.x": 1.2})
    q, _ = model.start()
    assert model.point("b.A", q) == pytest.approx(model.point("a.A", q) + 1.2 * np.array([1.0, 0.0]), abs=1e-12)


def test_what_is_left_out_is_told() -> None:
    (line,) = implied_lines(twice(0.0))
    assert line == "j2 holds what j1 holds: it is left out of the equations, and the forces are shared"
