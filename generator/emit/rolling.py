"""Recognises blocks that repeat from link to link and turns them into loops.

Long chains give the same block again and again with shifted numbers in the names. Written out they outgrow the
processor's instruction cache and the compiler's patience; as loops over arrays they do neither. Only names are looked
at: blocks whose texts are equal but for numbers, and whose numbers grow by fixed strides from round to round, become
one loop. The arithmetic and its order stay the same.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise

Line = tuple[str, str]
"""A name and the expression assigned to it."""

Place = tuple[str, int]
"""An array and an index into it."""

LEAST_ROUNDS = 6
"""Fewer rounds than this stay written out: short chains run fastest without loops."""

LONGEST_PERIOD = 4
"""Blocks looked at as one round: branches that run side by side."""

NAME = re.compile(r"(?<![\w.])[A-Za-z]\w*")
OFFSETS = {0: "own", 1: "next", -1: "last"}


@dataclass(frozen=True)
class Lines:
    """A block of assignments under a title."""

    title: str
    lines: tuple[Line, ...]
    rounds: int = 0


@dataclass(frozen=True)
class Loop:
    """``rounds`` repetitions of ``body``, whose texts hold the loop counter ``i``."""

    rounds: int
    body: tuple[Lines, ...]
    title: str


@dataclass
class Rolled:
    """What to write: blocks and loops in order, the arrays (name, size) they use, and the names that lie in arrays."""

    statements: list[Lines | Loop] = field(default_factory=list)
    arrays: list[tuple[str, int]] = field(default_factory=list)
    places: dict[str, Place] = field(default_factory=dict)
    scalars: set[str] = field(default_factory=set)

    def spell(self, text: str) -> str:
        """``text`` with every name that lies in an array written as its element."""
        return NAME.sub(lambda m: "{}[{}]".format(*self.places[m[0]]) if m[0] in self.places else m[0], text)

    def read(self, given: Mapping[str, Place]) -> set[str]:
        """Arrays of ``given`` that loops read by index."""
        arrays = {array for array, _ in given.values()}
        loops = [s for s in self.statements if isinstance(s, Loop)]
        texts = (text for loop in loops for lines in loop.body for _, text in lines.lines)
        return arrays & {name for text in texts for name in NAME.findall(text)}


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


class _Roller:
    def __init__(
        self, blocks: Sequence[Lines], given: Mapping[str, Place], results: set[str], reserved: set[str]
    ) -> None:
        self.blocks, self.given, self.results, self.reserved = blocks, given, results, reserved
        self.home = {name: i for i, block in enumerate(blocks) for name, _ in block.lines}
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
        """Whether each name is defined in the very block that holds it and is read nowhere else."""
        blocks = [run.start + r * run.period + p for r in range(run.rounds)]
        return all(self.home.get(n) == b and n not in self._abroad for n, b in zip(names, blocks, strict=True))

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

    def _moves(self, run: _Run, p: int, names: tuple[str, ...]) -> str | None:
        """How a name is written in the body, or ``None`` if it cannot be."""
        if self._local(run, p, names) and names[0] not in self.places:
            return self._local_name(names)
        if len(set(names)) == 1:
            return self._spelled(names[0])
        places = [self.given.get(name) or self.places.get(name) for name in names]
        if None in places or len({place[0] for place in places if place}) != 1:
            return None
        index = [place[1] for place in places if place]
        stride = index[1] - index[0]
        if any(b - a != stride for a, b in pairwise(index)):
            return None
        array = places[0][0] if places[0] else ""
        return f"{array}[{_affine(index[0], stride)}]"

    def _local_name(self, names: tuple[str, ...]) -> str:
        """A name for what lives inside one block of one round; numbers that stand still stay in it."""
        places = _places(names)
        label = places[0][0] if places else names[0]
        taken = {array for array, _ in self.places.values()} | self.reserved
        return f"{label}_here" if label in taken else label

    def _spelled(self, name: str) -> str:
        """A name outside of loops: an element of an array, or itself."""
        return "{}[{}]".format(*self.places[name]) if name in self.places else name

    # -- writing ---------------------------------------------------------------------------------------------------

    def _straight(self, block: Lines, scalars: set[str]) -> Lines:
        scalars.update(n for line in block.lines for n in _names(line) if n not in self.places)
        return Lines(block.title, tuple((self._spelled(n), NAME.sub(self._respell, text)) for n, text in block.lines))

    def _respell(self, match: re.Match[str]) -> str:
        return self._spelled(match[0])

    def _loop(self, run: _Run, scalars: set[str]) -> Loop:
        first = self.blocks[run.start : run.start + run.period]
        last = self.blocks[run.stop - run.period : run.stop]
        texts = iter([self._moves(run, p, names) or "" for p, names in self._sequences(run)])
        for _, names in self._sequences(run):
            if len(set(names)) == 1 and names[0] not in self.places:
                scalars.add(names[0])
        body = []
        for block in first:
            lines = [(next(texts), NAME.sub(lambda match: next(texts), text)) for _, text in block.lines]
            body.append(Lines(block.title, tuple(lines)))
        title = "; ".join(f"{a.title} to {b.title}" for a, b in zip(first, last, strict=True))
        return Loop(run.rounds, tuple(body), title)


def _names(line: Line) -> list[str]:
    """The assigned name, then the names of the expression in the order they are written."""
    return [line[0], *NAME.findall(line[1])]


def _numbers(name: str) -> list[int]:
    return [int(token) for token in name.split("_") if token.isdigit()]


def _shape(block: Lines) -> tuple[str, ...]:
    """The block's text with a mark in place of every number in a name."""
    blur = lambda match: "_".join("#" if t.isdigit() else t for t in match[0].split("_"))  # noqa: E731
    return tuple(NAME.sub(blur, f"{name} = {text}") for name, text in block.lines)


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


def _affine(start: int, stride: int) -> str:
    moving = "i" if abs(stride) == 1 else f"{abs(stride)}*i"
    if stride < 0:
        return f"{start} - {moving}"
    return f"{moving} + {start}" if start else moving
