"""Functions of the core by themselves, compiled without the rest and called with arrays."""

from __future__ import annotations

import ctypes
import os
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from .core_objects import BASE, core_objects
from .folders import RUNTIME

CORE = RUNTIME / "core"


class Functions:
    """A library of some folders of the core, and of other ``sources``. ``call(name, ...)`` takes whole numbers, floats,
    arrays and ``None``; functions that want an arena take the one that is here."""

    def __init__(self, folder: Path, *layers: str, sources: Sequence[Path] = ()) -> None:
        objects = core_objects(RUNTIME, layers=layers)
        library = folder / "functions.so"
        flags = [*BASE, "-shared", *os.environ.get("CFLAGS", "").split()]
        flags += ["-Wl,-Bsymbolic"] if sys.platform == "linux" else []  # glibc has functions of the same names
        more = [str(source) for source in sources]
        subprocess.run(["cc", *flags, f"-I{CORE}", *more, *objects, "-lm", "-o", str(library)], check=True)
        self.library: Any = ctypes.CDLL(str(library))
        self.arena = np.zeros(16, dtype=np.uint64)
        """A ``struct arena``, which is zeros as long as it has nothing (``base/arena.h``)."""

    def __del__(self) -> None:
        if hasattr(self, "arena") and hasattr(self.library, "free_arena"):
            self.call("free_arena", self.arena)

    def call(self, name: str, *arguments: Any) -> int:
        """The whole number that the function ``name`` returns; arrays are those of the caller."""
        found: int = getattr(self.library, name)(*map(self._passed, arguments))
        return found

    @staticmethod
    def _passed(argument: Any) -> Any:
        if isinstance(argument, np.ndarray):
            assert argument.flags.c_contiguous
            return ctypes.c_void_p(argument.ctypes.data)
        return ctypes.c_double(argument) if isinstance(argument, float) else argument
