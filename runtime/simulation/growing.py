"""Runs that are looked at while they grow, so that wherever they end it is known what has come along them."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from ..arrays import FloatArray
from ..run import Run
from .interruption import check

LEAST, PART = 64, 8
"""A run is looked at when it has an eighth more rows than when it was last: so all copies of its rows are of nine times
them at most, and what is lost where it is interrupted is a ninth. Less than 64 are not worth a copy."""
BLOCK = 16
"""Rows between two questions whether Ctrl-C has come."""
NEVER = 2**62
"""More rows than a run has."""

Look = Callable[[Run], int]
"""What is shown a run that grows, first its start. It says how many rows it wants to see next, or raises
:class:`Enough`."""


class Enough(Exception):
    """What a look raises, of which it is the ``by``, where a run need not go on."""

    def __init__(self, by: object) -> None:
        super().__init__()
        self.by = by


def wanted(rows: int) -> int:
    """How many rows a run of so many is to have when it is looked at next."""
    return rows + max(LEAST, rows // PART)


def sure_rows(before: Run | None, run: Run, changes: bool) -> Run | None:
    """A run as far as its rows stay what they are, where nothing has come along it. Something that ``changes`` it may
    come within a hundredth of a step after its last row, which is then left out: so that is as far as the run was when
    it was looked at ``before``. Its start stays."""
    return run if not changes or len(run.t) == 1 else before


def at_the_start(run: Run) -> int:
    """A look at nothing else: for a stretch that its caller has seen. Where it is interrupted it raises that."""
    return NEVER


def blocks(t: FloatArray, first: int) -> Iterator[slice]:
    """Rows at the times ``t`` (rows,) that never decrease, from ``first`` on, some at a time: each block begins with
    the last row of the one before, which is the last of its time. Raises ``KeyboardInterrupt`` between them."""
    last = len(t) - 1
    while True:
        end = min(first + BLOCK, last)
        while end < last and t[end + 1] == t[end]:
            end += 1
        yield slice(first, end + 1)
        if end == last:
            return
        first = end
        check()
