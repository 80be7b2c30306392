"""The documentation as a site: Sphinx reads the Markdown that stands in the repository, and docstrings; ``make site``.

Nothing here names a page that other pages do not link to: a page of docs/ that this file does not know is in the menu
under "More", so that none is left out. The order of a folder's pages is that of the links in its ``index.md``.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path.insert(0, str(HERE))

from ccgen.generator import __version__  # noqa: E402

project = "ccgen"
release = version = __version__
author = copyright = "the authors of ccgen"

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "diagrams_as_tables",
    "equation_links",
    "external_links",
    "files_beside",
    "mathml",
]
root_doc = "README"
include_patterns = ["README.md", "CHANGELOG.md", "CONTRIBUTING.md", "benchmarks/README.md", "docs/*.md", "docs/*/**.md"]
include_patterns += ["docs/site/*.rst"]
exclude_patterns = [
    ".*",
    "build",
    "results",
    "site",
    "front",
    "generator",
    "runtime",
    "templates",
    "tests",
    "scenes",
    "backend",
]

# -- Markdown as GitHub reads it: anchors of headings, formulas in dollars and in fences ------------------------------

myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 6
myst_fence_as_directive = {"math", "mermaid"}
myst_dmath_double_inline = True

# -- docstrings ------------------------------------------------------------------------------------------------------

default_role = "literal"
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_default_options = {
    "members": True,
    "undoc-members": True,
    "inherited-members": "object, Exception, BaseException, ValueError",
}
autodoc_class_signature = "separated"
autodoc_type_aliases = {name: name for name in ("ArrayLike", "BoolArray", "FloatArray")}
python_maximum_signature_line_length = 88
add_module_names = False

# -- pages -----------------------------------------------------------------------------------------------------------

html_theme = "furo"
html_title = f"ccgen {__version__}"
html_static_path = ["static"]
html_css_files = ["site.css"]
html_math_renderer = "mathml"
html_copy_source = False
html_show_sphinx = False
html_show_copyright = False
html_theme_options = {"navigation_with_keys": True}
pygments_style, pygments_dark_style = "friendly", "monokai"

MENU: dict[str, tuple[str, ...]] = {
    "Use": ("docs/howto/index", "docs/gallery/index", "docs/mechanisms", "docs/troubleshooting", "docs/faq"),
    "Reference": (
        "docs/scenes",
        "docs/model",
        "docs/site/generator",
        "docs/site/runtime",
        "docs/c",
        "docs/events",
        "docs/accuracy",
        "docs/glossary",
    ),
    "Theory": (
        "docs/theory",
        "docs/paper",
        "docs/sweep",
        "docs/hard-cases",
        "docs/counts",
        "docs/formulations",
        "benchmarks/README",
    ),
    "Develop": ("docs/architecture", "docs/extending", "CONTRIBUTING", "CHANGELOG"),
}
MAY_LACK = {"docs/gallery/index", "docs/paper"}


def is_there(page: str) -> bool:
    return any((ROOT / f"{page}{suffix}").is_file() for suffix in (".md", ".rst"))


def known_pages() -> dict[str, tuple[str, ...]]:
    """The menu, with what stands in docs/ beside it under "More"; a page that is named and lacks is an error."""
    lacking = [page for pages in MENU.values() for page in pages if not is_there(page) and page not in MAY_LACK]
    if lacking:
        raise FileNotFoundError(f"docs/site/conf.py: found no {', '.join(lacking)} (.md), which MENU names")
    menu = {title: tuple(page for page in pages if is_there(page)) for title, pages in MENU.items()}
    named = {page for pages in menu.values() for page in pages}
    folders = sorted((ROOT / "docs").glob("*/index.md"))
    more = [
        path.relative_to(ROOT).with_suffix("").as_posix() for path in (*sorted((ROOT / "docs").glob("*.md")), *folders)
    ]
    rest = tuple(page for page in more if page not in named)
    return {**menu, "More": rest} if rest else menu


def menus(app: object, page: str, source: list[str]) -> None:
    """Put the menu behind the front page, and behind the index of a folder its pages; readers of the files see none."""
    if page == root_doc:
        entries = known_pages()
    elif page.endswith("/index"):
        folder = ROOT / Path(page).parent
        linked = re.findall(r"\]\((?:\./)?([\w./-]+)\.md(?:#[\w-]*)?\)", source[0])
        others = sorted(path.relative_to(folder).with_suffix("").as_posix() for path in folder.rglob("*.md"))
        ordered = dict.fromkeys([*(name for name in linked if name in others), *others])
        entries = {"": tuple(name for name in ordered if name != "index")}
    else:
        return
    for title, pages in entries.items():
        if pages:
            caption = f":caption: {title}\n" if title else ""
            names = "\n".join(f"/{name}" if page == root_doc else name for name in pages)
            source[0] += f"\n\n```{{toctree}}\n:hidden:\n{caption}\n{names}\n```\n"


def front_page(app: object, exception: Exception | None) -> None:
    """The front page by the name that browsers and servers look for."""
    out = Path(app.outdir)  # type: ignore[attr-defined]
    if exception is None and (out / f"{root_doc}.html").is_file():
        (out / "index.html").write_bytes((out / f"{root_doc}.html").read_bytes())


def setup(app: object) -> None:
    app.connect("source-read", menus)  # type: ignore[attr-defined]
    app.connect("build-finished", front_page)  # type: ignore[attr-defined]
