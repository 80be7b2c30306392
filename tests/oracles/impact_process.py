"""One rough contact struck by Stronge's or Poisson's law: the process of the impact, marched along the normal impulse.

With the contact's rates v = (normal, tangential) and their change W per unit impulse, dv = W (1, f) dp, where f is
Coulomb's friction per normal impulse. The impact ends when the normal impulse has given back e² of the work that it
took (W. J. Stronge, Impact Mechanics, 2000, section 4.2), or by Poisson's law when it has grown by e times what ended
the approach. W may have rank 1: what is a rounding of the speeds that there were is 0.
"""

from __future__ import annotations

import numpy as np

from .maximal import Array

FINEST = 1e-15
"""Part of a step below which a change of sliding is where it is."""


def _friction(W: Array, mu: float, v: Array, dp: float) -> float:
    """That which brings the sliding to rest within the step, or the limit."""
    if W[1, 1] == 0.0:
        return 0.0  # nothing moves it along
    return float(np.clip(-(v[1] / dp + W[1, 0]) / W[1, 1], -mu, mu))


def strike(W: Array, mu: float, e: float, before: Array, steps: int = 2000) -> tuple[Array, Array, float, float]:
    """Impulses (normal, tangential), rates after, and the work (J) that the normal impulse has taken and given back."""
    v, impulse, taken, given = np.array(before, float), np.zeros(2), 0.0, 0.0
    whole = dp = abs(v[0]) / W[0, 0] / steps
    for _ in range(1000 * steps):
        f = _friction(W, mu, v, dp)
        after = v + W @ (1.0, f) * dp
        work = 0.5 * (v[0] + after[0]) * dp
        turns = (v[1] != 0.0 and f != -np.sign(v[1]) * mu) or after[0] * v[0] < 0.0
        if (turns or (v[0] >= 0.0 and given + work > e**2 * taken)) and dp > FINEST * whole:
            dp *= 0.5
            continue
        taken -= min(work, 0.0)
        given += max(work, 0.0)
        v, impulse = after, impulse + np.array([1.0, f]) * dp
        v[np.abs(v) <= 1e-14 * abs(before[0])] = 0.0
        if v[0] >= 0.0 and given >= e**2 * taken * (1 - 1e-13):
            return impulse, v, taken, given
        dp = min(2.0 * dp, whole)
    raise ArithmeticError("the impact does not end")


def poisson(W: Array, mu: float, e: float, before: Array, steps: int = 20) -> tuple[Array, Array, bool]:
    """Impulses (normal, tangential), rates after, and whether sliding turned round within compression or expansion."""
    v, impulse, turned = np.array(before, float), np.zeros(2), False
    whole = abs(v[0]) / W[0, 0] / steps
    for expands in (False, True):
        end, dp, slid = (1.0 + e) * impulse[0] if expands else np.inf, whole, 0.0
        for _ in range(1000 * steps):
            if impulse[0] >= end * (1.0 - 1e-15) or (not expands and v[0] >= 0.0):
                break
            dp = min(dp, end - impulse[0])
            f = _friction(W, mu, v, dp)
            after = v + W @ (1.0, f) * dp
            turns = (v[1] != 0.0 and f != -np.sign(v[1]) * mu) or after[0] * v[0] < 0.0
            if turns and dp > FINEST * whole:
                dp *= 0.5
                continue
            v, impulse = after, impulse + np.array([1.0, f]) * dp
            v[np.abs(v) <= 1e-14 * np.max(np.abs(before))] = 0.0
            v[0] *= v[1] != 0.0 or abs(v[0]) > 1e-12 * np.max(np.abs(before))  # both end at once where W has rank 1
            turned |= slid * v[1] < 0.0
            slid, dp = v[1] or slid, min(2.0 * dp, whole)
        else:
            raise ArithmeticError("the impact does not end")
    return impulse, v, turned
