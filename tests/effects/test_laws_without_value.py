"""Runs that come to where a law has no value name it, with where that is; starts without one are refused."""

from __future__ import annotations

import math

import numpy as np
import pytest

from ccgen.runtime import Model, ensemble, simulate

from ..support.workshop import Workshop
from .test_laws import MASS

LAW = """
[[law]]
name = "push"
value = "VALUE"
parameters = { k = 0.5 }
[[motor]]
joint = "guide"
force = "-1 - push*0.1"
[start]
slides = { guide = 0.5 }
"""
REACHED = "push = {} comes to where it has no finite value, with slide(guide) = "


def model_of(value: str, workshop: Workshop, more: str = "") -> Model:
    return workshop.model(MASS + LAW.replace("VALUE", value) + more)


@pytest.mark.parametrize(
    ("value", "shown"),
    [
        ("k*sqrt(slide(guide))", "k * sqrt(slide(guide))"),
        ("k*log(slide(guide))", "k * log(slide(guide))"),
        ("k/slide(guide)", "k / slide(guide)"),
        ("k/slide(guide)**2 + 0*t", "k / slide(guide) ** 2 + 0 * t"),
        ("k*asin(2 - slide(guide)*2 - 1)", "k * asin(2 - slide(guide) * 2 - 1)"),
    ],
)
def test_a_law_that_loses_its_value_is_named(value: str, shown: str, workshop: Workshop) -> None:
    run = simulate(model_of(value, workshop), until=3.0)
    assert not run.success and f"stopped at t = {run.t[-1]:.12g} s: {REACHED.format(shown)}" in run.message
    assert abs(run.q[-1, 0]) < 1e-6 and "max(...)" in run.message


def test_a_load_and_a_law_behind_another_are_named(workshop: Workshop) -> None:
    """The innermost of those that have none."""
    more = '[[law]]\nname = "more"\nvalue = "2*push + rate(guide)"\n'
    model = model_of("k*log(slide(guide))", workshop, more)
    assert "push = k * log(slide(guide)) comes to" in simulate(model, until=3.0).message
    own = MASS + '[[motor]]\njoint = "guide"\nforce = "-1 - sqrt(slide(guide))"\n[start]\nslides = { guide = 0.5 }\n'
    run = simulate(workshop.model(own), until=3.0)
    assert "motor_0.force = -1 - sqrt(slide(guide)) comes to where it has no finite value" in run.message


def test_rows_of_ensembles_name_it_too(workshop: Workshop) -> None:
    model = model_of("k*log(slide(guide))", workshop)
    table = ensemble(model, {"push.k": [0.5, 0.6]}, observe=["mass.c.x"], at=[3.0], until=3.0)
    assert all("push = k * log(slide(guide)) comes to where" in reason for reason in table.reason)


@pytest.mark.parametrize("value", ["k*sqrt(slide(guide) - 1)", "k/(slide(guide) - 0.5)", "k*log(slide(guide) - 0.5)"])
def test_a_start_without_a_value_is_refused(value: str, workshop: Workshop) -> None:
    model = model_of(value, workshop)
    with pytest.raises(
        ValueError, match=r"push = .* has no finite value at the start, with slide\(guide\) = 0.5; change"
    ):
        simulate(model)
    assert simulate(model, [1.2], [0.0], until=0.1).success


def test_a_law_of_events_alone_may_have_none(workshop: Workshop) -> None:
    text = MASS + '[[law]]\nname = "far"\nvalue = "sqrt(slide(guide) - 1)"\n[[event]]\nwhen = "far - 0.1"\n'
    text += "[start]\nslides = { guide = 0.5 }\nsliding_velocities = { guide = 1.0 }\n"
    run = simulate(workshop.model(text), until=1.0)
    assert run.success and [event.t for event in run.events] == pytest.approx([0.51], rel=1e-9)
    assert math.isnan(run["far"][0]) and np.isfinite(run["far"][-1])


def test_other_ends_keep_their_words(workshop: Workshop) -> None:
    """A law that has a value all the way is not blamed."""
    text = MASS + '[[law]]\nname = "push"\nvalue = "1e3*slide(guide)"\n[[motor]]\njoint = "guide"\nforce = "push"\n'
    text += '[[force]]\npoint = "mass.c"\nvector = ["exp(exp(9*t))", 0]\n'
    run = simulate(workshop.model(text), until=2.0)
    assert not run.success and "push" not in run.message
