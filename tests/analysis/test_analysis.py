"""Inverse dynamics, the torque of a crank, equilibrium and momenta against closed forms and the dense reference."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ccgen.generator import SceneError, load_scene
from ccgen.runtime import driving_torque, inverse_dynamics, momentum, simulate, static_equilibrium

from ..oracles import maximal, scenes
from ..support.command_line import ccgen
from ..support.folders import SCENES
from ..support.tiers import hard
from ..support.workshop import Workshop

HINGED = 'name = "hinged"\n[chain]\nlinks = 1\nhinged = true\nlength = 2.0\nmass = 3.0\n[gravity]\ng = 9.81\n'


def shown(name: str, workshop: Workshop) -> Any:
    return workshop.model(load_scene(SCENES / f"{name}.toml"))


# -- inverse dynamics --------------------------------------------------------------------------------------------------


@pytest.mark.quick
def test_torque_of_a_rod(workshop: Workshop) -> None:
    model = workshop.model(HINGED)
    found = inverse_dynamics(model, [0.3], [2.0], [5.0], ["joint_0"])
    assert found == pytest.approx([3.0 * 4.0 / 3.0 * 5.0 + 3.0 * 9.81 * np.cos(0.3)], rel=1e-13)
    batch = inverse_dynamics(model, [[0.3], [0.4]], [[2.0], [0.0]], [[5.0], [0.0]], ["joint_0"])
    assert batch.shape == (2, 1)
    assert batch[0] == pytest.approx(found, rel=1e-14)


@pytest.mark.hard
def test_no_torque_where_the_motion_is_free(workshop: Workshop) -> None:
    for name, joint in (("four-bar", "motor"), ("jansen-leg", "axle")):
        model = shown(name, workshop)
        q, u = model.start()
        free = inverse_dynamics(model, q, u, model.acceleration(q, u), [joint])
        assert np.abs(free[0]) <= 1e-9 * driving_torque(model, joint, 1.0, 4).torque.max()


def test_surplus_joints_share_the_work_with_the_least_sum_of_squares(workshop: Workshop) -> None:
    model = shown("four-bar", workshop)
    q, u = model.start()
    still = model.acceleration(q, 0 * u)
    bias = model.kernels.of_state("closure_bias", q[None], u[None])[0]
    u_dot = still + np.linalg.lstsq(model.jacobian(q), -bias - model.jacobian(q) @ still, rcond=None)[0]
    alone = inverse_dynamics(model, q, u, u_dot, ["motor"])[0]
    joints = ["motor", "pivot"]
    shared = inverse_dynamics(model, q, u, u_dot, joints)
    crank, rocker = u[0], u[2]
    assert shared[0] * crank + shared[1] * rocker == pytest.approx(alone * crank, rel=1e-9)
    assert np.sum(shared**2) <= alone**2
    assert shared[0] * rocker == pytest.approx(shared[1] * crank, rel=1e-9)


def test_torques_that_cannot_give_the_motion_are_refused(workshop: Workshop) -> None:
    model = shown("flyer", workshop)
    q, u = model.start()
    with pytest.raises(
        ValueError, match=r"torques at left_elbow cannot give this motion.*name more joints \(9 degrees"
    ):
        inverse_dynamics(model, q, u, np.ones(len(u)), ["left_elbow"])
    model = shown("four-bar", workshop)
    q, u = model.start()
    with pytest.raises(ValueError, match=r"u_dot: state 0 opens a loop at .* m/s²"):
        inverse_dynamics(model, q, u, np.ones(3), ["motor"])
    with pytest.raises(ValueError, match=r"found 'nothing', expected some of: motor"):
        inverse_dynamics(model, q, u, np.zeros(3), ["nothing"])
    for wrong in ("motor", [], ["motor", "motor"]):
        with pytest.raises(ValueError, match="expected a list of joints"):
            inverse_dynamics(model, q, u, np.zeros(3), wrong)


STOPPED = HINGED + '[[stop]]\njoint = "joint_0"\nlowest = "-20 deg"\nrestitution = 0\n'
CLEARED = HINGED + '[[ground]]\nrestitution = 0\npoint = [0, {level}]\ncontacts = ["link_0.B"]\n'


def test_states_and_motions_into_surfaces_have_no_torques(workshop: Workshop) -> None:
    model, lowest = workshop.model(STOPPED), -np.radians(20.0)
    gravity = 3.0 * 9.81 * np.cos(lowest)
    with pytest.raises(ValueError, match=r"q: state 1 has joint_0 beyond stop_0\.lowest by 0\.150934 rad"):
        inverse_dynamics(model, [[0.3], [-0.5]], [[0.0], [0.0]], [[0.0], [0.0]], ["joint_0"])
    with pytest.raises(ValueError, match=r"u: state 0 drives joint_0 into stop_0\.lowest at 2 rad/s, expected"):
        inverse_dynamics(model, [lowest], [-2.0], [0.0], ["joint_0"])
    with pytest.raises(ValueError, match=r"u_dot: state 0 drives joint_0 into stop_0\.lowest at 2 rad/s², expected"):
        inverse_dynamics(model, [lowest], [0.0], [-2.0], ["joint_0"])
    with pytest.warns(UserWarning, match=r"joint_0 on stop_0\.lowest\), whose forces the motion does not give"):
        assert inverse_dynamics(model, [lowest], [0.0], [0.0], ["joint_0"]) == pytest.approx([gravity], rel=1e-13)
    for push in (0.0, gravity):
        found = inverse_dynamics(model, [lowest], [0.0], [0.0], ["joint_0"], contact_forces=[[push, 0.0]])
        assert found == pytest.approx([gravity - push], abs=1e-12)
    for state, forces, wrong in (
        ([0.3], [[1.0, 0.0]], "its gap is open"),
        ([lowest], [[-1.0, 0.0]], "it can only push"),
        ([lowest], [[1.0, 0.1]], "its friction is at most 0 N"),
    ):
        with pytest.raises(ValueError, match=f"contact_forces: state 0 has .* at joint_0 on stop_0.lowest; {wrong}"):
            inverse_dynamics(model, state, [0.0], [0.0], ["joint_0"], contact_forces=forces)
    with pytest.raises(ValueError, match=r"contact_forces: found shape \(2,\), expected finite numbers \(1, 2\)"):
        inverse_dynamics(model, [lowest], [0.0], [0.0], ["joint_0"], contact_forces=[0.0, 0.0])


# -- the torque of a crank ---------------------------------------------------------------------------------------------


@pytest.mark.quick
def test_torque_of_a_turning_rod(workshop: Workshop) -> None:
    turn = driving_torque(workshop.model(HINGED), "joint_0", -2.0, 90)
    assert turn.angle[1] - turn.angle[0] == pytest.approx(-np.radians(4.0))
    assert np.allclose(turn.torque, 3.0 * 9.81 * np.cos(turn.angle), rtol=0, atol=1e-11)
    assert abs(turn.peak) == pytest.approx(29.43)


@pytest.mark.parametrize(("name", "joint"), [("four-bar", "motor"), ("jansen-leg", "axle")])
def test_torque_over_a_turn_balances_the_energy(name: str, joint: str, workshop: Workshop, tmp_path: Path) -> None:
    """Its work between any two angles is the change of energy; none is left after a turn. Inverse dynamics agrees."""
    model = shown(name, workshop)
    turn = driving_torque(model, joint, 3.0, 720)
    assert np.max(np.abs(model.closure(turn.q))) <= 1e-12 * model.length
    assert abs(turn.mean) <= 1e-9 * abs(turn.peak)
    energy = np.sum(model.energy(turn.q, turn.u), axis=0)
    slope = np.gradient(np.concatenate([energy[-3:], energy, energy[:3]]), 2.0 * np.pi / 720)[3:-3]
    assert np.max(np.abs(slope - turn.torque)) <= 2e-3 * abs(turn.peak)
    again = inverse_dynamics(model, turn.q, turn.u, turn.u_dot, [joint])[:, 0]
    assert np.max(np.abs(again - turn.torque)) <= 1e-11 * abs(turn.peak)
    turn.plot(tmp_path / "torque.png")
    assert (tmp_path / "torque.png").read_bytes().startswith(b"\x89PNG")
    with pytest.raises(ValueError, match=r"saved as \.png"):
        turn.plot(tmp_path / "torque.pdf")


def test_torque_at_change_points_is_the_limit(workshop: Workshop) -> None:
    """A parallelogram's crank from 60°: the samples at 180° and 360° are change points."""
    turn = driving_torque(shown("parallelogram", workshop), "motor", 3.0, 360)
    assert np.max(np.abs(turn.torque - 9.81 * 2.5 * np.cos(turn.angle))) <= 1e-6
    assert np.max(np.abs(turn.q[:, 1])) <= 1e-9


