"""How well measurements tell parameters: covariance, and directions that they leave open."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..arrays import FloatArray


@dataclass(frozen=True, eq=False)
class Known:
    """``covariance`` (p, p) of the parameters, in their own units, infinite for those that are left open; ``open`` are
    the directions that change no residual, as relative changes of parameters."""

    covariance: FloatArray
    open: tuple[dict[str, float], ...]
    rank: int


def known(paths: Sequence[str], jacobian: FloatArray, scales: FloatArray, exact_to: float) -> Known:
    """From the ``jacobian`` (m, p) of residuals that have a variance of one, by parameters of sizes ``scales`` (p,).

    The covariance is the inverse of J^T J, by singular values (A. Bjorck, Numerical Methods for Least Squares Problems,
    1996, section 2.8.1). ``exact_to`` is the part of the largest singular value to which J is known: one that is less
    is zero for all that is known, and its direction is open. A parameter takes part in such a direction where its
    entry is more than rounding can turn the direction by, ``exact_to`` over the gap to the next singular value.
    """
    _, values, directions = np.linalg.svd(jacobian * scales, full_matrices=True)
    whole = np.zeros(len(paths))
    whole[: len(values)] = values
    largest = whole.max(initial=0.0)
    rank = int(np.sum(whole > exact_to * largest))
    seen, unseen = directions[:rank], directions[rank:]
    covariance = (seen.T / whole[:rank] ** 2) @ seen * np.outer(scales, scales)
    turned = exact_to * largest / whole[rank - 1] if rank else 0.0
    opened = np.any(np.abs(unseen) > turned, axis=0) if len(unseen) else np.zeros(len(paths), dtype=bool)
    covariance[opened, :] = covariance[:, opened] = np.inf
    return Known(covariance, tuple(_named(paths, one, turned) for one in unseen), rank)


def _named(paths: Sequence[str], direction: FloatArray, turned: float) -> dict[str, float]:
    """The largest entry is 1."""
    scaled = direction / direction[np.argmax(np.abs(direction))]
    return {path: float(x) for path, x in zip(paths, scaled, strict=True) if abs(x) > turned}
