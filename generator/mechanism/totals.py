"""Sums of numbers, the same to the last bit in every Python: from 3.12 on the built-in ``sum`` compensates floats."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TypeVar

Number = TypeVar("Number", float, complex)


def total(parts: Iterable[Number]) -> Number:
    """The sum of numbers or of arrays, added one after the other, as given; 0.0 of none."""
    whole: Number = 0.0
    for part in parts:
        whole = whole + part
    return whole
