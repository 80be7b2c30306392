"""Types of numbers that models compute with, and how C writes them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ..program.dialects import Dialect


@dataclass(frozen=True)
class Precision:
    """A type of numbers: its name for people, its C type, and what the C library adds to the names of its functions.

    Quotients of whole numbers are taken in them. Decimal numbers keep the value that they have as doubles, so that a
    model in wider numbers is a model of the same mechanism.
    """

    name: str
    type: str
    suffix: str

    @property
    def double(self) -> bool:
        """Whether it is the type that the runtime's headers are written in."""
        return self.name == "double"

    def package(self, package: str) -> str:
        """Name of the package of a scene's model in these numbers."""
        return package if self.double else f"{package}_{self.name}"

    @property
    def capsule(self) -> str:
        """Name of the capsule that hands the model over: a runtime over other numbers does not take it."""
        return "ccgen.model" if self.double else f"ccgen.model.{self.name}"

    @property
    def preamble(self) -> tuple[str, ...]:
        """Lines before and after the runtime's headers, which are written over ``double``."""
        return (
            () if self.double else (f"#define CCGEN_OF_TYPE(name) name##{self.suffix}", f"#define double {self.type}")
        )

    def dialect(self, vector: str = "") -> Dialect:
        """C in these numbers; ``vector`` is the type of vectors."""
        from ..program.dialects import Dialect  # here, since reading scenes must not wait for SymPy

        decimal, whole = ("f", "f") if self.name == "float" else ("", self.suffix.upper())
        return Dialect(suffix=self.suffix, decimal=decimal, whole=whole, vector=vector)


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
