"""Links and anchors of all Markdown files are alive, read as GitHub reads them; nothing is built or fetched."""

from __future__ import annotations

import re
import unicodedata
from collections import Counter
from functools import cache
from itertools import pairwise
from pathlib import Path
from urllib.parse import unquote

import pytest
from markdown_it import MarkdownIt
from markdown_it.token import Token

from ..support.folders import ROOT

PAGES = sorted(
    path
    for pattern in ("*.md", "docs/**/*.md", "benchmarks/*.md")
    for path in ROOT.glob(pattern)
    if not any(part.startswith(".") for part in path.relative_to(ROOT).parts)
)
ELSEWHERE = re.compile(r"[a-z][a-z0-9+.-]*:", re.IGNORECASE)
READER = MarkdownIt("commonmark").enable("table")


def tokens(text: str) -> list[Token]:
    """All tokens of a text, those inside of lines too."""
    return [inner for token in READER.parse(text) for inner in (token, *(token.children or ()))]


def links(text: str) -> list[str]:
    """What a text links to and shows pictures of, in its order; fences and code are no links."""
    found = [token.attrGet("href") or token.attrGet("src") for token in tokens(text)]
    return [str(target) for target in found if target]


@cache
def anchors(text: str) -> set[str]:
    """Anchors of headings as GitHub makes them: a word that comes again has a number behind it."""
    seen: Counter[str] = Counter()
    found = set(re.findall(r'<a (?:id|name)="([^"]+)"', text))
    parsed = READER.parse(text)
    for opened, line in pairwise(parsed):
        if opened.type == "heading_open":
            slug = slug_of("".join(token.content for token in line.children or ()))
            found.add(f"{slug}-{seen[slug]}" if seen[slug] else slug)
            seen[slug] += 1
    return found


def slug_of(heading: str) -> str:
    """Letters, digits, marks, ``-`` and ``_`` stay; a space becomes ``-``; all else goes."""
    kept = (one for one in heading.strip().lower() if one in "-_ " or unicodedata.category(one)[0] in "LNM")
    return "".join(kept).replace(" ", "-")


def dead(page: Path, text: str) -> list[str]:
    """Links of a page that lead nowhere in the repository."""
    found = []
    for target in links(text):
        if ELSEWHERE.match(target):
            continue
        path, _, anchor = unquote(target).partition("#")
        file = (page.parent / path).resolve() if path else page
        if not file.exists() or not file.is_relative_to(ROOT):
            found.append(f"{target}: there is no {path}")
        elif (
            anchor
            and file.suffix == ".md"
            and anchor not in anchors(text if file == page else file.read_text(encoding="utf-8"))
        ):
            found.append(f"{target}: {file.name} has no heading of that name")
    return found


def test_there_are_pages_and_links() -> None:
    names = {str(page.relative_to(ROOT)) for page in PAGES}
    assert {"README.md", "docs/theory.md", "docs/howto/index.md"} <= names
    assert len(links((ROOT / "docs" / "scenes.md").read_text(encoding="utf-8"))) > 50


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_links_lead_somewhere(page: Path) -> None:
    assert dead(page, page.read_text(encoding="utf-8")) == []


def test_dead_links_are_found() -> None:
    text = (
        "# A `[[b]]` c\n[a](#a-b-c) [b](#b) [c](none.md) ![d](images/none.png) [e](theory.md#10-references)\n`[f](g)`"
    )
    assert [told.partition(":")[0] for told in dead(ROOT / "docs" / "faq.md", text)] == [
        "#b",
        "none.md",
        "images/none.png",
    ]


def test_every_how_to_is_in_the_index() -> None:
    folder = ROOT / "docs" / "howto"
    linked = links((folder / "index.md").read_text(encoding="utf-8"))
    assert {path.name for path in folder.glob("*.md")} - {"index.md"} <= {*linked}
