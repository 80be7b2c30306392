"""The command line, run as a person or a script runs it."""

from __future__ import annotations

import io
import os
import subprocess
import sys
import sysconfig
import tempfile
import time
import traceback
import warnings
from collections.abc import Callable, Mapping
from importlib import import_module
from pathlib import Path

CCGEN = str(Path(sysconfig.get_path("scripts")) / "ccgen")
PENDULUM = """\
name = "pendulum"
[chain]
links = 1
hinged = true
[gravity]
g = 9.81
[run]
until = 0.5
"""
LONGEST = 120.0
"""Seconds that a command may take."""
NEEDED = ("generator.cli.app", "generator.cli.run", "generator.cli.show", "generator.cli.cost", "generator.cli.statics")
"""What commands import when they run; with it sympy, SciPy and Matplotlib."""
Done = subprocess.CompletedProcess[str]


def ccgen(*options: str, at: Path, environment: Mapping[str, str] | None = None) -> Done:
    """``ccgen`` in the folder ``at``, its output in files: in a process of its own that begins as a copy of this one,
    so that it need not import what is imported here; anew where it has an ``environment``."""
    if hasattr(os, "fork") and environment is None:
        return _copied([CCGEN, *options], at)
    return subprocess.run(
        [CCGEN, *options],
        cwd=at,
        capture_output=True,
        text=True,
        env={**os.environ, **(environment or {})},
        timeout=LONGEST,
        check=False,
    )


def written(folder: Path) -> list[str]:
    """All files below ``folder``, lock files aside."""
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file())


def _copied(arguments: list[str], at: Path) -> Done:
    for name in NEEDED:
        import_module(f"ccgen.{name}")
    from ccgen.generator.cli import main

    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DeprecationWarning)  # of a copy of a process that has threads
            pid = os.fork()
        if pid == 0:
            os.dup2(out.fileno(), 1)
            os.dup2(err.fileno(), 2)
            os._exit(_run(main, arguments, at))
        code = _ended(pid, arguments)
        texts = []
        for file in (out, err):
            file.seek(0)
            texts.append(file.read().decode())
    return subprocess.CompletedProcess(arguments, code, *texts)


def _run(main: Callable[[], None], arguments: list[str], at: Path) -> int:
    """The exit code of the command, as Python itself would have it."""
    sys.stdout = io.TextIOWrapper(io.FileIO(1, "w", closefd=False), "utf-8")
    sys.stderr = io.TextIOWrapper(io.FileIO(2, "w", closefd=False), "utf-8", "backslashreplace", line_buffering=True)
    code = 0
    try:
        warnings.resetwarnings()
        for kind in (DeprecationWarning, PendingDeprecationWarning, ImportWarning, ResourceWarning):
            warnings.simplefilter("ignore", kind)
        os.chdir(at)
        sys.argv = arguments
        main()
    except SystemExit as stop:
        code = stop.code if isinstance(stop.code, int) else int(stop.code is not None)
    except BaseException:
        traceback.print_exc()
        code = 1
    sys.stdout.flush()
    sys.stderr.flush()
    return code


def _ended(pid: int, arguments: list[str]) -> int:
    """The exit code of a process, once it has ended."""
    end = time.monotonic() + LONGEST
    while True:
        found, status = os.waitpid(pid, os.WNOHANG)
        if found:
            return os.waitstatus_to_exitcode(status)
        if time.monotonic() > end:
            os.kill(pid, 9)
            os.waitpid(pid, 0)
            raise subprocess.TimeoutExpired(arguments, LONGEST)
        time.sleep(0.005)
