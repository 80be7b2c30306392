"""Equal modules side by side: found, put into loops and lanes, with the values of the code written out."""

from __future__ import annotations

import math
import re
import shutil
from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
import sympy as sp

from ccgen.generator import load_scene, loop
from ccgen.generator.derive.derivation import derive
from ccgen.generator.mechanism.modules import LEAST_LINKS, alike, varied
from ccgen.generator.mechanism.topology import span
from ccgen.generator.pipeline import derive_scene
from ccgen.generator.planning.choose import TIP_TO_ROOT, choose
from ccgen.generator.program import abreast as pass_
from ccgen.generator.program import routine
from ccgen.generator.program.abreast import Abreast, Packed, abreast
from ccgen.generator.program.dialects import C
from ccgen.generator.program.program import lower
from ccgen.generator.program.rolling import Lines, Loop, Place
from ccgen.generator.program.routine import Routines
from ccgen.generator.program.terms import (
    Assign,
    Call,
    Element,
    Gathered,
    Guard,
    Leaf,
    Name,
    Negative,
    Number,
    Power,
    Product,
    Sum,
    Term,
)

from ..oracles.maximal import Array
from ..support.folders import SCENES
from ..support.tiers import hard
from ..support.workshop import Workshop
from ..support.written_models import Compiled, Written, same

Value = float | Array


# -- an interpreter of terms -----------------------------------------------------------------------------------------


class Machine:
    """Runs statements on numbers and vectors by the meaning of terms, not by how C writes them."""

    def __init__(
        self, given: Mapping[str, float], places: Mapping[str, Place], packed: Packed[str], lanes: int
    ) -> None:
        self.names: dict[str, Value] = dict(given)
        self.arrays: dict[str, dict[int, Value]] = {}
        for name, (array, index) in places.items():
            self.arrays.setdefault(array, {})[index] = given[name]
        entries = [given[name] for name in packed.entries]
        self.arrays["k_abreast"] = dict(enumerate(entries if lanes == 1 else np.reshape(entries, (-1, lanes))))

    def run(self, statements: Iterable[Lines | Loop]) -> None:
        for part in statements:
            for i in range(part.rounds if isinstance(part, Loop) else 1):
                names = dict(self.names)
                for block in part.body if isinstance(part, Loop) else (part,):
                    for line in block.lines:
                        self.assign(line, i, names)
                if isinstance(part, Lines):
                    self.names = names

    def assign(self, line: Assign, i: int, names: dict[str, Value]) -> None:
        value = self.value(line.value, i, names)
        if isinstance(line.target, Name):
            assert line.target.name not in names, f"{line.target.name} is assigned twice"
            names[line.target.name] = value
        else:
            self.arrays.setdefault(line.target.array, {})[line.target.start + line.target.stride * i] = value

    def leaf(self, leaf: Leaf, i: int, names: Mapping[str, Value]) -> Value:
        if isinstance(leaf, Name):
            return names[leaf.name]
        value = self.arrays[leaf.array][leaf.start + leaf.stride * i]
        return value if leaf.lane is None else value[leaf.lane]  # type: ignore[index]

    def value(self, term: Term, i: int = 0, names: Mapping[str, Value] | None = None) -> Value:
        names = self.names if names is None else names
        of: Callable[[Term], Value] = lambda t: self.value(t, i, names)  # noqa: E731
        match term:
            case Number(value):
                return float(value)
            case Name() | Element():
                return self.leaf(term, i, names)
            case Negative(inner):
                return -of(inner)
            case Sum(terms):
                return sum(map(of, terms))  # type: ignore[arg-type]
            case Product(factors, under):
                return math.prod(map(of, factors)) / math.prod(map(of, under))  # type: ignore[arg-type]
            case Power(base, exponent):
                return of(base) ** exponent
            case Call("total", inner):
                return float(np.sum(of(inner)))
            case Call(function, inner):
                return getattr(np, function)(of(inner))
            case Gathered(lanes):
                return np.array([of(t) for t in lanes])
        raise AssertionError(term)


