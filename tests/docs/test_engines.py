"""Engines beside ccgen: what their motions are judged by, against closed forms; tables are those of the data."""

from __future__ import annotations

import importlib
import math
from types import ModuleType

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from ..support.folders import ROOT

G = 9.81
DATA = ROOT / "docs" / "data" / "engines.csv"


@pytest.fixture
def scripts(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(ROOT / "docs" / "scripts"))
    monkeypatch.syspath_prepend(str(ROOT / "benchmarks"))


@pytest.fixture
def audits(scripts: None) -> ModuleType:
    return importlib.import_module("engine_audits")


@pytest.fixture
def linkage(scripts: None) -> ModuleType:
    return importlib.import_module("linkage")


@pytest.fixture
def engines(scripts: None) -> ModuleType:
    return importlib.import_module("engines")


def rods(linkage: ModuleType, start: np.ndarray, corners: bool = False) -> object:
    """Two rods of 1 m, 1 kg and 2 kg, in a row, the first one's end on the second one's beginning."""
    half = np.array([0.5, 0.0])
    pin = linkage.Pin(0, half, 1, -half)
    feet = (linkage.Corner(0, -half), linkage.Corner(1, half)) if corners else ()
    return linkage.Linkage(np.array([1.0, 2.0]), np.array([1.0, 2.0]) / 12.0, (pin,), feet, 0.5, G, start)


def straight(height: float) -> np.ndarray:
    return np.array([[0.5, height, 0, 0, 0, 0], [1.5, height, 0, 0, 0, 0]], dtype=float)


def test_gap_is_how_far_a_joint_is_open(audits: ModuleType, linkage: ModuleType) -> None:
    open_ = straight(1.0)
    open_[1, :2] += [3e-3, 4e-3]
    assert audits.gap(rods(linkage, open_), np.stack([straight(1.0), open_])) == pytest.approx(5e-3)


def test_energy_of_rods_that_turn_and_fall(audits: ModuleType, linkage: ModuleType) -> None:
    states = straight(2.0)
    states[:, 4], states[:, 5] = 3.0, 4.0
    own = rods(linkage, straight(2.0))
    turning = 0.5 * (1.0 + 2.0) / 12.0 * 16.0
    assert audits.energy(own, states) == pytest.approx(0.5 * 3.0 * 9.0 + turning + 3.0 * G * 2.0)
    assert audits.drift(own, states[None]) == pytest.approx(0.5 * 3.0 * 9.0 + turning)


def test_a_bounce_is_found_where_it_is(audits: ModuleType, linkage: ModuleType) -> None:
    """Rods that fall flat from 1 m come up at √(2h/g); one end alone is missed where only the other one is known."""
    own, h, e, step = rods(linkage, straight(1.0), corners=True), 1.0, 0.5, 1e-3
    hit = math.sqrt(2.0 * h / G)
    t = step * np.arange(1, 601)
    after = np.maximum(t - hit, 0.0)
    y = np.where(t < hit, h - 0.5 * G * t**2, e * G * hit * after - 0.5 * G * after**2)
    v = np.where(t < hit, -G * t, e * G * hit - G * after)
    states = np.repeat(straight(0.0)[None], len(t), axis=0)
    states[:, :, 1], states[:, :, 4] = y[:, None], v[:, None]
    found = audits.strikes(own, states, step)
    assert [one.corner for one in found] == [0, 1]
    assert all(0.0 <= one.time - hit <= step for one in found)
    known = [audits.Strike(hit, 0), audits.Strike(hit, 1), audits.Strike(hit + 0.1, 1)]
    missed, late = audits.compare(found, known)
    assert missed == 1 and late <= step
    assert audits.compare(found[:1], known)[0] == 2


def test_tree_coordinates_keep_pins_shut_and_know_their_speeds(audits: ModuleType, linkage: ModuleType) -> None:
    """Rates of states are those of their differences."""
    random = np.random.default_rng(1)
    own = rods(linkage, straight(1.0))
    tree = linkage.as_tree(own)
    q, v, small = random.normal(size=4), random.normal(size=4), 1e-6
    before, now, after = (tree.states(q + s * v, v) for s in (-small, 0.0, small))
    assert np.abs((after - before)[:, :3] / (2 * small) - now[:, 3:]).max() < 1e-8
    assert audits.gap(own, now) < 1e-15
    assert np.abs(tree.states(np.zeros(4), tree.speeds()) - own.start).max() < 1e-15


@pytest.mark.parametrize("restitution", [0.3, 0.5, 0.7, 0.95])
def test_spring_and_damper_return_the_restitution(scripts: None, restitution: float) -> None:
    """Followed in numbers until they no longer push."""
    ratio = importlib.import_module("mujoco_linkage").damping_ratio(restitution)

    def push(_: float, y: np.ndarray) -> float:
        return float(-y[0] - 2.0 * ratio * y[1])

    push.terminal, push.direction = True, -1.0  # type: ignore[attr-defined]
    run = solve_ivp(lambda t, y: [y[1], push(t, y)], (0.0, 10.0), [-1e-12, -1.0], events=push, rtol=1e-10, atol=1e-12)
    assert run.y_events[0][0][1] == pytest.approx(restitution, abs=1e-6)


def test_engines_that_are_not_there_are_told(engines: ModuleType) -> None:
    absent = engines.Engine("none", "no_such_engine", True, lambda linkage, step: None)
    found, missing = engines.installed([absent])
    assert not found
    assert "no_such_engine" in missing["no_such_engine"]


def test_what_is_saved_is_read(engines: ModuleType, tmp_path: object) -> None:
    rows = [engines.Row("ring", "pymunk, 10 iterations", 1e-3, 12.3, 4.5, 1e-2, 2e-3, 3e-1, 0, 0.0)]
    path = tmp_path / "rows.csv"  # type: ignore[operator]
    engines.save(rows, path)
    assert engines.read(path) == rows


def test_tables_are_those_of_the_data(engines: ModuleType) -> None:
    """Else run benchmarks/engines.py --write."""
    assert engines.tables(engines.read(DATA)) in (ROOT / "docs" / "accuracy.md").read_text()


def test_every_motion_has_its_base(engines: ModuleType) -> None:
    rows = engines.read(DATA)
    assert {row.case for row in rows} == {case.name for case in engines.CASES}
    for case in engines.CASES:
        assert [r.ratio for r in rows if (r.case, r.tool, r.step) == (case.name, *engines.BASE)] == [1.0]


def test_first_impulse_of_the_ring(scripts: None) -> None:
    """As two other programs found it."""
    paper, accuracy = (importlib.import_module(name) for name in ("paper", "accuracy"))
    assert paper.first_impulse(1.0, G, 0.5) == pytest.approx(accuracy.IMPULSES[0], rel=1e-10)


@pytest.mark.slow
def test_the_page_of_the_paper_has_the_counts_of_now(scripts: None) -> None:
    """Else run docs/scripts/paper.py --write."""
    paper = importlib.import_module("paper")
    assert paper.count_table(paper.derived(anew=False)) in (ROOT / "docs" / "paper.md").read_text()
