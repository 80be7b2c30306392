"""Four derivations of the accelerations of one row of rods, each as a program of assignments and, at its end, a solve.

As a script it derives one of them, measures, checks it against the exact accelerations, and prints one line of JSON:
`python benchmarks/derivations.py FORMULATION FAMILY N LIMIT`. It ends with status 3 when the limit is over.
"""

import json
import os
import sys
import threading
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import sympy as sp
import sympy.physics.mechanics as me
from rods import GRAVITY, Array, Rods, rods

from ccgen.generator import Scene, chain, loop
from ccgen.generator.derive import derivation  # noqa: F401 - before the clock starts
from ccgen.generator.derive.expanded import expand
from ccgen.generator.mechanism.topology import span
from ccgen.generator.pipeline import derive_scene
from ccgen.generator.planning.choose import TIP_TO_ROOT
from ccgen.generator.program.program import Counts, count, lower

OVER = 3
"""Exit status of a derivation that was given up."""


@dataclass(frozen=True)
class Derived:
    """``assignments`` in order, then ``matrix``·x = ``right``, the accelerations first in x; x = ``right`` without it.

    ``parameters``, ``q`` and ``u`` are the symbols that are given, the latter two in the order: position of the rod
    ``root`` if the row floats, then all angles.
    """

    parameters: dict[sp.Symbol, float]
    q: tuple[sp.Symbol, ...]
    u: tuple[sp.Symbol, ...]
    assignments: list[tuple[sp.Symbol, sp.Expr]]
    matrix: sp.Matrix | None
    right: sp.Matrix
    symmetric: bool
    root: int = 0

    def counts(self) -> Counts:
        """Operations before the solve; what depends on parameters alone is computed once and not counted."""
        constant, moving = set(self.parameters), []
        for symbol, expression in self.assignments:
            if expression.free_symbols <= constant:
                constant.add(symbol)
            else:
                moving.append(expression)
        return count([*moving, *self._outputs()])

    def solve_operations(self) -> int:
        """Operations of the solve: LDLᵀ of a symmetric matrix, of which one half is evaluated, otherwise LU."""
        return 0 if self.matrix is None else solve_operations(len(self.right), self.symmetric)

    def accelerations(self, q: Array, u: Array) -> Array:
        """du/dt at one state."""
        names: dict[str, object] = {"sin": np.sin, "cos": np.cos, "sqrt": np.sqrt}
        given = [*self.parameters.items(), *zip(self.q, q, strict=True), *zip(self.u, u, strict=True)]
        names.update({symbol.name: value for symbol, value in given})

        def value(expression: sp.Expr) -> float:
            return float(eval(sp.pycode(expression).replace("math.", ""), names))

        for symbol, expression in self.assignments:
            names[symbol.name] = value(expression)
        right = np.array([value(entry) for entry in self.right])
        if self.matrix is None:
            return right[: len(u)]
        matrix = np.array([value(entry) for entry in self.matrix]).reshape(self.matrix.shape)
        return np.linalg.solve(matrix, right)[: len(u)]

    def _outputs(self) -> Iterable[sp.Expr]:
        if self.matrix is not None:
            rows, columns = self.matrix.shape
            yield from (self.matrix[i, j] for i in range(rows) for j in range(columns) if j >= i or not self.symmetric)
        yield from self.right


