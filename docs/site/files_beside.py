"""Files that pages name lie in the site as in the repository: what HTML in Markdown shows, and pages to play.

Pictures of Markdown and links to sources Sphinx copies by itself. Folders have no page: links to them become words.
"""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import Any

from docutils import nodes
from sphinx import addnodes

NAMED = re.compile(r'\b(?:src|href|poster)="([^":#?]+)"')
LINK = re.compile(r"(?<!!)\[([^\]]*)\]\(([^)#:\s]+)\)")
FENCE = re.compile(r"^(?:```.*?^```|    .*?)$", re.DOTALL | re.MULTILINE)


def folders_as_words(app: Any, page: str, source: list[str]) -> None:
    """Links to folders of the repository, outside of code, as their words."""
    here = Path(app.srcdir, page).parent

    def words(link: re.Match[str]) -> str:
        return link[1] if (here / link[2]).is_dir() else link[0]

    text, end, parts = source[0], 0, []
    for fence in FENCE.finditer(text):
        parts += [LINK.sub(words, text[end : fence.start()]), fence[0]]
        end = fence.end()
    source[0] = "".join([*parts, LINK.sub(words, text[end:])])


def open_pages(app: Any, doctree: nodes.document) -> None:
    """Links to pages of HTML open them; Sphinx would have them saved."""
    for node in list(doctree.findall(addnodes.download_reference)):
        target = Path(app.env.relfn2path(node["reftarget"], app.env.docname)[1])
        if target.suffix == ".html" and target.is_file():
            here = Path(app.env.doc2path(app.env.docname)).parent
            where = Path(os.path.relpath(target, here)).as_posix()
            node.replace_self(nodes.reference("", "", *node.children, refuri=where))


def copy_named(app: Any, exception: Exception | None) -> None:
    """Copy what pages name and the site lacks, where the repository has it."""
    if exception is not None or app.builder.format != "html":
        return
    source, out = Path(app.srcdir).resolve(), Path(app.outdir).resolve()
    for page in sorted(out.rglob("*.html")):
        for name in NAMED.findall(page.read_text(encoding="utf-8")):
            place = (page.parent / name).resolve()
            if not place.is_relative_to(out) or place.exists():
                continue
            found = source / place.relative_to(out)
            if found.is_file():
                place.parent.mkdir(parents=True, exist_ok=True)
                place.write_bytes(found.read_bytes())


def setup(app: Any) -> dict[str, Any]:
    app.connect("source-read", folders_as_words)
    app.connect("doctree-read", open_pages)
    app.connect("build-finished", copy_named)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
