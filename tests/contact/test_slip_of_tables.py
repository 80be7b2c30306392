"""A table that stands on rough ground is pushed ever harder, until it slides: when, and how its run depends on that."""

from __future__ import annotations

import numpy as np
import pytest

from ccgen.runtime import sensitivities, simulate

from ..support.workshop import Workshop

MASS, G, GROWS, END = 10.0, 9.81, 70.0, 1.0
"""kg, m/s^2, N/s, s: the push is GROWS times the time"""


def table(feet: list[float], mu: float, height: float) -> str:
    points = ", ".join(f"F{i} = [{x!r}, {-height!r}]" for i, x in enumerate(feet))
    names = ", ".join(f'"table.F{i}"' for i in range(len(feet)))
    return f"""
name = "table"
[[link]]
name = "table"
mass = {MASS!r}
inertia = 3.0
com = [0, 0]
points = {{ {points} }}
[start]
position = [0, {height!r}]
[gravity]
g = {G!r}
[[ground]]
restitution = 0.0
friction = {mu!r}
contacts = [{names}]
[[force]]
point = "table.F0"
vector = ["{GROWS!r} * t", 0]
[run]
until = {END!r}
"""


@pytest.mark.parametrize("rtol", [1e-6, 1e-9, 1e-13])
@pytest.mark.parametrize("mu", [0.3, 0.5])
@pytest.mark.parametrize(
    ("feet", "height"), [([0.0], 0.0), ([-0.5, 0.5], 0.2), ([-0.5, 0.7], 0.2), ([-0.5, -0.1, 0.3, 0.5], 0.2)]
)
def test_it_begins_to_slide_when_the_push_passes_friction(
    feet: list[float], height: float, mu: float, rtol: float, workshop: Workshop
) -> None:
    """How feet share friction is open, and so is, with three and more of them, how they share the weight: the table
    stands for as long as any shares do, which is until the push is all that friction can be."""
    model = workshop.model(table(feet, mu, height), derivatives=True)
    begins = mu * MASS * G / GROWS
    run = simulate(model, rtol=rtol)
    stands, slides = (phase for phase in run.phases if phase.kind == "contact")
    assert set(stands.how) == {"sticks"} and set(slides.how) == {"slides forward"}
    assert stands.end == pytest.approx(begins, abs=1e-8)
    late = END - begins
    speed = GROWS / MASS * (END**2 - begins**2) / 2 - mu * G * late
    np.testing.assert_allclose(run.u[-1], [speed, 0.0, 0.0], atol=max(1e-14, rtol))
    if len(feet) > 3:  # what slides on more feet than it has freedoms has no derivatives, which is said
        return
    found = sensitivities(model, {"gravity.g": np.ones(1)}, ["q", "u"], rtol=rtol).jacobian[:, 0]
    np.testing.assert_allclose(found, [-mu * late**2 / 2, 0.0, 0.0, -mu * late, 0.0, 0.0], atol=1e-8)
