"""Links that no joint holds, beside others that are held: ``free = true``."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from ccgen.generator.scene import SceneError, load_scene
from ccgen.runtime import simulate

from ..support.workshop import Workshop

ARM: dict[str, Any] = {
    "name": "arm",
    "ground_link": {"points": {"O": [0, 0]}},
    "link": [{"name": "arm", "rod": {"mass": 3}, "points": {"A": [0, 0], "B": [1, 0]}}],
    "joint": [{"name": "axle", "between": ["ground.O", "arm.A"]}],
    "gravity": {},
}
BALL: dict[str, Any] = {"name": "ball", "disc": {"mass": 0.5, "radius": 0.05}, "points": {"C": [0, 0]}}
FREE = BALL | {"free": True}
TOUCH = {"between": ["ball.C", ["arm.A", "arm.B"]], "radius": [0.05, 0], "restitution": 0.6, "friction": 0.3}
START = {"angles": {"arm": 0.2}, "poses": {"ball": [0.6, 0.6, 0.1]}, "sliding_velocities": {"ball_y": -5.0}}


def by_hand() -> dict[str, Any]:
    """The arm and the ball, with carriages as a scene can write them out."""
    nothing = {"mass": 0, "inertia": 0, "com": [0, 0], "points": {"P": [0, 0]}}
    joints = [
        {"name": "ball_x", "type": "prismatic", "between": ["ground.O", "across.P"], "axis": [1, 0]},
        {"name": "ball_y", "type": "pin-in-slot", "between": ["across.P", "ball.C"], "axis": [0, 1]},
    ]
    return ARM | {
        "link": [*ARM["link"], BALL, {"name": "across", **nothing}],
        "joint": [*ARM["joint"], *joints],
        "touch": [TOUCH],
        "start": START | {"poses": {}, "angles": {"arm": 0.2, "ball": 0.1}, "slides": {"ball_x": 0.6, "ball_y": 0.6}},
    }


def test_a_free_link_moves_as_one_on_carriages(workshop: Workshop) -> None:
    """The same rows, of which the last are after an impact on the arm: by the same equations, so to rounding."""
    scene = load_scene(ARM | {"link": [*ARM["link"], FREE], "touch": [TOUCH], "start": START})
    free, hand = (simulate(workshop.model(one), until=0.8, rtol=1e-10) for one in (scene, load_scene(by_hand())))
    assert free.success and len(free.impacts) == len(hand.impacts) == 1
    at = np.linspace(0.0, 0.8, 20)
    (q, u), (p, v) = free.at(at), hand.at(at)
    for joint in ("arm", "ball"):
        number = free.model.links.index(joint)
        np.testing.assert_allclose(free.model.poses(q)[:, number], hand.model.poses(p)[:, number], atol=1e-9)
    assert set(free.model.contacts) == set(hand.model.contacts)
    assert u.shape == v.shape


def test_two_free_balls_exchange_their_velocities(workshop: Workshop) -> None:
    """No joint at all: equal elastic balls that meet head-on, as Newton has it."""
    balls = [FREE | {"name": name} for name in ("a", "b")]
    touch = {"between": ["a.C", "b.C"], "radius": 0.05, "restitution": 1}
    start = {"poses": {"a": [0, 1, 0], "b": [1, 1, 0]}, "sliding_velocities": {"a_x": 2.0, "b_x": -1.0}}
    run = simulate(workshop.model(load_scene({"link": balls, "touch": [touch], "start": start})), until=0.5)
    assert [impact.t for impact in run.impacts] == pytest.approx([0.3], abs=1e-12)
    speeds = run.model.velocities(run.q, run.u)[-1, :2, 0]
    np.testing.assert_allclose(speeds, [-1.0, 2.0], atol=1e-12)


def test_what_hangs_on_a_free_link_is_free(workshop: Workshop) -> None:
    """A pair of hinged rods beside the arm: its mass centre falls as a point does, whatever the rods do."""
    rods = [
        {"name": name, "rod": {"mass": 1}, "points": {"A": [0, 0], "B": [1, 0]}, "free": name == "second"}
        for name in ("first", "second")
    ]
    knee = {"name": "knee", "between": ["first.B", "second.A"]}
    start = {"poses": {"first": [2, 1, 0], "second": [3, 1, 0.5]}, "angular_velocities": {"second": 3.0}}
    links, joints = [*ARM["link"], *rods], [*ARM["joint"], knee]
    scene = load_scene(ARM | {"link": links, "joint": joints, "start": start})
    run = simulate(workshop.model(scene), until=1.0, rtol=1e-10)
    poses = run.model.poses(run.q)[:, 1:3]
    middle = (poses[..., :2] + 0.5 * np.stack([np.cos(poses[..., 2]), np.sin(poses[..., 2])], axis=-1)).mean(axis=1)
    speed = 0.5 * 0.5 * 3.0 * np.array([-np.sin(0.5), np.cos(0.5)])
    fallen = middle[0] + run.t[:, None] * speed + 0.5 * run.t[:, None] ** 2 * np.array([0.0, -9.81])
    np.testing.assert_allclose(middle, fallen, atol=1e-8)


def test_a_link_that_is_not_said_to_be_free_is_a_fault() -> None:
    """A joint may have been forgotten: the fault says both remedies."""
    with pytest.raises(SceneError) as caught:
        load_scene(ARM | {"link": [*ARM["link"], BALL]})
    fault = str(caught.value)
    assert (
        "link[1]: found no joints that connect ball with the ground, expected one piece; add a [[joint]], or " in fault
    )
    assert "free = true to a [[link]] that moves freely" in fault


def test_free_says_nothing_of_a_link_that_is_held_or_alone(workshop: Workshop) -> None:
    """A link that a joint holds, and a body that is alone, are what they are without it."""
    held = load_scene(ARM | {"link": [ARM["link"][0] | {"free": True}]})
    assert held == load_scene(ARM)
    alone = load_scene({"name": "ball", "link": [FREE]})
    assert alone == load_scene({"name": "ball", "link": [BALL]})
