"""Tangents of a model's functions in C: what ``derivatives.c.j2`` prints of each."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from itertools import chain

from ..equations.equations import Equations
from ..program.program import Function, function_of
from ..program.residuals import RESIDUAL, residuals
from ..program.rolling import Lines, Loop
from ..program.routine import Routines
from ..program.tangent import PREFIX, Tangent, tangent, tangent_of_line
from ..program.terms import Assign, Element, Leaf, Name, Term, exchanged
from .precision import Precision
from .routines import Slots, declared

VECTOR = "ccgen_lanes"

ARGUMENTS = ("k", "q", "u", "t", "inputs", "u_dot", "lambda", "P", "f", "y")
"""Members of ``struct ccgen_arguments``."""

PARTS = {"q": ("q",), "u": ("u",), "k": ("k",), "t": ("t", "inputs")}
"""The derivatives of the residual, each a function of its own: most of it does not depend on most of these."""

OF_SOLUTIONS = ("acceleration", "impulse", "contact_response")
"""Functions whose derivatives follow from those of the residuals."""

LEFT_OUT = ("momentum", "inverse_dynamics", "switching", "latching", "reaches")
"""Functions of which no derivative is asked for, or that of another stands for."""

INDICATORS = "indicators"
"""That of event indicators, of which the derivatives of the values alone are asked for."""

SOLVE = "solve"

OF_ACCELERATIONS = (*(f"{RESIDUAL}_{part}" for part in PARTS), SOLVE, "prescribed")
"""Derivatives of which those of accelerations are made."""


def tangents(equations: Equations, routines: Routines) -> list[Tangent]:
    """The derivatives that a model has, of those that do not vanish; in the order of its functions."""
    found = []
    functions = [one for one in routines.program.functions if one.kernel.name != INDICATORS]
    for function in chain(functions, _indicators(equations), residuals(equations)):
        name = function.kernel.name
        parts = _parts(function)
        if name == "impulse":
            found.append(tangent(routines.link_by_link(function), SOLVE, ("f", "y")))
        elif not name.startswith(OF_SOLUTIONS) and name not in LEFT_OUT:
            routine = routines.link_by_link(function)
            found += [tangent(routine, called, given) for called, given in parts.items()]
    return [one for one in found if not one.vanishes]


def _indicators(equations: Equations) -> list[Function]:
    """The values of the event indicators, without their rates and sizes."""
    values = [
        replace(kernel, inputs=tuple(a for a in kernel.inputs if a.name in ARGUMENTS), outputs=kernel.outputs[:1])
        for kernel in equations.kernels
        if kernel.name == INDICATORS
    ]
    return [function_of(equations, kernel) for kernel in values]


def _parts(function: Function) -> dict[str, tuple[str, ...]]:
    """Names of the derivatives of a function, and the arguments that move in each."""
    kernel = function.kernel
    if kernel.name == RESIDUAL:
        return {f"{RESIDUAL}_{part}": given for part, given in PARTS.items()}
    return {kernel.name: ("k", *(a.name for a in kernel.inputs))}


def shared_angles(found: Iterable[Tangent]) -> range:
    """The coordinates whose sines and cosines the derivatives of accelerations read, and those between them."""
    read = [angles for one in found if one.name in OF_ACCELERATIONS and (angles := _angles(one))]
    return range(min(one.start for one in read), max(one.stop for one in read)) if read else range(0)


def _angles(one: Tangent) -> range:
    """The coordinates whose sines and cosines it reads; routines link by link read them one after the other."""
    angles = one.routine.angles
    if not angles.order or not one.read & {"c", "s"}:
        return range(0)
    assert angles.array == "q" and angles.first is not None
    return range(angles.first, angles.first + len(angles.order))


def _sizes(one: Tangent, constants: int) -> Mapping[str, int]:
    return {"k": constants} | {a.name: len(a.symbols) for a in one.routine.function.kernel.inputs}


class Derivatives:
    """Prints tangents in one type of numbers."""

    def __init__(self, routines: Routines, numbers: Precision) -> None:
        self.routines, self.numbers = routines, numbers
        self.c = numbers.dialect()
        self.constants_count = routines.packed_from + len(routines.packed_constants)

    def function(self, one: Tangent) -> Slots:
        """One function."""
        angles = _angles(one)
        reads = [x for x in ARGUMENTS if x in one.read and x != "t"]
        if angles and "q" not in reads:
            reads.append("q")
        sizes = _sizes(one, self.constants_count)
        lost = " || ".join(
            f"!({self.c.text(g.pivot)} > {self.c.text(g.least)})" for g in one.routine.guards if g.least is not None
        )
        return {
            "name": f"{one.name}_tangent",
            "purpose": f"tangents of {one.routine.function.kernel.name} along "
            f"{', '.join(one.moving)}: {one.routine.function.kernel.purpose}",
            "meanings": [f"{x}[{sizes[x]}]" for x in one.moving],
            "results": one.results,
            "reads": reads,
            "timed": "t" in one.read,
            "value_arrays": one.value_arrays,
            "angles": {"first": angles.start, "count": len(angles)} if angles else None,
            "shares": one.name in OF_ACCELERATIONS,
            "loads": [declared(line, self.numbers.type, self.c) for line in one.loads],
            "value_sections": [self._part(part) for part in one.values],
            "lost": lost,
            "moving": [(PREFIX + x, x, one.results if one.name == SOLVE else sizes[x]) for x in one.moving],
            "arrays": one.arrays,
            "sections": [self._part(part) for part in one.statements],
            "outputs": [(self.c.text(line.target), self._vector(line.value)) for line in one.outputs],
        }

    def constants(self) -> Slots:
        """The tangents of the constants along those of the parameters."""
        routines, count = self.routines, len(self.routines.program.parameters)
        places = {name: Element("k", index) for name, index in routines.slots.items()}

        def placed(leaf: Leaf) -> Leaf:
            return places[leaf.name] if isinstance(leaf, Name) else leaf

        lines = [
            tangent_of_line(Assign(places[a.symbol.name], exchanged(routines.order(a.expression), placed)), {"k"})
            for a in routines.program.constants
        ]
        named = [(line, a.symbol.name) for line, a in zip(lines, routines.program.constants, strict=True)]
        return {
            "parameters": count,
            "all": self.constants_count,
            "lines": [(self.c.text(line.target), self._vector(line.value), name) for line, name in named],
            "first": routines.packed_from,
            "packed": [routines.slots[name] for name in routines.packed_constants],
        }

    def _vector(self, term: Term) -> str:
        """Tangents, or zero in all lanes."""
        text = self.c.text(term)
        return text if PREFIX in text else f"CCGEN_ALL({text})"

    def _part(self, part: Lines | Loop) -> Slots:
        if isinstance(part, Lines):
            return {"title": part.title, "rounds": 0, "lines": [self._line(line) for line in part.lines]}
        blocks = [self._part(block) for block in part.body]
        return {"title": part.title, "rounds": part.rounds, "modules": False, "body": blocks}

    def _line(self, line: Assign) -> tuple[str, str]:
        label = line.target.name if isinstance(line.target, Name) else line.target.array
        target, text = declared(line, VECTOR if label.startswith(PREFIX) else self.numbers.type, self.c)
        return target, self._vector(line.value) if label.startswith(PREFIX) else text
