"""The woodpecker toy by Moreau's time stepping, with equations written by hand: large angles, or Glocker's small ones.

Coordinates are the height of the sleeve, its angle and the bird's; contacts are the beak, the sleeve's lower edge and
its upper one.
"""

from __future__ import annotations

import math

import numpy as np

M_SLEEVE, J_SLEEVE, M_BIRD, J_BIRD, STIFFNESS = 0.3e-3, 5.0e-9, 4.5e-3, 7.0e-7, 5.6e-3
R_POLE, R_SLEEVE, H_SLEEVE, L_SPRING, L_BIRD, L_BEAK, H_BEAK = 2.5e-3, 3.1e-3, 5.8e-3, 10e-3, 15e-3, 20.1e-3, 20e-3
FRICTION, G = 0.3, 9.81
RESTITUTION = (0.5, 0.0, 0.0)
START = ((0.0, -0.1036, -0.2788), (-0.3411, 0.0, -7.4583))


def motion(q: np.ndarray, u: np.ndarray, small: bool) -> tuple[np.ndarray, np.ndarray]:
    """Masses (3, 3) and forces (3,) without those of contacts; ``small``: of first order in the angles."""
    cs, cb, ss, sb = (1.0, 1.0, 0.0, 0.0) if small else (*np.cos(q[1:]), *np.sin(q[1:]))
    across, whirl = (1.0, 0.0) if small else (math.cos(q[1] - q[2]), math.sin(q[1] - q[2]))
    a, b = M_BIRD * L_SPRING, M_BIRD * L_BIRD
    mass = np.array(
        [
            [M_SLEEVE + M_BIRD, a * cs, b * cb],
            [a * cs, J_SLEEVE + a * L_SPRING, a * L_BIRD * across],
            [b * cb, a * L_BIRD * across, J_BIRD + b * L_BIRD],
        ]
    )
    twist = STIFFNESS * (q[1] - q[2])
    force = np.array(
        [
            a * ss * u[1] ** 2 + b * sb * u[2] ** 2 - (M_SLEEVE + M_BIRD) * G,
            -a * L_BIRD * whirl * u[2] ** 2 - a * G * cs - twist,
            a * L_BIRD * whirl * u[1] ** 2 - b * G * cb + twist,
        ]
    )
    return mass, force


def contacts(q: np.ndarray, small: bool) -> list[tuple[float, np.ndarray, np.ndarray]]:
    """Gap, row of the normal and row along the pole of beak, lower edge and upper edge."""
    if small:
        back = L_BIRD - L_BEAK
        return [
            (L_SPRING + back - R_POLE - H_BEAK * q[2], np.array([0, 0, -H_BEAK]), np.array([1, L_SPRING, back])),
            (R_SLEEVE - R_POLE + H_SLEEVE * q[1], np.array([0, H_SLEEVE, 0]), np.array([1, R_SLEEVE, 0])),
            (R_SLEEVE - R_POLE - H_SLEEVE * q[1], np.array([0, -H_SLEEVE, 0]), np.array([1, R_SLEEVE, 0])),
        ]
    cs, cb, ss, sb = *np.cos(q[1:]), *np.sin(q[1:])
    bird = complex(L_BIRD - L_BEAK, H_BEAK) * complex(cb, sb)
    low, high = (complex(R_SLEEVE, side * H_SLEEVE) * complex(cs, ss) for side in (-1, 1))
    beak = L_SPRING * complex(cs, ss)
    return [
        (
            (beak + bird).real - R_POLE,
            np.array([0, (1j * beak).real, (1j * bird).real]),
            np.array([1, (1j * beak).imag, (1j * bird).imag]),
        ),
        *(
            (edge.real - R_POLE, np.array([0, (1j * edge).real, 0]), np.array([1, (1j * edge).imag, 0]))
            for edge in (low, high)
        ),
    ]


def pecks(until: float, step: float, small: bool = False) -> np.ndarray:
    """Times and heights (n, 2) of the instants at which the beak strikes."""
    q, u = (np.array(one) for one in START)
    found: list[tuple[float, float]] = []
    for k in range(int(until / step)):
        middle = q + 0.5 * step * u
        mass, force = motion(middle, u, small)
        inverse = np.linalg.inv(mass)
        free = u + inverse @ force * step
        all_contacts = contacts(middle, small)
        closed = [i for i in range(3) if all_contacts[i][0] <= 0.0]
        after = strike(inverse, u, free, [(RESTITUTION[i], *all_contacts[i][1:]) for i in closed])
        if 0 in closed and all_contacts[0][1] @ u < -1e-3:
            found.append((k * step, float(q[0])))
        q, u = middle + 0.5 * step * after, after
    return np.array(found)


def strike(
    inverse: np.ndarray, before: np.ndarray, free: np.ndarray, rows: list[tuple[float, np.ndarray, np.ndarray]]
) -> np.ndarray:
    """Velocities after the impulses of the step, by projections in turn until they stay."""
    if not rows:
        return free
    both = np.array([row for _, normal, along in rows for row in (normal, along)], dtype=float)
    delassus = (both @ inverse @ both.T).tolist()
    rates, returned = (both @ free).tolist(), [one * float(normal @ before) for one, normal, _ in rows]
    impulses = [0.0] * len(both)
    for _ in range(200):
        moved = 0.0
        for k in range(len(both)):
            wanted = impulses[k] - (rates[k] + (0.0 if k % 2 else returned[k // 2])) / delassus[k][k]
            most = FRICTION * impulses[k - 1]
            wanted = min(max(wanted, -most), most) if k % 2 else max(0.0, wanted)
            change, impulses[k] = wanted - impulses[k], wanted
            rates = [rate + row[k] * change for rate, row in zip(rates, delassus, strict=True)]
            moved = max(moved, abs(change))
        if moved < 1e-13:
            break
    return np.asarray(free + inverse @ both.T @ impulses)
