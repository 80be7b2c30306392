"""Program in, texts of the generated files out (all but the listing)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache

import jinja2
import sympy as sp

from ..derive.derivation import AT_DEAD_CENTRES
from ..derive.equations import GUARD, Kernel, Output
from ..program.program import Function, Program
from .expressions import C, write
from .lanes import over_lanes
from .rolling import NAME, Lines, Place, roll

SIGNATURES: Mapping[str, tuple[str, ...]] = {
    "acceleration": ("k", "q", "u", "t", "inputs"),
    "inverse_dynamics": ("k", "q", "u", "t", "inputs", "u_dot"),
    "reactions": ("k", "q", "u", "t", "inputs", "u_dot", "lambda"),
    "power": ("k", "q", "u", "t", "inputs", "u_dot", "lambda"),
    "impulse_reactions": ("k", "q", "u", "lambda"),
}
"""Kernels whose contract has more arguments than the kernel reads; those for dead centres take the same."""

SOLVERS = ("acceleration", "impulse")
"""Kernels that say whether they have solved."""

MEMBERS = {"points": "point_positions"}
"""Kernels whose place in the contract has another name."""

METHODS = (
    "start",
    "gaps",
    "gap_rates",
    "jacobian",
    "with_parameters",
    "parameters",
    "acceleration",
    "multipliers",
    "reactions",
    "poses",
    "velocities",
    "point",
    "state_from_poses",
    "energy",
    "closure",
    "assemble",
    "project",
    "impact",
)


@dataclass(frozen=True)
class Sizes:
    """Array sizes of the contract, in the order of ``struct ccgen_model``."""

    nq: int
    nu: int
    base: int
    rows: int
    links: int
    joints: int
    points: int
    contacts: int
    parameters: int
    constants: int
    inputs: int
    drives: int


@dataclass(frozen=True)
class Banner:
    """What every generated file says of its origin, and nothing else."""

    name: str
    package: str
    version: str
    hash: str


@cache
def _environment() -> jinja2.Environment:
    return jinja2.Environment(
        loader=jinja2.PackageLoader("ccgen.templates", "."),
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )


def render_binding(banner: Banner, capsule: str) -> str:
    """The Cython module that hands over the descriptor in a capsule of that name."""
    return _environment().get_template("binding.pyx.j2").render(vars(banner), capsule=capsule)


def render_package(banner: Banner) -> str:
    """The package's ``__init__.py``."""
    return _environment().get_template("package.py.j2").render(**vars(banner), methods=METHODS)


def render_c(
    banner: Banner,
    program: Program,
    sizes: Sizes,
    tables: Mapping[str, Sequence[int]],
    root: int,
    index: Iterable[str],
) -> str:
    """The model in C11: one function per kernel and the descriptor. ``tables`` are the contract's arrays of numbers."""
    slots = _slots(program)
    functions = [_constants(program), *(_function(f, slots) for f in program.functions)]
    members = [("derive_constants", "derive_constants")]
    called = {f.kernel.otherwise for f in program.functions}
    own = [f.kernel.name for f in program.functions if f.kernel.name not in called]
    members += [(MEMBERS.get(name, name), name) for name in own]
    members += [(name, f"ccgen_{name}_{banner.package}") for name in ("acceleration_lanes", "stages")]
    return (
        _environment()
        .get_template("model.c.j2")
        .render(
            **vars(banner),
            functions=functions,
            sizes=list(vars(sizes).items()),
            members=members,
            tables={name: list(values) for name, values in tables.items() if values},
            root=root,
            floating=root >= 0,
            index=list(index),
        )
    )


def render_lanes(banner: Banner, program: Program) -> str:
    """The acceleration over lanes in C11 with vectors."""
    function = program.function("acceleration")
    slots, spell = _written(function, _slots(program))
    guards = [(spell(write(pivot, C)), spell(write(scale, C))) for pivot, scale in function.kernel.guards]
    slots = over_lanes(slots, guards, repr(GUARD))
    return _environment().get_template("lanes.c.j2").render(**vars(banner), function=slots)


def render_one_lane(banner: Banner) -> str:
    """What stands in for the functions over lanes where there are none."""
    return _environment().get_template("one_lane.c.j2").render(vars(banner))


def _slots(program: Program) -> dict[sp.Symbol, int]:
    """Where each parameter and each derived constant lies in ``k``."""
    slots = {sp.Symbol(p.symbol): i for i, p in enumerate(program.parameters)}
    return slots | {a.symbol: len(program.parameters) + i for i, a in enumerate(program.constants)}


def _constants(program: Program) -> dict[str, object]:
    """The function that fills ``k``: the parameters, then what is derived from them."""
    offset = len(program.parameters)
    purpose = "constants k from parameters p: the parameters themselves, then what is derived from them"
    return {
        "name": "derive_constants",
        "purpose": purpose if offset else "no constants: the values of the parameters are folded into the code",
        "counts": f"{len(program.parameters)} parameters, {len(program.constants)} derived constants",
        "meanings": [f"k[{i}]: {p.path}" for i, p in enumerate(program.parameters)],
        "signature": "const double *p, double *k",
        "solves": False,
        "loads": [(p.symbol, f"p[{i}]") for i, p in enumerate(program.parameters)],
        "arrays": [],
        "angles": Angles(),
        "sections": [Lines("derived", tuple(_text(a.symbol, a.expression) for a in program.constants))]
        if program.constants
        else [],
        "clears": [],
        "outputs": [(f"k[{i}]", p.symbol) for i, p in enumerate(program.parameters)]
        + [(f"k[{offset + i}]", a.symbol.name) for i, a in enumerate(program.constants)],
        "unused": [] if program.parameters else ["p", "k"],
    }


