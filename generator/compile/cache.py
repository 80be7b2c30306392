"""The cache of generated packages: nothing is derived or compiled twice, and two builds at once do no harm."""

from __future__ import annotations

import hashlib
import importlib.util
import os
import re
import shutil
import stat
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from ..package.parts import HEADERS, ONE_LANE_HEADERS, is_current, parts_of
from ..package.replace import OutputError, check_place, put, staging


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


def contract_version() -> int:
    """Version of the contract between generated models and the runtime that is installed."""
    found = re.search(r"#define CCGEN_CONTRACT_VERSION (\d+)", (runtime_folder() / "model.h").read_text())
    if found is None:
        raise OutputError(f"{runtime_folder() / 'model.h'}: found no contract version; install ccgen again")
    return int(found[1])


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


def fetch_or_build(key: str, target: Path, build: Callable[[Path], None]) -> bool:
    """Put the package of ``key`` at ``target``; ``build`` makes it in an empty folder if the cache lacks it.

    Returns whether it was built. The target changes in one step, from what it was to the whole new package. A damaged
    package in the cache is built again. Raises :class:`OutputError` when the target's or the cache's folder cannot be
    written, when there is something at the target that ccgen did not write, and when others may write to the cache.
    """
    from filelock import FileLock

    check_place(target)
    with writing(cache_folder(), private=True) as store, writing(store / "models") as models:
        stored = models / key[:32]
        with FileLock(store / f"{key[:32]}.lock"):
            built = not is_current(stored, key)
            if built:
                with staging(models, own=True) as fresh:
                    build(fresh)
                    put(fresh, stored, own=True)
            with writing(target.parent), staging(target.parent) as fresh:
                for name in parts_of(stored):
                    shutil.copyfile(stored / name, fresh / name)
                put(fresh, target)
    return built


@contextmanager
def writing(folder: Path, private: bool = False) -> Iterator[Path]:
    """A folder to write to, made where it is missing; ``private`` ones are the user's alone from the beginning."""
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        folder.mkdir(mode=0o700 if private else 0o777, exist_ok=True)
        if not os.access(folder, os.W_OK):
            raise PermissionError(13, "Permission denied")
        if private and os.name == "posix" and folder.stat().st_mode & stat.S_IWOTH:
            raise OutputError(
                f"{folder}: found a cache that everybody can write to, expected one that others cannot, since its code "
                f"is run; run: chmod o-w {folder}, or let CCGEN_CACHE_DIR name another"
            )
        yield folder
    except OSError as error:
        raise OutputError(f"{folder}: cannot be written ({error.strerror or error}); choose another folder") from error
