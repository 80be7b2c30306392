"""Where the scene starts a model, and how many ways it can move there."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ..arrays import FloatArray
from .assembly import assemble, nearest_closed, project
from .drives import drive_rows, put_where_driven
from .geometry import Geometry
from .integrators import integral_rows
from .poses import read_off, read_rates
from .tolerances import start_miss

Begin = tuple[tuple[tuple[float, ...], ...], ...]
"""Poses and velocities of the links at a start that is not the scene's."""


def begun(data: Mapping[str, Any], begin: Begin) -> Mapping[str, Any]:
    """A model's data with another start."""
    poses, velocities = ([list(row) for row in rows] for rows in begin)
    return {**data, "start": {**data["start"], "poses": poses, "velocities": velocities}}


def start(model: Geometry) -> tuple[FloatArray, FloatArray]:
    """The scene's start (q, u); where parameters have changed since, the nearest that is closed and driven, of those
    that have what the scene gives, where there is one."""
    q, u = scene_start(model)
    if model.rows and np.max(np.abs(model.closure(q))) > start_miss(model.core.REAL, model.length):
        q, u = closed_anew(model, q, u)
    if model.data["drives"]:
        q, u = put_where_driven(model, q, u, kept_rates(model))
    return project(model, q, u)


def scene_start(model: Geometry) -> tuple[FloatArray, FloatArray]:
    """The scene's start as its poses and velocities have it, whatever the parameters are now."""
    poses = np.array(model.data["start"]["poses"], dtype=float)
    velocities = np.array(model.data["start"]["velocities"], dtype=float)
    return read_off(model, poses), read_rates(model, poses, velocities)


def kept_places(model: Geometry) -> list[int]:
    """Coordinates that the scene gives its start, and that its loops leave free."""
    return list(model.data["start"].get("kept_places", ()))


def kept_rates(model: Geometry) -> list[int]:
    """Those whose rates it gives."""
    return list(model.data["start"].get("kept_rates", ()))


def closed_anew(model: Geometry, q: FloatArray, u: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The closed state nearest to one that other values of parameters have opened.

    What the scene gives its start stays as it is, and the rest gives way; where the loops cannot be closed so, all of
    it does. Raises ``ValueError`` where they cannot be closed at all.
    """
    places, rates = kept_places(model), kept_rates(model)
    closed = _closed_with(model, q, places) if places else None
    closed = assemble(model, q) if closed is None else closed
    return closed, _shut_with(model, closed, u, rates) if rates else u


def _closed_with(model: Geometry, q: FloatArray, places: list[int]) -> FloatArray | None:
    """The nearest closed configuration with the coordinates ``places`` as they are, or None where none is found."""
    placed = [drive["position"] is not None for drive in model.data["drives"]]
    held = np.vstack([np.eye(len(q), dtype=q.dtype)[places], drive_rows(model)[placed]]) * model.length

    def misses(x: FloatArray) -> FloatArray:
        return np.append(model.closure(x), held @ (x - q))

    try:
        found = nearest_closed(misses, lambda x: np.vstack([model.jacobian(x), held]), model.displacements(), q)
    except ValueError:
        return None
    found[places] = q[places]
    return found


def _shut_with(model: Geometry, q: FloatArray, u: FloatArray, rates: list[int]) -> FloatArray:
    """The rates nearest to ``u`` that keep the loops shut, those of the coordinates ``rates`` as they are; ``u`` itself
    where there are none."""
    rows = np.asarray(np.vstack([np.eye(len(u))[rates], model.jacobian(q)]), dtype=float)
    wanted = np.append(u[rates], np.zeros(len(model.rows)))
    found = u + np.linalg.lstsq(rows, np.asarray(wanted - rows @ u, dtype=float), rcond=1e-12)[0]
    fits = np.max(np.abs(rows @ found - wanted)) <= start_miss(model.core.REAL, model.length) * (1 + np.max(np.abs(u)))
    return found if fits else u


def degrees_of_freedom(model: Geometry) -> int:
    """Quasi-velocities less integrals and the rank of the closure and driven joints, at the scene's start."""
    jacobian = model.jacobian(read_off(model, np.array(model.data["start"]["poses"], dtype=float)))
    rows = np.vstack([jacobian, drive_rows(model) * model.length, integral_rows(model) * model.length])
    coarse = max(1e-9, 100.0 * float(np.finfo(model.core.REAL).eps))
    rank = int(np.linalg.matrix_rank(np.asarray(rows, dtype=float), tol=coarse * model.length)) if len(rows) else 0
    return len(model.u_names) - rank
