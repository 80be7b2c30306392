"""How many runs are made at a time: as many as take some seconds, by what those before have taken."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

SECONDS = 2.0
"""How long a chunk is meant to take: long against what it costs to send, short against what is lost with a worker."""
GROWTH = 4
"""Times as long as the one before a chunk may be."""


class Sizes:
    """The number of runs in the next chunk: ``fixed`` where that is given, else from ``first`` on by measured times."""

    def __init__(self, fixed: int | None, first: int) -> None:
        self.fixed, self.next = fixed is not None, fixed or first

    def took(self, runs: int, seconds: float) -> None:
        """So many runs have taken so long."""
        if not self.fixed:
            wanted = int(runs * SECONDS / max(seconds, 1e-6))
            self.next = max(1, min(wanted, GROWTH * max(runs, self.next)))


def cut(gaps: Sequence[tuple[int, int]], sizes: Sizes) -> Iterator[tuple[int, int]]:
    """First and last run of one chunk after the other, each as long as ``sizes`` says when it is asked for."""
    for begin, end in gaps:
        first = begin
        while first < end:
            last = min(first + sizes.next, end)
            yield first, last
            first = last
