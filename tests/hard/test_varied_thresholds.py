"""Each threshold of the core doubled and halved: no survey of hard motions changes its class, so none is tuned."""

from __future__ import annotations

import ctypes
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from ccgen.generator import load_scene, loop
from ccgen.runtime import Model, _core

from ..support.bodies import tossed_hexagon
from ..support.c_library import Library
from ..support.folders import ROOT
from ..support.workshop import Workshop
from .fuzz import scene as toss_scene

APART = 6
"""The mode of a contact that is open (runtime/ccgen.h)."""
SAME = 1e-6
"""Relative: times of the first events, and energies at the end, that are the same."""

Start = tuple[Any, Any, Any, float]


def rests(workshop: Workshop) -> Start:
    """Falls, bounces, folds through a line and comes to lie flat."""
    model = workshop.model(loop(6, gravity=True, start={"height": 1.0}, ground=[{"restitution": 0.5}]))
    return model, *model.start(), 30.0


def tossed(workshop: Workshop) -> Start:
    """Thrown, through accumulation after accumulation: a third as many impacts as with the restitution of 0.5."""
    model = workshop.model(loop(6, gravity=True, start={"height": 1.0}, ground=[{"restitution": 0.5}]))
    return model.with_parameters({"ground_0.restitution": 0.1}), *tossed_hexagon(model), 3.0


def rough(workshop: Workshop) -> Start:
    """Thrown into a rough wedge of two planes, where it sticks and slides."""
    model = workshop.model(toss_scene(6, rough=True)).with_parameters({"ground_1.point.y": 0.0})
    q, u = model.start()
    q, u = model.project(q, u + np.random.default_rng(1).normal(size=u.size))
    q[1] += 0.2 + 1.5 * max(0.0, -float(model.gaps(q).min()))
    return model, q, u, 1.5


def dead_points(workshop: Workshop) -> Start:
    """Loops that pass configurations where their rows depend."""
    model = workshop.model(load_scene(ROOT / "scenes" / "parallelogram.toml"))
    return model, *model.start(), 3.0


def cradle(workshop: Workshop) -> Start:
    """Impacts through rows of balls that touch."""
    model = workshop.model(load_scene(ROOT / "scenes" / "newtons-cradle.toml"))
    return model, *model.start(), 2.0


SURVEYS = (rests, tossed, rough, dead_points, cradle)


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> Library:
    """With -O1, which pays for itself: the surveys run twelve hundred times."""
    file = tmp_path_factory.mktemp("varied") / "core.so"
    return Library(ROOT / "runtime", file, "-O1", "-DCCGEN_VARIABLE_TOLERANCES")


@pytest.fixture
def vary(library: Library) -> Iterator[Any]:
    """Sets one threshold to a multiple of what it is, until the test ends."""
    varied: list[str] = []

    def to(name: str, factor: float) -> None:
        varied.append(name)
        ctypes.c_double.in_dll(library.calls, name).value = factor * _core.TOLERANCES[name].value

    yield to
    for name in varied:
        ctypes.c_double.in_dll(library.calls, name).value = _core.TOLERANCES[name].value


def survey(library: Library, start: Start, **settings: Any) -> tuple[str, list[int], list[float], float]:
    """How the motion ends, contacts closed then, times of its first three events (s), and its energy (J) at the end.

    Nothing drives these mechanisms: after no event they may have more energy than after the one before.
    """
    model, q, u, until = start
    begun = least = float(np.sum(model.energy(q, u)))
    outcome, run = library.create(model, rtol=1e-9, **{"rate_budget": 20000, **settings})
    assert outcome == "done"
    run.reset(q, u)
    events: list[float] = []
    while True:
        outcome, event = run.step_to_event(until)
        if outcome != "done" or event.kind == 0:
            break
        events = [*events, event.t][:3]
        run.forget()
        _, q, u = run.motion()
        energy = float(np.sum(model.energy(q, u)))
        assert energy <= least + SAME * abs(begun), "an event adds energy"
        least = min(least, energy)
    _, q, u = run.motion()
    closed = [contact for contact, mode in enumerate(run.modes()) if mode != APART] if model.contacts else []
    return outcome, closed, events, float(np.sum(model.energy(q, u)))


@pytest.fixture(scope="module")
def usual(library: Library, workshop: Workshop) -> dict[str, tuple[Start, Any]]:
    starts = {make.__name__: make(workshop) for make in SURVEYS}
    return {name: (start, survey(library, start)) for name, start in starts.items()}


@pytest.mark.hard
@pytest.mark.parametrize("factor", [0.5, 2.0])
@pytest.mark.parametrize("name", _core.TOLERANCES)
def test_no_survey_changes_its_class(
    name: str, factor: float, vary: Any, library: Library, usual: dict[str, tuple[Start, Any]]
) -> None:
    vary(name, factor)
    for start, (outcome, closed, events, energy) in usual.values():
        found = survey(library, start)
        assert found[:2] == (outcome, closed)
        assert found[2] == pytest.approx(events, rel=SAME)
        if outcome == "done" and not start[0].contacts:
            assert found[3] == pytest.approx(energy, rel=SAME)


def by_newton(workshop: Workshop, seed: int) -> Start:
    """Thrown into the wedge, under Newton's law with little loss, which gains energy in some impacts."""
    wedge = workshop.model(toss_scene(6, rough=True))
    values = {"ground_1.point.y": 0.0, "ground_0.restitution": 0.8, "ground_1.restitution": 0.8}
    model = Model(wedge._descriptor, {**wedge.data, "law": "newton"}).with_parameters(values)
    q, u = model.start()
    q, u = model.project(q, u + 2.0 * np.random.default_rng(seed).normal(size=u.size))
    q[1] += 0.2 + 1.5 * max(0.0, -float(model.gaps(q).min()))
    return model, q, u, 1.5


@pytest.mark.hard
def test_what_an_event_gains_is_taken_back(vary: Any, library: Library, workshop: Workshop) -> None:
    """Impacts that gain energy are found out in the impact; where they are not, by the look at what any event adds;
    where that is left out too, runs rise."""
    starts = [by_newton(workshop, seed) for seed in range(20)]
    vary("IMPACT_GAIN", 1e30)
    for start in starts:
        assert survey(library, start)[0] == "done"
    vary("ENERGY_JUMPED", 1e30)
    with pytest.raises(AssertionError, match="an event adds energy"):
        for start in starts:
            survey(library, start)
