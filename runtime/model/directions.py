"""Directions in the arguments of a model's functions, in blocks of lanes, as its derivatives take them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache, cached_property

import numpy as np
from numpy.typing import ArrayLike, DTypeLike

from ..arrays import FloatArray, IntArray
from ..faults import Faults
from .compiled import Compiled
from .numbers import read_names, read_numbers

Wrt = str | Sequence[str] | Mapping[str, ArrayLike]
"""What derivatives are by: names, each with all its entries one by one, or directions in them by name."""

STATE = ("q", "u")
"""What runs are derived by where no argument moves."""

GROUPS = ("q", "u", "k", "t")
"""Arguments with blocks of their own; with t come the inputs."""


@dataclass
class Directions:
    """Blocks of directions: per argument the first block and an array (count, size, lanes), and where each column lies
    among the lanes of all ``blocks``."""

    lanes: int
    blocks: int = 0
    by: dict[str, tuple[int, FloatArray]] = field(default_factory=dict)
    columns: list[int] = field(default_factory=list)

    @cached_property
    def zeros(self) -> dict[str, FloatArray]:
        """Per argument an array (blocks, size, lanes) of directions that do not move it."""
        return {name: np.zeros((self.blocks, *part.shape[1:]), dtype=part.dtype) for name, (_, part) in self.by.items()}

    def whole(self) -> dict[str, FloatArray]:
        """Per argument an array (blocks, size, lanes), zero where nothing moves it."""
        return dict(self._whole)

    @cached_property
    def still(self) -> dict[str, FloatArray]:
        """The same where u is held."""
        return {name: self.zeros[name] if name == "u" else part for name, part in self._whole.items()}

    @cached_property
    def _whole(self) -> dict[str, FloatArray]:
        found = {}
        for name, (first, part) in self.by.items():
            found[name] = self.zeros[name].copy()
            found[name][first : first + len(part)] = part
        return found

    def result(self, tangents: FloatArray) -> FloatArray:
        """(…, outputs, columns) of tangents (…, blocks, outputs, lanes)."""
        side_by_side = np.moveaxis(tangents, -2, -3)
        flat = side_by_side.reshape(*side_by_side.shape[:-2], -1)
        return np.take(flat, self.chosen, axis=-1)

    @cached_property
    def chosen(self) -> IntArray:
        """The columns among the lanes of all blocks."""
        return np.array(self.columns, dtype=np.intp)


def directions_of(model: Compiled, wrt: Wrt) -> Directions:
    """The directions that ``wrt`` asks for, in its order.

    Raises ``KeyError`` for names that the model has not, and ``ValueError`` for wrong shapes, for parameters of a
    folded model, and for those that joints which the equations leave out rest on.
    """
    if isinstance(wrt, Mapping):
        return _mixed(model, wrt)
    names = (wrt,) if isinstance(wrt, str) else tuple(read_names(wrt, "wrt", "what is derived by"))
    if names == STATE:
        return _of_state(model.kernels.directions, len(model.q_names), model.core.REAL)
    places, faults = list[tuple[str, int]](), Faults()
    for name in names:
        with faults.collecting():
            places += _places(model, name)
    faults.stop_if_any()
    found = Directions(model.kernels.directions)
    where: dict[tuple[str, int], int] = {}
    for group, members in (("q", ("q",)), ("u", ("u",)), ("k", ("p",)), ("t", ("t", "inputs"))):
        own = list(dict.fromkeys(place for place in places if place[0] in members))
        if own:
            matrices = {name: np.zeros((_size(model, name), len(own)), dtype=model.core.REAL) for name in members}
            for column, (name, index) in enumerate(own):
                matrices[name][index, column] = 1.0
                where[name, index] = found.blocks * found.lanes + column
            _append(model, found, {group: matrices}, len(own))
    found.columns = [where[place] for place in places]
    return found


@cache
def _of_state(lanes: int, n: int, kind: DTypeLike) -> Directions:
    """Those in q and u, the same for all models with as many coordinates."""
    blocks, units = -(-n // lanes), _packed(np.eye(n, dtype=kind), lanes)
    units.flags.writeable, first = False, blocks * lanes
    return Directions(lanes, 2 * blocks, {"q": (0, units), "u": (blocks, units)}, [*range(n), *range(first, first + n)])


def _mixed(model: Compiled, given: Mapping[str, ArrayLike]) -> Directions:
    """Directions that move several arguments at a time: of each name an array (size, columns), or (columns,)."""
    matrices: dict[str, FloatArray] = {}
    counts, faults = dict[str, int](), Faults()
    for name, value in given.items():
        with faults.collecting():
            places = _places(model, name)
            rows = np.atleast_2d(read_numbers(value, name, model.core.REAL))
            if rows.ndim != 2 or len(rows) != len(places):
                raise ValueError(f"{name}: found shape {np.shape(rows)}, expected ({len(places)}, directions)")
            counts[name] = rows.shape[1]
            for (kind, index), row in zip(places, rows, strict=True):
                whole = matrices.setdefault(kind, np.zeros((_size(model, kind), rows.shape[1]), dtype=model.core.REAL))
                if whole.shape[1] == len(row):
                    whole[index] += row
    if len(set(counts.values())) > 1:
        faults.add(f"wrt: found {counts} directions, expected as many of each")
    faults.stop_if_any()
    found = Directions(model.kernels.directions)
    count = max(counts.values(), default=0)
    found.columns = list(range(count))
    groups: dict[str, Mapping[str, FloatArray]] = {
        group: {group: matrices[group]} for group in ("q", "u") if group in matrices
    }
    if "p" in matrices:
        groups["k"] = {"p": matrices["p"]}
    if "t" in matrices or "inputs" in matrices:
        none = {name: np.zeros((_size(model, name), count), dtype=model.core.REAL) for name in ("t", "inputs")}
        groups["t"] = {name: matrices.get(name, none[name]) for name in none}
    if count:
        _append(model, found, groups, count)
    return found


def _append(model: Compiled, found: Directions, groups: Mapping[str, Mapping[str, FloatArray]], count: int) -> None:
    """Blocks for ``count`` directions, behind those that are there."""
    lanes, first = found.lanes, found.blocks
    found.blocks += -(-count // lanes)
    for matrices in groups.values():
        for name, matrix in matrices.items():
            packed = _packed(matrix, lanes)
            if name == "p":
                found.by["k"] = first, model.kernels.constant_tangents(packed)
            else:
                found.by[name] = first, packed


def _packed(matrix: FloatArray, lanes: int) -> FloatArray:
    """(blocks, size, lanes) of columns (size, columns), filled up with zeros."""
    size, count = matrix.shape
    blocks = -(-count // lanes)
    filled = np.zeros((size, blocks * lanes), dtype=matrix.dtype)
    filled[:, :count] = matrix
    return np.ascontiguousarray(filled.reshape(size, blocks, lanes).transpose(1, 0, 2))


def _size(model: Compiled, name: str) -> int:
    """Entries of an argument; inputs have behind them what tells sides, which does not move."""
    sizes = model.kernels.sizes
    return {"q": sizes["n"], "u": sizes["n"], "p": sizes["parameters"], "t": 1, "inputs": sizes["inputs"]}[name]


def _places(model: Compiled, name: str) -> list[tuple[str, int]]:
    """What a name stands for: arguments and indices into them."""
    whole = {"q": len(model.q_names), "u": len(model.u_names), "t": 1, "inputs": len(model.inputs)}
    if name in whole:
        return [(name, index) for index in range(whole[name])]
    if name in model.inputs:
        return [("inputs", model.inputs.index(name))]
    if not isinstance(name, str):
        raise ValueError(f"wrt: found {name!r}, expected a name")
    model.parameters[name]  # raises for one that is none
    if name in model.all_gates:
        what = "switches an effect" if name in model.gates.values() else "says whether a joint holds"
        raise ValueError(f"{name}: found what {what}, expected a number that can change by a little")
    if model.folded:
        raise ValueError(f"{name}: found a parameter of {model.name}, whose parameters are folded into its code")
    if name in model.data["rests_on"]:
        raise ValueError(
            f"{name}: found no derivative by it, because {model.data['rests_on'][name]} holds only with its value what "
            "other joints hold; leave it out, or remove the joint"
        )
    return [("p", list(model.parameters).index(name))]
