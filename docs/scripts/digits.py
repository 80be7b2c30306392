"""Where digits are lost (theory, section 4.11): accelerations against a dense solution in 60-digit arithmetic.

Prints three tables: a hinged chain whose masses differ by orders of magnitude, as the elimination leaves its
accelerations and with the repair, and a loop that is nearly flat.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from itertools import product
from typing import Any

import mpmath as mp  # type: ignore[import-untyped]
import numpy as np

from ccgen.generator import chain, generate, pinned
from ccgen.runtime import Model, load_model
from ccgen.runtime._core import Kernels

mp.mp.dps = 60
LINKS, STATES = 6, 20
PATTERNS: dict[str, tuple[bool, Callable[[int], bool]]] = {
    "light and heavy in turn": (False, lambda k: k % 2 == 0),
    "heavy tip on light links": (False, lambda k: k < LINKS - 1),
    "light links on a heavy root": (False, lambda k: k > 0),
    "heavy middle, pinned": (True, lambda k: k != LINKS // 2),
}
"""Whether both ends are pinned, and which links are light."""


def exact(model: Model, q: Any, u: Any, closed: bool) -> list[Any]:
    """Accelerations of a hinged (or, closed, pinned) chain of rods from its mass matrix and closure rows."""
    n, values = len(model.links), model.parameters
    q, u = [mp.mpf(x) for x in q.tolist()], [mp.mpf(x) for x in u.tolist()]
    length, mass, inertia, com = (
        [mp.mpf(values[f"link_{k}.{what}"]) for k in range(n)] for what in ("length", "mass", "inertia", "com.x")
    )
    size = n + 2 * closed
    matrix, right = mp.zeros(size, size), mp.zeros(size, 1)
    for k in range(n):
        arm = [length[j] if j < k else com[j] if j == k else mp.mpf(0) for j in range(n)]
        x = [-a * mp.sin(t) for a, t in zip(arm, q, strict=True)]
        y = [a * mp.cos(t) for a, t in zip(arm, q, strict=True)]
        bias_x = -sum(a * w**2 for a, w in zip(y, u, strict=True))
        bias_y = sum(a * w**2 for a, w in zip(x, u, strict=True)) + mp.mpf(values["gravity.g"])
        for i, j in product(range(n), repeat=2):
            matrix[i, j] += mass[k] * (x[i] * x[j] + y[i] * y[j])
        for i in range(n):
            right[i] -= mass[k] * (x[i] * bias_x + y[i] * bias_y)
        matrix[k, k] += inertia[k]
    if closed:
        for i in range(n):
            x, y = -length[i] * mp.sin(q[i]), length[i] * mp.cos(q[i])
            matrix[n, i] = matrix[i, n] = x
            matrix[n + 1, i] = matrix[i, n + 1] = y
            right[n] += y * u[i] ** 2
            right[n + 1] -= x * u[i] ** 2
    return list(mp.lu_solve(matrix, right))[:n]


def eliminated(model: Model, q: Any, u: Any) -> Any:
    """Accelerations as the elimination leaves them."""
    bare = Kernels(model._descriptor, np.array(list(model.parameters.values())), model.length)
    return bare.acceleration(q[None], u[None], 0.0)[0][0]


def error(model: Model, q: Any, u: Any, closed: bool, repaired: bool) -> float:
    """Largest error of the model's accelerations, relative to the largest of them."""
    found = (model.acceleration(q, u) if repaired else eliminated(model, q, u)).tolist()
    wanted = exact(model, q, u, closed)
    return float(max(abs(a - b) for a, b in zip(found, wanted, strict=True)) / max(map(abs, wanted)))


def worst(model: Model, q0: float, spread: float, closed: bool, repaired: bool = False) -> float:
    """Largest error over random states with angles within ``spread`` of ``q0``."""
    random, n = np.random.default_rng(0), len(model.links)
    states = [(q0 + spread * random.uniform(-1, 1, n), random.uniform(-2, 2, n)) for _ in range(STATES)]
    return max(error(model, q, u, closed, repaired) for q, u in states)


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        models = [load_model(generate(s, folder)) for s in (chain(LINKS, True, True), pinned(LINKS, True))]
        for repaired in (False, True):
            print("\nrepaired" if repaired else "as eliminated")
            print("ratio of masses |", " | ".join(PATTERNS))
            for power in range(0, 11, 2):
                errors = []
                for closed, light in PATTERNS.values():
                    masses = [10.0**-power if light(k) else 1.0 for k in range(LINKS)]
                    values = {f"link_{k}.mass": mass for k, mass in enumerate(masses)}
                    model = models[closed].with_parameters(
                        values | {f"link_{k}.inertia": mass / 12 for k, mass in enumerate(masses)}
                    )
                    errors.append(worst(model, 0.0, 3.0, closed, repaired))
                print(f"1e{power}", *(f"{e:.0e}" for e in errors), sep=" | ")
        model = load_model(generate(pinned(4, gravity=True), folder))
        print("\nflatness (rad) | error")
        for power in range(8):
            try:
                print(f"1e-{power} | {worst(model, 0.6, 10.0**-power, True):.0e}")
            except ValueError as refusal:
                print(f"1e-{power} | {refusal}")


if __name__ == "__main__":
    main()
