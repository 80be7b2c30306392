"""Rows of links inside of modules that go side by side become loops, as in one long chain (:mod:`.rolling`).

A vector holds the same link of each module; the loop goes from link to link.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import replace

from .abreast import Abreast
from .rolling import Lines, Loop, Place, Rolled, exchanged_line, roll
from .terms import ZERO, Assign, Element, Leaf, Name, Term, exchanged, leaves

PACKED = ("k_abreast", "c_abreast", "s_abreast")
"""Arrays of vectors that are there before the statements."""

END = "end of a phase"
"""Title of what stands between phases, and is not printed."""


def rolled_modules(side: Abreast, results: Collection[Term], reserved: Collection[str]) -> Abreast:
    """The statements with loops over the links of modules where these repeat.

    Only where one vector holds all modules of each group: else there is a loop over vectors already. ``results`` are
    read behind the last statement; ``reserved`` are names that no array may take.
    """
    loops = [part for part in side.statements if isinstance(part, Loop)]
    if side.lanes == 1 or any(loop.rounds > 1 for loop in loops):
        return side
    vectors = {array for array, _ in side.arrays}
    given: dict[str, Place] = {}

    def named(leaf: Leaf) -> Leaf:
        """A vector by a name of its own, as :func:`roll` reads it."""
        if isinstance(leaf, Name) or leaf.lane is not None:
            return leaf
        if leaf.array in vectors:
            return Name(leaf.array)
        if leaf.array in PACKED:
            name = f"{leaf.array}_{leaf.start}"
            given[name] = (leaf.array, leaf.start)
            return Name(name)
        return leaf

    blocks: list[Lines] = []
    for phase, loop in enumerate(loops):
        for block in loop.body:
            blocks.append(_with(block, named))
        blocks.append(Lines(END, (Assign(Name(END + "x" * phase), ZERO),)))  # no two alike: no loop goes across them
    outside = [line.value for part in side.statements if isinstance(part, Lines) for line in part.lines]
    outside += [*results, *(entry for guard in side.guards for entry in (guard.pivot, guard.least) if entry)]
    read = {leaf.array for term in outside for leaf in leaves(term) if isinstance(leaf, Element)}
    rolled = roll(blocks, given, read & vectors, {*reserved, *PACKED, *vectors, *_shared(side)})
    if not any(isinstance(part, Loop) for part in rolled.statements):
        return side
    return _joined(side, rolled, vectors, given)


def _with(block: Lines, new: Callable[[Leaf], Leaf]) -> Lines:
    """The block with other leaves."""
    return replace(block, lines=tuple(exchanged_line(line, new) for line in block.lines))


def _shared(side: Abreast) -> set[str]:
    """Names of what belongs to no module."""
    lines = (line for part in side.statements if isinstance(part, Lines) for line in part.lines)
    return {line.target.name for line in lines if isinstance(line.target, Name)}


def _joined(side: Abreast, rolled: Rolled, vectors: set[str], given: Mapping[str, Place]) -> Abreast:
    """The statements outside of modules as they were, the modules' in loops, all with the places of both."""

    def moved(element: Element) -> Element:
        if element.array in rolled.places:
            return Element(*rolled.places[element.array], 0, element.lane)
        return element

    def placed(leaf: Leaf) -> Leaf:
        return moved(leaf) if isinstance(leaf, Element) else leaf

    def back(leaf: Leaf) -> Leaf:
        if isinstance(leaf, Name) and leaf.name in given:
            return Element(*given[leaf.name])
        if isinstance(leaf, Name) and leaf.name in vectors:
            return Element(leaf.name, 0)
        return leaf

    phases: list[list[Lines | Loop]] = [[]]
    for part in rolled.statements:
        if isinstance(part, Lines) and part.title == END:
            phases.append([])
        elif isinstance(part, Lines):
            phases[-1].append(replace(_with(part, back), lanes=side.lanes))
        else:
            phases[-1].append(replace(part, body=tuple(_with(block, back) for block in part.body), lanes=side.lanes))
    result = replace(side, statements=[])
    result.angles = side.angles
    each = iter(phases)
    for part in side.statements:
        if isinstance(part, Loop):
            result.statements += next(each)
        else:
            result.statements.append(_with(part, placed))
    result.places = {name: moved(element) for name, element in side.places.items()}
    result.guards = [
        replace(g, pivot=exchanged(g.pivot, placed), least=g.least and exchanged(g.least, placed)) for g in side.guards
    ]
    kept = [(array, size) for array, size in side.arrays if array not in rolled.places]
    result.arrays = sorted([*kept, *rolled.arrays])
    return result
