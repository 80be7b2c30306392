"""A run as a function of numbers: ``run_function(model, ["u0", "link.mass"], ["tip.x"])``."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import FloatArray
from ..faults import Faults
from ..model.derivatives import need_derivatives
from ..model.inputs import Given
from ..model.model import Model, with_params
from ..model.numbers import read_numbers
from ..precision import need_doubles
from ..run import Run
from ..sensitivity.jacobian import MODES, Mode, run_sensitivities, run_vjp
from ..sensitivity.told import TIMES, WHOLE, Output, check_outputs, label, read_outputs
from ..simulate import simulate
from ..simulation.one_run import options_of
from .arguments import arguments_of, constants_of
from .function import Function
from .values import output_values

STOPS = ("refuse", "nan")


class Kept(NamedTuple):
    """The last x that was asked for, its run, and what is known of that by now."""

    x: FloatArray
    run: Run
    value: FloatArray | None = None
    jacobian: FloatArray | None = None


class RunFunction(Function):
    """Outputs (m,) of a model's run as a function of a vector x (p,), with their derivatives (m, p).

    ``columns`` (p,) name the entries of x, ``x0`` (p,) is what they are in the model, and ``bounds``, two arrays (p,),
    what they may be. ``value(x)`` are the ``outputs`` one behind the other, those of the first for all times first;
    calling it is the same. SI units and radians. Made by :func:`run_function`, which says what is refused. The run of
    the x asked for last is kept, so that its derivatives do not take another; ``evaluations`` is how many were made.

    With SciPy: ``least_squares(f, f.x0, jac=f.jacobian, bounds=f.bounds)``, and of one number
    ``minimize(f.value_and_gradient, f.x0, jac=True)``. :meth:`to_jax`, :meth:`to_torch` and :meth:`to_casadi` give it
    to these.
    """

    def __init__(
        self,
        model: Model,
        wrt: Sequence[str] | str,
        outputs: Sequence[Output] | Output,
        start: tuple[ArrayLike | None, ArrayLike | None],
        at: ArrayLike | None,
        on_stop: str,
        mode: Mode,
        options: dict[str, Any],
    ) -> None:
        need_doubles(model.precision, model.name, "derivatives of a run")
        need_derivatives(model)
        faults = Faults()
        self.model = model
        self.outputs: tuple[Output, ...] = tuple(read_outputs(outputs))
        self._start, self._options, self._on_stop, self._mode = start, options, on_stop, mode
        self._kept: Kept | None = None
        self.evaluations = 0
        with faults.collecting():
            self._arguments = arguments_of(model, wrt, start, options["inputs"])
        with faults.collecting():
            check_outputs(model, self.outputs)
        if not self.outputs:
            faults.add("outputs: found none, expected at least one")
        with faults.collecting():
            self._at = None if at is None else _times(at, options["until"])
            if self._at is not None and options["until"] is None:
                self._options = options | {"until": float(np.max(self._at))}
        with faults.collecting():
            others: dict[str, Any] = {"drift": None, "on_gain": None, "progress": None, "keep_interrupted": False}
            asked = {name: value for name, value in options.items() if name not in ("params", "inputs")}
            self.rtol = options_of(model, inputs=None, **asked, **others).settings.rtol
        if on_stop not in STOPS:
            faults.add(f"on_stop: found {on_stop!r}, expected one of {', '.join(STOPS)}")
        if mode not in MODES:
            faults.add(f"mode: found {mode!r}, expected one of {', '.join(MODES)}")
        faults.stop_if_any()
        self._count = self._known_count()

    def _known_count(self) -> int | None:
        """How many numbers outputs have by their names; None where some are functions or impact times."""
        if any(callable(one) or one == TIMES for one in self.outputs):
            return None
        times = 1 if self._at is None else len(self._at)
        return times * sum(len(self.model.q_names) if one in WHOLE else 1 for one in self.outputs)

    def __repr__(self) -> str:
        outputs = ", ".join(label(one) for one in self.outputs)
        return f"RunFunction({self.model.name}: {', '.join(self._arguments.names)} -> {outputs})"

    @property
    def count(self) -> int:
        """How many numbers ``value`` has, m; where only a run can tell, as of impact times, those at ``x0``."""
        if self._count is None:
            kept = self._at_x(self.x0)
            if not kept.run.success:
                raise self._stopped(kept)
            self._count = len(self._values(kept))
        return self._count

    def run(self, x: ArrayLike) -> Run:
        """The run of these numbers. Raises ``ValueError`` for an x that is none, or that the model cannot have."""
        return self._at_x(x).run

    def value(self, x: ArrayLike) -> FloatArray:
        """The outputs (m,). Raises ``ValueError``, with x, where the run stops early, unless ``on_stop`` is "nan"."""
        return self._values(self._at_x(x)).copy()

    def value_and_jacobian(self, x: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Both, (m,) and (m, p), of one run."""
        kept = self._at_x(x)
        value = self._values(kept)
        if kept.jacobian is None:
            found = self._told(kept.x, lambda: self._derived(kept))
            self._kept = kept = kept._replace(value=value, jacobian=found)
        assert kept.jacobian is not None
        return value.copy(), kept.jacobian.copy()

    def vjp(self, x: ArrayLike, w: ArrayLike) -> FloatArray:
        """What the outputs weighted with w (m,) move by, (p,), in adjoint mode: no Jacobian is made for it."""
        kept = self._at_x(x)
        value = self._values(kept)
        if kept.jacobian is not None:
            return super().vjp(x, w)
        weights = self._weights(w, len(value))
        q0, u0 = self._given(kept.x)
        names = self._arguments.names
        found: FloatArray = self._told(
            kept.x, lambda: run_vjp(kept.run, weights, names, self.outputs, self._at, (q0, u0))
        )
        return found

    # -- the run that is kept: replaced as a whole, so that threads at worst make one anew ---------------------------

    def _at_x(self, x: ArrayLike) -> Kept:
        read, kept = self._arguments.read(x), self._kept
        if kept is None or not np.array_equal(kept.x, read):
            self._kept = kept = Kept(read, self._told(read, lambda: self._simulated(read)))
        return kept

    def _split(self, x: FloatArray) -> tuple[tuple[Any, Any], dict[str, float], Given]:
        """The start (q0, u0), values of parameters, and inputs."""
        parts: dict[str, Any] = self._arguments.parts(x)
        start = parts.pop("q0", self._start[0]), parts.pop("u0", self._start[1])
        own = {name: parts.pop(name) for name in [*parts] if name in self.model.inputs}
        inputs = self._options["inputs"]
        if own:
            inputs = dict(zip(self.model.inputs, constants_of(self.model, inputs).tolist(), strict=True)) | own
        return start, parts, inputs

    def _simulated(self, x: FloatArray) -> Run:
        (q0, u0), params, inputs = self._split(x)
        found = simulate(self.model, q0, u0, params=params or None, **self._options | {"inputs": inputs})
        self.evaluations += 1
        assert isinstance(found, Run)
        return found

    def _values(self, kept: Kept) -> FloatArray:
        if kept.value is not None:
            return kept.value
        run = kept.run
        if run.success:
            times = run.t[-1:] if self._at is None else self._at
            found = self._told(kept.x, lambda: output_values(run, self.outputs, times))
            value = np.concatenate([np.ravel(one) for one in found.values()])
            if self._count not in (None, len(value)):
                raise ValueError(
                    f"with {self._arguments.told(kept.x)}: found {len(value)} numbers, expected {self._count} as at x0:"
                    " other impacts come"
                )
        elif self._on_stop == "nan":
            value = np.full(self.count, np.nan)
        else:
            raise self._stopped(kept)
        if self._kept is kept:
            self._kept = kept._replace(value=value)
        return value

    def _stopped(self, kept: Kept) -> ValueError:
        return ValueError(
            f"with {self._arguments.told(kept.x)}: found a run that stopped early, expected one that reaches its end: "
            f"{kept.run.message}"
        )

    def _derived(self, kept: Kept) -> FloatArray:
        q0, u0 = self._given(kept.x)
        names = self._arguments.names
        return run_sensitivities(kept.run, names, self.outputs, self._at, (q0, u0), self._mode).jacobian

    def _given(self, x: FloatArray) -> tuple[FloatArray | None, FloatArray | None]:
        """The start as the run has it from x, with None for what is the scene's."""
        q0, u0 = (None if one is None else np.asarray(one, dtype=float) for one in self._split(x)[0])
        return q0, u0

    def _told(self, x: FloatArray, work: Callable[[], Any]) -> Any:
        """What ``work`` gives; what it refuses is refused with x."""
        try:
            return work()
        except ValueError as error:
            raise ValueError(f"with {self._arguments.told(x)}: {error}") from error


