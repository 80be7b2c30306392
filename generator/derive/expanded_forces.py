"""Generalized forces Q of the loads that effects put on links, for the closed form: Q = Σ F·∂x/∂q + Σ M ∂θ/∂q.

Effects write their loads for the recursion, in the names of its kinematics. Here those names are replaced by what they
stand for, sines and cosines of the angles; names that effects give to quantities of their own are kept.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import sympy as sp

from ..equations.equations import Assignment
from ..equations.ledger import Ledger
from ..equations.names import State
from ..mechanism.joints import PointRef
from ..mechanism.links import GROUND
from ..mechanism.mechanism import Mechanism
from ..mechanism.topology import Topology
from .closure import Closure
from .kinematics import Kinematics
from .motion import Couple, Force, Motion, Stands
from .terms_of_effects import Terms, laws_of
from .vectors import Vector, dot

Position = Callable[[PointRef], Vector]
"""Where a named point is, as a function of q."""


def expanded_forces(
    mechanism: Mechanism, topology: Topology, state: State, effects: Sequence[Terms], position: Position
) -> tuple[tuple[sp.Expr, ...], tuple[Assignment, ...]]:
    """Q, one entry per quasi-velocity (N, N m), and the definitions of the names in it, in their order."""
    ledger = Ledger()
    kinematics = Kinematics(mechanism, topology, state, ledger)
    places, velocities = kinematics.write_positions(), kinematics.write_velocities()
    motion = _Named(kinematics, Closure(kinematics), places, velocities, laws_of(effects))
    loads = [load for effect in effects for load in effect.loads(motion)]
    ledger.close("loads")
    explicit: dict[sp.Symbol, sp.Expr] = {}
    own: list[Assignment] = []
    for assignment in (a for block in ledger.blocks for a in block.assignments):
        expression = assignment.expression.xreplace(explicit)
        if assignment.symbol in motion.own:
            own.append(Assignment(assignment.symbol, expression))
        else:
            explicit[assignment.symbol] = expression
    total = [sp.S.Zero] * len(state.q)
    for load in loads:
        total = [a + b for a, b in zip(total, _projected(load, state, position, explicit), strict=True)]
    return tuple(total), _used(total, own)


class _Named(Motion):
    """Motion that remembers which names effects gave."""

    def __init__(
        self,
        kinematics: Kinematics,
        closure: Closure,
        place: dict[int, Vector],
        velocity: dict[int, Vector],
        laws: Mapping[str, Stands],
    ) -> None:
        super().__init__(kinematics, closure, place, velocity, laws)
        self.own: set[sp.Symbol] = set()

    def let(self, name: str, expression: sp.Expr) -> sp.Expr:
        self.own.add(sp.Symbol(name))
        return super().let(name, expression)

    def let_vector(self, name: str, vector: Vector) -> Vector:
        return (self.let(f"{name}_x", vector[0]), self.let(f"{name}_y", vector[1]))


def _projected(
    load: Force | Couple, state: State, position: Position, explicit: dict[sp.Symbol, sp.Expr]
) -> list[sp.Expr]:
    """What one load, in ``explicit`` terms, does along each coordinate; nothing on the ground."""
    link = load.point.link if isinstance(load, Force) else load.link
    if link == GROUND:
        return [sp.S.Zero] * len(state.q)
    if isinstance(load, Couple):
        moment = load.moment.xreplace(explicit)
        return [moment * sp.diff(state.angle(link), q) for q in state.q]
    x, y = position(load.point)
    force = (load.vector[0].xreplace(explicit), load.vector[1].xreplace(explicit))
    return [dot(force, (sp.diff(x, q), sp.diff(y, q))) for q in state.q]


def _used(forces: Sequence[sp.Expr], own: Sequence[Assignment]) -> tuple[Assignment, ...]:
    """The definitions that the forces depend on."""
    wanted = {s for entry in forces for s in entry.free_symbols}
    for assignment in reversed(own):
        if assignment.symbol in wanted:
            wanted |= assignment.expression.free_symbols
    return tuple(a for a in own if a.symbol in wanted)
