"""Inverse kinematics along a path: one configuration after another, and the rates and accelerations of the motion."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import BoolArray, FloatArray
from ..faults import Faults
from ..model.model import Model, check_model
from ..model.numbers import read_numbers
from ..precision import need_doubles
from .reach import OutOfReach, by_parts, configuration, reached
from .wants import Wanted, Wants, read_wanted

KEPT = 1e-8
"""Rates that leave a larger part of the wanted ones, or of what the mechanism's own make, do not give the motion."""
RANK = 1e-10
"""Singular values below this part of the largest do not count."""


@dataclass(frozen=True, eq=False)
class Followed:
    """Configurations q (n, nq) along a path; of one that was given with its rates u (n, nu) and u_dot (n, nu) too, else
    None."""

    q: FloatArray
    u: FloatArray | None = None
    u_dot: FloatArray | None = None


def follow(
    model: Model,
    q: ArrayLike,
    points: Mapping[str, ArrayLike] | None = None,
    angles: Mapping[str, ArrayLike] | None = None,
    slides: Mapping[str, ArrayLike] | None = None,
) -> Followed:
    """The configurations in which ``points`` go along places (n, 2) in m, links and joints through ``angles`` (n,) in
    rad, and sliding joints through lengths (n,) in m: the first nearest to ``q``, as of :func:`~.reach.reach`, each
    other nearest to the one before. One of the two coordinates of a place may be None, which leaves it open there.

    Given with their first and second derivatives in time, (3, n, 2) and (3, n), all of them, these also give u and u̇:
    from the constraints differentiated, J u = v and J u̇ = a − J̇ u, loops held shut. Where freedoms are left, they are
    the least in joint displacements; q then follows a path of its own. With ``inverse_dynamics`` that is what motors
    must give.

    Between places joints are brought along in parts where they go far. Raises ``OutOfReach`` where a place is out of
    reach, and ``ValueError`` where joints would jump from one branch to another, or no velocities give the wanted
    ones, each with the number of the place. No gap of a contact becomes negative.
    """
    check_model(model)
    need_doubles(model.precision, model.name, "inverse kinematics")
    start = configuration(model, q)
    faults = Faults()
    named = read_wanted(model, points, angles, slides, faults)
    values, rates, left = _read_paths(named, faults)
    first = Wants(model, [one for one, _ in named], values[0], left[0])
    wants = [first.at(*place) for place in zip(values, left, strict=True)]
    rows = [_reached(model, start, first, 0)]
    for number in range(1, len(values)):
        rows.append(_next(model, rows[-1], wants[number], number))
    found = np.array(rows)
    if rates is None:
        return Followed(found)
    moving = [_rates(model, *given, k) for k, given in enumerate(zip(wants, found, *rates, strict=True))]
    return Followed(found, *(np.array(part) for part in zip(*moving, strict=True)))


def _read_paths(
    named: list[tuple[Wanted, Any]], faults: Faults
) -> tuple[FloatArray, tuple[FloatArray, FloatArray] | None, BoolArray]:
    """Values (n, k) along the path, their first and second derivatives where they are given, and which values are left
    open (n, k), which are 0.

    Raises ``ValueError`` with all that is wrong with them, the ``faults`` noted before among it.
    """
    paths: list[FloatArray] = []
    opens: list[BoolArray] = []
    for one, given in named:
        what, shape = f"{one.kind}: {one.name}", ", 2" if one.width == 2 else ","
        with faults.collecting():
            path = read_numbers(given, what)
            plain = 2 if one.width == 2 else 1
            whole = path.ndim in (plain, plain + 1) and path.size > 0 and (plain == 1 or path.shape[-1] == 2)
            left = _left_open(given) if one.width == 2 else np.zeros(path.shape, dtype=bool)
            if not whole or (path.ndim > plain and len(path) != 3) or not np.all(np.isfinite(path) | left):
                deep = shape.rstrip(",")
                raise ValueError(
                    f"{what}: found shape {path.shape}, expected finite numbers (n{shape}), or (3, n{deep}) with first "
                    "and second derivatives in time"
                )
            rows = (*path.shape[: path.ndim - plain + 1], one.width)
            opens.append(_opens(left.reshape(rows), path.ndim > plain, what))
            paths.append(np.where(left, 0.0, path).reshape(rows))
    faults.stop_if_any()
    shapes = {path.shape[:-1] for path in paths}
    if len(shapes) > 1:
        told = ", ".join(f"{one.name} {path.shape[:-1]}" for (one, _), path in zip(named, paths, strict=True))
        raise ValueError(f"points, angles, slides: found {told}, expected equally many places, with rates or without")
    every, open_ = np.concatenate(paths, axis=-1), np.concatenate(opens, axis=-1)
    return (every, None, open_) if every.ndim == 2 else (every[0], (every[1], every[2]), open_)


