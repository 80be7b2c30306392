"""Derivatives of what a model computes, by its coordinates, rates, time, inputs and parameters (theory, section 11)."""

from __future__ import annotations

from collections.abc import Sized

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import FloatArray
from .directions import Directions, Wrt, directions_of
from .dynamics import read_times
from .forces import Contacts, no_motion
from .geometry import Geometry
from .inputs import Values
from .numbers import told
from .start import start

SOLVED = ("acceleration", "multipliers", "reactions", "power")
"""What depends on the accelerations that the equations of motion have."""

INEXACT = 1e-7
"""Rows that depend on others miss by less than this, relative to what they are to be, where directions are those of
a motion."""


def derivatives(
    model: Geometry,
    of: str,
    q: ArrayLike,
    u: ArrayLike,
    t: ArrayLike,
    inputs: Values | None,
    wrt: Wrt,
    contacts: Contacts,
) -> FloatArray:
    """The derivatives of one function at a state or a batch of states, its columns last."""
    _check(model, of, contacts)
    states, single = model._state(q, u)
    times = read_times(t, len(states[0]))
    along = directions_of(model, wrt)
    with model.given(inputs):
        if of in SOLVED and contacts is None and model.contacts and model.kernels.closed(states[0]).any():
            raise ValueError(
                f"{of}: found a closed contact, expected none: derivatives are those of flight; open it, or leave "
                "contacts out with contacts=()"
            )
        found = under_inputs(model, of, *states, times, along)
    if not np.all(np.isfinite(found)):
        raise ValueError(
            f"{of}: found no finite derivative here, expected one: a root or a quotient of the equations has none at "
            "this state"
        )
    return found[0] if single else found


def need_derivatives(model: Geometry) -> None:
    """Raise ``ValueError`` for a model that was generated without its derivatives."""
    if model.kernels.derivatives is None:
        raise ValueError(
            f"{model.name}: found a model without derivatives, expected one with them; generate it with "
            "generate(scene, derivatives=True) or ccgen --scene FILE --derivatives"
        )


def _check(model: Geometry, of: str, contacts: Contacts) -> None:
    need_derivatives(model)
    shapes = shapes_of(model)
    if not isinstance(of, str) or of not in shapes:
        raise ValueError(f"of: found {told(of)}, expected one of {', '.join(shapes)}")
    sized = isinstance(contacts, Sized) and not isinstance(contacts, np.ndarray)
    if contacts is not None and (not sized or len(contacts)):
        raise ValueError(f"contacts: found {told(contacts)}, expected () or None: derivatives are those of flight")


def shapes_of(model: Geometry) -> dict[str, tuple[int, ...]]:
    """What there are derivatives of, and the shape of each at one state."""
    n, rows, contacts = len(model.u_names), len(model.rows), len(model.contacts)
    return {
        "acceleration": (n,),
        "multipliers": (rows,),
        "reactions": (len(model.joints), 3),
        "closure": (rows,),
        "closure_rate": (rows,),
        "gaps": (contacts,),
        "gap_rates": (contacts,),
        "poses": (len(model.links), 3),
        "velocities": (len(model.links), 3),
        "points": (model.kernels.sizes["points"], 2),
        "energy": (2,),
        "power": (),
        "outputs": (len(model.told),),
    }


def under_inputs(
    model: Geometry, of: str, q: FloatArray, u: FloatArray, t: float | FloatArray, along: Directions
) -> FloatArray:
    """The same at states q, u (b, n), in flight, under the inputs that are set."""
    shape = (len(q), *shapes_of(model)[of], len(along.columns))
    if not along.columns or 0 in shape:
        return np.zeros(shape, dtype=model.core.REAL)
    n, rows = len(model.u_names), len(model.rows)
    if of not in SOLVED:
        none = np.zeros((len(q), n), dtype=model.core.REAL), np.zeros((len(q), rows + 1), dtype=model.core.REAL)
        return _of_functions(model, of, q, u, t, none, along, None).reshape(shape)
    solution, tangents = _accelerated(model, of, q, u, t, along)
    if of == "acceleration":
        return np.array([along.result(one[:, :n]) for one in tangents])
    if of == "multipliers":
        return np.array([along.result(one[:, n:]) for one in tangents])
    return _of_functions(model, of, q, u, t, solution, along, tangents).reshape(shape)


