"""Ctrl-C while a run is made: it is noted, and ends the run where all that is done is in order."""

from __future__ import annotations

import signal
import sysconfig
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from types import FrameType

import numpy as np

from ..run import Run

OWN = tuple(str(folder) for folder in (Path(__file__).parents[1], Path(np.__file__).parent))
"""Folders of the code that a run is made by."""
LIBRARY, OTHERS = sysconfig.get_path("stdlib"), sysconfig.get_path("purelib")


@dataclass
class _Note:
    """Whether Ctrl-C has come. Of the runs that are made one within the other, each has one."""

    came: bool = False


_notes: list[_Note] = []


@contextmanager
def noting(keeps: bool) -> Iterator[_Note]:
    """Within, Ctrl-C is raised by :func:`check` alone, if what is done is kept: elsewhere it would break off what puts
    that together. A function of the caller's is broken off at once, and so is anything where it comes again.

    Where it came after the last check, the note that is given says so at the end: for :func:`marked`. Where there is
    nothing to mark, since an error ends what is done, ``KeyboardInterrupt`` is raised instead of that.
    Only the main thread is told of signals; a handler that is no function of Python is left as it is.
    """
    before = signal.getsignal(signal.SIGINT)
    if not keeps or not callable(before) or threading.current_thread() is not threading.main_thread():
        yield _Note()
        return
    handler: Callable[[int, FrameType | None], object] = before
    note = _Note()

    def came(number: int, frame: FrameType | None) -> None:
        if note.came or _of_caller(frame):
            handler(number, frame)
        note.came = True

    _notes.append(note)
    signal.signal(signal.SIGINT, came)
    try:
        yield note
    except Exception:
        if note.came:
            raise KeyboardInterrupt from None
        raise
    finally:
        signal.signal(signal.SIGINT, before)
        _notes.pop()


def marked(made: Run | list[Run], note: _Note) -> Run | list[Run]:
    """A run, or the last of a list, that says that it was interrupted, where Ctrl-C was noted and not raised: the run
    was at its end already, but whoever asked for it asks for no other."""
    if not note.came or made == []:
        return made
    if isinstance(made, list):
        return [*made[:-1], _interrupted(made[-1])]
    return _interrupted(made)


def _interrupted(run: Run) -> Run:
    if run.message.endswith("interrupted"):
        return run
    if not run.success:
        return replace(run, message=f"{run.message}; interrupted")
    return replace(run, success=False, message=f"stopped at t = {run.t[-1]:.12g} s: interrupted")


def _of_caller(frame: FrameType | None) -> bool:
    """Whether a function that the caller has given is at work."""
    while frame is not None and frame.f_code.co_name != "simulate":
        file = frame.f_code.co_filename
        if not file.startswith((*OWN, "<")) and (not file.startswith(LIBRARY) or file.startswith(OTHERS)):
            return True
        frame = frame.f_back
    return False


def check() -> None:
    """Raise ``KeyboardInterrupt`` if Ctrl-C has been noted."""
    if _notes and _notes[-1].came and threading.current_thread() is threading.main_thread():
        _notes[-1].came = False
        raise KeyboardInterrupt


def checking(progress: Callable[[float], object] | None) -> Callable[[float], object] | None:
    """A ``progress`` that raises what has been noted."""
    if not _notes or threading.current_thread() is not threading.main_thread():
        return progress

    def told(t: float) -> None:
        check()
        if progress is not None:
            progress(t)

    return told
