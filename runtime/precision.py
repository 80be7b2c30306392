"""The compiled cores, one for each type of numbers that a model may be in."""

from __future__ import annotations

import importlib
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._core import all_finite, never_decreases

CORES = {"double": "_core", "float": "_float", "wide": "_wide"}


def core_of(precision: str) -> ModuleType:
    """The core over numbers of that precision; its ``REAL`` is the type of its arrays."""
    return importlib.import_module(f".{CORES[precision]}", __package__)


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
    """Whether "wide" numbers have more digits than doubles on this machine, for C and for NumPy alike."""
    kind = core_of("wide").REAL
    return bool(np.finfo(kind).eps < np.finfo(float).eps)