def _of_functions(
    model: Geometry,
    of: str,
    q: FloatArray,
    u: FloatArray,
    t: float | FloatArray,
    solution: tuple[FloatArray, FloatArray],
    along: Directions,
    tangents: FloatArray | None,
) -> FloatArray:
    """Of a generated function, state by state; with the ``tangents`` of the accelerations where it reads these."""
    n = len(model.u_names)
    size, columns = int(np.prod(shapes_of(model)[of], dtype=int)), len(along.columns)
    times = np.array(np.broadcast_to(np.asarray(t, dtype=model.core.REAL), (len(q),)))
    pushes = np.zeros(2 * len(model.contacts) + 1, dtype=model.core.REAL)
    by, roomy = along.whole(), np.tile(pushes, (len(q), 1))
    if tangents is None:
        found = model.kernels.tangents(of, q, u, times, *solution, roomy, by, along.blocks)
        return np.zeros((len(q), size, columns)) if found is None else along.result(found)
    each = np.zeros((len(q), size, columns), dtype=model.core.REAL)
    for i in range(len(q)):
        by["u_dot"] = np.ascontiguousarray(tangents[i][:, :n])
        by["multipliers"] = np.ascontiguousarray(tangents[i][:, n:])
        part = slice(i, i + 1)
        given = q[part], u[part], times[part], solution[0][part], solution[1][part], roomy[part]
        one = model.kernels.tangents(of, *given, by, along.blocks)
        if one is not None:
            each[i] = along.result(one[0])
    return each


def _accelerated(
    model: Geometry, of: str, q: FloatArray, u: FloatArray, t: float | FloatArray, along: Directions
) -> tuple[tuple[FloatArray, FloatArray], FloatArray]:
    """Accelerations and multipliers (with a number of room behind), and their tangents (b, blocks, n + rows, lanes)."""
    u_dot, multipliers, without = model.kernels.acceleration(q, u, t, side_by_side=False)
    if without:
        raise no_motion(model, min(without), without[min(without)])
    tangents, missed, without = model.kernels.acceleration_tangents(q, u, t, u_dot, multipliers, along.by, along.blocks)
    if without:
        raise no_motion(model, min(without), without[min(without)])
    for i in np.flatnonzero(missed >= 0.0):
        _check_rows(model, of, q[i], float(missed[i]))
    roomy = np.hstack([multipliers, np.zeros((len(q), 1), dtype=multipliers.dtype)])
    return (u_dot, roomy), tangents


def _check_rows(model: Geometry, of: str, q: FloatArray, missed: float) -> None:
    """Raise where rows depend on each other, and the derivative is none, or not that one.

    Where their number of independent ones is that of the start, joints are redundant: accelerations have derivatives
    along motions that keep loops shut. Where it is less, the configuration is singular, and they have none.
    """
    n = len(model.q_names)
    rank = n - len(model.kernels.motions(np.ascontiguousarray(q)))
    if rank == len(model.kernels.rows_on) + model.kernels.sizes["drives"]:
        return
    if rank < n - len(model.kernels.motions(start(model)[0])):
        raise ValueError(
            f"{of}: found a singular configuration, in which closure rows depend on each other that do not elsewhere; "
            "accelerations have no derivatives there"
        )
    if missed > INEXACT:
        raise ValueError(
            f"{of}: found directions that open loops which redundant joints close, expected such as keep them shut: "
            'those of motions, as wrt={"q": model.motions(q)}'
        )
    if of != "acceleration":
        raise ValueError(
            f"{of}: found redundant joints, whose forces are those of least norm; derivatives are those of "
            "accelerations there, and of what does not depend on forces"
        )
