"""What a generated package consists of, and the record of its parts, by which damage and files of others are seen."""

from __future__ import annotations

import hashlib
import json
import os
import re
from collections.abc import Iterable, Mapping
from pathlib import Path

HEADERS = ("model.h", "sincos.h", "lanes.h", "abreast.h")
"""Headers of the runtime that a generated model is compiled with; a copy lies in its package."""

ONE_LANE_HEADERS = ("model.h", "one_lane.h")
"""Those of a model in numbers other than doubles."""

KEY = ".key"
"""File that holds the key of what the package was made from."""

DATA = "model.json"
"""File that holds what the runtime knows of the model."""

RECORD = "build.json"
"""File that holds how the package was built, where it runs, and sizes and hashes of its other files but the key."""

DERIVATIVES = "derivatives.c"
"""File of the derivatives, in packages that were asked for with them."""

BANNERED = ("__init__.py", "_binding.pyx", "model.c", "lanes.c", DERIVATIVES)
"""Files that say at their beginning that ccgen wrote them."""

NAMES = {*HEADERS, *ONE_LANE_HEADERS, *BANNERED, KEY, RECORD, "_binding.c", "equations.txt", DATA}
EXTENSION = re.compile(r"_model_[0-9a-f]{16}\.([\w-]+\.)*(so|pyd)")
BYTECODE = "__pycache__"
COMPILED = re.compile(r".*\.pyc(\.\d+)?")
"""Names of files of bytecode, those among them that Python is just writing and has not renamed yet."""
SAID = re.compile(rb"(ritten|generated) by ccgen ")


def strangers(folder: Path) -> list[str]:
    """Names of what lies in ``folder`` and has no name or kind that ccgen gives, in order."""
    with os.scandir(folder) as entries:
        return sorted(entry.name for entry in entries if not _known(entry))


def is_package(folder: Path) -> bool:
    """Whether ccgen wrote a package into ``folder``, however damaged it is now."""
    if not any((folder / name).is_file() for name in (KEY, RECORD)):
        return False
    return any(SAID.search(_beginning(folder / name)) for name in BANNERED)


def discard(folder: Path) -> None:
    """Remove the files of a package, and their folder if nothing else is in it. What ccgen did not write stays."""
    try:
        mine = edited(folder)
        with os.scandir(folder) as entries:
            known = [entry for entry in entries if _known(entry) and entry.name not in mine]
        for entry in known:
            path = Path(entry.path)
            if entry.name == BYTECODE:
                for file in path.iterdir():
                    if COMPILED.fullmatch(file.name):
                        file.unlink(missing_ok=True)
                path.rmdir()
            else:
                path.unlink(missing_ok=True)
        folder.rmdir()
    except OSError:
        return  # what cannot be removed stays too


def write_record(folder: Path, key: str, facts: Mapping[str, object]) -> None:
    """The record of a package whose other files are all there, with ``facts`` on how it was built, and its ``key``."""
    parts = {name: _part((folder / name).read_bytes()) for name in sorted(path.name for path in folder.iterdir())}
    record = {**facts, "parts": parts}
    (folder / RECORD).write_text(json.dumps({**record, "seal": seal(record)}, indent=1) + "\n")
    (folder / KEY).write_text(key)


def seal(record: Mapping[str, object]) -> str:
    """SHA-256 of a record without its seal, as canonical JSON."""
    plain = {name: value for name, value in record.items() if name != "seal"}
    return hashlib.sha256(json.dumps(plain, sort_keys=True).encode()).hexdigest()


def is_current(folder: Path, key: str) -> bool:
    """Whether ``folder`` holds the package of ``key``, whole and undamaged."""
    parts = _parts(folder)
    try:
        return (
            parts is not None
            and (folder / KEY).read_text() == key
            and all(_part((folder / name).read_bytes()) == part for name, part in parts.items())
        )
    except (OSError, ValueError):
        return False


def edited(folder: Path) -> list[str]:
    """Names of the texts in a package that somebody has changed since ccgen wrote them, in order.

    What is loaded is left out, and what is empty: there a change is damage. Nothing is known of a package whose record
    is damaged or missing.
    """
    while True:
        place, parts = _place(folder), _parts(folder) or {}
        found = sorted(name for name, part in parts.items() if _is_edited(folder / name, part))
        if not found or _place(folder) == place:  # else another package has taken its place meanwhile
            return found


def parts_of(folder: Path) -> Iterable[str]:
    """Names of the files of a package that is whole."""
    return (*(_parts(folder) or {}), RECORD, KEY)


def _place(folder: Path) -> tuple[int, int] | None:
    """What tells a folder from another that takes its place; ``None`` where there is none."""
    try:
        found = folder.stat()
        return found.st_ino, found.st_ctime_ns
    except FileNotFoundError:
        return None


def _is_edited(file: Path, part: object) -> bool:
    if file.name == DATA or EXTENSION.fullmatch(file.name) or file.is_symlink():
        return False
    try:
        content = file.read_bytes()
    except OSError:
        return False  # gone
    return bool(content) and _part(content) != part


def _parts(folder: Path) -> dict[str, object] | None:
    """Sizes and hashes of the files of a package by its record; ``None`` if that is missing or damaged."""
    try:
        record = json.loads((folder / RECORD).read_text())
        return dict(record["parts"]) if record["seal"] == seal(record) else None
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError):
        return None


def _part(content: bytes) -> dict[str, object]:
    return {"size": len(content), "sha256": hashlib.sha256(content).hexdigest()}


def _known(entry: os.DirEntry[str]) -> bool:
    if entry.name == BYTECODE and entry.is_dir(follow_symlinks=False):
        try:
            with os.scandir(entry.path) as inside:
                return all(COMPILED.fullmatch(file.name) and file.is_file(follow_symlinks=False) for file in inside)
        except FileNotFoundError:
            return True  # another package, without bytecode, has taken its place meanwhile
    named = entry.name in NAMES or EXTENSION.fullmatch(entry.name)
    return bool(named) and entry.is_file(follow_symlinks=False)


def _beginning(file: Path) -> bytes:
    try:
        with file.open("rb") as opened:
            return opened.read(1000)
    except OSError:
        return b""
