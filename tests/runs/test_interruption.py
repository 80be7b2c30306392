"""Ctrl-C ends runs soon, whatever they are busy with, and what is done is kept where that is asked for."""

from __future__ import annotations

import os
import signal
import threading
import time
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from ccgen.runtime import Run, simulate
from ccgen.runtime.simulation.threads import share

from ..support.heeding import heeding_ctrl_c
from ..support.workshop import Workshop

SOON = 0.2
"""Seconds from Ctrl-C to the return."""
AFTER = 0.3
"""Seconds of work before Ctrl-C."""

Called = Callable[[], Any]


def ctrl_c(call: Called, after: float = AFTER) -> tuple[Any, float]:
    """What the call gives, or the ``KeyboardInterrupt`` that it raises, and how long after Ctrl-C it does: the least of
    three times, where a machine that does much else has kept it waiting."""
    for _ in range(3):
        found, seconds = once(call, after)
        if seconds <= SOON:
            break
    return found, seconds


def once(call: Called, after: float) -> tuple[Any, float]:
    """The same, tried once. The seconds are those of the clock, or of the processor where these are fewer: a process
    that waits for its turn on a machine that does much else has not gone on."""
    sent: list[tuple[float, float]] = []

    def send() -> None:
        sent.append((time.perf_counter(), time.process_time()))
        os.kill(os.getpid(), signal.SIGINT)

    timer = threading.Timer(after, send)
    with heeding_ctrl_c():
        timer.start()
        try:
            found = call()
        except KeyboardInterrupt as error:
            found = error
        finally:
            now = (time.perf_counter(), time.process_time())
            timer.cancel()
    assert sent, "it was over before Ctrl-C"
    return found, min(end - start for end, start in zip(now, sent[0], strict=True))


@pytest.fixture(scope="module")
def tossed(workshop: Workshop) -> tuple[Any, np.ndarray, np.ndarray]:
    """A loop over the ground that bounces for a second, and a hundred thousand starts."""
    from ccgen.generator import loop

    model = workshop.model(loop(6, gravity=True, start={"height": 1.0}, ground=[{"restitution": 0.5}]))
    q, u = model.start()
    return model, np.tile(q, (100_000, 1)), np.random.default_rng(3).normal(scale=0.1, size=(100_000, u.size))


def test_a_batch_ends_at_once(tossed: Any) -> None:
    model, q, u = tossed
    found, seconds = ctrl_c(lambda: simulate(model, q, u, until=1.0))
    assert isinstance(found, KeyboardInterrupt)
    assert seconds <= SOON


