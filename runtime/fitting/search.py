"""Least squares over parameters of a model, within their domains."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ..arrays import FloatArray
from ..extras import needed
from ..faults import Faults
from ..functions.arguments import domain_of
from ..model.model import Model

ENOUGH = 1e-12
"""The search ends where a step, or what it wins, is less than this part: derivatives are exact, so that steps come to
be quadratic, and one more is cheap."""


WEAK = 1e-11
"""How weakly variables are held to their start, beside what moves most: enough to count beside rounding times some
thousand numbers, and its square far below what any direction that is told moves."""


@dataclass(frozen=True)
class Varied:
    """Parameters that are searched for: their paths, where the search begins, and what they may be."""

    paths: tuple[str, ...]
    start: FloatArray
    lowest: FloatArray
    highest: FloatArray

    @property
    def scales(self) -> FloatArray:
        """The size of each, 1 of those that begin at zero: changes are told as parts of it."""
        return np.where(self.start == 0.0, 1.0, np.abs(self.start))


@dataclass(frozen=True, eq=False)
class Search:
    """Where a search has ended: the variables ``x``, the residuals there and their derivatives, and whether it has
    converged."""

    x: FloatArray
    residuals: FloatArray
    jacobian: FloatArray
    converged: bool
    message: str


def varied(model: Model, paths: Sequence[str], what: str) -> Varied:
    """The parameters of these paths, from the values that the model has.

    Raises ``ValueError`` for names that are no parameters or cannot be changed, with all that are wrong.
    """
    if isinstance(paths, str) or not all(isinstance(path, str) for path in paths):
        raise TypeError(f"{what}: found {paths!r}, expected a list of paths of parameters")
    faults, names = Faults(), tuple(paths)
    if not names or len(set(names)) != len(names):
        raise ValueError(f"{what}: found {', '.join(names) or 'nothing'}, expected paths of parameters, each once")
    for path in names:
        if path not in model.parameters:
            faults.add(f"{what}: found {path!r}, which is no parameter; model.parameters has all")
    faults.stop_if_any()
    model.with_parameters({path: model.parameters[path] for path in names})  # raises for what must keep its value
    lowest, highest = zip(*(domain_of(model, path) for path in names), strict=True)
    start = np.array([model.parameters[path] for path in names], dtype=float)
    return Varied(names, start, np.array(lowest), np.array(highest))


def least_squares(
    residuals: Callable[[FloatArray], FloatArray],
    jacobian: Callable[[FloatArray], FloatArray],
    start: FloatArray,
    bounds: tuple[FloatArray, FloatArray],
    scales: FloatArray,
    most: int,
    purpose: str,
) -> Search:
    """SciPy's trust region with bounds (M. A. Branch, T. F. Coleman, Y. Li, SIAM Journal on Scientific Computing 21,
    1999). Where residuals are no numbers the region shrinks. They are pure numbers, of size one where something is
    wrong by all of it.

    Its steps are only right where every direction moves something (it takes all to the border of the region else). So
    each variable is also held to its start, ``WEAK``ly: what measurements tell is changed by the square of that.
    """
    optimize, m = needed("scipy.optimize", purpose), len(residuals(start))
    weak = WEAK * np.linalg.norm(jacobian(start) * scales, 2) / scales

    def held(x: FloatArray) -> FloatArray:
        return np.concatenate([residuals(x), weak * (x - start)])

    def held_jacobian(x: FloatArray) -> FloatArray:
        return np.vstack([jacobian(x), np.diag(weak)])

    found = optimize.least_squares(
        held,
        start,
        held_jacobian,
        bounds,
        x_scale=scales,
        method="trf",
        tr_solver="exact",
        xtol=ENOUGH,
        ftol=ENOUGH,
        gtol=np.finfo(float).eps,  # where no residual is left SciPy would divide by their sum
        max_nfev=most,
    )
    ended = "converged" if found.status > 0 else f"ended after {most} tries, before it had converged"
    x, misses, J = (np.asarray(part, dtype=float) for part in (found.x, found.fun, found.jac))
    return Search(x, misses[:m], J[:m], bool(found.status > 0), ended)
