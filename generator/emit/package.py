"""What a generated package consists of, and the record of its parts, by which damage and files of others are seen."""

from __future__ import annotations

import hashlib
import json
import os
import re
from collections.abc import Iterable, Mapping
from pathlib import Path

HEADERS = ("model.h", "sincos.h", "lanes.h")
"""Headers of the runtime that a generated model is compiled with; a copy lies in its package."""

ONE_LANE_HEADERS = ("model.h", "one_lane.h")
"""Those of a model in numbers other than doubles."""

KEY = ".key"
"""File that holds the key of what the package was made from."""

RECORD = "build.json"
"""File that holds how the package was built, where it runs, and sizes and hashes of its other files but the key."""

BANNERED = ("__init__.py", "_binding.pyx", "model.c", "lanes.c")
"""Files that say at their beginning that ccgen wrote them."""

NAMES = {*HEADERS, *ONE_LANE_HEADERS, *BANNERED, KEY, RECORD, "_binding.c", "equations.txt", "model.json"}
EXTENSION = re.compile(r"_model_[0-9a-f]{16}\.([\w-]+\.)*(so|pyd)")
BYTECODE = "__pycache__"
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
        with os.scandir(folder) as entries:
            known = [entry for entry in entries if _known(entry)]
        for entry in known:
            path = Path(entry.path)
            if entry.name == BYTECODE:
                for file in path.glob("*.pyc"):
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
    try:
        if (folder / KEY).read_text() != key:
            return False
        record = json.loads((folder / RECORD).read_text())
        parts = record["parts"]
        return record["seal"] == seal(record) and all(
            _part((folder / name).read_bytes()) == part for name, part in parts.items()
        )
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return False


def parts_of(folder: Path) -> Iterable[str]:
    """Names of the files of a package that is whole."""
    return (*json.loads((folder / RECORD).read_text())["parts"], RECORD, KEY)


def _part(content: bytes) -> dict[str, object]:
    return {"size": len(content), "sha256": hashlib.sha256(content).hexdigest()}


def _known(entry: os.DirEntry[str]) -> bool:
    if entry.name == BYTECODE and entry.is_dir(follow_symlinks=False):
        with os.scandir(entry.path) as inside:
            return all(file.name.endswith(".pyc") and file.is_file(follow_symlinks=False) for file in inside)
    named = entry.name in NAMES or EXTENSION.fullmatch(entry.name)
    return bool(named) and entry.is_file(follow_symlinks=False)


def _beginning(file: Path) -> bytes:
    try:
        with file.open("rb") as opened:
            return opened.read(1000)
    except OSError:
        return b""