def _text(symbol: sp.Symbol, expression: sp.Expr) -> tuple[str, str]:
    return (str(symbol.name), write(expression, C))


def _function(function: Function, slots: Mapping[sp.Symbol, int]) -> dict[str, object]:
    return _written(function, slots)[0]


def _written(function: Function, slots: Mapping[sp.Symbol, int]) -> tuple[dict[str, object], Callable[[str], str]]:
    """What the template needs of a function, and how names outside of its loops are spelled."""
    kernel = function.kernel
    solver = next((name for name in SOLVERS if kernel.name in (name, name + AT_DEAD_CENTRES)), None)
    arguments = SIGNATURES.get(solver or kernel.name) or ("k", *(a.name for a in kernel.inputs))
    places = {s.name: ("k", slots[s]) for s in function.constants}
    places |= {s.name: (name, i) for name, i, s in function.inputs_used() if name != "t"}
    outputs, guards = _outputs(kernel), _guards(kernel)
    angles, blocks = _angles(function, places)
    places |= angles.places
    results = {name for text in (*(text for _, text in outputs), guards) for name in NAME.findall(text)}
    rolled = roll(blocks, places, results, reserved={*arguments, "i", "c", "s", *(o.name for o in kernel.outputs)})
    scalars = rolled.scalars | results
    read = {array for name, (array, _) in places.items() if name in scalars} | rolled.read(places)
    read |= {angles.array} if angles.count else set()
    read |= {name for name, _, _ in function.inputs_used() if name == "t"}
    filled = {output.name for output in kernel.outputs if output.entries}
    written: dict[str, object] = {
        "name": kernel.name,
        "purpose": kernel.purpose,
        "counts": str(function.counts()),
        "meanings": _meanings(kernel),
        "signature": ", ".join(
            [f"double {a}" if a == "t" else f"const double *{a}" for a in arguments]
            + [f"double *{output.name}" for output in kernel.outputs]
        ),
        "solves": solver is not None,
        "otherwise": kernel.otherwise
        and f"{kernel.otherwise}({', '.join([*arguments, *(o.name for o in kernel.outputs)])})",
        "arrays": rolled.arrays,
        "angles": angles,
        "loads": [(name, f"{array}[{i}]") for name, (array, i) in places.items() if name in scalars],
        "sections": rolled.statements,
        "clears": [(output.name, len(output.entries)) for output in kernel.outputs if _sparse(output)],
        "outputs": [(target, rolled.spell(text)) for target, text in outputs],
        "unused": [a for a in arguments if a not in read] + [o.name for o in kernel.outputs if o.name not in filled],
        "lost_rank": rolled.spell(guards) or "0",
    }
    return written, rolled.spell


@dataclass(frozen=True)
class Angles:
    """Angles whose sines and cosines a kernel needs: ``count`` of ``array`` from ``first``; where c and s lie."""

    array: str = ""
    first: int = 0
    count: int = 0
    places: Mapping[str, Place] = field(default_factory=dict)


def _angles(function: Function, given: Mapping[str, Place]) -> tuple[Angles, list[Lines]]:
    """Takes the sines and cosines out of the blocks: they are computed together, before everything else."""
    found: dict[str, tuple[str, Place]] = {}
    blocks = []
    for section in function.sections:
        lines = []
        for a in section.assignments:
            name, text = _text(a.symbol, a.expression)
            if a.expression.func in (sp.sin, sp.cos) and given.get(text[4:-1], ("",))[0] == "q":
                found[name] = (text[:3], given[text[4:-1]])
            else:
                lines.append((name, text))
        if lines:
            blocks.append(Lines(section.title, tuple(lines)))
    if not found:
        return Angles(), blocks
    indices = [index for _, (_, index) in found.values()]
    first, array = min(indices), next(iter(found.values()))[1][0]
    places = {name: ("c" if f == "cos" else "s", index - first) for name, (f, (_, index)) in found.items()}
    return Angles(array, first, max(indices) - first + 1, places), blocks


def _guards(kernel: Kernel) -> str:
    return " || ".join(f"!({write(pivot, C)} > {GUARD!r}*{write(scale, C)})" for pivot, scale in kernel.guards)


def _meanings(kernel: Kernel) -> list[str]:
    lines = [f"{a.name}[{len(a.symbols)}]: {a.meaning}" for a in kernel.inputs]
    return lines + [f"{o.name}[{len(o.entries)}]: {o.meaning}" for o in kernel.outputs]


def _sparse(output: Output) -> bool:
    return sum(1 for entry in output.entries if entry == 0) > 8


def _outputs(kernel: Kernel) -> list[tuple[str, str]]:
    """Entry by entry; zeros of an array that was cleared are left out."""
    return [
        (f"{output.name}[{i}]", write(entry, C))
        for output in kernel.outputs
        for i, entry in enumerate(output.entries)
        if entry != 0 or not _sparse(output)
    ]
