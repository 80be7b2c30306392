"""Recognises blocks that repeat from link to link and turns them into loops.

Long chains give the same block again and again with shifted numbers in the names. Written out they outgrow the
processor's instruction cache and the compiler's patience; as loops over arrays they do neither. Blocks whose terms are
equal but for numbers in names, and whose numbers grow by fixed strides from round to round, become one loop. The
arithmetic and its order stay the same. In long functions (:func:`roll_finely`) the same is sought within blocks, link
by link, and among outputs.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import groupby, pairwise

from .terms import Assign, Element, Leaf, Name, Term, exchanged, leaves

Place = tuple[str, int]
"""An array and an index into it."""

LEAST_ROUNDS = 6
"""Fewer rounds than this stay written out: short chains run fastest without loops."""

LONGEST_PERIOD = 4
"""Blocks looked at as one round: branches that run side by side."""

END = "outputs"
"""Title of outputs, each a block of its own."""

OFFSETS = {0: "own", 1: "next", -1: "last"}


@dataclass(frozen=True)
class Lines:
    """A block of assignments under a title.

    ``late`` ones come behind all others: they belong to every column that a kernel is given, or to what it is asked
    for. ``shared`` ones belong to no module, whatever they read. Those on vectors of more than one of ``lanes`` are of
    modules side by side.
    """

    title: str
    lines: tuple[Assign, ...]
    late: bool = False
    shared: bool = False
    lanes: int = 1


@dataclass(frozen=True)
class Loop:
    """``rounds`` repetitions of ``body``, whose elements move with the loop's counter, on vectors of ``lanes``.

    Names that a block declares are its own; in a loop over ``modules`` they are known to later blocks of the round.
    """

    rounds: int
    body: tuple[Lines, ...]
    title: str
    lanes: int = 1
    modules: bool = False

    @property
    def late(self) -> bool:
        """Whether the loop comes behind all others."""
        return self.body[0].late


@dataclass
class Rolled:
    """What to write: blocks and loops in order, the arrays (name, size) they use, and the names that lie in arrays."""

    statements: list[Lines | Loop] = field(default_factory=list)
    arrays: list[tuple[str, int]] = field(default_factory=list)
    places: dict[str, Place] = field(default_factory=dict)
    scalars: set[str] = field(default_factory=set)

    def placed(self, term: Term) -> Term:
        """The term with every name that lies in an array as its element."""
        return exchanged(term, lambda leaf: _placed(leaf, self.places))

    def read(self) -> set[str]:
        """Arrays that loops read by index."""
        loops = [s for s in self.statements if isinstance(s, Loop)]
        terms = [line.value for loop in loops for lines in loop.body for line in lines.lines]
        return {leaf.array for term in terms for leaf in leaves(term) if isinstance(leaf, Element)}


@dataclass(frozen=True)
class _Run:
    """Blocks ``start`` … of a period and a number of rounds that may become a loop."""

    start: int
    period: int
    rounds: int

    @property
    def stop(self) -> int:
        return self.start + self.period * self.rounds


def roll(
    blocks: Sequence[Lines], given: Mapping[str, Place], results: Iterable[str], reserved: Iterable[str]
) -> Rolled:
    """Turn repeating ``blocks`` into loops.

    ``given`` says where inputs and constants lie; ``results`` are names that are read after the last block;
    ``reserved`` are names that no array may take.
    """
    return _Roller(blocks, given, set(results), set(reserved)).rolled()


def roll_finely(
    blocks: Sequence[Lines],
    outputs: Sequence[Assign],
    given: Mapping[str, Place],
    results: Collection[str],
    reserved: Collection[str],
) -> tuple[Rolled, list[Assign]]:
    """Turn what repeats within ``blocks``, link by link, and among ``outputs`` into loops; the outputs left over.

    Outputs are elements of arrays; loops over them come behind all other statements.
    """
    entries = {f"{END} {o.target.array}_{o.target.start}": o for o in outputs if isinstance(o.target, Element)}
    places = {name: (o.target.array, o.target.start) for name, o in entries.items() if isinstance(o.target, Element)}
    ends = [Lines(END, (Assign(Name(name), o.value),)) for name, o in entries.items()]
    fine = [replace(block, lines=lines) for block in blocks for lines in _link_by_link(block.lines)]
    rolled = roll([*fine, *ends], {**given, **places}, results, reserved)
    left, statements = list[Assign](), list[Lines | Loop]()
    for part in rolled.statements:
        last = statements[-1] if statements else None
        if isinstance(part, Loop):
            statements.append(part)
        elif part.title == END:
            left += [entries[_target(line)] for line in part.lines]
        elif isinstance(last, Lines) and last.title == part.title:
            statements[-1] = replace(last, lines=last.lines + part.lines)
        else:
            statements.append(part)
    rolled.statements = statements
    return rolled, left


def _link_by_link(lines: Sequence[Assign]) -> list[tuple[Assign, ...]]:
    """Runs of lines whose targets have the same first number."""
    return [tuple(run) for _, run in groupby(lines, key=lambda line: _numbers(_target(line))[:1])]


class _Roller:
    def __init__(
        self, blocks: Sequence[Lines], given: Mapping[str, Place], results: set[str], reserved: set[str]
    ) -> None:
        self.blocks, self.given, self.results, self.reserved = blocks, given, results, reserved
        self.home = {_target(line): i for i, block in enumerate(blocks) for line in block.lines}
        self.names = [[_names(line) for line in block.lines] for block in blocks]
        self.places: dict[str, Place] = {}

    def rolled(self) -> Rolled:
        runs = [run for run in self._runs() if self._claim(run)]
        runs = [run for run in runs if self._regular(run)]
        starts = {run.start: run for run in runs}
        result, i = Rolled(places=self.places), 0
        while i < len(self.blocks):
            run = starts.get(i)
            if run:
                result.statements.append(self._loop(run, result.scalars))
                i = run.stop
            else:
                result.statements.append(self._straight(self.blocks[i], result.scalars))
                i += 1
        sizes: dict[str, int] = {}
        for array, index in self.places.values():
            sizes[array] = max(sizes.get(array, 0), index + 1)
        result.arrays = sorted(sizes.items())
        return result

    # -- finding ---------------------------------------------------------------------------------------------------

    def _runs(self) -> list[_Run]:
        """Repetitions of equal shape and steady strides, the longest first found from the front."""
        shapes = [_shape(block) for block in self.blocks]
        numbers = [tuple(n for names in lines for name in names for n in _numbers(name)) for lines in self.names]
        found, i = [], 0
        while i < len(self.blocks):
            best = max(
                (_Run(i, period, self._rounds(i, period, shapes, numbers)) for period in range(1, LONGEST_PERIOD + 1)),
                key=lambda run: (run.rounds >= LEAST_ROUNDS, run.period * run.rounds, -run.period),
            )
            if best.rounds >= LEAST_ROUNDS:
                found.append(best)
                i = best.stop
            else:
                i += 1
        return found

    @staticmethod
    def _rounds(start: int, period: int, shapes: Sequence[object], numbers: Sequence[tuple[int, ...]]) -> int:
        """How often the ``period`` blocks from ``start`` repeat."""
        rounds = 1
        strides: list[tuple[int, ...]] | None = None
        while start + (rounds + 1) * period <= len(shapes):
            now = range(start + rounds * period, start + (rounds + 1) * period)
            if any(shapes[b] != shapes[b - period] for b in now):
                break
            step = [tuple(x - y for x, y in zip(numbers[b], numbers[b - period], strict=True)) for b in now]
            if strides is not None and step != strides:
                break
            strides = step
            rounds += 1
        return rounds

    # -- placing ---------------------------------------------------------------------------------------------------

    def _sequences(self, run: _Run) -> Iterable[tuple[int, tuple[str, ...]]]:
        """Every occurrence of a name in the body, as (block of the period, names round by round)."""
        for p in range(run.period):
            rounds = [self.names[run.start + r * run.period + p] for r in range(run.rounds)]
            for line in range(len(rounds[0])):
                for o in range(len(rounds[0][line])):
                    yield p, tuple(names[line][o] for names in rounds)

    def _local(self, run: _Run, p: int, names: tuple[str, ...]) -> bool:
        """Whether each name is defined in the very block that holds it, and neither read nor given anywhere else."""
        blocks = [run.start + r * run.period + p for r in range(run.rounds)]
        elsewhere = self._abroad | self.given.keys()
        return all(self.home.get(n) == b and n not in elsewhere for n, b in zip(names, blocks, strict=True))

    @cached_property
    def _abroad(self) -> set[str]:
        """Names read outside their own block."""
        found = set(self.results)
        for i, lines in enumerate(self.names):
            found |= {name for names in lines for name in names[1:] if self.home.get(name, i) != i}
        return found

    def _claim(self, run: _Run) -> bool:
        """Give every name that must lie in an array its place; false if that cannot be done."""
        wanted: dict[str, Place] = {}
        owners = {place: name for name, place in self.places.items()}
        for p, names in self._sequences(run):
            if len(set(names)) == 1 or names[0] in self.given or self._local(run, p, names):
                continue
            places = _places(names)
            if places is None:
                return False
            for name, place in zip(names, places, strict=True):
                if name in self.given or self.places.get(name, place) != place or wanted.get(name, place) != place:
                    return False
                if owners.setdefault(place, name) != name:
                    return False
                wanted[name] = place
        if any(array in self.reserved for array, _ in wanted.values()):
            return False
        self.places.update(wanted)
        return True

    def _regular(self, run: _Run) -> bool:
        """Whether every name of the body is local, the same in all rounds, or moves evenly through one array."""
        return all(self._moves(run, p, names) is not None for p, names in self._sequences(run))

    def _moves(self, run: _Run, p: int, names: tuple[str, ...]) -> Leaf | None:
        """What stands for a name in the body, or ``None`` if nothing can."""
        if self._local(run, p, names) and names[0] not in self.places:
            return Name(self._local_name(names))
        if len(set(names)) == 1:
            return _placed(Name(names[0]), self.places)
        places = [self.given.get(name) or self.places.get(name) for name in names]
        if None in places or len({place[0] for place in places if place}) != 1:
            return None
        index = [place[1] for place in places if place]
        stride = index[1] - index[0]
        if any(b - a != stride for a, b in pairwise(index)):
            return None
        array = places[0][0] if places[0] else ""
        return Element(array, index[0], stride)

    def _local_name(self, names: tuple[str, ...]) -> str:
        """A name for what lives inside one block of one round; numbers that stand still stay in it."""
        places = _places(names)
        label = places[0][0] if places else names[0]
        taken = {array for array, _ in self.places.values()} | self.reserved
        return f"{label}_here" if label in taken else label

    # -- writing ---------------------------------------------------------------------------------------------------

    def _straight(self, block: Lines, scalars: set[str]) -> Lines:
        scalars.update(n for line in block.lines for n in _names(line) if n not in self.places)
        lines = (exchanged_line(line, lambda leaf: _placed(leaf, self.places)) for line in block.lines)
        return replace(block, lines=tuple(lines))

    def _loop(self, run: _Run, scalars: set[str]) -> Loop:
        first = self.blocks[run.start : run.start + run.period]
        last = self.blocks[run.stop - run.period : run.stop]
        moving = iter([self._moves(run, p, names) for p, names in self._sequences(run)])
        for _, names in self._sequences(run):
            if len(set(names)) == 1 and names[0] not in self.places:
                scalars.add(names[0])
        body = [
            replace(block, lines=tuple(exchanged_line(line, lambda leaf: next(moving) or leaf) for line in block.lines))
            for block in first
        ]
        title = "; ".join(f"{a.title} to {b.title}" for a, b in zip(first, last, strict=True))
        return Loop(run.rounds, tuple(body), title)


def exchanged_line(line: Assign, new: Callable[[Leaf], Leaf]) -> Assign:
    """The line with other leaves: its target first, then what it reads."""
    return Assign(new(line.target), exchanged(line.value, new))


def _placed(leaf: Leaf, places: Mapping[str, Place]) -> Leaf:
    """An element where a name lies in an array, or the leaf itself."""
    return Element(*places[leaf.name]) if isinstance(leaf, Name) and leaf.name in places else leaf


def _target(line: Assign) -> str:
    return line.target.name if isinstance(line.target, Name) else line.target.array


def _names(line: Assign) -> list[str]:
    """The assigned name, then the names of the value in the order in which it is written."""
    return [_target(line), *(leaf.name for leaf in leaves(line.value) if isinstance(leaf, Name))]


def _numbers(name: str) -> list[int]:
    return [int(token) for token in name.split("_") if token.isdigit()]


def _shape(block: Lines) -> tuple[object, ...]:
    """The block with a mark in place of every number in a name."""
    return (block.late, *(exchanged_line(line, _blurred) for line in block.lines))


def _blurred(leaf: Leaf) -> Leaf:
    if isinstance(leaf, Element):
        return leaf
    return Name("_".join("#" if token.isdigit() else token for token in leaf.name.split("_")))


def _places(names: Sequence[str]) -> list[Place] | None:
    """Places for names whose numbers move together: an array indexed by the first number that moves.

    Numbers that stand still become part of the array's name, as do the distances of others that move along.
    """
    numbers = [_numbers(name) for name in names]
    strides = [b - a for a, b in zip(numbers[0], numbers[1], strict=True)]
    lead = next(i for i, stride in enumerate(strides) if stride)
    label = []
    for token, stride in zip(numbers[0], strides, strict=True):
        offset = token - numbers[0][lead]
        if stride == 0:
            label.append(str(token))
        elif stride == strides[lead]:
            label.append(OFFSETS.get(offset, f"by{offset}".replace("-", "m")))
        else:
            return None
    label[lead] = ""
    tokens = iter(label)
    parts = [next(tokens) if part.isdigit() else part for part in names[0].split("_")]
    array = "_".join(part for part in parts if part)
    return [(array, row[lead]) for row in numbers]
