"""Equal modules abreast: the legs of a walking machine as one program over lanes of a vector, or over a loop.

A module is a set of links that meets the rest at few joints. What depends on one module's state alone, and on what is
shared, belongs to the module; where the modules' statements are the same but for the quantities in them, they are
written once. What is shared stays as it is. The arithmetic of each quantity does not change.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from graphlib import CycleError, TopologicalSorter
from itertools import pairwise
from typing import Generic, TypeVar

from .rolling import Lines, Loop, Place
from .terms import ZERO, Assign, Call, Element, Gathered, Guard, Leaf, Name, Negative, Sum, Term, exchanged, leaves

T = TypeVar("T")

LEAST = 12
"""Statements of a module, at least: fewer cost less than it does to gather what they read."""

SHARE = 0.4
"""Of all statements, those that belong to equal modules, at least. With a quarter, as in walking machines from tip to
root, what shared statements read of single modules costs more than lanes save; with half they take half of the time."""


@dataclass
class Packed(Generic[T]):
    """Things that lie side by side in an array, a tuple of one per module after the other.

    A tuple takes as many places as it has entries, rounded up to whole vectors of ``lanes``.
    """

    lanes: int
    places: dict[tuple[T, ...], int] = field(default_factory=dict)
    entries: list[T] = field(default_factory=list)

    def place(self, each: tuple[T, ...]) -> int:
        """Index of the first of a tuple, which gets places if it has none."""
        if each not in self.places:
            self.places[each] = len(self.entries)
            self.entries += padded(each, self.lanes)
        return self.places[each]


def padded(each: Sequence[T], lanes: int) -> list[T]:
    """The entries and the last one again, until they fill whole vectors."""
    return [*each, *[each[-1]] * (-len(each) % lanes)]


@dataclass
class Abreast:
    """Statements in order; arrays of one value per module (name, size); names that lie in arrays after all of them.

    ``angles`` are coordinates of modules, by their index: the sines of one tuple, and its cosines, are to lie side by
    side.
    """

    lanes: int
    statements: list[Lines | Loop] = field(default_factory=list)
    arrays: list[tuple[str, int]] = field(default_factory=list)
    places: dict[str, Element] = field(default_factory=dict)
    guards: list[Guard] = field(default_factory=list)
    groups: list[Group] = field(default_factory=list)
    angles: Packed[int] = field(init=False)

    def __post_init__(self) -> None:
        self.angles = Packed(self.lanes)

    def placed(self, term: Term) -> Term:
        """The term with every name that lies in an array as its element."""
        return exchanged(term, lambda leaf: self.places.get(leaf.name, leaf) if isinstance(leaf, Name) else leaf)


@dataclass(frozen=True)
class _Line:
    block: int
    line: Assign

    @property
    def name(self) -> str:
        return self.line.target.name if isinstance(self.line.target, Name) else self.line.target.array


@dataclass
class Group:
    """Equal modules: their statements, position by position."""

    members: tuple[int, ...]
    columns: list[tuple[_Line, ...]]


def abreast(
    blocks: Sequence[Lines],
    owner: Mapping[str, int],
    given: Mapping[str, Place],
    results: Collection[str],
    guards: Sequence[Guard],
    packed: Packed[str],
    lanes: int,
) -> Abreast | None:
    """The blocks with equal modules in loops, ``lanes`` modules at a time; ``None`` where no two are worth it.

    ``owner`` gives the module of each coordinate and rate, of sines and cosines too; ``given`` the places of inputs and
    constants; ``results`` the names that are read afterwards. Constants of modules are put into ``packed``. A sum of
    what is shared and of parts of modules becomes a sum of the modules' parts, each a statement of its module.
    """
    writer = _Writer(blocks, owner, given, set(results), guards, packed, lanes)
    if writer.share() < SHARE:
        return None
    phases = writer.phases()
    return writer.written(phases) if phases else None


class _Writer:
    def __init__(
        self,
        blocks: Sequence[Lines],
        owner: Mapping[str, int],
        given: Mapping[str, Place],
        results: set[str],
        guards: Sequence[Guard],
        packed: Packed[str],
        lanes: int,
    ) -> None:
        self.owner, self.given, self.packed, self.lanes = owner, given, packed, lanes
        self.results = results
        self.kept: set[str] = set()
        self.shared: dict[tuple[str, ...], str] = {}
        self.blocks = [*blocks, Lines("guards", ())]
        self.label: dict[str, int] = dict(owner)
        self.count = len(set(owner.values()))
        self.lines = [
            part
            for number, block in enumerate(blocks)
            for line in block.lines
            for part in self._parts(_Line(number, line))
        ]
        self.guards = [self._guard(number, guard) for number, guard in enumerate(guards)]
        self.groups = self._groups()
        self.home = {
            line.name: (number, position, member)
            for number, group in enumerate(self.groups)
            for position, column in enumerate(group.columns)
            for member, line in enumerate(column)
        }

    # -- labels ----------------------------------------------------------------------------------------------------

    def _modules(self, term: Term) -> set[int]:
        """Modules that a term depends on otherwise than through what is shared."""
        return {self.label[name] for name in map(_named, leaves(term)) if name in self.label}

    def _parts(self, line: _Line) -> list[_Line]:
        """The line with its label; where it sums parts of several modules, these as lines before it."""
        value, name = line.line.value, line.name
        modules = self._modules(value)
        if not modules or self.blocks[line.block].shared:
            return [line]
        if len(modules) == 1:
            self.label[name] = modules.pop()
            return [line]
        if 2 * len(modules) <= self.count or not isinstance(value, Sum):
            return [line]  # what joins neighbours gains nothing
        own: dict[int, list[Term]] = defaultdict(list)
        rest: list[Term] = []
        for term in value.terms:
            found = self._modules(term)
            (own[found.pop()] if len(found) == 1 else rest).append(term)
        before = []
        for module, terms in own.items():
            part = Name(f"{name}_of_{module}")
            self.label[part.name] = module
            before.append(_Line(line.block, Assign(part, terms[0] if len(terms) == 1 else Sum(tuple(terms)))))
            rest.append(part)
        return [*before, _Line(line.block, Assign(line.line.target, Sum(tuple(rest))))]

    def _guard(self, number: int, guard: Guard) -> Guard:
        """The guard; where it belongs to one module, as what must be positive, a line of the module."""
        if guard.least is None:
            return guard
        pivot = self._modules(guard.pivot)
        modules = pivot | self._modules(guard.least)
        if len(modules) != 1 or not pivot:
            self.results |= {_named(leaf) for entry in (guard.pivot, guard.least) for leaf in leaves(entry)}
            return guard
        kept = Name(f"kept_{number}")
        self.label[kept.name] = modules.pop()
        self.lines.append(_Line(len(self.blocks) - 1, Assign(kept, Sum((guard.pivot, Negative(guard.least))))))
        self.results.add(kept.name)
        self.kept.add(kept.name)
        return Guard(kept, ZERO)

    # -- finding ---------------------------------------------------------------------------------------------------

    def _groups(self) -> list[Group]:
        """Modules whose statements are equal one by one."""
        modules: dict[int, list[_Line]] = defaultdict(list)
        for line in self.lines:
            if line.name in self.label:
                modules[self.label[line.name]].append(line)
        alike: dict[tuple[object, ...], list[int]] = defaultdict(list)
        for module in sorted(modules):
            if len(modules[module]) >= LEAST:
                alike[self._shape(modules[module])].append(module)
        return [
            Group(tuple(members), list(zip(*(modules[m] for m in members), strict=True)))
            for members in alike.values()
            if len(members) > 1
        ]

    def _shape(self, lines: Sequence[_Line]) -> tuple[object, ...]:
        """The module's statements with places in them instead of names."""
        number = {line.name: f"own{position}" for position, line in enumerate(lines)}
        seen: dict[str, str] = {}

        def kind(leaf: Leaf) -> Term:
            name = _named(leaf)
            if name in number:
                return Name(number[name])
            if name in self.given:
                array = self.given[name][0]
                return Name(array if array == "k" else seen.setdefault(name, f"{array}{len(seen)}"))
            return Name("shared")

        return tuple((self.blocks[line.block].late, exchanged(line.line.value, kind)) for line in lines)

    def share(self) -> float:
        """The statements that belong to groups of equal modules, as a part of all."""
        inside = sum(len(group.columns) * len(group.members) for group in self.groups)
        return inside / len(self.lines) if inside else 0.0

    # -- ordering --------------------------------------------------------------------------------------------------

    def phases(self) -> dict[str, int] | None:
        """When each statement can go: shared ones of a phase before its modules', those before the next phase.

        Late blocks come behind all others. ``None`` where members of a group wait for each other, as modules in a row.
        """
        phase: dict[str, int] = {}
        for late in (False, True):
            lines = [line for line in self.lines if self.blocks[line.block].late == late]
            start = max(phase.values(), default=-1) + 1
            if not self._settle(lines, phase, start):
                return None
        return phase

    def _settle(self, lines: Sequence[_Line], phase: dict[str, int], start: int) -> bool:
        """Find the first phase, from ``start`` on, that each line can go in; false if some wait for each other."""
        together: dict[object, list[_Line]] = defaultdict(list)  # a column of a group goes as a whole
        for line in lines:
            together[self._column(line.name)].append(line)
        before = {
            one: [name for line in found for name in map(_named, leaves(line.line.value))]
            for one, found in together.items()
        }
        order = TopologicalSorter(
            {one: {self._column(name) for name in names} & together.keys() for one, names in before.items()}
        )
        try:
            for one in order.static_order():
                here = isinstance(one, tuple)
                after = [phase[name] + (name in self.home and not here) for name in before[one] if name in phase]
                phase |= dict.fromkeys((line.name for line in together[one]), max([start, *after]))
        except CycleError:
            return False
        return True

    def _column(self, name: str) -> object:
        """What goes at once with a statement: its group and position, or itself."""
        return self.home[name][:2] if name in self.home else name

    # -- writing ---------------------------------------------------------------------------------------------------

    def written(self, phase: Mapping[str, int]) -> Abreast:
        """The statements in the order of their phases."""
        read_late = self._read_late(phase)
        result = Abreast(self.lanes, groups=self.groups)
        for name, (number, position, member) in self.home.items():
            array = self._array(number, position)
            if array in read_late:
                result.places[name] = self._entry(array, member)
        sizes = {array: self._rounds(self.groups[self.home[array][0]]) for array in read_late}
        for now in sorted(set(phase.values())):
            rest = [line for line in self.lines if phase[line.name] == now and line.name not in self.home]
            result.statements += self._blocks([(x.block, self._placed(x.line, result)) for x in rest])
            for number, group in enumerate(self.groups):
                columns = [c for c in group.columns if phase[c[0].name] == now]
                if not columns:
                    continue
                gathers: list[Assign] = []
                body = [(c[0].block, self._moving(c, number, result, gathers, sizes)) for c in columns]
                blocks = tuple(self._blocks(body))
                if gathers:
                    result.statements.append(Lines("what the modules read", tuple(gathers), blocks[0].late))
                rounds = self._rounds(group)
                others = len(group.members) - 1
                title = f"{blocks[0].title} to {blocks[-1].title}, and {others} module{'s' * (others > 1)} like them"
                result.statements.append(Loop(rounds, blocks, title, self.lanes, modules=True))
        result.arrays = sorted(sizes.items())
        result.guards = [kept for guard in self.guards for kept in self._kept(guard, result)]
        return result

    def _rounds(self, group: Group) -> int:
        return -(-len(group.members) // self.lanes)

    def _entry(self, array: str, member: int) -> Element:
        """Where the value of a member of a group lies."""
        if self.lanes == 1:
            return Element(array, member)
        return Element(array, member // self.lanes, 0, member % self.lanes)

    def _read_late(self, phase: Mapping[str, int]) -> set[str]:
        """First members' names of what is read outside of the loop that computes it."""
        found = set()

        def note(name: str) -> None:
            number, position, _ = self.home[name]
            found.add(self._array(number, position))

        for line in self.lines:
            for name in map(_named, leaves(line.line.value)):
                if name in self.home:
                    same = line.name in self.home and self.home[line.name][0] == self.home[name][0]
                    if not same or phase[line.name] != phase[name]:
                        note(name)
        for name in self.results & set(self.home):
            note(name)
        return found

    def _blocks(self, lines: Iterable[tuple[int, Assign]]) -> list[Lines]:
        """Lines under the titles of their blocks."""
        found: list[Lines] = []
        last = -1
        for block, line in lines:
            if block == last:
                found[-1] = replace(found[-1], lines=(*found[-1].lines, line))
            else:
                found.append(replace(self.blocks[block], lines=(line,)))
            last = block
        return found

    def _placed(self, line: Assign, result: Abreast) -> Assign:
        """A shared line. Where it adds one quantity of all modules of a group, whole vectors are added first."""
        value = line.value
        if self.lanes == 1 or not isinstance(value, Sum):
            return Assign(line.target, result.placed(value))
        columns: dict[tuple[int, int], list[int]] = defaultdict(list)
        rest: list[Term] = []
        for term in value.terms:
            if isinstance(term, Name) and term.name in self.home:
                number, position, member = self.home[term.name]
                columns[number, position].append(member)
            else:
                rest.append(result.placed(term))
        for (number, position), members in columns.items():
            group = self.groups[number]
            array, whole = group.columns[position][0].name, 0
            if len(members) == len(group.members) and (whole := len(members) // self.lanes):
                vectors = tuple(Element(array, index) for index in range(whole))
                rest.append(Call("total", vectors[0] if whole == 1 else Sum(vectors)))
            rest += [self._entry(array, member) for member in members if member >= whole * self.lanes]
        return Assign(line.target, rest[0] if len(rest) == 1 else Sum(tuple(rest)))

    def _kept(self, guard: Guard, result: Abreast) -> list[Guard]:
        """What is to be checked of a guard; for one of a group, the vectors that its first member is in."""
        if not isinstance(guard.pivot, Name) or guard.pivot.name not in self.kept & self.home.keys():
            return [Guard(result.placed(guard.pivot), guard.least and result.placed(guard.least))]
        number, position, member = self.home[guard.pivot.name]
        if self.lanes == 1:
            return [Guard(self._entry(self._array(number, position), member), ZERO)]
        rounds = range(self._rounds(self.groups[number])) if member == 0 else ()
        return [Guard(Element(self._array(number, position), index), None) for index in rounds]

    def _array(self, number: int, position: int) -> str:
        """The array that holds a column of a group: it is called as the first member's quantity."""
        return self.groups[number].columns[position][0].name

    def _moving(
        self,
        column: tuple[_Line, ...],
        number: int,
        result: Abreast,
        gathers: list[Assign],
        sizes: dict[str, int],
    ) -> Assign:
        """One statement for all members of a group."""
        reads = [list(map(_named, leaves(line.line.value))) for line in column]
        each = iter(zip(*reads, strict=True))
        value = exchanged(column[0].line.value, lambda _: self._operand(next(each), number, result, gathers, sizes))
        name = column[0].name
        return Assign(Element(name, 0, 1) if name in result.places else Name(name), value)

    def _operand(
        self,
        names: tuple[str, ...],
        number: int,
        result: Abreast,
        gathers: list[Assign],
        sizes: dict[str, int],
    ) -> Term:
        """What a loop reads in the place of one name of each module."""
        first = names[0]
        if first in self.home and self.home[first][0] == number:
            return Element(first, 0, 1) if first in result.places else Name(first)
        if len(set(names)) == 1:
            return result.placed(Name(first))
        arrays = {self.given.get(name, ("",))[0] for name in names}
        if arrays == {"k"}:
            return Element("k_abreast", self.packed.place(names) // self.lanes, 1)
        if self.lanes == 1 and (moving := self._strided(names)):
            return moving
        if self.lanes > 1 and arrays in ({"c"}, {"s"}):
            angles = tuple(self.given[name][1] for name in names)
            return Element(f"{arrays.pop()}_abreast", result.angles.place(angles) // self.lanes, 1)
        if names not in self.shared:
            array, again = f"{first}_abreast", 1
            while array in sizes:  # other modules read it beside other names
                again += 1
                array = f"{first}_abreast_{again}"
            self.shared[names] = array
            sizes[array] = self._rounds(self.groups[number])
            filled = padded(names, self.lanes)
            for start in range(0, len(filled), self.lanes):
                lanes = tuple(result.placed(Name(name)) for name in filled[start : start + self.lanes])
                value = lanes[0] if self.lanes == 1 else Gathered(lanes)
                gathers.append(Assign(Element(array, start // self.lanes), value))
        return Element(self.shared[names], 0, 1)

    def _strided(self, names: tuple[str, ...]) -> Element | None:
        """An element that moves with the loop, where the names lie at even distances in one array."""
        places = [self.given.get(name) for name in names]
        if None in places or len({place[0] for place in places if place}) > 1:
            return None
        index = [place[1] for place in places if place]
        stride = index[1] - index[0]
        if any(b - a != stride for a, b in pairwise(index)):
            return None
        return Element(places[0][0] if places[0] else "", index[0], stride)


def _named(leaf: Leaf) -> str:
    return leaf.name if isinstance(leaf, Name) else leaf.array
