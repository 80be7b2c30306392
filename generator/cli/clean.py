"""Removes what ccgen wrote into folders and says what stays: ``python -m ccgen.generator.cli.clean``, for make."""

from __future__ import annotations

import os
import sys
from pathlib import Path

from ..package.parts import discard, is_package
from .folders import forget_results


def clean(folder: Path) -> list[Path]:
    """Remove packages, results and then empty folders at and below ``folder``; returns what stays."""
    if folder.is_symlink() or not folder.is_dir():
        return [folder] if os.path.lexists(folder) else []
    if is_package(folder):
        discard(folder)
    else:
        forget_results(folder)
    if not folder.exists():
        return []
    left = [path for inside in sorted(folder.iterdir()) for path in clean(inside)]
    if not left:
        folder.rmdir()
    return left


if __name__ == "__main__":
    for path in [path for name in sys.argv[1:] for path in clean(Path(name))]:
        print(f"left: {path}, which ccgen did not write")
