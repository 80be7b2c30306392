r"""Formulas as MathML, which browsers draw by themselves: no script, no network, and the same bytes on every machine.

The conversion is that of docutils, on which Sphinx stands; it refuses what it does not know, so that a formula which
cannot be drawn ends a strict build. Three things are done before it: a ``\tag{4.7}`` becomes a number beside the formula
and an anchor, ``#eq-4.7``; a few commands that it lacks are written by others; and what stands in ``\text`` stays.
"""

from __future__ import annotations

import re
from html import escape
from typing import Any

from docutils import nodes
from docutils.utils.math import MathError
from docutils.utils.math.latex2mathml import tex2mathml
from sphinx.util import logging

log = logging.getLogger(__name__)

TAG = re.compile(r"\s*\\tag\{([^{}]*)\}")
REPLACED = (
    (re.compile(r"\\([tdc]?frac)\s*([0-9a-z])\s*([0-9a-z])"), r"\\\1{\2}{\3}"),  # it reads numbers whole
    (re.compile(r"\\([tdc]?frac|sqrt)\s*([0-9])(?![0-9])"), r"\\\1{\2}"),
    (re.compile(r"\\dots\b"), r"\\ldots"),
    (re.compile(r"\\mathrel\s*\{\s*([^{}]*?)\s*\}"), r"\1"),
    (re.compile(r"\\mathop\s*\{\s*\\mathrm\s*\{(\w+)\}\s*\}"), r"\\operatorname{\1}"),
)
"""What docutils lacks, and what says the same."""
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
    return (mathml if isinstance(mathml, str) else "\n".join(mathml)), found[1] if found else ""


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


def setup(app: Any) -> dict[str, Any]:
    app.add_html_math_renderer("mathml", (visit_inline, None), (visit_block, None))
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
