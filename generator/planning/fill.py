"""Elimination on a graph: nodes that share entries of a form are neighbours, and what goes joins those around it."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from typing import Any, Protocol, TypeVar


class Node(Protocol):
    """What can stand in a set, and has an order that breaks ties."""

    def __hash__(self) -> int: ...
    def __lt__(self, other: Any, /) -> bool: ...


N = TypeVar("N", bound=Node)


def take_out(near: dict[N, set[N]], block: Collection[N]) -> set[N]:
    """Eliminate a block of nodes: those around it become neighbours of one another, and are returned."""
    gone = set(block)
    around = set[N]().union(*(near.pop(node, set()) for node in block)) - gone
    for node in around:
        near[node] = (near[node] | around) - gone
    return around


def by_least_fill(near: dict[N, set[N]], nodes: Collection[N]) -> Iterator[tuple[N, set[N]]]:
    """Eliminate ``nodes`` in an order of minimum degree, the lower first among equals; each, and what is around it."""
    waiting = sorted(nodes)
    while waiting:
        node = min(waiting, key=lambda one: len(near[one]))
        waiting.remove(node)
        yield node, take_out(near, (node,))
