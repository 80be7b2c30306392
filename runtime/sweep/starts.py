"""Starts whose coordinates and speeds vary: the nearest to the scene's own that have the wanted ones, loops shut."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..arrays import FloatArray
from ..faults import sentence
from ..model.assembly import nearest_closed
from ..model.model import Model
from ..model.start import kept_places, kept_rates

RATES = {"angle": "angular_velocity", "slide": "slide_rate", "x": "vx", "y": "vy"}
"""What the rate of each kind of coordinate is called."""


RANK = 1e-9
"""Singular values of rows below this, times the mechanism's length, are zero: rows are known to some 1e-15 of it, and
what they leave free by less would move the others a billion times as fast."""

AT_START = "(0)"
"""Behind the name of an output: its value at t = 0, apart from the output itself, which may be observed too."""


def start_names(model: Model) -> dict[str, tuple[str, int]]:
    """Names of all coordinates and their rates at the start, ``crank.angle(0)``, and which entry of q or u each is."""
    found = {f"{name}{AT_START}": ("q", k) for k, name in enumerate(model.q_of)}
    for k, name in enumerate(model.q_of):
        of, _, kind = name.rpartition(".")
        found[f"{of}.{RATES[kind]}{AT_START}"] = ("u", k)
    return found


def starts_of(
    model: Model, params: Mapping[str, FloatArray], wanted: Mapping[str, FloatArray]
) -> tuple[FloatArray | None, FloatArray | None, dict[int, str]]:
    """Starts q and u (runs, n) in which coordinates and rates are as ``wanted`` (runs,) by name, None for the scene's
    own; and, of runs that have no such start, why.

    Where loops are to be shut, q is the nearest to the scene's start in joint displacements, and u the nearest to its
    speeds, among those that have the wanted ones."""
    if not wanted:
        return None, None, {}
    names, count = start_names(model), len(next(iter(wanted.values())))
    entries = [(*names[name], values) for name, values in wanted.items()]
    alike = not (model.rows and params)  # loops are closed with each run's own parameters
    own_q, own_u = model.start()
    q, u, faults = np.tile(own_q, (count, 1)), np.tile(own_u, (count, 1)), dict[int, str]()
    for kind, k, values in entries:
        (q if kind == "q" else u)[:, k] = values
    if not model.rows:
        return q, u, faults
    for run in range(count):
        one = model if alike else model.with_parameters({path: values[run].item() for path, values in params.items()})
        try:
            q[run], u[run] = _closed(one, own_q, own_u, [(kind, k, values[run].item()) for kind, k, values in entries])
        except ValueError as error:
            q[run], faults[run] = np.nan, sentence(error)
    return q, u, faults


def _closed(
    model: Model, q: FloatArray, u: FloatArray, wanted: list[tuple[str, int, float]]
) -> tuple[FloatArray, FloatArray]:
    """The start nearest to (q, u) with loops shut and the wanted entries, and of the others those that the scene gives
    where the loops leave all of these free together."""
    places = [(k, value) for kind, k, value in wanted if kind == "q"]
    speeds = [(k, value) for kind, k, value in wanted if kind == "u"]
    places += _staying(model, q, places, [(k, q[k].item()) for k in kept_places(model)])
    rows = np.zeros((len(places), q.size))
    for row, (k, _) in enumerate(places):
        rows[row, k] = model.length
    values = np.array([value for _, value in places])

    def misses(at: FloatArray) -> FloatArray:
        off = np.array([at[k] for k, _ in places]) - values if places else np.zeros(0)
        return np.concatenate([model.closure(at), model.length * off])

    found = nearest_closed(misses, lambda at: np.vstack([model.jacobian(at), rows]), model.displacements(), q)
    speeds += _staying(model, found, speeds, [(k, u[k].item()) for k in kept_rates(model)])
    jacobian = np.vstack([model.jacobian(found), np.eye(u.size)[[k for k, _ in speeds]]])
    right = np.concatenate([np.zeros(len(model.rows)), [value for _, value in speeds]])
    change = np.linalg.lstsq(jacobian, right - jacobian @ u, rcond=None)[0]
    if np.max(np.abs(jacobian @ (u + change) - right), initial=0.0) > 1e-9 * (1.0 + np.max(np.abs(right), initial=0.0)):
        raise ValueError("no motion that keeps the loops shut has the wanted speeds")
    return found, u + change


Entries = list[tuple[int, float]]
"""Coordinates, or rates, and their values."""


def _staying(model: Model, q: FloatArray, wanted: Entries, kept: Entries) -> Entries:
    """Those of the entries ``kept`` that are not ``wanted`` otherwise; none of them where the loops do not leave them
    free together with these."""
    others = [(k, value) for k, value in kept if k not in {one for one, _ in wanted}]
    rows, unit = model.jacobian(q), model.length * np.eye(q.size)
    known = np.vstack([rows, unit[[k for k, _ in wanted]]])
    every = np.vstack([known, unit[[k for k, _ in others]]])
    tolerance = RANK * model.length
    free = np.linalg.matrix_rank(every, tol=tolerance) - np.linalg.matrix_rank(known, tol=tolerance)
    return others if free == len(others) else []
