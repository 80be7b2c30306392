"""Numbers of scenes are the same in every Python: from 3.12 on its ``sum`` compensates floats; none is summed by it."""

from __future__ import annotations

import ast
import builtins
import math
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import pytest

from ccgen.generator import load_scene
from ccgen.generator.mechanism.totals import total

from ..support.folders import ROOT

SCENES = sorted((*ROOT.glob("scenes/*.toml"), *ROOT.glob("scenes/gallery/*.toml")))
COUNTS = {"len", "bool", "isdigit"}
NO_FLOATS = {
    "documents/latex.py _matrix",
    "effect_base/arithmetic.py _check",
    "effect_base/compliance.py scale",
    "effect_base/rows_in_time.py _powers",
    "mechanism/uniform_bodies.py polygon",
    "planning/choose.py _in_segments",
    "planning/choose.py _summed",
    "planning/pattern.py run",
    "planning/trees.py _close",
    "planning/trees.py operations",
}
"""Functions that sum whole numbers, fractions or expressions, which their text does not show."""


def counted(element: ast.expr) -> bool:
    """Whether an element is a whole number by what is written: a count, a comparison, a literal."""
    if isinstance(element, ast.Constant):
        return isinstance(element.value, int)
    if isinstance(element, ast.IfExp):
        return counted(element.body) and counted(element.orelse)
    if isinstance(element, ast.BinOp):
        return counted(element.left) and counted(element.right)
    if isinstance(element, ast.Call):
        called = element.func
        return (called.attr if isinstance(called, ast.Attribute) else getattr(called, "id", "")) in COUNTS
    return isinstance(element, ast.Compare) or (isinstance(element, ast.UnaryOp) and isinstance(element.op, ast.Not))


def sums(tree: ast.AST) -> Iterator[ast.expr]:
    """What the built-in ``sum`` adds, where it begins with no number of another type and it may be no count."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "sum":
            added = node.args[0]
            mapped = isinstance(added, ast.Call) and ast.unparse(added).startswith("map(len,")
            element = added.elt if isinstance(added, ast.GeneratorExp | ast.ListComp) else added
            if len(node.args) == 1 and not mapped and not counted(element):
                yield element


def test_no_floats_are_summed_by_the_built_in() -> None:
    found = set()
    for file in sorted((ROOT / "generator").rglob("*.py")):
        for function in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(function, ast.FunctionDef) and any(sums(function)):
                found.add(f"{file.relative_to(ROOT / 'generator').as_posix()} {function.name}")
    assert found == NO_FLOATS


@pytest.mark.parametrize("scene", SCENES, ids=lambda path: path.stem)
def test_none_is_where_scenes_are_read(scene: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    usual = sum

    def watched(parts: Iterable[Any], /, start: Any = 0) -> Any:
        whole = list(parts)
        inside = "generator" in Path(sys._getframe(1).f_code.co_filename).parts
        floats = [part for part in whole if isinstance(part, float | complex)]
        assert not (inside and len(floats) > 1), "found floats in the built-in sum, expected total"
        return usual(whole, start)

    monkeypatch.setattr(builtins, "sum", watched)
    load_scene(scene)


def test_a_total_adds_one_after_the_other() -> None:
    """0.1 ten times is not 1.0 then, as it is by compensated and by exact sums."""
    tenths = [0.1] * 10
    assert total(tenths) == 0.1 + 0.1 + 0.1 + 0.1 + 0.1 + 0.1 + 0.1 + 0.1 + 0.1 + 0.1 == 0.9999999999999999
    assert math.fsum(tenths) == 1.0
    assert total([0.1j] * 10) == 0.9999999999999999j
    assert total([]) == 0.0
