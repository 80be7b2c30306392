"""Folders to write in, looked at before any work is done; files in them that ccgen did not write stay."""

from __future__ import annotations

import hashlib
import json
import os
import tempfile
import zipfile
from collections.abc import Iterable
from pathlib import Path

from ..package.parts import is_package
from ..package.replace import STAGING, OutputError, check_length
from ..scene.near_files import as_there
from .refusal import fail

MODELS = Path("build")
"""Folder of generated models."""

DERIVED = MODELS / "with-derivatives"
"""Folder of those with derivatives that commands make for themselves, so that runs of the others still find theirs."""

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
    try:
        Path(tempfile.mkdtemp(prefix=STAGING, dir=nearest)).rmdir()
    except OSError as error:  # as in a file system that takes no files, or is full
        fail(f"{option} {folder}: found no way to write in {nearest} ({error.strerror}); name another folder")


def check_there(path: Path, what: str, *ends: str) -> None:
    """Stop with exit code 2 unless ``path``, which is to be ``what``, is there, and no folder if it is a file with one
    of these ``ends``."""
    if not path.exists():
        fail(f"{path}: found nothing there, expected {what}{as_there(path, *ends)}; correct the name")
    if ends and path.is_dir():
        fail(f"{path}: found a folder, expected {what}; name a file")


def check_picture(file: Path, option: str) -> None:
    """Stop with exit code 2 unless a picture can be written to ``file``, where nothing is or a picture of ccgen."""
    if file.suffix != ".png":
        fail(f"{option} {file}: found {file.name!r}, expected a name that ends in .png; correct it")
    check_folder(file.parent, option)
    if os.path.lexists(file) and not is_picture(file):
        fail(f"{option} {file}: found a file that ccgen did not write, expected none; move it away or name another")


def check_results(folder: Path, names: Iterable[str], option: str) -> None:
    """Stop with exit code 2 unless files of these ``names`` can be written into ``folder``.

    A file that is there already is replaced only if it is as ccgen wrote it. Places of models are for models alone.
    """
    check_folder(folder, option)
    here = folder.resolve()
    if MODELS.resolve() in (here, *here.parents) or any(is_package(place) for place in (here, *here.parents)):
        fail(f"{option} {folder}: found a place of a generated model, expected a folder for results; name another")
    written = _written(folder)
    earlier = not os.path.lexists(folder / RECORD) and bool(written)
    for name in names:
        if os.path.lexists(folder / name) and not _is_own(folder / name, written):
            if earlier:
                fail(
                    f"{option} {folder}: found the file {name} beside a run of an earlier version of ccgen, which "
                    "kept no record of what it wrote; move the folder away, remove it, or name another"
                )
            fail(
                f"{option} {folder}: found the file {name}, which ccgen did not write or which has changed since, "
                "expected none; move it away or name another folder"
            )


def record_results(folder: Path, names: Iterable[str]) -> None:
    """Note that ccgen has just written the files of these ``names`` into ``folder``."""
    written = _written(folder) | {name: _hash(folder / name) for name in names}
    _write_record(folder, written)


def forget_results(folder: Path) -> None:
    """Remove the results in ``folder`` that are as ccgen wrote them, and the record of them."""
    written = _written(folder)
    for name in written:
        if os.path.lexists(folder / name) and _is_own(folder / name, written):
            (folder / name).unlink()
    (folder / RECORD).unlink(missing_ok=True)


def forget_stale(folder: Path, names: Iterable[str]) -> list[str]:
    """Remove those of the files ``names`` in ``folder`` that are as ccgen wrote them before: they belong to older
    results. Which these were, by their names."""
    written = _written(folder)
    stale = sorted(name for name in names if name in written and _is_own(folder / name, written))
    for name in stale:
        (folder / name).unlink()
    if stale:
        _write_record(folder, {name: hash_ for name, hash_ in written.items() if name not in stale})
    return stale


def _write_record(folder: Path, written: dict[str, str]) -> None:
    beside = folder / f"{RECORD}.new"
    beside.write_text(json.dumps(written, indent=1, sort_keys=True) + "\n")
    beside.replace(folder / RECORD)  # a record that is cut short would make all results a stranger's


def _is_own(file: Path, written: dict[str, str]) -> bool:
    """Whether ccgen wrote a file, by the hashes of what it ``written`` there."""
    if file.is_symlink() or not file.is_file():
        return False
    return _hash(file) == written.get(file.name)


def _written(folder: Path) -> dict[str, str]:
    """Hashes of what ccgen wrote into a folder. Without a record, as of an earlier version, that is a run alone."""
    try:
        found = json.loads((folder / RECORD).read_text())
        return dict(found) if isinstance(found, dict) else {}
    except FileNotFoundError:
        run = folder / "result.npz"
        return {run.name: _hash(run)} if _is_run(run) else {}
    except (OSError, ValueError, RecursionError):
        return {}


def is_picture(file: Path) -> bool:
    """Whether a file is a PNG that says that ccgen made it."""
    try:
        with file.open("rb") as opened:
            return not file.is_symlink() and b"tEXtSoftware\0ccgen" in opened.read(1000)
    except OSError:
        return False


def _is_run(file: Path) -> bool:
    """Whether a file is a run as ccgen saves it."""
    try:
        with zipfile.ZipFile(file) as archive, archive.open("format.npy") as text:
            return "ccgen run".encode("utf-32-le") in text.read(1000)
    except (OSError, KeyError, zipfile.BadZipFile):
        return False


def _hash(file: Path) -> str:
    return hashlib.sha256(file.read_bytes()).hexdigest()
