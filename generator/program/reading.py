"""Reads a listing back and evaluates it, without SymPy and without a compiled model."""

from __future__ import annotations

import ast
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import CodeType

import numpy as np
from numpy.typing import NDArray

Values = NDArray[np.float64]

_KERNEL = re.compile(r"\[kernel (\w+):")
_ENTRY = re.compile(r"(\w+)\[(\d+)\] = (.*)")
_FUNCTIONS = {"sin": np.sin, "cos": np.cos, "sqrt": np.sqrt}
_ALLOWED = (ast.Expression, ast.BinOp, ast.UnaryOp, ast.Name, ast.Constant, ast.Call, ast.Load)
_OPERATORS = (ast.Add, ast.Sub, ast.Mult, ast.Div, ast.Pow, ast.USub)


class ListingError(ValueError):
    """A line of a listing that is not of its form; the message names the line."""


@dataclass
class ListedKernel:
    """A kernel of a listing: argument symbols by argument name, and output entries by output name and index."""

    inputs: dict[str, list[str]] = field(default_factory=dict)
    outputs: dict[tuple[str, int], CodeType] = field(default_factory=dict)


@dataclass
class Listing:
    """What a listing says: state, parameter values, named assignments in order, kernels."""

    state: dict[str, list[str]] = field(default_factory=dict)
    parameters: dict[str, float] = field(default_factory=dict)
    paths: dict[str, str] = field(default_factory=dict)
    assignments: dict[str, CodeType] = field(default_factory=dict)
    kernels: dict[str, ListedKernel] = field(default_factory=dict)

    def evaluate(self, kernel: str, arguments: Mapping[str, Values]) -> dict[str, Values]:
        """Outputs of a kernel. Each argument has shape (entries, ...): trailing axes are a batch of states.

        Raises ``KeyError`` for an unknown kernel or a missing argument.
        """
        listed = self.kernels[kernel]
        names: dict[str, object] = {**_FUNCTIONS, **self.parameters, "__builtins__": {}}
        for argument, symbols in listed.inputs.items():
            names.update(zip(symbols, np.asarray(arguments[argument], dtype=float), strict=True))
        needed = self._needed(listed)
        for name, code in self.assignments.items():
            if name in needed:
                names[name] = eval(code, names)  # noqa: S307 (checked when read: arithmetic on known names only)
        entries: dict[str, dict[int, object]] = {}
        for (output, index), code in listed.outputs.items():
            entries.setdefault(output, {})[index] = eval(code, names)  # noqa: S307
        return {output: _stack(values) for output, values in entries.items()}

    def _needed(self, kernel: ListedKernel) -> set[str]:
        found: set[str] = set()
        waiting = [name for code in kernel.outputs.values() for name in code.co_names]
        while waiting:
            name = waiting.pop()
            if name not in found:
                found.add(name)
                if name in self.assignments:
                    waiting.extend(self.assignments[name].co_names)
        return found


def _stack(values: Mapping[int, object]) -> Values:
    return np.stack(np.broadcast_arrays(*(values.get(i, 0.0) for i in range(max(values) + 1)))).astype(float)


def read_listing(text: str, source: str = "listing") -> Listing:
    """Parse a listing; raises :class:`ListingError` naming the line at fault."""
    listing, section = Listing(), ""
    kernel: ListedKernel | None = None
    if not text.startswith("# ccgen equations, format 1"):
        raise ListingError(f'{source}:1: found {text[:40].splitlines()[:1]}, expected "# ccgen equations, format 1"')
    for number, raw in enumerate(text.splitlines(), start=1):
        line, where = raw.strip(), f"{source}:{number}"
        if not line or line.startswith(("#", "|")):
            continue
        if line.startswith("["):
            section = line
            match = _KERNEL.match(line)
            kernel = listing.kernels.setdefault(match[1], ListedKernel()) if match else None
        elif entry := _ENTRY.fullmatch(line):
            if kernel is None:
                raise ListingError(f"{where}: an output stands outside a kernel: {line}")
            kernel.outputs[entry[1], int(entry[2])] = _compile(entry[3], where)
        elif " = " in line:
            name, _, expression = line.partition(" = ")
            if section == "[parameters]":
                value, _, path = expression.partition("#")
                listing.parameters[name], listing.paths[name] = float(value), path.strip()
            else:
                listing.assignments[name] = _compile(expression, where)
        else:
            name, _, symbols = line.partition(": ")
            owner = kernel.inputs if kernel is not None else listing.state
            owner[name] = [s.strip() for s in symbols.split(",") if s.strip()]
    _check(listing, source)
    return listing


def _check(listing: Listing, source: str) -> None:
    """Every name that an expression uses must be defined somewhere in the listing."""
    known = {*_FUNCTIONS, *listing.parameters, *listing.assignments}
    for kernel in listing.kernels.values():
        known.update(*kernel.inputs.values())
    codes = [*listing.assignments.values(), *(c for kernel in listing.kernels.values() for c in kernel.outputs.values())]
    unknown = sorted({name for code in codes for name in code.co_names} - known)
    if unknown:
        raise ListingError(f"{source}: used but never defined: {', '.join(unknown)}")


def _compile(expression: str, where: str) -> CodeType:
    try:
        tree = ast.parse(expression, mode="eval")
    except SyntaxError as error:
        raise ListingError(f"{where}: not an expression: {expression}") from error
    for node in ast.walk(tree):
        if isinstance(node, ast.operator | ast.unaryop):
            allowed = isinstance(node, _OPERATORS)
        elif isinstance(node, ast.Constant):
            allowed = isinstance(node.value, int | float)
        else:
            allowed = isinstance(node, _ALLOWED)
        if not allowed:
            raise ListingError(f"{where}: {type(node).__name__} is not part of a listing: {expression}")
    return compile(tree, where, "eval")