def block(title: str, *lines: tuple[str, str]) -> Lines:
    return Lines(title, tuple(Assign(Name(name), C.term(sp.sympify(text))) for name, text in lines))


def module(m: int, twist: str = "") -> Lines:
    """Statements that belong to module m: it reads its own angle, a constant of its own, and what is shared."""
    chain = [(f"x{j}_{m}", f"x{j - 1}_{m}*b_{m} + hub{twist}") for j in range(1, pass_.LEAST)]
    return block(f"module {m}", (f"x0_{m}", f"q_{m}*a_{m} - port_{m}"), *chain)


def program(count: int) -> list[Lines]:
    """What is shared, the modules, their sum with what is shared, and what each makes of it."""
    hub = block("hub", ("hub", "2*q_99"), *((f"port_{m}", f"hub*a_{(m + 1) % count}") for m in range(count)))
    last = pass_.LEAST - 1
    parts = " + ".join(f"x{last}_{m}*q_{m} - x2_{m}" for m in range(count))
    total = block("total", ("whole", f"hub + {parts}"))
    back = [block(f"back {m}", (f"y_{m}", f"whole*x1_{m} + sqrt(b_{m})")) for m in range(count)]
    return [hub, *(module(m) for m in range(count)), total, *back]


def run_both(
    blocks: Sequence[Lines], count: int, results: Sequence[str], lanes: int, guards: Sequence[Guard] = ()
) -> tuple[Abreast | None, Machine, Machine]:
    """The statements abreast, and the machines that have run them so and as they stood."""
    names = [f"{letter}_{m}" for letter in "ab" for m in range(count)]
    places: dict[str, Place] = {name: ("k", index) for index, name in enumerate(names)}
    places |= {f"q_{m}": ("q", m) for m in range(count)} | {"q_99": ("q", 99)}
    rng = np.random.default_rng(3)
    given = {name: float(x) for name, x in zip(places, rng.uniform(0.5, 1.5, len(places)), strict=True)}
    packed: Packed[str] = Packed(4)
    side = abreast(blocks, {f"q_{m}": m for m in range(count)}, places, set(results), guards, packed, lanes)
    plain = Machine(given, places, packed, lanes if side else 1)
    plain.run(blocks)
    done = Machine(given, places, packed, 4 if side and lanes > 1 else 1)
    done.run(side.statements if side else blocks)
    return side, done, plain