@pytest.mark.parametrize("samples", [5, 90, 720])
def test_change_points_move_no_sample(samples: int, workshop: Workshop) -> None:
    """However close the samples lie to a change point, each is at its own angle and has its own torque."""
    turn = driving_torque(shown("parallelogram", workshop), "motor", 3.0, samples)
    assert turn.angle - turn.angle[0] == pytest.approx(2.0 * np.pi * np.arange(samples) / samples, abs=1e-12)
    assert np.max(np.abs(turn.torque - 9.81 * 2.5 * np.cos(turn.angle))) <= 1e-6


def test_cranks_that_do_not_turn_are_refused(workshop: Workshop) -> None:
    with pytest.raises(ValueError, match=r"pivot cannot be turned right round: .*°: crank and coupler are in line"):
        driving_torque(shown("four-bar", workshop), "pivot", 1.0)
    with pytest.raises(ValueError, match=r"its angle does not determine the motion here.*found 9"):
        driving_torque(shown("flyer", workshop), "tail_root", 1.0)
    model = shown("four-bar", workshop)
    for rate in (np.nan, np.inf):
        with pytest.raises(ValueError, match="expected a finite number"):
            driving_torque(model, "motor", rate)
    with pytest.raises(ValueError, match="expected at least 2"):
        driving_torque(model, "motor", 1.0, 1)


