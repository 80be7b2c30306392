"""Random mechanisms, trees with random extra joints and random effects, against the dense reference.

Hypothesis draws ten in ``make test`` and fifty in ``make hard``, the same ones each time; ``make fuzz-mechanisms``
draws more.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from ccgen.runtime.model.drives import drive_rows

from ..oracles import maximal, random_mechanisms, sliding
from ..oracles.maximal import GROUND, Array
from ..oracles.random_mechanisms import KINDS, LOADS, MESHES, Sketch
from ..support.random_mechanism_checks import BOUND, EXAMPLES, FEW, check_forces, quasi_accelerations
from ..support.workshop import Workshop


@st.composite
def sketches(choose: st.DrawFn, meshes: bool = False) -> Sketch:
    """One to six links, up to three more joints, up to three loads; with ``meshes`` up to three of these before."""
    n = choose(st.integers(1, 6))
    kinds = choose(st.lists(st.sampled_from(KINDS), min_size=n, max_size=n))
    parents = [choose(st.integers(GROUND, k - 1)) for k in range(n)]
    if choose(st.booleans()) and n > 1:  # floats: nothing on the ground
        parents = [GROUND + 1 if k else -2 for k in range(n)]
        lowest = 0
    else:
        lowest = GROUND
    pairs = st.tuples(st.sampled_from(KINDS), st.integers(lowest, n - 1), st.integers(0, n - 1))
    extra = [pair for pair in choose(st.lists(pairs, max_size=3)) if pair[1] != pair[2]]
    loads = choose(st.lists(st.sampled_from(LOADS), max_size=3))
    if meshes:
        loads = choose(st.lists(st.sampled_from(MESHES), min_size=1, max_size=3)) + loads
    return random_mechanisms.draw(kinds, parents, extra, loads, choose(st.integers(0, 10**6)), choose(st.booleans()))


def check(sketch: Sketch, workshop: Workshop) -> None:
    """Accelerations, joint forces, inverse dynamics, energy, power and impulses at the drawn pose with random
    velocities."""
    model = workshop.model(sketch.toml("random-mechanism"))
    system, slots = sketch.system, sketch.slots
    assert len(model.u_names) - len(model.rows) - len(sketch.given) == model.dof
    q, _ = model.state_from_poses(sketch.poses, np.zeros_like(sketch.poses))
    rng = np.random.default_rng(3)
    q, u = model.project(q, rng.normal(size=len(q)))
    poses, velocities = model.poses(q), model.velocities(q, u)
    miss, opening = sliding.misses(system, slots, poses, velocities)
    assert miss <= 1e-12 and opening <= 1e-11 * max(1.0, np.abs(velocities).max())
    back = model.state_from_poses(poses, velocities)
    assert np.max(np.abs(back[1] - u)) <= 1e-10 * max(1.0, np.abs(u).max())
    acting = sketch.acting(poses, velocities)
    motion = sliding.accelerate(system, slots, poses, velocities, acting.wrenches, sketch.prescribed)
    wanted = quasi_accelerations(model, poses, velocities, motion.frames)
    found = model.acceleration(q, u)
    scale = max(np.max(np.abs(motion.frames)), 1.0)
    assert np.max(np.abs(found - wanted)) <= BOUND * scale
    check_forces(model, sketch, q, u, motion)
    inverse = model.kernels.inverse_dynamics(q[None], u[None], 0.0, wanted[None])[0]
    loops = model.jacobian(q).T @ model.multipliers(q, u) if model.rows else 0.0
    order = [sketch.driven.index(model.joints.index(drive["joint"])) for drive in model.data["drives"]]
    loops = loops + drive_rows(model).T @ motion.efforts[order].astype(float)
    force = max(np.max(np.abs(motion.pins), initial=0.0), np.max(np.abs(motion.slots), initial=0.0), scale)
    assert np.max(np.abs(inverse - loops)) <= BOUND * force * 10.0
    kinetic, potential = maximal.energy(system, poses, velocities)
    energy = model.energy(q, u)
    assert energy[0] == pytest.approx(kinetic, rel=1e-12)
    assert energy[1] == pytest.approx(potential + float(acting.potential), rel=1e-11, abs=1e-11 * float(scale))
    _check_impulses(model, sketch, q, rng)


def _check_impulses(model: Any, sketch: Sketch, q: Array, rng: np.random.Generator) -> None:
    """Jumps under random impulses on every link: of all links, and with M du = A^T Lambda + f + D^T (drives' own).

    Then random rates of the closure too: A du = y, with drives that move as before.
    """
    poses, units = model.poses(q), np.eye(len(q))
    struck = rng.normal(size=poses.shape)
    moved = [maximal.centre_velocities(sketch.system, poses, model.velocities(q, unit)) for unit in units]
    f = np.array([float(np.sum(struck * centres)) for centres in moved])
    still = np.zeros(len(model.rows))
    du, inside, outcomes = model.kernels.impulse(q[None], f[None], still[None])
    assert outcomes == ["done"]
    frames, efforts = sliding.jump(sketch.system, sketch.slots, poses, struck, sketch.prescribed)
    scale = max(float(np.max(np.abs(frames))), 1.0)
    assert np.max(np.abs(model.velocities(q, du[0]) - frames)) <= BOUND * scale
    order = [sketch.driven.index(model.joints.index(drive["joint"])) for drive in model.data["drives"]]
    taken = drive_rows(model).T @ efforts[order].astype(float) + model.jacobian(q).T @ inside[0]
    momentum = model.kernels.of_state("momentum", q[None], du)[0]
    force = max(float(np.max(np.abs(x), initial=1.0)) for x in (f, taken, momentum))
    assert np.max(np.abs(momentum - f - taken)) <= BOUND * force * 10.0
    wanted = rng.normal(size=len(model.rows))
    (du,), _, outcomes = model.kernels.impulse(q[None], f[None], wanted[None])
    assert outcomes == ["done"]
    size = max(1.0, float(np.max(np.abs(du))))
    assert np.max(np.abs(model.jacobian(q) @ du - wanted), initial=0.0) <= BOUND * size
    assert np.max(np.abs(drive_rows(model) @ du), initial=0.0) <= BOUND * size


DRAWN = settings(
    derandomize=True,
    deadline=None,
    database=None,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture, HealthCheck.data_too_large],
)


@settings(DRAWN, max_examples=FEW)
@given(sketch=sketches())
def test_a_few_random_mechanisms_are_those_of_the_dense_reference(sketch: Sketch, workshop: Workshop) -> None:
    check(sketch, workshop)


@pytest.mark.hard
@settings(DRAWN, max_examples=EXAMPLES)
@given(sketch=sketches())
def test_random_mechanisms_are_those_of_the_dense_reference(sketch: Sketch, workshop: Workshop) -> None:
    check(sketch, workshop)


@settings(DRAWN, max_examples=FEW)
@given(sketch=sketches(meshes=True))
def test_a_few_random_gears_are_those_of_the_dense_reference(sketch: Sketch, workshop: Workshop) -> None:
    check(sketch, workshop)


@pytest.mark.hard
@settings(DRAWN, max_examples=EXAMPLES)
@given(sketch=sketches(meshes=True))
def test_random_gears_are_those_of_the_dense_reference(sketch: Sketch, workshop: Workshop) -> None:
    check(sketch, workshop)
