"""Folders that take their place whole, in one step, and only where nothing is in the way that ccgen did not write."""

from __future__ import annotations

import ctypes
import errno
import os
import shutil
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from secrets import token_hex

from .parts import discard, edited, is_package, strangers

STAGING = ".ccgen-"
"""Beginning of the names of folders that are still being filled, or on their way out."""

ABANDONED = 86400.0
"""Seconds after which a staging folder is taken as left behind, on systems where folders cannot be locked."""

ATTEMPTS = 100
"""Times that a place is tried anew while others put something there; each fails because another got there first."""

AT_FDCWD, SWAP = -100, 2
"""Of Linux's renameat2: paths from the working folder; and its RENAME_EXCHANGE, which macOS calls RENAME_SWAP."""


class OutputError(Exception):
    """A folder that cannot be written, or must not be; the message names it."""


def check_place(target: Path) -> None:
    """Raise :class:`OutputError` unless a package may be put at ``target``.

    It may where nothing is yet, in place of an empty folder, and in place of a package that ccgen wrote, in which
    nobody has changed a text and nothing else lies.
    """
    check_length(target)
    advice = "move it away, choose another folder for models, or give the scene another name"
    expected = "expected a generated package or nothing"
    if target.is_symlink():
        raise OutputError(f"{target}: found a link, {expected}; {advice}")
    if not target.exists():
        return
    if not target.is_dir():
        raise OutputError(f"{target}: found a file, {expected}; {advice}")
    others = strangers(target)
    if others and is_package(target):
        raise OutputError(f"{target}: found {_listed(others)} in the package, which ccgen did not write; {advice}")
    if others or (any(target.iterdir()) and not is_package(target)):
        names = _listed(others or sorted(path.name for path in target.iterdir()))
        raise OutputError(f"{target}: found a folder that ccgen did not write, with {names}, {expected}; {advice}")
    if changed := edited(target):
        raise OutputError(
            f"{target}: found {_listed(changed)} in the package changed since ccgen wrote it; move what is yours away, "
            "or remove it, and generate again"
        )


def check_length(target: Path) -> None:
    """Raise :class:`OutputError` if the name is longer than the file system takes."""
    nearest = target.absolute().parent
    while not nearest.is_dir() and nearest != nearest.parent:
        nearest = nearest.parent
    limit = os.pathconf(nearest, "PC_NAME_MAX") if hasattr(os, "pathconf") else 255
    length = len(os.fsencode(target.name))
    if length > limit:
        raise OutputError(
            f"{target.parent}: found a name of {length} characters for a folder in it, expected at most {limit}; "
            "give the scene a shorter name"
        )


@contextmanager
def staging(parent: Path, own: bool = False) -> Iterator[Path]:
    """An empty folder in ``parent``, to be filled and put in its place; what is still there after an error goes.

    Folders that killed processes have left there go first. With ``own`` the parent is ccgen's, and all that is in
    such folders goes; otherwise what ccgen did not write stays.
    """
    for left in parent.glob(f"{STAGING}*"):
        _sweep(left, own)
    fresh, lock = _locked(parent)
    try:
        yield fresh
    except BaseException:
        _remove(fresh, own)
        raise
    finally:
        if lock is not None:
            os.close(lock)


def put(fresh: Path, target: Path, own: bool = False) -> None:
    """Move the folder ``fresh`` to ``target``; a package that is there vanishes, in one step where the system can.

    What else is there stays and raises :class:`OutputError`. With ``own`` the place is ccgen's, so that a package is
    replaced however damaged it is.
    """
    for _ in range(ATTEMPTS):
        try:
            fresh.rename(target)  # where nothing is, or an empty folder
            return
        except OSError as error:
            if error.errno not in (errno.ENOTEMPTY, errno.EEXIST):
                check_place(target)
                raise
        try:
            if not own or strangers(target):
                check_place(target)
            _exchange(fresh, target)
        except FileNotFoundError:
            continue  # another process was faster
        try:
            late = strangers(fresh) or (not own and edited(fresh))  # somebody has just written into it
        except FileNotFoundError:
            return  # swept away by another process
        if late:
            _exchange(fresh, target)
            check_place(target)
        discard(fresh)
        return
    raise OutputError(f"{target}: others replace it all the time; choose another folder")


def _exchange(one: Path, other: Path) -> None:
    """Let two folders change places, in one step if the system can."""
    if _swapped(os.fsencode(one), os.fsencode(other)):
        return
    aside = one.with_name(f"{one.name}.old")
    other.rename(aside)
    try:
        one.rename(other)
    except OSError:
        aside.rename(other)
        raise
    with suppress(FileNotFoundError):  # swept away already
        aside.rename(one)


def _swapped(one: bytes, other: bytes) -> bool:
    if sys.platform == "win32":
        return False
    libc = ctypes.CDLL(None, use_errno=True)
    if sys.platform == "darwin" and hasattr(libc, "renamex_np"):
        failed = libc.renamex_np(one, other, ctypes.c_uint(SWAP))
    elif sys.platform == "linux" and hasattr(libc, "renameat2"):
        failed = libc.renameat2(AT_FDCWD, one, AT_FDCWD, other, ctypes.c_uint(SWAP))
    else:
        return False
    code = ctypes.get_errno()
    if failed and code in (errno.ENOSYS, errno.EINVAL, errno.ENOTSUP):
        return False  # an old kernel, or a file system that cannot
    if failed:
        raise OSError(code, os.strerror(code), os.fsdecode(other))
    return True


def _locked(parent: Path) -> tuple[Path, int | None]:
    """A new folder, and a lock on it that lasts as long as this process holds it open."""
    while True:
        fresh = parent / f"{STAGING}{token_hex(4)}"
        try:
            fresh.mkdir()
            lock = _lock(fresh)
        except (FileExistsError, BlockingIOError):  # taken, or about to be swept away
            continue
        if fresh.exists():
            return fresh, lock
        if lock is not None:
            os.close(lock)


def _lock(folder: Path) -> int | None:
    """A lock on a folder; ``None`` where folders cannot be locked. Raises ``BlockingIOError`` if another has it."""
    if sys.platform == "win32":
        return None
    import fcntl

    try:
        opened = os.open(folder, os.O_RDONLY)
    except FileNotFoundError:
        return None
    try:
        fcntl.flock(opened, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        os.close(opened)
        raise
    except OSError:
        os.close(opened)
        return None
    return opened


def _sweep(folder: Path, own: bool) -> None:
    """Remove a staging folder if the process that made it has ended."""
    try:
        lock = _lock(folder)
        if lock is not None or time.time() - folder.stat().st_mtime > ABANDONED:
            _remove(folder, own)
    except OSError:
        return  # locked by a build that goes on, or gone
    if lock is not None:
        os.close(lock)


def _remove(folder: Path, own: bool) -> None:
    if own:
        shutil.rmtree(folder, ignore_errors=True)
    else:
        discard(folder)


def _listed(names: list[str]) -> str:
    more = len(names) - 3
    return ", ".join(names[:3]) + (f" and {more} more" if more > 0 else "")
