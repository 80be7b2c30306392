"""Accelerations along a phase and their derivatives: in flight, and with contacts held (docs/theory.md, eq. 11.6)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .._core import sure_inverses
from ..arrays import BoolArray, FloatArray
from ..model.compiled import Compiled
from ..model.derivatives import INEXACT
from ..model.forces import Held
from ..model.model import Model
from .local import Local, Places
from .moving import Moving

AGAINST = {
    "slides forward": -1.0,
    "slides backward": 1.0,
    "at the limit, forward": -1.0,
    "at the limit, backward": 1.0,
}
"""Friction by the normal force and the coefficient, along the ground, of what is held so."""

BALANCED = 1e-8
"""Forces that do not obey the law which is differentiated by this part of themselves are not those of that law: they
are known to some hundred roundings of a solution whose condition is up to 1e5."""


DEPENDENT = 1e-10
"""Rows count as dependent where singular values fall below this part of the largest: what the core takes for dependent
in doubles (docs/theory.md, section 8)."""


FIXED = 1e-7
"""A contact on which forces act this much less than on the one on which they act most, by the root of what a force
gives its own rate, is one that no force moves, as two links beside their joint do not slide: what is left is rounding,
which is about 1e-16 of the terms of a row. Stops, whose rates are angles, differ from others by the size of the
mechanism in metres."""


SURE = 1e-5
"""Rows are surely independent, and no contact is one that no force moves: far above ``DEPENDENT`` and ``FIXED``."""


def pushing(held: Held) -> list[tuple[int, str]]:
    """Contacts that push, and how each is held."""
    return [(contact, how) for contact, how in held if how != "carried"]


def cannot(held: Held, model: Compiled) -> str:
    """Why the motion with these contacts held has no derivative; empty where it has."""
    for contact, how in held:
        name = "({}, {})".format(*model.contacts[contact])
        if how == "touches":
            return f"{name} touches without pressing: whether it presses is undecided"
        if how == "carried":
            return (
                f"{name} is closed because other contacts or driven joints keep it so: which of them push is not unique"
            )
    return ""


def accelerations(
    model: Model, held: Held, t: FloatArray, q: FloatArray, u: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Accelerations (b, n), multipliers (b, rows) and forces of contacts (b, 2 contacts), normal ones first, at times
    t (b,) and states (b, n), under the inputs that are set."""
    if not held:
        u_dot, multipliers, without = model.kernels.acceleration(q, u, t)
        if without:
            raise _none(model, t, without)
        return u_dot, multipliers, np.zeros((len(q), 2 * len(model.contacts)))
    u_dot, multipliers, pushes, _, _, _, trouble = model.kernels.motion(q, u, t, held)
    if trouble:
        raise _none(model, t, {trouble[0]: trouble[1]})
    return u_dot, np.ascontiguousarray(multipliers), pushes


