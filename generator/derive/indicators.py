"""What the derivation asks of events of a scene: expressions whose zeros they are, and what they set."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import sympy as sp

from .motion import Motion

LENGTH, PACE = sp.symbols("scale_length scale_time")
"""The mechanism's length (m) and time (s), which tell how exactly lengths and rates are known: given at run time."""


@dataclass(frozen=True)
class Indication:
    """A value, its ``rate`` per second, ``None`` where that takes accelerations, and its ``size``: times the numbers'
    precision that is what the value is known to."""

    value: sp.Expr
    rate: sp.Expr | None
    size: sp.Expr


class Sets(Protocol):
    """What an event sets a parameter to."""

    def at(self, motion: Motion, name: str) -> sp.Expr:
        """The value in a motion. Names of what it consists of begin with ``name``."""
        ...


class Indicates(Protocol):
    """An event indicator."""

    def indication(self, motion: Motion, name: str) -> Indication:
        """What it is in a motion. Names of what it consists of begin with ``name``."""
        ...
