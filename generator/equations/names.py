"""Names of every quantity, made from its place: kind, link, joint, axis. Nothing is numbered by a counter.

``k`` is a link, ``j`` a joint (both in scene order), axes are ``x`` and ``y`` of the fixed frame. The ground has no
number; where a name needs it, ``g`` stands for it.
"""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp

from ..mechanism.links import GROUND
from ..mechanism.mechanism import Mechanism
from ..mechanism.topology import Topology

AXES = ("x", "y")


def place(link: int) -> str:
    """A link's part of a name."""
    return "g" if link == GROUND else str(link)


@dataclass(frozen=True, order=True)
class Variable:
    """A variable of the quadratic form that is handed from tips to root.

    ``kind`` is ``a`` (acceleration of the inboard point), ``alpha`` (angular acceleration), ``slide`` (acceleration
    along the line of the joint that carries the link), ``lambda`` (closure multiplier of cut joint ``joint``) or
    ``turn`` (angular acceleration of link ``joint``, further out, which is left open). ``rank`` comes first in the
    order of multipliers.
    """

    kind: str
    rank: int = 0
    joint: int = -1
    axis: str = ""

    @property
    def suffix(self) -> str:
        if self.kind == "lambda":
            return f"{self.joint}{self.axis}"
        if self.kind == "turn":
            return f"w{self.joint}"
        return {"alpha": "w", "slide": "s"}.get(self.kind, self.axis)


A_X, A_Y, ALPHA, SLIDE = Variable("a", axis="x"), Variable("a", axis="y"), Variable("alpha"), Variable("slide")


def multiplier(joint: int, axis: str, rank: int = 0) -> Variable:
    """One of the multipliers of a cut joint."""
    return Variable("lambda", rank, joint, axis)


def turn(link: int) -> Variable:
    """The angular acceleration of ``link``, as a variable of the forms of links nearer to the root."""
    return Variable("turn", joint=link)


def hessian_name(link: int, v: Variable, w: Variable) -> str:
    """Name of a second derivative of V_link (eq. 4.4): Phi, p, D of accelerations; B, g, C with multipliers.

    Those with the acceleration along a sliding joint's line: Psi (with a), psi (with α), gs (with λ), Ds (eq. 4.5).
    Those with the angular acceleration of a link further out have that link's number behind ``link``'s.
    """
    k = place(link)
    v, w = sorted((v, w))
    if w.kind == "turn":
        return _open_name(k, v, w)
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
        case "a", "slide":
            return f"Psi_{k}_{v.axis}"
        case "alpha", "slide":
            return f"psi_{k}"
        case "lambda", "slide":
            return f"gs_{k}_{v.joint}_{v.axis}"
        case "slide", "slide":
            return f"Ds_{k}"
    joints = f"{v.joint}" if v.joint == w.joint else f"{v.joint}_{w.joint}"
    return f"C_{k}_{joints}_{v.axis}{w.axis}"


def _open_name(k: str, v: Variable, w: Variable) -> str:
    """The same where ``w`` is the angular acceleration of a link further out."""
    match v.kind:
        case "a":
            return f"p_{k}_{w.joint}_{v.axis}"
        case "alpha":
            return f"D_{k}_{w.joint}"
        case "lambda":
            return f"g_{k}_{w.joint}_{v.joint}_{v.axis}"
        case "slide":
            return f"psi_{k}_{w.joint}"
    return f"D_{k}_{v.joint}_{w.joint}"


def linear_name(link: int, v: Variable, impact: bool) -> str:
    """Name of a first derivative of V_link at zero accelerations: b, h, d in flight; bi, hi, di in impact."""
    k, i = place(link), "i" if impact else ""
    if v.kind == "a":
        return f"b{i}_{k}_{v.axis}"
    if v.kind == "alpha":
        return f"h{i}_{k}"
    if v.kind == "slide":
        return f"hs{i}_{k}"
    if v.kind == "turn":
        return f"h{i}_{k}_{v.joint}"
    return f"d{i}_{k}_{v.joint}_{v.axis}"