def test_a_turn_ends_where_a_contact_would_push(workshop: Workshop) -> None:
    stopped = workshop.model(STOPPED)
    with pytest.raises(
        ValueError, match=r"comes to a stop after 20°, where joint_0 reaches stop_0\.lowest, which would"
    ):
        driving_torque(stopped, "joint_0", -1.0, 8)
    with pytest.raises(ValueError, match=r"q: found joint_0 beyond stop_0\.lowest by"):
        driving_torque(stopped, "joint_0", 1.0, 8, [-0.5])
    turn = driving_torque(stopped, "joint_0", 1.0, 8)  # upwards the angle only grows
    assert turn.torque == pytest.approx(3.0 * 9.81 * np.cos(turn.angle), abs=1e-11) and not turn.closed
    last = stopped.with_parameters({"stop_0.lowest": -np.radians(359.5)})
    with pytest.raises(ValueError, match=r"comes to a stop after 359\.5°"):
        driving_torque(last, "joint_0", -1.0, 8)


def test_a_turn_sees_points_that_graze_a_surface(workshop: Workshop) -> None:
    """The tip's lowest place is between two steps: a floor a millionth of a metre above it bars the way."""
    model = workshop.model(CLEARED.format(level=-2.0001))
    for level in (-2.0 - 1e-6, -2.0 + 1e-6):
        lower = model.with_parameters({"ground_0.point.y": level})
        if level < -2.0:
            assert driving_torque(lower, "joint_0", -1.0, 8).mean == pytest.approx(0.0, abs=1e-9)
            continue
        stop = np.degrees(np.arcsin(-level / 2.0))
        with pytest.raises(ValueError, match=f"after {stop:.4g}.*°, where link_0.B reaches the surface of ground_0"):
            driving_torque(lower, "joint_0", -1.0, 8)


def test_contacts_that_stay_closed_over_a_turn_do_no_work(workshop: Workshop) -> None:
    """A slider's foot on a floor along its guide changes no torque; if it is rough, nothing says how hard it rubs."""
    free = shown("slider-crank", workshop)
    text = (SCENES / "slider-crank.toml").read_text()
    floor = '[[ground]]\nrestitution = 0\nfriction = 0.2\npoint = [0, -0.03]\ncontacts = ["slider.low_front"]\n'
    model = workshop.model(text + floor)
    with pytest.raises(ValueError, match=r"motor: slider\.low_front slides on rough ground_0, and the motion does not"):
        driving_torque(model, "motor", 3.0, 8)
    smooth = driving_torque(model.with_parameters({"ground_0.friction": 0.0}), "motor", 3.0, 8)
    assert smooth.closed == (("slider.low_front", "ground_0"),)
    assert smooth.torque == pytest.approx(driving_torque(free, "motor", 3.0, 8).torque, abs=1e-9)


