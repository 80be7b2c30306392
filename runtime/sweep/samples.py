"""Random and quasi-random samples of the unit cube, row by row wherever one begins, by SciPy's ``qmc``."""

from __future__ import annotations

import inspect
import warnings
from typing import Any

import numpy as np

from ..arrays import FloatArray
from ..extras import needed

ENGINES = {"sobol": "Sobol", "halton": "Halton", "latin": "LatinHypercube"}
"""Samplers by name; ``random`` is beside them."""
SAMPLERS = ("random", *ENGINES)
BLOCK = 4096
"""Rows of a random sample that are drawn from one stream, so that any of them is found without those before."""
CORNER = 2.0**-53
"""Numbers stay this far from 0 and 1, at which some distributions have none."""


class Samples:
    """``count`` points (count, dimensions) in the unit cube by a sampler's name and a ``seed``."""

    def __init__(self, by: str, dimensions: int, count: int, seed: int) -> None:
        self.by, self.dimensions, self.count, self.seed = by, dimensions, count, seed
        self._whole: FloatArray | None = None

    def rows(self, first: int, last: int) -> FloatArray:
        """Points ``first`` to ``last``, (last - first, dimensions), the same whatever is asked for before."""
        if self.by == "random":
            found = [self._block(block) for block in range(first // BLOCK, (last - 1) // BLOCK + 1)]
            begin = first - first // BLOCK * BLOCK
            points = np.concatenate(found)[begin : begin + last - first]
        elif self.by == "latin":  # one arrangement of all rows
            if self._whole is None:
                self._whole = np.asarray(self._engine().random(self.count))
            points = self._whole[first:last]
        else:
            engine = self._engine()
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", UserWarning)  # of counts that are no power of two: a plan chooses them
                if first:
                    engine.fast_forward(first)
                points = np.asarray(engine.random(last - first))
        return np.clip(points, CORNER, 1.0 - CORNER)

    def _block(self, block: int) -> FloatArray:
        return np.random.default_rng([self.seed, block]).random((BLOCK, self.dimensions))

    def _engine(self) -> Any:
        kind = getattr(needed("scipy.stats", "a quasi-random sample").qmc, ENGINES[self.by])
        name = "rng" if "rng" in inspect.signature(kind).parameters else "seed"  # its name before SciPy 1.15
        return kind(self.dimensions, **{name: self.seed})
