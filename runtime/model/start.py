"""Where the scene starts a model, and how many ways it can move there."""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray
from .assembly import assemble, project
from .drives import drive_rows, put_where_driven
from .geometry import Geometry
from .integrators import integral_rows
from .poses import read_off, read_rates
from .tolerances import start_miss


def start(model: Geometry) -> tuple[FloatArray, FloatArray]:
    """The scene's start (q, u); where parameters have changed since, the nearest that is closed and driven."""
    poses = np.array(model.data["start"]["poses"], dtype=float)
    velocities = np.array(model.data["start"]["velocities"], dtype=float)
    q, u = read_off(model, poses), read_rates(model, poses, velocities)
    if model.rows and np.max(np.abs(model.closure(q))) > start_miss(model.core.REAL, model.length):
        q = assemble(model, q)
    if model.data["drives"]:
        q, u = put_where_driven(model, q, u)
    return project(model, q, u)


def degrees_of_freedom(model: Geometry) -> int:
    """Quasi-velocities less integrals and the rank of the closure and driven joints, at the scene's start."""
    jacobian = model.jacobian(read_off(model, np.array(model.data["start"]["poses"], dtype=float)))
    rows = np.vstack([jacobian, drive_rows(model) * model.length, integral_rows(model) * model.length])
    coarse = max(1e-9, 100.0 * float(np.finfo(model.core.REAL).eps))
    rank = int(np.linalg.matrix_rank(np.asarray(rows, dtype=float), tol=coarse * model.length)) if len(rows) else 0
    return len(model.u_names) - rank
