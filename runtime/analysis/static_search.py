"""The way to a configuration at rest: downhill over surfaces, or to the nearest one."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..arrays import FloatArray
from .cones import least_distance
from .contacts import ACROSS, CLOSED, Hold
from .statics import BALANCED, NODES, Statics

PASSES = 200
FLAT = 1e-7
"""Stiffnesses below this part of the largest load or stiffness are taken as zero."""
TURNING = 1e-6
"""Of stiffness and loads, the part by which the first is not symmetric through differences alone, over steps of 1e-6 in
which loads lose ten digits; more comes of loads that follow."""
MOST, MOVES = 3, 0.1
"""How many coordinates are named that what is left of the loads moves, and which part of the most each moves."""
UPHILL = 0.5
"""A step ends where the loads bar the way half as hard as they pull along it at first: a lowest place lies behind."""
FARTHEST = 0.5
"""Longest step: rad, or lengths of the mechanism."""


def rest_from(statics: Statics, q: FloatArray, nearest: bool) -> tuple[FloatArray, Hold]:
    """A configuration in which loads and contact forces balance, and how contacts hold it.

    Contacts that push are kept closed in a step like loops, contacts that friction can hold are kept from sliding; of
    all others no gap becomes negative. Where the way downhill ends without a balance, and loads have no potential, so
    that there may be no lowest place, the nearest balance is looked for. Raises ``ValueError`` where it finds none.
    """
    found, hold = _way_from(statics, q, nearest)
    if statics.residual(found, hold) <= 1e3 * BALANCED:
        return found, hold
    if not nearest and follows(statics, found, hold):
        for begin in (found, q):
            other, held = _way_from(statics, begin, True)
            if statics.residual(other, held) <= 1e3 * BALANCED:
                return other, held
    why = "; a mechanism that falls freely has none" if statics.model.root in statics.model.links else ""
    if np.any(hold.closed):
        why = f"; {', '.join(touching(statics, hold))} may push and cannot balance it"
    if not nearest:
        why += "; nearest=True (--nearest) looks for the nearest one, stable or not"
    left = f"a part {statics.residual(found, hold):.3g} of the loads is left{_moved(statics, found, hold)}"
    raise ValueError(f"{statics.model.name}: no equilibrium found from here, {left}{why}")


def _way_from(statics: Statics, q: FloatArray, nearest: bool) -> tuple[FloatArray, Hold]:
    """Where the way from ``q`` ends, and how contacts hold it there."""
    for _ in range(PASSES):
        hold = statics.hold(q)
        if statics.ajar(q, hold):
            new = statics.closed(q, hold)
            if new is None:
                break
            q, hold = new, statics.hold(new)
        balanced = statics.residual(q, hold) <= BALANCED
        if balanced and nearest:
            return q, hold
        if balanced:
            new = _off_a_crest(statics, q, hold)
            if new is None:
                return q, hold
        elif nearest:
            new = _nearer(statics, q, hold)
        else:
            new = next((low for way in _ways(hold) if (low := _lower(statics, q, way)) is not None), None)
        if new is None:
            break
        q = new
    return q, statics.hold(q)


def follows(statics: Statics, q: FloatArray, hold: Hold) -> bool:
    """Whether loads have no potential there, as forces that turn with a link."""
    tangent = statics.tangent(q, hold, hold.forces)
    size = max(float(np.max(np.abs(tangent), initial=0.0)), statics.scale(q))
    return bool(np.max(np.abs(tangent - tangent.T), initial=0.0) > TURNING * size)


def _moved(statics: Statics, q: FloatArray, hold: Hold) -> str:
    """Which coordinates move most along what is left of the loads."""
    motions = statics.motions(q, hold)
    share = np.abs(motions @ (motions.T @ statics.force(q)))
    names = [statics.model.q_of[k] for k in np.argsort(-share, kind="stable")[:MOST] if share[k] > MOVES * share.max()]
    return f", along {' and '.join(names)}" if names else ""


def touching(statics: Statics, hold: Hold) -> list[str]:
    """Names of closed contacts."""
    names = [f"{point} on {ground}" for point, ground in statics.model.contacts]
    return [names[k] for k in np.flatnonzero(hold.closed)]


def smallest(statics: Statics, q: FloatArray, values: FloatArray) -> float:
    """A stiffness that is taken as zero, beside others with these ``values``."""
    return FLAT * max(float(np.max(np.abs(values), initial=0.0)), statics.scale(q))


def _ways(hold: Hold) -> Iterator[Hold]:
    """With what sticks, then with all contacts sliding."""
    yield hold
    if np.any(hold.sticking):
        yield hold.slipping()


def _off_a_crest(statics: Statics, q: FloatArray, hold: Hold) -> FloatArray | None:
    """A step off a crest, either way; ``None`` where this is none, or where contacts bar both."""
    motions = statics.motions(q, hold)
    values, directions = np.linalg.eigh(statics.stiffness(q, hold, hold.forces))
    if not values.size or values[0] >= -smallest(statics, q, values):
        return None
    step = 0.1 * motions @ directions[:, 0]
    if not len(statics.contacts):
        return statics.closed(q + step, hold)
    for sign in (1.0, -1.0):
        new = statics.closed(q + _kept_out(statics, q, hold, sign * step, motions), hold)
        if new is not None and statics.work(q, new) < 0.0:
            return new
    return None


def _nearer(statics: Statics, q: FloatArray, hold: Hold) -> FloatArray | None:
    """One of Newton's steps towards the balance."""
    motions = statics.motions(q, hold)
    left = motions.T @ statics.force(q)
    stiffness = statics.tangent(q, hold, statics.pressed(q, hold))
    step = -_bounded(statics, motions @ np.linalg.lstsq(stiffness, left, rcond=1e-12)[0])
    return statics.closed(q + _kept_out(statics, q, hold, step, motions), hold)


