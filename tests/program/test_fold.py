"""Folded models: the same numbers from fewer operations, with parameters that can be read and not set."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sympy as sp

from ccgen.generator import FoldError, Scene, chain, generate, load_scene, loop, pinned
from ccgen.generator.equations.equations import Argument, Assignment, Block, Equations, Kernel, Output
from ccgen.generator.equations.names import State
from ccgen.generator.mechanism.links import Parameter
from ccgen.generator.mechanism.topology import span
from ccgen.generator.pipeline import derive_scene, listing
from ccgen.generator.program.dialects import LISTING, write
from ccgen.generator.program.fold import fold
from ccgen.generator.program.program import Counts, lower
from ccgen.generator.program.reading import read_listing
from ccgen.runtime import Model, load_model, simulate

from ..support.command_line import ccgen
from ..support.effect_examples import EXAMPLES, SCENE
from ..support.folders import ROOT
from ..support.tiers import all_hard_but
from ..support.workshop import Workshop

FILES = sorted((ROOT / "scenes").glob("*.toml"))
SCENES: dict[str, Callable[[Workshop], Scene]] = {
    **{file.stem: lambda workshop, file=file: load_scene(file) for file in FILES},  # type: ignore[misc]
    "every effect": lambda workshop: workshop.scene(SCENE + "".join(EXAMPLES.values())),
    "loop": lambda workshop: loop(12, gravity=True),
    "chain": lambda workshop: chain(9),
    "pinned": lambda workshop: pinned(3, gravity=True),
}
FEW = ("falling-hexagon", "four-bar", "slider-crank", "every effect", "pinned")
SAME = 1e-14
"""Relative difference of folded results: some tens of roundings."""
SOLVING, FEW_LOOPS = ("acceleration", "impulse"), 6
"""Kernels that solve for the loops' multipliers. At angles drawn blindly many loops are close to singular somewhere,
and rounding grows: more loops than these are compared at consistent configurations. No two programs agree better on
these kernels than to what the last digit of their arguments changes."""
NEIGHBOURS = 8
"""States beside one that tell how far rounding of a state moves what is solved for."""
STRIDE = 0.05
"""Largest step of a coordinate (rad, m) from one of these to the next."""


@pytest.fixture(scope="module", params=all_hard_but(*FEW, of=SCENES))
def scene(request: pytest.FixtureRequest, workshop: Workshop) -> Scene:
    return SCENES[request.param](workshop)


@pytest.fixture(scope="module")
def hexagon() -> Scene:
    return load_scene(next(file for file in FILES if file.stem == "falling-hexagon"))


def _miss(found: Any, wanted: Any) -> float:
    """Largest difference relative to the largest value."""
    found, wanted = np.asarray(found), np.asarray(wanted)
    scale = float(np.max(np.abs(wanted), initial=0.0))
    return float(np.max(np.abs(found - wanted), initial=0.0)) / (scale or 1.0)


def _rounded(q: Any, u: Any, rng: np.random.Generator) -> tuple[Any, Any]:
    """A state beside this one: each number goes one step of the type up or down, as rounding sends it."""
    return tuple(np.nextafter(values, rng.choice([-np.inf, np.inf], values.shape)) for values in (q, u))


# -- the same numbers ----------------------------------------------------------------------------------------------


def _consistent(model: Model, count: int, rng: np.random.Generator) -> np.ndarray[Any, Any]:
    """Configurations (nq, count) with closed loops: a random walk from the start."""
    q, found = model.start()[0], []
    for _ in range(count):
        _, u = model.project(q, rng.uniform(-1, 1, len(q)))
        q = model.assemble(q + STRIDE * u / np.max(np.abs(u)))
        found.append(q)
    return np.array(found).T


def gates(scene: Scene) -> set[sp.Symbol]:
    """What joints and events switch, which stays a parameter."""
    return {sp.Symbol(p.symbol) for p in (*scene.mechanism.gates.values(), *scene.gates) if p}


@pytest.mark.sample(2)
@pytest.mark.large(8, "every effect")
def test_every_kernel_gives_the_same_numbers(scene: Scene, tmp_path: Path) -> None:
    plain, folded = read_listing(listing(scene)), read_listing(listing(scene, fold=True))
    assert {*folded.parameters} == {str(gate) for gate in gates(scene)} and folded.state == plain.state
    assert list(folded.kernels) == list(plain.kernels)
    rng = np.random.default_rng(2)
    many = len(span(scene.mechanism).cuts) > FEW_LOOPS
    closed = {"q": _consistent(load_model(generate(scene, tmp_path)), 20, rng)} if many else {}
    for name, kernel in plain.kernels.items():
        arguments = {argument: rng.uniform(-1, 1, (len(s), 20)) for argument, s in kernel.inputs.items()}
        arguments |= closed if name in SOLVING else {}
        wanted, found = plain.evaluate(name, arguments), folded.evaluate(name, arguments)
        assert wanted.keys() == found.keys()
        last = arguments if name not in SOLVING else {a: np.nextafter(x, np.inf) for a, x in arguments.items()}
        beside = plain.evaluate(name, last)
        for output in wanted:
            known = _miss(beside[output], wanted[output])
            assert _miss(found[output], wanted[output]) <= max(SAME, known), f"{name}: {output}"


@pytest.mark.sample(2)
@pytest.mark.large(8, "every effect")
def test_compiled_models_give_the_same_numbers(scene: Scene, tmp_path: Path) -> None:
    plain = load_model(generate(scene, tmp_path / "plain"))
    folded = load_model(generate(scene, tmp_path / "folded", fold=True))
    q, u = plain.start()
    rng = np.random.default_rng(5)
    for _ in range(5):
        q, u = plain.project(q, u + rng.uniform(-1, 1, u.shape))
        for name in ("acceleration", "multipliers", "reactions"):  # states may be just before an impact
            found, wanted = (getattr(model, name)(q, u, contacts=()) for model in (folded, plain))
            beside = (getattr(plain, name)(*_rounded(q, u, rng), contacts=()) for _ in range(NEIGHBOURS))
            known = max(_miss(values, wanted) for values in beside)
            assert _miss(found, wanted) <= max(SAME, known), name
        for name in ("velocities", "energy", *(("gap_rates",) if plain.contacts else ())):
            assert _miss(getattr(folded, name)(q, u), getattr(plain, name)(q, u)) <= SAME, name
        for name in ("poses", "closure", "jacobian"):
            assert np.max(np.abs(getattr(folded, name)(q) - getattr(plain, name)(q)), initial=0.0) <= SAME, name
        grounded = [contact for contact in plain.contacts if contact[1] in plain.grounds]
        if grounded:
            struck = list(dict.fromkeys([grounded[0], grounded[-1]]))
            for found, wanted in zip(folded.impact(q, u, struck), plain.impact(q, u, struck), strict=True):
                assert _miss(found, wanted) <= SAME


def test_runs_are_the_same(hexagon: Scene, tmp_path: Path) -> None:
    plain = simulate(load_model(generate(hexagon, tmp_path / "plain")))
    folded = simulate(load_model(generate(hexagon, tmp_path / "folded", fold=True)))
    assert [i.contacts for i in folded.impacts] == [i.contacts for i in plain.impacts]
    assert folded.q[-1] == pytest.approx(plain.q[-1], abs=1e-11)


# -- fewer operations ----------------------------------------------------------------------------------------------


def _counts(scene: Scene, folded: bool) -> dict[str, Counts]:
    return {f.kernel.name: f.counts() for f in lower(derive_scene(scene, folded)[1]).functions}


@pytest.mark.sample(2)
@pytest.mark.large(8, "every effect")
def test_no_function_takes_more_operations(scene: Scene) -> None:
    plain, folded = _counts(scene, False), _counts(scene, True)
    for name, counts in plain.items():
        assert folded[name].total <= counts.total, name
        assert folded[name].angles <= counts.angles, name
    assert sum(c.total for c in folded.values()) < sum(c.total for c in plain.values())


def test_lengths_of_one_cost_nothing() -> None:
    """Each of six arms from joint to joint, x and y, was a product with the link's length."""
    plain, folded = _counts(loop(6), False)["acceleration"], _counts(loop(6), True)["acceleration"]
    assert plain - folded == Counts(products=12)


