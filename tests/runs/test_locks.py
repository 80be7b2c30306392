"""Joints that take hold or let go beside others of the same links at the same points: locks of hinges and of slides.

What holds is held against scenes in which it is one link, what does not against scenes without the lock."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from ccgen.runtime import sensitivities, simulate

from ..support.workshop import Workshop

LOCKED = """
name = "locked"
[ground_link]
points = { O = [0, 0] }
[[link]]
name = "a"
mass = 1.3
inertia = 0.1
com = [0.4, 0]
points = { A = [0, 0], B = [1, 0] }
[[link]]
name = "b"
mass = 1.5
inertia = 0.2
com = [0.5, 0]
points = { B = [0, 0], E = [0.8, 0] }
[[joint]]
name = "p"
between = ["ground.O", "a.A"]
JOINTS
[start]
START
[gravity]
[run]
until = 0.5
"""
PIN = '[[joint]]\nname = "k"\nbetween = ["a.B", "b.B"]\n'
SLIDE = '[[joint]]\nname = "k"\ntype = "prismatic"\nbetween = ["a.B", "b.B"]\naxis = [1, 0]\n'
LOCK = '[[joint]]\nname = "x"\ntype = "weld"\nbetween = ["a.B", "b.B"]\n'
RELEASE = '[[release]]\njoint = "x"\nat = 0.2\n'
HOLD = '[[hold]]\njoint = "x"\nat = 0.2\nwithin = 2\n'
HINGE = "angles = { a = 0.5, b = 0.5 }"
KINDS = {"hinge": (PIN, HINGE, "angles = { a = 0.5, b = 0.2 }")}
KINDS["slide"] = (SLIDE, "angles = { a = 0.5 }\nslides = { k = 0 }", "angles = { a = 0.5 }\nslides = { k = 0.1 }")


def scene(joints: str, start: str) -> str:
    return LOCKED.replace("JOINTS", joints).replace("START", start)


def tip(run: Any, t: float) -> Any:
    point = run.point("b.E", [t])
    return np.hstack([point.position, point.velocity])


@pytest.mark.parametrize("fold", [False, True])
@pytest.mark.parametrize("kind", KINDS)
def test_a_lock_that_lets_go_has_held_the_links_as_one(kind: str, fold: bool, workshop: Workshop) -> None:
    joint, start, _ = KINDS[kind]
    run = simulate(workshop.model(scene(joint + LOCK + RELEASE, start), fold=fold), rtol=1e-11)
    one = simulate(workshop.model(scene(LOCK, "angles = { a = 0.5 }")), rtol=1e-11)
    assert run.success and tip(run, 0.19) == pytest.approx(tip(one, 0.19), abs=1e-9)
    assert abs(run.energy_drift) < 1e-9
    free = workshop.model(scene(joint, start))
    order = [run.model.q_of.index(name) for name in free.q_of]
    q, u = (state[0][order] for state in run.at([0.2]))
    goes_on = simulate(free, q0=q, u0=u, until=0.3, rtol=1e-11)
    assert tip(run, 0.5) == pytest.approx(tip(goes_on, 0.3), abs=1e-8)


@pytest.mark.parametrize("kind", KINDS)
def test_a_lock_that_takes_hold_keeps_links_together(kind: str, workshop: Workshop) -> None:
    """Both then turn at one rate, and the moment of momentum about the ground's pin is kept by the impact."""
    joint, _, start = KINDS[kind]
    run = simulate(workshop.model(scene(joint + LOCK + HOLD, start)), rtol=1e-11)
    (change,) = run.changes
    assert run.success and change.kind == "hold" and change.gap > 0.01
    spun = run.values("a.angular_velocity", "b.angular_velocity", t=[0.3, 0.5])
    assert spun["a.angular_velocity"] == pytest.approx(spun["b.angular_velocity"], abs=1e-10)
    apart = run.point("a.B", [0.3, 0.5]).position - run.point("b.B", [0.3, 0.5]).position
    assert np.abs(apart).max() < 1e-10


def test_the_lock_of_a_hinge_has_derivatives(workshop: Workshop) -> None:
    model = workshop.model(scene(PIN + LOCK + RELEASE, HINGE), derivatives=True)
    found = sensitivities(model, ["a.mass"], ["b.E.y"], rtol=1e-12)["b.E.y"]

    def height(step: float) -> float:
        moved = model.with_parameters({"a.mass": 1.3 + step})
        return float(simulate(moved, rtol=1e-13).point("b.E", [0.5]).position[0, 1])

    step = 1e-2
    slopes = [(height(k * step) - height(-k * step)) / (2 * k * step) for k in (1, 2)]
    assert np.ravel(found)[0] == pytest.approx((4 * slopes[0] - slopes[1]) / 3, rel=1e-6)
