"""Compares two listings: as text, and by their numbers at random states."""

from __future__ import annotations

import difflib
from dataclasses import dataclass

import numpy as np

from .reading import Listing, read_listing

STATES = 64
AGREEMENT = 1e-9
"""Relative difference up to which two listings agree; rounding of differently ordered sums stays far below."""


@dataclass(frozen=True)
class DiffReport:
    """``same`` when the texts are equal; ``text`` is the unified diff, ``numbers`` a sentence on the numbers."""

    same: bool
    text: str
    numbers: str


def compare(old: str, new: str, old_name: str = "old", new_name: str = "new") -> DiffReport:
    """Unified diff of two listings and whether they give the same numbers at random states.

    Raises :class:`~.reading.ListingError` when one of them cannot be read.
    """
    a, b = read_listing(old, old_name), read_listing(new, new_name)
    if old == new:
        return DiffReport(True, "", "the listings are the same")
    lines = difflib.unified_diff(old.splitlines(True), new.splitlines(True), old_name, new_name)
    return DiffReport(False, "".join(lines), _numbers(a, b))


def _numbers(a: Listing, b: Listing) -> str:
    """One sentence: what differs numerically, or that nothing does."""
    if a.state != b.state:
        return "the numbers cannot be compared: the listings have different coordinates"
    findings = []
    for name in sorted(a.kernels.keys() | b.kernels.keys()):
        if name not in a.kernels or name not in b.kernels:
            findings.append(f"{name} is in one of them only")
        elif a.kernels[name].inputs != b.kernels[name].inputs:
            findings.append(f"{name} takes other arguments")
        else:
            worst = _worst(a, b, name)
            if not worst <= AGREEMENT:
                findings.append(f"{name} differs by {worst:.2g} (relative)")
    if not findings:
        return f"the numbers agree at {STATES} random states to {AGREEMENT:g} (relative)"
    return f"the numbers differ at {STATES} random states: " + "; ".join(findings)


def _worst(a: Listing, b: Listing, kernel: str) -> float:
    """Largest difference of a kernel's outputs relative to the largest entry of each output."""
    random = np.random.default_rng(1)
    arguments = {
        name: random.uniform(-2.0, 2.0, (len(symbols), STATES)) for name, symbols in a.kernels[kernel].inputs.items()
    }
    first, second = a.evaluate(kernel, arguments), b.evaluate(kernel, arguments)
    if {k: v.shape for k, v in first.items()} != {k: v.shape for k, v in second.items()}:
        return float("inf")
    worst = 0.0
    for name, values in first.items():
        scale = float(np.max(np.abs(values))) or 1.0
        worst = max(worst, float(np.max(np.abs(values - second[name]))) / scale)
    return worst
