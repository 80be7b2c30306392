"""Expressions of the state in place of numbers of loads: ``"-30*(angle(hip) - 0.3) - 2*rate(hip)"``, and laws."""

from __future__ import annotations

import ast
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, NamedTuple

from .arithmetic import KINKED, laws_among
from .changing import Changing
from .expression_of_time import InTime, term
from .grammar_of_state import asks_state, laws_in, plain, seems_of_state

if TYPE_CHECKING:
    from pydantic import ValidationInfo
    from sympy import Expr

    from ..derive.motion import Motion
    from .expression_of_time import Quantity
    from .piecewise_in_time import Piecewise
    from .state_in_motion import ValueReader


class Kinked(NamedTuple):
    """A ``call`` with kinks, where its argument, or the difference of its two, is one of these values."""

    call: ast.Call
    at: tuple[float, ...]


@dataclass(frozen=True)
class Unread(Changing):
    """An expression of the state as a table has it: it is read when the mechanism is known."""

    text: str
    of_state: ClassVar[bool] = True

    @property
    def shown(self) -> str:
        return self.text

    def realise(self, motion: Motion, name: str) -> Expr:
        raise AssertionError(f"{self.text} has not been read")


@dataclass(frozen=True)
class OfState(Changing):
    """An expression of time and state; ``text`` is its normal form (:mod:`.grammar_of_state`).

    ``own`` are parameters that it names, each with its symbol, ``curves`` the functions of one variable that it names.
    That of a law has a ``label``, by which it stands in the equations.
    """

    text: str
    own: tuple[tuple[str, str], ...] = ()
    label: str = ""
    curves: tuple[tuple[str, Piecewise], ...] = ()
    of_state: ClassVar[bool] = True

    @property
    def shown(self) -> str:
        return plain(self.text)

    def tree(self) -> ast.expr:
        return ast.parse(self.text, mode="eval").body

    def kinks_in(self) -> list[Kinked]:
        """Its calls with kinks, each once: of ``abs`` where its argument is zero, of ``min`` and ``max`` where theirs
        are equal, and of a curve at its rows."""
        rows = {name: tuple(row[0] for row in curve.rows) for name, curve in self.curves}
        found: dict[str, Kinked] = {}
        for node in ast.walk(self.tree()):
            name = node.func.id if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) else ""
            if isinstance(node, ast.Call) and name in (*_WITH_KINKS, *rows):
                found.setdefault(ast.dump(node), Kinked(node, rows.get(name, (0.0,))))
        return [*found.values()]

    def realise(self, motion: Motion, name: str) -> Expr:
        """The value in the equations, on the sides of kinks that the run holds."""
        return self._reader(motion, name, self.sides(name)).read(self.tree())

    def sides(self, name: str) -> tuple[str, ...]:
        """Names of its kinks, where :meth:`realise` has this ``name``."""
        count = sum(len(kink.at) for kink in self.kinks_in())
        return tuple(f"{name}_kink_{number}" for number in range(1, count + 1))

    def switching(self, motion: Motion, name: str) -> list[Expr]:
        """The functions whose signs tell the sides; they have none of these in them."""
        reader, found = self._reader(motion, f"kinks_{name}", None), []
        for kink in self.kinks_in():
            first, *second = (reader.read(argument) for argument in kink.call.args)
            value = first - second[0] if second else first
            found += [value - at if at else value for at in kink.at]
        return found

    def as_law(self, motion: Motion, held: bool) -> Expr:
        """The value of a law, which the equations have once; where sides are not ``held``, with its kinks."""
        if held or not self._has_kinks(motion):
            return motion.let(self.label, self.realise(motion, f"{self.label}_part"))
        return motion.let(f"at_{self.label}", self.free(motion, f"at_{self.label}_part"))

    def free(self, motion: Motion, name: str) -> Expr:
        """The value with its kinks, free of the sides that the run holds."""
        return self._reader(motion, name, None).read(self.tree())

    def _has_kinks(self, motion: Motion) -> bool:
        """Whether it has kinks, its own or those of laws that it names."""
        waiting: list[OfState] = [self]
        for law in waiting:
            if law.kinks_in():
                return True
            named = (motion.laws[name] for name in laws_in(law.text))
            waiting += [one for one in named if isinstance(one, OfState) and one not in waiting]
        return False

    def _reader(self, motion: Motion, name: str, sides: tuple[str, ...] | None) -> ValueReader:
        from .state_in_motion import ValueReader

        mechanism = motion.kinematics.mechanism
        return ValueReader(mechanism, motion, name, self, self.kinks_in(), sides)


_WITH_KINKS = ("abs", *KINKED)


def free(of: Quantity, motion: Motion, name: str) -> Expr:
    """A quantity as :func:`.expression_of_time.term` has it, in functions that tell sides: these have none in them."""
    if isinstance(of, OfState):
        return motion.let(f"at_{name}", of.free(motion, f"at_{name}_part"))
    return term(of, motion, name)


class InLoad(InTime):
    """Marks a value of a load: a number, an expression of t, or one of the state."""

    def __repr__(self) -> str:
        return f"InLoad({', '.join(self.units)})"

    def read_state(self, text: str, info: ValidationInfo) -> Changing | None:
        names = info.context or {}
        laws = laws_among(names)
        return Unread(text) if asks_state(text, laws) or seems_of_state(text, names, laws) else None


class InLaw(InTime):
    """Marks the value of a law: a number, or an expression of time and state, always read as one of the state."""

    def __init__(self) -> None:
        super().__init__("1")

    def __repr__(self) -> str:
        return "InLaw()"

    def read_state(self, text: str, info: ValidationInfo) -> Changing | None:
        return Unread(text)


def sides_of(quantities: Mapping[str, Quantity]) -> tuple[str, ...]:
    """The sides of those that are of the state, by the names that :func:`.expression_of_time.term` has for them."""
    found = (of.sides(f"{name}_part") for name, of in quantities.items() if isinstance(of, OfState))
    return tuple(side for sides in found for side in sides)


def switching_of(quantities: Mapping[str, Quantity], motion: Motion) -> Sequence[Expr]:
    """The functions whose signs tell these."""
    found = (of.switching(motion, f"{name}_part") for name, of in quantities.items() if isinstance(of, OfState))
    return [value for values in found for value in values]
