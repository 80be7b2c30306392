"""Where the scene starts a model, with whatever values of its parameters, and how many ways it can move there.

All ways to run a model begin here: the start is one function of the parameters, and ``sensitivity.start`` derives it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ..arrays import FloatArray
from .assembly import least_weighted, nearest_closed, project
from .drives import drive_misses, drive_rows, drive_speeds
from .geometry import Geometry
from .integrators import integral_rows
from .lines import Lines
from .poses import read_off
from .tolerances import start_miss

Rows = tuple[tuple[float, ...], ...]


class Begin(NamedTuple):
    """Poses and velocities of the links at a start that is not the scene's, and the values of all parameters for which
    they were given."""

    poses: Rows
    velocities: Rows
    values: tuple[float, ...]


class Closed(NamedTuple):
    """A configuration ``q`` with loops shut and the joints of the drives ``placed`` where they are to be, the
    coordinates ``kept`` as the scene gives them: of all those the one with the least Σ w (q − near)², ``weights``
    (n, n) being w."""

    q: FloatArray
    kept: list[int]
    placed: list[int]
    near: FloatArray
    weights: FloatArray


class Going(NamedTuple):
    """Rates ``u`` that keep loops shut and are those of driven joints, those of the coordinates ``kept`` as the scene
    gives them, likewise."""

    u: FloatArray
    kept: list[int]
    near: FloatArray
    weights: FloatArray


def begun(data: Mapping[str, Any], begin: Begin) -> Mapping[str, Any]:
    """A model's data with another start."""
    poses, velocities = ([list(row) for row in rows] for rows in begin[:2])
    values = dict(zip((one["path"] for one in data["parameters"]), begin.values, strict=True))
    own = {"poses": poses, "velocities": velocities, "values": values, "sketch": [], "smallest_rates": False}
    return {**data, "start": {**data["start"], **own}}


def start(model: Geometry) -> tuple[FloatArray, FloatArray]:
    """The start (q, u) for the model's parameters: the scene's own where these leave loops shut, and driven joints
    where and as fast as they are to be; else one that has what the scene gives, as :func:`closed_anew` and
    :func:`going_anew` say.

    Raises ``ValueError`` where the loops cannot be closed.
    """
    return project(model, *put_right(model, *scene_start(model)))


