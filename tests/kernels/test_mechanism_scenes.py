"""Scenes of mechanisms: known motions, and accelerations, reactions and torques against the dense reference."""

from __future__ import annotations

import importlib
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from ccgen.generator import load_scene
from ccgen.runtime import driving_torque, inverse_dynamics, simulate

from ..oracles import joint_scenes, loads, maximal, scenes, sliding
from ..oracles.maximal import GROUND, Array, System
from ..support.folders import SCENES
from ..support.jansen_foot import foot
from ..support.random_mechanism_checks import quasi_accelerations
from ..support.tiers import hard
from ..support.workshop import Workshop

DRIVES = {
    "four-bar": ["motor"],
    "jansen-leg": ["axle"],
    "n-four-bar": ["foot_0"],
    "newtons-cradle": [f"hook_{k}" for k in range(5)],
    "parallelogram": ["motor"],
    "closed-pendulum": ["nail", "pin_0", "pin_1", "pin_2", "pin_5", "pin_6"],
    "flyer": ["left_shoulder", "left_elbow", "right_shoulder", "right_elbow", "tail_root", "tail_joint"],
}
SLIDING = {
    "slider-crank": "motor",
    "equal-length-slider-crank": "motor",
    "quick-return": "axle",
    "massless-coupler": "motor",
    "strandbeest": "axle",
}
"""Joints of each scene that are driven: as many as there are degrees of freedom, or all of a floating tree."""
SINGULAR = 3e3
TOLERANCE = 1e-10


@dataclass(frozen=True)
class Case:
    name: str
    model: Any
    system: System

    def states(self, count: int = 8) -> Iterator[tuple[Array, Array]]:
        """Random consistent states away from singular ones, in which nothing touches."""
        rng = np.random.default_rng(5)
        q0, _ = self.model.start()
        wide = 0.35 if self.model.dof > 1 else 3.0
        scale = maximal.conditioning(self.system, self.model.poses(q0))
        found = 0
        for _ in range(4000):
            bent = q0.copy()
            if self.model.dof > 1:
                bent += rng.uniform(-wide, wide, len(bent))
            else:
                bent = bent + rng.uniform(-0.3, 0.3) * self.model.project(q0, rng.normal(size=len(q0)))[1]
            try:
                q, u = self.model.project(self.model.assemble(bent), rng.normal(size=len(bent)))
            except ValueError:
                continue
            if not np.all(self.model.kernels.of_q("gaps", q[None]) > 0.0):
                continue
            if maximal.conditioning(self.system, self.model.poses(q)) < max(SINGULAR, 10.0 * scale):
                yield q, u
                found += 1
                if found == count:
                    return
        raise AssertionError("too few states away from singular ones")


@pytest.fixture(scope="module", params=DRIVES)
def case(request: pytest.FixtureRequest, workshop: Workshop) -> Case:
    path = SCENES / f"{request.param}.toml"
    return Case(request.param, workshop.model(load_scene(path)), scenes.read_system(path))


def quasi(model: Any, frames: Array) -> Array:
    column = {"vx": 0, "vy": 1, "w": 2}
    names = (name.rsplit("_", 1) for name in model.u_names)
    return np.array([frames[int(link), column[kind]] for kind, link in names], dtype=float)


def close(found: Array, wanted: Array, least: float = 0.0) -> bool:
    wanted = np.asarray(wanted, dtype=float)
    return bool(np.max(np.abs(found - wanted)) <= TOLERANCE * np.max(np.abs(wanted), initial=least))


def test_accelerations_and_reactions_are_those_of_the_dense_solve(case: Case) -> None:
    model, system = case.model, case.system
    for q, u in case.states():
        poses = model.poses(q)
        assert maximal.opening(system, poses) <= 1e-13 * max(1.0, model.length)
        motion = maximal.accelerate(system, poses, model.velocities(q, u))
        assert close(model.acceleration(q, u), quasi(model, motion.frames))
        weight = float(np.max(system.mass)) * system.gravity
        assert close(model.reactions(q, u)[:, :2], motion.forces, weight)


