"""Where large mechanisms are cut and rooted: fewer operations than on the tree of short branches, or that tree."""

from __future__ import annotations

import dataclasses
import math
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from ccgen.generator import load_scene, loop, pinned
from ccgen.generator.mechanism.mechanism import Mechanism
from ccgen.generator.mechanism.topology import Topology, span
from ccgen.generator.pipeline import plan_scene
from ccgen.generator.planning import trees
from ccgen.generator.planning.choose import TIP_TO_ROOT, choose
from ccgen.generator.planning.trees import GAIN, other_tree
from ccgen.generator.scene import read_tables

from ..oracles import graphs
from ..oracles.maximal import GROUND
from ..support.folders import ROOT
from ..support.large_mechanisms import near_chain, operations, scene_of, walking

NEAR_CHAINS = {
    "afloat": near_chain(24, 6, 2),
    "longer": near_chain(40, 10, 3),
    "on the ground": [(GROUND, 0), *near_chain(30, 7, 1)],
}


def from_tip_to_root(mechanism: Mechanism, topology: Topology) -> int:
    return dict(choose(mechanism, topology, (), ()).costs)[TIP_TO_ROOT]


def drawn(name: str, edges: graphs.Edges, tmp_path: Any) -> Mechanism:
    return scene_of(graphs.mechanism(name, edges, seed=5), tmp_path).mechanism


@pytest.mark.sample(1)
@pytest.mark.slow
@pytest.mark.parametrize("name", NEAR_CHAINS)
def test_another_tree_takes_fewer_operations(name: str, tmp_path: Any) -> None:
    """It spans the same links, cuts as many joints, and stays on the ground; the same tree is found again."""
    scene = scene_of(graphs.mechanism("mechanism", NEAR_CHAINS[name], seed=5), tmp_path)
    mechanism = scene.mechanism
    short, found = span(mechanism), plan_scene(scene)[0]
    assert GAIN * from_tip_to_root(mechanism, found) < from_tip_to_root(mechanism, short)
    assert {found.root, *(b.link for b in found.branches)} == {short.root, *(b.link for b in short.branches)}
    joints = sorted([branch.joint for branch in found.branches] + [cut.joint for cut in found.cuts])
    assert joints == list(range(len(mechanism.joints)))
    assert found.floating == short.floating
    assert found == other_tree(mechanism, short, ())
    assert from_tip_to_root(mechanism, other_tree(mechanism, found, ())) <= from_tip_to_root(mechanism, found)


@pytest.mark.slow
def test_what_is_written_takes_fewer_too(tmp_path: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    scene = scene_of(graphs.mechanism("mechanism", NEAR_CHAINS["afloat"], seed=5), tmp_path)
    found = operations(scene)
    monkeypatch.setattr(trees, "LARGE", math.inf)
    assert found < operations(scene)


@pytest.mark.parametrize("path", sorted((ROOT / "scenes").glob("*.toml")), ids=lambda path: path.stem)
def test_scenes_keep_the_tree_of_short_branches(path: Path) -> None:
    """But the scissor lift, a row of loops, of which another takes fewer operations."""
    scene = load_scene(path)
    found, short = plan_scene(scene)[0], span(scene.mechanism, scene.driven)
    if path.stem == "scissor-lift":
        assert GAIN * from_tip_to_root(scene.mechanism, found) < from_tip_to_root(scene.mechanism, short)
    else:
        assert found == short


def test_rings_rows_and_what_walks_keep_it(tmp_path: Any) -> None:
    legs = scene_of(graphs.mechanism("legs", walking(3), seed=5), tmp_path)
    for scene, plan in ((loop(32), TIP_TO_ROOT), (pinned(32), TIP_TO_ROOT), (legs, None)):
        assert plan_scene(scene, plan)[0] == span(scene.mechanism)


def test_driven_joints_stay_in_the_tree(tmp_path: Any) -> None:
    mechanism = drawn("mechanism", NEAR_CHAINS["longer"], tmp_path)
    driven = [cut.joint for cut in other_tree(mechanism, span(mechanism), ()).cuts][:2]
    found = other_tree(mechanism, span(mechanism, driven), driven)
    assert found != span(mechanism, driven)
    assert set(driven) <= {branch.joint for branch in found.branches}


def test_links_without_inertia_keep_the_tree(tmp_path: Any) -> None:
    mechanism = drawn("mechanism", NEAR_CHAINS["longer"], tmp_path)
    light = dataclasses.replace(mechanism.links[3], inertia=None)
    links = (*mechanism.links[:3], light, *mechanism.links[4:])
    mechanism = dataclasses.replace(mechanism, links=links)
    short = span(mechanism)
    assert other_tree(mechanism, short, ()) is short


@pytest.mark.hard
def test_the_same_tree_under_other_hash_seeds(tmp_path: Any) -> None:
    path = tmp_path / "mechanism.toml"
    path.write_text(graphs.mechanism("mechanism", NEAR_CHAINS["afloat"], seed=5).toml())
    program = (
        "from ccgen.generator import load_scene; from ccgen.generator.pipeline import plan_scene; "
        f"found = plan_scene(load_scene({str(path)!r}))[0]; print(found.root, found.branches, found.cuts)"
    )
    printed = {
        subprocess.run(
            [sys.executable, "-c", program],
            env=os.environ | {"PYTHONHASHSEED": str(seed)},
            check=True,
            capture_output=True,
            text=True,
            timeout=300,
        ).stdout
        for seed in (0, 1, 2)
    }
    assert len(printed) == 1


def test_the_search_ends_when_its_work_is_done(monkeypatch: pytest.MonkeyPatch) -> None:
    """In the middle of a pass too: a row of 200 four-bars has 200 loops with three pins each to cut."""
    searches = []

    class Told(trees._Search):
        def __init__(self, *arguments: Any) -> None:
            super().__init__(*arguments)
            searches.append(self)

    monkeypatch.setattr(trees, "_Search", Told)
    cells = 200
    names = [*(f"upright{k}" for k in range(cells + 1)), *(f"bar{k}" for k in range(cells))]
    rod = {"mass": 1.0, "inertia": 0.1, "com": [0.5, 0.0], "points": {"A": [0.0, 0.0], "B": [1.0, 0.0]}}
    joints = [{"between": [f"ground.A{k}", f"upright{k}.A"]} for k in range(cells + 1)]
    for k in range(cells):
        joints += [{"between": [f"upright{k}.B", f"bar{k}.A"]}, {"between": [f"bar{k}.B", f"upright{k + 1}.B"]}]
    tables = {
        "ground_link": {"points": {f"A{k}": [float(k), 0.0] for k in range(cells + 1)}},
        "link": [{"name": name, **rod} for name in names],
        "joint": joints,
        "start": {"angles": [1.2] * (cells + 1) + [0.0] * cells},
    }
    mechanism = read_tables(tables, "row", "row").mechanism
    short = span(mechanism)
    monkeypatch.setattr(trees, "WORK", 100_000)
    other_tree(mechanism, short, ())
    (search,) = searches
    once = search.work
    search.work = 0
    search.operations(trees._Tree(short.root, frozenset(branch.joint for branch in short.branches)))
    assert trees.WORK <= once <= trees.WORK + 3 * search.work
