r"""Formulas as MathML, which browsers draw by themselves: no script, no network, and the same bytes on every machine.

The conversion is that of docutils, on which Sphinx stands; it refuses what it does not know, so that a formula which
cannot be drawn ends a strict build. Before it a ``\tag{4.7}`` becomes a number beside the formula and an anchor,
``#eq-4.7``, and what docutils lacks or reads otherwise than TeX is written so that it does not.

Not every system has a font for formulas, with brackets that grow; so the site has one, STIX Two Math (SIL Open Font
License), as the Python package ziamath brings it.
"""

from __future__ import annotations

import re
from html import escape, unescape
from importlib.resources import files
from itertools import pairwise
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from docutils import nodes
from docutils.utils.math import MathError
from docutils.utils.math.latex2mathml import tex2mathml
from sphinx.util import logging

log = logging.getLogger(__name__)

MATHML = "{http://www.w3.org/1998/Math/MathML}"
ElementTree.register_namespace("", MATHML[1:-1])

TAG = re.compile(r"\s*\\tag\{([^{}]*)\}")
REPLACED = (
    (re.compile(r"\\([tdc]?frac)\s*([0-9a-z])\s*([0-9a-z])"), r"\\\1{\2}{\3}"),  # it reads numbers whole
    (re.compile(r"\\([tdc]?frac|sqrt)\s*([0-9])(?![0-9])"), r"\\\1{\2}"),
    (re.compile(r"\\dots\b"), r"\\ldots"),
    (re.compile(r"\\mathrel\s*\{\s*([^{}]*?)\s*\}"), r"\1"),  # what stands before "=" is put to it below
    (re.compile(r"\\mathop\s*\{\s*\\mathrm\s*\{(\w+)\}\s*\}"), r"\\operatorname{\1}"),
)
"""What docutils lacks, and what says the same."""
NAMED = re.compile(r"&(?!lt;|gt;|amp;|quot;|apos;)\w+;")
ACCENTS = frozenset("ˆˉ˙¨→")
DOTS = frozenset("˙¨")
SIGNS = frozenset("+-−±∓")
CLOSE = frozenset("|/")
"""Signs without space around them."""
APPLIED, THIN = "\u2061", "0.17em"
"""What stands between a function's name and its argument, and how wide it is."""
MINUS = ("+", "-", "−")
UNDER = (f"{MATHML}munder", f"{MATHML}munderover")
BEFORE_SIGNS = frozenset("∑=(,[<>≤≥≠∈→⟶+-−±·⋅×/")
"""Behind these a plus or a minus is a sign and no operation."""
PRIMES = re.compile(r"('+)(?:\^(\{(?:[^{}]|\{[^{}]*\})*\}|\\?\w))?")
"""Primes, with an exponent behind them: docutils would hang an index on the prime."""


def converted(formula: str, as_block: bool) -> tuple[str, str]:
    """MathML of a formula, and the number of its equation or nothing; raises ``MathError``."""
    found = TAG.search(formula)
    text = TAG.sub("", formula)
    for pattern, instead in REPLACED:
        text = pattern.sub(instead, text)
    text = PRIMES.sub(lambda primes: "^{" + r"\prime " * len(primes[1]) + (primes[2] or "") + "}", text)
    mathml = tex2mathml(text.strip(), as_block=as_block)
    written = NAMED.sub(lambda named: unescape(named[0]), mathml if isinstance(mathml, str) else "".join(mathml))
    tree = ElementTree.fromstring(written)
    _as_tex_has_it(tree)
    return ElementTree.tostring(tree, encoding="unicode", short_empty_elements=False), found[1] if found else ""


def _as_tex_has_it(element: ElementTree.Element) -> None:
    """An index beside a letter with an accent, not under it; ``+=`` as one sign; Greek capitals upright; spaces."""
    for child in element:
        _as_tex_has_it(child)
    parts = list(element)
    element.text, element.tail = "" if parts else element.text, ""
    if element.tag == f"{MATHML}munderover" and parts[2].tag == f"{MATHML}mo" and parts[2].text in ACCENTS:
        accented = ElementTree.Element(f"{MATHML}mover", accent="true")
        accented.extend((parts[0], parts[2]))
        element.tag = f"{MATHML}msub"
        element[:] = [accented, parts[1]]
    if element.tag == f"{MATHML}msup" and parts and parts[0].tag == f"{MATHML}msub":
        element.tag = f"{MATHML}msubsup"
        element[:] = [*parts[0], parts[1]]
    if element.get("class") == "capital-greek":
        element.set("mathvariant", "normal")
    if element.tag == f"{MATHML}mo" and element.text in CLOSE:
        element.set("lspace", "0")
        element.set("rspace", "0")
    if element.text in DOTS:
        element.set("class", "dot")
    for one, other in pairwise(parts):
        opens = other.tag == f"{MATHML}mo" and other.text == "("
        if one.text == APPLIED:
            one.tag, one.text = f"{MATHML}mspace", ""
            one.set("width", "0" if opens else THIN)
        elif one.tag == f"{MATHML}mo" and (one.text or "").isalpha():
            one.set("lspace", "0" if one is parts[0] else THIN)
            one.set("rspace", "0" if opens else THIN)
        elif other.tag == f"{MATHML}mo" and one.tag == f"{MATHML}mo" and one.text in MINUS and other.text == "=":
            other.text = one.text + "="
            element.remove(one)
        elif other.tag == f"{MATHML}mo" and other.text in SIGNS and (one.text in BEFORE_SIGNS or one.tag in UNDER):
            other.set("form", "prefix")


def _written(translator: Any, node: nodes.Element, as_block: bool) -> tuple[str, str]:
    try:
        return converted(node.astext(), as_block)
    except (MathError, SyntaxError, KeyError, IndexError, AttributeError) as error:
        log.warning("formula that is not drawn: %s (%s)", node.astext(), error, location=node)
        return f"<code>{escape(node.astext())}</code>", ""


def visit_inline(translator: Any, node: nodes.Element) -> None:
    translator.body.append(f'<span class="formula">{_written(translator, node, False)[0]}</span>')
    raise nodes.SkipNode


def visit_block(translator: Any, node: nodes.Element) -> None:
    mathml, number = _written(translator, node, True)
    anchor = f' id="eq-{escape(number)}"' if number else ""
    told = f'<a class="number" href="#eq-{escape(number)}">({escape(number)})</a>' if number else ""
    translator.body.append(f'<div class="formula"{anchor}><div class="drawn">{mathml}</div>{told}</div>\n')
    raise nodes.SkipNode


def copy_font(app: Any, exception: Exception | None) -> None:
    if exception is None and app.builder.format == "html":
        font = files("ziamath") / "fonts" / "STIXTwoMath-Regular.ttf"
        Path(app.outdir, "_static", "STIXTwoMath-Regular.ttf").write_bytes(font.read_bytes())


def setup(app: Any) -> dict[str, Any]:
    app.connect("build-finished", copy_font)
    app.add_html_math_renderer("mathml", (visit_inline, None), (visit_block, None))
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