def test_torques_of_a_motion_are_those_that_made_it(case: Case) -> None:
    """Known torques in the dense reference give a motion; inverse dynamics gives the torques back."""
    model, system, rng = case.model, case.system, np.random.default_rng(9)
    for q, u in case.states(5):
        size = float(np.max(system.mass)) * system.gravity * model.length
        torques = size * rng.uniform(0.5, 1.0, len(DRIVES[case.name])) * rng.choice([-1.0, 1.0])
        wrenches = np.zeros((system.size, 3))
        for name, torque in zip(DRIVES[case.name], torques, strict=True):
            pin = system.pins[model.joints.index(name)]
            for link, sign in ((pin.a, -1.0), (pin.b, 1.0)):
                if link != GROUND:
                    wrenches[link, 2] += sign * torque
        motion = loads.accelerate(system, model.poses(q), model.velocities(q, u), wrenches, (0.0, -1.0))
        found = inverse_dynamics(model, q, u, quasi(model, motion.frames), DRIVES[case.name])
        assert close(found, torques)


def test_runs_keep_their_energy(case: Case) -> None:
    run = simulate(case.model)
    assert run.success, run.message
    assert run.closure_max <= 1e-13 * max(1.0, case.model.length)
    energy = sum(abs(part) for part in case.model.energy(*case.model.start()))
    assert run.energy_drift <= 1e-7 * energy


# -- sliding joints, welds, links without mass -------------------------------------------------------------------------


@dataclass(frozen=True)
class Joint:
    """A scene whose joints are of any kind, and the joint that is driven."""

    name: str
    model: Any
    joined: joint_scenes.Joined
    drive: str

    def states(self, count: int) -> Iterator[tuple[Array, Array, Array, Array]]:
        """Random consistent states away from singular ones: q, u, and poses and velocities of all links."""
        rng = np.random.default_rng(5)
        q0, _ = self.model.start()
        found = 0
        for _ in range(400):
            stir = self.model.project(q0, rng.normal(size=len(q0)))[1]
            reach = rng.uniform(-1.0, 1.0) * (0.3 if self.model.dof > 1 else 1.5) / np.max(np.abs(stir))
            try:
                q, u = self.model.project(self.model.assemble(q0 + reach * stir), rng.normal(size=len(q0)))
            except ValueError:
                continue
            poses, velocities = self.joined.spread(self.model.links, self.model.poses(q), self.model.velocities(q, u))
            if self.joined.conditioning(poses) < 1e5:
                yield q, u, poses, velocities
                found += 1
                if found == count:
                    return
        raise AssertionError("too few states away from singular ones")

    def accelerations(self, poses: Array, velocities: Array, frames: Array) -> Array:
        """The reference's motion as quasi-accelerations of the model."""
        left = [self.joined.names.index(name) for name in self.model.links]
        return quasi_accelerations(self.model, poses[left], velocities[left], frames[left])


@pytest.fixture(scope="module", params=[hard(name) if name == "strandbeest" else name for name in SLIDING])
def joint(request: pytest.FixtureRequest, workshop: Workshop) -> Joint:
    path = SCENES / f"{request.param}.toml"
    return Joint(request.param, workshop.model(load_scene(path)), joint_scenes.read(path), SLIDING[request.param])


def test_motions_and_forces_of_joints_of_any_kind_are_those_of_the_dense_solve(joint: Joint) -> None:
    model, joined = joint.model, joint.joined
    for q, u, poses, velocities in joint.states(6):
        miss, opening = sliding.misses(joined.system, joined.slots, poses, velocities)
        assert miss <= 1e-13 * max(1.0, model.length)
        assert opening <= 1e-12 * max(1.0, model.length * np.abs(velocities[:, 2]).max())
        motion = sliding.accelerate(joined.system, joined.slots, poses, velocities)
        assert close(model.acceleration(q, u), joint.accelerations(poses, velocities, motion.frames))
        reactions = model.reactions(q, u)
        weight = float(np.max(joined.system.mass)) * joined.system.gravity
        largest = max(weight, np.abs(motion.pins).max(), np.abs(motion.slots[:, :2]).max(initial=0.0))
        for name, found in zip(model.joints, reactions, strict=True):
            end = joined.ends[name]
            pin = isinstance(end, maximal.Pin)
            wanted = motion.pins[joined.system.pins.index(end)] if pin else motion.slots[joined.slots.index(end)]
            assert np.max(np.abs(found[:2] - wanted[:2])) <= TOLERANCE * largest
            if not pin and end.angle is not None and name not in model.cuts:
                assert end.b > end.a, "about the second point"
                assert abs(found[2] - wanted[2]) <= TOLERANCE * max(largest * model.length, abs(wanted[2]))
            else:
                assert found[2] == 0.0


