"""Numbers of equations in the text of pages and docstrings, as "eq. 4.7 and 4.8", become links to the equations.

The sources stay as they are, so that files read on GitHub, and the code that cites equations in the same words, need no
links of their own. A number that no equation has is a warning, which ends a strict build.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator
from pathlib import Path
from typing import Any

from docutils import nodes
from sphinx.util import logging

log = logging.getLogger(__name__)

THEORY = "docs/theory"
"""The page that has the equations."""
NUMBER = re.compile(r"\d+\.\d+")
CITED = re.compile(r"\b(?:[Ee]qs?\.|[Ee]quations?)\s+\d+\.\d+(?:(?:,\s+|,?\s+and\s+|\s+to\s+|–)\d+\.\d+)*")
TAG = re.compile(r"\\tag\{([^{}]*)\}")
LEFT_AS_THEY_ARE = (
    nodes.literal,
    nodes.literal_block,
    nodes.reference,
    nodes.title,
    nodes.math,
    nodes.math_block,
    nodes.raw,
)


def pieces(text: str) -> Iterator[tuple[str, bool]]:
    """The text in pieces, each with whether it is the number of an equation."""
    done = 0
    for cited in CITED.finditer(text):
        for number in NUMBER.finditer(text, *cited.span()):
            yield text[done : number.start()], False
            yield number[0], True
            done = number.end()
    yield text[done:], False


def numbers_in(theory: str) -> frozenset[str]:
    """The numbers that its equations have."""
    return frozenset(TAG.findall(theory))


def link(page: nodes.Node, uri: str, numbers: Collection[str]) -> list[str]:
    """Make links of what a page cites; gives the numbers that no equation has, which stay text."""
    unknown = []
    for parent in list(page.findall(nodes.TextElement)):
        if isinstance(parent, LEFT_AS_THEY_ARE) or _inside(parent):
            continue
        made: list[nodes.Node] = []
        for child in _joined(parent.children):
            if not isinstance(child, nodes.Text):
                made.append(child)
                continue
            for piece, cited in pieces(str(child)):
                if cited and piece in numbers:
                    made.append(nodes.reference("", piece, internal=True, refuri=f"{uri}#eq-{piece}"))
                elif piece:
                    made.append(nodes.Text(piece))
                    unknown += [piece] if cited else []
        parent.children = []
        parent.extend(made)
    return unknown


def _inside(node: nodes.Node) -> bool:
    while node.parent is not None:
        node = node.parent
        if isinstance(node, LEFT_AS_THEY_ARE):
            return True
    return False


def _joined(children: list[nodes.Node]) -> Iterator[nodes.Node]:
    """Neighbouring texts as one: the ends of lines are texts of their own."""
    waiting = ""
    for child in children:
        if isinstance(child, nodes.Text):
            waiting += str(child)
            continue
        if waiting:
            yield nodes.Text(waiting)
            waiting = ""
        yield child
    if waiting:
        yield nodes.Text(waiting)


def link_page(app: Any, page: nodes.document, name: str) -> None:
    if app.builder.format != "html":
        return
    numbers = numbers_in(Path(app.srcdir, f"{THEORY}.md").read_text(encoding="utf-8"))
    uri = "" if name == THEORY else app.builder.get_relative_uri(name, THEORY)
    for number in link(page, uri, numbers):
        log.warning("found equation %s, which %s.md does not have", number, THEORY, location=name)


def setup(app: Any) -> dict[str, Any]:
    app.connect("doctree-resolved", link_page)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
