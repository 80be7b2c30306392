"""Generalized forces of a mechanism at rest, how they change, and what joints carry."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..arrays import BoolArray, FloatArray
from ..model.drives import drive_rows
from ..model.model import Model
from .contacts import Contacts, Hold
from .inverse_dynamics import free_motions

BALANCED = 1e-10
"""Loads balance when what is left along the free motions is smaller than this part of them."""
NODES, WEIGHTS = (np.polynomial.legendre.leggauss(16)[0] + 1.0) / 2.0, np.polynomial.legendre.leggauss(16)[1] / 2.0
"""Of the work along a straight line from 0 to 1: to rounding for angles that change by half a radian."""
SHUT = 1e-12
"""Contacts farther from their surfaces than this part of the length (of a stop, rad) are put onto them."""


@dataclass(frozen=True)
class Statics:
    """Generalized forces at rest, ``held`` (nu,) being those of the torques.

    Driven joints are where they are in ``first`` (nq,).
    """

    model: Model
    held: FloatArray
    first: FloatArray
    torques: Mapping[str, float]

    @cached_property
    def contacts(self) -> Contacts:
        return Contacts(self.model)

    def force(self, q: FloatArray) -> FloatArray:
        """Gradient of the potential less the torques: what holding still would take, (nu,)."""
        return self._open(q) - self.held

    def _open(self, q: FloatArray) -> FloatArray:
        rest = np.zeros((1, len(q)))
        return np.asarray(self.model.kernels.inverse_dynamics(q[None], rest, 0.0, rest)[0], dtype=float)

    def scale(self, q: FloatArray) -> float:
        return float(max(np.max(np.abs(self._open(q))), np.max(np.abs(self.held)), 1e-300))

    # -- contacts --------------------------------------------------------------------------------------------------

    def hold(self, q: FloatArray) -> Hold:
        """How closed contacts hold the loads: by friction too where that balances them.

        Where it does not, contacts that friction can keep from sliding stick, and what pushes is judged as if all were
        smooth.
        """
        force, motions = self.force(q), free_motions(self.model, q)
        smooth = self.contacts.leaning(q, force, motions)
        if not np.any(smooth.closed):
            return smooth
        rough = smooth
        if np.any(self.contacts.friction[smooth.closed]):
            rough = self.contacts.leaning(q, force, motions, rough=True)
        if self.residual(q, rough) <= BALANCED:
            return self.contacts.holding(q, force, motions, self._size(q, rough))
        return replace(smooth, pushing=smooth.pushing | rough.sticking, sticking=rough.sticking)

    def rests_smooth(self, q: FloatArray) -> bool:
        """Whether contacts hold the loads without friction."""
        return self.residual(q, self.contacts.leaning(q, self.force(q), free_motions(self.model, q))) <= BALANCED

    def motions(self, q: FloatArray, hold: Hold) -> FloatArray:
        """Orthonormal motions (nu, freedoms) that keep contacts that push closed, and those that stick from sliding."""
        if not np.any(hold.pushing):
            return free_motions(self.model, q)
        return free_motions(self.model, q, contacts=self._held_rows(q, hold))

    def _held_rows(self, q: FloatArray, hold: Hold) -> FloatArray:
        """Rows (held, nu) in m: normals of what pushes, then tangents of what sticks."""
        normals = self.contacts.normals(q) * self.contacts.levers[:, None]
        return np.vstack([normals[hold.pushing], self.contacts.tangents(q)[hold.sticking]])

    def pressed(self, q: FloatArray, hold: Hold) -> FloatArray:
        """Forces (contacts, 2), of either sign, that keep what pushes closed and what sticks from sliding."""
        found, count = np.zeros((len(self.contacts), 2)), len(self.model.rows) + len(self.model.data["drives"])
        if np.any(hold.pushing):
            rows = np.vstack([self._rows(q), self._held_rows(q, hold)])
            carried = np.linalg.lstsq(rows.T, self.force(q), rcond=1e-12)[0][count:]
            pushing = int(np.sum(hold.pushing))
            found[hold.pushing, 0] = carried[:pushing] * self.contacts.levers[hold.pushing]
            found[hold.sticking, 1] = carried[pushing:]
        return found

    def residual(self, q: FloatArray, hold: Hold) -> float:
        """What is left along the free motions, against weights and torques."""
        most = float(np.max(np.abs(hold.left), initial=0.0))
        return most / self._size(q, hold) if most else 0.0

    def _size(self, q: FloatArray, hold: Hold) -> float:
        """Size of the loads, also where they happen to balance link by link: or their change over a radian."""
        return max(self.scale(q), float(np.max(np.abs(self._change(q, hold.forces)), initial=0.0)))

    # -- stiffness -------------------------------------------------------------------------------------------------

    def _change(self, q: FloatArray, forces: FloatArray) -> FloatArray:
        """Derivative of the force by q (nu, nq), the multipliers that hold the loops shut kept.

        What holds driven joints has constant rows and drops out.
        """
        multipliers = self.multipliers(q, forces)
        columns = []
        for k in range(len(q)):
            sides = []
            for sign in (1.0, -1.0):
                moved = q.copy()
                moved[k] += sign * 1e-6
                sides.append(self.force(moved) - self.model.jacobian(moved).T @ multipliers)
            columns.append((sides[0] - sides[1]) / 2e-6)
        return np.array(columns).T

    def multipliers(self, q: FloatArray, forces: FloatArray) -> FloatArray:
        """Closure multipliers of least norm that hold the loads beside the drives and contact forces, (rows,), 0 of
        rows that are off."""
        found, on = np.zeros(len(self.model.rows)), self.model.kernels.rows_on
        if len(on):
            load = self.force(q) - self.contacts.generalized(q, forces)
            found[on] = np.linalg.lstsq(self._rows(q).T, load, rcond=1e-12)[0][on]
        return found

    def _rows(self, q: FloatArray) -> FloatArray:
        """The closure's rows, then those of the driven joints as lengths, (rows + drives, nu)."""
        return np.vstack([self.model.jacobian(q), drive_rows(self.model) * self.model.length])

    def tangent(self, q: FloatArray, hold: Hold, forces: FloatArray) -> FloatArray:
        """What the force changes by over orthonormal motions (freedoms, freedoms) along paths that keep loops shut,
        contacts that push closed and those that stick from sliding, contact forces kept: the reduced Hessian of the
        potential, and not symmetric where loads have none."""
        motions = self.motions(q, hold)
        curved = self.contacts.curvature(q, forces, motions)
        return np.asarray(motions.T @ self._change(q, forces) @ motions - curved, dtype=float)

    def stiffness(self, q: FloatArray, hold: Hold, forces: FloatArray) -> FloatArray:
        """The symmetric part of ``tangent``: what loads do along a small motion and back is nothing of the rest."""
        tangent = self.tangent(q, hold, forces)
        return (tangent + tangent.T) / 2.0

    def work(self, q: FloatArray, new: FloatArray) -> float:
        """What it takes to move straight from ``q`` to ``new`` (J), loads with a potential or not, by Gauss's rule."""
        return float(WEIGHTS @ self.slopes(q, new))

    def slopes(self, q: FloatArray, new: FloatArray) -> FloatArray:
        """The force along the straight way from ``q`` to ``new``, times its length, at ``NODES`` of it (J)."""
        places = q + NODES[:, None] * (new - q)
        rest = np.zeros_like(places)
        forces = np.asarray(self.model.kernels.inverse_dynamics(places, rest, 0.0, rest), dtype=float) - self.held
        return np.asarray(forces @ (new - q))

    # -- geometry --------------------------------------------------------------------------------------------------

    def ajar(self, q: FloatArray, hold: Hold) -> bool:
        """Whether a contact that pushes is closed to its tolerance only."""
        return bool(np.any(np.abs(self.contacts.depths(q)[hold.pushing]) > SHUT))

    def closed(self, q: FloatArray, hold: Hold) -> FloatArray | None:
        """A closed configuration near ``q``, by smallest steps, with what pushes closed and nothing behind a surface;
        ``None`` where there is none."""
        touching = hold.pushing.copy()
        for _ in range(len(self.contacts) + 1):
            found = self._shut(q, touching)
            if found is None:
                return None
            deep = (self.contacts.depths(found) > SHUT) & ~touching
            if not np.any(deep):
                return found
            touching |= deep
        return None

    def _shut(self, q: FloatArray, touching: BoolArray) -> FloatArray | None:
        size = self.model.length
        for _ in range(60):
            miss = self._miss(q, touching)
            if np.max(np.abs(miss), initial=0.0) <= 1e-14 * size * len(q):
                return q
            rows = self._rows(q)
            if np.any(touching):
                rows = np.vstack([rows, (self.contacts.normals(q) * self.contacts.levers[:, None])[touching]])
            q = q - np.linalg.lstsq(rows, miss, rcond=1e-12)[0]
        return q if np.max(np.abs(self._miss(q, touching))) <= 1e-12 * size * len(q) else None

    def _miss(self, q: FloatArray, touching: BoolArray) -> FloatArray:
        """How far loops are open, driven joints have moved and touching contacts are off, (rows + drives + k,) in m."""
        moved = drive_rows(self.model) @ (q - self.first)
        gaps = -(self.contacts.depths(q) * self.model.length)[touching]
        return np.concatenate([self.model.closure(q), moved * self.model.length, gaps])

    # -- joints ----------------------------------------------------------------------------------------------------

    def reactions(self, q: FloatArray, forces: FloatArray) -> FloatArray:
        """Force and moment per joint on its second link, (joints, 3), contact ``forces`` (contacts, 2) counted."""
        rest, rows = np.zeros((1, len(q))), np.append(self.multipliers(q, forces), 0.0)[None]
        found = self.model.kernels.reactions(q[None], rest, 0.0, rest, np.ascontiguousarray(rows))
        pushes = np.ascontiguousarray(forces.T, dtype=float).reshape(1, -1)
        found = found + self.model.kernels.contact_reactions(q[None], pushes)
        carried = np.array(found, dtype=float).reshape(-1, 3)
        if self.torques:
            carried[:, 2] -= self._torques_carried()
            carried[:, :2] -= self._pushes(self.model.poses(q))
        return carried

    def _pushes(self, poses: FloatArray) -> FloatArray:
        """Per joint (joints, 2) what a force along its own line does to its second link: that is no reaction."""
        model, found = self.model, np.zeros((len(self.model.joints), 2))
        for name, force in self.torques.items():
            if name in model.data["lines"]:
                found[model.joints.index(name)] = force * model.lines.direction(name, poses)
        return found

    def _torques_carried(self) -> FloatArray:
        """Per joint (joints,) the part of its moment on its second link that the torques give: they act on links,
        beside the loads.

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
                first, second = data["between"][index]
                stiff[index] = (first, second) if data["sides"][index] > 0 else (second, first)

        def carried(link: int) -> float:
            return float(couples[link]) + sum(carried(out) for inward, out in stiff.values() if inward == link)

        return np.array(
            [data["sides"][k] * carried(stiff[k][1]) if k in stiff else 0.0 for k in range(len(model.joints))]
        )
