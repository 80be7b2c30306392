"""The site of the documentation is built strictly, twice the same, is read without a network, and draws formulas."""

from __future__ import annotations

import importlib
import importlib.util
import os
import re
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path

import pytest

from ..support.folders import ROOT

pytestmark = pytest.mark.hard

NEEDED = ("sphinx", "myst_parser", "furo", "ziamath")
LACKING = [name for name in NEEDED if importlib.util.find_spec(name) is None]
VOID = {"area", "base", "br", "col", "embed", "hr", "img", "input", "link", "meta", "source", "track", "wbr"}
CODE = {"code", "pre", "script", "style", "title", "annotation"}


class Page(HTMLParser):
    """What a page loads, how many formulas it draws, its anchors, and its words outside of code."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.loads: list[str] = []
        self.formulas = 0
        self.anchors: set[str] = set()
        self.links: list[str] = []
        self.words: list[str] = []
        self.inside: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = dict(attrs)
        if tag in ("script", "img", "source", "iframe") and given.get("src"):
            self.loads.append(given["src"] or "")
        if tag == "link" and given.get("href"):
            self.loads.append(given["href"] or "")
        if tag == "a" and given.get("href"):
            self.links.append(given["href"] or "")
        self.formulas += tag == "math"
        self.anchors.update(filter(None, (given.get("id"), given.get("name") if tag == "a" else None)))
        if tag not in VOID:
            self.inside.append(tag)

    def handle_endtag(self, tag: str) -> None:
        if tag in self.inside:
            while self.inside.pop() != tag:
                pass

    def handle_data(self, data: str) -> None:
        if not CODE & {*self.inside}:
            self.words.append(data)


def build(out: Path, **environment: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going", "-E", "-c", str(ROOT / "docs" / "site"),
         "-d", str(out.with_name(f"{out.name}-doctrees")), str(ROOT), str(out)],
        capture_output=True,
        text=True,
        env={**os.environ, **environment},
        timeout=600,
        check=False,
    )  # fmt: skip


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    if LACKING:
        pytest.skip(f"needs {', '.join(LACKING)}; install with: pip install 'ccgen[site]'")
    out = tmp_path_factory.mktemp("site") / "site"
    done = build(out, PYTHONHASHSEED="1")
    assert done.returncode == 0, done.stderr
    return out


def pages(site: Path) -> dict[str, Page]:
    return {
        path.relative_to(site).as_posix(): Page(path.read_text(encoding="utf-8"))
        for path in sorted(site.rglob("*.html"))
    }


def formulas(text: str) -> int:
    """How many formulas a Markdown text has: fences of math, and dollars outside of code."""
    fences = len(re.findall(r"^```math$", text, re.MULTILINE))
    text = re.sub(r"^```.*?^```$", "", text, flags=re.MULTILINE | re.DOTALL)
    text = re.sub(r"^    .*$", "", text, flags=re.MULTILINE)
    text = re.sub(r"`[^`\n]+`", "", text)
    return fences + len(re.findall(r"(?<!\\)\$[^$]+?\$", text))


def test_every_page_and_every_formula_is_there(site: Path) -> None:
    built = pages(site)
    sources = [*(ROOT / "docs").glob("*.md"), *(ROOT / "docs" / "howto").glob("*.md"), ROOT / "README.md"]
    for source in sources:
        page = built[source.relative_to(ROOT).with_suffix(".html").as_posix()]
        raw = [words for words in page.words if "$" in words or "\\frac" in words or "\\mathcal" in words]
        assert raw == [], source.name
        assert page.formulas == formulas(source.read_text(encoding="utf-8")), source.name
    assert built["docs/theory.html"].formulas > 900
    assert "eq-4.7" in built["docs/theory.html"].anchors
    assert (site / "index.html").read_bytes() == (site / "README.html").read_bytes()


def test_numbers_of_equations_are_links(site: Path) -> None:
    """All that the text of the theory cites, counted in its source; what docstrings cite leads to its page."""
    cited = re.compile(r"\b(?:[Ee]q\.|[Ee]quations?)\s+\d+\.\d+(?:(?:,\s+|\s+and\s+|\s+to\s+|–)\d+\.\d+)*")
    text = re.sub(r"^#[^\n]*$|^```.*?^```$|`[^`\n]+`", "", (ROOT / "docs" / "theory.md").read_text(), flags=re.M | re.S)
    wanted = sum(len(re.findall(r"\d+\.\d+", one[0])) for one in cited.finditer(text))
    built = pages(site)
    theory = built["docs/theory.html"]
    links = [one for one in theory.links if one.startswith("#eq-")]
    numbers = sum(anchor.startswith("eq-") for anchor in theory.anchors)
    assert wanted > 100 and len(links) - numbers == wanted  # each numbered equation links to itself
    assert {one[1:] for one in links} <= theory.anchors
    reference = [one for one in built["docs/site/runtime.html"].links if "theory.html#eq-" in one]
    assert len(reference) > 2 and {one.partition("#")[2] for one in reference} <= theory.anchors


@pytest.mark.skipif(bool(LACKING), reason="needs the packages of 'ccgen[site]'")
def test_what_is_the_number_of_an_equation(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(ROOT / "docs" / "site"))
    equation_links = importlib.import_module("equation_links")
    for text, wanted in {
        "by equations 4.7, 4.8 and 99.1.": ["4.7", "4.8", "99.1"],
        "Equations 2.1–2.6 and 3.4 to\n3.6": ["2.1", "2.6", "3.4", "3.6"],
        "theory, 4.13, takes 1.8 times as long as equation 3": [],
        "Equation 4.7, 3 bars": ["4.7"],
    }.items():
        found = [*equation_links.pieces(text)]
        assert [piece for piece, cited in found if cited] == wanted
        assert "".join(piece for piece, _ in found) == text


@pytest.mark.skipif(bool(LACKING), reason="needs the packages of 'ccgen[site]'")
def test_an_equation_that_is_not_there_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    """Numbers across the end of a line are links; what stands in code or in a link stays."""
    from docutils import nodes

    monkeypatch.syspath_prepend(str(ROOT / "docs" / "site"))
    equation_links = importlib.import_module("equation_links")
    page = nodes.paragraph("", "", *map(nodes.Text, ("by eq.", "\n", "4.7 and 99.1, ")), nodes.literal("", "eq. 4.7"))
    assert equation_links.link(nodes.section("", page), "theory.html", {"4.7"}) == ["99.1"]
    assert [one["refuri"] for one in page.findall(nodes.reference)] == ["theory.html#eq-4.7"]
    assert page.astext() == "by eq.\n4.7 and 99.1, eq. 4.7"


@pytest.mark.skipif(bool(LACKING), reason="needs the packages of 'ccgen[site]'")
def test_formulas_are_those_of_tex(monkeypatch: pytest.MonkeyPatch) -> None:
    """What docutils lacks or reads otherwise; and a command that nobody knows is refused."""
    monkeypatch.syspath_prepend(str(ROOT / "docs" / "site"))
    mathml = importlib.import_module("mathml")
    drawn = {
        r"\hat s_j^2": "<msubsup><mover><mi>s</mi><mo>ˆ</mo></mover><mi>j</mi><mn>2</mn></msubsup>",
        r"\tfrac12k": "<mfrac><mn>1</mn><mn>2</mn></mfrac><mi>k</mi>",
        r"B'_c": "<msubsup><mi>B</mi><mi>c</mi><mi>′</mi></msubsup>",
        r"p \mathrel{-}= 1": "<mi>p</mi><mo>−=</mo><mn>1</mn>",
        r"x_i \text{ on } k": "<msub><mi>x</mi><mi>i</mi></msub><mtext>\xa0on\xa0</mtext><mi>k</mi>",
    }
    for formula, wanted in drawn.items():
        found = re.sub(r"<(m\w+) [^>]*>", r"<\1>", mathml.converted(formula, False)[0]).replace("<mrow></mrow>", "")
        assert found == f"<math>{wanted}</math>", formula
    assert mathml.converted(r"a = b \tag{4.7}", True)[1] == "4.7"
    with pytest.raises(mathml.MathError):
        mathml.converted(r"\nobody{x}", False)


def test_it_is_read_without_a_network(site: Path) -> None:
    """Scripts, styles, fonts and pictures are files of the site; those that styles name too."""
    for name, page in pages(site).items():
        for load in page.loads:
            path = load.partition("?")[0].partition("#")[0]
            assert not re.match(r"[a-z]+:|//", path), (name, load)
            assert not path or (site / name).parent.joinpath(path).exists(), (name, load)
    for style in site.rglob("*.css"):
        named = re.findall(r"url\(\s*['\"]?([^'\")]+)|@import\s+['\"]([^'\"]+)", style.read_text(encoding="utf-8"))
        assert [one for pair in named for one in pair if re.match(r"https?:|//", one)] == [], style.name


def test_public_names_are_in_the_reference(site: Path) -> None:
    import ccgen.generator
    import ccgen.runtime

    for package in (ccgen.generator, ccgen.runtime):
        name = package.__name__.rpartition(".")[2]
        anchors = pages(site)[f"docs/site/{name}.html"].anchors
        wanted = {f"{package.__name__}.{one}" for one in package.__all__ if not one.startswith("__")}
        assert wanted <= anchors


def test_words_of_all_pages_are_found_by_the_search(site: Path) -> None:
    """The index is a script, which pages load from a folder too, and it knows a word of the middle of a page."""
    index = (site / "searchindex.js").read_text(encoding="utf-8")
    assert index.startswith("Search.setIndex(")
    for page in ("docs/theory", "docs/howto/ropes", "docs/site/runtime", "docs/troubleshooting"):
        assert f'"{page}"' in index
    assert re.search(r'"?atwood"?:', index)


def test_the_same_bytes_again(site: Path) -> None:
    out = site.with_name("again")
    done = build(out, PYTHONHASHSEED="2", TZ="Asia/Tokyo")
    assert done.returncode == 0, done.stderr
    files = {path.relative_to(site): path.read_bytes() for path in site.rglob("*") if path.is_file()}
    again = {path.relative_to(out): path.read_bytes() for path in out.rglob("*") if path.is_file()}
    assert files.keys() == again.keys()
    assert [str(name) for name in files if files[name] != again[name]] == []
