"""Program in, texts of the generated files out (all but the listing)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache

import jinja2

from ..equations.equations import Equations
from ..program.routine import Routines
from .derivatives import OF_ACCELERATIONS, Derivatives, shared_angles, tangents
from .lanes import over_lanes, over_states
from .precision import DOUBLE, Precision
from .routines import Writer

MEMBERS = {"points": "point_positions", "indicators": "indicate", "event_values": "find_event_values"}
"""Kernels whose place in the contract has another name."""

IN_LANES = ("acceleration_lanes", "acceleration_states", "stages")
"""Members of the contract that are in a file of their own."""

OPTIONAL = ("latches", "told", "lines", "indicators", "event_values")
"""Sizes that are left out where they are 0."""

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
    """Array sizes of the contract, in the order of ``struct ccgen_model``; those with a default are left out where
    they are 0."""

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
    switches: int
    latches: int = 0
    told: int = 0
    lines: int = 0
    indicators: int = 0
    event_values: int = 0


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


def render_binding(version: str, capsule: str) -> str:
    """The Cython module that hands over the descriptor in a capsule of that name; the same for every scene."""
    return _environment().get_template("binding.pyx.j2").render(version=version, capsule=capsule)


def render_package(banner: Banner) -> str:
    """The package's ``__init__.py``."""
    return _environment().get_template("package.py.j2").render(**vars(banner), methods=METHODS)


def render_c(
    banner: Banner,
    routines: Routines,
    sizes: Sizes,
    tables: Mapping[str, Sequence[int] | Sequence[float]],
    root: int,
    index: Iterable[str],
    numbers: Precision = DOUBLE,
    derivatives: bool = False,
) -> str:
    """The model in C11: one function per kernel and the descriptor. ``tables`` are the contract's arrays of numbers.

    With ``derivatives`` the descriptor names those of :func:`render_derivatives`.
    """
    program = routines.program
    writer = Writer(numbers)
    functions = [writer.routine(r, routines.packed_from) for r in routines.made]
    members = [("derive_constants", "derive_constants")]
    called = {f.kernel.otherwise for f in program.functions}
    own = [f.kernel.name for f in program.functions if f.kernel.name not in called]
    members += [(MEMBERS.get(name, name), name) for name in own]
    members += [(name, f"CCGEN_CALLED(ccgen_{name}, {banner.package})") for name in IN_LANES]
    return (
        _environment()
        .get_template("model.c.j2")
        .render(
            **vars(banner),
            constants=writer.constants(routines),
            functions=functions,
            real=numbers.type,
            preamble=numbers.preamble,
            header="sincos.h" if numbers.double else "one_lane.h",
            abreast=max(r.lanes for r in routines.made),
            sizes=[(name, value) for name, value in vars(sizes).items() if value or name not in OPTIONAL],
            members=members,
            tables={name: list(values) for name, values in tables.items() if values},
            root=root,
            floating=root >= 0,
            index=list(index),
            derivatives=derivatives,
        )
    )


def render_derivatives(banner: Banner, equations: Equations, routines: Routines, numbers: Precision = DOUBLE) -> str:
    """The derivatives of the functions in C11, for as many directions at a time as there are lanes."""
    writer, found = Derivatives(routines, numbers), tangents(equations, routines)
    shared = shared_angles(found)
    return (
        _environment()
        .get_template("derivatives.c.j2")
        .render(
            **vars(banner),
            constants=writer.constants(),
            functions=[writer.function(one) for one in found],
            members=[one.name for one in found if one.name in OF_ACCELERATIONS],
            shared={"first": shared.start, "count": len(shared)} if shared else None,
            member={"lambda": "multipliers"},
            real=numbers.type,
            preamble=numbers.preamble,
            header="sincos.h" if numbers.double else "one_lane.h",
        )
    )


def render_lanes(banner: Banner, routines: Routines) -> str:
    """The acceleration over lanes in C11 with vectors."""
    routine = routines.one_by_one("acceleration")
    slots = {"function": over_lanes(routine, routines.packed_from), "states": over_states(routine)}
    return _environment().get_template("lanes.c.j2").render(**vars(banner), **slots)


def render_one_lane(banner: Banner, numbers: Precision) -> str:
    """What stands in for the functions over lanes where there are none."""
    return _environment().get_template("one_lane.c.j2").render(**vars(banner), preamble=numbers.preamble)