def test_a_torque_that_made_a_motion_with_sliding_joints_comes_back(joint: Joint) -> None:
    model, joined, rng = joint.model, joint.joined, np.random.default_rng(9)
    pin = joined.ends[joint.drive]
    for q, u, poses, velocities in joint.states(4):
        torque = float(np.max(joined.system.mass)) * joined.system.gravity * model.length * rng.uniform(0.5, 1.0)
        wrenches = np.zeros((joined.system.size, 3))
        for link, sign in ((pin.a, -1.0), (pin.b, 1.0)):
            if link != GROUND:
                wrenches[link, 2] += sign * torque
        motion = sliding.accelerate(joined.system, joined.slots, poses, velocities, wrenches)
        u_dot = joint.accelerations(poses, velocities, motion.frames)
        assert close(inverse_dynamics(model, q, u, u_dot, [joint.drive]), np.array([torque]))


def test_runs_with_sliding_joints_keep_their_energy(joint: Joint) -> None:
    run = simulate(joint.model)
    assert run.success, run.message
    last_digits = 2.0 * np.finfo(float).eps * len(joint.model.links) * joint.model.length  # of the angles of all links
    assert run.closure_max <= max(1e-14 * max(1.0, joint.model.length), last_digits)
    energy = sum(abs(part) for part in joint.model.energy(*joint.model.start()))
    assert run.energy_drift <= 1e-7 * energy


def test_slider_crank_is_where_the_closed_form_has_it(workshop: Workshop) -> None:
    """The slider at r cos θ + √(l² − r² sin²θ) with its stroke of 2 r, the crank as fast as the energy says."""
    model = workshop.model(load_scene(SCENES / "slider-crank.toml"))
    run = simulate(model, rtol=1e-11)
    angle, rate, r, length = run.q[:, 0], run.u[:, 0], 0.2, 0.6
    assert abs(angle[-1] - angle[0]) > 8.0 * np.pi
    reach = np.sqrt(length**2 - (r * np.sin(angle)) ** 2)
    slide, sliding_rate = run.q[:, model.q_names.index("slide_3")], run.u[:, model.u_names.index("sliding_3")]
    assert np.max(np.abs(slide - (r * np.cos(angle) + reach))) <= 1e-14
    slope = -r * np.sin(angle) * (1.0 + r * np.cos(angle) / reach)
    assert np.max(np.abs(sliding_rate - slope * rate)) <= 1e-12 * np.max(np.abs(rate))
    rod = -r * np.cos(angle) / reach
    middle = (-r * np.sin(angle) + 0.5 * r * np.sin(angle) * rod, 0.5 * r * np.cos(angle))
    felt = 0.4 * r**2 / 3.0 + 0.6 * (middle[0] ** 2 + middle[1] ** 2) + 0.018 * rod**2 + slope**2
    energy = 0.5 * felt * rate**2 + 9.81 * (0.4 + 0.6) * 0.5 * r * np.sin(angle)
    assert np.max(np.abs(energy / energy[0] - 1.0)) <= 1e-9
    assert np.ptp(slide) == pytest.approx(2.0 * r, abs=1e-3)


def test_equal_lengths_pass_upright_on_their_branch(workshop: Workshop) -> None:
    """Rod and crank stay mirror images, and the energy on this branch is that of its closed form, to 1e-9."""
    model = workshop.model(load_scene(SCENES / "equal-length-slider-crank.toml"))
    run = simulate(model)
    assert run.success, run.message
    theta, rate = run.q[:, 0], run.u[:, 0]
    assert np.ptp(theta) > 10.0 * np.pi
    assert np.max(np.abs(theta + run.q[:, 1])) <= 1e-9
    assert np.max(np.abs(run.q[:, 2] - 2.0 * np.cos(theta))) <= 1e-9
    sine, cosine = np.sin(theta) ** 2, np.cos(theta) ** 2
    kinetic = 0.5 * rate**2 * (1.0 / 3.0 + 1.0 / 12.0 + 2.25 * sine + 0.25 * cosine + 4.0 * sine)
    energy = kinetic + 9.81 * np.sin(theta)
    assert energy[0] == pytest.approx(4.0 * (5.0 / 3.0 + 4.0 * 0.5) + 9.81 * np.sqrt(0.5), rel=1e-12)
    assert np.max(np.abs(energy / energy[0] - 1.0)) <= 1e-9


def ram(crank: Array) -> tuple[Array, Array]:
    """Angle of the quick return's lever, and place of its ram along the guide, at angles of the crank."""
    pin = 0.2j + 0.1 * np.exp(1j * crank)
    end = 0.45 * pin / np.abs(pin)
    return np.angle(pin), end.real + np.sqrt(0.2**2 - (0.45 - end.imag) ** 2)


