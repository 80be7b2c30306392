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
_ENTRY = re.compile(r"([A-Za-z]\w*)\[(\d{1,7})\] = (.*)")
_ASSIGNMENT = re.compile(r"([A-Za-z]\w*) = (.*)")
_SYMBOLS = re.compile(r"([A-Za-z]\w*):((?: [A-Za-z]\w*,?)*)")
HEAD = "# ccgen equations, format 1"
_FUNCTIONS = {
    "sin": np.sin,
    "cos": np.cos,
    "tan": np.tan,
    "atan": np.arctan,
    "exp": np.exp,
    "log": np.log,
    "tanh": np.tanh,
    "sqrt": np.sqrt,
    "abs": np.abs,
    "step": lambda x: np.where(np.greater(x, 0.0), 1.0, 0.0),
}
_ALLOWED = (ast.Expression, ast.BinOp, ast.UnaryOp, ast.Name, ast.Load, ast.USub)
_OPERATORS = (ast.Add, ast.Sub, ast.Mult, ast.Div)
_LARGEST_POWER = 64


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

        Time and inputs are zero unless given. Raises ``KeyError`` for an unknown kernel or another missing argument.
        """
        listed = self.kernels[kernel]
        names: dict[str, object] = {**_FUNCTIONS, **self.parameters, "__builtins__": {}}
        for argument, symbols in listed.inputs.items():
            still = np.zeros(len(symbols)) if argument in ("t", "inputs") else None
            values = arguments[argument] if still is None else arguments.get(argument, still)
            names.update(zip(symbols, np.asarray(values, dtype=float), strict=True))
        needed = self._needed(listed)
        for name, code in self.assignments.items():
            if name in needed:
                names[name] = eval(code, names)  # checked when read: arithmetic on known names only
        entries: dict[str, dict[int, Values]] = {}
        for (output, index), code in listed.outputs.items():
            entries.setdefault(output, {})[index] = eval(code, names)
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


def _stack(values: Mapping[int, Values]) -> Values:
    """One array of all entries; those that the listing leaves out are zero."""
    zero = np.zeros(())
    return np.stack(np.broadcast_arrays(*(values.get(i, zero) for i in range(max(values) + 1)))).astype(float)


def read_listing(text: str, source: str = "listing") -> Listing:
    """Parse a listing; raises :class:`ListingError` naming the line at fault."""
    if not text.startswith(HEAD):
        raise ListingError(f'{source}:1: found {text[:40].splitlines()[:1]}, expected "{HEAD}"')
    reader = _Reader(source)
    for number, line in enumerate(text.splitlines(), start=1):
        reader.take(line.strip(), f"{source}:{number}")
    reader.check()
    return reader.listing


class _Reader:
    """Takes a listing line by line; ``used`` keeps what each line defines and the code that defines it."""

    def __init__(self, source: str) -> None:
        self.source, self.listing, self.section = source, Listing(), ""
        self.kernel: ListedKernel | None = None
        self.used: list[tuple[str, str, CodeType]] = []

    def take(self, line: str, where: str) -> None:
        if not line or line.startswith(("#", "|")):
            return
        if line.startswith("["):
            self.section, match = line, _KERNEL.match(line)
            self.kernel = self.listing.kernels.setdefault(match[1], ListedKernel()) if match else None
        elif match := _ENTRY.fullmatch(line):
            if self.kernel is None:
                raise ListingError(f"{where}: an output stands outside a kernel: {line}")
            code = self.kernel.outputs[match[1], int(match[2])] = _compile(match[3], where)
            self.used.append((where, "", code))
        elif match := _ASSIGNMENT.fullmatch(line):
            self._define(match[1], match[2], where)
        elif match := _SYMBOLS.fullmatch(line):
            owner = self.kernel.inputs if self.kernel is not None else self.listing.state
            owner[match[1]] = [s.strip() for s in match[2].split(",") if s.strip()]
        else:
            raise ListingError(f"{where}: expected a heading, a definition or a list of names: {line}")

    def _define(self, name: str, expression: str, where: str) -> None:
        listing = self.listing
        if name in listing.parameters or name in listing.assignments or name in _FUNCTIONS:
            raise ListingError(f"{where}: {name} is defined twice")
        if self.section == "[parameters]":
            value, _, path = expression.partition("#")
            try:
                listing.parameters[name], listing.paths[name] = float(value), path.strip()
            except ValueError as error:
                raise ListingError(f"{where}: not a number: {value.strip()}") from error
        else:
            code = listing.assignments[name] = _compile(expression, where)
            self.used.append((where, name, code))

    def check(self) -> None:
        """Every name is an argument, or is defined before it is used."""
        listing = self.listing
        known = {*_FUNCTIONS, *listing.parameters}
        for kernel in listing.kernels.values():
            known.update(*kernel.inputs.values())
        for where, name, code in self.used:
            unknown = sorted(set(code.co_names) - known)
            if unknown:
                late = "before it is defined" if unknown[0] in listing.assignments else "which is never defined"
                raise ListingError(f"{where}: uses {unknown[0]} {late}")
            known.add(name)


def _compile(expression: str, where: str) -> CodeType:
    try:
        tree = ast.parse(expression, mode="eval")
        _check_node(tree, where)
        return compile(tree, where, "eval")
    except ListingError:
        raise
    except (SyntaxError, ValueError, OverflowError, RecursionError, MemoryError) as error:
        raise ListingError(f"{where}: not an expression: {expression[:80]}") from error


def _check_node(node: ast.AST, where: str) -> None:
    """Sums, products, quotients, whole powers, and functions of one argument: all that a listing can say."""
    match node:
        case ast.Call(func=ast.Name(id=name), args=[argument], keywords=[]) if name in _FUNCTIONS:
            return _check_node(argument, where)
        case ast.BinOp(left=base, op=ast.Pow(), right=ast.Constant(value=int(power))) if 0 <= power <= _LARGEST_POWER:
            return _check_node(base, where)
        case ast.Constant(value=float() | int() as value) if not isinstance(value, bool):
            node.value = float(value)
            return None
        case ast.Name(id=name) if name in _FUNCTIONS:
            raise ListingError(f"{where}: {name} is a function and needs an argument")
        case ast.operator() if isinstance(node, _OPERATORS):
            return None
    if not isinstance(node, _ALLOWED):
        raise ListingError(f"{where}: {type(node).__name__} is not part of a listing")
    for child in ast.iter_child_nodes(node):
        _check_node(child, where)
    return None