def test_a_contact_that_its_guide_holds_closed_has_any_force(workshop: Workshop) -> None:
    """Guide and floor share the slider's weight as they like: all of it is the guide's in the least norm."""
    text = (SCENES / "slider-crank.toml").read_text()
    model = workshop.model(
        text + '[[ground]]\nrestitution = 0\nfriction = 0.2\npoint = [0, -0.03]\ncontacts = ["slider.low_front"]\n'
    )
    found = static_equilibrium(model.with_parameters({"ground_0.friction": 0.0}))
    known = static_equilibrium(shown("slider-crank", workshop))
    assert found.q == pytest.approx(known.q, abs=1e-9) and found.stability == "stable"
    assert np.all(found.contact_forces == 0.0) and found.ranges[0, 0].tolist() == [0.0, np.inf]
    assert found.reactions == pytest.approx(known.reactions, abs=1e-8)


# -- equilibrium -------------------------------------------------------------------------------------------------------


@pytest.mark.quick
def test_a_rod_hangs_or_stands(workshop: Workshop) -> None:
    model = workshop.model(HINGED)
    hanging = static_equilibrium(model)
    assert hanging.stability == "stable"
    assert np.sin(hanging.q[0]) == pytest.approx(-1.0, abs=1e-14)
    assert hanging.stiffness == pytest.approx([29.43], rel=1e-8)
    assert hanging.reactions[0] == pytest.approx([0.0, 29.43, 0.0], abs=1e-8)
    standing = static_equilibrium(model, [1.4], nearest=True)
    assert standing.stability == "unstable"
    assert standing.q[0] == pytest.approx(np.pi / 2.0, abs=1e-10)
    assert static_equilibrium(model, [np.pi / 2.0]).stability == "stable"
    held = static_equilibrium(model, torques={"joint_0": 14.715})
    assert held.stability == "stable"
    assert np.cos(held.q[0]) == pytest.approx(0.5, abs=1e-9)
    with pytest.raises(ValueError, match="no equilibrium found from here"):
        static_equilibrium(model, torques={"joint_0": 40.0})


@pytest.mark.parametrize("name", ["four-bar", "jansen-leg", "parallelogram", "n-four-bar"])
def test_equilibria_do_not_accelerate(name: str, workshop: Workshop) -> None:
    model = shown(name, workshop)
    for nearest in (False, True):
        found = static_equilibrium(model, nearest=nearest)
        assert found.residual <= 1e-10
        assert np.max(np.abs(model.closure(found.q))) <= 1e-12 * model.length
        rest = np.zeros(len(found.q))
        assert np.max(np.abs(model.acceleration(found.q, rest))) <= 1e-8 * 9.81 / model.length
        assert np.allclose(
            model.reactions(found.q, rest), found.reactions, rtol=1e-7, atol=1e-7 * found.reactions.max()
        )
        if not nearest:
            assert found.stability == "stable"
            q, u = model.project(found.q + 1e-3, rest)
            run = simulate(model, q, u, until=2.0, rtol=1e-8)
            assert np.max(np.abs(run.q - found.q)) <= 0.05


def test_a_necklace_hangs_folded(workshop: Workshop) -> None:
    """Its lowest configuration is a flattened loop, where closure rows are dependent."""
    found = static_equilibrium(shown("closed-pendulum", workshop))
    assert found.stability == "stable"
    assert np.allclose(np.sin(found.q[:4]), -1.0, atol=1e-6) and np.allclose(np.sin(found.q[4:]), 1.0, atol=1e-6)


def test_a_falling_mechanism_has_no_equilibrium(workshop: Workshop) -> None:
    with pytest.raises(ValueError, match="a mechanism that falls freely has none"):
        static_equilibrium(shown("flyer", workshop))
    free = workshop.model('name = "free"\n[chain]\nlinks = 2\n')
    assert static_equilibrium(free).stability == "indifferent"


# -- momentum ----------------------------------------------------------------------------------------------------------


