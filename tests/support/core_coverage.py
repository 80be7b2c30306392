"""What part of the core's lines has run: ``make coverage`` prints it from what gcc's ``--coverage`` has counted.

    python tests/support/core_coverage.py FOLDER

Below FOLDER are the counts (``.gcda``) of all objects that were compiled of the core, for every type of numbers; a line
has run if it has in any of them. Per layer and file: lines that have run, of those that have code, and which have not.
"""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from collections import defaultdict
from collections.abc import Iterable, Mapping
from pathlib import Path

CORE = re.compile(r"runtime/core/(\w+/\w+\.[ch])$")
ROOT = Path(__file__).resolve().parents[2]
Counts = dict[str, dict[int, int]]
"""How often each line with code has run, by file (``steps/step.c``) and line."""


def counts(folder: Path) -> Counts:
    """What has been counted below a folder."""
    found: Counts = defaultdict(lambda: defaultdict(int))
    for data in sorted(folder.rglob("*.gcda")):
        command = [os.environ.get("GCOV", "gcov"), "--json-format", "--stdout", str(data)]
        done = subprocess.run(command, capture_output=True, text=True, check=True)
        for text in done.stdout.splitlines():
            add(found, json.loads(text)["files"])
    return found


def add(found: Counts, files: Iterable[Mapping[str, object]]) -> None:
    """Add what gcov tells of the files of an object to what is known."""
    for file in files:
        name = CORE.search(str(file["file"]))
        if name and (ROOT / name[0]).is_file():  # tests compile the core with files of their own, too
            for line in file["lines"]:  # type: ignore[attr-defined]
                found[name[1]][line["line_number"]] += line["count"]


def report(found: Counts, order: Iterable[str]) -> str:
    """The table: per layer, in this order, and per file."""
    lines, whole = [], [0, 0]
    for layer in order:
        files = {file: lines_of for file, lines_of in sorted(found.items()) if file.startswith(f"{layer}/")}
        ran = sum(sum(1 for count in one.values() if count) for one in files.values())
        there = sum(map(len, files.values()))
        whole = [whole[0] + ran, whole[1] + there]
        lines.append(row(layer, ran, there))
        for file, one in files.items():
            missed = [line for line, count in sorted(one.items()) if not count]
            lines.append(row(f"  {file}", len(one) - len(missed), len(one)) + spans(missed))
    return "\n".join([*lines, row("the core", *whole)])


def row(name: str, ran: int, there: int) -> str:
    """One line of the table; of what has no code, no share."""
    share = f"{100.0 * ran / there:6.2f} %" if there else " no code"
    return f"{name:40s}{ran:5d} of {there:5d} {share}"


def spans(lines: Iterable[int]) -> str:
    """Numbers of lines, those that follow each other as one span."""
    found: list[list[int]] = []
    for line in lines:
        if found and line == found[-1][1] + 1:
            found[-1][1] = line
        else:
            found.append([line, line])
    text = ", ".join(str(first) if first == last else f"{first}-{last}" for first, last in found)
    return f"   not run: {text}" if text else ""


def layers() -> list[str]:
    """The folders of the core in the order of docs/architecture.md."""
    text = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    section = text.partition("## The core in C")[2].partition("Where is")[0]
    return re.findall(r"^\| `(\w+)` \|", section, re.MULTILINE)


if __name__ == "__main__":
    print(report(counts(Path(sys.argv[1])), layers()))
