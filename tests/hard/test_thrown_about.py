"""Balls and boxes that a wheel of random teeth throws about a closed room: nothing passes through anything.

Steps of a free body are long, and it is thrown across the room within a piece of one. Where bodies are is told by plain
geometry.
"""

from __future__ import annotations

import os
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from ccgen.generator import load_scene
from ccgen.runtime import simulate

from ..support.tiers import many
from ..support.workshop import Workshop

pytestmark = pytest.mark.hard
MACHINES = int(os.environ.get("CCGEN_THROWN", many(1, 6)))
WIDE, HIGH = 0.7, 0.6
BALL, SKIN = 0.05, 0.002
BOX = {"A": [-0.1, -0.06], "B": [0.1, -0.06], "C": [0.1, 0.06], "D": [-0.1, 0.06]}
ROOM = {"W0": [-WIDE, HIGH], "W1": [-WIDE, -HIGH], "W2": [WIDE, -HIGH], "W3": [WIDE, HIGH]}


def machine(rng: np.random.Generator, kind: str) -> dict[str, Any]:
    """A wheel in the middle of a room, and a ball or a box that is free."""
    count = int(rng.integers(3, 9))
    teeth: dict[str, list[float]] = {"T": [float(rng.uniform(0.2, 0.3)), 0.0]}
    if rng.random() < 0.5:
        teeth["R"] = [float(rng.uniform(0.1, 0.2)), float(rng.uniform(0.1, 0.9) * 2 * np.pi / count)]
    wheel = {
        "name": "wheel",
        "mass": float(rng.uniform(0.5, 3)),
        "inertia": 0.03,
        "com": [0, 0],
        "points": {"O": [0, 0]},
        "around": {"count": count, "points": teeth},
    }
    law = {"restitution": float(rng.choice([0, 0.3, 0.7]))} | ({"friction": 0.3} if rng.random() < 0.5 else {})
    if kind == "ball":
        thrown = {"name": kind, "disc": {"mass": 0.5, "radius": BALL}, "points": {"C": [0, 0]}, "free": True}
        walls = [[f"ground.W{k}", f"ground.W{(k + 1) % 4}"] for k in range(4)]
        sides, radii = ["ball.C"] * 5, [BALL, 0]
    else:
        thrown = {"name": kind, "plate": {"mass": 1.0}, "points": BOX, "outline": [*BOX], "free": True}
        walls = [["ground.W0", "ground.W1", "ground.W2"], ["ground.W2", "ground.W3", "ground.W0"]]
        sides, radii = ["box"] * 3, [SKIN, SKIN]
    touches = [
        {"between": [side, other], "radius": radii, **law} for side, other in zip(sides, ("wheel", *walls), strict=True)
    ]
    return {
        "name": "thrown",
        "ground_link": {"points": {"O": [0, 0], **ROOM}},
        "link": [wheel, thrown],
        "joint": [{"name": "axle", "between": ["ground.O", "wheel.O"]}],
        "touch": touches,
        "gravity": {},
        "start": {"poses": {kind: [0.0, 0.45, 0.3]}, "angles": {"wheel": 0.1}},
    }


def depth(ring: NDArray[np.complex128], places: NDArray[np.complex128]) -> float:
    """How far the deepest of the places is inside a polygon (m), negative where all are outside: by the angles at which
    its edges are seen, and the distances from these."""
    after, seen = np.roll(ring, -1), ring - places[:, None]
    inside = np.abs(np.sum(np.angle(np.roll(seen, -1, axis=1) / seen), axis=1)) > np.pi
    share = np.clip(((places[:, None] - ring) / (after - ring)).real, 0.0, 1.0)
    away = np.min(np.abs(ring + share * (after - ring) - places[:, None]), axis=1)
    return float(np.max(np.where(inside, away, -away)))


@pytest.mark.parametrize("number", range(MACHINES))
def test_nothing_passes_through_anything(number: int, workshop: Workshop) -> None:
    rng = np.random.default_rng([7, number])
    kind = ("ball", "box")[number % 2]
    scene = load_scene(machine(rng, kind))
    model = workshop.model(scene)
    link = scene.mechanism.links[0]
    ring = np.array([complex(*link.points[str(name)].values()) for name in scene.mechanism.outlines["wheel"]])
    room = np.array([complex(*place) for place in ROOM.values()])
    corners = np.array([0.0] if kind == "ball" else [complex(*place) for place in BOX.values()])
    skin = BALL if kind == "ball" else 2 * SKIN
    for _ in range(12):
        q, u = model.start()
        q[0] += rng.uniform(0, 6)
        u[:] = rng.normal(size=len(u)) * np.array([10 ** rng.uniform(0, 2), 2.0, 2.0, 2.0])
        run = simulate(model, q0=q, u0=u, until=3.0)
        assert run.success and run.energy_drift < 1e-7
        poses = model.poses(run.at(np.linspace(0.0, 3.0, 400))[0])
        turned, body = poses[:, model.links.index("wheel"), 2], poses[:, model.links.index(kind)]
        for angle, (x, y, own_angle) in zip(turned, body, strict=True):
            places = complex(x, y) + np.exp(1j * own_angle) * corners
            assert depth(ring, places * np.exp(-1j * angle)) < 1e-8 - skin
            assert depth(room, places) > skin - 1e-8