def test_quick_return_moves_as_its_closed_form(workshop: Workshop) -> None:
    """Over a turn: positions, speeds and accelerations; out over 240° of the crank, back over 120°."""
    model = workshop.model(load_scene(SCENES / "quick-return.toml"))
    turn = driving_torque(model, "axle", -10.0, 720)
    lever, place = ram(turn.angle)
    assert np.max(np.abs(turn.q[:, 1] - lever)) <= 1e-12
    assert np.max(np.abs(turn.q[:, 3] - place)) <= 1e-12
    step = 1e-3
    for column, index in ((0, 1), (1, 3)):
        around = [ram(turn.angle + k * step)[column] for k in (-3, -2, -1, 0, 1, 2, 3)]
        first = (np.array([-1, 9, -45, 0, 45, -9, 1]) / 60.0 / step) @ around
        second = (np.array([2, -27, 270, -490, 270, -27, 2]) / 180.0 / step**2) @ around
        assert np.max(np.abs(turn.u[:, index] + 10.0 * first)) <= 1e-9 * np.max(np.abs(turn.u[:, index]))
        assert np.max(np.abs(turn.u_dot[:, index] - 100.0 * second)) <= 1e-7 * np.max(np.abs(turn.u_dot[:, index]))
    for out in (turn.u[:, 1] < 0.0, turn.u[:, 3] > 0.0):
        assert np.mean(out) == pytest.approx(2.0 / 3.0, abs=2.0 / 720)


def test_a_coupler_without_mass_only_pulls_or_pushes(workshop: Workshop) -> None:
    """Its force runs along it; crank and rocker have the energy of two bodies, one with the counterweight on it."""
    path = SCENES / "massless-coupler.toml"
    model = workshop.model(load_scene(path))
    assert list(model.links) == ["crank", "coupler", "rocker"]
    run = simulate(model, rtol=1e-11)
    reactions = model.reactions(run.q, run.u)
    along = np.column_stack([np.cos(run.q[:, 1]), np.sin(run.q[:, 1])])
    for name in ("knee", "elbow"):
        force = reactions[:, model.joints.index(name), :2]
        across = force[:, 1] * along[:, 0] - force[:, 0] * along[:, 1]
        assert np.max(np.abs(across)) <= 1e-12 * np.max(np.abs(force))
    felt = 0.4 * 0.2**2 / 3.0 + 0.002 + 1.5 * 0.05**2
    tilted = run.q[:, 0] + np.radians(170.0)
    kinetic = 0.5 * felt * run.u[:, 0] ** 2 + 0.5 * 0.25 / 3.0 * run.u[:, 2] ** 2
    potential = 9.81 * (0.04 * np.sin(run.q[:, 0]) + 1.5 * 0.05 * np.sin(tilted) + 0.25 * np.sin(run.q[:, 2]))
    energy = kinetic + potential
    assert np.max(np.abs(energy / energy[0] - 1.0)) <= 1e-9


def test_a_light_coupler_comes_to_the_one_without_mass(workshop: Workshop) -> None:
    """The difference from the dense reference with a light coupler is proportional to the coupler's mass."""
    path = SCENES / "massless-coupler.toml"
    model, joined = workshop.model(load_scene(path)), joint_scenes.read(path)
    q, u = model.start()
    poses, velocities = joined.spread(model.links, model.poses(q), model.velocities(q, u))
    found, coupler = model.acceleration(q, u), joined.names.index("coupler")
    differences = []
    for light in (1e-3, 1e-5):
        mass, inertia = joined.system.mass.copy(), joined.system.inertia.copy()
        mass[coupler], inertia[coupler] = light, light * 0.5**2 / 12.0
        system = maximal.System(mass, inertia, joined.system.com, joined.system.pins, joined.system.gravity)
        frames = sliding.accelerate(system, joined.slots, poses, velocities).frames
        left = [joined.names.index(name) for name in model.links]
        differences.append(np.max(np.abs(found - np.asarray(frames[left, 2], dtype=float))))
    assert differences[0] / differences[1] == pytest.approx(100.0, rel=1e-2)
    assert differences[1] <= 1e-3 * np.max(np.abs(found))


# -- Strandbeest -------------------------------------------------------------------------------------------------------