def gain_name(link: int, eliminated: Variable, v: Variable | None, impact: bool = False) -> str:
    """Name of the factor by which ``v`` (or the constant term, ``None``) enters the solution for ``eliminated``."""
    k, i = place(link), "i" if impact else ""
    if eliminated.kind in ("alpha", "turn"):
        here = k if eliminated.kind == "alpha" else f"{k}_{eliminated.joint}"
        if v is None:
            return f"hD{i}_{here}"
        names = {"a": f"pD_{here}_{v.axis}", "lambda": f"gD_{here}_{v.joint}_{v.axis}", "slide": f"Dpsi_{here}"}
        whose = {"alpha": k, "turn": str(v.joint)}
        return names[v.kind] if v.kind in names else f"DD_{here if '_' in here else f'{k}_{k}'}_{whose[v.kind]}"
    if eliminated.kind == "slide":
        if v is None:
            return f"hDs{i}_{k}"
        names = {"a": f"PsiD_{k}_{v.axis}", "alpha": f"psiD_{k}", "lambda": f"gDs_{k}_{v.joint}_{v.axis}"}
        names["turn"] = f"psiD_{k}_{v.joint}"
        return names[v.kind]
    here = f"{k}_{eliminated.joint}_{eliminated.axis}" if eliminated.kind == "lambda" else f"{k}_{eliminated.axis}"
    return f"e{i}_{here}" if v is None else f"E_{here}_{v.suffix}"


def solution_name(link: int, v: Variable, impact: bool) -> str:
    """Name of an acceleration or multiplier once it is known, or of a velocity jump or impulse in impact."""
    k = place(link)
    if v.kind == "a":
        return f"{'dv' if impact else 'a'}_{k}_{v.axis}"
    if v.kind in ("alpha", "turn"):
        return f"{'dw' if impact else 'alpha'}_{k if v.kind == 'alpha' else v.joint}"
    if v.kind == "slide":
        return f"{'dsliding' if impact else 'slide_acc'}_{k}"
    return f"{'Lambda' if impact else 'lambda'}_{v.joint}_{v.axis}"


@dataclass(frozen=True)
class State:
    """Symbols of coordinates q and quasi-velocities u = dq/dt, in order; and every link's angle and rate.

    ``base`` coordinates come first: the position of a floating root. Then the absolute angle of each link that has one
    of its own, in scene order, then the length along the line of each sliding joint of the tree, in scene order.
    ``angles`` and ``rates`` of links that follow another link's angle are that one's, with the joints' angles added.
    """

    q: tuple[sp.Symbol, ...]
    u: tuple[sp.Symbol, ...]
    base: int = 0
    angles: tuple[sp.Expr, ...] = ()
    rates: tuple[sp.Expr, ...] = ()

    @staticmethod
    def of(mechanism: Mechanism, topology: Topology) -> State:
        """The state of the virtual open chain."""
        base = [f"_{topology.root}"] if topology.floating else []
        followers = {branch.link: branch for branch in topology.branches if branch.follows}
        slides = sorted(branch.joint for branch in topology.branches if branch.slides)
        own = [k for k in range(len(mechanism.links)) if k not in followers]
        q = [f"{axis}{k}" for k in base for axis in AXES] + [f"theta_{k}" for k in own]
        u = [f"v{axis}{k}" for k in base for axis in AXES] + [f"w_{k}" for k in own]
        q, u = q + [slide_name(j) for j in slides], u + [sliding_name(j) for j in slides]
        angles: dict[int, sp.Expr] = {GROUND: sp.S.Zero} | {k: sp.Symbol(f"theta_{k}") for k in own}
        rates: dict[int, sp.Expr] = {GROUND: sp.S.Zero} | {k: sp.Symbol(f"w_{k}") for k in own}
        for branch in topology.branches:  # from the root outwards, so what is followed is known
            if branch.follows:
                angle = mechanism.joints[branch.joint].angle
                turned = (1 if branch.outwards else -1) * sp.Symbol(angle.symbol) if angle else sp.S.Zero
                angles[branch.link] = angles[branch.parent] + turned
                rates[branch.link] = rates[branch.parent]
        links = range(len(mechanism.links))
        every = [tuple(of[k] for k in links) for of in (angles, rates)]
        return State(tuple(map(sp.Symbol, q)), tuple(map(sp.Symbol, u)), 2 * len(base), every[0], every[1])

    def angle(self, link: int) -> sp.Expr:
        """Absolute angle (rad); that of the ground is zero."""
        return sp.S.Zero if link == GROUND else self.angles[link]

    def rate(self, link: int) -> sp.Expr:
        """Angular velocity (rad/s): a symbol of ``u``, or zero."""
        return sp.S.Zero if link == GROUND else self.rates[link]


def slide_name(joint: int) -> str:
    """The coordinate of a sliding joint: how far along the line its second point is from its first."""
    return f"slide_{joint}"


def sliding_name(joint: int) -> str:
    return f"sliding_{joint}"
