"""Gears, racks and belts: Willis' formula, equivalent inertias and impacts in closed form, and wrong tables."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from ccgen.generator import SceneError
from ccgen.generator.mechanism.redundancy import mobility
from ccgen.runtime import inverse_dynamics, simulate, static_equilibrium
from ccgen.runtime.model.meshes import mesh_names, mesh_torques

from ..support.gear_scenes import CART, GROUND_PAIR, PLANETARY, TEETH, disc, joint, planets
from ..support.workshop import Workshop

SUN, RING, PLANET = TEETH
FIXED = {  # which member stands still, which one is turned, and how fast the third turns for it: Willis' formula
    "ring": ("sun", "arm", SUN / (SUN + RING)),
    "arm": ("sun", "ring", -SUN / RING),
    "sun": ("ring", "arm", RING / (SUN + RING)),
}
AXLES = {"sun": "sun_axle", "ring": "ring_axle", "arm": "arm_axle"}
MEMBERS = {"arm": 0, "sun": 1, "ring": 2}


@pytest.mark.sample(2)
@pytest.mark.parametrize("count", [1, 3])
@pytest.mark.parametrize("fixed", FIXED)
def test_a_planetary_train_turns_as_willis_says(fixed: str, count: int, workshop: Workshop) -> None:
    """All three members in turn held still; several equal planets are redundant and change nothing."""
    turned, third, ratio = FIXED[fixed]
    drives = f'[[drive]]\njoint = "{AXLES[fixed]}"\nspeed = 0\n[[drive]]\njoint = "{AXLES[turned]}"\nspeed = "2 + t"\n'
    model = workshop.model(PLANETARY + planets(count) + drives)
    assert model.dof == 0
    run = simulate(model, until=3.0)
    assert run.success, run.message
    angle = 2.0 * run.t + run.t**2 / 2.0
    found = {name: run.q[:, k] - run.q[0, k] for name, k in MEMBERS.items()}
    assert np.max(np.abs(found[fixed])) <= 1e-13
    assert np.max(np.abs(found[third] - ratio * angle)) <= 1e-12 * angle[-1]
    spin = (found["sun"] - found["arm"]) * -SUN / PLANET
    for k in range(count):
        assert np.max(np.abs(run.q[:, 3 + k] - run.q[0, 3 + k] - found["arm"] - spin)) <= 1e-11 * angle[-1]
    assert run.closure_max <= 1e-13


@pytest.mark.parametrize("count", [1, 3])
def test_the_members_share_torques_as_their_teeth(count: int, workshop: Workshop) -> None:
    """A load on the arm is held by torques as z_sun : z_ring : -(z_sun + z_ring); planets share them."""
    load = 12.0
    table = f'[[torque]]\nlink = "arm"\ntorque = {load}\n'
    hold = "".join(f'[[drive]]\njoint = "{AXLES[name]}"\nspeed = 3\n' for name in ("sun", "arm"))
    model = workshop.model(PLANETARY + planets(count) + table + hold)
    q, u = model.start()
    assert np.max(np.abs(model.acceleration(q, u))) <= 1e-12  # all members turn alike and steadily
    moments = {name: model.reactions(q, u)[model.joints.index(axle), 2] for name, axle in AXLES.items()}
    assert moments["sun"] == pytest.approx(0.0, abs=1e-11)  # nothing holds the ring: its mesh carries nothing
    assert moments["arm"] == pytest.approx(-load, rel=1e-12)
    held = "".join(f'[[drive]]\njoint = "{AXLES[name]}"\nspeed = 3\n' for name in ("sun", "ring"))
    model = workshop.model(PLANETARY + planets(count) + table + held)
    q, u = model.start()
    moments = {name: model.reactions(q, u)[model.joints.index(axle), 2] for name, axle in AXLES.items()}
    assert moments["sun"] == pytest.approx(-load * SUN / (SUN + RING), rel=1e-11)
    assert moments["ring"] == pytest.approx(-load * RING / (SUN + RING), rel=1e-11)
    forces = dict(zip(model.rows, model.multipliers(q, u), strict=True))
    for k in range(count):  # the torque of each mesh on its first wheel
        torque = forces[f"sun_{k}.mesh"] * model.parameters[f"sun_{k}.radius_1"]
        assert torque == pytest.approx(load * SUN / (SUN + RING) / count, rel=1e-10)


@pytest.mark.parametrize(
    ("gear", "ratio"),
    [
        ("teeth = [20, 50]", -2.5),
        ("ratio = 2.5", -2.5),
        ("radii = [0.1, 0.25]", -2.5),
        ("teeth = [20, 50]\ninternal = true", 2.5),
    ],
)
def test_a_pair_has_the_equivalent_inertia_of_its_first_wheel(gear: str, ratio: float, workshop: Workshop) -> None:
    """J = J1 + J2 / ratio²; the torque of the mesh on the first wheel is what the second one needs through it."""
    torque, first, second = 0.3, 0.02, 0.08
    model = workshop.model(GROUND_PAIR + f'[[gear]]\nname = "pair"\njoints = ["a", "b"]\n{gear}\n' + _motor(torque))
    alpha = torque / (first + second / ratio**2)
    u_dot = model.acceleration(*model.start())
    assert u_dot == pytest.approx([alpha, alpha / ratio], rel=1e-13)
    run = simulate(model, until=2.0)
    assert run.q[-1] == pytest.approx([2.0 * alpha, 2.0 * alpha / ratio], rel=1e-12)
    assert run.energy_drift <= 1e-12 and run.closure_max <= 1e-13
    (force,) = model.multipliers(*model.start())
    assert force * model.parameters["pair.radius_1"] == pytest.approx(first * alpha - torque, rel=1e-12)


def _motor(torque: float) -> str:
    return f'[[motor]]\njoint = "a"\ntorque = {torque}\n'


@pytest.mark.parametrize(("crossed", "sign"), [(False, 1.0), (True, -1.0)])
def test_a_belt_turns_pulleys_alike_and_a_crossed_one_against_each_other(
    crossed: bool, sign: float, workshop: Workshop
) -> None:
    belt = f'[[belt]]\njoints = ["a", "b"]\nradii = [0.05, "8 cm"]\ncrossed = {str(crossed).lower()}\n'
    model = workshop.model(GROUND_PAIR + belt + _motor(0.3))
    run, ratio = simulate(model, until=2.0), sign * 0.08 / 0.05
    alpha = 0.3 / (0.02 + 0.08 / ratio**2)
    assert run.q[-1] == pytest.approx([2.0 * alpha, 2.0 * alpha / ratio], rel=1e-12)
    # other pulleys without compiling again
    other = model.with_parameters({"belt_0.radius_2": 0.1})
    assert other.acceleration(*other.start())[0] == pytest.approx(0.3 / (0.02 + 0.08 / 4.0), rel=1e-12)


@pytest.mark.parametrize(("reverse", "sign"), [(False, 1.0), (True, -1.0)])
def test_a_pinion_pulls_a_rack_uphill(reverse: bool, sign: float, workshop: Workshop) -> None:
    """A mass on an incline of 30°, and a pinion with a torque: (m + J / r²) s'' = T / r - m g sin 30°."""
    mass, inertia, r, torque = 2.0, 0.02, 0.1, 3.0
    text = (
        'name = "rack"\n[ground_link]\npoints = { O = [0, 0], Q = [0.0, 0.3] }\n'
        + disc("wheel", 1.0, inertia)
        + disc("bar", mass, 0.01)
        + joint("axle", "ground.O", "wheel.C")
        + '[[joint]]\nname = "guide"\ntype = "prismatic"\naxis = "30 deg"\nbetween = ["ground.Q", "bar.C"]\n'
        + "[start]\nangles = { bar = 0 }\nslides = { guide = 0.2 }\nangular_velocities = { wheel = 1.5 }\n"
        + f'[gravity]\ng = 9.81\n[[rack]]\npinion = "axle"\nslide = "guide"\nradius = {r}\n'
        + f'reverse = {str(reverse).lower()}\n[[torque]]\nlink = "wheel"\ntorque = {torque}\n'
    )
    model = workshop.model(text)
    assert model.dof == 1
    run = simulate(model, until=1.0)
    s = run.q[:, model.q_names.index("slide_1")]
    acceleration = (sign * torque / r - mass * 9.81 / 2.0) / (mass + inertia / r**2)
    wanted = 0.2 + sign * 1.5 * r * run.t + acceleration * run.t**2 / 2.0
    assert np.max(np.abs(s - wanted)) <= 1e-12
    assert run.energy_drift <= 1e-11 and run.closure_max <= 1e-14
    # the guide carries what is across it alone: the mesh holds the rest
    reaction = model.reactions(*model.start())[model.joints.index("guide"), :2]
    along = np.array([math.cos(math.pi / 6), math.sin(math.pi / 6)])
    assert reaction @ along == pytest.approx(0.0, abs=1e-11)
    assert reaction @ np.array([-along[1], along[0]]) == pytest.approx(mass * 9.81 * along[0], rel=1e-12)


def test_a_wheel_that_rolls_is_a_rack_under_a_cart(workshop: Workshop) -> None:
    """A wheel in a cart that rolls down an incline without slip: a = g sin(20°) (M + m) / (M + m + J / r²)."""
    model = workshop.model(CART)
    run = simulate(model, until=1.0)
    s, wheel = (run.q[:, model.q_names.index(name)] for name in ("slide_0", "theta_1"))
    acceleration = 9.81 * math.sin(math.radians(20.0)) * 3.0 / (3.0 + 0.01 / 0.1**2)
    assert np.max(np.abs(s - acceleration * run.t**2 / 2.0)) <= 1e-12
    assert np.max(np.abs(wheel - wheel[0] + s / 0.1)) <= 1e-12


def test_an_impulse_goes_through_a_mesh_in_the_ratio_of_inertias(workshop: Workshop) -> None:
    """The first wheel strikes a stop: with J = J1 + J2 / i², the stop's impulse is (1 + e) J w, of which the mesh
    passes on (1 + e) J2 w / i²."""
    ratio, first, second, e, w = -2.5, 0.02, 0.08, 0.5, 3.0
    stop = f'[[stop]]\njoint = "a"\nhighest = 1.2\nrestitution = {e}\n'
    begin = f"[start]\nangular_velocities = {{ one = {w} }}\n"
    gear = '[[gear]]\nname = "pair"\njoints = ["a", "b"]\nteeth = [20, 50]\n'
    model = workshop.model(GROUND_PAIR + gear + stop + begin)
    run = simulate(model, until=1.0)
    (impact,) = run.impacts
    assert impact.t == pytest.approx(1.2 / w, rel=1e-12)
    assert run.u[-1] == pytest.approx([-e * w, -e * w / ratio], rel=1e-12)
    assert abs(sum(impact.impulses)) == pytest.approx((1.0 + e) * (first + second / ratio**2) * w, rel=1e-11)
    q, _ = model.start()
    f = np.array([-(1.0 + e) * (first + second / ratio**2) * w, 0.0])
    du, passed, _ = model.kernels.impulse(q[None], f[None], np.zeros((1, 1)))
    assert du[0] == pytest.approx([-(1.0 + e) * w, -(1.0 + e) * w / ratio], rel=1e-12)
    radius = model.parameters["pair.radius_1"]
    assert passed[0, 0] * radius == pytest.approx((1.0 + e) * second / ratio**2 * w, rel=1e-12)


def test_the_second_wheel_strikes_the_stop(workshop: Workshop) -> None:
    stop = '[[stop]]\njoint = "b"\nlowest = -0.5\nrestitution = 0\n'
    begin = "[start]\nangular_velocities = { one = 3 }\n"
    gear = '[[gear]]\njoints = ["a", "b"]\nteeth = [20, 50]\n'
    run = simulate(workshop.model(GROUND_PAIR + gear + stop + begin), until=1.0)
    (impact,) = run.impacts
    assert impact.t == pytest.approx(0.5 * 2.5 / 3.0, rel=1e-12)
    assert np.max(np.abs(run.u[-1])) <= 1e-14  # both wheels stop


def test_a_four_bar_with_a_geared_pair_closes_the_loop(workshop: Workshop) -> None:
    """A five-bar whose cranks are geared 1 : -1 is symmetric: its tip stays on the line between the cranks."""
    text = 'name = "geared"\n[ground_link]\npoints = { O = [-0.15, 0], Q = [0.15, 0] }\n'
    for name, long in (("left", 0.1), ("first", 0.4), ("second", 0.4), ("right", 0.1)):
        text += f'[[link]]\nname = "{name}"\nrod = {{ mass = 1.0 }}\npoints = {{ A = [0, 0], B = [{long}, 0] }}\n'
    text += joint("o", "ground.O", "left.A") + joint("l", "left.B", "first.A") + joint("tip", "first.B", "second.B")
    text += joint("r", "right.B", "second.A") + joint("q", "ground.Q", "right.A")
    open_ = math.acos((0.15 + 0.1 * math.cos(1.0)) / 0.4)
    angles = {"left": math.pi - 1.0, "right": 1.0, "first": open_, "second": math.pi - open_}
    text += "[start]\nangles = { " + ", ".join(f"{name} = {angle!r}" for name, angle in angles.items()) + " }\n"
    text += "angular_velocities = { left = 4 }\n[gravity]\ng = 9.81\n"
    model = workshop.model(text + '[[gear]]\njoints = ["o", "q"]\nteeth = [30, 30]\n')
    assert model.dof == 1
    run = simulate(model, until=2.0)
    assert run.success, run.message
    tip = model.point("tip", run.q)
    assert np.max(np.abs(tip[:, 0] - tip[0, 0])) <= 1e-9
    assert abs(tip[0, 0]) <= 1e-12
    assert np.max(np.abs(run.q[:, 0] + run.q[:, 3] - math.pi)) <= 1e-11
    assert run.energy_drift <= 1e-7 and run.closure_max <= 1e-13


def _wrong(text: str, workshop: Workshop) -> str:
    with pytest.raises(SceneError) as caught:
        workshop.scene(text)
    return str(caught.value)


WRONG: list[tuple[Any, str]] = [
    ('[[gear]]\njoints = ["a", "b"]\n', "found none of teeth, ratio, radii, expected one of teeth, ratio and radii"),
    ('[[gear]]\njoints = ["a", "b"]\nratio = 2\nteeth = [1, 2]\n', "found teeth beside ratio, expected one of"),
    ('[[gear]]\njoints = ["a", "b"]\nratio = 0\n', "gear[0].ratio: found 0, expected how many times as fast"),
    ('[[gear]]\njoints = ["a", "b"]\nteeth = [20, 0]\n', "gear[0].teeth[1]: found 0"),
    ('[[gear]]\njoints = ["a", "c"]\nratio = 2\n', 'gear[0].joints[1]: found "c", expected a joint; the joints are'),
    ('[[gear]]\njoints = ["a", "a"]\nratio = 2\n', 'gear[0].joints: found "a" twice, expected two joints'),
    ('[[gear]]\njoints = ["a", "tail"]\nratio = 2\n', "found no carrier, expected one link on which both axes sit"),
    ('[[gear]]\njoints = ["a", "b"]\nratio = 2\ncarrier = "two"\n', "two does not carry the axes of a, b"),
    ('[[gear]]\njoints = ["a", "b"]\nratio = 2\ncarrier = "axle"\n', 'gear[0].carrier: found "axle", expected a link'),
    ('[[gear]]\njoints = ["a", "b"]\nradii = [0.1, 0.1]\n', "found radii of wheels whose axes are"),
    ('[[gear]]\njoints = ["a", "b"]\nratio = 1\ninternal = true\n', "found wheels of one size, one inside the other"),
    ('[[belt]]\njoints = ["a", "b"]\nradii = [0.1, -1]\n', "belt[0].radii[1]: found -1"),
    ('[[rack]]\npinion = "a"\nslide = "b"\nradius = 0.1\n', 'rack[0].slide: found "b", expected a joint; its links'),
    (
        '[[gear]]\njoints = ["a", "b"]\nratio = 2\n'
        '[[drive]]\njoint = "a"\nspeed = 1\n[[drive]]\njoint = "b"\nspeed = 1\n',
        "found a, b driven, whose motions gear_0 joins, expected drives of joints that move apart",
    ),
    (
        '[[gear]]\njoints = ["a", "b"]\nratio = 2\n[start]\nangular_velocities = { one = 1, two = 1 }\n',
        "start.angular_velocities: found angular velocities of one, two that",
    ),
]


@pytest.mark.parametrize(("table", "message"), WRONG)
def test_wrong_tables_are_sentences(table: str, message: str, workshop: Workshop) -> None:
    tail = disc("three", 1.0, 0.1) + joint("tail", "two.E", "three.C")
    found = _wrong(GROUND_PAIR + tail + table, workshop)
    assert message in found, found


def test_a_weld_is_no_joint_of_a_gear(workshop: Workshop) -> None:
    weld = disc("three", 1.0, 0.1) + '[[joint]]\nname = "w"\ntype = "weld"\nbetween = ["two.E", "three.C"]\n'
    found = _wrong(GROUND_PAIR + weld + '[[gear]]\njoints = ["a", "w"]\nratio = 2\n', workshop)
    assert "it is a weld, whose links do not move against each other" in found


def test_meshes_of_further_planets_are_told_as_redundant(workshop: Workshop) -> None:
    """Each planet beyond the first has two rows for its one turn: one row too many each."""
    alone, three = (workshop.scene(PLANETARY + planets(count)).mechanism for count in (1, 3))
    poses = [scene.start.poses for scene in (workshop.scene(PLANETARY + planets(count)) for count in (1, 3))]
    assert mobility(alone, poses[0]).groups == ()
    found = mobility(three, poses[1])
    assert found.freedom == 2
    (group,) = found.groups
    assert group.surplus == 2 and group.joints == tuple(range(6, 12))


def test_a_train_at_rest_carries_what_its_load_asks(workshop: Workshop) -> None:
    """A motor on the sun against a spring on the ring, the arm held: T_ring = T_sun z_ring / z_sun."""
    torsion = '[[torsion]]\njoint = "ring_axle"\nstiffness = 20\n'
    hold = '[[drive]]\njoint = "arm_axle"\nspeed = 0\n[[motor]]\njoint = "sun_axle"\ntorque = 0.5\n'
    model = workshop.model(PLANETARY + planets(1) + torsion + hold)
    found = static_equilibrium(model)
    assert found.stability == "stable"
    assert mesh_names(model) == ("sun_0", "ring_0")
    torques = mesh_torques(model, found.meshes)
    assert torques == pytest.approx([-0.5, -0.5 * RING / SUN], rel=1e-9)
    ring = found.q[model.q_names.index("theta_2")]
    assert abs(ring) == pytest.approx(0.5 * RING / SUN / 20.0, rel=1e-9)


def test_inverse_dynamics_count_the_wheels_behind_a_mesh(workshop: Workshop) -> None:
    """The torque on the first wheel for a motion is its equivalent inertia times its acceleration."""
    model = workshop.model(GROUND_PAIR + '[[gear]]\njoints = ["a", "b"]\nteeth = [20, 50]\n')
    q, u = model.start()
    torques = inverse_dynamics(model, q, u, np.array([3.0, -1.2]), ["a"])
    assert np.ravel(torques) == pytest.approx([3.0 * (0.02 + 0.08 / 2.5**2)], rel=1e-12)
