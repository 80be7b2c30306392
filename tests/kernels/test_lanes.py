"""Accelerations over the machine's vector lanes: the same numbers as one state at a time, whatever the width."""

from __future__ import annotations

import json
import shutil
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ccgen.generator import chain, generate, load_scene, loop
from ccgen.generator.compile.compiler import CompileError
from ccgen.runtime import load_model, simulate

from ..oracles import polygons
from ..oracles.maximal import Array
from ..support.folders import SCENES
from ..support.tiers import all_hard_but
from ..support.workshop import Workshop

ACTED = """
name = "acted"
[chain]
links = 3
hinged = true
[start]
angles = [0.3, -0.4, 0.5]
[gravity]
g = 9.81
[[torsion]]
joint = "joint_1"
stiffness = 4.0
damping = 0.3
[[joint_friction]]
joints = ["joint_2"]
dry = 0.4
viscous = 0.1
rate = 0.05
[[motor]]
joint = "joint_0"
torque = "2 * sin(3 * t) + exp(-t)"
[[drag]]
point = "link_1.B"
quadratic = 0.2
[[input]]
name = "push"
point = "link_2.B"
direction = [1, 0]
"""
"""Functions of the C library, time, and an input."""


def both(model: Any, q: Array, u: Array, t: Array) -> tuple[Array, Array]:
    """Accelerations of the states, one by one and in lanes."""
    single = [model.kernels.acceleration(a[None], b[None], float(c))[0][0] for a, b, c in zip(q, u, t, strict=True)]
    lanes, outcomes = model.kernels.acceleration_lanes(q, u, t)
    assert set(outcomes) == {"done"}
    return np.array(single), lanes


def states(model: Any, count: int, spread: float = 0.2) -> tuple[Array, Array, Array]:
    rng = np.random.default_rng(4)
    q, u = model.start()
    n = q.size
    return q + spread * rng.normal(size=(count, n)), u + rng.normal(size=(count, n)), rng.uniform(0.0, 9.0, count)


@pytest.mark.parametrize(
    "name",
    all_hard_but(
        *("closed-pendulum", "falling-hexagon", "four-bar", "jansen-driven", "newtons-cradle", "slider-crank"),
        of=sorted(path.stem for path in SCENES.glob("*.toml")),
    ),
)
def test_lanes_agree_with_one_state_at_a_time(name: str, workshop: Workshop) -> None:
    """To rounding: of the arithmetic, or of the states where their last digit changes more, as with light links."""
    model = workshop.model(load_scene(SCENES / f"{name}.toml"))
    q, u, t = states(model, 21)
    single, lanes = both(model, q, u, t)
    beside = [both(model, np.nextafter(q, way), u, t)[0] for way in (np.inf, -np.inf)]
    rounding = 3e-14 * max(1, len(model.cuts))  # each loop's multipliers are found from those of others
    known = sum(np.max(np.abs(one - single)) for one in beside)
    assert np.max(np.abs(lanes - single)) <= max(rounding * np.max(np.abs(single)), known)


def test_functions_time_and_inputs(workshop: Workshop) -> None:
    model = workshop.model(ACTED)
    model.kernels.set_inputs(np.array([1.7]))
    single, lanes = both(model, *states(model, 19))
    assert np.max(np.abs(lanes - single)) <= 1e-13 * np.max(np.abs(single))
    still, _ = both(model, *states(model, 19)[:2], np.zeros(19))
    assert np.max(np.abs(lanes - still)) > 0.1


@pytest.mark.hard
def test_rolled_loops(workshop: Workshop) -> None:
    model = workshop.model(loop(48, gravity=True))
    single, lanes = both(model, *states(model, 9, spread=0.02))
    assert np.max(np.abs(lanes - single)) <= 1e-12 * np.max(np.abs(single))


@pytest.mark.quick
@pytest.mark.parametrize("count", [1, 2, 7, 8, 9])
def test_any_number_of_states(count: int, workshop: Workshop) -> None:
    model = workshop.model(loop(6, gravity=True))
    q, u, t = states(model, count)
    single, lanes = both(model, q, u, t)
    assert lanes.shape == q.shape
    assert np.max(np.abs(lanes - single)) <= 1e-14 * np.max(np.abs(single))


def test_singular_lanes_take_the_robust_path_and_leave_the_others_alone(workshop: Workshop) -> None:
    """A flat square in one lane: its closure rows depend on each other."""
    model = workshop.model(loop(4, gravity=True))
    q, u, t = states(model, model.kernels.lanes, spread=0.01)
    q = np.array([model.project(a, b)[0] for a, b in zip(q, u, strict=True)])
    u = np.array([model.project(a, b)[1] for a, b in zip(q, u, strict=True)])
    flat = np.array([0.0, 0.0, 0.0, 0.0, np.pi, np.pi])
    q[1], u[1] = flat, model.project(flat, np.array([0.1, 0.2, 0.3, 0.3, 0.3, 0.3]))[1]
    single, lanes = both(model, q, u, t)
    assert np.array_equal(lanes[1], single[1])
    assert np.max(np.abs(lanes - single)) <= 1e-12 * np.max(np.abs(single))


@pytest.mark.quick
def test_a_lane_that_is_no_number_spoils_no_other(workshop: Workshop) -> None:
    model = workshop.model(loop(6, gravity=True))
    q, u, t = states(model, model.kernels.lanes)
    single, _ = both(model, q, u, t)
    u[0, 3] = np.inf
    lanes, _ = model.kernels.acceleration_lanes(q, u, t)
    assert not np.all(np.isfinite(lanes[0]))
    assert np.max(np.abs(lanes[1:] - single[1:])) <= 1e-14 * np.max(np.abs(single))


