"""Prescribed joint motion: kinematics in closed form, the torque it takes, its work, and wrong tables."""

from __future__ import annotations

import sys
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import pytest

from ccgen.generator import SceneError, load_scene
from ccgen.runtime import simulate

from ..support.driven_crank import CRANK, L, R
from ..support.folders import SCENES
from ..support.jansen_foot import foot
from ..support.tiers import hard
from ..support.workshop import Workshop

SPEED = '[[drive]]\njoint = "axle"\nspeed = 5.0\n'
SWING = '[[drive]]\njoint = "axle"\nangle = "0.7 + 0.5*sin(2*t)"\n'
PUSH = '[[drive]]\njoint = "guide"\nposition = "1.2 + 0.1*sin(3*t)"\n'


def slider(angle: Any) -> Any:
    """Where the slider is when the crank is at ``angle``."""
    return R * np.cos(angle) + np.sqrt(L**2 - (R * np.sin(angle)) ** 2)


@pytest.mark.parametrize(("table", "law"), [(SPEED, None), (SWING, lambda t: 0.7 + 0.5 * np.sin(2.0 * t))])
def test_a_driven_crank_goes_as_it_is_told(table: str, law: Any, workshop: Workshop) -> None:
    model = workshop.model(CRANK + table)
    assert model.dof == 0
    run = simulate(model, until=4.0, rtol=1e-11)
    assert run.success, run.message
    crank, slide = (run.q[:, model.q_names.index(name)] for name in ("theta_0", "slide_3"))
    wanted = law(run.t) if law else crank[0] + 5.0 * run.t
    assert np.max(np.abs(crank - wanted)) <= 1e-9
    assert np.max(np.abs(slide - slider(wanted))) <= 1e-9
    assert run.energy_drift <= 1e-8 and run.closure_max <= 1e-13


EXCAVATOR = """
name = "excavator"
[ground_link]
points = { O = [0, 0], C = [0.5, -0.3] }
[[link]]
name = "boom"
rod = { mass = 800, between = ["O", "E"] }
points = { O = [0, 0], E = [4, 0], P = [1.8, 0.2], Q = [2.2, 0.4] }
[[link]]
name = "stick"
rod = { mass = 400, between = ["E", "T"] }
points = { E = [0, 0], T = [2.5, 0], K = [-0.5, 0.1] }
[[link]]
name = "barrel1"
rod = { mass = 40, between = ["A", "B"] }
points = { A = [0, 0], B = [1, 0] }
[[link]]
name = "rod1"
rod = { mass = 25, between = ["A", "B"] }
points = { A = [-1, 0], B = [0, 0] }
[[link]]
name = "barrel2"
rod = { mass = 40, between = ["A", "B"] }
points = { A = [0, 0], B = [1, 0] }
[[link]]
name = "rod2"
rod = { mass = 25, between = ["A", "B"] }
points = { A = [-1, 0], B = [0, 0] }
[[joint]]
between = ["ground.O", "boom.O"]
[[joint]]
between = ["boom.E", "stick.E"]
[[joint]]
between = ["ground.C", "barrel1.A"]
[[joint]]
name = "lift"
type = "prismatic"
between = ["barrel1.A", "rod1.B"]
axis = [1, 0]
[[joint]]
between = ["rod1.B", "boom.P"]
[[joint]]
between = ["boom.Q", "barrel2.A"]
[[joint]]
name = "curl"
type = "prismatic"
between = ["barrel2.A", "rod2.B"]
axis = [1, 0]
[[joint]]
between = ["rod2.B", "stick.K"]
[[drive]]
joint = "lift"
position = { rows = [[0, 1.7], [4, 2.1]], order = 5 }
[[drive]]
joint = "curl"
position = { rows = [[0, 1.5], [1, 1.5], [4, 1.8]], order = 5 }
[[force]]
point = "stick.T"
vector = [0, "-3 kN"]
[gravity]
[start]
angles = { boom = "25 deg", stick = "-35 deg" }
[run]
until = 5.0
"""
"""Both cylinders are driven: nothing is left to move, and the steps are as long as the motion is smooth."""