@pytest.mark.sample(2)
@pytest.mark.large(8, "every effect")
def test_folded_equations_have_no_constants_but_of_gates(scene: Scene) -> None:
    program = lower(derive_scene(scene, True)[1])
    kept = {sp.Symbol(p.symbol) for p in program.parameters}
    assert kept == gates(scene)
    for constant in program.constants:
        assert constant.expression.free_symbols and constant.expression.free_symbols <= kept
        kept.add(constant.symbol)
    assert all({*function.constants} <= kept for function in program.functions)


# -- what stands in the equations ----------------------------------------------------------------------------------

A, B, X, Y = sp.symbols("a b x y")


def _equations(values: tuple[float, float], *expressions: sp.Expr) -> Equations:
    """Equations that name the expressions ``e_0`` …, the last of which is put out."""
    parameters = tuple(Parameter(name, name, value) for name, value in zip("ab", values, strict=True))
    named = tuple(Assignment(sp.Symbol(f"e_{i}"), e) for i, e in enumerate(expressions))
    out = Kernel("out", (), (Output("out", (named[-1].symbol,), ""),), "")
    arguments = Kernel("in", (Argument("q", (X, Y), ""),), (), "")
    return Equations(parameters, State((X,), (Y,)), (Block("all", named),), (arguments, out))