@pytest.mark.hard
def test_strandbeest_flies_with_the_momentum_that_it_has(workshop: Workshop) -> None:
    path = SCENES / "strandbeest.toml"
    model, joined = workshop.model(load_scene(path)), joint_scenes.read(path)
    assert (len(model.links), len(model.cuts), len(model.rows), model.dof) == (30, 14, 28, 4)
    run = simulate(model, rtol=1e-11)
    assert run.success, run.message
    assert np.ptp(run.q[:, model.q_names.index("theta_1")]) > 2.0 * np.pi
    poses, velocities = model.poses(run.q), model.velocities(run.q, run.u)
    system = joined.system
    found = np.array([maximal.momenta(system, p, v) for p, v in zip(poses, velocities, strict=True)], dtype=float)
    weight = system.mass.sum() * system.gravity
    assert np.max(np.abs(found[:, 0] - found[0, 0])) <= 1e-9 * weight
    assert np.max(np.abs(found[:, 1] + weight * run.t - found[0, 1])) <= 1e-9 * weight
    kinetic, potential = model.energy(*model.start())
    assert run.energy_drift <= 1e-9 * (abs(kinetic) + abs(potential))


@pytest.mark.hard
def test_strandbeest_has_the_feet_of_the_leg(workshop: Workshop) -> None:
    """Seen from the body, four feet draw the leg's path, in centimetres: two of them, mirrored ones, and half a turn
    apart."""
    model = workshop.model(load_scene(SCENES / "strandbeest.toml"))
    run = simulate(model)
    body, turned = model.poses(run.q)[:, 0], run.q[:, 3] - run.q[:, 2]
    for suffix, phase, mirrored in (("l0", 0.0, False), ("r0", 0.0, True), ("l1", np.pi, False), ("r1", np.pi, True)):
        place = model.point(f"shin_{suffix}.F", run.q)
        seen = (place[:, 0] + 1j * place[:, 1] - body[:, 0] - 1j * body[:, 1]) * np.exp(-1j * body[:, 2])
        wanted = -foot(np.pi - turned - phase).conjugate() if mirrored else foot(turned + phase)
        assert np.max(np.abs(seen - wanted / 100.0)) <= 1e-11


def test_strandbeest_is_what_its_script_writes(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(SCENES.parent / "docs" / "scripts"))
    for name, scene in (("strandbeest", "strandbeest.toml"), ("jansen", "jansen-leg.toml")):
        assert importlib.import_module(name).text() == (SCENES / scene).read_text(), name
    script, phases = importlib.import_module("strandbeest"), (0.0, 2.0)
    plain, placed = (
        load_scene(tomllib.loads(text)) for text in (script.plain(phases), script.text(phases, pumps=False))
    )
    assert plain.mechanism == placed.mechanism


# -- Jansen leg --------------------------------------------------------------------------------------------------------


def test_jansen_foot_draws_its_path(workshop: Workshop) -> None:
    """Assembled over a turn of the crank, each position from the one before."""
    model = workshop.model(load_scene(SCENES / "jansen-leg.toml"))
    assert (len(model.links), len(model.joints), len(model.cuts), model.dof) == (7, 10, 3, 1)
    q, _ = model.start()
    path, cranks = [], []
    for _ in range(721):
        cranks.append(q[model.links.index("crank")])
        path.append(model.point("shin.F", q))
        _, u = model.project(q, np.eye(len(q))[model.links.index("crank")])
        q = model.assemble(q + u * (np.pi / 360.0) / u[model.links.index("crank")])
    found, wanted = np.array(path), foot(np.array(cranks))
    assert cranks[-1] - cranks[0] == pytest.approx(2.0 * np.pi, abs=0.05)
    assert np.max(np.abs(found[:, 0] + 1j * found[:, 1] - wanted)) <= 1e-10
    dense = foot(np.linspace(0.0, 2.0 * np.pi, 20001))
    for path_ in (dense, found[:, 0] + 1j * found[:, 1]):
        assert np.ptp(path_.real) == pytest.approx(67.908, abs=1e-3)
        assert np.ptp(path_.imag) == pytest.approx(22.457, abs=1e-3)


def test_jansen_foot_over_a_driven_turn(workshop: Workshop) -> None:
    model = workshop.model(load_scene(SCENES / "jansen-leg.toml"))
    turn = driving_torque(model, "axle", 6.0, 720)
    found = model.point("shin.F", turn.q)
    assert np.max(np.abs(found[:, 0] + 1j * found[:, 1] - foot(turn.angle))) <= 1e-10
    assert np.ptp(found[:, 0]) == pytest.approx(67.908, abs=1e-3)
    assert np.ptp(found[:, 1]) == pytest.approx(22.457, abs=1e-3)