def solve_operations(size: int, symmetric: bool) -> int:
    """Sums, products and quotients of a dense elimination without exchanges, one right-hand side."""
    total = 0
    for below in reversed(range(size)):  # rows below each pivot: its reciprocal, the factors, the update
        total += 1 + below + 2 * (below * (below + 1) // 2 if symmetric else below * below)
    return total + 2 * size * (size - 1) + size  # forward and back substitution, division by the pivots


def recursive(row: Rods) -> Derived:
    """ccgen's recursion from tip to root, down to the program of its acceleration."""
    scene = _scene(row)
    topology, equations = derive_scene(scene, plan=TIP_TO_ROOT)
    program = lower(equations)
    function = program.function("acceleration")
    values = _values(row)
    return Derived(
        {sp.Symbol(p.symbol): values[p.path] for p in program.parameters},
        equations.state.q,
        equations.state.u,
        [(a.symbol, a.expression) for a in (*program.constants, *function.assignments())],
        None,
        sp.Matrix(function.kernel.outputs[0].entries),
        symmetric=True,
        root=max(topology.root, 0),
    )


def closed_form(row: Rods) -> Derived:
    """M u̇ + h = Aᵀλ and A u̇ + Ȧu = 0 of the virtual open chain, as ``ccgen show --expand`` writes them, then CSE."""
    scene = _scene(row)
    topology = span(scene.mechanism)
    form = expand(scene.mechanism, topology, scene.effects, limit=len(row.masses))
    values = _values(row)
    parameters = [p for owner in (scene.mechanism, *scene.effects) for p in owner.parameters()]
    given = {sp.Symbol(p.symbol): values[p.path] for p in parameters}
    none = sp.zeros(form.A.rows, form.A.rows)
    matrix = sp.Matrix(sp.BlockMatrix([[form.M, -form.A.T], [-form.A, none]])) if form.A.rows else sp.Matrix(form.M)
    right = sp.Matrix([*(-form.h), *form.A_rate])
    return _cse(given, (form.state.q, form.state.u), matrix, right, symmetric=True, root=max(topology.root, 0))


def kane(row: Rods) -> Derived:
    """SymPy's KanesMethod; of a loop, the last two angles depend on the others."""
    model = _Mechanics(row)
    held = 2 if model.closure else 0
    free = len(model.q) - held
    dependent = {
        "q_dependent": model.q[free:],
        "u_dependent": model.u[free:],
        "configuration_constraints": model.closure,
        "velocity_constraints": [gap.diff(me.dynamicsymbols._t).subs(model.rates) for gap in model.closure],
    }
    method = me.KanesMethod(
        model.frame, model.q[:free], model.u[:free], kd_eqs=model.kinematics, **(dependent if held else {})
    )
    method.kanes_equations(model.bodies, model.loads)
    return model.derived(method.mass_matrix, method.forcing, symmetric=not held)


def lagrange(row: Rods) -> Derived:
    """SymPy's LagrangesMethod; a loop is closed by multipliers."""
    model = _Mechanics(row, speeds=False)
    options = {"hol_coneqs": model.closure} if model.closure else {}
    energy = me.Lagrangian(model.frame, *model.bodies)
    method = me.LagrangesMethod(energy, model.q, forcelist=model.loads, frame=model.frame, **options)
    method.form_lagranges_equations()
    known = len(model.q)  # the first rows say that q' is q'
    return model.derived(method.mass_matrix_full[known:, known:], method.forcing_full[known:, :], symmetric=True)


FORMULATIONS: dict[str, Callable[[Rods], Derived]] = {
    "recursive": recursive,
    "closed_form": closed_form,
    "kane": kane,
    "lagrange": lagrange,
}


class _Mechanics:
    """The rods as points, frames and bodies of ``sympy.physics.mechanics``; absolute angles, as in ccgen."""

    def __init__(self, row: Rods, speeds: bool = True) -> None:
        n, floats = len(row.masses), row.family == "loop"
        names = [*(["x", "y"] if floats else []), *(f"theta_{k}" for k in range(n))]
        self.q = list(me.dynamicsymbols(names))
        self.dots = [q.diff() for q in self.q]
        self.u = list(me.dynamicsymbols([f"w_{name}" for name in names])) if speeds else self.dots
        self.kinematics = [dot - u for dot, u in zip(self.dots, self.u, strict=True)]
        self.rates = dict(zip(self.dots, self.u, strict=True))
        self.parameters: dict[sp.Symbol, float] = {sp.Symbol("g"): GRAVITY}
        self.frame = me.ReferenceFrame("N")
        end = me.Point("O")
        end.set_vel(self.frame, self.u[0] * self.frame.x + self.u[1] * self.frame.y if floats else 0)
        self.bodies, self.loads, reach = [], [], 0 * self.frame.x
        for k in range(n):
            end, step = self._rod(row, k, end)
            reach += step
        self.closure = [reach.dot(axis) for axis in (self.frame.x, self.frame.y)] if floats else []

    def derived(self, matrix: sp.Matrix, right: sp.Matrix, symmetric: bool) -> Derived:
        """Functions of time replaced by symbols, then CSE, as those who generate code from these methods do."""
        q = tuple(sp.Symbol(function.func.__name__) for function in self.q)
        u = tuple(sp.Symbol(f"u_{symbol.name}") for symbol in q)
        plain = {**dict(zip(self.u, u, strict=True)), **dict(zip(self.q, q, strict=True))}
        matrix, right = me.msubs(matrix, plain), me.msubs(right, plain)
        return _cse(self.parameters, (q, u), matrix, right, symmetric)

    def _rod(self, row: Rods, k: int, start: me.Point) -> tuple[me.Point, me.Vector]:
        """Body k and its weight; the end of the rod, and the vector from its start."""
        given = (row.masses[k], row.inertias[k], row.lengths[k], row.centres[k])
        mass, inertia, length, centre = (sp.Symbol(f"{name}_{k}") for name in ("m", "I", "l", "c"))
        self.parameters.update(zip((mass, inertia, length, centre), map(float, given), strict=True))
        first = len(self.q) - len(row.masses)
        turned = self.frame.orientnew(f"A_{k}", "Axis", [self.q[first + k], self.frame.z])
        turned.set_ang_vel(self.frame, self.u[first + k] * self.frame.z)
        middle, end = start.locatenew(f"G_{k}", centre * turned.x), start.locatenew(f"P_{k}", length * turned.x)
        for point in (middle, end):
            point.v2pt_theory(start, self.frame, turned)
        about = (me.inertia(turned, 0, 0, inertia), middle)
        self.bodies.append(me.RigidBody(f"rod_{k}", middle, turned, mass, about))
        self.loads.append((middle, -mass * sp.Symbol("g") * self.frame.y))
        return end, length * turned.x


def _scene(row: Rods) -> Scene:
    n = len(row.masses)
    return loop(n, gravity=True) if row.family == "loop" else chain(n, hinged=True, gravity=True)


def _values(row: Rods) -> dict[str, float]:
    """Parameter values by their names in a scene."""
    found = {"gravity.g": GRAVITY}
    for k in range(len(row.masses)):
        given = zip(("mass", "inertia", "length"), (row.masses, row.inertias, row.lengths), strict=True)
        found.update({f"link_{k}.{name}": float(values[k]) for name, values in given})
        found[f"link_{k}.com.x"] = float(row.centres[k])
    return found


def _cse(
    parameters: dict[sp.Symbol, float],
    state: tuple[Sequence[sp.Symbol], Sequence[sp.Symbol]],
    matrix: sp.Matrix,
    right: sp.Matrix,
    symmetric: bool,
    root: int = 0,
) -> Derived:
    assignments, (matrix, right) = sp.cse([matrix, right], symbols=sp.numbered_symbols("z_"))
    return Derived(parameters, tuple(state[0]), tuple(state[1]), assignments, matrix, right, symmetric, root)


def _error(derived: Derived, row: Rods) -> float:
    """Largest error of any acceleration (of the root's position and of all angles), over the largest of them."""
    place = [0.0] * (len(derived.q) - len(row.angles))
    expected = np.concatenate([row.accelerations[derived.root, : len(place)], row.accelerations[:, 2]])
    found = derived.accelerations(np.array([*place, *row.angles]), np.array([*place, *row.rates]))
    return float(np.abs(found - expected).max() / np.abs(expected).max())


def _watch(done: threading.Event, end: float) -> None:
    """End the process when it has used its processor time."""
    while not done.wait(0.05):
        if time.process_time() > end:
            os._exit(OVER)


def main() -> None:
    """Derive, measure, check, print."""
    name, family, n, limit = sys.argv[1], sys.argv[2], int(sys.argv[3]), float(sys.argv[4])
    row = rods(family, n)
    done = threading.Event()
    start = time.process_time()
    threading.Thread(target=_watch, args=(done, start + limit), daemon=True).start()
    derived = FORMULATIONS[name](row)
    seconds = time.process_time() - start
    done.set()
    counts = derived.counts()
    record = {
        "seconds": seconds,
        "equations": counts.total,
        "solve": derived.solve_operations(),
        "angles": counts.angles,
        "error": _error(derived, row),
    }
    print(json.dumps(record))


if __name__ == "__main__":
    main()
