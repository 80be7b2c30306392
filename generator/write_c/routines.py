"""Routines in C: what the templates print of each function."""

from __future__ import annotations

from collections.abc import Callable

from ..equations.equations import Kernel
from ..program.dialects import C, Dialect
from ..program.rolling import Lines, Loop
from ..program.routine import Angles, Routine, Routines, is_sparse
from ..program.terms import Assign, Element, Gathered, Guard, Leaf, Name, Term, exchanged
from .precision import Precision

Slots = dict[str, object]
"""What a template reads."""

VECTOR = "ccgen_abreast"
"""The C type of one quantity of several equal modules."""

GATHERED = ("k", "c", "s")
"""Arrays that are read as vectors too, under their names with ``_abreast`` behind."""


class Writer:
    """Prints routines in one type of numbers."""

    def __init__(self, numbers: Precision) -> None:
        self.numbers = numbers
        self.c = numbers.dialect(VECTOR)

    def constants(self, routines: Routines) -> Slots:
        """The function that fills ``k``: parameters, what is derived from them, and constants of modules abreast."""
        program = routines.program
        purpose = "constants k from parameters p: the parameters themselves, then what is derived from them"
        if routines.packed_constants:
            purpose += ",\n * then those of equal modules side by side"
        count = len(program.parameters)
        places = {name: Element("k", index) for name, index in routines.slots.items()}

        def placed(leaf: Leaf) -> Leaf:
            return places[leaf.name] if isinstance(leaf, Name) else leaf

        lines = [
            Assign(places[a.symbol.name], exchanged(routines.order(a.expression), placed)) for a in program.constants
        ]
        return {
            "purpose": purpose if count else "no constants: the values of the parameters are folded into the code",
            "counts": f"{count} parameters, {len(lines)} derived constants",
            "meanings": [f"k[{i}]: {p.path}" for i, p in enumerate(program.parameters)],
            "real": self.numbers.type,
            "parameters": count,
            "lines": [
                (self.c.text(line.target), self.c.text(line.value), a.symbol.name)
                for line, a in zip(lines, program.constants, strict=True)
            ],
            "first": routines.packed_from,
            "packed": [routines.slots[name] for name in routines.packed_constants],
        }

    def routine(self, routine: Routine, packed_from: int) -> Slots:
        """One kernel; constants of modules begin at ``packed_from``."""
        kernel, real = routine.function.kernel, self.numbers.type
        arguments = list(routine.arguments)
        if kernel.columns:
            arguments.insert(min(arguments.index(a) for a in arguments if a in kernel.columns), "count")
        call = ", ".join([*arguments, *(o.name for o in kernel.outputs)])
        sizes = lengths(kernel)

        def moves(line: Assign) -> bool:
            return isinstance(line.value, Element) and line.value.array in kernel.columns

        lost = [f"!{self._holds(guard)}" for guard in routine.guards]
        return {
            "name": kernel.name,
            "purpose": kernel.purpose,
            "counts": str(routine.function.counts()),
            "meanings": meanings(routine),
            "signature": ", ".join(
                [{"t": f"{real} t", "count": "int count"}.get(a, f"const {real} *{a}") for a in arguments]
                + [f"{real} *{output.name}" for output in kernel.outputs]
            ),
            "solves": routine.solver,
            "otherwise": kernel.otherwise and f"{kernel.otherwise}({call})",
            "arrays": [(VECTOR if routine.lanes > 1 else real, *array) for array in routine.arrays],
            "angles": self._angles(routine.angles, routine.lanes),
            "views": self._views(routine, packed_from),
            "loads": [self._declared(line) for line in routine.loads if not moves(line)],
            "each_loads": [self._declared(line) for line in routine.loads if moves(line)],
            "sections": [self._part(part) for part in routine.statements if not part.late],
            "late": [self._part(part) for part in routine.statements if part.late],
            "strides": [(name, sizes[name]) for name in kernel.columns],
            "clears": clears(routine),
            "outputs": outputs(routine, self.c.text, asked=False),
            "asked": kernel.asked if kernel.asked not in routine.unused else None,
            "asked_outputs": outputs(routine, self.c.text, asked=True),
            "unused": routine.unused,
            "lost_rank": " || ".join(lost) or "0",
        }

    def _angles(self, angles: Angles, lanes: int) -> Slots | None:
        if not angles.order:
            return None
        count, first = len(angles.order), angles.first
        if first is not None:
            return {"count": count, "read": angles.array + (f" + {first}" if first else ""), "gathered": []}
        entries = [Element(angles.array, index) for index in angles.order]
        vectors = [Gathered(tuple(entries[i : i + lanes])) for i in range(0, count, lanes)]
        return {"count": count, "read": "(const double *)angles", "gathered": [self.c.text(v) for v in vectors]}

    def _views(self, routine: Routine, packed_from: int) -> list[tuple[str, str]]:
        """Arrays of numbers that loops read as vectors, or from where the constants of modules begin."""
        starts = {"k": f"k + {packed_from}", "c": "c", "s": "s"}
        read = [array for array in GATHERED if routine.reads(f"{array}_abreast")]
        if routine.lanes == 1:
            return [(f"const {self.numbers.type} *{array}_abreast", starts[array]) for array in read]
        return [
            (f"const {VECTOR}_stored *{array}_abreast", f"(const {VECTOR}_stored *)({starts[array]})") for array in read
        ]

    def _part(self, part: Lines | Loop) -> Slots:
        if isinstance(part, Lines):
            return self._block(part, part.lanes)
        blocks = [self._block(block, part.lanes) for block in part.body]
        return {"title": part.title, "rounds": part.rounds, "modules": part.modules, "body": blocks}

    def _block(self, block: Lines, lanes: int) -> Slots:
        return {"title": block.title, "rounds": 0, "lines": [self._declared(line, lanes) for line in block.lines]}

    def _holds(self, guard: Guard) -> str:
        if guard.least is None:
            return f"ccgen_positive({self.c.text(guard.pivot)})"
        return f"({self.c.text(guard.pivot)} > {self.c.text(guard.least)})"

    def _declared(self, line: Assign, lanes: int = 1) -> tuple[str, str]:
        return declared(line, self.numbers.type if lanes == 1 else VECTOR, self.c)