def test_what_a_batch_has_done_is_kept(tossed: Any) -> None:
    """The list is that of the first starts: whole runs, equal to single ones, and those that were in progress."""
    model, q, u = tossed
    runs, seconds = ctrl_c(lambda: simulate(model, q, u, until=1.0, keep_interrupted=True))
    assert seconds <= SOON
    whole = [run.success for run in runs]
    assert 10 < len(runs) < len(q) and len(runs) - sum(whole) <= (os.cpu_count() or 1)
    for k, run in enumerate(runs):
        assert run.success or ("interrupted" in run.message and run.t[-1] < 1.0)
        if k in (0, sum(whole) // 2):
            alone = simulate(model, q[k], u[k], until=1.0)
            assert np.array_equal(run.q, alone.q[: len(run.q)]) and run.success


def test_a_batch_of_controllers_ends_at_once(workshop: Workshop) -> None:
    text = "name = 'held'\n[chain]\nlinks = 1\nhinged = true\n[[input]]\nname = 'torque'\njoint = 'joint_0'\n"
    model = workshop.model(text)
    q, u = model.start()

    def controller(t: float, q: Any, u: Any) -> float:
        return -float(q[0])

    found, seconds = ctrl_c(lambda: simulate(model, np.tile(q, (9, 1)), u + 1.0, until=1e5, inputs=controller))
    assert isinstance(found, KeyboardInterrupt) and seconds <= SOON


def test_ctrl_c_in_the_progress_of_a_batch_ends_it(tossed: Any) -> None:
    model, q, u = tossed
    times: list[float] = []

    def progress(t: float) -> None:
        times.append(t)
        if len(times) == 40:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        simulate(model, q, u, until=1.0, progress=progress)
    times.clear()
    runs = simulate(model, q, u, until=1.0, progress=progress, keep_interrupted=True)
    assert 0 < len(runs) <= 40 and not all(run.success for run in runs)


def test_threads_are_back_where_ctrl_c_broke_their_start(monkeypatch: pytest.MonkeyPatch) -> None:
    """It comes when the second thread is at work and its start has not returned: that is waited for too, as it still
    writes."""
    starts, begun, ended = list[threading.Thread](), threading.Event(), threading.Event()
    back: list[threading.Thread] = []
    start = threading.Thread.start

    def broken(thread: threading.Thread) -> None:
        starts.append(thread)
        start(thread)
        if len(starts) == 2:
            begun.wait()
            raise KeyboardInterrupt

    def work() -> None:
        second = len(starts) == 2 and threading.current_thread() is starts[1]
        if second:
            begun.set()
        ended.wait()
        if second:
            time.sleep(0.2)  # what is not waited for is still at work
        back.append(threading.current_thread())

    monkeypatch.setattr(threading.Thread, "start", broken)
    assert not share(work, 2, ended.set, None)
    assert len(starts) == 2 and set(back) == set(starts)


@pytest.mark.hard
@pytest.mark.parametrize("method", ["gauss", "dop853", "radau"])
def test_a_run_of_many_links_ends_within_a_step(method: str, workshop: Workshop) -> None:
    """Steps of a hundred links take long, above all by radau; at 1e4 rad/s a run is many of them. Soon after its start,
    so that no time goes into handing over rows by the ten thousand."""
    from ccgen.generator import loop

    model = workshop.model(loop(200))
    q, u = model.project(model.start()[0], np.random.default_rng(1).normal(scale=30.0, size=202))
    run, seconds = ctrl_c(lambda: simulate(model, q, u, until=1e3, method=method, keep_interrupted=True), 0.3)
    assert isinstance(run, Run) and "interrupted" in run.message
    assert seconds <= SOON
    assert run.closure_max <= 1e-10 and np.isfinite(run.energy_drift)


@pytest.mark.hard
@pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="needs a signal from the system, as Ctrl-C is")
def test_a_look_with_many_links_ends(workshop: Workshop) -> None:
    """A look between rows that lie apart takes many steps, by radau long ones: broken off inside of it."""
    from ccgen.generator import loop

    def break_off(*_: object) -> None:
        raise KeyboardInterrupt

    model = workshop.model(loop(200))
    q, u = model.project(model.start()[0], np.random.default_rng(1).normal(scale=30.0, size=202))
    rows = np.array([0.0, 1.0]), np.array([q, q]), np.array([u, u])
    before = signal.signal(signal.SIGALRM, break_off)
    try:
        signal.setitimer(signal.ITIMER_REAL, AFTER)
        with pytest.raises(KeyboardInterrupt) as broken:
            model.kernels.between("radau", *rows, 0.9, False, rtol=1e-9, atol=1e-9)
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)
    assert any("between" in entry.name for entry in broken.traceback)


def test_the_search_of_a_long_step_for_events_ends(workshop: Workshop) -> None:
    """A wheel that turns steadily is one long step, in which a billion turns are searched for contact."""
    ground = "[[ground]]\npoint = [0, -3]\nrestitution = 0.5\ncontacts = ['link_0.B']\n"
    text = f"name = 'wheel'\n[chain]\nlinks = 1\nhinged = true\n{ground}"
    model = workshop.model(text)
    q, _ = model.start()
    run, seconds = ctrl_c(lambda: simulate(model, q, [1e8], until=1e3, keep_interrupted=True))
    assert seconds <= SOON
    assert "interrupted" in run.message and not run.impacts


def test_an_interrupted_run_is_the_beginning_of_the_whole_one(tossed: Any) -> None:
    """Rows and impacts up to there are bit-equal: nothing is recorded of what was broken off."""
    model, q, u = tossed
    whole = simulate(model, q[0], u[0], until=3.0)
    assert len(whole.impacts) > 5
    for calls in (1, 3, 6, 9):
        times: list[float] = []

        def progress(t: float, calls: int = calls, times: list[float] = times) -> None:
            times.append(t)
            if len(times) == calls:
                raise KeyboardInterrupt

        part = simulate(model, q[0], u[0], until=3.0, progress=progress, keep_interrupted=True)
        assert not part.success and part.t[-1] < 3.0
        assert np.array_equal(part.t, whole.t[: len(part.t)]) and np.array_equal(part.q, whole.q[: len(part.q)])
        assert [impact.t for impact in part.impacts] == [impact.t for impact in whole.impacts[: len(part.impacts)]]
