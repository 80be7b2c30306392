"""What each effect of a scene adds in operations: the program with it less the program without it.

Nothing is attributed by name. The scene is derived again without the effect, so what an effect shares with others, or
makes necessary elsewhere, is counted as what it is.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from ..mechanism.links import Parameter
from .program import Counts, Program

GROUPS: Mapping[str, tuple[str, ...]] = {
    "acceleration": ("acceleration",),
    "energy and power": ("energy", "power"),
    "events": ("gaps", "gap_rates", "contact_impulse"),
}
"""What operations are added to, and the kernels that belong to it."""


@dataclass(frozen=True)
class Price:
    """An effect, its parameters, and the operations it adds to each of :data:`GROUPS`."""

    title: str
    parameters: tuple[Parameter, ...]
    added: Mapping[str, Counts]


def spent(program: Program) -> dict[str, Counts]:
    """Operations of a program by :data:`GROUPS`; kernels that it lacks take none."""
    own = {function.kernel.name: function.counts() for function in program.functions}
    return {group: sum((own.get(name, Counts()) for name in names), Counts()) for group, names in GROUPS.items()}


def added(program: Program, without: Program) -> dict[str, Counts]:
    """What ``program`` has beyond the program ``without`` something."""
    more, less = spent(program), spent(without)
    return {group: more[group] - less[group] for group in GROUPS}