@pytest.mark.parametrize(
    ("values", "expression", "expected"),
    [
        ((1.0, 0.0), A * X + B * Y, "x"),
        ((2.0, 0.5), A * B * X, "x"),
        ((2.0, 3.0), A * (X + Y) + B, "3 + 2*(x + y)"),
        ((0.1, 0.2), A + B + X, f"{0.1 + 0.2!r} + x"),
        ((4.0, 9.0), sp.sqrt(A) * X + sp.sqrt(B), "3 + 2*x"),
        ((3.0, 0.1), sp.tanh(X / B) * A, "3*tanh(x*10)"),
        ((-1.0, 1.0), sp.Abs(A) * X + sp.exp(B) * 0, "x"),
        ((2.0, 8.0), X / A + Y / B, "0.5*x + 0.125*y"),
        ((1.0, -1.0), A * X * Y + B * X * Y + X, "x"),
        ((1.5, 1.0), -A * X**2, "-1.5*x**2"),
    ],
)
def test_numbers_simplify(values: tuple[float, float], expression: sp.Expr, expected: str) -> None:
    folded = fold(_equations(values, expression))
    (output,) = folded.kernels[1].outputs
    found = {a.symbol: a.expression for a in folded.assignments()}.get(output.entries[0], output.entries[0])
    point = {X: sp.Float(0.7), Y: sp.Float(-1.3)}
    assert float(found.subs(point)) == pytest.approx(float(sp.sympify(expected).subs(point)), rel=1e-15)
    assert write(found, LISTING).count("*") <= expected.count("*")


def test_equal_expressions_have_one_name() -> None:
    """Also where they differ in sign; and what nothing needs by that name is gone."""
    folded = fold(_equations((2.0, 2.0), A * X, B * X, -A * X, sp.Symbol("e_0") * Y + sp.Symbol("e_2") * X))
    assert [a.symbol.name for a in folded.assignments()] == ["e_0", "e_3"]
    assert folded.assignments()[1].expression == sp.Symbol("e_0") * Y - sp.Symbol("e_0") * X


@pytest.mark.parametrize(
    ("values", "expression"),
    [
        ((0.0, 1.0), B / A),
        ((-1.0, 1.0), sp.sqrt(A) * X),
        ((-1.0, 1.0), sp.log(A)),
        ((1e3, 1.0), sp.exp(A) + X),
        ((1e300, 1e300), A * B * X),
    ],
    ids=str,
)
def test_values_without_a_finite_number_are_refused(values: tuple[float, float], expression: sp.Expr) -> None:
    with pytest.raises(FoldError, match=r"found no finite number for e_0 .* leave out --fold"):
        fold(_equations(values, expression))


# -- generated packages --------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def folded_bars(tmp_path_factory: pytest.TempPathFactory) -> Model:
    return load_model(generate(chain(2, hinged=True, gravity=True), tmp_path_factory.mktemp("bars"), fold=True))


def test_parameters_can_be_read_and_not_set(folded_bars: Model) -> None:
    assert folded_bars.folded
    assert folded_bars.parameters["gravity.g"] == 9.81
    before = folded_bars.acceleration([0.1, 0.2], [0.0, 0.0])
    words = "gravity.g: found a new value for hinged2, whose parameters are folded .* build it without --fold"
    changes: list[Callable[[], object]] = [
        lambda: folded_bars.parameters.update({"gravity.g": 1.0}),
        lambda: folded_bars.with_parameters({"gravity.g": 1.0}),
        lambda: simulate(folded_bars, params={"gravity.g": 1.0}),
    ]
    for change in changes:
        with pytest.raises(ValueError, match=words):
            change()
    with pytest.raises(KeyError, match="gravity: found no such parameter, expected one of the model, as gravity"):
        folded_bars.parameters["gravity"] = 1.0
    assert folded_bars.parameters["gravity.g"] == 9.81
    assert np.array_equal(folded_bars.with_parameters(None).acceleration([0.1, 0.2], [0.0, 0.0]), before)


