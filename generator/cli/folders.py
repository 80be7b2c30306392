"""Folders to write in, looked at before any work is done; files in them that ccgen did not write stay."""

from __future__ import annotations

import hashlib
import json
import os
import zipfile
from collections.abc import Iterable
from pathlib import Path

from ..emit.replace import OutputError, check_length
from .refusal import fail

RECORD = ".ccgen.json"
"""File of a folder of results that holds the SHA-256 of each file as ccgen wrote it."""


def check_folder(folder: Path, option: str) -> None:
    """Stop with exit code 2 unless ``folder`` exists or can be made, and can be written to."""
    try:
        check_length(folder)
    except OutputError as error:
        fail(f"{option}: {error}")
    nearest = folder.absolute()
    while not os.path.lexists(nearest):
        nearest = nearest.parent
    if not nearest.is_dir():
        fail(f"{option} {folder}: found a file {nearest}, expected a folder; name another")
    if not os.access(nearest, os.W_OK | os.X_OK):
        fail(f"{option} {folder}: found no permission to write in {nearest}, expected it; name another folder")


def check_results(folder: Path, names: Iterable[str], option: str) -> None:
    """Stop with exit code 2 unless files of these ``names`` can be written into ``folder``.

    A file that is there already is replaced only if it is as ccgen wrote it.
    """
    check_folder(folder, option)
    written = _written(folder)
    for name in names:
        if os.path.lexists(folder / name) and not _is_own(folder / name, written):
            fail(
                f"{option} {folder}: found the file {name}, which ccgen did not write or which has changed since, "
                "expected none; move it away or name another folder"
            )


def record_results(folder: Path, names: Iterable[str]) -> None:
    """Note that ccgen has just written the files of these ``names`` into ``folder``."""
    written = (_written(folder) or {}) | {name: _hash(folder / name) for name in names}
    (folder / RECORD).write_text(json.dumps(written, indent=1, sort_keys=True) + "\n")


def forget_results(folder: Path) -> None:
    """Remove the results in ``folder`` that are as ccgen wrote them, and the record of them."""
    written = _written(folder)
    if written is None:
        return
    for name in written:
        if os.path.lexists(folder / name) and _is_own(folder / name, written):
            (folder / name).unlink()
    (folder / RECORD).unlink(missing_ok=True)


def _is_own(file: Path, written: dict[str, str] | None) -> bool:
    """Whether ccgen wrote a file, by the hashes of what it ``written`` there."""
    if file.is_symlink() or not file.is_file():
        return False
    return written is None or _hash(file) == written.get(file.name)


def _written(folder: Path) -> dict[str, str] | None:
    """Hashes of what ccgen wrote into a folder; ``None`` of one with results from before there were records."""
    try:
        found = json.loads((folder / RECORD).read_text())
        return dict(found) if isinstance(found, dict) else {}
    except FileNotFoundError:
        return None if _is_run(folder / "result.npz") else {}
    except (OSError, ValueError):
        return {}


def _is_run(file: Path) -> bool:
    """Whether a file is a run as ccgen saves it."""
    try:
        with zipfile.ZipFile(file) as archive, archive.open("format.npy") as text:
            return "ccgen run".encode("utf-32-le") in text.read(1000)
    except (OSError, KeyError, zipfile.BadZipFile):
        return False


def _hash(file: Path) -> str:
    return hashlib.sha256(file.read_bytes()).hexdigest()
