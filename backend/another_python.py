"""Prints the newest Python on this machine of another version than this one, from 3.11 on; nothing where there is none.

Looked for on the path, as ``python3.13``, and among those that pyenv has installed.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

LEAST = (3, 11)


def candidates() -> Iterator[Path]:
    """Files that may be Pythons."""
    versions = Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv")) / "versions"
    folders = [Path(folder) for folder in os.environ.get("PATH", "").split(os.pathsep) if folder]
    for folder in (*sorted(versions.glob("*/bin")), *folders):
        yield from sorted(folder.glob("python3.[0-9]*")) if folder.is_dir() else ()


def version_of(python: Path) -> tuple[int, int] | None:
    """Its version, if it is a Python that makes environments, and starts."""
    code = "import sys, ensurepip, venv; print(*sys.version_info[:2])"
    try:
        found = subprocess.run([python, "-c", code], capture_output=True, text=True, timeout=60, check=True).stdout
    except (OSError, subprocess.SubprocessError):
        return None
    major, minor = map(int, found.split())
    return major, minor


def newest(here: tuple[int, int], found: dict[Path, tuple[int, int]]) -> Path | None:
    """The first of the newest of those that are allowed and of another version than ``here``."""
    others = {path: version for path, version in found.items() if version >= LEAST and version != here}
    return max(others, key=lambda path: others[path]) if others else None


if __name__ == "__main__":
    named = [path for path in candidates() if re.fullmatch(r"python3\.\d+", path.name)]
    known = {path: version for path in named if (version := version_of(path))}
    if chosen := newest(sys.version_info[:2], known):
        print(chosen)
