"""Diagrams in Mermaid's notation, which GitHub draws, as tables: from where, to where, and when.

A drawing would need Mermaid's script in every browser, or a browser in every build. A table says the same, can be
searched, and fits a narrow screen.
"""

from __future__ import annotations

import re
from typing import Any

from docutils import nodes
from sphinx.util.docutils import SphinxDirective

ARROW = re.compile(r"^\s*(\S+)\s*-->\s*(\S+?)\s*(?::\s*(.*))?$")
NAME = re.compile(r"^\s*(\w+)\s*:\s*(.+)$")
START = "[*]"


def arrows(diagram: str) -> list[tuple[str, str, str]]:
    """From, to and label of every arrow; raises ``ValueError`` for a line that is neither arrow nor name nor kind."""
    first, *lines = [line for line in diagram.splitlines() if line.strip()]
    if first.split()[0] not in ("graph", "flowchart", "stateDiagram-v2"):
        raise ValueError(f'found a diagram that begins with "{first}", expected graph, flowchart or stateDiagram-v2')
    names: dict[str, str] = {}
    found: list[tuple[str, str, str]] = []
    for line in lines:
        if arrow := ARROW.match(line):
            found.append((arrow[1], arrow[2], arrow[3] or ""))
        elif name := NAME.match(line):
            names[name[1]] = name[2].strip()
        else:
            raise ValueError(f'found "{line.strip()}" in a diagram, expected A --> B: label, or A: name')
    return [(names.get(a, a), names.get(b, b), label) for a, b, label in found]


class Mermaid(SphinxDirective):
    """A fence of Mermaid's as a table."""

    has_content = True

    def run(self) -> list[nodes.Node]:
        try:
            found = arrows("\n".join(self.content))
        except ValueError as error:
            raise self.error(str(error)) from error
        labelled = any(label for _, _, label in found)
        if labelled:
            rows = [(a.replace(START, "begin"), b.replace(START, "over"), label) for a, b, label in found]
            return [_table(("from", "to", "when"), rows)]
        targets: dict[str, list[str]] = {}
        for a, b, _ in found:
            targets.setdefault(a, []).append(b)
        return [_table(("from", "to"), [(a, ", ".join(bs)) for a, bs in targets.items()])]


def _table(heads: tuple[str, ...], rows: list[tuple[str, ...]]) -> nodes.table:
    group = nodes.tgroup("", *(nodes.colspec(colwidth=1) for _ in heads), cols=len(heads))
    group += nodes.thead("", _row(heads))
    group += nodes.tbody("", *(_row(row) for row in rows))
    return nodes.table("", group, classes=["diagram"])


def _row(cells: tuple[str, ...]) -> nodes.row:
    return nodes.row("", *(nodes.entry("", nodes.paragraph("", cell)) for cell in cells))


def setup(app: Any) -> dict[str, Any]:
    app.add_directive("mermaid", Mermaid)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
