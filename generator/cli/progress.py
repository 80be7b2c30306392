"""Progress of long work: a line on the terminal with the stage, how far it is and for how long; nothing in a pipe."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import timedelta
from typing import TYPE_CHECKING

from .detail import Detail

if TYPE_CHECKING:
    from rich.progress import Progress

STAGES = {
    "derive": "deriving the equations",
    "write": "writing the sources",
    "compile": "compiling",
    "simulate": "simulating",
    "compare": "comparing",
    "draw": "drawing",
    "refer": "making a reference",
    "measure": "measuring",
    "follow": "following the motion",
}
"""What the stages are called on the terminal; others by their own name."""
INTERVAL = 0.1
"""Seconds between two looks at a simulation's time: it is told much more often than a person can read."""


class Silence:
    """Progress that nobody sees."""

    def stage(self, name: str) -> None:
        """A stage of unknown length begins."""

    def reached(self, t: float, until: float) -> None:
        """The simulation is at ``t`` of ``until`` (s)."""

    def counted(self, done: int, total: int, left: float | None = None) -> None:
        """Of ``total`` pieces of work ``done`` are done; the rest take about ``left`` seconds, where that is known."""


class Line(Silence):
    """Progress as one line of a terminal, gone when the work is done."""

    def __init__(self, display: Progress) -> None:
        self.display = display
        self.task = display.add_task("", total=None, share="")
        self.next = 0.0

    def stage(self, name: str) -> None:
        self.display.remove_task(self.task)
        self.task = self.display.add_task(STAGES.get(name, name), total=None, share="")

    def reached(self, t: float, until: float) -> None:
        now = time.monotonic()
        if now >= self.next:
            self.next = now + INTERVAL
            share = f"{t / until if until else 1.0:4.0%}  t = {t:.4g} of {until:g} s"
            self.display.update(self.task, completed=t, total=until, share=share)

    def counted(self, done: int, total: int, left: float | None = None) -> None:
        rest = "" if left is None else f", about {timedelta(seconds=round(left))} left"
        self.display.update(self.task, completed=done, total=total, share=f"{done} of {total}{rest}")


@contextmanager
def progress(detail: Detail = Detail.USUAL) -> Iterator[Silence]:
    """Where to tell of stages and times as they are reached."""
    if detail is Detail.NOTHING or not sys.stderr.isatty():
        yield Silence()
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

    share = TextColumn("{task.fields[share]}")
    columns = (SpinnerColumn(), "{task.description}", BarColumn(20), share, TimeElapsedColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as display:
        yield Line(display)
