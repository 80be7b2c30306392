"""Static equilibrium: where the loads of a mechanism balance, and whether it stays there."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from .analysis import free_motions
from .drives import drive_columns, drive_rows
from .frames import FloatArray
from .model import Model
from .precision import need_doubles

Stability = Literal["stable", "unstable", "indifferent"]

PASSES = 200
BALANCED = 1e-10
"""Loads balance when what is left along the free motions is smaller than this part of them."""
FLAT = 1e-7
"""Stiffnesses below this part of the largest load or stiffness are taken as zero."""
FARTHEST = 0.5
"""Longest step (rad, m)."""


@dataclass(frozen=True)
class Equilibrium:
    """A configuration ``q`` (nq,) in which the mechanism stays at rest.

    ``stiffness`` (freedoms,): eigenvalues of the reduced Hessian of the potential over orthonormal free motions,
    rising. All positive: stable. One negative: unstable. Otherwise indifferent, or not to be told from the stiffness.
    ``reactions`` (joints, 3): force and moment on each joint's outboard link. ``residual``: generalized force left
    over, relative to the loads.
    """

    q: FloatArray
    stability: Stability
    stiffness: FloatArray
    reactions: FloatArray
    residual: float


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
    Driven joints are held where they are in ``q``, by the moment (the force along the line) of their reactions.
    The search begins at the scene's start unless ``q`` is given, and goes downhill to a stable equilibrium; with
    ``nearest`` it goes to a near one, stable or not. Raises ``ValueError`` where it finds none, as for a mechanism that
    falls freely.
    """
    need_doubles(model.precision, model.name, "an equilibrium")
    given = dict(torques or {})
    for drive in model.data["drives"]:
        if drive["joint"] in given:
            raise ValueError(f"torques: found {drive['joint']}, which a drive holds, expected joints that are free")
    held = np.zeros(len(model.u_names))
    if given:
        held = drive_columns(model, list(given)) @ np.array(list(given.values()), dtype=float)
    if not np.all(np.isfinite(held)):
        raise ValueError(f"torques: found {given}, expected finite numbers")
    first = model.start()[0] if q is None else model.assemble(q)
    if np.ndim(first) != 1:
        raise ValueError(f"q: found shape {np.shape(first)}, expected one configuration ({len(model.q_names)},)")
    statics = _Statics(model, held, first, given)
    found = _search(statics, first, nearest)
    values: FloatArray = np.asarray(np.linalg.eigvalsh(statics.stiffness(found)), dtype=float)
    smallest = FLAT * max(float(np.max(np.abs(values), initial=0.0)), statics.scale(found))
    stability: Stability = "stable" if np.all(values > smallest) else "indifferent"
    if np.any(values < -smallest):
        stability = "unstable"
    return Equilibrium(found, stability, values, statics.reactions(found), statics.residual(found))


def _search(statics: _Statics, q: FloatArray, nearest: bool) -> FloatArray:
    for _ in range(PASSES):
        motions = free_motions(statics.model, q)
        left = motions.T @ statics.force(q)
        balanced = statics.residual(q) <= BALANCED
        if balanced and nearest:
            return q
        stiffness = statics.stiffness(q)
        values, directions = np.linalg.eigh(stiffness)
        if balanced:
            least = FLAT * max(float(np.max(np.abs(values), initial=0.0)), statics.scale(q))
            if not values.size or values[0] >= -least:
                return q
            new = statics.closed(q + 0.1 * motions @ directions[:, 0])  # off a crest, either way
        elif nearest:
            new = statics.closed(q - _bounded(motions @ np.linalg.lstsq(stiffness, left, rcond=1e-12)[0]))
        else:
            curved = np.maximum(np.abs(values), 1e-6 * float(np.max(np.abs(values), initial=0.0)) + 1e-300)
            new = _downhill(statics, q, -_bounded(motions @ (directions @ ((directions.T @ left) / curved))))
        if new is None:
            break
        q = new
    if statics.residual(q) <= 1e3 * BALANCED:
        return q
    why = "; a mechanism that falls freely has none" if statics.model.root in statics.model.links else ""
    raise ValueError(
        f"{statics.model.name}: no equilibrium found from here, a part {statics.residual(q):.3g} of the loads is "
        f"left{why}"
    )


def _bounded(step: FloatArray) -> FloatArray:
    return step * min(1.0, FARTHEST / max(float(np.max(np.abs(step), initial=0.0)), 1e-300))


def _downhill(statics: _Statics, q: FloatArray, step: FloatArray) -> FloatArray | None:
    """The longest part of ``step`` that lowers the potential, or the loads left over; ``None`` where none does."""
    before, left = statics.potential(q), statics.residual(q)
    for halvings in range(40):
        new = statics.closed(q + step / 2**halvings)
        if new is not None and (statics.potential(new) < before or statics.residual(new) < 0.5 * left):
            return new
    return None


