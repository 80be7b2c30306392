"""Names in a folder that may be meant for one that is not there."""

from __future__ import annotations

import os
import re
from difflib import get_close_matches
from itertools import islice
from os import PathLike
from pathlib import Path

NEAREST = 3
"""So many are named."""
ALIKE = 0.7
"""How much names, or words of names, are alike, as difflib has it: two of three letters at least."""
WORD = 4
"""Letters of a word, at least, that stands for the whole name: shorter ones are alike by chance."""
MOST = 10_000
"""Names of a folder that are looked at, the first by the alphabet."""


def as_there(path: str | PathLike[str], *ends: str) -> str:
    """``; near it is hexagon.toml``: names beside that of ``path`` that may be meant, of files with one of these
    ``ends``, of files and folders without any; where its folder is not there that, and nothing where no name is near.
    """
    given = Path(path)
    if not given.parent.is_dir():
        return f"; there is no folder {given.parent}"
    *others, last = _near(given, ends) or [""]
    if not others:
        return f"; near it is {last}" if last else ""
    return f"; near it are {', '.join(others)} and {last}"


def _near(given: Path, ends: tuple[str, ...]) -> list[str]:
    """The nearest first."""
    try:
        with os.scandir(given.parent) as entries:
            names = sorted(one.name for one in entries if one.name.endswith(ends or "") and not (ends and one.is_dir()))
    except OSError:
        return []
    known: dict[str, dict[str, None]] = {}
    for name in islice((name for name in names if not name.startswith(".")), MOST):
        stem = _stem(name, ends)
        words = [word for word in re.split(r"[-_ ]", stem) if len(word) >= WORD]
        for word in dict.fromkeys((stem, *words)):
            known.setdefault(word, {})[name] = None
    meant = dict.fromkeys((_stem(given.name, ends), given.stem.lower() if ends else given.name.lower()))
    alike = [word for one in meant for word in get_close_matches(one, known, len(known) or 1, ALIKE)]
    return list(dict.fromkeys(name for word in alike for name in known[word]))[:NEAREST]


def _stem(name: str, ends: tuple[str, ...]) -> str:
    end = next((end for end in ends if name.endswith(end)), "")
    return name.removesuffix(end).lower()
