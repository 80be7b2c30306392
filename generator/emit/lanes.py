"""A kernel over lanes: the same assignments as for one state, with the type that each quantity has.

What depends on the state, on time or on inputs is a vector, one number per lane; what depends on parameters alone is a
number, the same in all lanes. C mixes the two in sums and products, so no expression changes.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace

from .rolling import NAME, Line, Lines, Loop

VECTOR, NUMBER = "const ccgen_lanes ", "const double "


class Lanes:
    """Knows which names are vectors, from the names of arrays and arguments and from what was typed before."""

    def __init__(self, vectors: Iterable[str]) -> None:
        self.vectors = set(vectors)

    def is_vector(self, text: str) -> bool:
        """Whether the value of an expression is a vector."""
        return any(name in self.vectors for name in NAME.findall(text))

    def line(self, line: Line) -> Line:
        """The assignment with its type in front; what lies in an array is a vector in any case."""
        name, text = line
        if "[" in name:
            return name, self.vector(text)
        if self.is_vector(text):
            self.vectors.add(name)
            return VECTOR + name, text
        self.vectors.discard(name)
        return NUMBER + name, text

    def vector(self, text: str) -> str:
        """The expression as a vector."""
        return text if self.is_vector(text) else f"CCGEN_ALL({text})"

    def section(self, section: Lines | Loop) -> Lines | Loop:
        """A block or a loop of blocks."""
        if isinstance(section, Loop):
            body = tuple(replace(block, lines=tuple(map(self.line, block.lines))) for block in section.body)
            return replace(section, body=body)
        return replace(section, lines=tuple(map(self.line, section.lines)))


def over_lanes(function: Mapping[str, object], guards: Iterable[tuple[str, str]], tolerance: str) -> dict[str, object]:
    """The slots of ``lanes.c.j2`` from those of a function of ``model.c.j2`` and its guards (pivot, scale)."""
    slots: dict[str, object] = dict(function)
    arrays: list[tuple[str, int]] = function["arrays"]  # type: ignore[assignment]
    given = ("q", "u", "t", "inputs")
    lanes = Lanes({*given, "c", "s", *(name for name, _ in arrays)})
    loads: list[Line] = function["loads"]  # type: ignore[assignment]
    sections: list[Lines | Loop] = function["sections"]  # type: ignore[assignment]
    outputs: list[Line] = function["outputs"]  # type: ignore[assignment]
    unused: list[str] = function["unused"]  # type: ignore[assignment]
    filled = ("u_dot", "lambda")
    slots["signature"] = "const double *k, " + ", ".join(
        [f"const double *{name}_lanes" for name in given] + [f"double *{name}_lanes" for name in filled]
    )
    slots["loads"] = [lanes.line(line) for line in loads]
    slots["timed"] = "t" not in unused
    slots["sections"] = [lanes.section(section) for section in sections]
    slots["outputs"] = [(target, lanes.vector(text)) for target, text in outputs]
    slots["unused"] = [name if name == "k" else f"{name}_lanes" for name in unused]
    slots["stored"] = [name for name in given if name not in (*unused, "t")]
    slots["filled"] = [name for name in filled if name not in unused]
    kept = " & ".join(f"({lanes.vector(pivot)} > {tolerance}*{lanes.vector(scale)})" for pivot, scale in guards)
    slots["lost_rank"] = f"ccgen_bits(~({kept}))" if kept else "0"
    return slots
