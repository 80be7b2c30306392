"""How one small difference passes an instant at which contacts strike together that it parts: one after the other.

Which contact comes first depends on the direction, by the rates of the gaps; the derivative along it is then that of
this order, and another one along the opposite direction (S. A. Burden, S. S. Sastry, D. E. Koditschek, S. Revzen,
Event-selected vector field discontinuities yield piecewise-differentiable flows, SIAM Journal on Applied Dynamical
Systems 15, 2016; docs/theory.md, section 11.10). Between two strikes time and places move by small amounts of the first
order, rates by whole ones: their order is followed like a motion of constant rates.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..arrays import FloatArray
from ..model.forces import Held
from ..model.model import Model
from ..model.thresholds import characteristic_time
from ..record.impact import Impact
from .held import accelerations, pushing
from .local import Local, at_one
from .moving import Moving
from .passing import MEET, RESTS, Instant, Passed
from .striking import after_impact, restitution_of

MOST = 60
"""Impacts in a row; more are bounces that accumulate within the instant."""

SAME = 1e-9
"""Rates behind all strikes are those of the run where they differ by less than this part of those before it: laws of
impact are decided to a tenth of that (``UNDECIDED``)."""


def pass_in_order(model: Model, moving: Moving, instant: Instant, S: FloatArray) -> tuple[FloatArray, Passed]:
    """A difference S (2 n, 1) of the state behind the impacts of an instant that it parts, from that before, contacts
    striking in the order in which it brings them to the ground.

    Raises ``ValueError`` where rates behind them are not those of the run, which then jumps along this direction.
    """
    impacts, q, ways = instant
    t, n = impacts[0].t, len(q)
    at = at_one(model, moving, t, q)
    order = _Order(at, impacts, S, ways[0])
    for _ in range(MOST):
        if not order.strike_next():
            break
    else:
        raise ValueError(f"{model.name}: found bounces at t = {t:.9g} s that do not end, expected strikes in an order")
    last = impacts[-1]
    speed = float(np.max(np.abs(at.gap_rows) @ np.abs(impacts[0].u_minus)))
    apart = float(np.max(np.abs(at.gap_rows @ (order.u - last.u_plus)), initial=0.0))
    apart = max(apart, float(np.max(np.abs(order.u - last.u_plus) / model.coordinate_units)) * model.length)
    if apart > SAME * speed:
        said = ", then ".join(" and ".join("{} on {}".format(*model.contacts[c]) for c in one) for one in order.struck)
        raise ValueError(
            f"{model.name}: found contacts that strike together at t = {t:.9g} s, and along this direction {said}: "
            f"that ends with rates that differ by {apart:.3g} m/s from those of the run, which jumps here; there is no "
            "derivative"
        )
    found = order.back(order.s, last.u_plus, _acceleration(at, ways[1], last.u_plus)[0])
    per = characteristic_time(model)
    units = np.concatenate([model.coordinate_units, model.coordinate_units / per])
    before, after = (one[:, 0] / units for one in (S, found))
    matrix = np.outer(after, before) / (float(before @ before) or 1.0)
    dt, behind = np.array([order.s]), np.vstack([order.d, order.w])
    assert behind.shape == (2 * n, 1)
    return found, Passed(t, "impact", tuple(impacts[0].contacts), dt, behind, matrix)


class _Order:
    """The difference on its way through the instant: after ``s`` (s per unit of it), by which places ``d`` and rates
    ``w`` (n, 1) differ from those of the run at the instant, whose rates ``u`` (n,) change by whole amounts."""

    def __init__(self, at: Local, impacts: Sequence[Impact], S: FloatArray, held: Held) -> None:
        n = len(at.q)
        self.at, self.s, self.u = at, 0.0, impacts[0].u_minus
        self.d, self.w = S[:n], S[n:]
        self.before = [contact for contact, _ in pushing(held)]
        struck = [at.model._contact(contact) for impact in impacts for contact in impact.contacts]
        self.contacts = list(dict.fromkeys([*self.before, *struck]))
        self.acceleration, _ = _acceleration(at, held, self.u)
        self.gaps = at.gaps_move()
        self.terms = np.abs(at.gap_rows) @ np.abs(self.u)
        self.closed = set(self.before)
        self.struck: list[list[int]] = []

    def strike_next(self) -> bool:
        """Go to the next strike, if there is one, and behind it."""
        rates = self.at.gap_rows @ self.u
        closing = [c for c in self.contacts if rates[c] < -RESTS * float(np.max(self.terms))]
        if not closing:
            return False
        gaps, sizes = self._gaps()
        times = {c: self.s - gaps[c] / rates[c] for c in closing}
        first = min(times, key=lambda c: times[c])
        if self.struck and times[first] < self.s:
            if -gaps[first] > MEET * sizes[first]:
                raise ValueError(
                    f"{self.at.model.name}: found a contact at t = {self.at.t:.9g} s that is passed along this "
                    "direction before another strikes; there is no derivative"
                )
            times[first] = self.s
        self._move(times[first] - self.s)
        gaps, sizes = self._gaps()
        meet = [c for c in closing if abs(gaps[c]) <= MEET * sizes[c]]
        chosen = [c for c in self.contacts if c in meet or c in self.closed]
        self._strike(chosen)
        self.struck.append(meet)
        return True

    def back(self, s: float, u: FloatArray, acceleration: FloatArray) -> FloatArray:
        """The difference (2 n, 1) at the time of the run, by the motion behind the instant."""
        return np.vstack([self.d - s * u[:, None], self.w - s * acceleration[:, None]])

    def _whole(self) -> FloatArray:
        return self.at.moving.whole(self.d, self.w)

    def _gaps(self) -> tuple[FloatArray, FloatArray]:
        """The gaps of the difference, and the size of the terms that they are sums of."""
        whole = self._whole()
        return (self.gaps @ whole)[:, 0], (np.abs(self.gaps) @ np.abs(whole))[:, 0] + abs(self.s) * self.terms

    def _move(self, time: float) -> None:
        self.d, self.w = self.d + time * self.u[:, None], self.w + time * self.acceleration[:, None]
        self.s += time

    def _strike(self, chosen: Sequence[int]) -> None:
        """The impact of contacts, with those that are closed beside them."""
        at, model, k = self.at, self.at.model, len(chosen)
        before = np.ascontiguousarray(self.u)
        after, impulses, outcome = model.kernels.impact(
            at.q, before, np.array(chosen, dtype=np.int32), restitution_of(model, chosen)
        )
        if outcome != "done":
            raise ValueError(
                f"{model.name}: found no impulses at t = {at.t:.9g} s for contacts that strike one after the other "
                f"along this direction ({outcome.replace('_', ' ')}); there is no derivative"
            )
        names = tuple(model.contacts[c] for c in chosen)
        impact = Impact(at.t, names, before, after, impulses[:k], 0.0, friction=impulses[k : 2 * k])
        whole = self._whole()
        moves, checks = after_impact(at, impact, np.eye(2 * len(at.q), len(whole))[len(at.q) :])
        for check in checks:
            check(whole)
        self.w, self.u = moves @ whole, after
        speed = float(np.max(self.terms))
        rates = at.gap_rows @ after
        self.closed = {c for c in chosen if abs(rates[c]) <= RESTS * speed}
        while True:
            held = _held(at, sorted(self.closed), after, speed)
            self.acceleration, pulls = _acceleration(at, held, after)
            if not pulls:
                break
            self.closed -= set(pulls)  # it leaves, so slowly that until the next strike its gap is of the second order


def _held(at: Local, contacts: Sequence[int], u: FloatArray, speed: float) -> Held:
    """How contacts are held that move like this along their grounds."""
    friction, slips = at.model.kernels.friction, at.slip_rows @ u
    found = []
    for c in contacts:
        still = abs(slips[c]) <= RESTS * speed
        how = "sticks" if still else "slides forward" if slips[c] > 0.0 else "slides backward"
        found.append((c, how if friction[c] > 0.0 else "smooth"))
    return found


def _acceleration(at: Local, held: Held, u: FloatArray) -> tuple[FloatArray, list[int]]:
    """With these contacts held, (n,), and those of them that would pull."""
    u_dot, _, pushes = accelerations(at.model, held, np.array([at.t]), at.q[None], np.ascontiguousarray(u[None]))
    return np.asarray(u_dot[0]), [c for c, _ in pushing(held) if float(pushes[0, c]) < 0.0]
