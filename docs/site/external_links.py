"""Lists the links that lead out of the site, in ``external-links.txt`` beside its pages. None is fetched."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from docutils import nodes


def list_links(app: Any, exception: Exception | None) -> None:
    if exception is not None or app.builder.format != "html":
        return
    found: dict[str, set[str]] = {}
    for page in app.env.found_docs:
        for node in app.env.get_doctree(page).findall(nodes.reference):
            target = node.get("refuri", "")
            if target.startswith(("http:", "https:", "mailto:")):
                found.setdefault(target, set()).add(page)
    lines = [f"{target}  ({', '.join(sorted(found[target]))})\n" for target in sorted(found)]
    Path(app.outdir, "external-links.txt").write_text("".join(lines), encoding="utf-8")


def setup(app: Any) -> dict[str, Any]:
    app.connect("build-finished", list_links)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
