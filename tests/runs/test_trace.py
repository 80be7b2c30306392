"""What a run tells of its last transitions, refused steps and kinks."""

from __future__ import annotations

import pickle
from itertools import pairwise
from pathlib import Path

import numpy as np

from ccgen.runtime import Run, load_run, simulate

from ..support.workshop import Workshop
from .test_user_events import BALL, PENDULUM

HANGS = (
    PENDULUM
    + """
[[spring]]
name = "rope"
between = ["ground.P", "rod.B"]
stiffness = 40
length = 1.2
acts = "pull"
"""
)


def lines(run: Run, *words: str) -> list[float]:
    return [one.t for one in run.trace if any(word in one.what for word in words)]


def test_each_event_is_told_with_its_contact(workshop: Workshop) -> None:
    """A ball that bounces until it rests: as many meetings as impacts, at their times."""
    run = simulate(workshop.model(BALL), until=1.2)
    assert len(run.trace) < 512 and len(run.impacts) > 2
    assert lines(run, "event: ball.P on ground_0 closes") == [impact.t for impact in run.impacts]
    assert run.trace[0].what.startswith("start -> ")
    assert all(one.t <= other.t for one, other in pairwise(run.trace))


def test_each_refused_step_is_told_with_its_reason(workshop: Workshop) -> None:
    """As many as the core has counted; errors are above what they may be."""
    for text in (BALL, PENDULUM):
        model = workshop.model(text)
        q, u = model.start()
        found = model.kernels.simulate(q, u, "dop853", 3.0, 1e-10, 1e-10, 0.0, 10**7, 10**7, None)
        run = simulate(model, until=3.0, rtol=1e-10, method="dop853")
        told = [one for one in run.trace if one.refused]
        assert all("is refused: " in one.what for one in told)
        assert len(run.trace) < 512 and len(told) == found["rejected"]
        errors = [float(one.what.split("its error is ")[1].split(" ")[0]) for one in told if "its error is" in one.what]
        assert all(error > 1.0 for error in errors)


def test_kinks_are_told_where_an_effect_comes_past_them(workshop: Workshop) -> None:
    model = workshop.model(HANGS.replace("ground.P", "ground.O").replace("length = 1.2", "length = 0.2"))
    assert not lines(simulate(model, until=1.0), "kink")  # it is tight all the time
    text = BALL.replace("[[ground]]", "[[compliant_ground]]\nload = 50\ndepth = 0.01")
    run = simulate(workshop.model(text), until=1.0)
    first = lines(run, "kink")[0]
    assert abs(first - np.sqrt(2.0 / 9.81)) < 1e-9  # where it comes down


def test_the_last_lines_are_kept_of_a_long_run(workshop: Workshop) -> None:
    run = simulate(workshop.model(BALL.replace("restitution = 0.5", "restitution = 1")), until=200.0)
    met = lines(run, "closes")
    assert len(run.impacts) > 200 and len(run.trace) == 512
    assert met == [impact.t for impact in run.impacts][-len(met) :]


def test_what_was_taken_back_is_not_told(workshop: Workshop) -> None:
    """A run that goes back to before each event that sets something tells of the way that it has gone."""
    text = PENDULUM + '[[event]]\nwhen = "angle(pin) + pi/2"\nset = { "gravity.g" = "9.81 + 0.1*t" }\n'
    run = simulate(workshop.model(text), until=20.0)
    assert len(run.events) > 10 and all(one.t <= other.t for one, other in pairwise(run.trace))
    assert not any("end" in one.what for one in run.trace)  # where it halts nothing happens
    assert run.stretches[0].trace == run.stretches[-1].trace  # of the whole run


def test_a_run_that_is_kept_in_a_file_has_its_trace(workshop: Workshop, tmp_path: Path) -> None:
    run = simulate(workshop.model(BALL), until=1.0)
    assert pickle.loads(pickle.dumps(run)).trace == run.trace
    run.save(tmp_path / "result.npz")
    assert load_run(tmp_path / "result.npz", run.model).trace == run.trace
