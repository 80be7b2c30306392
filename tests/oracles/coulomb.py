"""Coulomb's law at rough contacts, put to given impulses: dense NumPy, nothing of the runtime's."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .maximal import Array


@dataclass(frozen=True)
class Rough:
    """n contacts: W (2n, 2n) of normals, then tangents; rates b (2n,) without impulses; friction; least impulses."""

    W: Array
    b: Array
    mu: Array
    least: Array


def broken(c: Rough, P: Array, tolerance: float) -> list[str]:
    """What impulses P (2n,) break. ``tolerance`` is relative: rates are compared with the sum of the sizes of their
    terms, impulses with the largest as it loads its contact."""
    n = len(c.mu)
    compliance = np.sqrt(np.diag(c.W))
    rates, terms = c.W @ P + c.b, np.abs(c.W) @ np.abs(P) + np.abs(c.b)
    speed = max(float(np.max(np.abs(c.b) / compliance)), float(np.max(np.abs(P) * compliance)))
    rounding = tolerance * (terms + 1e-4 * speed * compliance)
    load = max(float(np.max(np.abs(P) * compliance)), float(np.max(c.least * compliance[:n])))
    small = tolerance * load / compliance
    wrong = []
    for i in range(n):
        extra, limit = P[i] - c.least[i], c.mu[i] * P[i]
        edge = tolerance * limit + 1e-4 * small[n + i]
        if rates[i] < -rounding[i]:
            wrong.append(f"contact {i} still approaches with {rates[i]:.3g}")
        if extra < -small[i]:
            wrong.append(f"contact {i} has {extra:.3g} N s less than its least")
        if extra > small[i] and rates[i] > rounding[i]:
            wrong.append(f"contact {i} pushes with {extra:.3g} N s and leaves with {rates[i]:.3g}")
        if abs(P[n + i]) > limit + edge:
            wrong.append(f"contact {i} has friction of {P[n + i]:.3g} N s, its limit is {limit:.3g}")
        if c.W[n + i, n + i] <= 1e-15 * c.W[i, i]:
            continue  # no impulse moves it along its ground: whether it rests there is not for the impulses to say
        if abs(rates[n + i]) > rounding[n + i] and abs(P[n + i] + np.sign(rates[n + i]) * limit) > edge:
            wrong.append(
                f"contact {i} slides with {rates[n + i]:.3g}, and its friction of {P[n + i]:.3g} is not at its limit"
            )
    return wrong
