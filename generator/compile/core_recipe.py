"""How the core is compiled: its files, and the flags of each. ``setup.py``, which has no ccgen yet, reads this too.

It imports nothing but what Python brings.
"""

from __future__ import annotations

import hashlib
from pathlib import Path

MODULES = {"double": "_core", "float": "_float", "wide": "_wide"}
"""Name of the extension module for each type of numbers; each is one file of Cython and the core's C once more."""

PRECISIONS = {"double": "0", "float": "1", "wide": "2"}
"""``CCGEN_PRECISION`` of each (runtime/core/base/real.h)."""

LANGUAGE = ("-std=c11", "-fvisibility=hidden", "-fno-math-errno", "-g0")  # hidden: glibc has an advance() too
FACE = "-O1"
"""Of the C that Cython writes. It hands over arrays and is half of what there is to compile: by -O3 it takes twice the
time, and runs are not a per cent faster."""
OFTEN, ELSE = "-O3", "-O2"
"""Of the folders in which runs spend their time, and of all others."""
HOT = ("methods",)
"""Those folders; with the rest by -O3 as well runs are no faster."""


def c_files(runtime: Path) -> list[Path]:
    """The core's C below the folder of the runtime, in order."""
    return sorted((runtime / "core").rglob("*.c"))


def read_files(runtime: Path) -> list[Path]:
    """All other files that the compiler or Cython reads, in order."""
    here = (*runtime.glob("*.h"), *runtime.glob("*.pyx"), *(runtime / "face").glob("*.pxi"))
    return sorted((*here, *(runtime / "core").rglob("*.h")))


def flags(source: Path) -> tuple[str, ...]:
    """Flags of one file of the core, or of the C that Cython has made."""
    if source.parent.parent.name != "core":
        return (*LANGUAGE, FACE)
    return (*LANGUAGE, OFTEN if source.parent.name in HOT else ELSE)


def digest(runtime: Path) -> str:
    """Of all that a core is compiled from, and of how."""
    found = hashlib.sha256(repr((LANGUAGE, FACE, OFTEN, ELSE, HOT)).encode())
    runtime = runtime.resolve()  # rglob looks through links, of which an editable installation is made
    for file in (*c_files(runtime), *read_files(runtime)):
        content = file.read_bytes()
        found.update(f"{file.relative_to(runtime).as_posix()}\0{len(content)}\0".encode() + content)
    return found.hexdigest()
