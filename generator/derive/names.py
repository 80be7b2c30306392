"""Names of every quantity, made from its place: kind, link, joint, axis. Nothing is numbered by a counter.

``k`` is a link, ``j`` a joint (both in scene order), axes are ``x`` and ``y`` of the fixed frame. The ground has no
number; where a name needs it, ``g`` stands for it.
"""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp

from ..mechanism.links import GROUND

AXES = ("x", "y")


def place(link: int) -> str:
    """A link's part of a name."""
    return "g" if link == GROUND else str(link)


@dataclass(frozen=True, order=True)
class Variable:
    """A variable of the quadratic form that is handed from tips to root.

    ``kind`` is ``a`` (acceleration of the inboard point), ``alpha`` (angular acceleration) or ``lambda`` (closure
    multiplier of cut joint ``joint``).
    """

    kind: str
    joint: int = -1
    axis: str = ""

    @property
    def suffix(self) -> str:
        if self.kind == "lambda":
            return f"{self.joint}{self.axis}"
        return "w" if self.kind == "alpha" else self.axis


A_X, A_Y, ALPHA = Variable("a", axis="x"), Variable("a", axis="y"), Variable("alpha")


def multiplier(joint: int, axis: str) -> Variable:
    return Variable("lambda", joint, axis)


def hessian_name(link: int, v: Variable, w: Variable) -> str:
    """Name of a second derivative of V_link (eq. 8): Phi, p, D of accelerations; B, g, C with multipliers."""
    k = place(link)
    v, w = sorted((v, w))
    match v.kind, w.kind:
        case "a", "a":
            return f"Phi_{k}_{v.axis}{w.axis}"
        case "a", "alpha":
            return f"p_{k}_{v.axis}"
        case "alpha", "alpha":
            return f"D_{k}"
        case "a", "lambda":
            return f"B_{k}_{w.joint}_{v.axis}{w.axis}"
        case "alpha", "lambda":
            return f"g_{k}_{w.joint}_{w.axis}"
    joints = f"{v.joint}" if v.joint == w.joint else f"{v.joint}_{w.joint}"
    return f"C_{k}_{joints}_{v.axis}{w.axis}"


def linear_name(link: int, v: Variable, impact: bool) -> str:
    """Name of a first derivative of V_link at zero accelerations: b, h, d in flight; bi, hi, di in impact."""
    k, i = place(link), "i" if impact else ""
    if v.kind == "a":
        return f"b{i}_{k}_{v.axis}"
    if v.kind == "alpha":
        return f"h{i}_{k}"
    return f"d{i}_{k}_{v.joint}_{v.axis}"


def gain_name(link: int, eliminated: Variable, v: Variable | None, impact: bool = False) -> str:
    """Name of the factor by which ``v`` (or the constant term, ``None``) enters the solution for ``eliminated``."""
    k, i = place(link), "i" if impact else ""
    if eliminated.kind == "alpha":
        if v is None:
            return f"hD{i}_{k}"
        return f"pD_{k}_{v.axis}" if v.kind == "a" else f"gD_{k}_{v.joint}_{v.axis}"
    here = f"{k}_{eliminated.joint}_{eliminated.axis}" if eliminated.kind == "lambda" else f"{k}_{eliminated.axis}"
    return f"e{i}_{here}" if v is None else f"E_{here}_{v.suffix}"


def solution_name(link: int, v: Variable, impact: bool) -> str:
    """Name of an acceleration or multiplier once it is known, or of a velocity jump or impulse in impact."""
    k = place(link)
    if v.kind == "a":
        return f"{'dv' if impact else 'a'}_{k}_{v.axis}"
    if v.kind == "alpha":
        return f"{'dw' if impact else 'alpha'}_{k}"
    return f"{'Lambda' if impact else 'lambda'}_{v.joint}_{v.axis}"


@dataclass(frozen=True)
class State:
    """Symbols of coordinates q and quasi-velocities u = dq/dt, in order."""

    q: tuple[sp.Symbol, ...]
    u: tuple[sp.Symbol, ...]

    @staticmethod
    def of(links: int, root: int) -> State:
        """Root position first when the mechanism floats (``root`` is a link), then the absolute angle of each link."""
        base = [] if root == GROUND else [f"_{root}"]
        q = [f"{axis}{k}" for k in base for axis in AXES] + [f"theta_{k}" for k in range(links)]
        u = [f"v{axis}{k}" for k in base for axis in AXES] + [f"w_{k}" for k in range(links)]
        return State(tuple(map(sp.Symbol, q)), tuple(map(sp.Symbol, u)))

    def angle(self, link: int) -> sp.Symbol:
        return sp.Symbol(f"theta_{link}")

    def rate(self, link: int) -> sp.Symbol:
        return sp.Symbol(f"w_{link}")
