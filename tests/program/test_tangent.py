"""Derivatives of the program, line by line, against SymPy's of the same equations with everything put in."""

from __future__ import annotations

import math
from typing import Any

import pytest
import sympy as sp

from ccgen.generator.equations.equations import Argument, Assignment, Kernel, Output
from ccgen.generator.equations.step import step
from ccgen.generator.pipeline import derive_scene
from ccgen.generator.program.dialects import LISTING, C
from ccgen.generator.program.program import Function, Program, Section, lower
from ccgen.generator.program.residuals import residuals
from ccgen.generator.program.rolling import Lines, Loop
from ccgen.generator.program.routine import Routines
from ccgen.generator.program.tangent import Tangent, tangent
from ccgen.generator.scene import load_scene, loop

from ..support.folders import ROOT
from ..support.tiers import all_hard_but

MATH: dict[str, Any] = {
    name: getattr(math, name) for name in ("sin", "cos", "tan", "atan", "exp", "log", "tanh", "sqrt")
} | {"abs": abs, "step": lambda x: float(x > 0)}


class Array(dict[int, float]):
    """Numbers by index, all of them there once written."""


def run(one: Tangent, at: dict[str, list[float]], along: dict[str, list[float]]) -> list[float]:
    """The tangents, by Python: statements are written as in the listing, which Python reads."""
    names: dict[str, Any] = dict(MATH) | at | {f"delta_{name}": value for name, value in along.items()}
    names["t"], names["lambda_"], names["delta_lambda_"] = at["t"][0], at.get("lambda"), along.get("lambda")
    angles = [at["q"][i] for i in one.routine.angles.order]
    names["c"], names["s"] = [math.cos(x) for x in angles], [math.sin(x) for x in angles]
    for name, _ in (*one.value_arrays, *one.arrays, ("tangent", 0)):
        names[name] = Array()
    lines = [Lines("loads", one.loads), *one.values, *one.statements, Lines("outputs", one.outputs)]
    for part in lines:
        for i in range(part.rounds if isinstance(part, Loop) else 1):
            names["i"] = i
            for block in part.body if isinstance(part, Loop) else (part,):
                for line in block.lines:
                    text = f"{LISTING.text(line.target)} = {LISTING.text(line.value)}"
                    exec(text.replace("lambda[", "lambda_["), {}, names)
    return [names["tangent"][i] for i in range(one.results)]


def derived(function: Function, program: Program, given: list[str], along: Any, at: Any) -> list[float]:
    """The same by SymPy."""
    values = {sp.Symbol(p.symbol): sp.Float(p.value, 30) for p in program.parameters}
    meaning: dict[sp.Basic, sp.Expr] = dict(values)
    for a in (*program.constants, *function.assignments()):
        meaning[a.symbol] = a.expression.xreplace(meaning)
    moving, state = [], {}
    for argument in function.kernel.inputs:
        for i, symbol in enumerate(argument.symbols):
            state[symbol] = sp.Float(at[argument.name][i], 30)
            if argument.name in given:
                moving.append((symbol, sp.Float(along[argument.name][i], 30)))
    found = []
    for output in function.kernel.outputs:
        for entry in output.entries:
            whole = entry.xreplace(meaning)
            found.append(float(sp.Add(*(whole.diff(symbol) * by for symbol, by in moving)).xreplace(state)))
    return found


def numbers(function: Function, start: float) -> dict[str, list[float]]:
    return {
        argument.name: [math.sin(start + 1.7 * i + len(argument.name)) for i in range(len(argument.symbols))]
        for argument in function.kernel.inputs
    } | ({} if any(a.name == "t" for a in function.kernel.inputs) else {"t": [0.0]})


def constants_of(program: Program) -> list[float]:
    values: dict[sp.Basic, float] = {sp.Symbol(p.symbol): p.value for p in program.parameters}
    for a in program.constants:
        values[a.symbol] = float(a.expression.xreplace({s: sp.Float(v, 30) for s, v in values.items()}))
    return list(values.values())


FUNCTIONS = ("residual", "jump", "acceleration", "energy", "closure_rate", "points")


