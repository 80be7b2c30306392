"""What the gallery says of its runs: each number against an answer that owes nothing to ``ccgen``."""

from __future__ import annotations

import importlib
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from ccgen.generator import load_scene
from ccgen.runtime import simulate

from ..oracles.gallery import ANSWERS, rods_lose
from ..oracles.woodpecker import pecks
from ..support.folders import ROOT
from ..support.workshop import Workshop

pytestmark = pytest.mark.hard


@pytest.fixture
def gallery(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """docs/scripts/gallery.py."""
    monkeypatch.syspath_prepend(str(ROOT / "docs" / "scripts"))
    return importlib.import_module("gallery")


def shown(name: str, gallery: ModuleType, workshop: Workshop) -> tuple[Any, Any, float]:
    """The row of an entry, its run, and what that says of the number."""
    (row,) = [row for row in gallery.entries() if row.name == name]
    run = simulate(workshop.model(load_scene(ROOT / row.scene)), until=row.until)
    assert run.success, run.message
    return row, run, gallery.gallery_numbers.NUMBERS[name](run)


@pytest.mark.parametrize("name", sorted(ANSWERS))
def test_runs_give_the_answers(name: str, gallery: ModuleType, workshop: Workshop) -> None:
    row, _, found = shown(name, gallery, workshop)
    answer = ANSWERS[name]()
    assert found == pytest.approx(answer, abs=row.within)
    assert row.answer == pytest.approx(answer, abs=row.within) and row.answer == pytest.approx(found, abs=row.within)


def test_the_chain_loses_what_its_rods_have_no_more(gallery: ModuleType, workshop: Workshop) -> None:
    row, run, found = shown("chain-over-edge", gallery, workshop)
    ends = [[run.point(f"rod_{k}.{end}", [0.0, 0.8]) for end in "AB"] for k in range(20)]
    places = np.array([[end.position for end in rod] for rod in ends]).swapaxes(1, 2)
    velocities = np.array([[end.velocity for end in rod] for rod in ends]).swapaxes(1, 2)
    assert found == pytest.approx(rods_lose(places, velocities, 0.02), abs=1e-6)
    assert row.answer == pytest.approx(found, abs=row.within)


def test_small_angles_give_the_woodpecker_its_other_period() -> None:
    """That of docs/gallery/entries.toml, 0.146 s."""
    assert np.diff(pecks(until=0.9, step=1e-4, small=True)[:, 0])[-3:].mean() == pytest.approx(0.146, abs=1e-3)