def test_momenta_are_those_of_the_bodies(workshop: Workshop) -> None:
    model = shown("flyer", workshop)
    system = scenes.read_system(SCENES / "flyer.toml")
    q, u = model.start()
    found = momentum(model, q, u)
    poses, velocities = model.poses(q), model.velocities(q, u)
    linear = maximal.momenta(system, poses, velocities)
    assert found[:2] == pytest.approx(linear[:2], rel=1e-13)
    centre = system.mass @ (poses[:, :2] + maximal.turned(poses[:, 2], system.com)) / system.mass.sum()
    x, y = np.asarray(centre, float) - poses[model.links.index(model.root), :2]
    assert found[2:].sum() == pytest.approx(linear[2] + x * linear[1] - y * linear[0], rel=1e-12)
    assert found @ u / 2.0 == pytest.approx(model.energy(q, u)[0], rel=1e-13)
    assert momentum(model, q[None], u[None]).shape == (1, len(u))


# -- command line ------------------------------------------------------------------------------------------------------


def test_commands_print_torque_and_equilibrium(tmp_path: Path) -> None:
    scene = str(SCENES / "four-bar.toml")
    done = ccgen("torque", scene, "motor", "--rate", "3", "--plot", "torque.png", at=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "mean" in done.stdout and "written: torque.png" in done.stdout
    assert (tmp_path / "torque.png").read_bytes().startswith(b"\x89PNG")
    done = ccgen("equilibrium", scene, at=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "four-bar: stable equilibrium; stiffnesses: " in done.stdout
    done = ccgen("torque", scene, "pivot", at=tmp_path)
    assert done.returncode == 2
    assert "ccgen: pivot cannot be turned right round" in done.stderr
    done = ccgen("equilibrium", str(SCENES / "flyer.toml"), at=tmp_path)
    assert done.returncode == 2
    assert "a mechanism that falls freely has none" in done.stderr


def test_a_crank_turns_as_its_drive_has_it(tmp_path: Path) -> None:
    """Unless another rate is asked for; without friction and over a whole turn the mean is zero, not its rounding."""
    command = ["torque", str(SCENES / "jansen-driven.toml"), "-q"]
    told, asked, slow = (
        ccgen(*command, *more, at=tmp_path).stdout.splitlines()
        for more in ((), ("--rate", repr(2.0 * np.pi)), ("--set", "drive_0.speed=0.5"))
    )
    assert told[0].startswith("jansen-driven: axle turned once at 6.28319 rad/s, as its [[drive]] has it: ")
    assert asked[0].startswith("jansen-driven: axle turned once at 6.28319 rad/s: ") and told[1:] == asked[1:]
    assert slow[0].startswith("jansen-driven: axle turned once at 0.5 rad/s, as its [[drive]] has it: ")
    assert told[1].split() == ["mean", "0", "N", "m"] and told[2] != slow[2]


ROD = """
[ground_link]
points = { O = [0, 0], P = [3, 0] }
[[link]]
name = "rod"
rod = { mass = 1 }
points = { O = [0, 0], T = [1, 0] }
[[joint]]
name = "hinge"
between = ["ground.O", "rod.O"]
[gravity]
"""
"""A rod of 1 m and 1 kg: at the angle a its weight asks for 4.905 cos a N m, at any constant rate."""
WHEEL = """
[[link]]
name = "wheel"
mass = 1
inertia = 1
com = [0, 0]
points = { O = [0, 0] }
[[joint]]
name = "axle"
between = ["ground.P", "wheel.O"]
"""


@pytest.mark.parametrize(
    ("law", "said"),
    [
        ('angle = "2*t"', "at 2 rad/s, as its [[drive]] has it at t = 0"),
        ('angle = "0.3 - 2*t + t**2"', "at -2 rad/s, as its [[drive]] has it at t = 0"),
        ('angle = "1 - cos(t)"', "at 1 rad/s"),
        ('speed = "3 + sin(t)"', "at 3 rad/s, as its [[drive]] has it at t = 0"),
        ("speed = { rows = [[0, 1.5], [1, 2], [2, 0]], order = 1 }", "at 1.5 rad/s, as its [[drive]] has it at t = 0"),
        hard("speed = 2.5", "at 2.5 rad/s, as its [[drive]] has it"),
        hard("angle = 0.5", "at 1 rad/s"),
        hard("speed = 0", "at 1 rad/s"),
    ],
)
@pytest.mark.parametrize("geared", [False, hard(True)])
def test_a_crank_turns_as_the_law_of_its_drive_begins(law: str, said: str, geared: bool, tmp_path: Path) -> None:
    """A drive by a plain number, an expression or rows, of its speed or its angle; beside a gear too."""
    more = WHEEL + '[[gear]]\njoints = ["hinge", "axle"]\nteeth = [20, 40]\n' if geared else ""
    (tmp_path / "rod.toml").write_text(f'name = "rod"{ROD}{more}[[drive]]\njoint = "hinge"\n{law}\n')
    done = ccgen("torque", "rod.toml", "hinge", at=tmp_path)
    assert done.returncode == 0, done.stderr
    told = done.stdout.splitlines()
    assert told[0] == f"rod: hinge turned once {said}: rod against ground"
    assert told[1].split() == ["mean", "0", "N", "m"]
    assert told[2].split()[1] == "4.905" and told[3].split()[1] == "-4.905"
    note = "note: its [[drive]] has hinge at rest at t = 0, so it is turned at 1 rad/s; --rate asks for another"
    assert (note in told) == (said == "at 1 rad/s")
    if not geared:
        rested = ccgen("torque", "rod.toml", "hinge", "--rate", "0", at=tmp_path).stdout.splitlines()
        assert rested[0] == "rod: hinge turned once and at rest at each angle: rod against ground"
        assert rested[2].split()[1] == "4.905" and note not in rested


def test_statics_over_a_turn_have_no_inertia(workshop: Workshop) -> None:
    """At rest the torque of a four-bar is the slope of its potential by the crank's angle, at a rate something else;
    friction that needs a speed is not there."""
    model = shown("four-bar", workshop)
    turn, moving = driving_torque(model, "motor", 0.0, 720), driving_torque(model, "motor", 5.0, 720)
    potential = np.array([float(model.energy(q, np.zeros(len(q)))[1]) for q in turn.q])
    waves = np.fft.rfftfreq(720, 1.0 / 720.0)
    slope = np.fft.irfft(1j * waves * np.fft.rfft(potential), 720)
    assert turn.torque == pytest.approx(slope, abs=1e-9 * np.abs(slope).max())
    assert not np.any(turn.u) and np.max(np.abs(moving.torque - turn.torque)) > 0.1
    damped = workshop.model(f'name = "rod"{ROD}[[joint_friction]]\njoints = ["hinge"]\nviscous = 2.0\n')
    assert driving_torque(damped, "hinge", 0.0).torque[0] == pytest.approx(4.905, rel=1e-12)
    assert driving_torque(damped, "hinge", 0.5).torque[0] == pytest.approx(5.905, rel=1e-12)


@pytest.mark.parametrize("way", [1.0, -1.0])
@pytest.mark.parametrize("angle", [0.0, 0.0021, 1.234567])
def test_extremes_over_a_turn_are_refined(way: float, angle: float, workshop: Workshop) -> None:
    """A rod with a constant load of 3 N upwards beside, and a spring: the closed form's own largest values."""
    more = '[[spring]]\nbetween = ["rod.T", "ground.P"]\nstiffness = 20\nlength = 1\n'
    model = workshop.model(f'name = "rod"{ROD}{more}')
    turn = driving_torque(model, "hinge", way, q=[angle])
    one, other = turn.largest, turn.smallest
    fine = np.linspace(0.0, 2.0 * np.pi, 2_000_001)
    length = np.sqrt(10.0 - 6.0 * np.cos(fine))
    exact = 4.905 * np.cos(fine) + 20.0 * (length - 1.0) * 3.0 * np.sin(fine) / length
    assert one[0] == pytest.approx(exact.max(), rel=1e-11) and other[0] == pytest.approx(exact.min(), rel=1e-11)
    for (_, at), wanted in ((one, fine[exact.argmax()]), (other, fine[exact.argmin()])):
        assert np.cos(at - wanted) == pytest.approx(1.0, abs=1e-11)
        assert 0.0 <= way * (at - angle) <= 2.0 * np.pi
    assert turn.peak == max(one[0], other[0], key=abs)
    assert np.max(turn.torque) < one[0]


def test_a_largest_torque_at_a_corner_is_found(tmp_path: Path, workshop: Workshop) -> None:
    """A rope-like spring that pulls beyond 1 rad of stretch: the torque jumps in slope between two samples; the mean
    has the digits that the corners leave."""
    more = (
        '[[spring]]\nbetween = ["rod.T", "ground.P"]\nstiffness = 500\nlength = 2.0003\nacts = "push"\n'
        '[[joint_friction]]\njoints = ["hinge"]\nviscous = 2.0\n'
    )
    model = workshop.model(f'name = "rod"{ROD}{more}')
    turn = driving_torque(model, "hinge", 1.0)
    fine = np.linspace(-0.05, 0.05, 2_000_001)
    length = np.sqrt(10.0 - 6.0 * np.cos(fine))
    pushes = np.where(length < 2.0003, 500.0 * (length - 2.0003) * 3.0 * np.sin(fine) / length, 0.0)
    exact = 4.905 * np.cos(fine) + pushes + 2.0
    assert turn.largest[0] == pytest.approx(exact.max(), abs=1e-9)
    (tmp_path / "rod.toml").write_text(f'name = "rod"{ROD}{more}')
    told = ccgen("torque", "rod.toml", "hinge", at=tmp_path).stdout.splitlines()
    assert told[1].split()[0] == "mean" and float(told[1].split()[1]) == pytest.approx(2.0, rel=1e-2)
    assert turn.mean_error <= 1e-2


@pytest.mark.hard
def test_loads_that_depend_on_time_are_told(tmp_path: Path) -> None:
    """A motor that follows an angle over time pulls as at the start, however far the crank has turned."""
    text = "[chain]\nlinks = 1\nhinged = true\n[[motor]]\njoint = 'joint_0'\nangle = {angle}\nstiffness = 5.0\n"
    for angle, told in (("'0.3 + 4*t'", True), ("0.3", False)):
        (tmp_path / "rod.toml").write_text(text.format(angle=angle))
        for command in (("torque", "rod.toml", "joint_0"), ("equilibrium", "rod.toml")):
            done = ccgen(*command, at=tmp_path)
            assert done.returncode == 0, done.stderr
            assert ("note: loads that depend on time are those at t = 0 throughout" in done.stdout) == told


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("count = 0", "four_bars.count: found 0, expected the number of four-bars, a whole number from 1 to 600"),
        ("count = 1.5", "four_bars.count: found 1.5, expected the number of four-bars"),
        ("", "four_bars.count: missing, expected the number of four-bars"),
        ("count = 2\nmass = -1", "four_bars.mass: found -1, expected the mass of every link in kg"),
        ("count = 2\nlinks = 3", "four_bars.links: found an unknown key, expected one of count, length, mass"),
        ("count = 2\nlength = 1e-200", "four_bars: found rods of inertia 0"),
    ],
)
def test_faults_of_four_bars_are_named(text: str, fault: str, workshop: Workshop) -> None:
    with pytest.raises(SceneError) as caught:
        workshop.scene(f'name = "row"\n[four_bars]\n{text}\n')
    assert fault in str(caught.value)


