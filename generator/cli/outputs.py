"""What ``ccgen run`` and ``ccgen plot`` draw and write: outputs of the run by name."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from .known_outputs import of_effects, possible_outputs
from .refusal import fail

if TYPE_CHECKING:
    from ccgen.runtime import Model, Run

    from ..scene.scene import Scene

PICTURE, TABLE = "outputs.png", "outputs.csv"
MOST_TIMES = 1_000_000


@dataclass(frozen=True)
class Wanted:
    """Outputs by name: those of the ``plot``, and those of the ``table``, at so many even ``times``, or at the rows of
    the run where that is None; the table of forces too. Each has where it is asked for before it: ``--plot``,
    ``output.plot[0]``."""

    plot: tuple[tuple[str, str], ...] = ()
    table: tuple[tuple[str, str], ...] = ()
    times: int | None = None

    @property
    def files(self) -> list[str]:
        """Names of the files."""
        return [*([PICTURE] if self.plot else []), *([TABLE] if self.table else [])]

    def beside(self, scene: Scene, file: Path) -> Wanted:
        """That, and what the scene of a file asks for in its place where this asks for none of a kind."""
        plot = tuple((f"{file}: output.plot[{index}]", name) for index, name in enumerate(scene.output.plot))
        table = tuple((f"{file}: output.table[{index}]", name) for index, name in enumerate(scene.output.table))
        if self.table:
            return Wanted(self.plot or plot, self.table, self.times)
        return Wanted(self.plot or plot, table, self.times or scene.output.times)

    def check_scene(self, scene: Scene) -> None:
        """Stop with exit code 2 where no model of the scene has one of them, before anything is compiled. What effects
        tell is known of the model alone: :meth:`check` looks at all again."""
        from ccgen.runtime.record.outputs import unknown_name

        known = possible_outputs(scene)
        every = "ccgen show --outputs has all"
        found = [
            f"{where}: {unknown_name(name, known, every)}"
            for where, name in self._asked
            if name not in known and f"{name}.x" not in known and not of_effects(scene, name)
        ]
        if found:
            fail("\n".join(found))

    @property
    def _asked(self) -> tuple[tuple[str, str], ...]:
        """All of them once, with where each is asked for first."""
        return tuple(dict.fromkeys((*self.plot, *(one for one in self.table if one not in self.plot))))

    def check(self, model: Model) -> None:
        """Stop with exit code 2 unless the model has all of them."""
        from ccgen.runtime.record.outputs import unknown, with_places

        asked = self._asked
        found = [f"{where}: {fault}" for where, name in asked for fault in unknown(model, with_places(model, [name]))]
        if found:
            fail("\n".join(found))

    def ways_to_write(
        self, run: Run, settings: Mapping[str, object] | None = None
    ) -> dict[str, Callable[[Path], object]]:
        """By the name of each of the files what writes it; the picture names the ``settings``."""
        from ccgen.runtime.pictures.output_plot import draw_outputs
        from ccgen.runtime.record.output_table import write_outputs
        from ccgen.runtime.record.outputs import with_places

        plot = list(dict.fromkeys(name for _, name in self.plot))
        table = with_places(run.model, [name for _, name in self.table])
        ways = {
            PICTURE: partial(draw_outputs, run, plot, settings=settings),
            TABLE: partial(write_outputs, run, table, times=self.times),
        }
        return {name: ways[name] for name in self.files}


def read_wanted(names: Sequence[str] | None, csv: bool, times: str | None, option: str = "--plot") -> Wanted:
    """What the options ask for, names by themselves or with commas between them; exit code 2 where they do not say
    it."""
    found = [(option, name.strip()) for text in names or () for name in text.split(",") if name.strip()]
    if names and not found:
        fail(f'{option}: found "{names[0]}", expected names with commas between them, such as "crank.angle,pin.force"')
    plot = tuple(dict.fromkeys(found))
    table = plot if csv else ()
    if times is None:
        return Wanted(plot, table)
    if not (csv and (plot or option == "--plot")):
        fail("--times: found without --csv, expected it; it says how many even times the tables have")
    if not (times.isascii() and times.isdigit() and 2 <= int(times) <= MOST_TIMES):
        fail(f"--times: found {times}, expected a whole number from 2 to {MOST_TIMES}")
    return Wanted(plot, table, int(times))
