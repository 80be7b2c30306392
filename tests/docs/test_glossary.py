"""The glossary: in order, every file that it names is there, and has the word or a name that is told beside it."""

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


def test_files_have_the_words() -> None:
    """A file that is named for a word has a part of it or a name of that row; each name is in one of its files."""
    for row in re.findall(r"^\| .*$", TEXT, re.M)[2:]:
        word, _, where = (cell.strip() for cell in row.strip("|").rsplit(" | ", 2)[-3:])
        spans = re.findall(r"`([^`]+)`", where)
        files = [span for span in spans if re.fullmatch(r"(core|generator)/[\w/]+\.\w+", span)]
        names = [span.split()[-1] for span in spans if re.fullmatch(r"((struct|enum) )?\w+", span)]
        texts = {span: (ROOT / ("runtime" if span.startswith("core") else ".") / span).read_text() for span in files}
        known = [*names, *(part[:6] for part in re.findall(r"\w{4,}", word))]
        for file, text in texts.items():
            assert any(name.lower() in text.lower() for name in known), (word, file)
        public = (ROOT / "runtime" / "model.h").read_text() + "".join(
            path.read_text() for path in (ROOT / "runtime" / "record").glob("*.py")
        )
        for name in names:
            assert any(re.search(rf"\b{name}\b", text) for text in [*texts.values(), public]), (word, name)
