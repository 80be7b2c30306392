"""Static equilibrium: where the loads of a mechanism balance, and whether it stays there."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import chain, combinations
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import BoolArray, FloatArray
from ..model.drives import drive_columns
from ..model.integrators import refuse_integrals
from ..model.loads_of_state import loads_of_state
from ..model.meshes import mesh_forces
from ..model.model import Model, check_model
from ..model.numbers import read_name, read_numbers, told
from ..precision import need_doubles
from .contacts import DEEPEST, Hold, inside
from .static_search import follows, rest_from, smallest
from .statics import Statics

Stability = Literal["stable", "unstable", "indifferent", "undetermined"]

FLUTTER = 1e-4
"""Of the squares of frequencies, the part that is taken as zero: where two meet they are known to the root of the 1e-8
of a stiffness that differences leave."""
LOOSE = 8
"""Contacts closed without force, at most, of which every way to open and stay closed is looked at."""
OPENING = 1e-9
"""Rates of gaps above minus this, along motions of length 1, are not into a surface."""

HELD = (
    "friction holds it here; it rests in a whole range of configurations around this one, and this is the first on "
    "the way from the start"
)
ROUGH = (
    "it rests without friction; by the friction of its contacts it rests in a range of configurations around this one"
)
LIMIT = "friction is at its limit at {}: less of it, or more load, and it slides"
FOLLOWING = (
    "loads that follow the motion have no potential: stiffnesses are those of the symmetric part, and unstable is also "
    "what flutters without damping"
)
RATES = (
    "{} {} on rates, which are zero here: stiffnesses do not tell whether it is stable, the poles of linearise do, "
    "np.linalg.eigvals(linearise(model, rest.q).A)"
)
OPEN = (
    "{} {} on the state and {} no potential: stiffnesses are those of the symmetric part, and do not tell whether it "
    "is stable; the poles of linearise do, np.linalg.eigvals(linearise(model, rest.q).A)"
)
SHARED = "contact forces are not unique: those of least norm are given, with the range of each"


@dataclass(frozen=True)
class Equilibrium:
    """A configuration ``q`` (nq,) in which the mechanism stays at rest.

    ``stiffness`` (freedoms,): eigenvalues, rising, of the reduced Hessian of the potential over orthonormal motions
    that keep loops shut, contacts that push closed, and those that friction holds from sliding. All positive: stable.
    One negative: unstable. Otherwise indifferent, or not to be told from the stiffness: so are rest at the very limit
    of friction, and contacts closed without force that bar motions of negative stiffness. Where loads are expressions
    of the state with rates in them, which are zero here, or without a potential, it is undetermined: the poles of
    :func:`.linearise` tell.
    ``reactions`` (joints, 3): force and moment on each joint's second link. ``residual``: generalized force left
    over, relative to the loads.

    ``closed`` are the (point, ground) names of the contacts that are closed. ``contact_forces`` (contacts, 2), in the
    order of the model's ``contacts``, are normal force and friction, the latter along the normal turned clockwise, on
    the point or the first disc, in N (of stops in N m); 0 where open. ``ranges`` (contacts, 2, 2) are the lowest and
    highest value that each can have; they differ where forces are not ``unique``, and ``inf`` is one without a bound.
    ``meshes`` (meshes,) are the tangential forces (N) of gears, racks and belts, in the order of their rows.
    ``note`` says in words what a rest on contacts leaves open, or loads without a potential do; it is empty where that
    is nothing. Under such loads, forces that turn with a link, ``stiffness`` is that of the symmetric part, and stable
    is what neither falls nor, without damping, flutters.
    """

    q: FloatArray
    stability: Stability
    stiffness: FloatArray
    reactions: FloatArray
    residual: float
    closed: tuple[tuple[str, str], ...]
    contact_forces: FloatArray
    ranges: FloatArray
    note: str
    meshes: FloatArray

    @property
    def unique(self) -> bool:
        """Whether the contact forces are the only ones that balance the loads."""
        return bool(np.all(self.ranges[..., 0] == self.ranges[..., 1]))


def static_equilibrium(
    model: Model,
    q: ArrayLike | None = None,
    torques: Mapping[str, float] | None = None,
    *,
    nearest: bool = False,
) -> Equilibrium:
    """An equilibrium under the loads of ``model`` at t = 0 and constant ``torques`` (N m) at joints, from ``q``.

    At a joint that slides, the number is a force (N) on its second link along the line. Neither is part of the joint's
    reaction.
    Effects that ``[start] off`` names are absent.
    Driven joints are held where they are in ``q``, by the moment (the force along the line) of their reactions.
    Grounds, stops and touches are kept: no gap is negative, contacts only push, and only those that are closed.
    The search begins at the scene's start unless ``q`` is given, and goes downhill to a stable equilibrium; with
    ``nearest`` it goes to a near one, stable or not. Friction holds a mechanism in a whole range of configurations:
    the first one that it holds, on a way downhill on which contacts slide or stick, is given. Raises ``ValueError``
    where it finds none, as for a mechanism that falls freely, where ``q`` is behind a surface, and where a motor has an
    integral.
    """
    check_model(model)
    need_doubles(model.precision, model.name, "an equilibrium")
    refuse_integrals(model)
    if torques is not None and not isinstance(torques, Mapping):
        raise TypeError(f"torques: found {told(torques)}, expected numbers by names of joints")
    if not isinstance(nearest, bool | np.bool_):
        raise TypeError(f"nearest: found {told(nearest)}, expected True or False")
    given = {read_name(joint, "torques", "a joint"): torque for joint, torque in (torques or {}).items()}
    for drive in model.data["drives"]:
        if drive["joint"] in given:
            raise ValueError(f"torques: found {drive['joint']}, which a drive holds, expected joints that are free")
    held = np.zeros(len(model.u_names))
    if given:
        held = drive_columns(model, list(given), "torques") @ read_numbers(list(given.values()), "torques")
    if not np.all(np.isfinite(held)):
        raise ValueError(f"torques: found {given}, expected finite numbers")
    first = model.start()[0] if q is None else model.assemble(q)
    if np.ndim(first) != 1:
        raise ValueError(f"q: found shape {np.shape(first)}, expected one configuration ({len(model.q_names)},)")
    if depth := inside(model, first, DEEPEST):
        raise ValueError(f"q: found {depth}, expected a configuration outside all surfaces; begin elsewhere")
    statics = Statics(model, held, first, given)
    found, hold = rest_from(statics, first, nearest)
    stability, values = _judge(statics, found, hold)
    return Equilibrium(
        found,
        stability,
        values,
        statics.reactions(found, hold.forces),
        statics.residual(found, hold),
        tuple(model.contacts[k] for k in np.flatnonzero(hold.closed)),
        hold.forces,
        hold.ranges,
        _note(statics, found, hold),
        mesh_forces(model, statics.multipliers(found, hold.forces)),
    )


def _judge(statics: Statics, q: FloatArray, hold: Hold) -> tuple[Stability, FloatArray]:
    """Whether it stays there, and the stiffnesses (freedoms,)."""
    form = statics.stiffness(q, hold, hold.forces)
    values: FloatArray = np.asarray(np.linalg.eigvalsh(form), dtype=float)
    least = smallest(statics, q, values)
    stability: Stability = "stable" if np.all(values > least) else "indifferent"
    loose = hold.closed & ~hold.pushing
    if np.any(values < -least) and (not np.any(loose) or _falls(statics, q, hold, form, loose, -least)):
        stability = "unstable"
    elif np.any(hold.limited):
        stability = "indifferent"
    of_state = loads_of_state(statics.model)
    if any(of_state.values()) or (of_state and follows(statics, q, hold)):
        return "undetermined", values
    if follows(statics, q, hold):
        return _judge_following(statics, q, hold), values
    return stability, values


def _judge_following(statics: Statics, q: FloatArray, hold: Hold) -> Stability:
    """Whether it stays where loads have no potential: by the squares of the frequencies of its small motions without
    damping, which flutter where these are complex, and fall where they are negative (Ziegler, 1968)."""
    motions = statics.motions(q, hold)
    mass = motions.T @ statics.model.mass_matrix(q) @ motions
    squares = np.linalg.eigvals(np.linalg.solve(mass, statics.tangent(q, hold, hold.forces)))
    small = FLUTTER * float(np.max(np.abs(squares), initial=0.0))
    if np.any(squares.real < -small) or np.any(np.abs(squares.imag) > small):
        return "unstable"
    return "stable" if np.all(squares.real > small) and not np.any(hold.limited) else "indifferent"


def _falls(statics: Statics, q: FloatArray, hold: Hold, form: FloatArray, loose: BoolArray, below: float) -> bool:
    """Whether some motion on which no ``loose`` contact closes has a stiffness ``below``.

    The least stiffness over such motions is an eigenvalue where some of these contacts stay closed and all others open.
    """
    motions = statics.motions(q, hold)
    rows = (statics.contacts.normals(q) / statics.contacts.sizes[:, None])[loose] @ motions
    count = range(len(rows)) if len(rows) <= LOOSE else ()
    for shut in chain.from_iterable(combinations(count, k) for k in range(len(rows) + 1)):
        face = np.eye(len(form))
        if shut:
            _, sizes, right = np.linalg.svd(rows[list(shut)])
            face = right[int(np.sum(sizes > OPENING)) :].T
        values, directions = np.linalg.eigh(face.T @ form @ face)
        for motion in (face @ directions[:, values < below]).T:
            if any(np.all(sign * rows @ motion >= -OPENING) for sign in (1.0, -1.0)):
                return True
    return False


def _note(statics: Statics, q: FloatArray, hold: Hold) -> str:
    """What a rest on contacts, or under loads that follow, leaves open."""
    parts = []
    if statics.motions(q, hold.slipping()).shape[1] > statics.motions(q, hold).shape[1]:
        parts.append(ROUGH if statics.rests_smooth(q) else HELD)
    if np.any(hold.limited):
        names = [f"{point} on {ground}" for point, ground in statics.model.contacts]
        parts.append(LIMIT.format(", ".join(names[k] for k in np.flatnonzero(hold.limited))))
    of_state = loads_of_state(statics.model)
    if rated := [name for name, rates in of_state.items() if rates]:
        parts.append(RATES.format(" and ".join(rated), "depends" if len(rated) == 1 else "depend"))
    elif follows(statics, q, hold):
        one = len(of_state) == 1
        told = " and ".join(of_state), "depends" if one else "depend", "has" if one else "have"
        parts.append(OPEN.format(*told) if of_state else FOLLOWING)
    if np.any(hold.ranges[..., 0] != hold.ranges[..., 1]):
        parts.append(SHARED)
    return "; ".join(parts)
