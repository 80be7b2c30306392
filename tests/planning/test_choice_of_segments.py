"""Segments: which rows of links are cut into them, and where they are taken."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from ccgen.generator import generate, loop
from ccgen.generator.pipeline import derive_scene, plan_scene
from ccgen.generator.planning.choose import IN_SEGMENTS, TIP_TO_ROOT
from ccgen.generator.planning.segments import APART, SEGMENTS
from ccgen.generator.program.dialects import C
from ccgen.generator.program.program import lower
from ccgen.generator.program.routine import LANES, Routines
from ccgen.generator.scene import read_tables
from ccgen.runtime import load_model

from ..support.planned_mechanisms import ring_of
from ..support.tiers import hard
from ..support.workshop import Workshop


def test_long_rings_go_in_segments() -> None:
    """Four segments of a ring as long as they can be; what is left over stays with the root."""
    topology, choice = plan_scene(loop(50))
    assert choice.plan.name == IN_SEGMENTS
    assert [len(segment) for segment in choice.plan.modules] == [12] * 4
    assert sum(choice.plan.modules, ()) == tuple(range(2, 50))
    assert choice.plan.severed == (2, 14, 26, 38)
    assert [cut.joint for cut in topology.cuts] == [
        next(j for j in (0, 49) if j not in {b.joint for b in topology.branches})
    ]
    assert plan_scene(loop(50), TIP_TO_ROOT)[1].plan.severed == ()
    with pytest.raises(
        ValueError, match="found 'segments', expected 'tip to root': no loop has a row of 20 links alike"
    ):
        plan_scene(loop(12), IN_SEGMENTS)


def test_rows_end_at_unlike_links() -> None:
    """Where a link's centre of mass is off its line and its neighbours' are not, their equations differ."""

    def longest(odd: int) -> int:
        coms = [[0.5, 0.1 * (k == odd)] for k in range(49)]
        plan = plan_scene(ring_of(49, com=coms))[1].plan
        return len(plan.modules[0]) if plan.name == IN_SEGMENTS else 0

    assert [longest(odd) for odd in (-1, 0, 1, 24, 36, 48)] == [12, 12, 11, 6, 0, 0]


@pytest.mark.parametrize("compiled", [False, hard(True)])
def test_links_that_do_not_resist_a_motion_are_in_no_segment(compiled: bool, workshop: Workshop) -> None:
    """Point masses on their inner or outer pin, or between: the ends of a segment would have no inertia."""
    points = {"A": [0.0, 0.0], "B": [1.0, 0.0]}
    joints = [{"between": [f"link{k}.B", f"link{(k + 1) % 44}.A"]} for k in range(44)]
    start = {"angles": [2.0 * math.pi * k / 44 for k in range(44)]}
    for com in (0.0, 0.5, 1.0):
        own = [(0.0, com) if 9 < k < 15 else (0.1, 0.5) for k in range(44)]
        links = [
            {"name": f"link{k}", "mass": 1.0, "inertia": inertia, "com": [x, 0.0], "points": points}
            for k, (inertia, x) in enumerate(own)
        ]
        name = f"points{10 * com:.0f}"
        scene = read_tables({"link": links, "joint": joints, "start": start}, name, name)
        choice = plan_scene(scene)[1]
        assert choice.plan.name == IN_SEGMENTS
        assert min(link for segment in choice.plan.modules for link in segment) >= 15
        if compiled:
            model = workshop.model(scene)
            assert np.all(np.isfinite(model.acceleration(*model.start())))


def test_light_links_and_forces_keep_the_order_from_tip_to_root(tmp_path: Any) -> None:
    """They cost digits at the ends of segments, or make segments unequal."""
    masses = [1.0] * 44
    assert plan_scene(ring_of(44, mass=masses))[1].plan.name == IN_SEGMENTS
    masses[30] = 1e-3
    assert plan_scene(ring_of(44, mass=masses))[1].plan.name == TIP_TO_ROOT
    pulled = loop(44, spring=[{"between": ["link_3.A", "link_9.A"], "stiffness": 10.0, "length": 1.0}])
    assert plan_scene(pulled)[1].plan.name == TIP_TO_ROOT
    assert plan_scene(pulled, IN_SEGMENTS)[1].plan.name == IN_SEGMENTS


@pytest.mark.hard
def test_segments_keep_their_digits_as_far_as_masses_may_differ(tmp_path: Any) -> None:
    """Light links at the ends of all segments, beside the same in wide numbers from tip to root."""
    masses = [1.0 if k not in (8, 13, 18, 23) else 1.0 / APART for k in range(24)]
    scene = ring_of(24, mass=masses)
    own = load_model(generate(scene, out=tmp_path, plan=IN_SEGMENTS))
    wide = load_model(generate(scene, out=tmp_path, plan=TIP_TO_ROOT, precision="wide"))
    rng = np.random.default_rng(1)
    for _ in range(3):
        start = own.start()[0] + 0.05 * rng.normal(size=26)
        q, u = own.project(start, rng.normal(size=26))
        wanted = wide.acceleration(q.astype(np.longdouble), u.astype(np.longdouble))
        assert np.abs(own.acceleration(q, u) - wanted).max() <= 1e-14 * np.abs(wanted).max()


def test_there_are_as_many_segments_as_lanes() -> None:
    assert SEGMENTS == LANES


@pytest.mark.hard
def test_segments_are_taken_only_where_they_go_side_by_side() -> None:
    """Folded numbers that differ leave no equal statements, and floats and wide numbers have no vectors."""
    unequal = ring_of(24, mass=[1.0 if k % 7 else 2.0 for k in range(24)])
    periodic = ring_of(24, mass=[1.0 if k % 5 else 2.0 for k in range(24)])
    for scene, fold, vectors, wanted in (
        (unequal, False, True, IN_SEGMENTS),
        (unequal, True, True, TIP_TO_ROOT),
        (ring_of(24), True, True, IN_SEGMENTS),
        (periodic, True, True, IN_SEGMENTS),
        (ring_of(24), False, False, TIP_TO_ROOT),
    ):
        topology, choice = plan_scene(scene, fold=fold, vectors=vectors)
        assert choice.plan.name == wanted
        if vectors:
            program = lower(derive_scene(scene, fold, choice=choice)[1])
            side_by_side = Routines(program, C.term).one_by_one("acceleration").modules
            assert bool(side_by_side) == (wanted == IN_SEGMENTS), topology
