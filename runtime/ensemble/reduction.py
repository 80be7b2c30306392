"""A function in machine code that reads all rows of each run and leaves a few numbers of it."""

from __future__ import annotations

import ctypes
from dataclasses import dataclass
from typing import Any

REAL = ctypes.POINTER(ctypes.c_double)
SIGNATURE = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, REAL, REAL, ctypes.c_size_t, ctypes.c_size_t, REAL)
"""``int f(void *context, const double *t, const double *rows, size_t count, size_t width, double *out)``."""
FUNCTION: Any = SIGNATURE.__mro__[1]
"""What all functions of ctypes are."""


@dataclass(frozen=True)
class Reduction:
    """A column ``name`` (b, size) of numbers that ``function`` makes of all rows of each run.

    It is called at the end of a run with the times t (count,) of its rows and the rows (count, width), q and u first,
    and writes ``size`` numbers; where it answers other than 0 these are not numbers. It is a ``ctypes`` function of
    that :data:`SIGNATURE`, or has its ``address``, as Numba's ``cfunc`` has: several threads call it at once, without
    Python. ``context`` is an address that it is given.
    """

    function: Any
    size: int
    name: str = "reduced"
    context: int = 0

    @property
    def address(self) -> tuple[int, int, int]:
        """Of the function, of the context, and how many numbers.

        Raises ``TypeError`` for what is no function in machine code."""
        found = getattr(self.function, "address", None)
        if found is None and isinstance(self.function, FUNCTION):
            found = ctypes.cast(self.function, ctypes.c_void_p).value
        if not isinstance(found, int):
            raise TypeError(
                f"reduction: found {self.function!r}, expected a function of ctypes, or one with an address, as "
                "Numba's cfunc has"
            )
        if self.size < 1:
            raise ValueError(f"reduction: found {self.size} numbers, expected at least 1")
        return found, self.context, self.size
