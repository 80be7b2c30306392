"""What docs/extending.md says to write, written into a copy of ccgen."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

from .folders import ROOT

TEXT = (ROOT / "docs" / "extending.md").read_text()


def copy_core(runtime: Path) -> None:
    """Copy the core and its headers into the folder ``runtime``."""
    runtime.mkdir(parents=True, exist_ok=True)
    shutil.copytree(ROOT / "runtime" / "core", runtime / "core", dirs_exist_ok=True)
    for name in ("ccgen.h", "model.h"):
        shutil.copy(ROOT / "runtime" / name, runtime / name)


def extend_core(runtime: Path) -> None:
    """Add to a copy of the core the files in C of the text, and its lines of lists."""
    for file, code in re.findall(r"In `runtime/(core/\S+\.[ch])`:\n\n```c\n(.*?)```", TEXT, re.S):
        (runtime / file).write_text(code)
    for file, line in re.findall(r"a line in `runtime/(core/\S+\.h)`:\n\n```c\n(.*?)```", TEXT, re.S):
        was = (runtime / file).read_text()
        now = re.sub(r"#define ALL_\w+\(.*?\n\n", lambda _, line=line: f"{line}\n", was, flags=re.S)
        assert now.count("\\\n") == was.count("\\\n") + 1
        (runtime / file).write_text(now)


def extend_generator(generator: Path) -> None:
    """Name the law of the text in a copy of the generator."""
    ((file, line),) = re.findall(r"`generator/(\S+\.py)`:\n\n```python\n(Law = .*?)```", TEXT, re.S)
    was = (generator / file).read_text()
    (old,) = re.findall(r"^Law = .*\n", was, re.M)
    insert(generator / file, old, line)


def insert(file: Path, place: str, text: str) -> None:
    """Put ``text`` in the one ``place`` of a file."""
    was = file.read_text()
    assert was.count(place) == 1, (file.name, place)
    file.write_text(was.replace(place, text))
