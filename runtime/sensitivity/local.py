"""Derivatives of a model's functions at one state, by q, u and the arguments that move, each a column."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..arrays import FloatArray
from ..model.drives import drive_rows, rate_rows
from ..model.model import Model
from .moving import Moving


@dataclass(frozen=True)
class Local:
    """A model at the configuration q (n,) and time t, and the ``moving`` directions: D of them, q first, then u."""

    model: Model
    moving: Moving
    t: float
    q: FloatArray

    @cached_property
    def gap_rows(self) -> FloatArray:
        """N (contacts, n)."""
        return rate_rows(self.model, "gap_rates", self.q)

    @cached_property
    def slip_rows(self) -> FloatArray:
        """T (contacts, n); of smooth models zeros."""
        if self.model.kernels.of_state("slips", self.q[None], self.q[None]).shape[1]:
            return rate_rows(self.model, "slips", self.q)
        return np.zeros_like(self.gap_rows)

    @cached_property
    def closure_rows(self) -> FloatArray:
        """A (rows, n)."""
        return np.asarray(self.model.jacobian(self.q))

    @cached_property
    def drive_rows(self) -> FloatArray:
        """Rows (drives, n) of the driven joints' speeds."""
        return drive_rows(self.model)

    def tangent(
        self,
        of: str,
        size: int,
        u: FloatArray,
        by: tuple[str, ...] = ("q", "u", "k"),
        P: FloatArray | None = None,
        multipliers: FloatArray | None = None,
    ) -> FloatArray:
        """Derivatives (size, D) of a function at ``u``, other ``by`` than these held; zero where it has none."""
        model, along = self.model, self.moving.directions
        given = {name: part for name, part in along.whole().items() if name in by}
        n, rows = len(self.q), len(model.rows)
        none = np.zeros(max(len(model.contacts), 1))
        held = np.zeros(rows + 1)
        if multipliers is not None:
            held[:rows] = multipliers
        found = model.kernels.tangents(
            of, self.q, u, self.t, np.zeros(n), held, none if P is None else P, given, along.blocks
        )
        return np.zeros((size, len(along.columns))) if found is None else np.asarray(along.result(found))

    def response(self, f: FloatArray, y: FloatArray) -> FloatArray:
        """Jumps (n, k) that generalized impulses f (n, k) give with closure rates y (rows, k), driven joints held."""
        count = f.shape[1]
        if not count:
            return np.zeros_like(f)
        rates = np.zeros((count, len(self.model.rows) + 1))
        rates[:, : len(y)] = y.T
        found, _, outcomes = self.model.kernels.impulse(
            np.tile(self.q, (count, 1)), np.ascontiguousarray(f.T, dtype=float), rates
        )
        if wrong := [outcome for outcome in outcomes if outcome != "done"]:
            raise ValueError(
                f"{self.model.name}: found no solution of the equations at t = {self.t:.9g} s "
                f"({wrong[0].replace('_', ' ')}); there is no derivative there"
            )
        return np.asarray(found).T

    def closure_moves(self) -> FloatArray:
        """By what the closure changes, (rows, D)."""
        return self.tangent("closure", len(self.model.rows), np.zeros_like(self.q), ("q", "k"))

    def closure_rates_move(self, u: FloatArray) -> FloatArray:
        """By what A u changes, (rows, D)."""
        return self.tangent("closure_rate", len(self.model.rows), u)

    def gaps_move(self) -> FloatArray:
        """By what gaps change, (contacts, D): raw, of stops in rad."""
        return self.tangent("gaps", len(self.model.contacts), np.zeros_like(self.q), ("q", "k"))

    def gap_rates_move(self, u: FloatArray, by: tuple[str, ...] = ("q", "u", "k")) -> FloatArray:
        """By what N u changes, (contacts, D)."""
        return self.tangent("gap_rates", len(self.model.contacts), u, by)

    def slips_move(self, u: FloatArray, by: tuple[str, ...] = ("q", "u", "k")) -> FloatArray:
        """By what T u changes, (contacts, D)."""
        return self.tangent("slips", len(self.model.contacts), u, by)

    def pushes_move(self, P: FloatArray, F: FloatArray) -> FloatArray:
        """By what N^T P + T^T F changes, (n, D), P and F (contacts,) held."""
        n, none = len(self.q), np.zeros_like(self.q)
        found = self.tangent("contact_impulse", n, none, ("q", "k"), P)
        return found + self.tangent("slip_impulse", n, none, ("q", "k"), F) if F.any() else found

    def coefficients_move(self, of: str) -> FloatArray:
        """By what ``"restitution"`` or ``"friction"`` of the contacts change, (contacts, D)."""
        return self.tangent(of, len(self.model.contacts), np.zeros_like(self.q), ("k",))
