"""Bouncing to rest: impacts that accumulate hand over to contact at the geometric series' limit, at every tolerance."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from ..support.bouncing_ball import BALL, FIRST, G
from ..support.workshop import Workshop


@pytest.fixture(scope="module")
def ball(workshop: Workshop) -> Any:
    return workshop.model(BALL)


def contacts(run: Any) -> list[Any]:
    return [phase for phase in run.phases if phase.kind == "contact"]


@pytest.mark.quick
@pytest.mark.parametrize("rtol", [1e-6, 1e-9, 1e-12])
@pytest.mark.parametrize("until", [None, 100.0, 400.0])
@pytest.mark.parametrize("e", [0.5, 0.9])
def test_a_ball_comes_to_rest(ball: Any, e: float, until: float | None, rtol: float) -> None:
    """v_k = sqrt(2 g h) e^k, t_k = t_0 (1 + 2 (e + ... + e^k)), and the limit t_0 (1 + e) / (1 - e)."""
    from ccgen.runtime import simulate

    limit = FIRST * (1 + e) / (1 - e)
    end = until or 2 * limit
    run = simulate(ball, until=end, rtol=rtol, params={"ground_0.restitution": e})
    assert run.success, run.message
    (rest,) = contacts(run)
    assert rest.start == pytest.approx(limit, rel=1e-9)
    assert rest.end == end
    assert rest.contacts == (("ball.C", "ground_0"),)
    assert run.phases[-1] == rest
    assert len(run.impacts) >= 20
    for k, impact in enumerate(run.impacts[:20]):
        speed = np.sqrt(2 * G) * e**k
        assert impact.t == pytest.approx(FIRST * (1 + 2 * sum(e**j for j in range(1, k + 1))), rel=1e-9)
        assert -impact.u_minus[1] == pytest.approx(speed, rel=1e-9)
        assert impact.u_plus[1] == pytest.approx(e * speed, rel=1e-9)
        assert impact.impulses == pytest.approx([2.0 * (1 + e) * speed], rel=1e-9)
        assert impact.energy_loss == pytest.approx((1 - e**2) * speed**2, rel=1e-9)
    resting = run.t > rest.start
    assert np.max(np.abs(run.u[resting])) <= 1e-12
    assert np.max(np.abs(ball.gaps(run.q[resting]))) <= 1e-12
    assert np.all(np.diff([impact.t for impact in run.impacts]) > 0)
    assert np.all(np.isfinite(run.q))
    assert np.all(np.isfinite(run.u))
    assert ball.gaps(run.q).min() >= -1e-12
    assert run.energy_drift <= 1e-9 * 2.0 * G


@pytest.mark.parametrize("e", [0.5, 0.9])
def test_rest_begins_earlier_far_from_the_origin(e: float, workshop: Workshop) -> None:
    """Bounces that lose no more of their height than half the last digit of a place, eps y, do not get lower: the first
    of those is the last, and ends in rest. What exact bounces would still take from there on is as much as rounding
    has moved the end until then."""
    from ccgen.runtime import simulate

    high = BALL.replace("position = [0.0, 1.0]", "position = [0.0, 6.0]")
    model = workshop.model(high.replace("[[ground]]", "[[ground]]\npoint = [0.0, 5.0]"))
    run = simulate(model, until=20.0, params={"ground_0.restitution": e})
    (rest,) = contacts(run)
    slowest = np.sqrt(2.0 * G * 2.0**-53 * 5.0 / (1.0 - e**2))
    *others, last = (-float(impact.u_minus[1]) for impact in run.impacts)
    assert slowest < min(others) and e * last <= 2.0 * slowest
    early = FIRST * (1 + e) / (1 - e) - rest.start
    assert 1e-9 < early <= 2.0 * (2.0 * e * slowest / G / (1.0 - e))


@pytest.mark.quick
@pytest.mark.parametrize("rtol", [1e-4, 1e-6, 1e-9, 1e-12])
def test_a_ball_that_does_not_rebound_stays_closed(ball: Any, rtol: float) -> None:
    from ccgen.runtime import simulate

    run = simulate(ball, until=100.0, rtol=rtol, params={"ground_0.restitution": 0.0})
    assert run.success
    assert [impact.t for impact in run.impacts] == pytest.approx([FIRST], rel=1e-9)
    assert [phase.start for phase in contacts(run)] == [run.impacts[0].t]
    assert run.phases[-1].end == 100.0
    assert np.max(np.abs(run.impacts[0].u_plus)) <= 1e-12


@pytest.mark.quick
@pytest.mark.parametrize("rtol", [1e-6, 1e-9, 1e-12])
def test_a_ball_that_loses_nothing_bounces_on(ball: Any, rtol: float) -> None:
    """50 flights of one step each; the method's rounded coefficients lose 2.5e-14 of the energy in every one."""
    from ccgen.runtime import simulate

    run = simulate(ball, until=100 * FIRST, rtol=rtol, params={"ground_0.restitution": 1.0})
    assert run.success, run.message
    assert [impact.t for impact in run.impacts] == pytest.approx(FIRST * (1 + 2 * np.arange(50)), rel=1e-9)
    kinetic, potential = ball.energy(run.q, run.u)
    assert kinetic + potential == pytest.approx(2.0 * G, rel=2e-12)


@pytest.mark.sample(3)
@pytest.mark.parametrize("rtol", 10.0 ** -np.arange(4.0, 13.0), ids=str)
def test_the_falling_hexagon_comes_to_stand_at_every_tolerance(rtol: float, workshop: Workshop) -> None:
    """The motion after many impacts is sensitive to the first ones: looser tolerances place its end less sharply."""
    from ccgen.generator import loop
    from ccgen.runtime import simulate

    model = workshop.model(loop(6, gravity=True, start={"height": 1.0}, ground=[{"restitution": 0.5}]))
    run = simulate(model, until=1.4, rtol=rtol)
    assert run.success
    assert contacts(run)[0].start == pytest.approx(1.292646, abs=max(1e-6, 30 * rtol))
    assert contacts(run)[0].contacts == (("joint_0", "ground_0"),)
    assert run.closure_max <= 1e-11
    assert model.gaps(run.q).min() >= -1e-10


@pytest.mark.quick
def test_contact_begins_as_near_to_the_limit_of_bounces_as_said(ball: Any) -> None:
    """docs/events.md: before the limit, by no more than 1e-11 max(1 s, t) or what a speed of 1e-10 length/s takes."""
    from ccgen.runtime import simulate

    nearest = 0.0
    for e in np.linspace(0.3, 0.95, 40):
        limit = FIRST * (1 + e) / (1 - e)
        run = simulate(ball, until=limit + 1.0, rtol=1e-12, params={"ground_0.restitution": float(e)})
        early = limit - contacts(run)[0].start
        bound = max(1e-11 * max(1.0, limit), 2e-10 * ball.length / (G * (1 - e)))
        assert -1e-14 * limit * len(run.impacts) <= early <= bound + 1e-14 * limit * len(run.impacts)
        nearest = max(nearest, early / bound)
    assert nearest > 0.5