def put_right(model: Geometry, q: FloatArray, u: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The scene's start (q, u), closed and set going anew where it has to be."""
    if is_open(model, q):
        q = closed_anew(model, q).q
    q, u = as_first_link(model, q, u)
    return q, going_anew(model, q, u).u if misses_rates(model, q, u) else u


def scene_start(model: Geometry) -> tuple[FloatArray, FloatArray]:
    """The coordinates and rates of the scene's start as its own values of parameters have them, whatever they are
    now."""
    own = model.data["start"].get("values") or {one["path"]: one["value"] for one in model.data["parameters"]}

    def numbers(points: Any) -> FloatArray:
        return np.array([[own[x] if isinstance(x, str) else x for x in point] for point in points], dtype=float)

    lines = Lines(model.data, numbers)
    poses = np.array(model.data["start"]["poses"], dtype=float)
    velocities = np.array(model.data["start"]["velocities"], dtype=float)
    named = model.data["coordinates"]
    q = [lines.coordinate(kind, of, poses) for kind, of in named]
    u = [lines.rate(kind, of, poses, velocities) for kind, of in named]
    return np.array(q, dtype=model.core.REAL), np.array(u, dtype=model.core.REAL)


def kept_places(model: Geometry) -> list[int]:
    """Coordinates that the scene gives its start, and that its loops leave free."""
    return list(model.data["start"].get("kept_places", ()))


def kept_rates(model: Geometry) -> list[int]:
    """Those whose rates it gives."""
    return list(model.data["start"].get("kept_rates", ()))


def is_open(model: Geometry, q: FloatArray) -> bool:
    """Whether loops are open there, or driven joints not where they are to be, by more than rounding."""
    misses = np.append(model.closure(q), drive_misses(model, q))
    return bool(np.max(np.abs(misses), initial=0.0) > start_miss(model.core.REAL, model.length))


def misses_rates(model: Geometry, q: FloatArray, u: FloatArray) -> bool:
    """Whether loops open with these rates, or driven joints are not as fast as they are to be, by more than
    rounding."""
    if not model.rows and not model.data["drives"]:
        return False
    driven = np.max(np.abs(drive_rows(model) @ u - drive_speeds(model)), initial=0.0)
    opening = np.max(np.abs(model.kernels.of_state("closure_rate", q[None], u[None])), initial=0.0)
    return bool(max(driven, opening) > start_miss(model.core.REAL, model.length) * rates_miss(u))


def rates_miss(u: FloatArray) -> float:
    """What rates of loops and of driven joints may miss by rounding, by what their places may."""
    return max(1.0, float(np.max(np.abs(u), initial=0.0)))


def closed_anew(model: Geometry, q: FloatArray) -> Closed:
    """The configuration that other values of parameters make of the scene's own q, which they have opened.

    What the scene gives its start stays as it is, where the loops can be closed so; the rest is the nearest to the
    sketch of the scene, or where that is not known by coordinates, to its own start. Raises ``ValueError`` where the
    loops cannot be closed at all.
    """
    kept, sketch = kept_places(model), model.data["start"].get("sketch")
    weights, wanted = _weights(model), np.array(sketch, dtype=q.dtype) if sketch else q
    driven = list(model.data["start"].get("kept_drives", ()))
    tries = [(kept, driven, wanted)] if kept or driven or sketch else []
    if driven and sketch and not kept:
        tries.append(([], [], wanted))
    for held, still, near in [*tries, ([], [], q)]:
        found = least_weighted(*_shutting(model, q, held, still), weights, near, q)
        if found is not None:
            found[held] = q[held]
            return Closed(found, held, placed_drives(model, still), near, weights)
    found = nearest_closed(*_shutting(model, q, [], []), np.sqrt(weights), q)
    return Closed(found, [], placed_drives(model, []), q, weights)


def placed_drives(model: Geometry, still: Sequence[int] = ()) -> list[int]:
    """The drives, by number, whose joints are where these have them at the start, or ``still`` where the scene has
    them."""
    return [k for k, drive in enumerate(model.data["drives"]) if drive["position"] is not None or k in still]


def _weights(model: Geometry) -> FloatArray:
    """What changes of coordinates and of rates are weighed by (n, n)."""
    return np.diag(model.data["start"].get("weights") or np.ones(len(model.q_names)))


def _shutting(model: Geometry, q: FloatArray, kept: list[int], still: list[int]) -> tuple[Any, Any]:
    """What misses of loops, of the places of driven joints, of those of the drives ``still`` and of the coordinates
    ``kept`` at q, and its derivatives."""
    placed, rows = placed_drives(model), drive_rows(model)
    held = np.vstack([np.eye(len(q))[kept], rows[still]]) * model.length

    def misses(x: FloatArray) -> FloatArray:
        return np.concatenate([model.closure(x), drive_misses(model, x)[placed] * model.length, held @ (x - q)])

    return misses, lambda x: np.vstack([model.jacobian(x), rows[placed] * model.length, held])


def as_first_link(model: Geometry, q: FloatArray, u: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The start of a mechanism that floats with its first link's frame where and as fast as the scene has it: its root
    may be another link."""
    if not floats_by_another(model):
        return q, u
    given = [np.array(model.data["start"][of][0][:2], dtype=float) for of in ("poses", "velocities")]
    at = [i for i, (kind, _) in enumerate(model.data["coordinates"]) if kind in ("x", "y")]
    q, u = q.copy(), u.copy()
    for x, off in ((q, given[0] - model.poses(q)[0, :2]), (u, given[1] - model.velocities(q, u)[0, :2])):
        if np.max(np.abs(off)) > start_miss(model.core.REAL, model.length):
            x[at] += off
    return q, u


def floats_by_another(model: Geometry) -> bool:
    """Whether a mechanism floats, and its root is not its first link."""
    return model.root in model.links and model.links.index(model.root) != 0


def shape_parameters(model: Geometry) -> set[str]:
    """The parameters that say where points are in links and which way lines go: what poses of links depend on."""
    parts = (model.data["outlines"], model.data["lines"], model.data["ground_points"])
    return {one for part in parts for one in _leaves(part) if isinstance(one, str)}


def _leaves(part: Any) -> list[Any]:
    if isinstance(part, Mapping):
        return [leaf for value in part.values() for leaf in _leaves(value)]
    return [leaf for value in part for leaf in _leaves(value)] if isinstance(part, list) else [part]


def going_anew(model: Geometry, q: FloatArray, u: FloatArray) -> Going:
    """The rates that other values of parameters make of the scene's own u.

    Those that the scene gives stay as they are, where loops leave them free, and others are the smallest; where it
    gives more than can stay, all change as little as keeps the loops shut.
    """
    data = model.data["start"]
    weights = _weights(model)
    near = np.zeros_like(u) if data.get("smallest_rates", True) else u.copy()
    floating = [i for i, (kind, _) in enumerate(model.data["coordinates"]) if kind in ("x", "y")]
    near[floating] = u[floating]
    for kept in [kept_rates(model), []]:
        rows, wanted = _rate_rows(model, q, kept, u)
        found = _least_rates(model, rows, wanted, weights, near)
        missed = np.max(np.abs(rows @ found - wanted), initial=0.0)
        if not kept or missed <= start_miss(model.core.REAL, model.length) * rates_miss(u):
            break
    return Going(found, kept, near, weights)


def _rate_rows(model: Geometry, q: FloatArray, kept: list[int], u: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Rows of rates that are given, and what they are: of driven joints, coordinates ``kept``, and loops."""
    rows = np.vstack([drive_rows(model), np.eye(len(u))[kept], model.jacobian(q)])
    return rows, np.concatenate([drive_speeds(model), u[kept], np.zeros(len(model.rows))])


def _least_rates(
    model: Geometry, rows: FloatArray, wanted: FloatArray, weights: FloatArray, near: FloatArray
) -> FloatArray:
    """The rates with the least Σ w (u − near)² of those with rows u = wanted."""
    root, found = np.sqrt(np.diag(weights)), near
    for _ in range(2 if model.precision == "double" else 4):  # solved in doubles, whatever the numbers of the model
        missing = np.asarray(wanted - rows @ found, dtype=float)
        found = found + np.linalg.lstsq(np.asarray(rows / root, dtype=float), missing, rcond=1e-12)[0] / root
    return found


def degrees_of_freedom(model: Geometry) -> int:
    """Quasi-velocities less integrals and the rank of the closure and driven joints, at the scene's start."""
    jacobian = model.jacobian(read_off(model, np.array(model.data["start"]["poses"], dtype=float)))
    rows = np.vstack([jacobian, drive_rows(model) * model.length, integral_rows(model) * model.length])
    coarse = max(1e-9, 100.0 * float(np.finfo(model.core.REAL).eps))
    rank = int(np.linalg.matrix_rank(np.asarray(rows, dtype=float), tol=coarse * model.length)) if len(rows) else 0
    return len(model.u_names) - rank
