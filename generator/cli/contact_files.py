"""What ``ccgen run --csv`` writes of impacts and phases, where a scene can have any."""

from __future__ import annotations

from collections.abc import Callable, Collection
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from .forces import touches

if TYPE_CHECKING:
    from ccgen.runtime import Run

    from ..scene.scene import Scene

IMPACTS, PHASES = "impacts.csv", "phases.csv"


def contact_files(scene: Scene, csv: bool) -> list[str]:
    """Names of the files of impacts and phases that a run of the scene may write: joints that take hold strike too."""
    strikes = touches(scene) or any(change.kind == "hold" for change in scene.changes)
    return [IMPACTS, PHASES] if csv and strikes else []


def ways_to_write_contacts(run: Run, names: Collection[str]) -> dict[str, Callable[[Path], object]]:
    """By the name of each of these files, of those that are asked for by ``names``, what writes it."""
    from ccgen.runtime.record.contact_tables import write_impacts, write_phases

    ways = {IMPACTS: partial(write_impacts, run), PHASES: partial(write_phases, run)}
    return {name: way for name, way in ways.items() if name in names}
