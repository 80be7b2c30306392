"""Layers: docs/architecture.md says what stands on what, and no module imports otherwise, at its top or in a function.

Imports for type checkers count too: what a module must name to say what it takes, it knows.
"""

from __future__ import annotations

import ast
import re
import sys
import tomllib
from collections.abc import Iterator
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

from ..support.folders import ROOT

PACKAGES = {"generator": "## The generator", "runtime": "## The runtime's Python"}
COMPILED = ("_core",)
"""Modules that are no Python files; which of them a model's numbers need is decided when it is loaded."""

Layers = dict[str, frozenset[str]]
"""Files and folders of a package from the lowest on, each with those that it stands on."""


@cache
def layers(package: str) -> Layers:
    """The package's table: a row names one or several layers, what they do, and what they stand on."""
    text = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    section = text.partition(f"{PACKAGES[package]}\n")[2].partition("\n## ")[0]
    rows = [line.split("|")[1:-1] for line in section.splitlines() if line.startswith("| `")]
    found: Layers = {}
    for names, _, below in rows:
        found |= dict.fromkeys(re.findall(r"`([^`]+)`", names), frozenset(re.findall(r"`([^`]+)`", below)))
    return found


def modules(package: str) -> dict[str, Path]:
    """All Python files by the names of their modules, ``runtime.model.drives``."""
    files = sorted((ROOT / package).rglob("*.py"))
    return {".".join(file.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__"): file for file in files}


def layer_of(module: str, package: str) -> str:
    """The row that a module belongs to."""
    rest = module.removeprefix(package).removeprefix(".")
    top = rest.partition(".")[0]
    if top in COMPILED:
        return top
    if not top:
        return "__init__.py"
    return f"{top}/" if (ROOT / package / top).is_dir() else f"{top}.py"


def imported(module: str, file: Path) -> Iterator[str]:
    """Names of what a module imports, from anywhere: names that it takes out of a module stand behind that module's."""
    here = module.split(".") if file.name == "__init__.py" else module.split(".")[:-1]
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            start = here[: len(here) - node.level + 1] if node.level else []
            base = ".".join([*start, *([node.module] if node.module else [])])
            yield from (f"{base}.{alias.name}" for alias in node.names)


@cache
def graph(package: str) -> dict[str, frozenset[str]]:
    """Modules of the package that each of its modules imports, compiled ones among them."""
    known = modules(package)
    names = {*known, *(f"{package}.{name}" for name in COMPILED)}

    def target(name: str) -> str | None:
        return next((found for found in (name, name.rpartition(".")[0]) if found in names), None)

    return {
        module: frozenset(found for name in imported(module, file) if (found := target(name)) and found != module)
        for module, file in known.items()
    }


@pytest.mark.parametrize("package", PACKAGES)
def test_the_table_names_every_file_and_folder(package: str) -> None:
    there = {layer_of(module, package) for module in modules(package)}
    assert set(layers(package)) - set(COMPILED) == there
    assert all(below <= set(layers(package)) for below in layers(package).values())


@pytest.mark.parametrize("package", PACKAGES)
def test_layers_stand_on_lower_ones(package: str) -> None:
    order = list(layers(package))
    upwards = [
        (layer, one)
        for layer, below in layers(package).items()
        for one in below
        if one not in order[: order.index(layer)]
    ]
    assert upwards == []


@pytest.mark.parametrize("package", PACKAGES)
def test_modules_import_what_their_layer_stands_on(package: str) -> None:
    """And the table names nothing that no module of the layer imports."""
    used: dict[str, set[str]] = {layer: set() for layer in layers(package)}
    wrong = []
    for module, found in graph(package).items():
        layer = layer_of(module, package)
        for one in found:
            below = layer_of(one, package)
            if below != layer:
                used[layer].add(below)
                wrong += [f"{module} imports {one}"] * (below not in layers(package)[layer])
    assert wrong == []
    assert used == {layer: set(below) for layer, below in layers(package).items()}


@pytest.mark.parametrize("package", PACKAGES)
def test_modules_import_in_no_circle(package: str) -> None:
    try:
        TopologicalSorter(graph(package)).prepare()
    except CycleError as error:
        pytest.fail(f"a circle: {' imports '.join(reversed(error.args[1]))}")


def test_the_runtime_never_imports_the_generator_nor_sympy() -> None:
    for module, file in modules("runtime").items():
        found = [name for name in imported(module, file) if name.partition(".")[0] in ("ccgen", "generator", "sympy")]
        assert found == [], module


def test_the_front_imports_both_packages_where_they_are_used() -> None:
    """At its top nothing but the standard library; neither package imports it."""
    tree = ast.parse((ROOT / "front" / "__init__.py").read_text(encoding="utf-8"))
    first = [node for node in tree.body if isinstance(node, ast.Import | ast.ImportFrom)]
    names = {node.module if isinstance(node, ast.ImportFrom) else node.names[0].name for node in first}
    assert {str(name).partition(".")[0] for name in names} <= set(sys.stdlib_module_names)
    for package in PACKAGES:
        for module, file in modules(package).items():
            assert not [
                name for name in imported(module, file) if name in ("ccgen", "front") or name[:6] == "front."
            ], module


def test_the_generator_imports_the_runtime_in_its_command_line_only() -> None:
    for module, file in modules("generator").items():
        found = [name for name in imported(module, file) if name.partition(".")[0] in ("ccgen", "runtime")]
        assert found == [] or module.startswith("generator.cli."), module
        assert all(name.startswith("ccgen.runtime") for name in found), module


def test_the_check_sees_imports_wherever_they_stand(tmp_path: Path) -> None:
    file = tmp_path / "drives.py"
    file.write_text(
        "import ccgen.runtime\nfrom typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from .model import Model\n"
        "def late():\n    from ..run import Run\n    from .. import simulate as go\n"
    )
    wanted = {
        "ccgen.runtime",
        "typing.TYPE_CHECKING",
        "runtime.model.model.Model",
        "runtime.run.Run",
        "runtime.simulate",
    }
    assert set(imported("runtime.model.drives", file)) == wanted


WITH = {"pydantic_core": "pydantic", "annotated_types": "pydantic", "PIL": "pillow"}
"""Modules by the distributions that bring them, where the names differ."""


def test_what_is_imported_is_required() -> None:
    """Else a command fails on a machine that has no more than what the package asks for."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    named = [
        *project["dependencies"],
        *(one for name in ("data", "zig") for one in project["optional-dependencies"][name]),
    ]
    required = {re.match(r"[\w-]+", one)[0] for one in named}
    found = {
        name.partition(".")[0] for package in PACKAGES for item in modules(package).items() for name in imported(*item)
    }
    others = found - set(sys.stdlib_module_names) - set(PACKAGES) - {"ccgen"}
    assert {WITH.get(name, name) for name in others} <= required
