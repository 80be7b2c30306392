"""The way to where wants miss least: loops shut, nothing behind a surface.

Newton's method in the motions that loops allow: with misses r, their rows J and the multipliers λ of what holds, the
Lagrangian's Hessian ``JᵀJ + Σ r ∇²r − Σ λ ∇²c`` has exact second derivatives, since rates' own derivatives at u̇ = 0 are
quadratic in u. Directions of negative curvature are taken as if it were positive, so each step goes down; gaps bound
it, by the shortest way to a polyhedron (``cones.least_distance``).
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ..arrays import FloatArray
from ..model.assembly import nearest_closed
from ..model.model import Model
from .cones import least_distance
from .contacts import CLOSED, Contacts
from .inverse_dynamics import free_motions
from .wants import Wants

PASSES = 100
FARTHEST = 0.5
"""Longest step in joint displacements: rad, or lengths of the mechanism."""
FIRST_DAMPING, LARGEST_DAMPING = 1e-6, 1e8
"""Of steps, in parts of the largest curvature; at the largest nothing is gained any more."""
FLAT = 1e-9
"""Curvatures below this part of the largest are taken as that."""
PENALTY = 100.0
"""What a gap behind its surface costs, as a miss of that length does."""
SMALL = 1e-14
"""Steps below this (rad, lengths) end the way."""


@dataclass
class Nearing:
    """Ways of ``model`` to where ``wants`` miss least."""

    model: Model
    wants: Wants
    contacts: Contacts = field(init=False)
    metric: FloatArray = field(init=False)

    def __post_init__(self) -> None:
        self.contacts = Contacts(self.model)
        self.metric = self.model.displacements()
        self.released = [drive["joint"] for drive in self.model.data["drives"]]

    def miss(self, q: FloatArray) -> float:
        """How far wants miss in all: root of the sum of squares (m)."""
        return float(np.linalg.norm(self.wants.misses(q)))

    def farthest(self, q: FloatArray, other: FloatArray) -> float:
        """How far a joint moves at most from one configuration to another (rad, lengths)."""
        return float(np.max(np.abs(self.metric @ (other - q))))

    def distance(self, q: FloatArray, other: FloatArray) -> float:
        """How far all do: root of the sum of squares."""
        return float(np.linalg.norm(self.metric @ (other - q)))

    def gaps(self, q: FloatArray) -> FloatArray:
        """Gaps as lengths (contacts,)."""
        return -self.contacts.depths(q) * self.model.length

    def least(self, q: FloatArray) -> FloatArray:
        """A configuration from which no step leads to smaller misses, from a closed ``q`` downhill."""
        damping, cost = FIRST_DAMPING, self._cost(q)
        for _ in range(PASSES):
            step, damping, lower = self._lower(q, damping, cost)
            if step is None or lower >= cost:
                break
            moved = self.farthest(q, step)
            q, cost = step, lower
            if moved <= SMALL:
                break
        return q

    def _cost(self, q: FloatArray) -> float:
        return self.miss(q) + PENALTY * float(np.sum(np.maximum(-self.gaps(q), 0.0)))

    def _lower(self, q: FloatArray, damping: float, cost: float) -> tuple[FloatArray | None, float, float]:
        """A place of less cost, with the damping that led there and its cost; ``None`` where there is none."""
        motions = free_motions(self.model, q, self.released)
        slope = motions.T @ (self.wants.rows(q).T @ self.wants.misses(q))
        values, directions = np.linalg.eigh(self._hessian(q, motions))
        size = max(float(np.max(np.abs(values), initial=0.0)), 1e-300)
        bent = np.maximum(np.abs(values), FLAT * size)
        while damping <= LARGEST_DAMPING:
            step = self._step(q, motions @ directions, directions.T @ slope, bent + damping * size)
            found = None if step is None else self._shut(q + step)
            if found is not None and (lower := self._cost(found)) < cost:
                return found, max(damping / 10.0, 1e-12), lower
            damping *= 10.0
        return None, damping, cost

    def _step(self, q: FloatArray, spread: FloatArray, slope: FloatArray, bent: FloatArray) -> FloatArray | None:
        """The step along ``spread`` (nu, k) that is best for that slope (k,) and these curvatures, of all that keep
        gaps from becoming negative."""
        best = -slope / bent
        far = self.farthest(q, q + spread @ best)
        best *= min(1.0, FARTHEST / max(far, 1e-300))
        if len(self.contacts):
            stretch = spread / np.sqrt(bent)
            rows = self.contacts.normals(q) * self.contacts.levers[:, None]
            change = least_distance(rows @ stretch, -self.gaps(q) - rows @ (spread @ best))
            if change is None:
                return None
            return np.asarray(spread @ best + stretch @ change)
        return np.asarray(spread @ best)

    def _shut(self, q: FloatArray) -> FloatArray | None:
        """The nearest closed configuration; ``None`` where there is none."""
        if not self.model.rows:
            return q
        try:
            return nearest_closed(self.model.closure, self.model.jacobian, self.metric, q)
        except ValueError:
            return None

    def _hessian(self, q: FloatArray, motions: FloatArray) -> FloatArray:
        """The Lagrangian's over ``motions`` (nu, k), (k, k); products of different ones come from sums and
        differences."""
        wants, misses, along = self.wants, self.wants.misses(q), self.wants.rows(q)
        closed = np.flatnonzero(self.gaps(q) <= CLOSED * self.model.length)
        levers = self.contacts.levers[closed]
        held = np.vstack([self.model.jacobian(q), self.contacts.normals(q)[closed] * levers[:, None]])
        multipliers = np.linalg.lstsq(held.T, along.T @ misses, rcond=1e-9)[0]
        loops, surfaces = np.split(multipliers, [len(self.model.rows)])

        def curvature(u: FloatArray) -> FloatArray:
            rates = np.ascontiguousarray(u.T)
            states = np.tile(q, (len(rates), 1))
            found = wants.bias(q, rates) @ misses
            if loops.size:
                found = found - self.model.kernels.of_state("closure_bias", states, rates) @ loops
            if surfaces.size:
                bent = self.contacts.model.kernels.of_state("gap_bias", states, rates)[:, closed]
                found = found - bent @ (levers * surfaces)
            return np.asarray(found)

        reduced, count = along @ motions, motions.shape[1]
        found = np.zeros((count, count))
        one, other = np.triu_indices(count)
        sums, differences = (motions[:, one] + sign * motions[:, other] for sign in (1.0, -1.0))
        found[one, other] = found[other, one] = (curvature(sums) - curvature(differences)) / 4.0
        return np.asarray(found + reduced.T @ reduced)
