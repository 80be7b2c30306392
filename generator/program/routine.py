"""A kernel as typed statements, ready for a language: loops found, places of quantities settled.

Function (named assignments) → terms → loops over links or modules → Routine. Languages print routines as they are.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property

from ..equations.equations import GUARD, OTHERWISE
from .abreast import Packed, abreast, padded
from .long_modules import rolled_modules
from .program import Function, Program
from .response import NAME as RESPONSE
from .rolling import Lines, Loop, Place, roll, roll_finely
from .terms import Assign, Call, Element, Guard, Name, Number, Ordering, Product, Term, leaves

SIGNATURES: Mapping[str, tuple[str, ...]] = {
    "acceleration": ("k", "q", "u", "t", "inputs"),
    "inverse_dynamics": ("k", "q", "u", "t", "inputs", "u_dot"),
    "reactions": ("k", "q", "u", "t", "inputs", "u_dot", "lambda"),
    "power": ("k", "q", "u", "t", "inputs", "u_dot", "lambda"),
    "switching": ("k", "q", "u", "t", "inputs"),
    "latching": ("k", "q", "u", "t", "inputs"),
    "outputs": ("k", "q", "u", "t", "inputs"),
    "impulse_reactions": ("k", "q", "u", "lambda"),
    "indicators": ("k", "q", "u", "t", "scales"),
    "event_values": ("k", "q", "u", "t"),
}
"""Kernels whose contract has more arguments than the kernel reads; those for dead centres take the same."""

SOLVERS = ("acceleration", "impulse", RESPONSE)
"""Kernels that say whether they have solved."""

LANES = 4
"""Modules in one vector, where there are more than two. Compilers make two vectors of one that the machine has not."""

LONG = 400
"""Assignments of a function, outputs included, from which on loops are sought within blocks and among outputs too."""

LOOP = "i"
"""The counter of loops."""


@dataclass(frozen=True)
class Angles:
    """Coordinates whose sines and cosines a routine needs, by index into ``array``, in the order of c and s."""

    array: str = ""
    order: tuple[int, ...] = ()

    @property
    def first(self) -> int | None:
        """The first, where they follow one another in the array; else ``None``."""
        start = self.order[0] if self.order else 0
        return start if self.order == tuple(range(start, start + len(self.order))) else None


@dataclass(frozen=True)
class Routine:
    """One kernel. ``arrays`` are (name, size); with ``lanes`` over 1 they hold vectors of that many modules.

    ``loads`` give names to entries of arguments; ``outputs`` are assigned after the statements; where a guard does not
    hold, a solver has not solved. ``modules`` are those of the program that go side by side, group by group.
    """

    function: Function
    solver: bool
    arguments: tuple[str, ...]
    angles: Angles
    arrays: tuple[tuple[str, int], ...]
    loads: tuple[Assign, ...]
    statements: tuple[Lines | Loop, ...]
    outputs: tuple[Assign, ...]
    guards: tuple[Guard, ...]
    unused: tuple[str, ...]
    lanes: int = 1
    modules: tuple[tuple[int, ...], ...] = ()

    def reads(self, array: str) -> bool:
        """Whether statements read an array by index."""
        blocks = (b for part in self.statements for b in (part.body if isinstance(part, Loop) else (part,)))
        values = (line.value for block in blocks for line in block.lines)
        return any(isinstance(leaf, Element) and leaf.array == array for value in values for leaf in leaves(value))


class Routines:
    """Makes routines of a program's functions. Constants of equal modules are laid side by side for all of them."""

    def __init__(self, program: Program, order: Ordering, vectors: bool = True) -> None:
        self.program, self.order = program, cache(order)
        self.slots = {p.symbol: i for i, p in enumerate(program.parameters)}
        self.slots |= {a.symbol.name: len(program.parameters) + i for i, a in enumerate(program.constants)}
        self.owner = {s.name: number for number, module in enumerate(program.modules) for s in module}
        self.lanes = (LANES if len(program.modules) > 2 else 2) if vectors else 1
        self.packed: Packed[str] = Packed(self.lanes)
        self.packed_from = len(self.slots)

    @cached_property
    def made(self) -> tuple[Routine, ...]:
        """A routine for each function of the program, in its order."""
        return tuple(self._routine(function, self.lanes) for function in self.program.functions)

    @property
    def packed_constants(self) -> tuple[str, ...]:
        """Names of the constants of modules side by side, which lie behind all others, from ``packed_from`` on."""
        return tuple(self.packed.entries) if self.made else ()

    def one_by_one(self, name: str) -> Routine:
        """The routine of a kernel with modules one at a time: vectors are free for states side by side."""
        return self._routine(self.program.function(name), 1)

    def link_by_link(self, function: Function) -> Routine:
        """The routine of a function without a look at modules: its loops go over links alone."""
        return self._routine(function, 0)

    def _routine(self, function: Function, lanes: int) -> Routine:
        kernel = function.kernel
        solver = next((name for name in SOLVERS if kernel.name in (name, name + OTHERWISE)), None)
        arguments = SIGNATURES.get(solver or kernel.name) or ("k", *(a.name for a in kernel.inputs))
        places: dict[str, Place] = {s.name: ("k", self.slots[s.name]) for s in function.constants}
        places |= {s.name: (name, i) for name, i, s in function.inputs_used() if name != "t"}
        sparse = {o.name for o in kernel.outputs if is_sparse(o.entries) and o.name != kernel.asked}
        outputs = [
            Assign(Element(output.name, i), self.order(entry))
            for output in kernel.outputs
            for i, entry in enumerate(output.entries)
            if entry != 0 or output.name not in sparse
        ]
        guards = [
            Guard(self.order(pivot), Product((Number(GUARD), self.order(scale)))) for pivot, scale in kernel.guards
        ]
        blocks, turned = self._blocks(function, places)
        if kernel.columns:
            given = {s.name for a in kernel.inputs if a.name in kernel.columns for s in a.symbols}
            blocks = _behind(blocks, _moving(blocks, given))
        elif kernel.asked:
            own = [line.value for line in outputs if _array(line) != kernel.asked]
            blocks = _behind(blocks, _spare(blocks, _named([*own, *_entries(guards)])))
        owner = self.owner | {name: self.owner[x] for name, (_, _, x) in turned.items() if x in self.owner}
        start = min((index for _, index, _ in turned.values()), default=0)
        places |= {name: (letter, index - start) for name, (letter, index, _) in turned.items()}
        results = _named([line.value for line in outputs])
        side = abreast(blocks, owner, places, results, guards, self.packed, lanes) if lanes else None
        reserved = {*arguments, LOOP, "c", "s", *(o.name for o in kernel.outputs)}
        # outputs wait for guards, for a caller's room, for zeros, and those of link_by_link stay one by one
        whole = lanes > 0 and not (solver or kernel.asked or sparse)
        if whole and _written(blocks) + len(outputs) > LONG:
            rolled, left = roll_finely(blocks, outputs, places, results, reserved)
        else:
            rolled, left = roll(blocks, places, results | _named(_entries(guards)), reserved), outputs
        if side:
            side = rolled_modules(side, [side.placed(line.value) for line in outputs], reserved)
            if _written(rolled.statements) < _written(side.statements):
                side = None  # few long modules: loops over their links are shorter
        if side is None:
            placed, statements, arrays, outputs = rolled.placed, rolled.statements, rolled.arrays, left
            guards = [Guard(placed(g.pivot), g.least and placed(g.least)) for g in guards]
        else:
            placed, statements, arrays, guards = side.placed, side.statements, side.arrays, side.guards
        angles = self._angles(turned, places, [start + i for i in side.angles.entries] if side else [], lanes)
        outputs = [Assign(line.target, placed(line.value)) for line in outputs]
        read = self._read(statements, [*(line.value for line in outputs), *_entries(guards)])
        loads = [Assign(Name(name), Element(*place)) for name, place in places.items() if name in read]
        used = read | {place[0] for name, place in places.items() if name in read} | {angles.array}
        used |= {"k"} if "k_abreast" in used else set()
        filled = {output.name for output in kernel.outputs if output.entries}
        unused = [a for a in arguments if a not in used] + [o.name for o in kernel.outputs if o.name not in filled]
        return Routine(
            function,
            solver is not None,
            tuple(arguments),
            angles,
            tuple(arrays),
            tuple(loads),
            tuple(statements),
            tuple(outputs),
            tuple(guards),
            tuple(unused),
            lanes if side else 1,
            tuple(group.members for group in side.groups) if side else (),
        )

    def _read(self, statements: Sequence[Lines | Loop], ends: Sequence[Term]) -> set[str]:
        """Names and arrays that are read, and arrays that are written, anywhere."""
        blocks = [b for part in statements for b in (part.body if isinstance(part, Loop) else (part,))]
        terms = [line.value for block in blocks for line in block.lines] + list(ends)
        return {leaf.name if isinstance(leaf, Name) else leaf.array for term in terms for leaf in leaves(term)}

    def _blocks(
        self, function: Function, given: Mapping[str, Place]
    ) -> tuple[list[Lines], dict[str, tuple[str, int, str]]]:
        """Blocks without sines and cosines of coordinates; those by name: letter, index and name of the coordinate."""
        turned: dict[str, tuple[str, int, str]] = {}
        blocks = []
        for section in function.sections:
            lines = []
            for a in section.assignments:
                value = self.order(a.expression)
                match value:
                    case Call("sin" | "cos" as letter, Name(angle)) if given.get(angle, ("",))[0] == "q":
                        turned[str(a.symbol.name)] = (letter[0], given[angle][1], angle)
                    case _:
                        lines.append(Assign(Name(str(a.symbol.name)), value))
            if lines:
                blocks.append(Lines(section.title, tuple(lines), shared=section.shared))
        return blocks, turned

    def _angles(
        self,
        turned: Mapping[str, tuple[str, int, str]],
        places: dict[str, Place],
        first: Sequence[int],
        lanes: int,
    ) -> Angles:
        """Settles where sines and cosines lie: those of modules side by side, then the others, else as in q."""
        if not turned:
            return Angles()
        indices = sorted({index for _, index, _ in turned.values()})
        if first:
            order = [*first, *(index for index in indices if index not in first)]
            order = padded(order, lanes)
        else:
            order = list(range(indices[0], indices[-1] + 1))
        at = {index: number for number, index in reversed(list(enumerate(order)))}
        for name, (letter, index, _) in turned.items():
            places[name] = (letter, at[index])
        return Angles("q", tuple(order))


