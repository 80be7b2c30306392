"""What ``ccgen run --plot`` draws and writes: outputs of the run by name."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from .refusal import fail

if TYPE_CHECKING:
    from ccgen.runtime import Model, Run

PICTURE, TABLE = "outputs.png", "outputs.csv"
MOST_TIMES = 1_000_000


@dataclass(frozen=True)
class Wanted:
    """Outputs that are to be drawn, by ``names``; with ``csv`` also as a table, at so many even ``times``, or at the
    rows of the run where that is None."""

    names: tuple[str, ...]
    csv: bool
    times: int | None

    @property
    def files(self) -> list[str]:
        """Names of the files."""
        return [*([PICTURE] if self.names else []), *([TABLE] if self.names and self.csv else [])]

    def check(self, model: Model) -> None:
        """Stop with exit code 2 unless the model has all of them."""
        from ccgen.runtime.record.outputs import unknown

        found = unknown(model, self.names)
        if found:
            fail("\n".join(f"--plot: {fault}" for fault in found))

    def ways_to_write(self, run: Run) -> dict[str, Callable[[Path], object]]:
        """By the name of each of the files what writes it."""
        from ccgen.runtime.pictures.output_plot import draw_outputs
        from ccgen.runtime.record.output_table import write_outputs

        ways = {PICTURE: partial(draw_outputs, run, self.names)}
        ways[TABLE] = partial(write_outputs, run, self.names, times=self.times)
        return {name: ways[name] for name in self.files}


def read_wanted(plot: str | None, csv: bool, times: str | None) -> Wanted:
    """What the options ask for; exit code 2 where they do not say it."""
    names = tuple(dict.fromkeys(name.strip() for name in (plot or "").split(",") if name.strip()))
    if plot is not None and not names:
        fail(f'--plot: found "{plot}", expected names with commas between them, such as "crank.angle,pin.force"')
    if times is None:
        return Wanted(names, csv, None)
    if not (names and csv):
        fail("--times: found without --plot and --csv, expected both; it says how many even times outputs.csv has")
    if not (times.isascii() and times.isdigit() and 2 <= int(times) <= MOST_TIMES):
        fail(f"--times: found {times}, expected a whole number from 2 to {MOST_TIMES}")
    return Wanted(names, csv, int(times))