@pytest.mark.parametrize("lanes", [1, 4])
@pytest.mark.parametrize("count", [2, 3, 4, 5, 8, 9])
def test_modules_abreast_have_the_values_of_the_code_as_it_stood(count: int, lanes: int) -> None:
    results = ["whole", *(f"y_{m}" for m in range(count)), "x3_1"]
    side, done, plain = run_both(program(count), count, results, lanes)
    assert side is not None
    loops = [part for part in side.statements if isinstance(part, Loop)]
    assert [loop.rounds for loop in loops] == [-(-count // lanes)] * 2
    for name in results:
        assert done.value(side.placed(Name(name))) == pytest.approx(plain.names[name], rel=1e-13), name


def test_a_sum_over_modules_is_a_sum_of_vectors() -> None:
    side, *_ = run_both(program(9), 9, ["whole"], 4)
    assert side is not None
    (line,) = [
        x for part in side.statements if isinstance(part, Lines) for x in part.lines if x.target == Name("whole")
    ]
    assert C.text(line.value).count("ccgen_total(") == 1
    assert "[2][0]" in C.text(line.value), "the ninth module, alone in its vector, must be counted once"


@pytest.mark.parametrize("lanes", [1, 4])
def test_guards_of_modules_are_checked_together(lanes: int) -> None:
    """Each holds where its pivot is more than its least; of nine, one may fail alone."""
    for fails in (None, 0, 8):
        guards = [
            Guard(Name(f"x2_{m}"), Product((Number(1e6 if m == fails else -1e6), Name(f"b_{m}")))) for m in range(9)
        ]
        side, done, _ = run_both(program(9), 9, ["whole"], lanes, guards)
        assert side is not None
        assert len(side.guards) == (9 if lanes == 1 else 3)
        least = [0.0 if g.least is None else done.value(g.least) for g in side.guards]
        holds = [bool(np.all(np.array(done.value(g.pivot)) > x)) for g, x in zip(side.guards, least, strict=True)]
        assert all(holds) == (fails is None)


def test_modules_that_differ_stay_as_they_are() -> None:
    blocks = program(4)
    blocks[2] = module(1, twist="*3")
    side, done, plain = run_both(blocks, 4, ["whole", "y_1"], 4)
    assert side is not None
    assert "x3_1" not in {line.target.name for loop in side.statements for line in _own(loop)}
    assert done.value(side.placed(Name("y_1"))) == pytest.approx(plain.names["y_1"], rel=1e-13)
    odd = [program(2)[0], module(0), module(1, "*3")]
    assert run_both(odd, 2, ["x3_0", "x3_1"], 4)[0] is None


def _own(part: Lines | Loop) -> list[Assign]:
    """Lines of a loop whose targets are names."""
    blocks = part.body if isinstance(part, Loop) else ()
    return [line for one in blocks for line in one.lines if isinstance(line.target, Name)]


def test_short_modules_stay_as_they_are() -> None:
    short = [block(f"{m}", (f"x_{m}", f"q_{m}*a_{m}")) for m in range(5)]
    assert run_both(short, 5, [f"x_{m}" for m in range(5)], 4)[0] is None


# -- mechanisms ------------------------------------------------------------------------------------------------------


def star(arms: int, extra: str = "", noise: float = 0.0) -> str:
    """A hub with loops around it, each a crank and a rod that meet at an elbow; a spring pulls each elbow."""
    at = [(np.cos(2 * np.pi * k / arms + 0.2), np.sin(2 * np.pi * k / arms + 0.2)) for k in range(arms)]
    points = [
        f"{p}{k} = [{r * x - d * y:.6f}, {r * y + d * x:.6f}]" for k, (x, y) in enumerate(at) for p, r, d in PORTS
    ]
    lines = ['name = "star"', *_link("hub", 3.0, points)]
    for k in range(arms):
        off = noise if k else 0.0
        for name, length in (("crank", 0.5), ("rod", 0.7), ("foot", 0.4)):
            lines += _link(f"{name}_{k}", 0.5 + 0.1 * k, [f"A = [0, {off}]", f"B = [{length + 0.01 * k:.4f}, {off}]"])
        for name, ends in (
            ("hip", ("hub.P", "crank_.A")),
            ("knee", ("hub.Q", "rod_.A")),
            ("elbow", ("crank_.B", "rod_.B")),
            ("ankle", ("rod_.B", "foot_.A")),
        ):
            one, other = (e.replace("_.", f"_{k}.") if "_." in e else f"{e}{k}" for e in ends)
            lines += ["[[joint]]", f'name = "{name}_{k}"', f'between = ["{one}", "{other}"]']
        lines += ["[[spring]]", f'between = ["hub.P{k}", "foot_{k}.B"]', "stiffness = 40.0", "length = 0.3"]
    angles = [f"crank_{k} = {np.arctan2(y, x) + 0.3:.6f}" for k, (x, y) in enumerate(at)]
    angles += [f"rod_{k} = {np.arctan2(y, x) - 0.3:.6f}" for k, (x, y) in enumerate(at)]
    lines += ["[gravity]", "[start]", "height = 3.0", f"angles = {{ {', '.join(angles)} }}", extra]
    return "\n".join(lines)


PORTS = (("P", 0.3, -0.15), ("Q", 0.3, 0.15))
ROUGH = '[[ground]]\nrestitution = 0.3\nfriction = 0.4\ncontacts = ["foot_0.B", "foot_1.B", "rod_0.B"]\n'


def _link(name: str, mass: float, points: Sequence[str]) -> list[str]:
    inside = ", ".join(points)
    return [
        "[[link]]",
        f'name = "{name}"',
        f"mass = {mass}",
        "inertia = 0.02",
        "com = [0.1, 0.05]",
        f"points = {{ {inside} }}",
    ]


@pytest.mark.sample(1)
@pytest.mark.skipif(shutil.which("cc") is None, reason="there is no cc")
@pytest.mark.parametrize("arms", [2, hard(3), hard(5), hard(6)])
@pytest.mark.parametrize("rough", [False, True])
def test_kernels_abreast_are_the_kernels_written_out(
    arms: int, rough: bool, workshop: Workshop, tmp_path: Path
) -> None:
    written = Written(workshop.scene(star(arms, ROUGH if rough else "")), tmp_path)
    together, apart = written.compiled("together", 10**9, pass_.LEAST), written.compiled("apart", 10**9)
    assert "ccgen_abreast" in together.source
    assert "ccgen_abreast" not in apart.source
    compare(written, together, apart)


@pytest.mark.hard
@pytest.mark.skipif(shutil.which("cc") is None, reason="there is no cc")
def test_a_walking_machine_abreast_is_that_written_out(tmp_path: Path) -> None:
    """Twelve legs with pumps: modules of two kinds, dyads, sliding joints."""
    written = Written(load_scene(SCENES / "strandbeest.toml"), tmp_path)
    together, apart = written.compiled("together", 10**9, pass_.LEAST), written.compiled("apart", 10**9)
    assert "ccgen_total(" in together.source
    compare(written, together, apart)


@pytest.mark.hard
@pytest.mark.skipif(shutil.which("cc") is None, reason="there is no cc")
@pytest.mark.parametrize("links", [40, 53])
def test_segments_of_a_ring_abreast_are_those_written_out(links: int, tmp_path: Path) -> None:
    """A vector holds one link of each segment, and a loop goes from link to link where the segments are long."""
    ground = [{"restitution": 0.3, "friction": 0.4}]
    written = Written(loop(links, gravity=True, start={"height": 9.0}, ground=ground), tmp_path)
    together, apart = written.compiled("together", 6, pass_.LEAST), written.compiled("apart", 10**9)
    assert "ccgen_abreast" in together.source
    compare(written, together, apart)
    made = Routines(written.program, C.term).made
    acceleration = next(routine for routine in made if routine.function.kernel.name == "acceleration")
    rounds = [part.rounds for part in acceleration.statements if isinstance(part, Loop) and part.lanes == 4]
    assert min(rounds) >= 6, rounds


@pytest.mark.hard
@pytest.mark.skipif(shutil.which("cc") is None, reason="there is no cc")
@pytest.mark.parametrize("name", ["ring", "walking machine"])
def test_loops_over_outputs_give_what_is_written_out(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where a function is long, what repeats within blocks becomes loops, and so do its outputs."""
    scene = loop(30, gravity=True) if name == "ring" else load_scene(SCENES / "strandbeest.toml")
    written = Written(scene, tmp_path)
    apart = written.compiled("apart", 10**9)
    monkeypatch.setattr(routine, "LONG", 0)
    together = written.compiled("together", 3)
    assert re.search(r"^ +pose\[3\*i", together.source, re.MULTILINE) or name != "ring"
    assert "pose[3*i" not in apart.source
    compare(written, together, apart)


def compare(written: Written, together: Compiled, apart: Compiled) -> None:
    """All kernels at states near the start, to rounding of their largest entry."""
    state = written.equations.state
    rng = np.random.default_rng(7)
    for _ in range(3):
        _, u, f, y, pushes = written.arguments(rng)
        q = rng.uniform(-0.1, 0.1, len(state.q)) + 0.4 * np.arange(len(state.q))
        found, wanted = together.everything(q, u, f, y, pushes), apart.everything(q, u, f, y, pushes)
        for kernel, outputs in wanted.items():
            for one, other in zip(found[kernel], outputs, strict=True):
                assert same(one, other, 1e-10 if kernel in SOLVED else 1e-13), kernel


SOLVED = ("acceleration", "impulse", "contact_response")
"""What divides by pivots: at a random state these may be small."""


@pytest.mark.skipif(shutil.which("cc") is None, reason="there is no cc")
@pytest.mark.parametrize("arms", [1, 4])
def test_responses_are_impulses_one_by_one(arms: int, workshop: Workshop, tmp_path: Path) -> None:
    """Impulses to generalized impulses, these to jumps, and these to rates: joined, and by the kernels one by one."""
    written = Written(workshop.scene(star(max(arms, 2), ROUGH)), tmp_path)
    model = written.compiled("model", 6, pass_.LEAST if arms > 1 else 10**9)
    size = {name: getattr(model.descriptor, name) for name in ("nu", "rows", "contacts")}
    nu, contacts, none = size["nu"], size["contacts"], np.zeros(size["rows"])
    rng = np.random.default_rng(11)
    q, *_ = written.arguments(rng)
    for count in (1, 2 * contacts):
        pushes = rng.normal(size=(count, 2 * contacts))
        jumps, rates = model.call("contact_response", [q, count, pushes], count * nu, count * 2 * contacts)
        for column, du, changed in zip(pushes, jumps.reshape(count, -1), rates.reshape(count, -1), strict=True):
            normal, tangential = column[:contacts].copy(), column[contacts:].copy()
            (f,), (g,) = (
                model.call(kernel, [q, push], nu)
                for kernel, push in (("contact_impulse", normal), ("slip_impulse", tangential))
            )
            wanted, _ = model.call("impulse", [q, f + g, none], nu, none.size)
            assert same(du, wanted, 1e-12)
            gaps, slips = (model.call(kernel, [q, wanted], contacts)[0] for kernel in ("gap_rates", "slips"))
            assert same(changed, np.concatenate([gaps, slips]), 1e-12)


@pytest.mark.skipif(shutil.which("cc") is None, reason="there is no cc")
def test_responses_are_symmetric(workshop: Workshop, tmp_path: Path) -> None:
    """The rates that unit impulses give are the Delassus operator, loops held shut."""
    written = Written(workshop.scene(star(3, ROUGH)), tmp_path)
    model = written.compiled("model", 6, pass_.LEAST)
    width = 2 * model.descriptor.contacts
    q, *_ = written.arguments(np.random.default_rng(5))
    _, rates = model.call("contact_response", [q, width, np.eye(width)], width * model.descriptor.nu, width * width)
    operator = rates.reshape(width, width)
    assert same(operator, operator.T, 1e-12)
    assert np.all(np.linalg.eigvalsh(0.5 * (operator + operator.T)) > -1e-12)


@pytest.mark.hard
def test_modules_stay_as_they_are_where_most_is_shared(workshop: Workshop) -> None:
    """From tip to root on the tree of short branches the legs' multipliers are coupled: most statements belong to none
    of them."""
    scene = load_scene(SCENES / "strandbeest.toml")
    topology = span(scene.mechanism, scene.driven)
    plan = choose(scene.mechanism, topology, scene.driven, (), TIP_TO_ROOT).plan
    coupled = derive(scene.mechanism, topology, plan, scene.effects)
    sides = [
        Routines(lower(equations), C.term).one_by_one("acceleration").modules
        for equations in (derive_scene(scene, plan="dyads")[1], coupled)
    ]
    assert [len(members) for members in sides[0]] == [4]
    assert sides[1] == ()


def graph(name: str, links: Mapping[str, Sequence[str]], pins: Sequence[tuple[str, str]], extra: str = "") -> str:
    """A scene from links with their points, and pins between points."""
    lines = [f'name = "{name}"']
    for link, points in links.items():
        lines += _link(link, 0.5, [f"{p} = [{0.3 * i:.2f}, {0.05 + 0.11 * i * i:.4f}]" for i, p in enumerate(points)])
    for index, (one, other) in enumerate(pins):
        lines += ["[[joint]]", f'name = "pin_{index}"', f'between = ["{one}", "{other}"]']
    angles = ", ".join(f"{link} = {0.3 + 0.7 * i}" for i, link in enumerate(links))
    return "\n".join([*lines, "[gravity]", "[start]", f"angles = {{ {angles} }}", extra])


def hubs_in_a_row() -> str:
    """Three hubs; on each two legs of three links and a tail of four: two kinds of modules that read the same hubs."""
    links = {f"hub{h}": ["W", "P", "Q", "R", "E"] for h in range(3)}
    pins = [("hub0.E", "hub1.W"), ("hub1.E", "hub2.W")]
    for h in range(3):
        for at, length in (("P", 3), ("Q", 3), ("R", 4)):
            names = [f"l{h}{at}{j}" for j in range(length)]
            links |= {name: ["A", "B"] for name in names}
            pins += [(f"hub{h}.{at}", f"{names[0]}.A")]
            pins += [(f"{a}.B", f"{b}.A") for a, b in pairwise(names)]
    damped = "".join(f'[[torsion]]\njoint = "pin_{k}"\nstiffness = 3.0\ndamping = 0.4\n' for k in range(len(pins)))
    return graph("centipede", links, pins, damped)


def platforms() -> str:
    """Four platforms one above the other, each on three legs of two links: modules that wait for each other."""
    links = {f"plat{h}": [f"{side}{k}" for side in "BT" for k in range(3)] for h in range(4)}
    pins = []
    for h in range(4):
        for k in range(3):
            links |= {f"l{h}{k}0": ["A", "B"], f"l{h}{k}1": ["A", "B"]}
            below = f"plat{h - 1}.T{k}" if h else f"ground.G{k}"
            pins += [(below, f"l{h}{k}0.A"), (f"l{h}{k}0.B", f"l{h}{k}1.A"), (f"l{h}{k}1.B", f"plat{h}.B{k}")]
    return graph("stack", links, pins, "[ground_link]\npoints = { G0 = [0, 0], G1 = [0.4, 0.1], G2 = [0.8, 0] }")


@pytest.mark.hard
@pytest.mark.skipif(shutil.which("cc") is None, reason="there is no cc")
def test_two_kinds_of_modules_may_read_the_same_hubs(workshop: Workshop, tmp_path: Path) -> None:
    written = Written(workshop.scene(hubs_in_a_row()), tmp_path)
    groups = Routines(written.program, C.term).one_by_one("acceleration").modules
    assert sorted(map(len, groups)) == [3, 6]
    together, apart = written.compiled("together", 10**9, pass_.LEAST), written.compiled("apart", 10**9)
    compare(written, together, apart)


def test_modules_that_wait_for_each_other_are_left_alone(workshop: Workshop) -> None:
    """A walk through their statements would never settle."""
    scene = workshop.scene(platforms())
    Routines(lower(derive_scene(scene)[1]), C.term).one_by_one("acceleration")
    row = [block("first", *[(f"x{j}_0", f"q_0*a_0 + {j}") for j in range(pass_.LEAST)])]
    row += [block("between", ("bridge", f"x{pass_.LEAST - 1}_0 + q_1"))]
    row += [block("second", *[(f"x{j}_1", f"q_1*a_1 + {'bridge' if j == 0 else j}") for j in range(pass_.LEAST)])]
    first = block("first", ("x0_0", "q_0*a_0 + start"), *[(f"x{j}_0", f"q_0*a_0 + {j}") for j in range(1, pass_.LEAST)])
    side, done, plain = run_both([block("hub", ("start", "2*q_99")), first, *row[1:]], 2, ["x0_1"], 4)
    assert side is None
    assert done.names["x0_1"] == plain.names["x0_1"]


@pytest.mark.skipif(shutil.which("cc") is None, reason="there is no cc")
def test_responses_fill_every_entry(workshop: Workshop, tmp_path: Path) -> None:
    """Eleven driven cranks do not answer; one free link does."""
    links = {f"l{k}": ["A", "B"] for k in range(12)}
    pins = [(f"ground.G{k}", f"l{k}.A") for k in range(12)]
    points = ", ".join(f"G{k} = [{2 * k}, 0]" for k in range(12))
    drives = "".join(f'[[drive]]\njoint = "pin_{k}"\nspeed = 1.0\n' for k in range(11))
    ground = '[[ground]]\npoint = [0, -9]\nrestitution = 0.5\ncontacts = ["l11.B"]\n'
    text = graph("cranks", links, pins, f"[ground_link]\npoints = {{ {points} }}\n{drives}{ground}")
    model = Written(workshop.scene(text), tmp_path).compiled("model", 6)
    count = 3
    du, rates = model.call("contact_response", [np.full(12, 0.3), count, np.ones(count)], count * 12, count)
    assert np.all(du.reshape(count, 12)[:, :11] == 0.0)
    assert np.all(np.isfinite(rates))
    assert np.all(du.reshape(count, 12)[:, 11] != 0.0)


@pytest.mark.hard
@pytest.mark.skipif(shutil.which("cc") is None, reason="there is no cc")
def test_multipliers_are_left_out_where_there_is_no_room(tmp_path: Path) -> None:
    written = Written(load_scene(SCENES / "strandbeest.toml"), tmp_path)
    model = written.compiled("model", 6, pass_.LEAST)
    rng = np.random.default_rng(13)
    _, u, f, y, _ = written.arguments(rng)
    q = rng.uniform(-0.1, 0.1, len(u)) + 0.4 * np.arange(len(u))
    for kernel, given in (("acceleration", [q, u, 0.0, None]), ("impulse", [q, f, y])):
        whole, multipliers = model.call(kernel, given, len(u), y.size)
        assert np.all(np.isfinite(multipliers))
        none = model.call_without(kernel, given, len(u))
        assert none.tobytes() == whole.tobytes()


# -- what is looked for ----------------------------------------------------------------------------------------------


def test_modules_are_found_by_what_falls_apart(workshop: Workshop) -> None:
    legs = alike(load_scene(SCENES / "strandbeest.toml").mechanism)
    assert sorted(map(len, legs)) == [2, 2, 6, 6, 6, 6]
    assert alike(workshop.scene(star(4)).mechanism) == tuple((3 * k + 1, 3 * k + 2, 3 * k + 3) for k in range(4))
    assert alike(load_scene(SCENES / "falling-hexagon.toml").mechanism) == ()


def test_coordinates_that_are_zero_in_some_modules_are_parameters_in_all(workshop: Workshop) -> None:
    even, uneven = (workshop.scene(star(3, noise=noise)) for noise in (0.0, 1e-17))
    assert not varied(even.mechanism)
    paths = {p.path: p.value for p in uneven.mechanism.parameters()}
    assert {paths[f"{name}_0.points.{p}.y"] for name in ("crank", "rod", "foot") for p in "AB"} == {0.0}
    assert "crank_0.points.A.x" not in paths
    shapes = [len({len(f) for f in lower(derive_scene(s)[1]).modules}) for s in (even, uneven)]
    assert shapes == [1, 1]
    assert LEAST_LINKS == 3
