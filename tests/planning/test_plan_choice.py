"""Which order of elimination is taken, what is told of it and of others, and prices by one kind of plan."""

from __future__ import annotations

import re
from typing import Any

import pytest

from ccgen.generator import load_scene, loop
from ccgen.generator.derive.derivation import derive
from ccgen.generator.documents.show import show_text
from ccgen.generator.mechanism.topology import Topology, span
from ccgen.generator.pipeline import Variant, fold_price, plan_scene, prices
from ccgen.generator.planning.choose import DYADS, TIP_TO_ROOT, choose
from ccgen.generator.program.program import lower
from ccgen.generator.scene.scene import Scene

from ..support.folders import ROOT
from ..support.large_mechanisms import operations


@pytest.mark.hard
def test_the_order_is_told(tmp_path: Any) -> None:
    """What a walking machine closes and leaves open, and the operations of each plan as its program has them."""
    scene = load_scene(ROOT / "scenes" / "strandbeest.toml")
    text = show_text(scene, False, False, equations=False)
    taken, other = operations(scene, DYADS), operations(scene, TIP_TO_ROOT)
    assert re.search(rf"order +dyads: {taken} operations of the acceleration, \d+ of them one after the other\n", text)
    assert f" tip to root: {other} operations, {other / taken:.2g} times as many, " in text
    assert "closed as dyads, the outermost first: " in text and "left open until then: shaft" in text


def test_why_a_plan_with_fewer_operations_is_not_taken() -> None:
    scene = load_scene(ROOT / "scenes" / "four-bar.toml")
    text = " ".join(show_text(scene, False, False, equations=False).split())
    few = operations(scene, DYADS)
    assert f"dyads: {few} operations, 0.64 times as many, " in text
    assert "taken only where they are 1.8 times fewer, since dyads divide by sines" in text
    text = show_text(scene, False, False, equations=False, plan=DYADS)
    assert f"dyads: {few} operations of the acceleration" in text and "1.6 times as many" in text
    with pytest.raises(ValueError, match="found 'segments', expected 'tip to root': no loop"):
        show_text(scene, False, False, plan="segments")


@pytest.mark.slow
def test_of_segments_the_chain_is_told() -> None:
    """A ring in segments has more operations, four at a time, and fewer that wait for each other."""
    text = " ".join(show_text(loop(24), False, False, equations=False).split())
    found = re.search(r"order segments: (\d+) .*?, (\d+) of them .*? tip to root: (\d+) .*?, (\d+) of them", text)
    assert found
    own, chain, others, longer = map(int, found.groups())
    assert own > others and chain < longer


def test_a_ring_keeps_the_order_from_tip_to_root() -> None:
    choice = plan_scene(loop(12))[1]
    assert choice.plan.name == TIP_TO_ROOT
    assert [name for name, _ in choice.costs] == [TIP_TO_ROOT]
    with pytest.raises(ValueError, match="found 'dyads', expected 'tip to root': the mechanism has no dyad to close"):
        plan_scene(loop(12), DYADS)
    with pytest.raises(ValueError, match="found 'best', expected 'tip to root', 'dyads' or 'segments'"):
        plan_scene(loop(12), "best")
    assert str(Variant(plan="")) != str(Variant())  # so that no model of the default plan stands for a wrong name
    with pytest.raises(ValueError, match="found '', expected 'tip to root', 'dyads' or 'segments'"):
        plan_scene(loop(12), "")


@pytest.mark.hard
def test_prices_compare_programs_of_one_plan() -> None:
    """A spring's force keeps a ring from segments; what it costs is its own operations, not those of another plan."""
    spring = {"between": ["link_3.A", "link_9.A"], "stiffness": 10.0, "length": 1.0}
    (gravity, stretched) = prices(loop(24, gravity=True, spring=[spring]))
    assert gravity.added["acceleration"].total == 1
    assert 15 <= stretched.added["acceleration"].total <= 40
    assert -150 <= fold_price(loop(24, gravity=True)).added["acceleration"].total < 0


@pytest.mark.slow
def test_a_drive_has_a_price_by_the_same_kind_of_plan() -> None:
    """Without it, its joint has an acceleration more to solve for."""
    driven = load_scene(ROOT / "scenes" / "jansen-driven.toml")
    (index,) = [number for number, effect in enumerate(driven.effects) if effect.driven()]
    found = prices(driven)[index].added["acceleration"].total
    assert found == operations(driven, TIP_TO_ROOT) - operations(driven.without(index), TIP_TO_ROOT) < 0


@pytest.mark.hard
def test_the_order_from_tip_to_root_is_judged_on_its_best_tree() -> None:
    """Also where it is asked for, and where dyads are compared with it."""
    scene = load_scene(ROOT / "scenes" / "strandbeest.toml")
    short = dict(choose(scene.mechanism, span(scene.mechanism), (), ()).costs)[TIP_TO_ROOT]
    topology, asked = plan_scene(scene, TIP_TO_ROOT)
    taken = plan_scene(scene)[1]
    assert taken.plan.name == DYADS
    assert dict(asked.costs)[TIP_TO_ROOT] == dict(taken.costs)[TIP_TO_ROOT] < 0.7 * short
    assert topology != span(scene.mechanism)
    assert operations(scene, TIP_TO_ROOT) < 0.75 * _on(scene, span(scene.mechanism))


def _on(scene: Scene, topology: Topology) -> int:
    plan = choose(scene.mechanism, topology, (), (), TIP_TO_ROOT).plan
    return lower(derive(scene.mechanism, topology, plan, scene.effects)).function("acceleration").counts().total
