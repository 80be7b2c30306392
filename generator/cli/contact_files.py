"""What ``ccgen run --csv`` writes of impacts and phases, where a scene can have any."""

from __future__ import annotations

from collections.abc import Callable
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
    return [IMPACTS, PHASES] if csv and (touches(scene) or scene.changes) else []


def ways_to_write(run: Run, csv: bool) -> dict[str, Callable[[Path], object]]:
    """By the name of each of these files what writes it; none of a model in which nothing can strike."""
    from ccgen.runtime.record.contact_tables import write_impacts, write_phases

    if not csv or not (run.model.contacts or run.changes or run.impacts):
        return {}
    return {IMPACTS: partial(write_impacts, run), PHASES: partial(write_phases, run)}
