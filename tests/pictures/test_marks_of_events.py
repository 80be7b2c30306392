"""Events of scenes in pictures: marks over time, names in the key, poses, and what the player says."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from ccgen.runtime import Run, simulate
from ccgen.runtime.pictures import player
from ccgen.runtime.pictures.frames import MOST_EVENTS, shown_events
from ccgen.runtime.pictures.instants import instants
from ccgen.runtime.pictures.marks import DASHED, DOTTED, EVENTS, SOFT

from ..support.workshop import Workshop

BALL = """
name = "ball"
[[link]]
name = "ball"
mass = 1
inertia = 1
com = [0, 0]
points = { C = [0, 0] }
[start]
position = [0, 1]
[gravity]
[[ground]]
restitution = 0.8
contacts = ["ball.C"]
[[event]]
name = "hit"
when = "rate(y(ball.C))"
direction = "rising"
[[event]]
name = "late"
when = "t - 2"
set = { "ball.mass" = 1, "gravity.g" = 5 }
[run]
until = 2.5
"""
"""It strikes four times before 2.5 s."""


@pytest.fixture(scope="module")
def run(workshop: Workshop) -> Run:
    found: Run = simulate(workshop.model(BALL))
    return found


def lines(axes: Any, width: float) -> list[float]:
    """Times of the lines of that width over the whole height."""
    found = [some for some in axes.collections if list(some.get_linewidths()) == [width]]
    return sorted(segment[0, 0] for some in found for segment in some.get_segments())


def key(figure: Any) -> dict[str, str]:
    """What the key says, and in which colours."""
    (legend,) = figure.subfigs[1].legends
    return {text.get_text(): line.get_color() for text, line in zip(legend.texts, legend.legend_handles, strict=True)}


def test_events_are_marked_and_named(run: Run) -> None:
    pytest.importorskip("matplotlib")
    figure: Any = run.plot()
    for axes in figure.subfigs[1].axes:
        assert lines(axes, DASHED) == [impact.t for impact in run.impacts]
        assert lines(axes, DOTTED) == pytest.approx([event.t for event in run.events])
    assert [*key(figure).items()][1:] == [("hit", EVENTS[0]), ("late", EVENTS[1])]
    titles = dict(instants(run))
    assert titles[2.0] == "late" and titles[run.impacts[0].t] == "hit"


def test_of_many_events_few_are_marked_and_of_many_names_few_told_apart(run: Run) -> None:
    pytest.importorskip("matplotlib")
    one = run.events[0]
    many = [replace(one, t=float(t), number=k) for k, t in enumerate(np.linspace(0.1, 2.4, 3000), 1)]
    crowded = replace(run, events=(*many, replace(one, t=2.45, name="rare")))
    shown = shown_events(crowded)
    assert len(shown) <= MOST_EVENTS + 1 and shown[-1].name == "rare" and shown[0] is many[0]
    assert lines(crowded.plot().subfigs[1].axes[0], DOTTED)[-1] == 2.45
    assert len(player.content(crowded)["events"]) == len(shown)
    named = tuple(replace(one, t=0.1 * k, name=f"event_{k}") for k in range(1, 9))
    told = key(replace(run, events=named).plot())
    assert [*told][1:] == ["event_1", "event_2", "event_3", "5 other events"] and told["5 other events"] == SOFT
    assert not {title for _, title in instants(replace(run, events=named))} & {f"event_{k}" for k in range(1, 9)}


def test_the_player_says_what_events_did(run: Run) -> None:
    events = player.content(run)["events"]
    assert [event["name"] for event in events] == [event.name for event in run.events]
    late = next(event for event in events if event["name"] == "late")
    assert late["said"] == ("event late, rising, at t = 2.000000 s: ball.mass stays 1, gravity.g from 9.81 to 5")
    assert events[1]["said"] == f"event hit (2), rising, at t = {run.events[1].t:.6f} s"


def test_runs_without_events_have_no_marks_of_them(run: Run) -> None:
    pytest.importorskip("matplotlib")
    plain = replace(run, events=())
    figure: Any = plain.plot()
    assert all(not lines(axes, DOTTED) for axes in figure.subfigs[1].axes)
    assert [*key(figure)] == ["impact"] and player.content(plain)["events"] == []
