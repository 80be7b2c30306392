"""Rows of bodies that strike each other without end: what moves is a motion however many events it has."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from ccgen.runtime import simulate

from ..oracles.row import Row
from ..support.workshop import Workshop

SEEN = 1e-6
"""Part of the speeds of a mechanism: what approaches faster is brought to rest by no crowd of events."""


def scene(row: Row) -> str:
    """The row on a rail. A wall that moves is a block that a drive moves."""
    text = 'name = "row"\n[ground_link]\npoints = { O = [0, 0] }\n'
    for i, mass in enumerate(row.masses):
        text += (
            f'[[link]]\nname = "b{i}"\nmass = {mass!r}\ninertia = {0.004 * mass!r}\ncom = [0, 0]\n'
            f'points = {{ C = [0, 0] }}\n[[joint]]\nname = "s{i}"\ntype = "prismatic"\n'
            f'between = ["ground.O", "b{i}.C"]\naxis = [1, 0]\n'
        )
    for i, (reach, e) in enumerate(zip(row.reach, row.restitution, strict=True)):
        text += f'[[touch]]\nbetween = ["b{i}.C", "b{i + 1}.C"]\nradius = {0.5 * reach!r}\nrestitution = {e!r}\n'
    places = {f"s{i}": p for i, p in enumerate(row.places)}
    speeds = {f"s{i}": v for i, v in enumerate(row.speeds)}
    if row.wall and not row.wall[1]:
        text += f"[[ground]]\npoint = [{row.wall[0]!r}, 0]\nnormal = [1, 0]\nrestitution = {row.wall[2]!r}\n"
        text += 'contacts = ["b0.C"]\n'
    elif row.wall:
        text += (
            '[[link]]\nname = "wall"\nmass = 1.0\ninertia = 0.01\ncom = [0, 0]\npoints = { C = [0, 0] }\n'
            '[[joint]]\nname = "sw"\ntype = "prismatic"\nbetween = ["ground.O", "wall.C"]\naxis = [1, 0]\n'
            f'[[drive]]\njoint = "sw"\nspeed = {row.wall[1]!r}\n'
            f'[[touch]]\nbetween = ["wall.C", "b0.C"]\nradius = 0.05\nrestitution = {row.wall[2]!r}\n'
        )
        places["sw"], speeds["sw"] = row.wall[0] - 0.1, row.wall[1]
    inside = {name: ", ".join(f"{k} = {x!r}" for k, x in of.items()) for name, of in (("p", places), ("v", speeds))}
    return text + f"[start]\nslides = {{ {inside['p']} }}\nsliding_velocities = {{ {inside['v']} }}\n"


def compare(row: Row, until: float, workshop: Workshop, accuracy: float, **options: Any) -> Any:
    """The run of the row, held to the motion in 40 digits: the same impacts, places and speeds to ``accuracy``."""
    places, speeds = row.move(until)
    run = simulate(workshop.model(scene(row)), until=until, **options)
    assert run.success, run.message
    n = len(row.masses)
    times = [float(t) for t, _ in row.impacts]
    if np.min(np.diff(times), initial=np.inf) < 1e-13:  # without end in finite time: told, and right but for the steps
        np.testing.assert_allclose(run.q[-1][:n], places, atol=1e-5)
        np.testing.assert_allclose(run.u[-1][:n], speeds, atol=1e-5)
        return run
    assert all(phase.kind != "steps" for phase in run.phases)
    assert len(run.impacts) == len(row.impacts)
    # contacts count as closed from 1e-9 lengths on: what is slow strikes so much earlier
    np.testing.assert_allclose([impact.t for impact in run.impacts], times, atol=1e-5)
    np.testing.assert_allclose(run.q[-1][:n], places, atol=accuracy)
    np.testing.assert_allclose(run.u[-1][:n], speeds, atol=accuracy)
    return run


FIVE = Row(
    [1.0, 0.1, 10.0, 0.01, 50.0],
    [1.0, 1.5, 2.0, 2.6, 3.0],
    [0.3, -1.0, 0.2, -0.7, -2.0],
    [0.2] * 4,
    [0.95] * 4,
    (0.1, 0.0, 0.95),
)
"""Light balls between heavy ones that close: thousands of impacts within a tenth of a second, all motion"""

THREE = Row([1.0, 0.0003, 2.0], [1.0, 1.45, 2.0], [1.0, 0.0, -1.0], [0.2] * 2, [0.999] * 2)


def test_a_light_ball_between_two_that_close(workshop: Workshop) -> None:
    """Some hundred impacts in the time in which the heavy ones turn round"""
    compare(THREE, 2.0, workshop, 1e-10)
    assert len(THREE.impacts) > 50


@pytest.mark.hard
def test_thousands_of_impacts_are_motion(workshop: Workshop) -> None:
    run = compare(FIVE, 10.0, workshop, 1e-9)
    assert len(run.impacts) == 9301


@pytest.mark.hard
@pytest.mark.parametrize("e", [0.9, 0.95, 0.99, 0.999, 1.0])
@pytest.mark.parametrize("seed", range(4))
def test_rows_of_all_masses(e: float, seed: int, workshop: Workshop) -> None:
    """Three to six bodies of a hundredth to a hundred kilograms that close on each other, before a wall or free"""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(3, 7))
    row = Row(
        [float(m) for m in 10.0 ** rng.uniform(-2, 2, n)],
        [float(x) for x in 1.0 + 0.5 * np.arange(n) + rng.uniform(-0.1, 0.1, n)],
        [float(v) for v in np.sort(rng.uniform(-2, 2, n))[::-1]],
        [0.2] * (n - 1),
        [e] * (n - 1),
        (0.1, 0.0, e) if seed % 2 else None,
    )
    compare(row, 3.0, workshop, 1e-8)


@pytest.mark.parametrize("method", ["gauss", "dop853", "radau"])
def test_what_loses_nothing_is_not_made_plastic(workshop: Workshop, method: str) -> None:
    """A light ball caught by two heavy ones that close, e = 1: its energy is all there is to turn them round"""
    row = Row([1.0, 1e-7, 2.0], [1.0, 1.45, 2.0], [1.0, 0.0, -1.0], [0.2] * 2, [1.0] * 2)
    run = simulate(workshop.model(scene(row)), until=0.6, method=method)
    assert run.success, run.message
    assert len(run.impacts) > 4000 and all(phase.kind != "steps" for phase in run.phases)
    energy = 0.5 * (run.u[:, :3] ** 2) @ np.array(row.masses)
    np.testing.assert_allclose(energy, energy[0], rtol=1e-9)
    assert {impact.restitution_share for impact in run.impacts} == {1.0}


def test_what_creeps_at_the_start_is_no_motion(workshop: Workshop) -> None:
    """Three that touch and close a billionth as fast as a fourth moves: they rest against each other from
    the first instant, as they would be after an event of the fourth"""
    row = Row([1.0, 1e-7, 2.0, 1.0], [1.0, 1.25, 1.5, 3.0], [1e-9, -1e-7, -1e-9, 1.0], [0.25] * 3, [0.99] * 3)
    run = simulate(workshop.model(scene(row)), until=0.1)
    assert run.success and all(phase.kind != "steps" for phase in run.phases)
    np.testing.assert_allclose(run.u[-1][:4], [*[-1e-9 / 3.0] * 3, 1.0], atol=1e-13)


@pytest.mark.parametrize(("method", "e"), [("gauss", 0.99), ("dop853", 0.99), ("gauss", 1.0)])
def test_what_accumulates_ends_however_fast_it_is(method: str, e: float, workshop: Workshop) -> None:
    """A ball so light that those beside it come to rest against each other before it has slowed down: tens of thousands
    of impacts until 0.3000004 s, and then one speed, that of all momentum over all mass. So it is where one of the two
    contacts loses nothing."""
    row = Row([1.0, 1e-7, 2.0], [1.0, 1.45, 2.0], [1.0, 0.0, -1.0], [0.2] * 2, [e, 0.99])
    run = simulate(workshop.model(scene(row)), until=0.6, method=method)
    assert run.success, run.message
    stretches = [phase for phase in run.phases if phase.kind == "steps"]
    assert len(stretches) == 1 and stretches[0].start == pytest.approx(0.3, abs=1e-5)
    assert stretches[0].end - stretches[0].start < 1e-5 and len(run.impacts) < 10_000
    np.testing.assert_allclose(run.u[-1][:3], -1.0 / 3.0, atol=1e-6)
    np.testing.assert_allclose(run.q[-1][:3], [1.2, 1.4, 1.6], atol=1e-5)
    lost = sum(impact.energy_loss for impact in run.impacts) + stretches[0].taken
    assert lost == pytest.approx(4.0 / 3.0, abs=1e-6)


def test_a_driven_wall_catches_a_light_ball(workshop: Workshop) -> None:
    """The wall does not give way: the ball, e = 1, gets ever faster until the heavy one has turned round"""
    row = Row([1e-4, 1.0], [1.0, 2.0], [0.0, -1.0], [0.1, 0.1][:1], [1.0], (0.5, 1.0, 1.0))
    compare(row, 1.5, workshop, 1e-8)
