"""Types of arrays."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]
IntArray = NDArray[np.int_]
ComplexArray = NDArray[np.complex128]
Starts = Sequence[Sequence[float] | NDArray[Any]]
"""Several rows of numbers, told from one by their type; of an array only its dimensions tell."""
