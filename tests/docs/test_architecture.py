"""The picture of the core's layers and the table of its sizes are those of its files."""

from __future__ import annotations

import importlib.util
import re
from pathlib import Path
from types import ModuleType

import pytest

from ..support.folders import ROOT


@pytest.fixture(scope="module")
def script() -> ModuleType:
    spec = importlib.util.spec_from_file_location("architecture", ROOT / "docs" / "scripts" / "architecture.py")
    assert spec and spec.loader
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_picture_is_that_of_the_includes(script: ModuleType) -> None:
    """Else run docs/scripts/architecture.py --write."""
    assert script.picture() in script.PAGE.read_text()


def test_the_picture_leads_wherever_a_layer_includes_from(script: ModuleType) -> None:
    """Along its arrows, and nowhere else; no arrow follows from others."""
    arrows = re.findall(r"^    (\w+) --> (\w+)$", script.picture(), re.MULTILINE)

    def reached(start: str, left_out: tuple[str, str] | None = None) -> set[str]:
        to = {end for begin, end in arrows if begin == start and (begin, end) != left_out}
        return to.union(*(reached(one, left_out) for one in to))

    for layer, names in script.includes().items():
        assert names <= reached(layer), layer
    for begin, end in arrows:
        assert end not in reached(begin, (begin, end)), (begin, end)
        assert end in script.includes()[begin]


def test_functions_are_counted(script: ModuleType, tmp_path: Path) -> None:
    file = tmp_path / "a.c"
    head = "static const double A = 1.0;\n\n/* b\n * c */\nstatic int one(int a,\n               int b)\n"
    file.write_text(head + "{\n    return 1;\n}\n")
    assert script.functions(file) == [("one", 5)]


def test_functions_of_the_core_fit_on_a_screen(script: ModuleType) -> None:
    """Of 60 lines, but for a list: all that a hybrid state is made of."""
    long = {
        name: lines
        for layer in script.layers()
        for file in script.files(layer)
        for name, lines in script.functions(file)
        if lines > script.SCREEN
    }
    assert long.keys() <= {"walk"}


def test_where_is_names_files_and_what_stands_in_them() -> None:
    """Each file is there, of the core or of the generator, and each name of a row stands in one of its files."""
    page = (ROOT / "docs" / "architecture.md").read_text()
    rows = re.findall(r"^\| .*$", page[page.index("Where is …") : page.index("**Memory.**")], re.MULTILINE)[1:]
    assert len(rows) > 8
    for row in rows:
        spans = re.findall(r"`([^`]+)`", row)
        files = [span for span in spans if "/" in span]
        names = [span for span in spans if "/" not in span]
        texts = [
            (ROOT if file.startswith("generator/") else ROOT / "runtime" / "core").joinpath(file).read_text()
            for file in files
        ]
        missing = [name for name in names if not any(re.search(rf"\b{name}\b", text) for text in texts)]
        assert files and names and not missing, (row, missing)
