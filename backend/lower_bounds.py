"""Prints what ``make oldest`` installs: every dependency of ccgen and of its tests at its lower bound, a line each."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator
from pathlib import Path

BOUND = re.compile(r"([\w.-]+)>=([\w.]+)")


def lower_bounds(text: str, extra: str = "test") -> list[str]:
    """``name==version`` of each requirement of the project whose pyproject.toml is ``text``, and of one ``extra`` with
    the extras of ccgen that it names.

    Raises ``ValueError`` where a requirement has no lower bound.
    """
    project = tomllib.loads(text)["project"]
    extras = project["optional-dependencies"]

    def wanted(requirements: list[str]) -> Iterator[str]:
        for requirement in requirements:
            if named := re.fullmatch(r"ccgen\[(\w+)\]", requirement):
                yield from wanted(extras[named[1]])
                continue
            bound = BOUND.fullmatch(requirement)
            if bound is None:
                raise ValueError(f"pyproject.toml: found {requirement!r}, expected a name, >= and a version")
            yield f"{bound[1]}=={bound[2]}"

    return list(dict.fromkeys([*wanted(project["dependencies"]), *wanted(extras[extra])]))


if __name__ == "__main__":
    pyproject = Path(__file__).resolve().parents[1] / "pyproject.toml"
    print("\n".join(lower_bounds(pyproject.read_text(encoding="utf-8"))))
