"""The picture of the automaton is that of its table, and every stage is in it."""

from __future__ import annotations

import importlib.util
import re

from ..support.folders import ROOT


def test_the_picture_is_that_of_the_table() -> None:
    spec = importlib.util.spec_from_file_location("automaton", ROOT / "docs" / "scripts" / "automaton.py")
    assert spec and spec.loader
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    shown = re.findall(r"```mermaid\n(.*?)\n```", (ROOT / "docs" / "events.md").read_text(), re.S)
    assert shown == [module.diagram()]
    header = (ROOT / "runtime" / "core" / "hybrid" / "automaton.h").read_text()
    stages = re.findall(r"^    ([A-Z]+),", header.partition("enum stage {")[2].partition("};")[0], re.M)
    assert list(module.NAMES) == stages
    for stage in stages:
        assert re.search(rf" {stage}\b.* -->|--> {stage}\b", shown[0]), stage
