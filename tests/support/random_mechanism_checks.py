"""How forces and accelerations of random mechanisms are compared with the dense reference."""

from __future__ import annotations

import functools
import os
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, settings

from ccgen.runtime.model.drives import drive_rows

from ..oracles import maximal, sliding
from ..oracles.maximal import GROUND, Array
from ..oracles.random_mechanisms import Sketch
from .tiers import LARGE

EXAMPLES = int(os.environ.get("CCGEN_MECHANISMS", "50"))
FEW = 10
"""As many are drawn in ``make test``."""
BOUND = 1e-10
"""Relative error of accelerations, joint forces and inverse dynamics."""
DRAWN = settings(
    derandomize=True,
    deadline=None,
    database=None,
    phases=(Phase.explicit, Phase.generate),  # what fails is compiled: shrinking it takes longer than all tests
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture, HealthCheck.data_too_large],
)


def first(usual: int) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Checks the first ``usual`` mechanisms of those that a test draws, and all with ``CCGEN_LARGE=1`` or where
    ``CCGEN_MECHANISMS`` says how many. What is drawn depends on how many are asked for: so all are drawn."""

    def of(check: Callable[..., None]) -> Callable[..., None]:
        seen = set[str]()

        @functools.wraps(check)
        def checked(**drawn: Any) -> None:
            text = "".join(_text(one) for name, one in drawn.items() if name != "workshop")
            if LARGE or "CCGEN_MECHANISMS" in os.environ or text in seen or len(seen) < usual:
                seen.add(text)  # one that fails is asked for again
                check(**drawn)

        return checked

    return of


def _text(drawn: Any) -> str:
    if isinstance(drawn, Sketch):
        return drawn.toml("drawn")
    return str(drawn.toml() if hasattr(drawn, "toml") else drawn)


def quasi_accelerations(model: Any, poses: Array, velocities: Array, frames: Array) -> Array:
    """The reference's accelerations of the frames as quasi-accelerations: rates of the quasi-velocities' own rates."""
    found = []
    for kind, of in model.data["coordinates"]:
        if kind == "slide":
            found.append(_sliding_acceleration(model, of, poses, velocities, frames))
        else:
            found.append(frames[of, ("x", "y", "angle").index(kind)])
    return np.array(found, dtype=float)


def _sliding_acceleration(model: Any, joint: str, poses: Array, velocities: Array, frames: Array) -> float:
    """d/dt of d·(b' − a' − ω (b − a)⊥) = d·(b'' − a'' − α (b − a)⊥ − ω (b' − a')⊥) + ω d⊥·(b' − a' − ω (b − a)⊥)."""
    line = model.data["lines"][joint]
    (a, b), axis = line["links"], model.parameters[line["axis"]] if isinstance(line["axis"], str) else line["axis"]
    ends = []
    for link, point in zip((a, b), line["points"], strict=True):
        on = [model.parameters[c] if isinstance(c, str) else c for c in point]
        if link == GROUND:
            ends.append((np.array(on), np.zeros(2), np.zeros(2)))
            continue
        arm = maximal.turned(np.asarray(poses[link, 2], float), on)
        turn, spin = np.array([-arm[1], arm[0]]), float(velocities[link, 2])
        ends.append(
            (
                poses[link, :2].astype(float) + arm,
                velocities[link, :2].astype(float) + spin * turn,
                frames[link, :2].astype(float) + float(frames[link, 2]) * turn - spin**2 * arm,
            )
        )
    (pa, va, aa), (pb, vb, ab) = ends
    own = 0.0 if a == GROUND else float(poses[a, 2])
    omega, alpha = (0.0, 0.0) if a == GROUND else (float(velocities[a, 2]), float(frames[a, 2]))
    d = np.array([np.cos(own + axis), np.sin(own + axis)])

    def perp(v: Array) -> Array:
        return np.array([-v[1], v[0]])

    seen = vb - va - omega * perp(pb - pa)
    return float(d @ (ab - aa - alpha * perp(pb - pa) - omega * perp(vb - va)) + omega * perp(d) @ seen)


def check_forces(
    model: Any,
    sketch: Sketch,
    q: Array,
    u: Array,
    motion: sliding.Motion,
    contacts: dict[Any, str] | tuple[()] | None = None,
) -> None:
    """Joint forces on the second links, moments about the later links' points, under ``contacts`` held as said."""
    reactions, scale = model.reactions(q, u, contacts=contacts), 1.0
    scale = max(np.max(np.abs(motion.pins), initial=1.0), np.max(np.abs(motion.slots), initial=1.0))
    for joint, (kind, index) in enumerate(sketch.kinds):
        ends = sketch.pins[index] if kind == "pin" else sketch.slots[index]
        force = (motion.pins if kind == "pin" else motion.slots)[index]
        if joint not in sketch.driven or kind == "pin":
            assert np.max(np.abs(reactions[joint, :2] - force[:2])) <= BOUND * scale * 10.0
        driven = joint in sketch.driven
        if driven and kind == "slot":
            continue  # its force along the line is in the oracle's effort
        if driven:
            assert abs(reactions[joint, 2] - motion.efforts[sketch.driven.index(joint)]) <= BOUND * scale * 10.0
        elif kind == "slot" and sketch.slots[index].angle is not None and model.joints[joint] not in model.cuts:
            moment = force[2] + (_about_the_first(model, ends, q, force) if ends.a > ends.b else 0.0)
            assert abs(reactions[joint, 2] - moment) <= BOUND * scale * 10.0
        else:
            assert reactions[joint, 2] == 0.0


def _about_the_first(model: Any, slot: sliding.Slot, q: Array, force: Array) -> float:
    """Moment about the first point of a force at the second point."""
    poses = np.vstack([model.poses(q), np.zeros(3)])  # the ground comes last: index -1
    ends = [poses[k, :2] + maximal.turned(poses[k, 2], on) for k, on in ((slot.a, slot.on_a), (slot.b, slot.on_b))]
    x, y = ends[1] - ends[0]
    return float(x * force[1] - y * force[0])


def check_flight(model: Any, sketch: Sketch, contacts: tuple[()] | None = None) -> None:
    """Accelerations, joint forces, inverse dynamics, energy and impulses at the drawn pose with random velocities;
    ``contacts``: () where none is held."""
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
    found = model.acceleration(q, u, contacts=contacts)
    scale = max(np.max(np.abs(motion.frames)), 1.0)
    assert np.max(np.abs(found - wanted)) <= BOUND * scale
    check_forces(model, sketch, q, u, motion, contacts)
    inverse = model.kernels.inverse_dynamics(q[None], u[None], 0.0, wanted[None])[0]
    loops = model.jacobian(q).T @ model.multipliers(q, u, contacts=contacts) if model.rows else 0.0
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


def unit_rows(model: Any, kernel: str, q: Array) -> Array:
    """The rows of a kernel that is linear in u."""
    unit = np.eye(len(model.u_names))
    return np.asarray(model.kernels.of_state(kernel, np.repeat(q[None], len(unit), axis=0), unit).T)
