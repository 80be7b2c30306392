"""An instant of a run that its scene has asked for."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from ..arrays import FloatArray
from .frozen import freeze

ENDED = "ended at t = "
"""How the message begins of a run that an event has ended."""


@dataclass(frozen=True, eq=False)
class Event:
    """At ``t`` (s) what the ``[[event]]`` called ``name`` watches came to zero, "rising" or "falling" (``direction``).

    ``number`` counts the instants of that name in its run, from 1. ``q`` (nq,), ``u`` (nu,) are the state there, after
    an impact where there is one. ``parameters`` are the values that were set, ``before`` those that they had, ``on``
    and ``off`` the effects that were switched, and ``energy`` (J) is what the mechanism got by all that.
    """

    t: float
    name: str
    direction: Literal["rising", "falling"]
    number: int
    q: FloatArray = field(repr=False)
    u: FloatArray = field(repr=False)
    parameters: Mapping[str, float] = field(default_factory=dict)
    energy: float = 0.0
    before: Mapping[str, float] = field(default_factory=dict)
    on: tuple[str, ...] = ()
    off: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        freeze(self, "q", "u")

    @property
    def done(self) -> tuple[str, ...]:
        """What it set and switched, in words: ``rod.mass from 1 to 2``, ``coil off``."""
        told = [_set(path, self.before.get(path), value) for path, value in self.parameters.items()]
        told += [f"{', '.join(names)} {way}" for way, names in (("on", self.on), ("off", self.off)) if names]
        return tuple(told)


def _set(path: str, before: float | None, value: float) -> str:
    """A parameter that was set, also to what it was: who reads it has asked for that. Digits are enough to tell."""
    if before is None or before == value:
        return f"{path} {'is' if before is None else 'stays'} {value:.6g}"
    first, last = f"{before:.6g}", f"{value:.6g}"
    return f"{path} from {first} to {last}" if first != last else f"{path} from {before!r} to {value!r}"
