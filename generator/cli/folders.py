"""Folders to write in, looked at before any work is done."""

from __future__ import annotations

import os
from pathlib import Path

from .refusal import fail


def check_folder(folder: Path, option: str) -> None:
    """Stop with exit code 2 unless ``folder`` exists or can be made, and can be written to."""
    nearest = folder.absolute()
    while not os.path.lexists(nearest):
        nearest = nearest.parent
    if not nearest.is_dir():
        fail(f"{option} {folder}: found a file {nearest}, expected a folder; name another")
    if not os.access(nearest, os.W_OK | os.X_OK):
        fail(f"{option} {folder}: found no permission to write in {nearest}, expected it; name another folder")
