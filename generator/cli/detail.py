"""How much a command says beside its result."""

from __future__ import annotations

from enum import Enum

from .refusal import Faults


class Detail(Enum):
    """From ``--quiet`` to ``--verbose``."""

    NOTHING = 0
    USUAL = 1
    ALL = 2


def detail(faults: Faults, verbose: bool, quiet: bool) -> Detail:
    """What the two options ask for; that they contradict each other is one of the ``faults``."""
    if verbose and quiet:
        faults.add("--quiet: found beside --verbose, expected one of them; leave one out")
    return Detail.ALL if verbose else Detail.NOTHING if quiet else Detail.USUAL
