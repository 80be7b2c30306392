"""Surfaces so thin that bodies would go through them are refused."""

from __future__ import annotations

import re

import pytest

from ccgen.generator.scene import SceneError
from ccgen.runtime import simulate

from ..support.workshop import Workshop


def box_on_plank(radius: float, scale: float = 1.0) -> str:
    """A box that stands a hundredth of the radius above a plank on a rail, both round by ``radius``"""
    half, side, high = 0.5 * scale, 0.1 * scale, 0.8 * scale
    return f"""
name = "thin"
[ground_link]
points = {{ O = [0, 0] }}
[[link]]
name = "plank"
mass = 10.0
inertia = 1.0
com = [0, 0]
points = {{ C = [0, 0], A = [{-half}, 0], B = [{half}, 0] }}
[[joint]]
name = "rail"
type = "prismatic"
between = ["ground.O", "plank.C"]
axis = [1, 0]
[[link]]
name = "box"
free = true
plate = {{ mass = 1.0, corners = ["P", "Q", "R", "S"] }}
points = {{ P = [{-side}, 0], Q = [{side}, 0], R = [{side}, {high}], S = [{-side}, {high}] }}
[[touch]]
between = [["box.P", "box.Q", "box.R", "box.S", "box.P"], ["plank.A", "plank.B"]]
radius = {radius!r}
restitution = 0
[start]
poses = {{ box = [0, {1.01 * radius!r}, 0] }}
[gravity]
[run]
until = 0.2
"""


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
def test_a_touch_thinner_than_contacts_are_found_is_refused(scale: float, workshop: Workshop) -> None:
    with pytest.raises(
        SceneError, match=r"touch\[0\]\.radius: found radii with the sum \S+ m, expected at least"
    ) as told:
        workshop.scene(box_on_plank(1e-8 * scale, scale))
    least = float(re.findall(r"expected at least (\S+) m", str(told.value))[0])
    assert least == pytest.approx(1e-6 * scale * (0.1**2 + 0.8**2) ** 0.5, rel=1e-5)


@pytest.mark.parametrize("radius", [1e-6, 1e-4])
def test_what_is_not_refused_holds(radius: float, workshop: Workshop) -> None:
    run = simulate(workshop.model(box_on_plank(radius)))
    assert run.success, run.message
    assert run.q[-1][3] == pytest.approx(radius, abs=1e-9)
