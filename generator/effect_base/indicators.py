"""Event indicators: the expressions whose zeros are a scene's events, over the moving mechanism, as equations.

The size of a value times the numbers' precision bounds its rounding, first order in it: a running error analysis.
"""

from __future__ import annotations

import ast
from dataclasses import dataclass
from typing import Protocol

import sympy as sp

from ..derive.indicators import LENGTH, PACE, Indication
from ..derive.motion import Motion
from ..mechanism.mechanism import Mechanism
from .state_in_motion import IndicationReader


@dataclass(frozen=True)
class Indicator:
    """The expression ``when`` of a mechanism's state and time, in normal form (:mod:`.grammar_of_state`)."""

    when: str
    mechanism: Mechanism

    def indication(self, motion: Motion, name: str) -> Indication:
        """Its value, rate and size; what it consists of is named by what begins with ``name``."""
        return IndicationReader(self.mechanism, motion, name).read(ast.parse(self.when, mode="eval").body)


class Changes(Protocol):
    """When a joint lets go or takes hold, as :class:`..scene.changes.Change` says it."""

    @property
    def joint(self) -> str: ...
    @property
    def at(self) -> float | None: ...
    @property
    def watch(self) -> Watches | None: ...
    @property
    def force(self) -> float | None: ...
    @property
    def meets(self) -> bool: ...


class Watches(Protocol):
    """What is watched: the quantity of a ``kind``, of what has the ``names``, and its ``limit``."""

    @property
    def kind(self) -> str: ...
    @property
    def names(self) -> tuple[str, ...]: ...
    @property
    def sign(self) -> int: ...
    @property
    def limit(self) -> float: ...


@dataclass(frozen=True)
class ChangeIndicator:
    """What rises through zero where a joint lets go or takes hold: the time less that of the change; what is watched
    less its limit; where the points of an open joint are nearest, what they miss times its rate. A force and an
    impulse in the joint are compared at run time: of these it is always below zero, and of the rate of a force nothing
    is known."""

    change: Changes
    mechanism: Mechanism

    def indication(self, motion: Motion, name: str) -> Indication:
        """Its value, rate and size; what it consists of is named by what begins with ``name``."""
        change = self.change
        if change.at is not None:
            at = sp.Float(change.at)
            return Indication(motion.time - at, sp.S.One, sp.Abs(motion.time) + at)
        if (watch := change.watch) is not None:
            kind = {"height": "y"}.get(watch.kind, watch.kind)
            quantity = f"{kind}({', '.join(map(repr, watch.names))})"
            less = f"{quantity} - ({watch.limit!r})" if watch.sign > 0 else f"({watch.limit!r}) - {quantity}"
            return Indicator(less, self.mechanism).indication(motion, name)
        if change.force is not None:
            return Indication(sp.S.NegativeOne, None, sp.Float(change.force))
        if not change.meets:
            return Indication(sp.S.NegativeOne, sp.S.Zero, sp.S.Zero)
        path = f"{change.joint}.held"
        number = next(k for k, gate in self.mechanism.gates.items() if gate.path == path)
        rows = motion.closure.missing(number)
        value = sp.Add(*(miss * rate for miss, rate in rows))
        size = sp.Add(*(LENGTH * (sp.Abs(rate) + sp.Abs(miss) / PACE) for miss, rate in rows))
        return Indication(motion.let(name, value), None, motion.let(f"{name}_size", size))


@dataclass(frozen=True)
class SetTo:
    """What an event sets a parameter to: a number, or an expression as :class:`Indicator` has one."""

    value: float | str
    mechanism: Mechanism

    def at(self, motion: Motion, name: str) -> sp.Expr:
        """Its value in a motion; what it consists of is named by what begins with ``name``."""
        if isinstance(self.value, str):
            return Indicator(self.value, self.mechanism).indication(motion, name).value
        return sp.Float(self.value)