def _array(line: Assign) -> str:
    return line.target.array if isinstance(line.target, Element) else ""


def _moving(blocks: Sequence[Lines], given: set[str]) -> set[str]:
    """Names of what depends on the inputs ``given``."""
    moving = set(given)
    for block in blocks:
        for line in block.lines:
            if isinstance(line.target, Name) and _named([line.value]) & moving:
                moving.add(line.target.name)
    return moving


def _spare(blocks: Sequence[Lines], results: set[str]) -> set[str]:
    """Names of what the ``results`` do not depend on."""
    needed, every = set(results), set[str]()
    for block in reversed(blocks):
        for line in reversed(block.lines):
            if isinstance(line.target, Name):
                every.add(line.target.name)
                if line.target.name in needed:
                    needed |= _named([line.value])
    return every - needed


def _behind(blocks: Sequence[Lines], late: set[str]) -> list[Lines]:
    """The blocks with what is ``late`` behind all the rest."""
    now: list[Lines] = []
    then: list[Lines] = []
    for block in blocks:
        for found, lines in (
            (now, tuple(line for line in block.lines if not _named([line.target]) & late)),
            (then, tuple(line for line in block.lines if _named([line.target]) & late)),
        ):
            if lines:
                found.append(replace(block, lines=lines, late=found is then))
    return now + then


def _written(statements: Sequence[Lines | Loop]) -> int:
    """How many assignments are written out."""
    blocks = (b for part in statements for b in (part.body if isinstance(part, Loop) else (part,)))
    return sum(len(block.lines) for block in blocks)


def _entries(guards: Sequence[Guard]) -> list[Term]:
    """What guards compare."""
    return [entry for guard in guards for entry in (guard.pivot, guard.least) if entry is not None]


def _named(terms: Sequence[Term]) -> set[str]:
    """Quantities that terms read by name."""
    return {leaf.name for term in terms for leaf in leaves(term) if isinstance(leaf, Name)}


def is_sparse(entries: Sequence[object]) -> bool:
    """Whether an output is cleared as a whole, because many of its entries are zero."""
    return sum(1 for entry in entries if entry == 0) > 8
