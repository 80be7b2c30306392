"""Smooth boxes flush on each other, corner on corner.

There the two touch twice at each side: a corner on the round end of the other's edge, and that end on the edge of the
corner. A corner that bore would push its box to the side, further and further."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from ccgen.runtime import Run, simulate

from ..support.outline_scenes import flush_boxes
from ..support.tiers import all_hard_but, hard
from ..support.touching_scenes import G
from ..support.workshop import Workshop

STACKS = {
    "two": ([0.2, 0.2], [1.0, 1.0]),
    "three": ([0.2, 0.2, 0.2], [1.0, 1.0, 1.0]),
    "heavy_in_the_middle": ([0.3, 0.3, 0.3], [1.0, 10.0, 0.1]),
    "four": ([0.5, 0.5, 0.5, 0.5], [5.0, 1.0, 1.0, 5.0]),
    "narrow_between_wide": ([0.4, 0.2, 0.4], [1.0, 1.0, 1.0]),
}
ASIDE = (0.0, 1e-14, -1e-12, 1e-10, -1e-8, 1e-6)
METHODS = ("gauss", "dop853", "radau")


def start(model: Any, aside: float, rises: float = 0.0) -> tuple[np.ndarray, np.ndarray, int]:
    """The highest box so far to the side, and the number of its slide x, before that of y."""
    q, u = (part.copy() for part in model.start())
    x = len(q) - 2
    q[x] += aside
    u[x + 1] = rises
    return q, u, x


def contact_only(run: Run) -> bool:
    return run.success and run.impacts == () and {phase.kind for phase in run.phases} == {"contact"}


@pytest.mark.parametrize("restitution", [hard(0.0), 0.5])
@pytest.mark.parametrize("stack", all_hard_but("two", of=STACKS))
def test_a_stack_stands(stack: str, restitution: float, workshop: Workshop) -> None:
    """Where it is, for 3 s: without an impact, without time stepping, whatever the offset."""
    model = workshop.model(flush_boxes(*STACKS[stack], restitution=restitution))
    for aside in ASIDE:
        for method in METHODS:
            q, u, _ = start(model, aside)
            run = simulate(model, q, u, until=3.0, method=method)
            assert contact_only(run), (aside, method, run.message)
            assert np.abs(run.q - q).max() <= 1e-8
            assert model.gaps(run.q).min() >= -1e-14
            assert len(run.t) <= 2000


LIFTS = {
    "by_a_force_that_grows": ("30*t", 0.6, 0.0, lambda t: 5.0 * np.maximum(t - G / 30.0, 0.0) ** 3),
    "at_once": ("12.0", 0.3, 0.0, lambda t: 0.5 * (12.0 - G) * t**2),
    "thrown": ("", 0.2, 1.0, lambda t: t - 0.5 * G * t**2),
}


@pytest.mark.hard
@pytest.mark.parametrize("lift", LIFTS)
def test_nothing_holds_back_what_is_lifted(lift: str, workshop: Workshop) -> None:
    """The box leaves when its weight is carried, upright, and rises as in the closed form."""
    force, until, rises, height = LIFTS[lift]
    more = f'[[force]]\npoint = "b1.C"\nvector = [0, "{force}"]\n' if force else ""
    model = workshop.model(flush_boxes(*STACKS["two"], more=more))
    for aside in (0.0, 1e-12, -1e-9, 1e-6):
        for method in METHODS:
            q, u, x = start(model, aside, rises)
            run = simulate(model, q, u, until=until, method=method)
            assert run.success and run.impacts == (), run.message
            assert run.q[:, x + 1] - q[x + 1] == pytest.approx(height(run.t), abs=1e-11)
            assert np.abs(run.q[:, x] - q[x]).max() <= 1e-12
            assert np.abs(run.q[:, :2]).max() <= 1e-13


@pytest.mark.hard
@pytest.mark.parametrize("push", [0.1, -0.1, 1e-3, -1e-6])
def test_nothing_holds_back_what_is_pushed(push: float, workshop: Workshop) -> None:
    """A smooth box slides off as on ice, away from where it is flush, and through there."""
    model = workshop.model(flush_boxes(*STACKS["two"], more=f'[[force]]\npoint = "b1.C"\nvector = [{push!r}, 0]\n'))
    for aside in (0.0, 1e-12, -1e-9, 6e-8):
        for method in METHODS:
            q, u, x = start(model, aside)
            run = simulate(model, q, u, until=0.8, method=method)
            assert contact_only(run), (aside, method, run.message)
            assert run.q[:, x] - q[x] == pytest.approx(0.5 * push * run.t**2, abs=3e-8)
            assert np.abs(run.q[:, :2]).max() <= 1e-13
