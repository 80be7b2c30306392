"""Contacts at rest: which are closed, what they can give within Coulomb's limits, and how they balance a load.

A closed contact pushes along its normal, P >= 0, and where it is rough drags along its tangent, |F| <= μ P. In the
plane that cone has two edges, N + μT and N − μT; a smooth contact has the one, N. So the generalized forces that
contacts can give are the sums of edges with shares >= 0, and a balance is a problem of non-negative least squares.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..arrays import BoolArray, FloatArray
from ..model.model import Model
from .cones import DEPENDENT, ROUNDING, farthest, least_distance, nonnegative

IntArray = NDArray[np.int64]

CLOSED = 1e-9
"""A contact is closed whose gap is at most this part of the mechanism's length, of a stop at most this angle (rad)."""
ACROSS = 1e-9
"""A contact whose row keeps less than this part along free motions does nothing to them."""
NONE = 1e-8
"""Contacts that take less than this part of the loads do not push."""

DEEPEST = 1e-8
"""A configuration with a contact deeper than this part of the length (of a stop, rad) is refused; less is rounding."""


@dataclass(frozen=True)
class Hold:
    """How closed contacts hold a mechanism against a load.

    ``closed``, ``pushing``, ``sticking`` and ``limited`` (contacts,) are booleans: one that pushes has a force above
    zero in some balance; one that sticks pushes, and friction keeps it from sliding; its friction is limited where it
    is at its limit in every balance. ``forces`` (contacts, 2) are normal and friction force, ``ranges``
    (contacts, 2, 2) the lowest and highest value of each. ``left`` (freedoms,) is the generalized force along free
    motions that contacts cannot take.
    """

    closed: BoolArray
    pushing: BoolArray
    sticking: BoolArray
    limited: BoolArray
    forces: FloatArray
    ranges: FloatArray
    left: FloatArray

    def slipping(self) -> Hold:
        """The same with no contact that sticks."""
        return replace(self, sticking=np.zeros_like(self.sticking))


@dataclass(frozen=True)
class _Edges:
    """Edges of the cones of closed contacts: ``of`` (edges,) says whose, ``side`` is 1 or −1, 0 where it is smooth;
    ``columns`` (freedoms, edges) are the generalized forces of a unit normal force along free motions."""

    of: IntArray
    side: IntArray
    columns: FloatArray

    def taken(self, shares: FloatArray, contacts: int, friction: FloatArray) -> FloatArray:
        """Normal and friction force of every contact (contacts, 2)."""
        found = np.zeros((contacts, 2))
        np.add.at(found[:, 0], self.of, shares)
        np.add.at(found[:, 1], self.of, shares * self.side * friction[self.of])
        return found


