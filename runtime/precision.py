"""The compiled cores, one for each type of numbers that a model may be in."""

from __future__ import annotations

import importlib
import subprocess
import sys
import threading
from importlib.machinery import ExtensionFileLoader
from importlib.util import module_from_spec, spec_from_file_location
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._core import all_finite, never_decreases

CORES = {"double": "_core", "float": "_float", "wide": "_wide"}
_one_at_a_time = threading.RLock()


def core_of(precision: str) -> ModuleType:
    """The core over numbers of that precision; its ``REAL`` is the type of its arrays.

    Where it has not been compiled yet it is now, into the user's cache, which takes about half a minute and is said on
    the error channel where that is a terminal. Raises ``ImportError`` where that fails, with the reason."""
    name = f"{__package__}.{CORES[precision]}"
    with _one_at_a_time:
        try:
            return importlib.import_module(name)
        except ModuleNotFoundError as missing:
            if missing.name != name:
                raise
        file = _compiled(precision)
        spec = spec_from_file_location(name, file, loader=ExtensionFileLoader(name, file))
        assert spec and spec.loader
        core = sys.modules[name] = module_from_spec(spec)
        spec.loader.exec_module(core)
    return core


def _compiled(precision: str) -> str:
    """The file of a core that is not installed, as the generator's machinery compiles it, in a process of its own."""
    command = [sys.executable, "-P", "-m", "ccgen.generator.compile.core", precision]
    said = []
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stdout and process.stderr
        for line in process.stderr:
            said.append(line)
            if sys.stderr is not None and sys.stderr.isatty():
                print(f"ccgen: {line}", end="", file=sys.stderr, flush=True)
        found = process.stdout.read().strip()
    if process.returncode or not found:
        raise ImportError(
            f"found no core for {precision} numbers in this installation, and it could not be compiled: "
            f"{''.join(said[-20:]).strip() or 'no reason was given'}"
        )
    return found


def need_doubles(precision: str, model: str, what: str) -> None:
    """Raise ``ValueError`` unless a model's numbers are doubles: ``what`` solves linear systems with LAPACK, which has
    no others."""
    if precision != "double":
        raise ValueError(
            f'{model}: found a model in precision="{precision}", expected "double" for {what}; generate it so'
        )


def finite(x: NDArray[Any]) -> bool:
    """Whether all numbers of an array are finite; of doubles, without an array between."""
    return bool(all_finite(x.ravel()) if x.dtype == np.float64 else np.isfinite(x).all())


def ascending(x: NDArray[Any]) -> bool:
    """Whether no number of a row (n,) is less than the one before it; of doubles, without an array between."""
    return bool(never_decreases(x) if x.dtype == np.float64 else not (x[1:] < x[:-1]).any())


def wider() -> bool:
    """Whether "wide" numbers have more digits than doubles on this machine; NumPy's are the compiler's long doubles."""
    return bool(np.finfo(np.longdouble).eps < np.finfo(float).eps)