@pytest.mark.hard
def test_both_forms_are_cached(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Same package, same folder; whichever was asked for last lies there, and neither is built twice."""
    monkeypatch.setenv("CCGEN_CACHE_DIR", str(tmp_path / "cache"))
    scene, built = chain(2, hinged=True), []
    for folded in (False, True, False, True):
        stages: list[str] = []
        package = generate(scene, tmp_path / "build", stages.append, fold=folded)
        assert package == tmp_path / "build" / "hinged2"
        assert load_model(package).folded == folded
        built.append("compile" in stages)
    assert built == [True, True, False, False]


@pytest.mark.sample(1)
@pytest.mark.skipif(shutil.which("cc") is None, reason="there is no cc")
@pytest.mark.parametrize("name", ["falling-hexagon", "every effect", "chain"])
def test_folded_c_has_no_warnings(name: str, workshop: Workshop, tmp_path: Path) -> None:
    folder = generate(SCENES[name](workshop), tmp_path, fold=True)
    command = ["cc", "-std=c11", "-Wall", "-Wextra", "-Werror", "-pedantic", "-O1", "-c", "model.c"]
    done = subprocess.run(
        [*command, "-o", str(tmp_path / "model.o")], cwd=folder, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr


@pytest.mark.hard
def test_the_listing_is_the_same_for_every_seed(tmp_path: Path) -> None:
    file = tmp_path / "all.toml"
    file.write_text(SCENE + "".join(EXAMPLES.values()))
    code = "import sys; from ccgen.generator import load_scene; from ccgen.generator.pipeline import listing; "
    code += "sys.stdout.write(listing(load_scene('all.toml'), fold=True))"
    texts = {
        subprocess.run(
            [sys.executable, "-c", code],
            cwd=tmp_path,
            env={**os.environ, "PYTHONHASHSEED": seed},
            capture_output=True,
            check=True,
        ).stdout
        for seed in ("0", "1", "4242")
    }
    assert len(texts) == 1


def test_the_listing_says_that_it_is_folded(hexagon: Scene) -> None:
    folded, plain = listing(hexagon, fold=True), listing(hexagon)
    assert "[parameters]\n# folded: these values stand in the equations as numbers\n# m_0 = 1.0  link_0.mass" in folded
    assert "folded" not in plain
    assert "g*" not in folded.replace("_g*", "") and "9.81" in folded


# -- command line --------------------------------------------------------------------------------------------------


@pytest.mark.hard
def test_fold_on_the_command_line(tmp_path: Path) -> None:
    done = ccgen("--links", "2", "--open", "--hinged", "--fold", at=tmp_path)
    assert (done.returncode, done.stdout, done.stderr) == (0, "build/hinged2\n", "")
    assert load_model(tmp_path / "build" / "hinged2").folded
    done = ccgen("--links", "2", "--open", "--hinged", at=tmp_path)
    assert not load_model(tmp_path / "build" / "hinged2").folded
    (tmp_path / "rods.toml").write_text('name = "rods"\n[chain]\nlinks = 2\nhinged = true\n[run]\nuntil = 0.2\n')
    done = ccgen("run", "rods.toml", "--fold", at=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert load_model(tmp_path / "build" / "rods").folded
    for options in (("--latex",), ()):
        done = ccgen("show", "rods.toml", "--fold", *options, at=tmp_path)
        assert done.returncode == 0
        assert "folded" in done.stdout


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--fold", "show", "rods.toml"), "--fold: found before the command show, expected behind it; move it"),
        (("show", "rods.toml", "--fold", "--expand"), "--fold: found beside --expand"),
        (("--fold",), "--fold: found without --links or --scene"),
    ],
)
def test_fold_in_the_wrong_place(options: tuple[str, ...], words: str, tmp_path: Path) -> None:
    (tmp_path / "rods.toml").write_text("[chain]\nlinks = 2\n")
    done = ccgen(*options, at=tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert words in done.stderr