@pytest.mark.parametrize("method", ["gauss", "dop853", "radau"])
@pytest.mark.parametrize("rtol", [1e-6, 1e-8, 1e-9, 1e-11])
def test_drives_that_leave_no_motion_work_what_the_energy_gains(method: str, rtol: float, workshop: Workshop) -> None:
    """Positions alone give the energy that is gained, the work is found along the way, to some tolerances of it."""
    model = workshop.model(EXCAVATOR)
    assert model.dof == 0
    run = simulate(model, rtol=rtol, method=method)
    assert run.success, run.message
    energy = np.sum(model.energy(run.q, run.u), axis=0)
    assert energy[-1] - energy[0] > 1e4
    assert run.energy_drift <= 10.0 * rtol * (energy[-1] - energy[0])


def test_the_reaction_moment_is_the_torque_that_gives_the_energy(workshop: Workshop) -> None:
    """Moment times speed is the rate of the energy, by central differences along the run."""
    model = workshop.model(CRANK + SPEED)
    run = simulate(model, until=1.0, rtol=1e-12)
    h = 1e-4
    for t in (0.2, 0.5, 0.8):
        energies = [sum(model.energy(*run.at(t + k * h))) for k in (-2, -1, 1, 2)]
        rate = (energies[0] - 8.0 * energies[1] + 8.0 * energies[2] - energies[3]) / (12.0 * h)
        moment = model.reactions(*run.at(t), t)[model.joints.index("axle"), 2]
        assert 5.0 * moment == pytest.approx(rate, rel=1e-8)


def test_reactions_of_states_at_their_times(workshop: Workshop) -> None:
    """What a drive asks for depends on time: a batch takes a time for each state, and one time for all."""
    model = workshop.model(CRANK + SWING)
    run = simulate(model, until=1.0)
    times = np.linspace(0.0, 1.0, 7)
    q, u = run.at(times)
    for method in (model.reactions, model.acceleration, model.multipliers):
        found = method(q, u, times)
        # accelerations of several at a time are rounded otherwise than those of one alone
        same = 0.0 if method == model.reactions else 1e-14
        single = np.array([method(q[k], u[k], time) for k, time in enumerate(times)])
        assert np.max(np.abs(found - single), initial=0.0) <= same * np.max(np.abs(single), initial=1.0)
        assert np.array_equal(method(q, u, np.full(7, 0.3)), method(q, u, 0.3))
        assert np.array_equal(method(q[:1], u[:1], times[:1]), single[:1])
        assert not np.allclose(found[3], method(q, u)[3])
        with pytest.raises(ValueError, match=r"t: found .*, expected a finite number, or one for each of 7 states"):
            method(q, u, times[:3])


def test_a_batch_at_its_times_is_one_call(workshop: Workshop) -> None:
    """A time for each state takes as many calls of functions as one time for all, however many the states are."""
    model = workshop.model(CRANK + SWING)
    q, u = (np.tile(x, (1001, 1)) for x in model.start())
    for method in (model.reactions, model.acceleration, model.multipliers):
        assert _calls(partial(method, q, u, np.linspace(0.0, 1.0, 1001))) <= _calls(partial(method, q, u, 0.5)) + 10


def _calls(function: Callable[[], Any]) -> int:
    """Calls of functions, of Python and of extensions, that a call of ``function`` makes."""
    count = 0

    def note(frame: Any, event: str, arg: Any) -> None:
        nonlocal count
        count += event in ("call", "c_call")

    sys.setprofile(note)
    try:
        function()
    finally:
        sys.setprofile(None)
    return count


@pytest.mark.sample(1)
@pytest.mark.parametrize(
    ("method", "rtol"), [("dop853", 5e-12), ("radau", 5e-12), ("dop853", 1e-10), ("dop853", 2e-12)]
)
def test_states_between_rows_beside_singular_configurations(method: str, rtol: float, workshop: Workshop) -> None:
    """A driven parallelogram lies in a line twice a turn; its angles are known at every time."""
    text = (SCENES / "parallelogram.toml").read_text()
    model = workshop.model(text + '[[drive]]\njoint = "motor"\nspeed = 10.0\n')
    # where a step happens to end beside the line, the drift is up to 2e-7 J: not at these tolerances
    run = simulate(model, method=method, rtol=rtol)
    assert run.success and run.energy_drift <= 1e-7, run.message  # the drive's work is as exact as the motion
    times = np.linspace(0.0, run.t[-1], 2001)
    crank, rocker, coupler = (run.at(times)[0][:, model.q_names.index(f"theta_{k}")] for k in (0, 2, 1))
    turned = np.radians(60.0) + 10.0 * times
    assert np.max(np.abs(crank - turned)) <= 1e-8
    assert np.max(np.abs(rocker - turned)) <= 1e-6 and np.max(np.abs(coupler)) <= 1e-6