@pytest.mark.parametrize("name", all_hard_but("residual", "jump", "closure_rate", of=FUNCTIONS))
def test_a_four_bars_functions_have_sympys_derivatives(name: str) -> None:
    """That of the acceleration too, which the runtime takes another way: through the elimination, line by line."""
    _, equations = derive_scene(load_scene(ROOT / "scenes" / "four-bar.toml"))
    program = lower(equations)
    function = next(f for f in (*program.functions, *residuals(equations)) if f.kernel.name == name)
    given = [argument.name for argument in function.kernel.inputs]
    one = tangent(Routines(program, C.term).link_by_link(function), name, given)
    at, along = numbers(function, 0.3), numbers(function, 0.8)
    found = run(one, at | {"k": constants_of(program)}, along)
    wanted = derived(function, program, given, along, at)
    assert found == pytest.approx(wanted, rel=1e-9, abs=1e-9 * max(map(abs, wanted)))


X, Y = sp.symbols("x y", real=True)


@pytest.mark.parametrize(
    "expression",
    [
        sp.sin(X * Y),
        sp.cos(X + Y) ** 3,
        sp.tan(X) / Y,
        sp.atan(X / Y),
        sp.exp(-X * Y),
        sp.log(X * X + Y),
        sp.tanh(X - Y) * X,
        sp.sqrt(X * X + Y * Y),
        1 / sp.sqrt(X + Y),
        sp.Abs(X - 2 * Y) * Y,
        step(X - 0.1) * X * Y + step(Y - 9) * X**2,
        X / (Y * (X + Y)) - 3 * X / 7,
        sp.Rational(1, 3) * X**4 * Y**2 / (1 + X**2),
        (X + Y) * (X - Y) / (X * Y),
    ],
)
def test_every_kind_of_term_has_its_derivative(expression: sp.Expr) -> None:
    kernel = Kernel("probe", (Argument("u", (X, Y), ""),), (Output("out", (sp.Symbol("v"),), ""),), "")
    section = Section("all", (Assignment(sp.Symbol("v"), expression),))
    function = Function(kernel, (section,), ())
    program = Program((), (), (function,))
    one = tangent(Routines(program, C.term).link_by_link(function), "probe", ("u",))
    at, along = {"u": [0.7, 0.4], "t": [0.0], "q": [], "k": []}, {"u": [1.3, -0.6]}
    values = {X: sp.Float(0.7), Y: sp.Float(0.4)}
    wanted = float((expression.diff(X) * 1.3 - expression.diff(Y) * 0.6).xreplace(values))
    assert run(one, at, along) == pytest.approx([wanted], rel=1e-12)


def test_at_a_kink_it_is_the_side_below() -> None:
    """An absolute value falls on the side below zero, as a step is zero there."""
    kernel = Kernel("probe", (Argument("u", (X, Y), ""),), (Output("out", (sp.Symbol("v"),), ""),), "")
    value = sp.Abs(X) + step(X) * Y
    function = Function(kernel, (Section("all", (Assignment(sp.Symbol("v"), value),)),), ())
    one = tangent(Routines(Program((), (), (function,)), C.term).link_by_link(function), "probe", ("u",))
    assert run(one, {"u": [0.0, 2.0], "t": [0.0], "q": [], "k": []}, {"u": [1.0, 1.0]}) == [-1.0]


def test_what_does_not_move_costs_nothing() -> None:
    """Along the rates of a ring no line of the configuration has tangents, and loops over links stay loops."""
    _, equations = derive_scene(loop(24, gravity=True))
    program = lower(equations)
    routines = Routines(program, C.term)
    function = residuals(equations)[0]
    by_u, by_q = (tangent(routines.link_by_link(function), name, (name,)) for name in ("u", "q"))

    def lines(one: Tangent) -> int:
        return sum(len(b.lines) for part in one.statements for b in (part.body if isinstance(part, Loop) else (part,)))

    assert lines(by_u) < lines(by_q)
    assert by_u.moving == ("u",)
    assert any(isinstance(part, Loop) for part in by_q.statements)
    still = tangent(routines.link_by_link(program.function("closure")), "closure", ("u",))
    assert still.vanishes
