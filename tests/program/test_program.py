"""Records that check themselves, kernels without needless assignments, and operation counts that grow linearly."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

import numpy as np
import pytest
import sympy as sp

from ccgen.generator import chain, loop, pinned
from ccgen.generator.equations.equations import Argument, Assignment, Block, Equations, Kernel, Output
from ccgen.generator.equations.names import State
from ccgen.generator.mechanism.links import Parameter
from ccgen.generator.pipeline import derive_scene
from ccgen.generator.program.program import Counts, Function, Program, Section, _chain, count, lower
from ccgen.generator.scene.scene import Scene

M, Q, A, B, X = sp.symbols("m_0 theta_0 a b x")
MASS = Parameter("body.mass", "m_0", 2.0)


def _let(*pairs: tuple[sp.Symbol, sp.Expr]) -> tuple[Assignment, ...]:
    return tuple(Assignment(symbol, expression) for symbol, expression in pairs)


def _kernel(*entries: sp.Expr, guards: tuple[tuple[sp.Expr, sp.Expr], ...] = ()) -> Kernel:
    return Kernel("some", (Argument("q", (Q,), "angle"),), (Output("result", entries, "numbers"),), "test", guards)


def _equations(
    assignments: Sequence[Assignment], kernel: Kernel, parameters: tuple[Parameter, ...] = (MASS,)
) -> Equations:
    return Equations(parameters, State((Q,), ()), (Block("first", tuple(assignments)),), (kernel,))


# -- records that check themselves ---------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("assignments", "entry", "says"),
    [
        (_let((A, M * Q), (A, M * Q)), A, "a is defined twice"),
        (_let((A, M * Q), (A, M + Q)), A, "a is defined twice"),
        (_let((M, Q**2)), M, "m_0 is defined twice"),
        (_let((Q, M**2)), Q, "theta_0 is defined twice"),
        (_let((A, M * X)), A, "a uses undefined x"),
        (_let((A, M * B), (B, Q**2)), A, "a uses undefined b"),
        (_let((A, A + 1)), A, "a uses undefined a"),
        (_let((A, M * Q)), A + X, r"result uses undefined \['x'\]"),
    ],
    ids=lambda value: value.split("uses")[-1] if isinstance(value, str) else "",
)
def test_equations_with_a_wrong_name_are_refused(
    assignments: tuple[Assignment, ...], entry: sp.Expr, says: str
) -> None:
    with pytest.raises(ValueError, match=says):
        _equations(assignments, _kernel(entry))


def test_parameters_with_one_symbol_are_refused() -> None:
    with pytest.raises(ValueError, match="share a symbol"):
        _equations(_let((A, M * Q)), _kernel(A), (MASS, Parameter("other.mass", "m_0", 1.0)))


@pytest.mark.parametrize(
    ("assignments", "constants", "entry", "says"),
    [
        (_let((A, M * Q)), (), A, "a uses undefined"),
        (_let((A, B * Q), (B, Q**2)), (M,), A, "a uses undefined"),
        (_let((A, M * Q)), (M,), B, "entry of result is not defined"),
    ],
)
def test_functions_with_a_wrong_name_are_refused(
    assignments: tuple[Assignment, ...], constants: tuple[sp.Symbol, ...], entry: sp.Expr, says: str
) -> None:
    with pytest.raises(ValueError, match=says):
        Function(_kernel(entry), (Section("first", assignments),), constants)


def test_constants_that_are_not_made_from_parameters_are_refused() -> None:
    assert Program((MASS,), _let((A, M**2), (B, A + M)), ()).constants[1].symbol == B
    for wrong in (_let((A, Q**2)), _let((A, B + M), (B, M**2))):
        with pytest.raises(ValueError, match="constant a is not made from parameters"):
            Program((MASS,), wrong, ())


# -- slices --------------------------------------------------------------------------------------------------------


def test_a_function_holds_what_its_kernel_needs_in_order() -> None:
    unused, c, d = sp.symbols("unused c d")
    assignments = _let((A, M**2), (c, sp.cos(Q)), (unused, c * M), (d, 3 * M), (B, A * c))
    program = lower(_equations(assignments, _kernel(B)))
    function = program.function("some")
    assert [a.symbol.name for a in function.assignments()] == ["c", "b"]
    assert [a.symbol.name for a in program.constants] == ["a"]
    assert function.constants == (A,)
    assert function.inputs_used() == (("q", 0, Q),)
    with pytest.raises(KeyError, match="other"):
        program.function("other")


def test_what_only_a_guard_needs_is_kept() -> None:
    assignments = _let((A, M * Q), (B, M * Q + 1))
    function = lower(_equations(assignments, _kernel(A, guards=((B, A),)))).function("some")
    assert [a.symbol.name for a in function.assignments()] == ["a", "b"]


SCENES = {
    "loop": lambda: loop(6, gravity=True),
    "chain": lambda: chain(3),
    "hinged": lambda: chain(3, hinged=True, gravity=True),
    "pinned": lambda: pinned(3),
}


@pytest.mark.parametrize("name", SCENES)
def test_no_kernel_computes_what_it_does_not_use(name: str) -> None:
    for function in _program(SCENES[name]()).functions:
        used = {s for output in function.kernel.outputs for entry in output.entries for s in entry.free_symbols}
        used |= {s for guard in function.kernel.guards for entry in guard for s in entry.free_symbols}
        for assignment in reversed(function.assignments()):
            assert assignment.symbol in used, f"{function.kernel.name} does not use {assignment.symbol}"
            used |= assignment.expression.free_symbols
        assert set(function.constants) <= used


@pytest.mark.parametrize("name", SCENES)
def test_what_parameters_decide_is_computed_once(name: str) -> None:
    program = _program(SCENES[name]())
    fixed = {sp.Symbol(p.symbol) for p in program.parameters} | {a.symbol for a in program.constants}
    for function in program.functions:
        for assignment in function.assignments():
            assert not assignment.expression.free_symbols <= fixed, assignment
    needed = {s for f in program.functions for s in f.constants}
    for assignment in reversed(program.constants):
        assert assignment.symbol in needed, f"no kernel needs {assignment.symbol}"
        needed |= assignment.expression.free_symbols


# -- counts --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("expression", "expected"),
    [
        (A, (0, 0, 0, 0)),
        (-A, (0, 0, 0, 0)),
        (A + B - X, (2, 0, 0, 0)),
        (A * B * X, (0, 2, 0, 0)),
        (-A * B, (0, 1, 0, 0)),
        (2 * A, (0, 1, 0, 0)),
        (A**2, (0, 1, 0, 0)),
        (A**3, (0, 2, 0, 0)),
        (1 / A, (0, 0, 1, 0)),
        (B / A, (0, 0, 1, 0)),
        (B / A**2, (0, 1, 1, 0)),
        (sp.sqrt(A), (0, 0, 1, 0)),
        (A * B - X**2, (1, 2, 0, 0)),
        ((A + B) * (A - X), (2, 1, 0, 0)),
        (sp.sin(A), (0, 0, 0, 1)),
        (sp.cos(A), (0, 0, 0, 1)),
        (sp.cos(A) + sp.cos(B), (1, 0, 0, 2)),
        (sp.sin(A) * B + sp.cos(A) * X, (1, 2, 0, 1)),
    ],
    ids=str,
)
def test_counts_of_expressions(expression: sp.Expr, expected: tuple[int, int, int, int]) -> None:
    counts = count([expression])
    assert counts == Counts(*expected)
    assert counts.total == sum(expected[:3])


@cache
def _acceleration(links: int) -> Counts:
    return _program(loop(links, gravity=True), "tip to root").function("acceleration").counts()


@pytest.mark.hard
def test_the_operations_of_the_acceleration_grow_linearly() -> None:
    sizes = np.array([4, 6, 8, 12, 16, 24, 32, 48, 64])
    totals = np.array([_acceleration(int(n)).total for n in sizes])
    exponent = np.polyfit(np.log(sizes), np.log(totals), 1)[0]
    assert exponent <= 1.05
    steps = np.diff(totals[2:]) / np.diff(sizes[2:])
    assert np.ptp(steps) <= 0.02 * steps.mean()


def test_the_operations_of_the_hexagon() -> None:
    counts = _acceleration(6)
    assert counts.total <= 600
    assert counts.angles == 6


def test_the_longest_chain_of_expressions() -> None:
    """Two at a time, what is ready first: (a + b) + (c + d) takes two, one that is late takes one more."""
    *x, late = sp.symbols("a b c d late")
    assert _chain(sp.Add(*x), {}) == 2
    assert _chain(sp.Add(*x, late), {late: 5}) == 6
    assert _chain(sp.Mul(*x) / (x[0] + x[1]), {}) == 3
    assert _chain(1 / x[0] - x[1] * x[2], {}) == 2
    assert _chain(x[0] ** 4 + 1, {}) == 3


@pytest.mark.hard
def test_the_longest_chain_of_a_ring_grows_with_half_of_it_and_less_in_segments() -> None:
    chain = {
        (n, plan): _program(loop(n), plan).function("acceleration").longest_chain()
        for n, plan in ((25, "tip to root"), (49, "tip to root"), (25, "segments"), (49, "segments"))
    }
    assert chain[49, "tip to root"] - chain[25, "tip to root"] == 7 * 24
    assert chain[49, "segments"] - chain[25, "segments"] <= 3.5 * 24


def _program(scene: Scene, plan: str | None = None) -> Program:
    return lower(derive_scene(scene, plan=plan)[1])


# -- what a scene does not name ------------------------------------------------------------------------------------


def test_effects_that_a_scene_does_not_name_are_absent() -> None:
    bare, heavy = (derive_scene(loop(4, gravity=gravity))[1] for gravity in (False, True))
    gravity = sp.Symbol("g")
    assert gravity in _names(heavy)
    assert gravity not in _names(bare)
    assert [p.path for p in heavy.parameters if p not in bare.parameters] == ["gravity.g"]
    for equations in (bare, heavy):
        assert not {"gaps", "gap_rates", "contact_impulse", "restitution"} & {k.name for k in equations.kernels}
        assert equations.contacts == ()
        assert not [s for s in _names(equations) if s.name.startswith(("n_", "nu_", "N_", "offset"))]
        assert not [p.path for p in equations.parameters if p.path.startswith("ground")]


def _names(equations: Equations) -> set[sp.Symbol]:
    found = {s for a in equations.assignments() for s in (a.symbol, *a.expression.free_symbols)}
    return found | {
        s for kernel in equations.kernels for output in kernel.outputs for e in output.entries for s in e.free_symbols
    }