def test_a_driven_slider_moves_the_crank(workshop: Workshop) -> None:
    model = workshop.model(CRANK + PUSH)
    run = simulate(model, until=3.0, rtol=1e-11)
    crank, slide = (run.q[:, model.q_names.index(name)] for name in ("theta_0", "slide_3"))
    assert np.max(np.abs(slide - 1.2 - 0.1 * np.sin(3.0 * run.t))) <= 1e-9
    assert np.max(np.abs(slider(crank) - slide)) <= 1e-9
    assert run.energy_drift <= 1e-8


def test_links_that_drive_each_other_keep_their_momentum(workshop: Workshop) -> None:
    """Two free links whose angle is given: no outer force acts, so the angular momentum stays that of the start."""
    rod = "mass = {m}\ninertia = {i}\ncom = [0.5, 0.0]\npoints = {{ A = [0, 0], B = [1, 0] }}\n"
    text = 'name = "pair"\n' + "".join("[[link]]\n" + rod.format(m=m, i=i) for m, i in ((1.0, 0.1), (2.0, 0.3)))
    text += '[[joint]]\nname = "waist"\nbetween = ["link_0.B", "link_1.A"]\n'
    model = workshop.model(text + '[[drive]]\njoint = "waist"\nangle = "sin(3*t)"\n')
    assert model.dof == 3
    run = simulate(model, until=5.0, rtol=1e-11)
    relative = run.q[:, model.q_names.index("theta_1")] - run.q[:, model.q_names.index("theta_0")]
    assert np.max(np.abs(relative - np.sin(3.0 * run.t))) <= 1e-9
    v, poses = model.velocities(run.q, run.u), model.poses(run.q)
    arms = 0.5 * np.stack([np.cos(poses[..., 2]), np.sin(poses[..., 2])], axis=-1)
    speeds = v[..., :2] + v[..., 2, None] * np.stack([-arms[..., 1], arms[..., 0]], axis=-1)
    mass = np.array([1.0, 2.0])[:, None]
    momentum = (mass * speeds).sum(axis=1)
    assert np.max(np.abs(momentum - momentum[0])) <= 1e-9


def test_the_speed_is_a_parameter(workshop: Workshop) -> None:
    model = workshop.model(CRANK + SPEED).with_parameters({"drive_0.speed": -2.0})
    q, u = model.start()
    assert u[model.u_names.index("w_0")] == pytest.approx(-2.0, abs=1e-12)
    assert np.max(np.abs(model.jacobian(q) @ u)) <= 1e-12


def test_a_start_that_moves_otherwise_is_refused(workshop: Workshop) -> None:
    model = workshop.model(CRANK + SPEED)
    q, u = model.start()
    with pytest.raises(ValueError, match="the driven joint axle misses the speed"):
        simulate(model, q0=q, u0=0.0 * u, until=0.1)


@pytest.mark.parametrize("part", [1e-6, -1e-6, 2e-8])
def test_a_speed_that_is_not_quite_that_of_its_drive_is_refused(part: float, workshop: Workshop) -> None:
    """It would turn as much faster all the way: here by 1e-6 of a turn per turn."""
    model = workshop.model(CRANK + SPEED)
    q, u = model.start()
    with pytest.raises(
        ValueError, match=rf"axle misses the speed .* by {5 * abs(part):.3g} rad/s, expected .* at most"
    ):
        simulate(model, q0=q, u0=(1.0 + part) * u, until=0.1)


def test_what_states_are_not_known_to_is_put_right(workshop: Workshop) -> None:
    """A speed that misses by less than states of runs do, and loops that the start leaves open by a micrometre: the
    crank turns as its drive has it, to rounding, from where it is."""
    model = workshop.model(CRANK + SPEED)
    q, u = model.start()
    for q0, u0 in ((q, (1.0 + 1e-9) * u), (q + np.array([0.0, 1e-7, -1e-7]), u)):
        run = simulate(model, q0=q0, u0=u0, until=10.0)
        crank = run.q[:, model.q_names.index("theta_0")]
        assert np.max(np.abs(crank - crank[0] - 5.0 * run.t)) <= 1e-11
    swung = workshop.model(CRANK + SWING)
    q, u = swung.start()
    run = simulate(swung, q0=q + np.array([0.0, 1e-7, -1e-7]), u0=u, until=2.0)
    crank = run.q[:, model.q_names.index("theta_0")]
    assert crank[0] == pytest.approx(0.7, abs=1e-14) and crank[-1] == pytest.approx(0.7 + 0.5 * np.sin(4.0), abs=1e-8)


