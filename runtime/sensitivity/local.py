"""Derivatives of a model's functions at states, by q, u and the arguments that move, each a column."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..arrays import FloatArray, IntArray
from ..model.drives import drive_rows
from ..model.model import Model
from .moving import Moving

BY = ("q", "u", "k")


Asked = tuple[int, str, tuple[str, ...], bytes, bytes, bytes]
"""A tangent at one configuration: its number, of which function and by what, and the bytes of u, P and multipliers."""


def _asked(
    number: int, of: str, by: tuple[str, ...], u: FloatArray, P: FloatArray | None, multipliers: FloatArray | None
) -> Asked:
    pushes, held = (b"" if one is None else one.tobytes() for one in (P, multipliers))
    return number, of, by, u.tobytes(), pushes, held


@dataclass(frozen=True)
class Places:
    """A model at configurations q (b, n) and times t (b,), and the ``moving`` directions: D of them, q first, then u.

    All that it tells has the configurations first, and reads rates u (b, n).
    """

    model: Model
    moving: Moving
    t: FloatArray
    q: FloatArray
    known: dict[Asked, FloatArray] | None = None
    """Where configurations are looked at one by one, what has been found for all of them at once, by what is asked
    for; None where that is not kept."""

    @cached_property
    def gap_rows(self) -> FloatArray:
        """N (b, contacts, n)."""
        return self._rate_rows("gap_rates")

    @cached_property
    def slip_rows(self) -> FloatArray:
        """T (b, contacts, n); of smooth models zeros."""
        found = self._rate_rows("slips")
        return found if found.shape[1] else np.zeros_like(self.gap_rows)

    def _rate_rows(self, kernel: str) -> FloatArray:
        b, n = self.q.shape
        units = np.repeat(np.eye(n)[None], b, axis=0).reshape(-1, n)
        found = self.model.kernels.of_state(kernel, np.repeat(self.q, n, axis=0), units)
        return np.asarray(found.reshape(b, n, -1).transpose(0, 2, 1))

    @cached_property
    def closure_rows(self) -> FloatArray:
        """A (b, rows, n)."""
        return np.asarray(self.model.jacobian(self.q))

    @cached_property
    def responses(self) -> FloatArray:
        """Jumps and impulses of the loops (b, n + rows, n + rows) that unit generalized impulses and unit closure rates
        give, driven joints held."""
        found, without = self.model.kernels.responses(self.q)
        if without:
            i = min(without)
            raise ValueError(
                f"{self.model.name}: found no solution of the equations at t = {self.t[i]:.9g} s "
                f"({without[i].replace('_', ' ')}); there is no derivative there"
            )
        return np.asarray(found)

    def tangent(
        self,
        of: str,
        size: int,
        u: FloatArray,
        by: tuple[str, ...] = BY,
        P: FloatArray | None = None,
        multipliers: FloatArray | None = None,
    ) -> FloatArray:
        """Derivatives (b, size, D) of a function at ``u``, other ``by`` than these held; zero where it has none."""
        model, along = self.model, self.moving.directions
        given = along.whole()
        for name in BY:
            if name not in by:
                given.pop(name, None)
        b, n = self.q.shape
        held = np.zeros((b, len(model.rows) + 1))
        if multipliers is not None:
            held[:, :-1] = multipliers
        pushes = np.zeros((b, max(len(model.contacts), 1))) if P is None else P
        found = model.kernels.tangents(
            of, self.q, u, self.t, np.zeros((b, n)), held, pushes, given, along.blocks, along.chosen
        )
        tangents = np.zeros((b, size, len(along.columns))) if found is None else found
        if self.known is not None:
            for i in range(b):
                rest = (None if one is None else one[i] for one in (P, multipliers))
                self.known[_asked(i, of, by, u[i], *rest)] = tangents[i]
        return tangents

    def response(self, f: FloatArray, y: FloatArray | None = None) -> FloatArray:
        """Jumps (b, n, k) that generalized impulses f (b, n, k) give with closure rates y (b, rows, k), driven joints
        held."""
        n = self.q.shape[1]
        found = self.responses[:, :n, :n] @ f
        return np.asarray(found if y is None else found + self.responses[:, :n, n:] @ y)

    def loop_impulses(self, P: FloatArray, F: FloatArray) -> FloatArray:
        """Impulses (b, rows) of the loops that impulses P and F (b, contacts) of the contacts give, closure rates being
        kept."""
        n = self.q.shape[1]
        f = P[:, None] @ self.gap_rows
        if F.any():
            f = f + F[:, None] @ self.slip_rows
        found = np.asarray((self.responses[:, n:, :n] @ f.transpose(0, 2, 1))[:, :, 0])
        if self.known is not None:
            for i in range(len(found)):
                self.known[_asked(i, "loop impulses", (), P[i], F[i], None)] = found[i]
        return found

    def closure_moves(self) -> FloatArray:
        """By what the closure changes, (b, rows, D)."""
        return self.tangent("closure", len(self.model.rows), np.zeros_like(self.q), ("q", "k"))

    def closure_rates_move(self, u: FloatArray, by: tuple[str, ...] = BY) -> FloatArray:
        """By what A u changes, (b, rows, D)."""
        return self.tangent("closure_rate", len(self.model.rows), u, by)

    def gaps_move(self) -> FloatArray:
        """By what gaps change, (b, contacts, D): raw, of stops in rad."""
        return self.tangent("gaps", len(self.model.contacts), np.zeros_like(self.q), ("q", "k"))

    def gap_rates_move(self, u: FloatArray, by: tuple[str, ...] = BY) -> FloatArray:
        """By what N u changes, (b, contacts, D)."""
        return self.tangent("gap_rates", len(self.model.contacts), u, by)

    def slips_move(self, u: FloatArray, by: tuple[str, ...] = BY) -> FloatArray:
        """By what T u changes, (b, contacts, D)."""
        return self.tangent("slips", len(self.model.contacts), u, by)

    def pushes_move(self, P: FloatArray, F: FloatArray) -> FloatArray:
        """By what N^T P + T^T F changes, (b, n, D), P and F (b, contacts) held."""
        n, none = self.q.shape[1], np.zeros_like(self.q)
        found = self.tangent("contact_impulse", n, none, ("q", "k"), P)
        return found + self.tangent("slip_impulse", n, none, ("q", "k"), F) if F.any() else found

    def coefficients_move(self, of: str) -> FloatArray:
        """By what ``"restitution"`` or ``"friction"`` of the contacts change, (contacts, D), at any place."""
        if "k" not in self.moving.directions.by:
            return np.zeros((len(self.model.contacts), len(self.moving.directions.columns)))
        if of not in self.coefficients:
            one = self.some(slice(0, 1))
            self.coefficients[of] = one.tangent(of, len(self.model.contacts), np.zeros_like(one.q), ("k",))[0]
        return self.coefficients[of]

    @cached_property
    def coefficients(self) -> dict[str, FloatArray]:
        return {}

    def some(self, which: slice | IntArray, known: dict[Asked, FloatArray] | None = None) -> Places:
        """Some of the configurations, with the rows and responses that have been found there."""
        found = Places(self.model, self.moving, self.t[which], self.q[which], known)
        for name in ("gap_rows", "slip_rows", "closure_rows", "responses"):
            if name in self.__dict__:
                found.__dict__[name] = self.__dict__[name][which]
        return found


@dataclass(frozen=True)
class Local:
    """The configuration q (n,) and time t among others; all that it tells is as of :class:`Places`, without b."""

    places: Places
    number: int

    @property
    def model(self) -> Model:
        return self.places.model

    @property
    def moving(self) -> Moving:
        return self.places.moving

    @property
    def t(self) -> float:
        return float(self.places.t[self.number])

    @property
    def q(self) -> FloatArray:
        return np.asarray(self.places.q[self.number])

    @property
    def gap_rows(self) -> FloatArray:
        """N (contacts, n)."""
        return np.asarray(self.places.gap_rows[self.number])

    @property
    def slip_rows(self) -> FloatArray:
        """T (contacts, n); of smooth models zeros."""
        return np.asarray(self.places.slip_rows[self.number])

    @property
    def closure_rows(self) -> FloatArray:
        """A (rows, n)."""
        return np.asarray(self.places.closure_rows[self.number])

    @cached_property
    def drive_rows(self) -> FloatArray:
        """Rows (drives, n) of the driven joints' speeds."""
        return drive_rows(self.model)

    @cached_property
    def _alone(self) -> Places:
        return self.places if len(self.places.t) == 1 else self.places.some(slice(self.number, self.number + 1))

    def tangent(
        self,
        of: str,
        size: int,
        u: FloatArray,
        by: tuple[str, ...] = BY,
        P: FloatArray | None = None,
        multipliers: FloatArray | None = None,
    ) -> FloatArray:
        """Derivatives (size, D) of a function at ``u``, other ``by`` than these held; zero where it has none."""
        if self.places.known is not None:
            known = self.places.known.get(_asked(self.number, of, by, u, P, multipliers))
            if known is not None:
                return known
        pushes = None if P is None else P[None]
        held = None if multipliers is None else multipliers[None]
        return np.asarray(self._alone.tangent(of, size, u[None], by, pushes, held)[0])

    def response(self, f: FloatArray, y: FloatArray) -> FloatArray:
        """Jumps (n, k) that generalized impulses f (n, k) give with closure rates y (rows, k), driven joints held."""
        found, n = self.places.responses[self.number, : len(f)], len(f)
        return np.asarray(found[:, :n] @ f + found[:, n:] @ y)

    def loop_impulses(self, P: FloatArray, F: FloatArray) -> FloatArray:
        """Impulses (rows,) of the loops that impulses P and F (contacts,) of the contacts give, closure rates being
        kept."""
        known = (self.places.known or {}).get(_asked(self.number, "loop impulses", (), P, F, None))
        return np.asarray(self._alone.loop_impulses(P[None], F[None])[0]) if known is None else known

    def closure_moves(self) -> FloatArray:
        """By what the closure changes, (rows, D)."""
        return self.tangent("closure", len(self.model.rows), np.zeros_like(self.q), ("q", "k"))

    def closure_rates_move(self, u: FloatArray, by: tuple[str, ...] = BY) -> FloatArray:
        """By what A u changes, (rows, D)."""
        return self.tangent("closure_rate", len(self.model.rows), u, by)

    def gaps_move(self) -> FloatArray:
        """By what gaps change, (contacts, D): raw, of stops in rad."""
        return self.tangent("gaps", len(self.model.contacts), np.zeros_like(self.q), ("q", "k"))

    def gap_rates_move(self, u: FloatArray, by: tuple[str, ...] = BY) -> FloatArray:
        """By what N u changes, (contacts, D)."""
        return self.tangent("gap_rates", len(self.model.contacts), u, by)

    def slips_move(self, u: FloatArray, by: tuple[str, ...] = BY) -> FloatArray:
        """By what T u changes, (contacts, D)."""
        return self.tangent("slips", len(self.model.contacts), u, by)

    def pushes_move(self, P: FloatArray, F: FloatArray) -> FloatArray:
        """By what N^T P + T^T F changes, (n, D), P and F (contacts,) held."""
        n, none = len(self.q), np.zeros_like(self.q)
        found = self.tangent("contact_impulse", n, none, ("q", "k"), P)
        return found + self.tangent("slip_impulse", n, none, ("q", "k"), F) if F.any() else found

    def coefficients_move(self, of: str) -> FloatArray:
        """By what ``"restitution"`` or ``"friction"`` of the contacts change, (contacts, D)."""
        return self.places.coefficients_move(of)


def at_one(model: Model, moving: Moving, t: float, q: FloatArray) -> Local:
    """One configuration alone."""
    return Local(Places(model, moving, np.array([t]), np.ascontiguousarray(q)[None]), 0)
