"""A rough ball rolls over edges that end on each other.

Beyond its end an edge is round, and its gap grows as the square of the way: that of the next one closes without speed.
Bounces lower than the last digits of places never get lower. Neither is an impact."""

from __future__ import annotations

from math import log, sqrt

import numpy as np
import pytest

from ccgen.runtime import simulate

from ..support.tiers import all_hard_but
from ..support.workshop import Workshop

G = 9.81
BALL = """
[ground_link]
points = {{ {points} }}
[[link]]
name = "ball"
mass = 1.0
inertia = 0.03125
com = [0, 0]
free = true
points = {{ C = [0, 0] }}
[[touch]]
between = ["ball.C", [{edges}]]
radius = [0.25, 0.05]
restitution = {restitution}
friction = 0.5
[start]
position = [-0.5, 0.3]
velocity = [0.0, 0]
angular_velocities = {{ ball = 0.0 }}
[gravity]
g = {gravity}
[run]
until = 1.0
law = "{law}"
"""


def ball(restitution: float, law: str) -> str:
    points = ", ".join(f"P{i} = [{i - 1}.0, 0.0]" for i in range(6))
    edges = ", ".join(f'"ground.P{i}"' for i in range(6))
    return BALL.format(points=points, edges=edges, restitution=restitution, law=law, gravity=G)


@pytest.mark.parametrize("method", ["gauss", "dop853", "radau"])
@pytest.mark.parametrize("speed", all_hard_but(1e-3, 2.0, of=[1e-3, 1e-2, 0.1, 1.0, 2.0, 3.0]))
@pytest.mark.parametrize("law", ["newton", "poisson", "stronge"])
def test_a_ball_rolls_over_seams(law: str, speed: float, method: str, workshop: Workshop) -> None:
    """Upon one edge after another, as fast as it began: each is stopped at once, and once more at most where a step has
    missed it beside the seam, and takes nothing."""
    model = workshop.model(ball(0.5, law))
    for rtol in (1e-9, 1e-11):
        run = simulate(model, u0=[speed, 0.0, -4.0 * speed], until=4.0 / speed, method=method, rtol=rtol)
        assert run.success, run.message
        assert len(run.impacts) <= 2 * 4
        assert sum(impact.energy_loss for impact in run.impacts) <= 1e-14
        assert all(phase.kind != "steps" for phase in run.phases)
        # gaps of ten rtol lengths count as closed: so far the ball may go round its own corner at each of four seams
        off = max(1e-7, 4 * 10.0 * rtol / 0.25)
        assert run.q[-1] == pytest.approx([3.5, 0.3, -16.0], abs=off)
        assert run.u[-1] == pytest.approx([speed, 0.0, -4.0 * speed], abs=off * speed)
        assert len(run.t) <= 500


@pytest.mark.parametrize("method", ["gauss", "dop853", "radau"])
@pytest.mark.parametrize("restitution", [0.3, 0.5, 0.8, 0.9])
def test_bounces_end_where_places_have_no_more_digits(restitution: float, method: str, workshop: Workshop) -> None:
    """Dropped by 1 m onto an edge, it comes to rest 0.3 m above the origin: there its place is known to 6e-17 m."""
    model = workshop.model(ball(restitution, "newton"))
    q, u = model.start()
    q = np.asarray(q) + np.array([0.0, 1.0, 0.0])
    fall = sqrt(2.0 / G)
    over = fall * (1.0 + restitution) / (1.0 - restitution)
    run = simulate(model, q, u, until=over + 0.5, method=method)
    assert run.success, run.message
    slowest = sqrt(2.0 * G * 2.0**-54)  # of a fall by half the last digit
    assert len(run.impacts) <= 10 + log(G * fall / slowest) / log(1.0 / restitution)
    assert run.phases[-1].kind == "contact"
    assert run.phases[-1].start == pytest.approx(over, abs=1e-6)
    assert run.q[-1][1] == pytest.approx(0.3, abs=1e-15)


@pytest.mark.parametrize("friction", [0.0, 0.5])
@pytest.mark.parametrize("place", [0.0, 1e-9, -1e-9, 1e-7, -1e-7, 1e-3, -1e-3])
@pytest.mark.parametrize("rate", [0.0, 4.0])
def test_one_edge_bears_a_ball_at_a_seam(rate: float, place: float, friction: float, workshop: Workshop) -> None:
    """At rest, and turning in its place: its whole weight is on the edge that its phase says bears, at every instant of
    the run, and of the model in that state. Friction is none, or μ m g against the turning."""
    model = workshop.model(ball(0.5, "newton").replace("friction = 0.5", f"friction = {friction}"))
    run = simulate(model, [place, 0.3, 0.0], [0.0, 0.0, rate], until=1e-9 if rate else 0.1)
    bearing = [
        contact for contact, how in zip(run.phases[0].contacts, run.phases[0].how, strict=True) if how != "carried"
    ]
    assert [phase.kind for phase in run.phases] == ["contact"]
    assert len(bearing) == 1
    which = model.contacts.index(bearing[0])
    t = run.t[-1] / 2
    for forces in (run.contact_forces(t), model.contact_forces(*run.at(t))):
        normal, rubbing = np.array(forces).T
        assert np.delete(normal, which) == pytest.approx(0.0, abs=1e-12)
        assert np.delete(rubbing, which) == pytest.approx(0.0, abs=1e-12)
        assert normal[which] == pytest.approx(G)
        assert abs(rubbing[which]) == pytest.approx(friction * G if rate else 0.0, abs=1e-5)