# -- lost rank ---------------------------------------------------------------------------------------------------------


def test_two_four_bars_are_where_the_exact_solution_is(workshop: Workshop) -> None:
    """All uprights stay parallel: sin(φ/2) = cn(K(m) − c t | m), at t = 10 after ten passes through a line."""
    model = workshop.model(load_scene(SCENES / "n-four-bar.toml"))
    run = simulate(model)
    assert run.success, run.message
    q, u = run.at(10.0)
    assert np.max(np.abs(model.point("upright_0.B", q) - (0.328458111540815, 0.944518538178601))) <= 1e-8
    speed = u[0] * np.array([-np.sin(q[0]), np.cos(q[0])])
    assert np.max(np.abs(speed - (1.42305147020694, -0.494868845487043))) <= 1e-8
    assert run.energy_drift <= 1e-8
    assert np.max(np.abs(q[3:])) <= 1e-8 and np.ptp(q[:3]) <= 1e-8


@pytest.mark.parametrize(("method", "loss"), [("gauss", 10.0), ("dop853", 300.0)])
def test_passing_a_line_costs_no_digits(method: str, loss: float, workshop: Workshop) -> None:
    """At every tolerance, so wherever steps happen to end. The pendulum it amounts to is off by 85 rtol when SciPy's
    DOP853 integrates its one angle."""
    model = workshop.model(load_scene(SCENES / "n-four-bar.toml"))
    for rtol in np.geomspace(1e-9, 1e-12, 25):
        run = simulate(model, rtol=rtol, method=method)
        assert run.success, run.message
        head = model.point("upright_0.B", run.q[-1])
        assert np.max(np.abs(head - (0.328458111540815, 0.944518538178601))) <= loss * rtol + 2e-9, rtol


@pytest.mark.parametrize("name", ["n-four-bar", "parallelogram"])
def test_states_between_rows_are_as_good_where_steps_pass_lines(name: str, workshop: Workshop) -> None:
    run = simulate(workshop.model(load_scene(SCENES / f"{name}.toml")))
    q, u = run.at(np.linspace(0.0, run.t[-1], 2001))
    assert np.ptp(np.sum(run.model.energy(q, u), axis=0)) <= 5e-8
    assert np.max(np.abs(run.model.closure(q))) <= 1e-13
    assert run.acceleration_error <= 1e-12


@pytest.mark.sample(1)
@pytest.mark.parametrize("count", [1, 3, hard(5)])
def test_rows_of_four_bars_start_upright(count: int, workshop: Workshop) -> None:
    scene = workshop.scene(f'name = "row"\n[four_bars]\ncount = {count}\nlength = 2.0\n')
    assert len(scene.mechanism.links) == 2 * count + 1
    model = workshop.model(scene)
    q, u = model.start()
    assert model.dof == 1
    heads = [model.point(f"upright_{k}.B", q) for k in range(count + 1)]
    assert np.allclose(heads, [(2.0 * k, 2.0) for k in range(count + 1)], atol=1e-13)
    assert np.allclose(-2.0 * u[: count + 1], 1.0, atol=1e-13)


def test_parallelogram_keeps_its_branch(workshop: Workshop) -> None:
    """The coupler only translates, through every change point: a pendulum in φ with known energy."""
    model = workshop.model(load_scene(SCENES / "parallelogram.toml"))
    run = simulate(model)
    assert run.success, run.message
    assert np.ptp(run.q[:, 0]) > 30 * np.pi
    assert np.max(np.abs(run.q[:, 1])) <= 1e-10 and np.max(np.abs(run.q[:, 0] - run.q[:, 2])) <= 1e-10
    inertia, moment = 2.0 / 3.0 + 1.5, 9.81 * (0.5 + 0.5 + 1.5)
    energy = 0.5 * inertia * run.u[:, 0] ** 2 + moment * np.sin(run.q[:, 0])
    assert np.max(np.abs(energy / energy[0] - 1.0)) <= 1e-9


def test_flyer_keeps_its_momentum_but_for_gravity(workshop: Workshop) -> None:
    model = workshop.model(load_scene(SCENES / "flyer.toml"))
    run = simulate(model)
    system = scenes.read_system(SCENES / "flyer.toml")
    poses, velocities = model.poses(run.q), model.velocities(run.q, run.u)
    found = np.array([maximal.momenta(system, p, v) for p, v in zip(poses, velocities, strict=True)])
    found[:, 1] += system.mass.sum() * system.gravity * run.t
    assert np.max(np.abs(found - found[0])) <= 1e-8
