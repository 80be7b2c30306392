"""Files as people name them, written whole or not at all."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any


def read_path(given: object, what: str) -> Path:
    """The argument ``path``, which names ``what``. Raises ``TypeError`` where it is no path."""
    if not isinstance(given, str | os.PathLike):
        raise TypeError(f"path: found {given!r}, expected the name of {what}")
    return Path(given)


def write_whole(target: Path, write: Callable[[Any], object]) -> None:
    """Let `write` fill a file beside the target and put it in place only once it is complete.

    Raises ``OSError`` with the target's name where the system takes no more, as of a full disk.
    """
    if not target.parent.is_dir():
        raise FileNotFoundError(f"{target}: there is no folder {target.parent}; make it first")
    part = target.with_name(f".{target.name}.{os.getpid()}.part")
    try:
        with part.open("wb") as file:
            write(file)
        part.replace(target)
    except OSError as error:
        if error.errno is None or error.filename not in (None, str(part)):
            raise
        raise type(error)(error.errno, error.strerror, str(target)) from error
    finally:
        part.unlink(missing_ok=True)