def _times(at: ArrayLike, until: float | None) -> FloatArray:
    times = np.atleast_1d(np.asarray(read_numbers(at, "at"), dtype=float))
    if times.ndim != 1 or not times.size or not np.all(np.isfinite(times)) or np.any(times < 0.0):
        raise ValueError(f"at: found {at!r}, expected a row of times in s, none before 0")
    if isinstance(until, (int, float)) and np.any(times > until):
        raise ValueError(f"at: found {times.max():g} s, expected times to the end of the run, until = {until:g} s")
    return times


def run_function(
    model: Model,
    wrt: Sequence[str] | str,
    outputs: Sequence[Output] | Output = WHOLE,
    q0: ArrayLike | None = None,
    u0: ArrayLike | None = None,
    *,
    at: ArrayLike | None = None,
    until: float | None = None,
    rtol: float | None = None,
    atol: float | None = None,
    method: str | None = None,
    step: float | None = None,
    params: dict[str, float] | None = None,
    inputs: Given = None,
    on_stop: str = "refuse",
    mode: Mode = "auto",
) -> RunFunction:
    """Outputs of a model's run as a function of starts, parameters and inputs, with exact derivatives.

    ``wrt`` names the entries of its vector, ``"q0"``, ``"u0"``, parameters by their paths and inputs, in that order;
    ``outputs``, ``at`` and ``mode`` say what its values are and how Jacobians are made, as for
    :func:`~.sensitivities.sensitivities`, and all other arguments
    are those of :func:`simulate`: what ``wrt`` does not name. The run ends with the last of the times ``at`` unless
    ``until`` is given. A run that stops early has no values: that is refused, or with ``on_stop="nan"`` they are no
    numbers, from which searches step back.

    Raises ``ValueError`` or ``TypeError`` for names, shapes and numbers that are wrong, all at once.
    """
    if not isinstance(model, Model):
        raise TypeError(f"model: found {type(model).__name__}, expected a Model; load one with load_model(folder)")
    begun = with_params(model, params)
    options = {"until": until, "rtol": rtol, "atol": atol, "method": method, "step": step, "inputs": inputs}
    return RunFunction(begun, wrt, outputs, (q0, u0), at, on_stop, mode, options)
