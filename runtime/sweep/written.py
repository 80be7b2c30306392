"""Numbers of a plan that are written as texts, as ``"20 deg"``, made plain ones in SI units."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

Written = Callable[[str, str | None, str | None], float]
"""The number (SI) that a text stands for, which measures what a unit does, or what a parameter of this path does, as
far as that is known. Raises ``ValueError`` with a sentence on what to write instead."""

UNITS = {"angle": "rad", "angular_velocity": "rad/s", "slide": "m", "slide_rate": "m/s"}
UNITS |= {"x": "m", "y": "m", "vx": "m/s", "vy": "m/s"}
"""What coordinates of a start and their rates measure, by the last words of their names."""
VARIED = ("values", "from", "to", "mean", "deviation")
TIMES = ("until", "step")
"""Keys of ``[run]`` that are times."""


class Plain:
    """Tables of a plan with plain numbers for texts; ``faults`` say by key what is wrong with those that are none."""

    def __init__(self, written: Written) -> None:
        self.written = written
        self.faults: dict[str, str] = {}

    def of(self, tables: Mapping[str, Any]) -> dict[str, Any]:
        """The tables; what is no text, or not where numbers are, stays as it is."""
        found = dict(tables)
        if "at" in found:
            found["at"] = self._number(found["at"], "at", "s")
        if isinstance(run := found.get("run"), Mapping):
            read = {key: self._number(one, f"run.{key}", "s") if key in TIMES else one for key, one in run.items()}
            found["run"] = {key: one for key, one in read.items() if f"run.{key}" not in self.faults}
        if isinstance(vary := found.get("vary"), list):
            found["vary"] = [self._varied(one, f"vary[{number}]") for number, one in enumerate(vary)]
        return found

    def _varied(self, one: Any, where: str) -> Any:
        if not isinstance(one, Mapping):
            return one
        unit = UNITS.get(str(one.get("start", "")).rpartition(".")[2])
        path = str(one["parameter"]) if "parameter" in one else None
        return {
            key: self._number(value, f"{where}.{key}", unit, path) if key in VARIED else value
            for key, value in one.items()
        }

    def _number(self, value: Any, where: str, unit: str | None, path: str | None = None) -> Any:
        if isinstance(value, list):
            return [self._number(one, where, unit, path) for one in value]
        if not isinstance(value, str):
            return value
        try:
            return self.written(value, unit, path)
        except ValueError as error:
            self.faults[where] = f'{where}: found "{value}": {error}'
            return value
