"""What other packages are told of a function and its derivatives."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import FloatArray


class Derived(Protocol):
    """A function of x (p,) with ``count`` values (m,), and its derivatives (m, p): whole, along a direction, and
    weighted."""

    @property
    def count(self) -> int:
        """m."""

    @property
    def columns(self) -> tuple[str, ...]:
        """What the entries of x are."""

    def value(self, x: ArrayLike) -> FloatArray:
        """(m,)"""

    def value_and_jacobian(self, x: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """(m,) and (m, p)"""

    def jvp(self, x: ArrayLike, v: ArrayLike) -> FloatArray:
        """(m,), along v (p,)"""

    def vjp(self, x: ArrayLike, w: ArrayLike) -> FloatArray:
        """(p,), weighted with w (m,)"""


def check_vector(of: Derived, shape: tuple[int, ...], kind: Any, wanted: Any, package: str) -> None:
    """Raise unless an array of another package is a vector x of doubles: ``TypeError``, ``ValueError``."""
    if kind != wanted:
        raise TypeError(
            f"x: found {package} numbers of type {kind}, expected {wanted}: runs and their derivatives are in doubles"
        )
    if tuple(shape) != (len(of.columns),):
        listed = ", ".join(of.columns[:12]) + (", …" if len(of.columns) > 12 else "")
        raise ValueError(f"x: found shape {tuple(shape)}, expected ({len(of.columns)},): {listed}")


def doubles(array: Any) -> FloatArray:
    """An array of another package, as one of NumPy."""
    return np.asarray(array, dtype=float)
