"""The motions that lead on from where a loop lies in a line, for who has given velocities that are those of none."""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray
from .drives import drive_rows, drive_speeds
from .model import Model

LOST, LOST_IN_FLOATS = 2e-5, 1e-2
"""Part of the largest singular value of the closure below which another is none: the core asks velocities there."""
ROUNDED = 1e-8
"""Part of the largest by which other changes of rows are rounding."""
APART = 1e-3
"""How far, in units of coordinates, rows are looked at beside a configuration."""
ALIKE = 1e-6
"""Part of the fastest link by which the angular velocities of one differ where they tell motions apart."""


def ways_on(model: Model, q: FloatArray, u: FloatArray) -> str:
    """Why a run cannot begin with velocities ``u`` (nu,) where a loop lies in a line at ``q`` (nq,).

    It names the angular velocities (rad/s) that tell the two motions from there apart, if there are two: those that
    leave the lost row as it is (docs/theory, eq. 8.4), nearest to ``u``, the link that turns fastest as fast as it
    does, which is given as a rule (what was given is not known here), and driven joints as they are to be.
    """
    told = "a loop lies in a line, and these velocities are those of neither motion that leads on from there"
    ways = [model.velocities(q, way)[:, 2] for way in _tangents(model, q, u)]
    links = list(model.links)
    fastest = max((float(np.abs(way).max()) for way in ways), default=0.0)
    apart = [k for k in range(len(links)) if len(ways) == 2 and abs(ways[0][k] - ways[1][k]) > ALIKE * fastest]
    if not apart:
        return f"{told}; give the angular velocities of more links, or start a little beside it"
    one, other = (", ".join(f"{links[k]} {_shown(way[k], fastest)}" for k in apart) for way in ways)
    names = " or ".join(links[k] for k in apart)
    return f"{told}, with angular velocities {one} or {other} rad/s; give that of {names} as well"


def _shown(rate: float, fastest: float) -> str:
    """A rate, without what is rounding of the fastest."""
    return f"{rate if abs(rate) > ALIKE * fastest else 0.0:.6g}"


def _tangents(model: Model, q: FloatArray, u: FloatArray) -> list[FloatArray]:
    """The velocities nearest to ``u`` on each of two branches, with the fastest link as fast where the branch has such;
    none where not two of them cross."""
    unit = model.coordinate_units

    def rows(at: FloatArray) -> FloatArray:
        return np.asarray(model.jacobian(at), dtype=float) * unit

    A = rows(q)
    left, sizes, right = np.linalg.svd(A)
    least = LOST_IN_FLOATS if np.float32 == model.core.REAL else LOST
    rank = int(np.sum(sizes > least * sizes[0]))
    K, N = right[rank:].T, left[:, rank:]
    if not K.shape[1] or not N.shape[1]:
        return []
    form = np.array([N.T @ (rows(q + APART * unit * k) - rows(q - APART * unit * k)) @ K / (2.0 * APART) for k in K.T])
    lost = np.linalg.svd(form.transpose(1, 0, 2).reshape(N.shape[1], -1))
    if np.sum(lost[1] > ROUNDED * lost[1][0]) != 1:  # several rows are lost together
        return []
    B = np.einsum("j,ijk->ik", lost[0][:, 0], form)
    values, vectors = np.linalg.eigh(0.5 * (B + B.T))
    if np.sum(np.abs(values) > APART * np.abs(values).max()) != 2 or values[0] * values[-1] >= 0.0:
        return []
    above, below = np.sqrt(values[-1]) * vectors[:, -1], np.sqrt(-values[0]) * vectors[:, 0]
    drives = drive_rows(model) * unit @ K
    turns = model.velocities(q, u)[:, 2]
    fastest = int(np.argmax(np.abs(turns)))
    kept = np.array([model.velocities(q, unit * k)[fastest, 2] for k in K.T])
    found = []
    for normal in (above + below, above - below):
        told = np.vstack([normal[None], drives]), np.concatenate([[0.0], drive_speeds(model)])
        with_fastest = np.vstack([told[0], kept[None]]), np.concatenate([told[1], [turns[fastest]]])
        for fixed, rates in (with_fastest, told):
            z = K.T @ (u / unit)
            z += np.linalg.lstsq(fixed, rates - fixed @ z, rcond=None)[0]
            if np.allclose(fixed @ z, rates, atol=ALIKE * max(1.0, float(np.abs(z).max()))):
                found.append(unit * (K @ z))
                break
    return found
