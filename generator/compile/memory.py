"""How much memory the C compiler takes for a model, said before it is asked for."""

from __future__ import annotations

import re
import warnings
from pathlib import Path

OWN, LINEAR, SQUARE = 30e6, 560.0, 1.09e-3
"""Peak of gcc 12 with -O2: bytes of its own, per byte of the largest function, and per square of that. Measured with
lattices of n × n squares: largest functions of 38,480, 104,972 and 234,031 characters (n = 2, 3, 4)
took 56, 101 and 221 MB; with n = 10 the formula has 6.6 GB where 7.4 were seen."""
MUCH = 1e9
"""Bytes from which on it is worth a word."""
FUNCTION = re.compile(r"^\{.*?^\}", re.DOTALL | re.MULTILINE)


def peak(source: str) -> float:
    """The most memory (bytes) that gcc takes for a source, by its largest function."""
    largest = max((len(body[0]) for body in FUNCTION.finditer(source)), default=0)
    return OWN + LINEAR * largest + SQUARE * largest**2


def tell_of_memory(name: str, file: Path) -> None:
    """Warn that compiling the model of the scene ``name`` takes much memory, where it does."""
    needed = peak(file.read_text())
    if needed >= MUCH:
        warnings.warn(
            f"{name}: the C compiler will take about {needed / 1e9:.2g} GB of memory for {file.name}, and minutes, as "
            "many loops hang together; with less memory the system ends it",
            stacklevel=2,
        )
