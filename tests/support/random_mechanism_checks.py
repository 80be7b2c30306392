"""How forces and accelerations of random mechanisms are compared with the dense reference."""

from __future__ import annotations

import os
from typing import Any

import numpy as np

from ..oracles import maximal, sliding
from ..oracles.maximal import GROUND, Array
from ..oracles.random_mechanisms import Sketch

EXAMPLES = int(os.environ.get("CCGEN_MECHANISMS", "50"))
FEW = 10
"""As many are drawn in ``make test``; all in ``make hard``."""
BOUND = 1e-10
"""Relative error of accelerations, joint forces and inverse dynamics."""


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
    model: Any, sketch: Sketch, q: Array, u: Array, motion: sliding.Motion, contacts: dict[Any, str] | None = None
) -> None:
    """Joint forces under ``contacts`` that are held as said."""
    reactions, scale = model.reactions(q, u, contacts=contacts), 1.0
    scale = max(np.max(np.abs(motion.pins), initial=1.0), np.max(np.abs(motion.slots), initial=1.0))
    for joint, (kind, index) in enumerate(sketch.kinds):
        ends = sketch.pins[index] if kind == "pin" else sketch.slots[index]
        sign = 1.0 if model.outboard[joint] == ("ground" if ends.b == GROUND else f"body_{ends.b}") else -1.0
        force = (motion.pins if kind == "pin" else motion.slots)[index]
        if joint not in sketch.driven or kind == "pin":
            assert np.max(np.abs(reactions[joint, :2] - sign * force[:2])) <= BOUND * scale * 10.0
        driven = joint in sketch.driven
        if driven and kind == "slot":
            continue  # its force along the line is in the oracle's effort
        if driven:
            effort = sign * motion.efforts[sketch.driven.index(joint)]
            assert abs(reactions[joint, 2] - effort) <= BOUND * scale * 10.0
        elif kind == "slot" and sketch.slots[index].angle is not None and model.joints[joint] not in model.cuts:
            moment = sign * force[2] + (_about_the_first(model, ends, q, force) if sign < 0.0 else 0.0)
            assert abs(reactions[joint, 2] - moment) <= BOUND * scale * 10.0
        else:
            assert reactions[joint, 2] == 0.0


def _about_the_first(model: Any, slot: sliding.Slot, q: Array, force: Array) -> float:
    """Moment about the first point of what the joint does to the first link, at the second point."""
    poses = np.vstack([model.poses(q), np.zeros(3)])  # the ground comes last: index -1
    ends = [poses[k, :2] + maximal.turned(poses[k, 2], on) for k, on in ((slot.a, slot.on_a), (slot.b, slot.on_b))]
    x, y = ends[1] - ends[0]
    return float(-(x * force[1] - y * force[0]))