# -- driven joints -----------------------------------------------------------------------------------------------------

ARM = """
name = "arm"
[ground_link]
points = { O = [0, 0] }
[[link]]
name = "crank"
mass = 2.0
inertia = 0.1
com = [0.3, 0.0]
points = { A = [0, 0], B = [0.8, 0] }
[[link]]
name = "rod"
mass = 3.0
inertia = 0.2
com = [0.5, 0.0]
points = { A = [0, 0] }
[[joint]]
name = "axle"
between = ["ground.O", "crank.A"]
[[joint]]
name = "pin"
between = ["crank.B", "rod.A"]
[start]
angles = { crank = 0.4, rod = -1.2 }
[gravity]
g = 9.81
[[drive]]
joint = "axle"
angle = "0.4 + sin(2*t)"
"""


def test_a_driven_joint_rests_where_its_drive_has_it(workshop: Workshop) -> None:
    """The rod hangs from a crank that is held: the axle takes the weights' moment, with a torque at the pin too."""
    model = workshop.model(ARM)
    weight = 9.81
    found = static_equilibrium(model)
    assert found.stability == "stable" and len(found.stiffness) == 1
    assert found.q == pytest.approx([0.4, -np.pi / 2.0], abs=1e-10)
    moment = weight * np.cos(0.4) * (2.0 * 0.3 + 3.0 * 0.8)
    assert found.reactions[0] == pytest.approx([0.0, 5.0 * weight, moment], abs=1e-8)
    leant = static_equilibrium(model, torques={"pin": 3.0 * weight * 0.5 * 0.6})
    assert np.cos(leant.q[1]) == pytest.approx(0.6, abs=1e-9) and leant.q[0] == pytest.approx(0.4, abs=1e-12)
    assert leant.reactions[0, 2] == pytest.approx(moment + 3.0 * weight * 0.5 * 0.6, rel=1e-9)
    with pytest.raises(ValueError, match="found axle, which a drive holds"):
        static_equilibrium(model, torques={"axle": 1.0})


