"""``identify(model, {"crank.angle": measured}, at=times, wrt=["crank.mass", "damper_0.damping"])``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import FloatArray
from ..faults import Faults
from ..functions.run_function import RunFunction, run_function
from ..functions.values import output_values
from ..model.inputs import Given
from ..model.model import Model, with_params
from ..model.numbers import read_numbers
from ..run import Run
from ..sensitivity.told import WHOLE, check_outputs
from .known import known
from .search import Search, least_squares, varied

EXACT_TO = 100.0
"""Tolerances of the run to which its derivatives are known."""


@dataclass(frozen=True, eq=False)
class Identified:
    """What measurements tell of a model's parameters.

    ``values`` are the parameters, ``deviations`` their standard deviations and ``covariance`` (p, p) theirs, in SI
    units and in the order of ``values``; infinite for a parameter that the measurements do not tell. ``undetermined``
    are the directions that change no measured number, as relative changes of parameters, the largest 1.

    ``misfit`` is the root mean square of residuals over their standard deviations, per degree of freedom: about 1 where
    the model is right and the deviations given are those of the measurements. Where none were given it is 1 by itself,
    and ``noise`` is what they have, in the unit of each output. ``residuals`` are measured less simulated; ``run`` is
    the run of the values found, and ``run.model`` has them. ``evaluations`` is how many runs that took; ``converged``
    is false where the search was ended before it had converged, and ``message`` says why it ended.
    """

    values: Mapping[str, float]
    deviations: Mapping[str, float]
    covariance: FloatArray = field(repr=False)
    undetermined: tuple[Mapping[str, float], ...]
    misfit: float
    noise: Mapping[str, float]
    residuals: Mapping[str, FloatArray] = field(repr=False)
    run: Run = field(repr=False)
    evaluations: int
    converged: bool
    message: str

    def __str__(self) -> str:
        lines = [
            f"{path} = {value:.6g} ± {self.deviations[path]:.2g}"
            if np.isfinite(self.deviations[path])
            else f"{path} = {value:.6g}, which the measurements do not tell"
            for path, value in self.values.items()
        ]
        for direction in self.undetermined:
            terms = ", ".join(f"{path} by {change:+.3g}" for path, change in direction.items())
            lines.append(f"changes nothing that was measured: relative changes of {terms}")
        lines.append(f"misfit {self.misfit:.3g}; {self.message}")
        return "\n".join(lines)


def identify(
    model: Model,
    data: Mapping[str, ArrayLike],
    at: ArrayLike,
    wrt: Sequence[str],
    q0: ArrayLike | None = None,
    u0: ArrayLike | None = None,
    *,
    sigma: float | Mapping[str, float] | None = None,
    params: Mapping[str, float] | None = None,
    inputs: Given = None,
    rtol: float | None = None,
    atol: float | None = None,
    method: str | None = None,
    step: float | None = None,
    most: int = 100,
) -> Identified:
    """The parameters ``wrt`` with which a run is nearest to measurements, by least squares with exact derivatives.

    ``data`` are measured outputs by name, (m,) each, or (m, n) of ``"q"`` and ``"u"``, at the times ``at`` (m,) in s;
    NaN where nothing was measured. Which outputs there are, and which runs have derivatives, is that of
    :func:`~.sensitivities.sensitivities`: through impacts, contact and friction. The search begins at the values that
    the model has, or ``params``, and stays in the domains of the parameters; ``most`` is how many runs it may take.
    ``sigma`` is the standard deviation of the measurements, one for all or by name, in SI units and radians; unless
    given all outputs count alike, each by its own size, and it is what the residuals are found to have. Other arguments
    are those of :func:`simulate`.

    Weighted least squares with the covariance of their linearisation (G. A. F. Seber, C. J. Wild, Nonlinear Regression,
    1989, section 2.1). Needs SciPy, and a model generated with its derivatives.

    Raises ``ValueError`` for names, shapes and numbers that are wrong, all at once; where a run on the way has no
    derivative, with its parameters; where the first run does not come to the last of the times.
    """
    if not isinstance(model, Model):
        raise TypeError(f"model: found {type(model).__name__}, expected a Model; load one with load_model(folder)")
    begun = with_params(model, params)
    faults, measured, search = Faults(), None, None
    with faults.collecting():
        search = varied(begun, wrt, "wrt")
    with faults.collecting():
        measured = _measured(begun, data, at, sigma)
    if isinstance(most, bool) or not isinstance(most, int) or most < 1:
        faults.add(f"most: found {most!r}, expected a number of runs, at least 1")
    faults.stop_if_any()
    assert measured is not None and search is not None
    if measured.count <= len(search.paths):
        raise ValueError(
            f"data: found {measured.count} numbers, expected more than the {len(search.paths)} parameters that they "
            "are to tell"
        )
    options: dict[str, Any] = {"rtol": rtol, "atol": atol, "method": method, "step": step, "inputs": inputs}
    outputs = [*measured.values]
    function = run_function(begun, search.paths, outputs, q0, u0, at=measured.times, on_stop="nan", **options)
    misses = _Misses(function, measured)
    if not np.all(np.isfinite(misses.residuals(search.start))):
        message = function.run(search.start).message
        raise ValueError(f"{model.name}: the first run ends before the last of the times: {message}")
    bounds = (search.lowest, search.highest)
    found = least_squares(
        misses.residuals, misses.jacobian, search.start, bounds, search.scales, most, "identifying parameters"
    )
    return _told(search.paths, misses, found)


@dataclass(frozen=True, eq=False)
class _Measured:
    """Outputs at ``times`` (m,): values and standard deviations as arrays of one shape, by name."""

    times: FloatArray
    values: dict[str, FloatArray]
    sigma: dict[str, FloatArray]
    given: bool

    @property
    def count(self) -> int:
        return int(sum(np.isfinite(one).sum() for one in self.values.values()))


def _measured(
    model: Model, data: Mapping[str, ArrayLike], at: ArrayLike, sigma: float | Mapping[str, float] | None
) -> _Measured:
    """Raises ``ValueError`` with all that is wrong."""
    if not isinstance(data, Mapping) or not data:
        raise ValueError(f"data: found {data!r}, expected measured outputs by name")
    faults = Faults()
    times = np.atleast_1d(np.asarray(read_numbers(at, "at"), dtype=float))
    if times.ndim != 1 or not np.all(np.isfinite(times)) or np.any(times < 0.0):
        faults.add(f"at: found {at!r}, expected a row of times in s, none before 0")
    with faults.collecting():
        check_outputs(model, list(data))
    found, n = {}, len(model.q_names)
    for name, given in data.items():
        shape = (len(times), n) if name in WHOLE else (len(times),)
        try:
            found[name] = np.array(given, dtype=float)
        except (TypeError, ValueError):
            faults.add(f"data: {name}: found {given!r}, expected numbers of shape {shape}")
            continue
        if found[name].shape != shape:
            faults.add(f"data: {name}: found shape {found[name].shape}, expected {shape}, a row for each of the times")
        elif np.any(np.isinf(found[name])):
            faults.add(f"data: {name}: found inf, expected numbers, or NaN where nothing was measured")
    with faults.collecting():
        deviations = _deviations(found, sigma)
    faults.stop_if_any()
    return _Measured(times, found, deviations, sigma is not None)


def _deviations(found: Mapping[str, FloatArray], sigma: float | Mapping[str, float] | None) -> dict[str, FloatArray]:
    """As given, or the size of each output, which then only weighs them against each other."""
    if sigma is None:
        return {name: np.full_like(one, _size(one)) for name, one in found.items()}
    by = sigma if isinstance(sigma, Mapping) else dict.fromkeys(found, sigma)
    if set(by) != set(found):
        raise ValueError(f"sigma: found {', '.join(by)}, expected the names of the data, {', '.join(found)}")
    for name, value in by.items():
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not 0.0 < value < np.inf:
            raise ValueError(f"sigma: {name}: found {value!r}, expected a standard deviation above 0")
    return {name: np.full_like(one, float(by[name])) for name, one in found.items()}


def _size(values: FloatArray) -> float:
    """How much an output varies, or how large it is where it does not."""
    return float(np.nanstd(values) or np.nanmax(np.abs(values)) or 1.0) if np.isfinite(values).any() else 1.0


class _Misses:
    """What is measured less what is simulated, over their deviations, as a function of the parameters."""

    def __init__(self, function: RunFunction, measured: _Measured) -> None:
        self.function, self.measured = function, measured
        self.measures = np.concatenate([np.isfinite(one).ravel() for one in measured.values.values()])
        self.wanted, self.sigma = (
            np.concatenate([one.ravel() for one in parts.values()])[self.measures]
            for parts in (measured.values, measured.sigma)
        )

    def residuals(self, x: FloatArray) -> FloatArray:
        """NaN where the run ends before."""
        return np.asarray((self.wanted - self.function.value(x)[self.measures]) / self.sigma)

    def jacobian(self, x: FloatArray) -> FloatArray:
        """What the residuals move by."""
        return np.asarray(-self.function.jacobian(x)[self.measures] / self.sigma[:, None])


def _told(paths: tuple[str, ...], misses: _Misses, found: Search) -> Identified:
    function, measured, residuals = misses.function, misses.measured, found.residuals
    run = function.run(found.x)
    exact_to = EXACT_TO * function.rtol
    of = known(paths, found.jacobian, np.where(found.x == 0.0, 1.0, np.abs(found.x)), exact_to)
    misfit = float(np.sqrt(residuals @ residuals / max(len(residuals) - of.rank, 1)))
    scale = 1.0 if measured.given else misfit
    covariance = of.covariance * scale**2
    noise = {name: scale * float(np.nanmean(one)) for name, one in measured.sigma.items()}
    each = output_values(run, [*measured.values], measured.times)
    return Identified(
        values=dict(zip(paths, found.x.tolist(), strict=True)),
        deviations=dict(zip(paths, np.sqrt(np.diag(covariance)).tolist(), strict=True)),
        covariance=covariance,
        undetermined=of.open,
        misfit=misfit if measured.given else 1.0,
        noise=noise,
        residuals={name: one - each[name] for name, one in measured.values.items()},
        run=run,
        evaluations=function.evaluations,
        converged=found.converged,
        message=found.message,
    )