def lengths(kernel: Kernel) -> dict[str, int]:
    """How many numbers each argument and output of a kernel has."""
    return {a.name: len(a.symbols) for a in kernel.inputs} | {o.name: len(o.entries) for o in kernel.outputs}


def declared(line: Assign, kind: str, dialect: Dialect) -> tuple[str, str]:
    """Target and value of an assignment; a name is declared as it is assigned."""
    declaration = f"const {kind} " if isinstance(line.target, Name) else ""
    return declaration + dialect.text(line.target), dialect.text(line.value)


def meanings(routine: Routine) -> list[str]:
    """What arguments and outputs are."""
    kernel = routine.function.kernel
    lines = [f"{a.name}[{len(a.symbols)}]: {a.meaning}" for a in kernel.inputs]
    return lines + [f"{o.name}[{len(o.entries)}]: {o.meaning}" for o in kernel.outputs]


def outputs(routine: Routine, text: Callable[[Term], str], asked: bool) -> list[tuple[str, str]]:
    """Entries of outputs and their values: of the one that is computed where it is ``asked`` for, or of all others."""
    name = routine.function.kernel.asked
    lines = [x for x in routine.outputs if isinstance(x.target, Element) and (x.target.array == name) == asked]
    return [(C.text(line.target), text(line.value)) for line in lines]


def clears(routine: Routine) -> list[tuple[str, int]]:
    """Outputs that are cleared before their entries are assigned."""
    kernel = routine.function.kernel
    return [(o.name, len(o.entries)) for o in kernel.outputs if is_sparse(o.entries) and o.name != kernel.asked]