def test_a_held_slider_carries_the_torque_at_its_pin(workshop: Workshop) -> None:
    """A rod held out from a block on a level guide that is driven: the guide's moment is the whole weight's."""
    text = ARM.replace('name = "axle"', 'name = "axle"\ntype = "prismatic"\naxis = [1, 0]\nangle = 0.4')
    text = text.replace('angle = "0.4 + sin(2*t)"', 'position = "0.2 + t"')
    model = workshop.model(text)
    found = static_equilibrium(model, torques={"pin": 3.0 * 9.81 * 0.5 * 0.6})
    slide = found.q[model.q_names.index("slide_0")]
    assert slide == pytest.approx(0.2, abs=1e-12)
    moment = 9.81 * (2.0 * 0.3 * np.cos(0.4) + 3.0 * (0.8 * np.cos(0.4) + 0.5 * 0.6))
    assert found.reactions[0] == pytest.approx([0.0, 5.0 * 9.81, moment], rel=1e-9, abs=1e-8)


def test_a_driven_leg_at_rest_has_the_virtual_work_of_its_crank(workshop: Workshop) -> None:
    """The moment that holds the crank is the potential's slope along its turn, by differences on assembled legs."""
    model = shown("jansen-driven", workshop)
    found = static_equilibrium(model)
    assert found.q == pytest.approx(model.start()[0], abs=1e-12)
    assert found.stiffness.shape == (0,)
    free = shown("jansen-leg", workshop)
    motion = np.linalg.svd(free.jacobian(found.q))[2][-1]
    motion /= motion[0]
    energies = []
    for step in (-1e-4, 1e-4):
        q, _ = free.project(found.q + step * motion, 0.0 * motion)
        energies.append((q[0], free.energy(q, 0.0 * motion)[1]))
    slope = (energies[1][1] - energies[0][1]) / (energies[1][0] - energies[0][0])
    assert found.reactions[model.joints.index("axle"), 2] == pytest.approx(slope, rel=1e-6)


def test_a_torque_stands_for_the_drive_of_its_joint(workshop: Workshop) -> None:
    model = workshop.model(ARM)
    q, u = model.start()
    u_dot = model.acceleration(q, u, 0.3)
    moment = model.reactions(q, u, 0.3)[0, 2]
    assert inverse_dynamics(model, q, u, u_dot, ["axle"], t=0.3) == pytest.approx([moment], rel=1e-12)
    assert inverse_dynamics(model, q, u, u_dot, ["pin"], t=0.3) == pytest.approx([0.0], abs=1e-12)


def test_a_turn_beside_a_drive_is_refused(workshop: Workshop) -> None:
    model = shown("jansen-driven", workshop)
    with pytest.raises(ValueError, match="found pivot_hip beside driven axle"):
        driving_torque(model, "pivot_hip", 1.0)
    leg, poses = shown("jansen-leg", workshop), model.poses(model.start()[0])
    q, _ = leg.state_from_poses(poses, np.zeros_like(poses))  # the free crank starts turned a little
    turn, free = driving_torque(model, "axle", 6.0, 12), driving_torque(leg, "axle", 6.0, 12, q)
    assert turn.torque == pytest.approx(free.torque, rel=1e-7, abs=1e-7 * abs(free.peak))
