"""The layers of the core: no file includes one of a later layer, and no files include each other in a circle."""

from __future__ import annotations

import re
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

from ..support.folders import ROOT

CORE = ROOT / "runtime" / "core"


def layers() -> list[str]:
    """The folders of the table in docs/architecture.md, in its order."""
    text = (ROOT / "docs" / "architecture.md").read_text()
    section = text.partition("## The core in C")[2].partition("Where is")[0]
    return re.findall(r"^\| `(\w+)` \|", section, re.M)


def includes() -> dict[str, list[str]]:
    """Per file of the core, as folder/name, what it includes of the core, likewise."""
    files = sorted(path for suffix in "ch" for path in CORE.rglob(f"*.{suffix}"))
    return {
        str(path.relative_to(CORE)): [
            name for name in re.findall(r'^#include "([^"]+)"', path.read_text(), re.M) if not name.startswith("../")
        ]
        for path in files
    }


def test_every_folder_is_a_layer() -> None:
    assert sorted(layers()) == sorted(path.name for path in CORE.iterdir() if path.is_dir())
    assert not [path.name for path in CORE.iterdir() if path.is_file()]


def test_no_file_includes_a_later_layer() -> None:
    order = {name: place for place, name in enumerate(layers())}
    wrong = [
        f"{file} includes {name}"
        for file, names in includes().items()
        for name in names
        if order[name.partition("/")[0]] > order[file.partition("/")[0]]
    ]
    assert not wrong


def test_no_circle_of_files() -> None:
    """A header and the source that it belongs to are one here."""
    graph = {file.removesuffix(".c").removesuffix(".h"): set[str]() for file in includes()}
    for file, names in includes().items():
        own = file[:-2]
        graph[own] |= {name[:-2] for name in names} - {own}
    try:
        tuple(TopologicalSorter(graph).static_order())
    except CycleError as circle:
        pytest.fail(" includes ".join(circle.args[1]))


def test_the_checks_see_a_wrong_include(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A file of the first layer that includes one of the last is told by both."""
    for name in layers():
        (tmp_path / name).mkdir()
    first, last = layers()[0], layers()[-1]
    (tmp_path / first / "a.h").write_text(f'#include "{last}/b.h"\n')
    (tmp_path / last / "b.h").write_text(f'#include "{first}/a.h"\n')
    monkeypatch.setitem(globals(), "CORE", tmp_path)
    with pytest.raises(AssertionError, match=r"a\.h includes"):
        test_no_file_includes_a_later_layer()
    with pytest.raises(pytest.fail.Exception, match="includes"):
        test_no_circle_of_files()
