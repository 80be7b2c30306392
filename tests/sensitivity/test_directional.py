"""Derivatives along one direction, where contacts strike together that it parts: a chair's two feet."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from ccgen.runtime import directional, sensitivities, simulate

from ..support.workshop import Workshop

CHAIR = """
name = "chair"
[[link]]
name = "body"
mass = 2.0
inertia = 0.3
com = {com}
points = {{ A = [-0.6, 0], B = [0.6, 0] }}
[start]
position = [0, 1]
velocity = [0.7, 0]
angles = {{ body = 0.0 }}
[gravity]
g = 9.81
[[ground]]
restitution = {restitution}
{friction}
contacts = ["body.A", "body.B"]
[run]
until = 0.6
rtol = 1e-13
"""
FALL = math.sqrt(2 / 9.81)
ANGLE = np.array([0.0, 0.0, 1.0])
MIXED = np.array([0.3, 0.5, -1.0]), np.array([0.2, 0.1, 0.4])


def chair(workshop: Workshop, com: str, friction: float, restitution: float = 0.0) -> Any:
    rough = f"friction = {friction}" if friction else ""
    return workshop.model(CHAIR.format(com=com, restitution=restitution, friction=rough), derivatives=True)


@pytest.fixture(scope="module")
def sticky(workshop: Workshop) -> Any:
    """It stands where its first foot touches."""
    return chair(workshop, "[0.1, 0.3]", 0.9)


def along(model: Any, q: Any, u: Any) -> Any:
    """The derivative (2 n,) of the end of its run."""
    found = directional(model, {"q0": q, "u0": u})
    return np.concatenate([found["q"][:, 0], found["u"][:, 0]])


def difference(model: Any, q: Any, u: Any) -> Any:
    """By one-sided differences of two steps (L. F. Richardson)."""
    own, ends = model.start(), []
    for h in (0.0, 1e-4, 2e-4):
        run = simulate(model, own[0] + h * np.asarray(q), own[1] + h * np.asarray(u))
        ends.append(np.concatenate([run.q[-1], run.u[-1]]))
    near, far = (ends[1] - ends[0]) / 1e-4, (ends[2] - ends[0]) / 2e-4
    return 2 * near - far


def test_a_chair_that_stands_where_its_first_foot_touches(sticky: Any) -> None:
    """Whichever foot is lower it touches earlier by its height by the speed of falling, and the chair stays there: what
    it has flown until then changes by the size of the angle. No matrix does that."""
    with pytest.raises(ValueError, match="strike together at"):
        sensitivities(sticky, "q0")
    less = -0.6 / (9.81 * FALL) * 0.7
    for angle in (1.0, -1.0, 2.5):
        found = along(sticky, angle * ANGLE, [0.0, 0.0, 0.0])
        assert found == pytest.approx([abs(angle) * less, 0.0, 0.0, 0.0, 0.0, 0.0], abs=1e-9)
    # spin makes an angle while it falls; a lift delays both feet
    found = along(sticky, [0.0, 0.0, 0.0], [0.0, 0.1, -0.4])
    assert found[0] == pytest.approx(0.4 * FALL * less + 0.7 * 0.1 / 9.81, abs=1e-9)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_chair_that_stands_beside_differences(sign: float, sticky: Any) -> None:
    q, u = (sign * part for part in MIXED)
    assert along(sticky, q, u) == pytest.approx(difference(sticky, q, u), abs=2e-7)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_smooth_chair_beside_differences(sign: float, workshop: Workshop) -> None:
    """Without friction its mass centre flies on, whichever foot comes first."""
    model = chair(workshop, "[0, 0.3]", 0.0)
    q, u = (sign * part for part in MIXED)
    found = along(model, q, u)
    assert found == pytest.approx(difference(model, q, u), abs=2e-7)
    assert found[0] == pytest.approx(sign * (0.3 + 0.3 + 0.6 * (0.2 - 0.3 * 0.4)), abs=1e-9)


def test_what_slides_jumps_to_one_side_alone(workshop: Workshop) -> None:
    """Sliding, it comes down on its front foot first to the same end, on its rear foot to another one: there a run is
    not continuous."""
    model = chair(workshop, "[0.1, 0.3]", 0.05)
    own = model.start()
    assert along(model, -ANGLE, np.zeros(3)) == pytest.approx(difference(model, -ANGLE, np.zeros(3)), abs=2e-7)
    with pytest.raises(ValueError, match=r"A on ground_0, then body\.B on ground_0: that ends with rates that differ"):
        along(model, ANGLE, np.zeros(3))
    level = simulate(model, *own).u[-1]
    jumps = [np.abs(simulate(model, own[0] + h * ANGLE, own[1]).u[-1] - level).max() for h in (1e-5, 1e-7)]
    assert min(jumps) > 1e-3 and jumps[0] == pytest.approx(jumps[1], rel=1e-2)


def test_a_foot_that_lifts_between_two_strikes(workshop: Workshop) -> None:
    """A high chair turns about its first foot so fast that this leaves the ground, and strikes again: the order that is
    told, and by how much it jumps, are those of runs beside it."""
    model = chair(workshop, "[0.1, 0.6]", 0.05)
    with pytest.raises(ValueError, match="which jumps here") as caught:
        along(model, ANGLE, np.zeros(3))
    told = "body.A on ground_0, then body.B on ground_0, then body.A on ground_0: that ends with rates that differ by "
    assert told in str(caught.value)
    q, u = model.start()
    beside = simulate(model, q + 1e-6 * ANGLE, u).impacts
    assert [impact.contacts[0][0] for impact in beside] == ["body.A", "body.B", "body.A"]
    jump = float(np.abs(beside[-1].u_plus - simulate(model, q, u).impacts[-1].u_plus).max())
    assert float(str(caught.value).partition(told)[2].split()[0]) == pytest.approx(jump, rel=5e-3)


def test_bounces_one_after_the_other_end_otherwise_than_together(workshop: Workshop) -> None:
    model = chair(workshop, "[0, 0.3]", 0.0, 0.4)
    with pytest.raises(ValueError, match="which jumps here; there is no derivative"):
        along(model, ANGLE, np.zeros(3))


def test_where_there_is_a_matrix_it_is_a_column_of_it(sticky: Any) -> None:
    """By its height both feet come later."""
    high = np.array([0.0, 1.0, 0.0])
    found = directional(sticky, {"q0": high, "gravity.g": 2.0}, ["body.A.x"])
    by = {"q0": high[:, None], "gravity.g": [2.0]}
    assert found["body.A.x"] == pytest.approx(sensitivities(sticky, by, ["body.A.x"])["body.A.x"], abs=1e-14)
    assert abs(found["body.A.x"][0]) > 1e-3


@pytest.mark.parametrize(
    ("direction", "said"),
    [
        ({"q0": np.eye(3)}, r"direction: q0: found shape \(3, 3\), expected finite numbers of shape \(3,\)"),
        ({"q0": [0.0, 1.0]}, r"direction: q0: found shape \(2,\), expected finite"),
        ({"q0": [0.0, np.nan, 1.0]}, "direction: q0: found what is no finite number"),
        ({"gravity.g": "1"}, "direction: gravity.g: found '1', expected numbers"),
        (
            {"gravity.g": [1.0, 2.0]},
            r"direction: gravity\.g: found shape \(2,\), expected finite numbers of shape \(\)",
        ),
        ("q0", "direction: found str, expected a mapping"),
    ],
)
def test_what_is_no_direction_is_refused(direction: Any, said: str, sticky: Any) -> None:
    with pytest.raises((TypeError, ValueError), match=said):
        directional(sticky, direction)


def test_times_of_impacts_are_no_outputs(sticky: Any) -> None:
    with pytest.raises(ValueError, match="found impact_times, expected others"):
        directional(sticky, {"q0": ANGLE}, "impact_times")
    with pytest.raises(TypeError, match="expected a Model"):
        directional(None, {"q0": ANGLE})  # type: ignore[arg-type]
