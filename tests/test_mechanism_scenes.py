"""Scenes of mechanisms: known motions, and accelerations, reactions and torques against the dense reference."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ccgen.generator import load_scene
from ccgen.runtime import driving_torque, inverse_dynamics, simulate

from .conftest import Workshop
from .oracles import loads, maximal, scenes
from .oracles.maximal import GROUND, Array, System

SCENES = Path(__file__).parents[1] / "scenes"
DRIVES = {
    "four-bar": ["motor"],
    "jansen-leg": ["axle"],
    "n-four-bar": ["foot_0"],
    "parallelogram": ["motor"],
    "closed-pendulum": ["nail", "pin_0", "pin_1", "pin_2", "pin_5", "pin_6"],
    "flyer": ["left_shoulder", "left_elbow", "right_shoulder", "right_elbow", "tail_root", "tail_joint"],
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
        """Random consistent states away from singular ones."""
        rng = np.random.default_rng(5)
        q0, _ = self.model.start()
        wide = 0.35 if self.model.dof > 1 else 3.0
        scale = maximal.conditioning(self.system, self.model.poses(q0))
        found = 0
        for _ in range(400):
            bent = q0.copy()
            if self.model.dof > 1:
                bent += rng.uniform(-wide, wide, len(bent))
            else:
                bent = bent + rng.uniform(-0.3, 0.3) * self.model.project(q0, rng.normal(size=len(q0)))[1]
            try:
                q, u = self.model.project(self.model.assemble(bent), rng.normal(size=len(bent)))
            except ValueError:
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
        sides = [model.links.index(name) for name in model.outboard]
        signs = np.array([1.0 if side == pin.b else -1.0 for side, pin in zip(sides, system.pins, strict=True)])
        weight = float(np.max(system.mass)) * system.gravity
        assert close(model.reactions(q, u)[:, :2], signs[:, None] * motion.forces, weight)


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


# -- Jansen leg --------------------------------------------------------------------------------------------------------


def meet(p: Array, r: float, q: Array, s: float, side: int) -> Array:
    """Where the circles of radius r about p and s about q meet, on the ``side`` of the way from p to q (1: left)."""
    way = q - p
    far = np.abs(way)
    along = (r**2 - s**2 + far**2) / (2.0 * far)
    return p + way / far * (along + side * 1j * np.sqrt(r**2 - along**2))


def foot(crank: Array) -> Array:
    a, b, c, d, e, f, g, h, i, j, k, low, m = (
        38.0, 41.5, 39.3, 40.1, 55.8, 39.4, 36.7, 65.7, 49.0, 50.0, 61.9, 7.8, 15.0
    )  # fmt: skip
    pivot = np.full(np.shape(crank), complex(-a, -low))
    pin = m * np.exp(1j * crank)
    upper, knee = meet(pivot, b, pin, j, 1), meet(pivot, c, pin, k, -1)
    rear = meet(pivot, d, upper, e, 1)
    heel = meet(rear, f, knee, g, -1)
    return meet(knee, i, heel, h, 1)


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


@pytest.mark.parametrize("count", [1, 3, 5])
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