class Contacts:
    """The contacts of ``model``: gaps, rows and forces. Forces are in N along normals and tangents, of stops in N m."""

    def __init__(self, model: Model) -> None:
        self.model = model
        angular = np.array([ground in model.stops for _, ground in model.contacts], dtype=bool)
        self.sizes: FloatArray = np.where(angular, 1.0, model.length)
        """What gaps are measured by: the mechanism's length, of stops 1 rad."""
        self.levers: FloatArray = np.where(angular, model.length, 1.0)
        """What turns rows of stops into rows in m."""
        self.friction: FloatArray = np.array(model.kernels.friction, dtype=float)

    def __len__(self) -> int:
        return len(self.model.contacts)

    def none(self) -> BoolArray:
        """A boolean per contact, all false."""
        return np.zeros(len(self), dtype=bool)

    def depths(self, q: FloatArray) -> FloatArray:
        """How deep contacts are behind their surfaces, in parts of ``sizes`` (contacts,)."""
        return -np.asarray(self.model.kernels.of_q("gaps", np.asarray(q)[None])[0], dtype=float) / self.sizes

    def normals(self, q: FloatArray) -> FloatArray:
        """Rows N (contacts, nu) of the gaps' rates by u."""
        return self._rows("gap_rates", q)

    def tangents(self, q: FloatArray) -> FloatArray:
        """Rows T (contacts, nu) of the sliding by u; zero where contacts are smooth."""
        return self._rows("slips", q) if np.any(self.friction) else np.zeros((len(self), len(q)))

    def _rows(self, kernel: str, q: FloatArray) -> FloatArray:
        units = np.eye(len(q))
        found = self.model.kernels.of_state(kernel, np.ascontiguousarray(np.tile(q, (len(q), 1))), units)
        return np.array(found.T, dtype=float).reshape(len(self), len(q))

    def generalized(self, q: FloatArray, forces: FloatArray) -> FloatArray:
        """Generalized force Nᵀ P + Tᵀ F (nu,) of ``forces`` (contacts, 2)."""
        if not np.any(forces):
            return np.zeros(len(q))
        return np.asarray(forces[:, 0] @ self.normals(q) + forces[:, 1] @ self.tangents(q), dtype=float)

    def curvature(self, q: FloatArray, forces: FloatArray, motions: FloatArray) -> FloatArray:
        """Σ P d²(gap) + F d²(slip) over ``motions`` (nu, k): a quadratic form (k, k), exact.

        The biases Ṅu and Ṫu are quadratic in u; products of different motions come from their sums and differences.
        """
        count, acting = motions.shape[1], np.flatnonzero(np.any(forces != 0.0, axis=1))
        found = np.zeros((count, count))
        if not acting.size:
            return found
        one, other = np.triu_indices(count)
        sums, differences = (motions[:, one] + sign * motions[:, other] for sign in (1.0, -1.0))
        found[one, other] = found[other, one] = (self._bias(q, forces, sums) - self._bias(q, forces, differences)) / 4.0
        return found

    def _bias(self, q: FloatArray, forces: FloatArray, u: FloatArray) -> FloatArray:
        """P · Ṅu + F · Ṫu of every column of ``u`` (nu, k)."""
        total = np.zeros(u.shape[1])
        for kernel, column in (("gap_bias", 0), ("slip_bias", 1)):
            acting = np.flatnonzero(forces[:, column])
            if acting.size:
                states = np.tile(q, (u.shape[1], 1)), np.ascontiguousarray(u.T)
                total += self.model.kernels.of_state(kernel, *states)[:, acting] @ forces[acting, column]
        return total

    # -- balance ---------------------------------------------------------------------------------------------------

    def leaning(self, q: FloatArray, load: FloatArray, motions: FloatArray, rough: bool = False) -> Hold:
        """How contacts take as much of ``load`` (nu,) as they can, motions (nu, freedoms) being free but for them.

        With ``rough`` within Coulomb's limits, else as if all were smooth. Forces are some that do it.
        """
        closed = self._closed(q)
        edges = self._edges(q, closed, motions, rough)
        wanted = motions.T @ load
        shares = nonnegative(edges.columns, wanted)
        pushes = np.bincount(edges.of[shares > 0.0], minlength=len(self))
        forces = edges.taken(shares, len(self), self.friction)
        left = wanted - edges.columns @ shares
        return Hold(closed, pushes > 0, pushes == 2, self.none(), forces, _points(forces), left)

    def holding(self, q: FloatArray, load: FloatArray, motions: FloatArray, scale: float) -> Hold:
        """How contacts hold ``load`` within Coulomb's limits: forces of least norm, and the range of each.

        What takes less than ``NONE`` of ``scale`` does not push.
        """
        closed = self._closed(q)
        edges = self._edges(q, closed, motions, rough=True)
        wanted = motions.T @ load
        shares = nonnegative(edges.columns, wanted)
        forces = self._shared(edges, shares)
        ranges, most = self._ranges(edges, shares, forces)
        size = np.linalg.norm(edges.columns, axis=0)
        felt = (size > 0.0) & (most > NONE * scale / np.where(size > 0.0, size, 1.0))
        pushes = np.bincount(edges.of[felt], minlength=len(self))
        sticking = (pushes > 0) & (self.friction > 0.0)
        left = wanted - edges.columns @ shares
        return Hold(closed, pushes > 0, sticking, sticking & (pushes < 2), forces, ranges, left)

    def _closed(self, q: FloatArray) -> BoolArray:
        return np.asarray(self.depths(q) >= -CLOSED, dtype=bool)

    def _edges(self, q: FloatArray, closed: BoolArray, motions: FloatArray, rough: bool) -> _Edges:
        normals, tangents = self.normals(q), self.tangents(q)
        of: list[int] = []
        side: list[int] = []
        for contact in np.flatnonzero(closed):
            sides = (1, -1) if rough and self.friction[contact] > 0.0 else (0,)
            of += [int(contact)] * len(sides)
            side += sides
        index, sign = np.array(of, dtype=np.int64), np.array(side, dtype=np.int64)
        rows = normals[index] + (sign * self.friction[index])[:, None] * tangents[index]
        columns = motions.T @ rows.T
        idle = np.linalg.norm(columns, axis=0) <= ACROSS * np.linalg.norm(rows, axis=1)
        return _Edges(index, sign, np.where(idle, 0.0, columns))

    def _shared(self, edges: _Edges, shares: FloatArray) -> FloatArray:
        """The forces (contacts, 2) of least norm that do what ``shares`` (edges,) do; moments count over the length."""
        forces = edges.taken(shares, len(self), self.friction)
        count = len(edges.of)
        spread = np.zeros((2 * len(self), count))  # forces of each edge, by which the norm is taken
        spread[edges.of, np.arange(count)] = 1.0 / self.levers[edges.of]
        spread[len(self) + edges.of, np.arange(count)] = edges.side * self.friction[edges.of]
        free = _null(edges.columns)
        if not free.shape[1]:
            return _rounded(forces)
        # shares + free y >= 0, with the least |spread (shares + free y)|
        root, values, turn = np.linalg.svd(spread @ free, full_matrices=False)
        keep = values > DEPENDENT * max(float(values[0]), 1e-300)
        change = free @ (turn[keep].T / values[keep])
        first = shares - change @ (root[:, keep].T @ (spread @ shares))
        step = least_distance(change, -first)
        if step is None:
            return forces
        return _rounded(edges.taken(np.maximum(first + change @ step, 0.0), len(self), self.friction))

    def _ranges(self, edges: _Edges, shares: FloatArray, forces: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Lowest and highest normal and friction force of every contact, and the largest share of every edge."""
        ranges = _points(forces)
        if not _null(edges.columns).shape[1]:
            return ranges, shares
        count = len(edges.of)
        for contact in np.unique(edges.of):
            own = (edges.of == contact).astype(float)
            for kind, cost in enumerate((own, own * edges.side * self.friction[contact])):
                if np.any(cost):
                    ends = (-farthest(edges.columns, shares, -cost)[0], farthest(edges.columns, shares, cost)[0])
                    if ends[1] - ends[0] > DEPENDENT * np.max(np.abs(forces)):
                        ranges[contact, kind] = ends
        return ranges, np.array([farthest(edges.columns, shares, unit)[0] for unit in np.eye(count)])


def _rounded(forces: FloatArray) -> FloatArray:
    """Forces of which those that are rounding beside the largest are 0."""
    return np.where(np.abs(forces) <= ROUNDING * np.max(np.abs(forces), initial=0.0), 0.0, forces)


def _points(forces: FloatArray) -> FloatArray:
    """Ranges that are single values."""
    return np.stack([forces, forces], axis=-1)


def _null(a: FloatArray) -> FloatArray:
    """Orthonormal basis (n, k) of the x with a x = 0, columns of ``a`` (m, n) taken as of one size."""
    if not a.size:
        return np.eye(a.shape[1])
    size = np.linalg.norm(a, axis=0)
    scale = np.where(size > 0.0, size, 1.0)
    _, values, right = np.linalg.svd(a / scale)
    rank = int(np.sum(values > DEPENDENT * max(float(values[0]), 1.0)))
    return np.asarray(np.linalg.qr(right[rank:].T / scale[:, None])[0], dtype=float)


def inside(model: Model, q: FloatArray, deepest: float) -> str:
    """Which contact is behind its surface by more than ``deepest`` lengths (of a stop, rad), and by how much; else "".

    Of several the deepest one.
    """
    contacts = Contacts(model)
    depths = contacts.depths(q)
    if not depths.size or depths.max() <= deepest:
        return ""
    worst = int(np.argmax(depths))
    point, ground = model.contacts[worst]
    depth = depths[worst] * contacts.sizes[worst]
    if ground in model.stops | model.slide_ends:
        return f"{point} beyond {ground} by {depth:.6g} {'rad' if ground in model.stops else 'm'}"
    return f"{point} inside {ground} by {depth:.6g} m"
