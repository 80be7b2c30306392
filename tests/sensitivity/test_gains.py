"""Impacts with as much of their restitution as gains no energy: derivatives of their runs."""

from __future__ import annotations

from typing import Any

import numpy as np

from ccgen.runtime import sensitivities, simulate

from ..support.workshop import Workshop

KANE = """name = "kane"
[ground_link]
points = { O = [0, 0] }
[[link]]
name = "r0"
rod = { mass = 1 }
points = { A = [0, 0], B = [1, 0] }
[[link]]
name = "r1"
rod = { mass = 1 }
points = { A = [0, 0], B = [1, 0] }
[[joint]]
between = ["ground.O", "r0.A"]
[[joint]]
between = ["r0.B", "r1.A"]
[gravity]
[[ground]]
point = [0, -1.2]
restitution = 0.7
friction = 0.5
contacts = ["r1.B"]
[start]
angles = [-0.5, -0.5]
"""
"""A double pendulum that strikes the ground (T. R. Kane, Stanford Mechanics Alumni Club Newsletter, 1984)."""

END = 1e-2


def states(model: Any, count: int) -> list[tuple[Any, Any, float]]:
    """States, and heights of a ground which they strike with a part of its restitution."""
    rng, found = np.random.default_rng(0), list[tuple[Any, Any, float]]()
    contact = np.array([0], dtype=np.int32)
    while len(found) < count:
        q, u = rng.uniform(-np.pi, np.pi, 2), rng.normal(size=2) * 4
        if model.kernels.impact(q, u, contact, np.array([0.7]))[2] != "gained":
            continue
        height = float(np.sin(q).sum()) - 1e-3
        impacts = simulate(model.with_parameters({"ground_0.point.y": height}), q, u, until=END).impacts
        if len(impacts) == 1 and 0.01 < impacts[0].restitution_share < 0.99:
            found.append((q, u, height))
    return found


def test_no_energy_is_gained_whatever_moves(workshop: Workshop) -> None:
    """What is conserved: along all directions energy stays what it was. And by friction, beside runs of other friction,
    whose impacts have their share to 1e-9."""
    model = workshop.model(KANE, derivatives=True)
    for q, u, height in states(model, 5):
        one = model.with_parameters({"ground_0.point.y": height})
        wrt = ("q0", "u0", "ground_0.friction", "ground_0.restitution")
        names = ["kinetic_energy", "potential_energy"]
        found = sensitivities(one, wrt, names, q, u, at=[0.0, END], until=END, rtol=1e-12)
        total = found["kinetic_energy"] + found["potential_energy"]
        np.testing.assert_allclose(total[1], total[0], atol=1e-8 * np.max(np.abs(total)))
        ends = sensitivities(one, wrt, "u", q, u, until=END, rtol=1e-12)["u"]
        h = 1e-3
        beside = [
            simulate(one, q, u, until=END, rtol=1e-12, params={"ground_0.friction": 0.5 + s}).u[-1] for s in (h, -h)
        ]
        np.testing.assert_allclose(ends[:, 4], (beside[0] - beside[1]) / (2 * h), atol=1e-4 * np.max(np.abs(ends)))
        np.testing.assert_allclose(ends[:, 5], 0.0, atol=1e-8 * np.max(np.abs(ends)))  # another part of more of it