def _lower(statics: Statics, q: FloatArray, hold: Hold) -> FloatArray | None:
    """One of Newton's steps downhill: along directions of negative curvature as if it were positive."""
    motions = statics.motions(q, hold)
    left = motions.T @ statics.force(q)
    values, directions = np.linalg.eigh(statics.stiffness(q, hold, statics.pressed(q, hold)))
    curved = np.maximum(np.abs(values), 1e-6 * float(np.max(np.abs(values), initial=0.0)) + 1e-300)
    step = -_bounded(statics, motions @ (directions @ ((directions.T @ left) / curved)))
    if len(statics.contacts):
        step = _landing(statics, q, step)
        step = _kept_out(statics, q, hold, step, motions @ (directions / np.sqrt(curved / curved.max(initial=1e-300))))
    return _downhill(statics, q, hold, step)


def _bounded(statics: Statics, step: FloatArray) -> FloatArray:
    turns = np.array([kind == "angle" for kind, _ in statics.model.data["coordinates"]])
    size = np.abs(step) / np.where(turns, 1.0, statics.model.length)
    return step * min(1.0, FARTHEST / max(float(np.max(size, initial=0.0)), 1e-300))


def _landing(statics: Statics, q: FloatArray, step: FloatArray) -> FloatArray:
    """The part of ``step`` up to where a rough contact closes: friction may hold it there."""
    contacts = statics.contacts
    gaps = -contacts.depths(q)
    coming = -(contacts.normals(q) @ step) / contacts.sizes
    hits = (contacts.friction > 0.0) & (gaps > CLOSED) & (coming > gaps)
    return step * float(np.min(gaps[hits] / coming[hits], initial=1.0))


def _kept_out(statics: Statics, q: FloatArray, hold: Hold, step: FloatArray, spread: FloatArray) -> FloatArray:
    """``step`` and as little of ``spread`` (nu, k) as keeps gaps from becoming negative, surfaces taken as flat."""
    contacts = statics.contacts
    if not len(contacts):
        return step
    rows = contacts.normals(q) / contacts.sizes[:, None]
    along = rows @ spread
    other = np.linalg.norm(along, axis=1) > ACROSS * np.linalg.norm(rows, axis=1) * np.linalg.norm(spread)
    other &= ~hold.pushing
    gaps = np.maximum(-contacts.depths(q), 0.0)
    change = least_distance(along[other], (-gaps - rows @ step)[other])
    return 0.0 * step if change is None else step + spread @ change


def _short(statics: Statics, q: FloatArray, step: FloatArray) -> FloatArray:
    """``step`` up to where the way leads uphill: one through the air may lead over what would hold the mechanism."""
    slopes = statics.slopes(q, q + step)
    bars = np.flatnonzero(slopes > UPHILL * abs(float(statics.force(q) @ step)))
    return step * float(NODES[bars[0]]) if bars.size else step


def _downhill(statics: Statics, q: FloatArray, hold: Hold, step: FloatArray) -> FloatArray | None:
    """The longest part of ``step`` that goes downhill, or lowers the loads left over; ``None`` where none does."""
    if not np.any(step):
        return None
    step, left = _short(statics, q, step), statics.residual(q, statics.hold(q))
    for halvings in range(40):
        new = statics.closed(q + step / 2**halvings, hold)
        if new is None:
            continue
        if statics.work(q, new) < 0.0 or statics.residual(new, statics.hold(new)) < 0.5 * left:
            return new
    return None