@pytest.mark.quick
def test_large_angles(workshop: Workshop) -> None:
    """Beyond the range of the vector sines in one lane: all lanes go to the C library."""
    model = workshop.model(loop(6, gravity=True))
    q, u, t = states(model, 5)
    q[2, 2:] += 2 * np.pi * 20000
    single, lanes = both(model, q, u, t)
    assert np.max(np.abs(lanes - single)) <= 1e-14 * np.max(np.abs(single))


@pytest.mark.sample(2)
@pytest.mark.parametrize("width", ["2", "4", "8"])
def test_the_width_can_be_asked_for(width: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Widths that the machine does not have are emulated by the compiler; a run is the same to rounding."""
    reference = load_model(generate(loop(6, gravity=True), tmp_path / "own"))
    monkeypatch.setenv("CCGEN_LANES", width)
    folder = generate(loop(6, gravity=True), tmp_path / "asked")
    assert f"-DCCGEN_LANES={width}" in json.loads((folder / "build.json").read_text())["flags"]
    model = load_model(folder)
    assert model.kernels.lanes == int(width)
    single, lanes = both(model, *states(model, 11))
    assert np.max(np.abs(lanes - single)) <= 1e-14 * np.max(np.abs(single))
    q, u, t = states(model, 11)
    assert np.array_equal(model.acceleration(q, u, t), lanes)
    q, u = model.state_from_poses(*polygons.perturbed(6))
    runs = [simulate(m, q, u, until=2.0, rtol=1e-12, method="gauss") for m in (model, reference)]
    assert all(run.success for run in runs)
    assert np.max(np.abs(runs[0].q[-1] - runs[1].q[-1])) <= 1e-12


def test_a_width_that_there_is_not(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CCGEN_LANES", "3")
    with pytest.raises(CompileError, match="CCGEN_LANES is '3', expected one of 2, 4, 8"):
        generate(loop(6), tmp_path)


@pytest.mark.skipif(shutil.which("cc") is None, reason="there is no cc")
def test_no_warnings(workshop: Workshop, tmp_path: Path) -> None:
    folder = generate(workshop.scene(ACTED), out=tmp_path)
    command = ["cc", "-std=c11", "-Wall", "-Wextra", "-Werror", "-pedantic", "-O1", "-c", "lanes.c"]
    done = subprocess.run([*command, "-o", "lanes.o"], cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_many_states_go_in_lanes_as_single_ones_do(workshop: Workshop) -> None:
    """Accelerations and multipliers of 21 states, not a multiple of the lanes, with an input; one of them by itself."""
    model = workshop.model(ACTED)
    q, u, _ = states(model, 21)
    inputs = {"push": 0.7}
    for call in (model.acceleration, model.multipliers):
        single = np.array([call(a, b, 0.4, inputs) for a, b in zip(q, u, strict=True)])
        assert np.max(np.abs(call(q, u, 0.4, inputs) - single), initial=0.0) <= 3e-14 * np.max(
            np.abs(single), initial=1.0
        )


@pytest.mark.parametrize("links", [2, 3, 6])
def test_states_are_turned_into_lanes_and_back(links: int, workshop: Workshop) -> None:
    """Four, five and eight coordinates: squares of lanes that fit and others. Bits are those of states in lanes."""
    model = workshop.model(loop(links, gravity=True) if links > 2 else chain(links, gravity=True))
    q, u, t = states(model, 21, spread=0.05)
    assert np.array_equal(model.acceleration(q, u, t), model.kernels.acceleration_lanes(q, u, t)[0])
    single = np.array([model.multipliers(a, b, c) for a, b, c in zip(q, u, t, strict=True)])
    miss = np.max(np.abs(model.multipliers(q, u, t) - single), initial=0.0)
    assert miss <= 1e-13 * np.max(np.abs(single), initial=1.0)


def test_a_state_that_lanes_cannot_solve_is_solved_alone(workshop: Workshop) -> None:
    """The flat parallelogram among states that are not: its closure rows depend on each other."""
    model = workshop.model(load_scene(SCENES / "parallelogram.toml"))
    q, u = model.start()
    q, u = np.tile(q, (21, 1)), np.tile(u, (21, 1))
    q[11] = np.round(q[11] / np.pi) * np.pi
    _, _, without = model.kernels.acceleration(q, u, 0.0)
    assert not without
    assert np.array_equal(model.acceleration(q, u)[11], model.acceleration(q[11], u[11]))
    assert np.array_equal(model.multipliers(q, u)[11], model.multipliers(q[11], u[11]))


def test_a_state_without_accelerations_is_named(workshop: Workshop) -> None:
    model = workshop.model(load_scene(SCENES / "falling-ring.toml"))
    q, u = model.start()
    q, u = np.tile(q, (21, 1)), np.tile(u, (21, 1))
    u[17] = 1e200
    with pytest.raises(ValueError, match="state 17 has no accelerations"):
        model.acceleration(q, u)


def test_states_are_left_as_they_were(workshop: Workshop) -> None:
    """Functions of states read the arrays that they are given, and what they return is new."""
    model = workshop.model(load_scene(SCENES / "open-chain.toml"))
    q, u, _ = states(model, 3)
    before = q.copy(), u.copy()
    for found in (*model.project(q, u), *model.project(q[0], u[0]), model.assemble(q), model.assemble(q[0])):
        assert not np.shares_memory(found, q)
        assert not np.shares_memory(found, u)
    model.acceleration(q, u)
    assert np.array_equal(q, before[0])
    assert np.array_equal(u, before[1])