def test_a_driven_crank_passes_its_change_point(workshop: Workshop) -> None:
    """Crank and rod of equal length: at 90° the slider stands over the axle and the rows lose rank."""
    text = CRANK.replace(f"[{L}, 0]", f"[{R}, 0]").replace("rod = -0.24", "rod = -0.7")
    model = workshop.model(text + SPEED)
    run = simulate(model, until=2.0, rtol=1e-10)
    assert run.success, run.message
    crank, slide = (run.q[:, model.q_names.index(name)] for name in ("theta_0", "slide_3"))
    assert np.max(np.abs(slide - 2.0 * R * np.cos(crank))) <= 1e-8
    assert np.max(np.abs(crank - crank[0] - 5.0 * run.t)) <= 1e-8


BAD = {
    "unknown joint": ('[[drive]]\njoint = "elbow"\nspeed = 1.0\n', "drive[0].joint", "the joints are axle"),
    "nothing given": ('[[drive]]\njoint = "axle"\n', "drive[0]", "found no speed or angle"),
    "two given": ('[[drive]]\njoint = "axle"\nspeed = 1.0\nangle = 0.7\n', "drive[0]", "found speed beside angle"),
    "position of a pin": ('[[drive]]\njoint = "axle"\nposition = 1.0\n', "drive[0].position", "expected angle"),
    "kink": ('[[drive]]\njoint = "axle"\nangle = "abs(t)"\n', "drive[0].angle", "expected one that is smooth"),
    "no rate at the start": ('[[drive]]\njoint = "axle"\nangle = "sqrt(t)"\n', "drive[0].angle", "no finite rate"),
    "no value at the start": ('[[drive]]\njoint = "axle"\nspeed = "1/t"\n', "drive[0].speed", "no finite value"),
    "speeds that do not fit": (
        SPEED + '[[drive]]\njoint = "wrist"\nspeed = 50.0\n',
        "drive[1]",
        "found 2 driven joints, expected no more than can be moved apart from each other",
    ),
    "positions that do not fit": (
        SWING + '[[drive]]\njoint = "wrist"\nangle = "30 deg"\n',
        "drive[1]",
        "found positions that miss by",
    ),
    "name of a joint": (
        SPEED.replace("speed", 'name = "guide"\nspeed')
        + '[[joint_friction]]\nname = "guide"\njoints = ["pin"]\ndry = 1.0\n',
        "drive[0].name",
        'found "guide" a second time',
    ),
    "driven twice": (SPEED + SPEED, "drive[1].joint", "which drive_0 drives already"),
    "against the start": (
        SPEED + '[[input]]\nname = "push"\njoint = "axle"\n',
        "start.angular_velocities",
        "that miss the drive of axle by",
    ),
    "a ring of drives": (
        "".join(f'[[drive]]\njoint = "{joint}"\nspeed = 1.0\n' for joint in ("axle", "pin", "wrist")),
        "drive[2].joint",
        "whose motion other drives or sliding joints give already",
    ),
    "out of reach": ('[[drive]]\njoint = "guide"\nposition = 9.0\n', "", "found positions that miss by"),
}


@pytest.mark.parametrize("case", BAD)
def test_wrong_table(case: str, workshop: Workshop) -> None:
    table, key, words = BAD[case]
    start = "angular_velocities = { crank = 1.0 }\n" if case == "against the start" else ""
    with pytest.raises(SceneError) as caught:
        workshop.scene(CRANK + start + table)
    faults = [fault for fault in caught.value.faults if words in fault.message]
    assert faults and (not key or faults[0].key == key), str(caught.value)
    assert faults[0].line is not None


def test_a_driven_jansen_leg_draws_its_foot_path(workshop: Workshop) -> None:
    """One turn a second: the foot's stride and lift, and where circles say that it is at each angle of the crank."""
    model = workshop.model(load_scene(SCENES / "jansen-driven.toml"))
    assert model.dof == 0
    run = simulate(model, rtol=1e-11)
    assert run.success, run.message
    times = np.linspace(0.0, 1.0, 2001)
    q, _ = run.at(times)
    path = model.point("shin.F", q)
    crank = q[:, model.links.index("crank")]
    assert np.max(np.abs(crank - crank[0] - 2.0 * np.pi * times)) <= 1e-9
    assert np.max(np.abs(path[:, 0] + 1j * path[:, 1] - foot(crank))) <= 1e-8
    assert np.ptp(path[:, 0]) == pytest.approx(67.908, abs=1e-3)
    assert np.ptp(path[:, 1]) == pytest.approx(22.457, abs=1e-3)


