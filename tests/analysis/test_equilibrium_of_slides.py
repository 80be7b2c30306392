"""Equilibria under forces along the lines of sliding joints: positions and joint forces by hand."""

from __future__ import annotations

import numpy as np
import pytest

from ccgen.runtime import static_equilibrium

from ..support.workshop import Workshop

MASS, STIFFNESS, G = 2.0, 80.0, 9.81
SLOPE = np.radians(25)
ALONG = np.array([np.cos(SLOPE), np.sin(SLOPE)])

CART = """\
name = "cart"
[ground_link]
points = {{ O = [0, 0] }}
[[link]]
name = "cart"
mass = {mass}
inertia = 0.1
com = [0, 0]
points = {{ A = [0, 0] }}
[[link]]
name = "bob"
mass = 0.5
inertia = 0.02
com = [0.3, 0]
points = {{ A = [0, 0] }}
[[joint]]
name = "rail"
type = "prismatic"
axis = "25 deg"
between = {between}
[[joint]]
name = "pin"
between = ["cart.A", "bob.A"]
[start]
slides = {{ rail = {slide} }}
angles = {{ cart = 0.0, bob = "-80 deg" }}
[[spring]]
between = ["ground.O", "cart.A"]
stiffness = {stiffness}
length = 0.5
[gravity]
g = 9.81
"""


@pytest.mark.parametrize("push", [0.0, 20.0])
@pytest.mark.parametrize("turned", [False, True])
def test_a_force_along_a_line_is_no_reaction(push: float, turned: bool, workshop: Workshop) -> None:
    """A cart on a slope with a bob under it: spring, weight and push balance along the slope; the rail gives what is
    across, and the weight of both is off the rail's point by nothing, so that it needs no moment."""
    between = '["cart.A", "ground.O"]' if turned else '["ground.O", "cart.A"]'
    text = CART.format(mass=MASS, between=between, stiffness=STIFFNESS, slide=-0.6 if turned else 0.6)
    model = workshop.model(text)
    found = static_equilibrium(model, torques={"rail": -push if turned else push})
    place = model.poses(found.q)[0, :2]
    weight = (MASS + 0.5) * G
    stretch = (push - weight * np.sin(SLOPE)) / STIFFNESS
    assert place == pytest.approx((0.5 + stretch) * ALONG, abs=1e-8)
    assert found.stability == "stable"
    across = np.array([-ALONG[1], ALONG[0]])
    sign = -1.0 if turned else 1.0  # on the second link
    assert sign * found.reactions[0, :2] == pytest.approx(weight * np.cos(SLOPE) * across, abs=1e-6)
    assert abs(found.reactions[0, 2]) <= 1e-6
    assert found.reactions[1, :2] == pytest.approx([0.0, 0.5 * G], abs=1e-6)
