"""A model's accelerations as a function of numbers: ``acceleration_function(model)``."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import FloatArray
from ..files import read_path, write_whole
from ..model.c_header import check_beside
from ..model.derivatives import need_derivatives
from ..model.forces import Contacts
from ..model.inputs import Values, read_values
from ..model.model import Model
from ..model.numbers import read_numbers
from ..model.places import rate_of
from ..precision import need_doubles
from .arguments import Arguments
from .casadi_source import casadi_source
from .function import Function


class AccelerationFunction(Function):
    """Accelerations u̇ (n,) of a model as a function of x = (q, u, inputs), with their derivatives (n, p), as for a
    problem of optimal control by collocation. Made by :func:`acceleration_function`, which says what is refused.

    ``columns`` (p,) name the entries of x, ``x0`` is the scene's start with the inputs' values, and ``value``,
    ``jacobian`` and the others are those of :class:`RunFunction`, with :meth:`to_jax`, :meth:`to_torch` and
    :meth:`to_casadi`.
    """

    def __init__(self, model: Model, values: FloatArray, t: float, contacts: Contacts) -> None:
        self.model, self.t, self._contacts = model, t, contacts
        n, q_of = len(model.q_names), model.q_of
        columns = (*q_of, *map(rate_of, q_of), *model.inputs)
        start = np.concatenate([*(np.asarray(part, dtype=float) for part in model.start()), values])
        ends = np.full(len(columns), np.inf)
        sizes = (n, n, *(1 for _ in model.inputs))
        self._arguments = Arguments(("q", "u", *model.inputs), sizes, columns, start, -ends, ends)

    def __repr__(self) -> str:
        return f"AccelerationFunction({self.model.name}: q, u{''.join(f', {name}' for name in self.model.inputs)})"

    @property
    def count(self) -> int:
        """How many accelerations there are, n."""
        return len(self.model.u_names)

    def value(self, x: ArrayLike) -> FloatArray:
        """The accelerations (n,). Raises ``ValueError`` where there are none, as ``Model.acceleration`` does."""
        q, u, inputs = self._split(x)
        return np.asarray(self.model.acceleration(q, u, self.t, inputs, self._contacts))

    def value_and_jacobian(self, x: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Both, (n,) and (n, p). Raises ``ValueError`` where there are none, as ``Model.derivatives`` does."""
        q, u, inputs = self._split(x)
        wrt = ("q", "u", *self.model.inputs)
        found = self.model.derivatives("acceleration", q, u, self.t, inputs, wrt, self._contacts)
        return self.value(x), np.asarray(found)

    def write_casadi(self, path: str | os.PathLike[str], name: str | None = None) -> Path:
        """Write C that makes this a function of ``casadi.external`` of that ``name``, by default as the file is called,
        with its Jacobian: of the parameters as they are now, at the time ``t``, and without Python. ``docs/c.md`` has
        the command that compiles it with the core.

        Raises ``ValueError`` for names that CasADi does not take, for a place in the model's package, and for a model
        with contacts that are not left out with ``contacts=()``: in C accelerations are those of flight.
        """
        target = read_path(path, "C for CasADi")
        if self.model.contacts and (self._contacts is None or len(self._contacts)):
            raise ValueError(
                f"contacts: found {self._contacts!r}, expected (): in C accelerations are those of flight; make the "
                "function with contacts=()"
            )
        check_beside(target, self.model.folder)
        text = casadi_source(self.model, target.stem if name is None else name, self.columns, self.t)
        write_whole(target, lambda part: part.write(text.encode()))
        return target

    def _split(self, x: ArrayLike) -> tuple[FloatArray, FloatArray, FloatArray | None]:
        n = len(self.model.q_names)
        q, u, inputs = np.split(self._arguments.read(x), (n, 2 * n))
        return q, u, inputs if self.model.inputs else None


def acceleration_function(
    model: Model, *, inputs: Values | None = None, t: float = 0.0, contacts: Contacts = None
) -> AccelerationFunction:
    """A model's accelerations at the time ``t`` (s) as a function of coordinates, rates and inputs.

    ``inputs`` are the values in ``x0``, zero unless given. ``contacts`` are those of ``Model.acceleration``: closed
    ones push unless told otherwise. Loops are held shut whatever q and u are: accelerations are those of the
    constraint's second derivative, so that a state keeps as open as it is.

    Raises ``ValueError`` for a model without derivatives, in other numbers than doubles, or with integrals over time,
    and for inputs that are no values of the model's.
    """
    if not isinstance(model, Model):
        raise TypeError(f"model: found {type(model).__name__}, expected a Model; load one with load_model(folder)")
    need_doubles(model.precision, model.name, "derivatives of accelerations")
    need_derivatives(model)
    if model.data.get("integrators"):
        found = ", ".join(one["name"] for one in model.data["integrators"])
        raise ValueError(f"{model.name}: found {found}, expected a model without integrals over time")
    time = np.asarray(read_numbers(t, "t"), dtype=float)
    if time.ndim or not np.isfinite(time):
        raise ValueError(f"t: found {t!r}, expected a time in s")
    return AccelerationFunction(model.as_it_is(), read_values(model.inputs, inputs), float(time), contacts)
