"""Several rough contacts struck together, marched along their impulses in small steps, many such impacts side by side.

Each contact in turn is pushed by a small part of what would end its approach, with the friction of its present
sliding, until none approaches. Then all give back, in proportion to e times what each has taken, until by Poisson's law
that much has been given, by Stronge's each contact has done e² of its work, and by Newton's each gap opens with e times
the speed of its approach; what others drive into its ground meanwhile is pushed. What holds itself fast gives nothing
back.

With one contact it is the process of :mod:`impact_process`. With several the order of pushes is a choice, as
stiffnesses would be: the size of impulses is known from it, not their digits.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from .maximal import Array

PART = 0.1
"""Of what would end an approach: one push."""
PASSES = 100_000
CLOSED = 1e-7
"""Of the speeds there were: an approach so slow has ended."""
STEPS = 20
"""Of expansion, for as much impulse as e times that of compression."""
LONGEST = 6
"""Times that impulse: no expansion is followed further."""


@dataclass
class Struck:
    """b impacts of n contacts: W (b, 2n, 2n) of normals, then tangents; rates v (b, 2n); friction and e (b, n)."""

    W: Array
    v: Array
    mu: Array
    e: Array

    def push(self, i: int, impulse: Array, P: Array) -> Array:
        """Push contact i by impulses (b,) with the friction of its sliding; the work that they do (b,)."""
        n, W, v = self.mu.shape[1], self.W, self.v
        before = v[:, i].copy()
        along = W[:, n + i, n + i]
        stop = -(v[:, n + i] + W[:, n + i, i] * impulse) / np.where(along > 0.0, along, np.inf)
        limit = self.mu[:, i] * impulse
        drag = np.clip(stop, -limit, limit)
        v += W[:, :, i] * impulse[:, None] + W[:, :, n + i] * drag[:, None]
        P[:, i] += impulse
        P[:, n + i] += drag
        work: Array = 0.5 * impulse * (before + v[:, i])
        return work

    def close(self, P: Array, part: float) -> Array:
        """Push what approaches, contact by contact, by ``part`` of what would end it; the work taken (b, n)."""
        n = self.mu.shape[1]
        return np.stack(
            [-self.push(i, part * np.maximum(-self.v[:, i], 0.0) / self.W[:, i, i], P) for i in range(n)], axis=1
        )


def impulses(W: Array, mu: Array, e: Array, before: Array, law: str, passes: int = PASSES) -> Array:
    """Impulses (b, 2n), normals and then tangents, of b impacts of n contacts by the law of that name.

    With fewer passes compression is cut short, and impulses are too small."""
    n = mu.shape[1]
    march, P, taken = Struck(W, before.copy(), mu, e), np.zeros_like(before), np.zeros_like(mu)
    unit = np.sqrt(np.maximum(np.einsum("bii->bi", W), 1e-300))
    speed = np.max(np.abs(before) / unit, axis=1)
    for _ in range(passes):
        taken += march.close(P, PART)
        if np.all(np.max(-march.v[:, :n] / unit[:, :n], axis=1) <= CLOSED * speed):
            break
    wanted, given = e * P[:, :n] / STEPS, np.zeros_like(taken)
    was = march.v.copy()
    for step in range(LONGEST * STEPS):
        if law == "newton":
            pushes = march.v[:, :n] < -e * before[:, :n]
        else:
            pushes = given < e**2 * taken if law == "stronge" else np.full(mu.shape, step < STEPS)
        pushes &= wanted > 0.0
        if law != "poisson" and step:
            pushes &= (np.max(np.abs(march.v - was) / unit, axis=1) > 1e-9 * speed)[:, None]
        if not pushes.any():
            break
        was = march.v.copy()
        for i in range(n):
            given[:, i] += march.push(i, np.where(pushes[:, i], wanted[:, i], 0.0), P)
        march.close(P, 1.0)
    return P


def ways(W: Array, b: Array, mu: Array) -> list[Array]:
    """All impulses (2n,) of n contacts that end approach, W P + b >= 0, by Coulomb's law: every way to open, stick and
    slide is tried, with impulses of least norm where they are not unique."""
    n, unit, found = len(mu), np.eye(len(b)), []
    largest = float(np.max(np.abs(b)))
    for modes in itertools.product("o+-s", repeat=n):
        columns, needed = [], []
        for i, mode in enumerate(modes):
            if mode == "o":
                continue
            columns.append(unit[i] + {"+": -mu[i], "-": mu[i], "s": 0.0}[mode] * unit[n + i])
            needed.append(i)
            if mode == "s":
                columns.append(unit[n + i])
                needed.append(n + i)
        span = np.array(columns).reshape(len(needed), 2 * n).T
        P = span @ np.linalg.lstsq(W[needed] @ span, -b[needed], rcond=1e-11)[0] if needed else np.zeros(2 * n)
        rates, rounding = W @ P + b, 1e-9 * (largest + np.abs(W) @ np.abs(P))
        if np.any(np.abs(rates[needed]) > rounding[needed]):
            continue
        limit, small = mu * P[:n], 1e-9 * float(np.max(np.abs(P)))
        right = P[:n] >= -small
        for i, mode in enumerate(modes):
            if mode == "o":
                right[i] = rates[i] >= -rounding[i]
            elif mode == "s":
                right[i] &= abs(P[n + i]) <= limit[i] + small * (1.0 + mu[i])
            else:
                right[i] &= rates[n + i] * (1.0 if mode == "+" else -1.0) >= -rounding[n + i]
        if right.all():
            found.append(P)
    return found