def test_a_given_angle_holds_when_lengths_change(workshop: Workshop) -> None:
    """The start of a changed model is closed and has the crank where the drive has it."""
    model = workshop.model(CRANK + SWING).with_parameters({"rod.points.B.x": 0.8, "crank.points.B.x": 0.3})
    q, u = model.start()
    assert q[model.q_names.index("theta_0")] == pytest.approx(0.7, abs=1e-12)
    assert u[model.u_names.index("w_0")] == pytest.approx(1.0, abs=1e-12)
    assert np.max(np.abs(model.closure(q))) <= 1e-13
    run = simulate(model, until=1.0)
    wanted = 0.7 + 0.5 * np.sin(2.0 * run.t)
    assert np.max(np.abs(run.q[:, model.q_names.index("theta_0")] - wanted)) <= 1e-8


def test_a_start_elsewhere_is_refused(workshop: Workshop) -> None:
    model = workshop.model(CRANK + SWING)
    q, u = workshop.model(CRANK + SPEED.replace("5.0", "1.0")).start()
    moved = model.assemble(q + np.array([0.2, 0.0, 0.0]))
    with pytest.raises(ValueError, match=r"the driven joint axle is .* rad from where it is to be"):
        simulate(model, q0=moved, u0=u, until=0.1)


def test_a_massless_arm_may_be_driven(workshop: Workshop) -> None:
    """Nothing resists its motion, and nothing has to: that is given."""
    arm = CRANK[: CRANK.index('[[link]]\nname = "rod"')].replace("mass = 1.0\ninertia = 0.1", "mass = 0\ninertia = 0")
    pin = '[[joint]]\nname = "axle"\nbetween = ["ground.O", "crank.A"]\n'
    with pytest.raises(SceneError, match="nothing else resists"):
        workshop.scene(arm + pin)
    model = workshop.model(arm + pin + SPEED)
    q, u = model.start()
    assert model.acceleration(q, u) == pytest.approx([0.0])
    assert np.all(model.reactions(q, u) == 0.0)


HIT = """\
name = "hit"
[chain]
links = 2
hinged = true
[gravity]
g = 9.81
[start]
angles = ["30 deg", "{second} deg"]
[[drive]]
joint = "joint_0"
speed = -1.0
[[ground]]
point = [0, -0.2]
restitution = {restitution}
contacts = ["{contact}"]
{more}
"""
"""A driven rod that turns down onto a floor 0.2 m below its hinge; a second one hangs on it."""


@pytest.mark.parametrize(("restitution", "more"), [(0.5, ""), (0.0, ""), (0.5, "friction = 0.3")])
def test_a_drive_into_a_ground_is_named(restitution: float, more: str, workshop: Workshop) -> None:
    """The elbow's motion is given; the tip of the second rod, which is free, may strike the floor."""
    text = HIT.format(second=60, restitution=restitution, contact="joint_1", more=more)
    run = simulate(workshop.model(text), until=2.0)
    assert not run.success and run.t[-1] == pytest.approx(np.pi / 6 + np.arcsin(0.2), abs=1e-9)
    assert "joint_1 is driven into ground_0 by joint_0, whose prescribed motion no impact can change" in run.message
    assert "[[motor]]" in run.message
    free = simulate(workshop.model(HIT.format(second=60, restitution=0.5, contact="link_1.B", more=more)), until=0.7)
    assert free.success and free.impacts


CHALK = """
name = "chalk"
[ground_link]
points = {{ O = [0, 1.0] }}
[[link]]
name = "cart"
mass = 1.0
inertia = 0.01
com = [0, 0]
points = {{ C = [0, 0] }}
[[link]]
name = "rod"
mass = 1.0
inertia = 0.1
com = [0.6, 0]
points = {{ H = [0, 0], T = [1.2, 0] }}
[[joint]]
name = "rail"
type = "prismatic"
between = ["ground.O", "cart.C"]
axis = [1, 0]
[[joint]]
name = "hinge"
between = ["cart.C", "rod.H"]
[start]
angles = {{ rod = "-56.4426902380793 deg" }}
[gravity]
[[ground]]
restitution = 0.2
friction = {friction}
contacts = ["rod.T"]
[[{table}]]
joint = "rail"
{way}
[run]
until = 0.2
"""
"""A rod that a cart pushes over the floor, its tip ahead, as chalk over a board."""


