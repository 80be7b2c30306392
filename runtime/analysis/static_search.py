"""The way to a configuration at rest: downhill over surfaces, or to the nearest one."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..arrays import FloatArray
from .cones import least_distance
from .contacts import ACROSS, CLOSED, Hold
from .statics import BALANCED, Statics

PASSES = 200
FLAT = 1e-7
"""Stiffnesses below this part of the largest load or stiffness are taken as zero."""
FARTHEST = 0.5
"""Longest step: rad, or lengths of the mechanism."""


def rest_from(statics: Statics, q: FloatArray, nearest: bool) -> tuple[FloatArray, Hold]:
    """A configuration in which loads and contact forces balance, and how contacts hold it.

    Contacts that push are kept closed in a step like loops, contacts that friction can hold are kept from sliding; of
    all others no gap becomes negative. Raises ``ValueError`` where it finds none.
    """
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
    hold = statics.hold(q)
    if statics.residual(q, hold) <= 1e3 * BALANCED:
        return q, hold
    why = "; a mechanism that falls freely has none" if statics.model.root in statics.model.links else ""
    if np.any(hold.closed):
        why = f"; {', '.join(touching(statics, hold))} may push and cannot balance it"
    if not nearest:
        why += "; nearest=True (--nearest) looks for the nearest one, stable or not"
    raise ValueError(
        f"{statics.model.name}: no equilibrium found from here, a part {statics.residual(q, hold):.3g} of the loads is "
        f"left{why}"
    )


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
    stiffness = statics.stiffness(q, hold, statics.pressed(q, hold))
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


def _downhill(statics: Statics, q: FloatArray, hold: Hold, step: FloatArray) -> FloatArray | None:
    """The longest part of ``step`` that goes downhill, or lowers the loads left over; ``None`` where none does."""
    if not np.any(step):
        return None
    before, left = statics.potential(q), statics.residual(q, statics.hold(q))
    for halvings in range(40):
        new = statics.closed(q + step / 2**halvings, hold)
        if new is None:
            continue
        lower = statics.work(q, new) < 0.0 if len(statics.contacts) else statics.potential(new) < before
        if lower or statics.residual(new, statics.hold(new)) < 0.5 * left:
            return new
    return None
