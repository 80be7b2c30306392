"""The recursive symbolic equations are the expanded Gibbs-Appell equations: their difference is exactly zero.

The chain of named assignments is evaluated in the field of rational functions over the integers, see
``oracles.expanded``, and put into the equations of motion that follow from the total Gibbs function by differentiation.
"""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from typing import Any

import pytest
import sympy as sp

from ccgen.generator.equations.equations import Equations
from ccgen.generator.mechanism.joints import PointRef
from ccgen.generator.mechanism.links import GROUND, Point
from ccgen.generator.mechanism.mechanism import Mechanism
from ccgen.generator.mechanism.topology import Topology
from ccgen.generator.pipeline import derive_scene

from ..oracles.expanded import Body, Branch, Cut, Exact, Expanded, Pair, expand, residuals
from ..support.tiers import all_hard_but
from ..support.workshop import Workshop

CASES = {
    "open-2": (2, False, 3),
    "open-3": (3, False, 4),
    "floating-3": (3, True, 2),
}
"""Links, whether they close to a ring, and a number that varies the link data."""


def text(links: int, ring: bool) -> str:
    """A scene whose links have offset centres of mass, in open chains also bent links; all data become symbols."""
    tip = "[1.0, 0]" if ring else "[1.0, 0.3]"
    lines = ['name = "exact"', "[gravity]", "g = 9.81"]
    for k in range(links):
        lines += ["[[link]]", f'name = "body_{k}"', "mass = 1.5", "inertia = 0.2", "com = [0.4, 0.1]"]
        lines += [f"points = {{ A = [0, 0], B = {tip} }}"]
    pairs = [(k - 1, k) for k in range(1, links)] + ([(links - 1, 0)] if ring else [])
    for a, b in pairs:
        lines += ["[[joint]]", f'between = ["body_{a}.B", "body_{b}.A"]']
    if ring:
        lines += ["[start]", "angles = [0.0, 2.1, 4.2]"]
    return "\n".join(lines) + "\n"


class Recursive:
    """The tool's symbolic equations of a scene, and the expanded ones of the same virtual open chain."""

    def __init__(self, workshop: Workshop, links: int, ring: bool) -> None:
        scene = workshop.scene(text(links, ring))
        self.links = links
        self.topology: Topology
        self.equations: Equations
        self.topology, self.equations = derive_scene(scene)
        self.expanded = _expanded(scene.mechanism, self.topology)
        self.data = [sp.Symbol(p.symbol) for p in self.equations.parameters]
        self.speeds = [sp.Symbol(f"w_{k}") for k in range(links)]

    def differences(self, exact: Exact) -> list[Any]:
        """``M u' + h - A^T lambda`` and ``A u' + bias`` with the recursive u' and lambda put in."""
        (kernel,) = (k for k in self.equations.kernels if k.name == "acceleration")
        rates, multipliers = (output.entries for output in kernel.outputs)
        needed = _needed([*rates, *multipliers], self.equations)
        exact.assign((a.symbol, a.expression) for a in self.equations.assignments() if a.symbol in needed)
        found: list[Any] = residuals(exact, self.expanded, [exact(r) for r in rates], [exact(m) for m in multipliers])
        return found


def _needed(outputs: list[sp.Expr], equations: Equations) -> set[sp.Symbol]:
    definitions = {a.symbol: a.expression for a in equations.assignments()}
    found: set[sp.Symbol] = set()
    waiting = [s for entry in outputs for s in entry.free_symbols]
    while waiting:
        symbol = waiting.pop()
        if symbol in definitions and symbol not in found:
            found.add(symbol)
            waiting.extend(definitions[symbol].free_symbols)
    return found


def _pair(point: Point) -> Pair:
    x, y = (sp.Symbol(p.symbol) if p else sp.S.Zero for p in (point.x, point.y))
    return x, y


def _expanded(mechanism: Mechanism, topology: Topology) -> Expanded:
    bodies = [
        Body(sp.Symbol(link.mass.symbol), sp.Symbol(link.inertia.symbol), _pair(link.com)) for link in mechanism.links
    ]

    def at(link: int, name: str) -> Pair:
        return _pair(mechanism.point(PointRef(link, name)))

    branches = [Branch(b.link, at(b.link, b.inboard), b.parent, at(b.parent, b.attach)) for b in topology.branches]
    cuts = [
        Cut((c.first.link, at(c.first.link, c.first.point)), (c.second.link, at(c.second.link, c.second.point)))
        for c in topology.cuts
    ]
    assert topology.root != GROUND
    return expand(bodies, topology.root, branches, cuts, sp.Symbol("g"))


def _numbers(symbols: list[sp.Symbol], seed: int) -> Mapping[sp.Symbol, sp.Integer]:
    """Small whole numbers without a pattern."""
    return {s: sp.Integer((seed * (k + 3) ** 2 + 5 * k) % 9 + 1) for k, s in enumerate(symbols)}


@pytest.mark.parametrize("case", all_hard_but("open-2", of=CASES))
def test_equal_at_every_state(case: str, workshop: Workshop) -> None:
    """Angles and angular velocities are symbols, link data are whole numbers."""
    links, ring, seed = CASES[case]
    recursive = Recursive(workshop, links, ring)
    exact = Exact(links, recursive.speeds, _numbers(recursive.data, seed))
    found = recursive.differences(exact)
    assert len(found) == 2 + links + 2 * ring
    assert all(value == 0 for value in found)


@pytest.mark.parametrize("case", CASES)
def test_equal_for_every_mass(case: str, workshop: Workshop) -> None:
    """Masses are symbols, the angles have rational cosines and sines, the other data are whole numbers."""
    links, ring, seed = CASES[case]
    recursive = Recursive(workshop, links, ring)
    masses = [s for s in recursive.data if s.name.startswith("m_")]
    assert len(masses) == links
    rest = [s for s in (*recursive.data, *recursive.speeds) if s not in masses]
    tangents = [Fraction(1, 2), Fraction(-2, 3), Fraction(3, 1)][:links]
    exact = Exact(links, masses, _numbers(rest, seed), tangents)
    assert all(value == 0 for value in recursive.differences(exact))


def test_the_check_sees_a_wrong_sign(workshop: Workshop) -> None:
    """The same check fails when gravity also pulls sideways in the reference."""
    recursive = Recursive(workshop, 2, False)
    recursive.expanded.bias[0] += sp.Symbol("m_0") * sp.Symbol("g")
    exact = Exact(2, [], _numbers([*recursive.data, *recursive.speeds], 4))
    assert any(value != 0 for value in recursive.differences(exact))
