"""The equations as a LaTeX document that needs nothing but amsmath and longtable."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence

import sympy as sp
from sympy.printing.latex import LatexPrinter

from ..derive.expanded import ExpandedForm
from ..equations.equations import Assignment, Block, Equations, Kernel, Output
from ..equations.names import State
from ..program.dialects import LISTING, write
from ..program.prices import Price
from .price_table import HEADINGS, price_rows

Summary = tuple[tuple[str, tuple[str, ...]], ...]
"""Headings, each with its lines."""

WIDTH = 78
"""Signs that fit on a line; a longer sum is broken between its terms."""

MATRIX_WIDTH = 66
"""The same for a matrix, whose brackets and gaps take room."""

GREEK = ("theta", "alpha", "beta", "lambda", "Lambda", "mu", "nu", "rho", "Phi")

HEADS: dict[str, tuple[str, str]] = {
    "w": (r"\omega", ""),
    "w2": (r"\omega", "2"),
    "dw": (r"\Delta\omega", ""),
    "dv": (r"\Delta v", ""),
    "c": (r"\mathrm{c}", ""),
    "s": (r"\mathrm{s}", ""),
    "cr": ("r", r"\omega"),
    "rc": ("r", r"\mathrm{c}"),
    "vc": ("v", r"\mathrm{c}"),
    "aR": ("a", r"\mathrm{R}"),
    "pD": (r"\hat p", ""),
    "gD": (r"\hat g", ""),
    "hD": (r"\hat h", ""),
    "DD": (r"\hat D", ""),
    "Dpsi": (r"\hat\psi", ""),
    "hDi": (r"\hat h", r"\Delta"),
    "bi": ("b", r"\Delta"),
    "di": ("d", r"\Delta"),
    "ei": ("e", r"\Delta"),
    "hi": ("h", r"\Delta"),
    "iD": ("D", "-1"),
    "iC": (r"\bar C", ""),
    "iPhi": (r"\bar\Phi", ""),
    "detC": (r"\det C", ""),
    "detPhi": (r"\det\Phi", ""),
    "idetC": (r"\det C", "-1"),
    "iG": (r"\bar G", ""),
    "detG": (r"\det G", ""),
    "idetG": (r"\det G", "-1"),
    "idetPhi": (r"\det\Phi", "-1"),
    "offset": (r"\delta", ""),
}
"""Letter and superscript for the kinds of quantities whose name is not its letter. Δ as superscript: in impact."""

PURPOSES = {
    "acceleration": r"M\dot u + h = A^{\mathsf T}\lambda,\quad A\dot u + \dot A u = 0",
    "impulse": r"M\,\Delta u = A^{\mathsf T}\Lambda + f,\quad A\,\Delta u = y",
}
"""What a kernel solves, where that is an equation."""

IMPACT = (
    r"M\,\Delta u = A^{\mathsf T}\Lambda + N^{\mathsf T}P,\quad A u^{+} = 0,"
    r"\quad 0\le P \perp N u^{+} + e\,N u^{-} \ge 0"
)

PREAMBLE = r"""\documentclass[10pt]{article}
\usepackage[a4paper,margin=18mm]{geometry}
\usepackage{amsmath}
\usepackage{amssymb}
\usepackage{longtable}
\allowdisplaybreaks
\renewcommand{\arraystretch}{1.3}
\setcounter{MaxMatrixCols}{20}
\setlength{\parindent}{0pt}
\begin{document}
"""


def recursive_document(summary: Summary, equations: Equations, added: Sequence[Price] = ()) -> str:
    """Summary, what effects add, parameters, the blocks of the derivation in order, and what each kernel gives."""
    parts = [_title(summary), _prices(added), _parameters(equations), r"\section*{Derivation}"]
    parts += [_block(block) for block in equations.blocks]
    parts.append(r"\section*{Results}")
    parts += [_kernel(kernel, equations.state) for kernel in equations.kernels]
    if equations.contacts:
        parts += [r"\subsection*{Impact}", _law(IMPACT)]
    return _document(parts)


def expanded_document(summary: Summary, form: ExpandedForm, added: Sequence[Price] = ()) -> str:
    """Summary and the closed form, its matrices whole where they fit on a line and by entries where not."""
    u = [symbol_tex(s.name) for s in form.state.u]
    rows = [symbol_tex(s.name) for s in form.multipliers]
    right = " + ".join([*(["Q"] if form.Q is not None else []), *([r"A^{\mathsf T}\lambda"] if rows else [])])
    law = rf"M\dot u + h = {right or '0'}" + (r",\quad A\dot u + \dot A u = 0" if rows else "")
    parts = [_title(summary), _prices(added), r"\section*{Flight}", _law(law), _named_vector("u", u)]
    if rows:
        parts.append(_named_vector(r"\lambda", rows))
    parts += [_matrix("M", form.M, True), _matrix("h", form.h)]
    if form.Q is not None:
        parts += [_assignments(form.forces), _matrix("Q", form.Q)]
    if rows:
        parts += [_matrix("A", form.A), _matrix(r"\dot A u", form.A_rate)]
    if form.contacts:
        law = IMPACT if rows else r"M\,\Delta u = N^{\mathsf T}P,\quad 0\le P \perp N u^{+} + e\,N u^{-} \ge 0"
        parts += [r"\section*{Impact}", _law(law)]
        parts.append("Rows of $N$: " + escape(", ".join(f"{p} on {g}" for p, g in form.contacts)) + ".")
        parts.append(_assignments(form.definitions))
        parts.append(_matrix("N", form.N))
    return _document(parts)


# -- names and expressions -----------------------------------------------------------------------------------------


def symbol_tex(name: str) -> str:
    r"""A name of the derivation as mathematics: ``Phi_3_xx`` is \Phi_{3,xx}."""
    head, *rest = name.split("_")
    if head == "given" and rest:
        return symbol_tex("_".join(rest))
    if head == "F" and rest and rest[0][0] in "vw":
        return f"F_{{{symbol_tex('_'.join(rest))}}}"
    if head == "length" and rest:
        return rf"\lvert {symbol_tex('_'.join(rest))}\rvert"
    dotted = bool(rest) and rest[-1] == "dot"
    rest = rest[:-1] if dotted else rest
    if head in ("vx", "vy", "mx", "my"):
        head, rest = head[0], [*rest, head[1]]
        head = r"\bar\mu" if head == "m" else head
    plain_point = head == "c" and len(rest) > 1
    tex, above = ("c", "") if plain_point else HEADS.get(head, (_letter(head), ""))
    tex = rf"\dot{{{tex}}}" if dotted else tex
    below = f"_{{{','.join(map(_index, rest))}}}" if rest else ""
    return tex + below + (f"^{{{above}}}" if above else "")


def _letter(head: str) -> str:
    if head.startswith("\\") or len(head) == 1:
        return head
    return f"\\{head}" if head in GREEK else rf"\mathrm{{{head}}}"


def _index(part: str) -> str:
    return part if part.isdigit() or re.fullmatch("[a-z]|[xy][xy]", part) else rf"\mathrm{{{part}}}"


def expression_tex(e: sp.Expr) -> str:
    """An expression as mathematics."""
    names = {s: symbol_tex(s.name) for s in e.free_symbols}
    return str(LatexPrinter({"symbol_names": names}).doprint(e))


def escape(text: str) -> str:
    """Plain text for LaTeX."""
    special = {"\\": r"\textbackslash{}", "^": r"\textasciicircum{}", "~": r"\textasciitilde{}"}
    return "".join(special.get(c, "\\" + c if c in "_&%$#{}" else c) for c in text)


def _sum(left: str, e: sp.Expr) -> str:
    """``left = e``, broken between terms where it is too long for a line."""
    terms = sorted(sp.Add.make_args(e), key=_reading_order)
    lines, line = [], f"{left} &= "
    for number, term in enumerate(terms):
        text = expression_tex(term)
        text = text if number == 0 else (f" - {text[1:].lstrip()}" if text.startswith("-") else f" + {text}")
        if number and _width(line + text) > WIDTH:
            lines.append(line)
            line = r"&\quad"
        line += text
    return " \\\\\n".join([*lines, line])


def _reading_order(term: sp.Expr) -> tuple[bool, bool, int, str]:
    """Positive terms first, short ones before long ones, as in the listing."""
    text = write(term, LISTING)
    bare = text.removeprefix("-")
    return (text.startswith("-"), "*" in bare or "/" in bare, bare.count("*"), bare)


def _width(tex: str) -> float:
    """Roughly the number of full-size signs that a formula is wide."""
    tex = re.sub(r"\\(left|right|mathrm|dot|hat|bar|mathsf|[lr]vert|quad)\b|[&$\s]", "", tex)
    tex = re.sub(r"\\frac\{(.*?)\}\{\d+\}", r"\1", tex)
    tex = re.sub(r"\\[A-Za-z]+", "x", tex)
    small = sum(len(part) for part in re.findall(r"[_^]\{([^{}]*)\}", tex))
    return len(re.sub(r"[{}_^]", "", tex)) - 0.4 * small


# -- parts of a document -------------------------------------------------------------------------------------------


def _document(parts: Iterable[str]) -> str:
    return PREAMBLE + "\n\n".join(part for part in parts if part) + "\n\\end{document}"


def _title(summary: Summary) -> str:
    lines = [rf"\section*{{{escape(summary[0][1][0])}}}", r"\begin{description}"]
    for heading, entries in summary[1:]:
        mathematics = heading.startswith(("coordinates", "quasi-velocities"))
        lines.append(rf"\item[{escape(heading)}] " + r"\\ ".join(map(_names if mathematics else escape, entries)))
    return "\n".join([*lines, r"\end{description}"])


def _names(listed: str) -> str:
    return ", ".join(f"${symbol_tex(name)}$" for name in listed.split(", "))


def _prices(added: Sequence[Price]) -> str:
    """What each effect adds in operations, as a table."""
    if not added:
        return ""
    rows = [" & ".join(map(escape, row)) + r" \\" for row in (HEADINGS, *price_rows(added))]
    heading = r"\subsection*{Operations added by effects}"
    return "\n".join([heading, r"\begin{longtable}{llrrrrr}", rows[0], r"\hline", *rows[1:], r"\end{longtable}"])


def _parameters(equations: Equations) -> str:
    listed = equations.folded or equations.parameters
    rows = [f"${symbol_tex(p.symbol)}$ & {escape(p.path)} & {escape(repr(p.value))} \\\\" for p in listed]
    heading = r"\section*{Parameters, folded into the equations}" if equations.folded else r"\section*{Parameters}"
    return "\n".join([heading, r"\begin{longtable}{lll}", *rows, r"\end{longtable}"])


def _align(lines: Iterable[str]) -> str:
    body = " \\\\\n".join(lines)
    return f"\\begin{{align*}}\n{body}\n\\end{{align*}}" if body else ""


def _assignments(assignments: Iterable[Assignment]) -> str:
    """One line per assignment; a square that has a name of its own (``w2_3``) reads the same on both sides."""
    named = [(symbol_tex(a.symbol.name), a.expression) for a in assignments]
    return _align(_sum(left, e) for left, e in named if left != expression_tex(e))


def _law(tex: str) -> str:
    return f"\\[\n{tex}\n\\]"


def _block(block: Block) -> str:
    """Gibbs function, the equations that the block solves, and its assignments."""
    parts = [rf"\subsection*{{{escape(block.title.capitalize())}}}"]
    if block.gibbs:
        parts += ["Gibbs function:", _align([_sum(symbol_tex(block.gibbs.symbol.name), block.gibbs.expression)])]
    if block.stationary:
        derivatives = [rf"\partial V/\partial {symbol_tex(a.symbol.name)} = 0" for a in block.stationary]
        sums = [_sum(d, a.expression) for d, a in zip(derivatives, block.stationary, strict=True)]
        parts += ["Solved here, in flight and in impact:", _align(sums), "With"]
    parts.append(_assignments(block.assignments))
    return "\n".join(parts)


def _kernel(kernel: Kernel, state: State) -> str:
    parts = [rf"\subsection*{{{escape(kernel.name.replace('_', ' ').capitalize())}}}"]
    parts.append(_law(PURPOSES[kernel.name]) if kernel.name in PURPOSES else "")
    for output in kernel.outputs:
        if output.entries:
            parts += [escape(f"{output.meaning}:"), _align(_output(output, state))]
    return "\n".join(part for part in parts if part)


def _output(output: Output, state: State) -> Iterator[str]:
    """Entries of an output; those that are zero are left out, unless all are."""
    given = [i for i, entry in enumerate(output.entries) if entry != 0] or [0]
    labels = {
        "u_dot": [symbol_tex(f"{u}_dot") for u in state.u],
        "du": [rf"\Delta {symbol_tex(u.name)}" for u in state.u],
        "A": [f"A_{{{i // len(state.u)},{i % len(state.u)}}}" for i in range(len(output.entries))],
    }.get(output.name)
    letter = f"\\{output.name}" if output.name in GREEK else rf"\mathrm{{{output.name}}}"
    for i in given:
        yield _sum(labels[i] if labels else f"{letter}_{{{i}}}", output.entries[i])


def _named_vector(name: str, entries: Sequence[str]) -> str:
    return _law(f"{name} = \\begin{{bmatrix}} {' & '.join(entries)} \\end{{bmatrix}}^{{\\mathsf T}}")


def _matrix(name: str, matrix: sp.ImmutableMatrix, symmetric: bool = False) -> str:
    """The matrix, or its entries that are not zero where it would not fit."""
    cells = [[expression_tex(matrix[i, j]) for j in range(matrix.cols)] for i in range(matrix.rows)]
    width = sum(max(_width(row[j]) + 2 for row in cells) for j in range(matrix.cols))
    if width <= MATRIX_WIDTH:
        rows = " \\\\\n".join(" & ".join(row) for row in cells)
        return _law(f"{name} = \\begin{{bmatrix}}\n{rows}\n\\end{{bmatrix}}")
    short = f"({name})" if " " in name else name
    entries = []
    for i in range(matrix.rows):
        for j in range(i if symmetric else 0, matrix.cols):
            if matrix[i, j] != 0:
                label = f"{short}_{{{i + 1}}}" if matrix.cols == 1 else f"{short}_{{{i + 1},{j + 1}}}"
                twin = f" = {short}_{{{j + 1},{i + 1}}}" if symmetric and i != j else ""
                entries.append(_sum(label + twin, matrix[i, j]))
    return "Entries that are not written are zero.\n" + _align(entries)
