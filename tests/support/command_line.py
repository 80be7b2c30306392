"""The command line, run as a person or a script runs it."""

from __future__ import annotations

import os
import subprocess
import sysconfig
from collections.abc import Mapping
from pathlib import Path

CCGEN = str(Path(sysconfig.get_path("scripts")) / "ccgen")
PENDULUM = """\
name = "pendulum"
[chain]
links = 1
hinged = true
[gravity]
g = 9.81
[run]
until = 0.5
"""
Done = subprocess.CompletedProcess[str]


def ccgen(*options: str, at: Path, environment: Mapping[str, str] | None = None) -> Done:
    """``ccgen`` in the folder ``at``, its output in pipes."""
    return subprocess.run(
        [CCGEN, *options],
        cwd=at,
        capture_output=True,
        text=True,
        env={**os.environ, **(environment or {})},
        timeout=120,
        check=False,
    )


def written(folder: Path) -> list[str]:
    """All files below ``folder``, lock files aside."""
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file())
