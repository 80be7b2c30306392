"""The cache of generated packages: nothing is derived or compiled twice, and two builds at once do no harm."""

from __future__ import annotations

import hashlib
import importlib.util
import os
import shutil
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib.machinery import EXTENSION_SUFFIXES
from pathlib import Path

HEADERS = ("model.h", "sincos.h", "lanes.h")
"""Headers of the runtime that a generated model is compiled with; a copy lies in its package."""

ONE_LANE_HEADERS = ("model.h", "one_lane.h")
"""Those of a model in numbers other than doubles."""

PARTS = ("__init__.py", "model.json", "model.c", "lanes.c", "equations.txt", f"*{EXTENSION_SUFFIXES[0]}")
"""What a whole package has; one from which a file was deleted is made again."""

KEY = ".key"
"""File of a generated package that holds the key of what it was made from."""


class OutputError(Exception):
    """A folder that cannot be written; the message names it."""


def cache_folder() -> Path:
    """``$CCGEN_CACHE_DIR``, else the user's cache folder."""
    asked = os.environ.get("CCGEN_CACHE_DIR")
    if asked:
        return Path(asked)
    from platformdirs import user_cache_path

    return user_cache_path("ccgen")


def runtime_folder() -> Path:
    """Where the runtime is installed, found without importing it."""
    spec = importlib.util.find_spec("ccgen.runtime")
    if spec is None or not spec.submodule_search_locations:
        raise OutputError("ccgen.runtime is not installed; run: python -m pip install .")
    return Path(spec.submodule_search_locations[0])


def key_of(*texts: str) -> str:
    """Key of everything that decides a generated package: the given texts and the generator's own sources."""
    digest = hashlib.sha256()
    for text in (*texts, sys.version, sys.implementation.cache_tag or ""):
        digest.update(text.encode() + b"\0")
    here = Path(__file__).resolve().parent.parent
    templates = importlib.util.find_spec("ccgen.templates")
    folders = [here, *(Path(p) for p in (templates.submodule_search_locations or ()))] if templates else [here]
    for folder in folders:
        for file in sorted(folder.rglob("*")):
            if file.suffix in (".py", ".j2") and "cli" not in file.parts:
                digest.update(file.name.encode() + b"\0" + file.read_bytes())
    for header in sorted({*HEADERS, *ONE_LANE_HEADERS}):
        digest.update((runtime_folder() / header).read_bytes())
    return digest.hexdigest()


def is_current(folder: Path, key: str) -> bool:
    """Whether ``folder`` holds the package of ``key``, whole."""
    try:
        return (folder / KEY).read_text() == key and all(any(folder.glob(part)) for part in PARTS)
    except OSError:
        return False


def fetch_or_build(key: str, target: Path, build: Callable[[Path], None]) -> bool:
    """Put the package of ``key`` at ``target``; ``build`` makes it in an empty folder if the cache lacks it.

    Returns whether it was built. The target changes in one step, from what it was to the whole new package. Raises
    :class:`OutputError` when the target's or the cache's folder cannot be written.
    """
    from filelock import FileLock

    with _writing(cache_folder()) as store:
        stored = store / "models" / key[:32]
        with FileLock(store / f"{key[:32]}.lock"):
            built = not is_current(stored, key)
            if built:
                with _staging(stored) as fresh:
                    build(fresh)
                    (fresh / KEY).write_text(key)
    with _writing(target.parent), FileLock(target.parent / f".{target.name}.lock"), _staging(target) as fresh:
        shutil.copytree(stored, fresh, dirs_exist_ok=True)
    (target.parent / f".{target.name}.lock").unlink(missing_ok=True)
    return built


@contextmanager
def _writing(folder: Path) -> Iterator[Path]:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        if not os.access(folder, os.W_OK):
            raise PermissionError(13, "Permission denied")
        yield folder
    except OSError as error:
        raise OutputError(
            f"{error.filename or folder}: cannot be written ({error.strerror}); choose another folder"
        ) from error


@contextmanager
def _staging(target: Path) -> Iterator[Path]:
    """An empty folder beside ``target`` that takes its place when all went well, and vanishes otherwise."""
    target.parent.mkdir(parents=True, exist_ok=True)
    fresh = Path(tempfile.mkdtemp(prefix=f".{target.name}.", dir=target.parent))
    try:
        yield fresh
        fresh.chmod(0o755)
        old = Path(tempfile.mkdtemp(prefix=f".{target.name}.old.", dir=target.parent))
        if target.exists():
            target.rename(old / "package")
        fresh.rename(target)
        shutil.rmtree(old, ignore_errors=True)
    finally:
        shutil.rmtree(fresh, ignore_errors=True)