@dataclass(frozen=True)
class _Statics:
    """Generalized forces at rest, ``held`` (nu,) being those of the torques.

    Driven joints are where they are in ``first`` (nq,).
    """

    model: Model
    held: FloatArray
    first: FloatArray
    torques: Mapping[str, float]

    def force(self, q: FloatArray) -> FloatArray:
        """Gradient of the potential less the torques: what holding still would take, (nu,)."""
        return self._open(q) - self.held

    def _open(self, q: FloatArray) -> FloatArray:
        rest = np.zeros((1, len(q)))
        return np.asarray(self.model.kernels.inverse_dynamics(q[None], rest, 0.0, rest)[0], dtype=float)

    def scale(self, q: FloatArray) -> float:
        return float(max(np.max(np.abs(self._open(q))), np.max(np.abs(self.held)), 1e-300))

    def residual(self, q: FloatArray) -> float:
        """What is left along the free motions, against weights and torques."""
        left = free_motions(self.model, q).T @ self.force(q)
        most = float(np.max(np.abs(left), initial=0.0))
        return most / max(self.scale(q), self._weight(q)) if most else 0.0

    def _weight(self, q: FloatArray) -> float:
        """Size of the loads where they happen to balance link by link: their change over a radian."""
        return float(np.max(np.abs(self._change(q)), initial=0.0))

    def _change(self, q: FloatArray) -> FloatArray:
        """Derivative of the force by q (nu, nq), the multipliers that hold the loops shut kept.

        What holds driven joints has constant rows and drops out.
        """
        multipliers = self.multipliers(q)
        columns = []
        for k in range(len(q)):
            sides = []
            for sign in (1.0, -1.0):
                moved = q.copy()
                moved[k] += sign * 1e-6
                sides.append(self.force(moved) - self.model.jacobian(moved).T @ multipliers)
            columns.append((sides[0] - sides[1]) / 2e-6)
        return np.array(columns).T

    def multipliers(self, q: FloatArray) -> FloatArray:
        """Closure multipliers of least norm that hold the loads beside the drives, (rows,)."""
        rows, count = self._rows(q), len(self.model.rows)
        return np.asarray(np.linalg.lstsq(rows.T, self.force(q), rcond=1e-12)[0][:count] if count else np.zeros(0))

    def _rows(self, q: FloatArray) -> FloatArray:
        """The closure's rows, then those of the driven joints as lengths, (rows + drives, nu)."""
        return np.vstack([self.model.jacobian(q), drive_rows(self.model) * self.model.length])

    def _miss(self, q: FloatArray) -> FloatArray:
        """By how much loops are open and driven joints have moved, (rows + drives,) in m."""
        moved = drive_rows(self.model) @ (q - self.first)
        return np.append(self.model.closure(q), moved * self.model.length)

    def stiffness(self, q: FloatArray) -> FloatArray:
        """Reduced Hessian over orthonormal free motions (freedoms, freedoms)."""
        motions = free_motions(self.model, q)
        reduced = motions.T @ self._change(q) @ motions
        return np.asarray((reduced + reduced.T) / 2.0, dtype=float)

    def potential(self, q: FloatArray) -> float:
        return float(self.model.energy(q, np.zeros(len(q)))[1] - self.held @ q)

    def closed(self, q: FloatArray) -> FloatArray | None:
        """A closed configuration near ``q``, by smallest steps; ``None`` where there is none."""
        size = self.model.length
        for _ in range(60):
            miss = self._miss(q)
            if np.max(np.abs(miss), initial=0.0) <= 1e-14 * size * len(q):
                return q
            q = q - np.linalg.lstsq(self._rows(q), miss, rcond=1e-12)[0]
        return q if np.max(np.abs(self._miss(q))) <= 1e-12 * size * len(q) else None

    def reactions(self, q: FloatArray) -> FloatArray:
        """Force and moment per joint on its outboard link, (joints, 3)."""
        rest, rows = np.zeros((1, len(q))), np.append(self.multipliers(q), 0.0)[None]
        found = self.model.kernels.reactions(q[None], rest, 0.0, rest, np.ascontiguousarray(rows))
        forces = np.array(found, dtype=float).reshape(-1, 3)
        if self.torques:
            forces[:, 2] -= self._torques_carried()
            forces[:, :2] -= self._pushes(self.model.poses(q))
        return forces

    def _pushes(self, poses: FloatArray) -> FloatArray:
        """Per joint (joints, 2) what a force along its own line does to its outboard link: that is no reaction."""
        model, found = self.model, np.zeros((len(self.model.joints), 2))
        for name, force in self.torques.items():
            if name in model.data["lines"]:
                second, joint = model.data["lines"][name]["links"][1], model.joints.index(name)
                outwards = model.outboard[joint] == (model.links[second] if second >= 0 else "ground")
                found[joint] = (force if outwards else -force) * model.lines.direction(name, poses)
        return found

    def _torques_carried(self) -> FloatArray:
        """Per joint (joints,) the part of its moment that the torques give: they act on links, beside the loads.

        A tree joint whose links do not turn freely against each other carries what acts on its outboard link, and on
        what such joints hang on that.
        """
        data, model = self.model.data, self.model
        couples = np.zeros(len(model.links) + 1)  # the last one is the ground's
        for name, torque in self.torques.items():
            if name not in data["lines"]:
                first, second = data["between"][model.joints.index(name)]
                couples[first] -= torque
                couples[second] += torque
        driven = [drive["joint"] for drive in data["drives"]]
        held = [name for name, line in data["lines"].items() if line["angle"] is not None]
        stiff = {}
        for index, name in enumerate(model.joints):
            if name in (*driven, *held) and name not in model.cuts:
                outboard = model.links.index(model.outboard[index])
                (inboard,) = (link for link in data["between"][index] if link != outboard)
                stiff[index] = (inboard, outboard)

        def carried(link: int) -> float:
            return float(couples[link]) + sum(carried(out) for inward, out in stiff.values() if inward == link)

        return np.array([carried(stiff[k][1]) if k in stiff else 0.0 for k in range(len(model.joints))])
