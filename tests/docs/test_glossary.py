"""The glossary: in order, and every file that it names is there."""

from __future__ import annotations

import re

from ..support.folders import ROOT

TEXT = (ROOT / "docs" / "glossary.md").read_text()


def test_words_are_in_order() -> None:
    words = re.findall(r"^\| ([^|]+?) \|", TEXT, re.M)[2:]
    assert words == sorted(words, key=str.lower) and len(words) > 20


def test_files_are_there() -> None:
    """Files of the core are told from its folder on, and their names stand in them."""
    for row in re.findall(r"^\| .*$", TEXT, re.M)[2:]:
        places = re.findall(r"`((?:core|generator)/[\w/.]+)`", row)
        paths = [ROOT / (place if place.startswith("generator") else f"runtime/{place}") for place in places]
        assert all(path.exists() for path in paths), row
        for name in re.findall(r"`(?:struct |enum )(\w+)`", row):
            assert any(name in path.read_text() for path in (ROOT / "runtime" / "core").rglob("*.h")), name