def test_a_drive_against_which_friction_jams_is_named(workshop: Workshop) -> None:
    """With friction of 1.5 the tip can neither slide nor stick. Both ways out that the message names are ways out."""

    def pushed(friction: float, table: str = "drive", way: str = "speed = 0.5") -> Any:
        return simulate(workshop.model(CHALK.format(friction=friction, table=table, way=way)))

    jammed = pushed(1.5)
    assert not jammed.success and "friction jams: the forces at rod.T on ground_0 have no solution" in jammed.message
    assert "take less friction or another start, or move rail by a [[motor]], which can give way" in jammed.message
    assert pushed(0.3).success
    assert pushed(1.5, "motor", "force = 60.0").success


ROCKING = """
name = "rocking"
[ground_link]
points = {{ O = [0, 0], Q = [2, 0] }}
[[link]]
name = "crank"
mass = 1
inertia = 0.08
com = [0.5, 0]
points = {{ A = [0, 0], B = [1, 0] }}
[[link]]
name = "coupler"
mass = 1.5
inertia = 0.28
com = [1, 0]
points = {{ A = [0, 0], B = [2, 0] }}
[[link]]
name = "rocker"
mass = 1
inertia = 0.08
com = [0.75, 0]
points = {{ A = [0, 0], B = [1.5, 0], T = [1.5, 0.3] }}
[[joint]]
name = "motor"
between = ["ground.O", "crank.A"]
[[joint]]
name = "knee"
between = ["crank.B", "coupler.A"]
[[joint]]
name = "elbow"
between = ["coupler.B", "rocker.B"]
[[joint]]
name = "pivot"
between = ["ground.Q", "rocker.A"]
[[drive]]
joint = "motor"
speed = 2
[[ground]]
restitution = 0.3
law = "{law}"
point = [0, 0.5]
contacts = ["rocker.T"]
{more}
[gravity]
[start]
angles = {{ crank = "60 deg" }}
"""
"""A driven four-bar whose rocker reaches a floor: its one freedom is prescribed, so no impulse moves anything."""


@pytest.mark.parametrize("law", ["newton", "poisson", "stronge"])
@pytest.mark.parametrize("more", ["", hard("friction = 0.1"), hard("friction = 0.4"), hard("friction = 1.5")])
def test_a_driven_linkage_into_a_ground_is_named(law: str, more: str, workshop: Workshop) -> None:
    """By every law, and no impact is recorded: nothing bounds impulses that move nothing."""
    run = simulate(workshop.model(ROCKING.format(law=law, more=more)), until=5.0)
    assert "rocker.T is driven into ground_0 by motor, whose prescribed motion no impact can change" in run.message
    assert not run.impacts and run.t[-1] == pytest.approx(1.268281868, abs=1e-6)


def test_a_drive_into_a_stop_is_named(workshop: Workshop) -> None:
    text = (
        HIT[: HIT.index("[[ground]]")].format(second=60)
        + '[[stop]]\njoint = "joint_0"\nlowest = "0 deg"\nrestitution = 0.5\n'
    )
    run = simulate(workshop.model(text), until=2.0)
    assert run.t[-1] == pytest.approx(np.pi / 6, abs=1e-9)
    assert "joint_0 is driven into stop_0.lowest by joint_0" in run.message


DRAGS = """
[chain]
links = 2
hinged = true
length = 1.0
mass = 1.0
inertia = 0.1
[gravity]
[[ground]]
point = [0, -0.5]
restitution = 0.0
{rough}
contacts = ["link_1.B"]
[start]
angles = ["0 deg", "-29 deg"]
[[drive]]
joint = "joint_0"
speed = 0.3
"""


@pytest.mark.parametrize("rough", ["", "friction = 0.4"])
def test_a_drive_does_work_while_a_contact_is_held(rough: str, workshop: Workshop) -> None:
    """A driven arm drags a rod whose end is on the ground: the work of drive and friction is what the energy gains."""
    run = simulate(workshop.model(DRAGS.format(rough=rough)), until=1.0)
    assert run.success, run.message
    held = [phase for phase in run.phases if phase.kind == "contact"]
    assert sum(phase.end - phase.start for phase in held) > 0.5
    gained = sum(run.model.energy(run.q[-1], run.u[-1])) - sum(run.model.energy(run.q[0], run.u[0]))
    assert gained > 1.0
    assert run.energy_drift <= 1e-7