def _left_open(given: Any) -> BoolArray:
    """Which numbers of what is given of a point are None."""
    return np.asarray(np.frompyfunc(lambda one: one is None, 1, 1)(np.asarray(given, dtype=object)), dtype=bool)


def _opens(left: BoolArray, moving: bool, what: str) -> BoolArray:
    """Which numbers (n, width) are left open, of a point one of two at most; the derivatives of one have to be too.

    Raises ``ValueError`` with the number of the place.
    """
    of = left[0] if moving else left
    for number in np.flatnonzero(of.all(axis=-1)):
        raise ValueError(
            f"{what}: found (None, None) at place {number}, expected (x, y) in m, of which one may be None"
        )
    for number in np.flatnonzero((left != of).any(axis=(0, -1)) if moving else ()):
        raise ValueError(
            f"{what}: found None for a coordinate or a derivative of it alone at place {number}, expected None for the "
            "coordinate and both derivatives, or for none of them"
        )
    return np.asarray(of)


def _reached(model: Model, q: FloatArray, wants: Wants, number: int) -> FloatArray:
    """That of place ``number`` of a path."""
    try:
        return reached(model, q, wants)
    except OutOfReach as error:
        raise OutOfReach(f"place {number}: {error}", error.q, error.misses) from None


def _next(model: Model, q: FloatArray, wants: Wants, number: int) -> FloatArray:
    """The configuration at the next place."""
    found = by_parts(model, q, wants)
    if found is None:
        other = _reached(model, q, wants, number)
        far = float(np.max(np.abs(model.displacements() @ (other - q))))
        raise ValueError(
            f"{model.name}: place {number} is reached on another branch only, {far:.3g} rad or lengths away in the "
            "joints; go another way, or begin elsewhere"
        )
    return found


def _rates(
    model: Model, wants: Wants, q: FloatArray, v: FloatArray, a: FloatArray, number: int
) -> tuple[FloatArray, FloatArray]:
    """u and u̇ (nu,) that give the wanted values these rates v and a (k,), loops shut."""
    rows = np.vstack([model.jacobian(q), wants.rows(q)])
    root = np.linalg.cholesky(_metric(model))
    scaled = np.linalg.solve(root, rows.T).T

    def least(wanted: FloatArray, loops: FloatArray, what: str) -> FloatArray:
        right = np.append(loops, wanted * wants.scale)
        found = np.linalg.solve(root.T, np.linalg.lstsq(scaled, right, rcond=RANK)[0])
        left = float(np.max(np.abs(rows @ found - right)))
        if left > KEPT * max(float(np.max(np.abs(right))), float(np.max(np.abs(rows) @ np.abs(found)))):
            raise ValueError(
                f"{model.name}: no {what} at place {number} give the wanted ones, which are off by {left:.3g} at "
                "least; the mechanism cannot move so there"
            )
        return np.asarray(found)

    u = least(v, np.zeros(len(model.rows)), "velocities")
    loops = model.kernels.of_state("closure_bias", q[None], u[None])[0]
    return u, least(a - wants.bias(q, u[None])[0] / wants.scale, -loops, "accelerations")


def _metric(model: Model) -> FloatArray:
    """Sum of squares of joint displacements as a form (nq, nq)."""
    displacements = model.displacements()
    return displacements.T @ displacements
