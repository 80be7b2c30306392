"""Vectors of the plane as pairs of expressions, and wrenches: a force with a moment."""

from __future__ import annotations

import sympy as sp

from ..mechanism.links import INTEGRATES, Link, Parameter, Point

Vector = tuple[sp.Expr, sp.Expr]
ZERO: Vector = (sp.S.Zero, sp.S.Zero)


def perp(v: Vector) -> Vector:
    """The vector turned by a right angle, counter-clockwise: r⊥ = (−r_y, r_x)."""
    return (-v[1], v[0])


def dot(v: Vector, w: Vector) -> sp.Expr:
    return v[0] * w[0] + v[1] * w[1]


def add(*vectors: Vector) -> Vector:
    return (sp.Add(*(v[0] for v in vectors)), sp.Add(*(v[1] for v in vectors)))


def less(v: Vector, w: Vector) -> Vector:
    """v − w."""
    return (v[0] - w[0], v[1] - w[1])


def scale(factor: sp.Expr, v: Vector) -> Vector:
    return (factor * v[0], factor * v[1])


def symbol(parameter: Parameter | None) -> sp.Expr:
    """The parameter's symbol, or zero for a structural zero."""
    return sp.Symbol(parameter.symbol) if parameter else sp.S.Zero


def inertia_of(link: Link) -> sp.Expr:
    """A link's inertia about its centre of mass: a symbol, zero, or the number of a link that integrates."""
    return sp.Rational(INTEGRATES) if link.integrates else symbol(link.inertia)


def local(point: Point) -> Vector:
    """Coordinates of a point in its link's frame."""
    return (symbol(point.x), symbol(point.y))


Wrench = tuple[Vector, sp.Expr]
"""A force, and a moment about the inboard point of the link it acts on."""
NO_LOAD: Wrench = (ZERO, sp.S.Zero)
