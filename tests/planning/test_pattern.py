"""The pattern by which plans are counted has every entry that the forms have."""

from __future__ import annotations

import dataclasses
from typing import Any

import pytest

from ccgen.generator.derive.derivation import derive
from ccgen.generator.derive.gibbs import Recursion
from ccgen.generator.pipeline import plan_scene
from ccgen.generator.planning.choose import PLANS
from ccgen.generator.planning.pattern import Pattern, Sweep

from ..oracles import graphs
from ..support.large_mechanisms import scene_of
from ..support.planned_mechanisms import MECHANISMS, ROWS
from ..support.tiers import all_hard_but


@pytest.mark.sample(5)
@pytest.mark.parametrize("plan", PLANS)
@pytest.mark.parametrize(
    "name", all_hard_but("four-bar", "one leg", "theta", "near chain", "hinged ring", of=MECHANISMS | ROWS)
)
def test_the_pattern_has_every_entry_of_the_forms(
    name: str, plan: str, tmp_path: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Link by link, as gathered: what is not zero in a form is an entry of its pattern."""
    scene = scene_of(graphs.mechanism("mechanism", (MECHANISMS | ROWS)[name], seed=5), tmp_path)
    if plan not in dict(plan_scene(scene)[1].costs):
        pytest.skip("it has no such plan")
    topology, choice = plan_scene(scene, plan)
    forms: dict[int, set[Any]] = {}
    patterns: dict[int, set[Any]] = {}
    eliminate = Recursion._eliminate

    def gathered(self: Recursion, link: int, form: Any, eliminator: Any) -> Any:
        forms.setdefault(link, {key for key, entry in form.hessian.items() if entry != 0})
        return eliminate(self, link, form, eliminator)

    def told(link: int, pattern: Pattern) -> Any:
        patterns[link] = set(pattern.entries)
        return choice.plan.at(link)

    monkeypatch.setattr(Recursion, "_eliminate", gathered)
    first_only = dataclasses.replace(choice.plan, otherwise=None)
    derive(scene.mechanism, topology, first_only, scene.effects)
    Sweep(scene.mechanism, topology, scene.driven, choice.plan.severed).run(told)
    assert forms.keys() == patterns.keys()
    for link, entries in forms.items():
        assert entries <= patterns[link], link
