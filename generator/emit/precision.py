"""The generated C in another type of numbers: the same program, with another word for ``double``."""

from __future__ import annotations

import re
from dataclasses import dataclass


@dataclass(frozen=True)
class Precision:
    """A type of numbers: its name for people, its C type, and what the C library adds to the names of its functions."""

    name: str
    type: str
    suffix: str

    @property
    def double(self) -> bool:
        """Whether it is the type that sources are written in."""
        return self.name == "double"

    def package(self, package: str) -> str:
        """Name of the package of a scene's model in these numbers."""
        return package if self.double else f"{package}_{self.name}"

    @property
    def capsule(self) -> str:
        """Name of the capsule that hands the model over: a runtime over other numbers does not take it."""
        return "ccgen.model" if self.double else f"ccgen.model.{self.name}"

    def write(self, source: str) -> str:
        """C written over doubles, in these numbers.

        Quotients of whole numbers are taken in them. Decimal numbers keep the value that they have as doubles, so that
        a model in wider numbers is a model of the same mechanism.
        """
        if self.double:
            return source
        return "".join(
            part if part.startswith(("/*", '"')) else self._code(part) for part in NO_CODE.split(source) if part
        )

    def _code(self, code: str) -> str:
        code = FUNCTION.sub(lambda found: found[0] + self.suffix, code)
        code = re.sub(r"\bdouble\b", self.type, code)
        return NUMBER.sub(r"\g<0>f", code) if self.name == "float" else QUOTIENT.sub(r"(\1L/\2L)", code)


NO_CODE = re.compile(r'(/\*.*?\*/|"[^"\n]*")', re.DOTALL)
FUNCTION = re.compile(r"\b(?:sin|cos|tan|exp|log|tanh|fabs|sqrt)\b(?=\()")
NUMBER = re.compile(r"(?<![\w.])(?:\d+\.\d*(?:e[-+]?\d+)?|\d+e[-+]?\d+)(?![\w.])")
QUOTIENT = re.compile(r"\((\d+\.0)/(\d+\.0)\)")

PRECISIONS = {
    precision.name: precision
    for precision in (
        Precision("float", "float", "f"),
        Precision("double", "double", ""),
        Precision("wide", "long double", "l"),
    )
}
"""Types of numbers by name; "wide" is the widest that every C compiler has, on some machines no wider than a double."""

DOUBLE = PRECISIONS["double"]