def jacobians(
    model: Model, moving: Moving, held: Held, t: FloatArray, q: FloatArray, u: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Accelerations (b, n) and their derivatives (b, n, D) by q, u and the arguments, under the inputs that are set."""
    u_dot, found = jacobians_abreast(model, moving, held, t, q, u, 1)
    return u_dot, found.reshape(found.shape[:-1])


def jacobians_abreast(
    model: Model, moving: Moving, held: Held, t: FloatArray, q: FloatArray, u: FloatArray, side: int
) -> tuple[FloatArray, FloatArray]:
    """The same, derivatives (b / side, n, D, side) of as many states side by side."""
    along = moving.directions
    u_dot, found, without, sure = model.kernels.jacobians(
        q, u, t, held, along.by, along.whole(), along.still, along.blocks, along.chosen, side
    )
    if without:
        raise _none(model, t, without)
    if sure:
        return u_dot, found
    u_dot, found = _of_dependent(model, moving, held, t, q, u)
    apart = found.reshape(len(q) // side, side, *found.shape[1:])
    return u_dot, np.ascontiguousarray(np.moveaxis(apart, 1, 3))


def _of_dependent(
    model: Model, moving: Moving, held: Held, t: FloatArray, q: FloatArray, u: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """The same where rows of closure or of contacts may depend on each other."""
    u_dot, multipliers, pushes = accelerations(model, held, t, q, u)
    along = moving.directions
    tangents, missed, without = model.kernels.acceleration_tangents(q, u, t, u_dot, multipliers, along.by, along.blocks)
    if without:
        raise _none(model, t, without)
    if np.any(missed > INEXACT):
        where = float(t[int(np.argmax(missed))])
        raise ValueError(
            f"{model.name}: found closure rows that depend on each other at t = {where:.9g} s, of redundant joints or "
            "of a singular configuration; runs have no derivatives there. Leave out joints that the mechanism does not "
            "need"
        )
    n = len(model.u_names)
    found = np.asarray(along.result(tangents[:, :, :n]))
    if held:
        found = found + _of_contacts(Places(model, moving, t, q), held, u, u_dot, pushes, found)
    return u_dot, found


def _of_contacts(
    at: Places, held: Held, u: FloatArray, u_dot: FloatArray, pushes: FloatArray, free: FloatArray
) -> FloatArray:
    """What the contacts add to the tangents (b, n, D) that accelerations have with their forces held in value and
    place.

    The unknown changes of force keep the rows of the contacts shut: N u_dot + dN/dt u = 0, of what sticks the same
    along the ground.
    """
    model, count = at.model, len(at.model.contacts)
    P, F = (np.ascontiguousarray(part) for part in (pushes[:, :count], pushes[:, count:]))
    set_, how = zip(*pushing(held), strict=True)
    sticks = [contact for contact, one in zip(set_, how, strict=True) if one == "sticks"]
    f, columns = at.pushes_move(P, F), []
    friction = model.kernels.friction
    changes = at.coefficients_move("friction") if any(one in AGAINST for one in how) else np.zeros((count, 0))
    for contact, one in zip(set_, how, strict=True):
        column = at.gap_rows[:, contact]
        if one in AGAINST:
            sign = AGAINST[one]
            _check_friction(at, contact, P[:, contact], F[:, contact], sign * float(friction[contact]))
            slip = at.slip_rows[:, contact]
            column = column + sign * friction[contact] * slip
            f = f + sign * P[:, contact, None, None] * slip[:, :, None] * changes[contact]
        columns.append(column)
    columns += [at.slip_rows[:, contact] for contact in sticks]
    moved = at.response(f)
    answer = at.response(np.stack(columns, axis=2))
    rows = np.concatenate([at.gap_rows[:, list(set_)], at.slip_rows[:, sticks]], axis=1)
    bent = at.gap_rates_move(u_dot, ("q", "k")) + at.tangent("gap_bias", count, u)
    missed = bent[:, list(set_)]
    if sticks:
        along = at.slips_move(u_dot, ("q", "k")) + at.tangent("slip_bias", count, u)
        missed = np.concatenate([missed, along[:, sticks]], axis=1)
    alike = not any(one in AGAINST for one in how)
    matrix, wanted = rows @ answer, rows @ (free + moved) + missed
    sure = well(matrix)
    found = np.zeros_like(wanted)
    found[sure] = np.linalg.solve(matrix[sure], wanted[sure])
    for i in np.flatnonzero(~sure):
        found[i] = solved(Local(at, int(i)), matrix[i], wanted[i], alike=alike)[0]
    return np.asarray(moved - answer @ found)


def well(matrices: FloatArray) -> BoolArray:
    """Which of the matrices (b, k, k) are surely regular, far from where rows count as dependent."""
    return sure_inverses(np.ascontiguousarray(matrices), SURE)[1]


def solved(at: Local, matrix: FloatArray, wanted: FloatArray, *, alike: bool) -> tuple[FloatArray, bool]:
    """The changes of forces or impulses (k, D) that give the rates of contacts ``wanted`` changes, and whether these
    are the only ones.

    Where rows depend on each other these are of least norm, and what moves is unique all the same if forces are where
    rates are, ``alike``: two solutions differ by forces that move nothing. Rows may then miss what is wanted; along
    directions that keep the contacts as they are they do not, which is for the caller to see. Raises ``ValueError``
    where friction at its limit is among them.
    """
    if not len(matrix):
        return np.zeros_like(wanted), True
    if len(matrix) == 1 and matrix[0, 0] > 0.0:
        return wanted / matrix[0, 0], True
    scale = np.sqrt(np.abs(np.diag(matrix)))
    scale[scale <= FIXED * scale.max()] = scale.max() or 1.0
    even = matrix / np.outer(scale, scale)
    left, values, right = np.linalg.svd(even)
    rank = int(np.count_nonzero(values > DEPENDENT * values[0]))
    if rank == len(even):
        return np.asarray(np.linalg.solve(matrix, wanted)), True
    where = f"{at.model.name}: found contacts at t = {at.t:.9g} s whose rows depend on each other, "
    if not alike:
        raise ValueError(
            f"{where}with friction at its limit, so that what each pushes with is not unique; runs have no derivatives "
            "there"
        )
    found: FloatArray = right[:rank].T @ ((left[:, :rank].T @ (wanted / scale[:, None])) / values[:rank, None])
    return np.asarray(found / scale[:, None]), False


def _check_friction(at: Places, contact: int, P: FloatArray, F: FloatArray, ratio: float) -> None:
    wrong = np.abs(F - ratio * P) > BALANCED * np.maximum(np.abs(F), np.abs(ratio * P))
    if wrong.any():
        i = int(np.argmax(wrong))
        name = "({}, {})".format(*at.model.contacts[contact])
        raise ValueError(
            f"{at.model.name}: found friction of {F[i]:.6g} N at {name} at t = {at.t[i]:.9g} s, expected "
            f"{ratio * P[i]:.6g} N, the limit; runs have no derivatives there"
        )


def _none(model: Compiled, t: FloatArray, without: dict[int, str]) -> ValueError:
    state = min(without)
    return no_accelerations(model, float(t[state]), without[state])


def no_accelerations(model: Compiled, t: float, outcome: str) -> ValueError:
    """That a run has no derivatives where there are no accelerations."""
    return ValueError(
        f"{model.name}: found no accelerations at t = {t:.9g} s ({outcome.replace('_', ' ')}); runs have no "
        "derivatives there"
    )


def ways_differ(one: Held, other: Held) -> bool:
    """Whether contacts are held otherwise."""
    return one is not other and list(one) != list(other)


def changed(before: Held, after: Held) -> Sequence[int]:
    """Contacts that slid before and are held otherwise after."""
    now = dict(after)
    return [contact for contact, how in before if how.startswith("slides") and now.get(contact) != how]
