"""Finite closure of the cut joints, its rate and its Jacobian with respect to u (theory, section 3)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import sympy as sp

from ..mechanism.links import GROUND
from ..mechanism.topology import Cut
from .displacement import Displacement, between
from .kinematics import Kinematics
from .meshing import Meshing
from .vectors import ZERO, Vector, add, dot, perp, scale, symbol

FIXED: dict[str, Vector] = {"x": (sp.S.One, sp.S.Zero), "y": (sp.S.Zero, sp.S.One)}


@dataclass(frozen=True)
class Row:
    """One side's part in a closure row: ± direction·(acceleration at the end of ``arm``) at u̇ = 0 is ``bias``."""

    name: str
    direction: Vector
    arm: Vector
    bias: sp.Expr


@dataclass(frozen=True)
class Line:
    """The line of a cut joint that slides: how the second point lies and moves as its link sees it.

    ``along`` and ``normal`` are unit vectors, ``distance`` (m) is from the first point to the second, ``drift`` (m/s)
    its rate in the first link's frame.
    """

    along: Vector
    normal: Vector
    distance: Vector
    drift: Vector


class Closure:
    """Rows of every cut joint (eq. 3.1): (point on the second side) − (point on the first side) = 0.

    A pin has rows x and y; a joint that slides has one row n, across its line, and where it holds an angle that the
    tree does not, a row a of that. Meshes have one row m each, behind them. All rows of a joint that lets go or takes
    hold are times its gate: while that is 0, they are 0.
    """

    def __init__(self, kinematics: Kinematics) -> None:
        self.kinematics, self.topology = kinematics, kinematics.topology
        self.meshing = Meshing(kinematics)
        self.displacements: dict[int, Displacement] = {}
        self.lines: dict[int, Line] = {}
        for cut in self.topology.cuts:
            ends = [(side.link, kinematics.r[side.link, cut.joint]) for side in (cut.first, cut.second)]
            self.displacements[cut.joint] = between(kinematics, ends[0], ends[1])
            if cut.slides:
                self._write_line(cut)

    def _write_line(self, cut: Cut) -> None:
        kinematics, displacement = self.kinematics, self.displacements[cut.joint]
        along = kinematics.line(cut.joint)
        distance = kinematics.ledger.let_vector(f"across_{cut.joint}", displacement.vector())
        carried = kinematics.swing(cut.first.link, distance)
        drift = add(displacement.rate(), scale(sp.S.NegativeOne, carried))
        drift = kinematics.ledger.let_vector(f"drift_{cut.joint}", drift)
        self.lines[cut.joint] = Line(along, perp(along), distance, drift)
        kinematics.ledger.close(f"line of {kinematics.mechanism.joints[cut.joint].name}")

    def side(self, cut: Cut, link: int, factor: int) -> tuple[Row, ...]:
        """What the side of ``cut`` on ``link`` adds to each row; ``factor`` is 1 for the second side, −1 for the first.

        A line turns with the first link: there the row sees the acceleration of that link's point under the pin, less
        2 ω ṡ n (eq. 3.3).
        """
        if self.kinematics.is_carried_by(link, cut.joint):  # the point is the link's inboard point
            return tuple(Row(name, FIXED[name], ZERO, sp.S.Zero) for name in cut.rows)  # segments' joints are pins
        arm, squared = self.kinematics.r[link, cut.joint], self.kinematics.squared_rate[link]
        line, extra = self.lines.get(cut.joint), sp.S.Zero
        directions: dict[str, Vector] = {"n": line.normal} if line else FIXED
        if line and factor < 0:
            arm = add(arm, line.distance)
            extra = -2 * self.kinematics.state.rate(link) * dot(line.along, line.drift)
        if link == GROUND or not line:
            bias = scale(-factor, self.kinematics.cr[link, cut.joint])
        else:
            bias = scale(-factor * squared, arm)
        return tuple(Row(name, directions[name], arm, dot(directions[name], bias) + extra) for name in directions)

    def turning(self, cut: Cut, link: int) -> sp.Expr:
        """What the angular acceleration of ``link`` is multiplied by in the row a of ``cut``, 0 where there is none."""
        lever = sp.Float(cut.arm) if cut.turns_alike and link != GROUND else sp.S.Zero
        return lever * ((cut.second.link == link) - (cut.first.link == link))

    def missing(self, joint: int) -> list[tuple[sp.Expr, sp.Expr]]:
        """The rows of a joint that is cut, whether it holds or not (m), each with its rate (m/s)."""
        (cut,) = (one for one in self.topology.cuts if one.joint == joint)
        gap, rate = self.displacements[joint].vector(), self._line_drift(cut) or self.displacements[joint].rate()
        rows = [(dot(direction, gap), dot(direction, rate)) for direction in self._directions(cut)]
        return [*rows, *([(self._turned(cut), self._spin(cut))] if cut.turns_alike else [])]

    def residual(self) -> tuple[sp.Expr, ...]:
        """The rows themselves (m)."""
        rows = self._rows(lambda cut: self.displacements[cut.joint].vector(), self._turned)
        return (*rows, *self.meshing.residual())

    def rate(self) -> tuple[sp.Expr, ...]:
        """A u (m/s), eq. 3.2."""
        rates = self._rows(lambda cut: self._line_drift(cut) or self.displacements[cut.joint].rate(), self._spin)
        return (*rates, *self.meshing.rate())

    def bias(self) -> tuple[sp.Expr, ...]:
        """Ȧ u (m/s²): what the rows accelerate at with u̇ = 0, eq. 3.2 differentiated."""
        return (*self._rows(self._bias, lambda cut: sp.S.Zero), *self.meshing.bias())

    def jacobian(self) -> tuple[sp.Expr, ...]:
        """A, row by row (eq. 3.2)."""
        state, entries = self.kinematics.state, []
        for cut in self.topology.cuts:
            columns, line = self.displacements[cut.joint].columns(), self.lines.get(cut.joint)
            spin = state.rate(cut.first.link)
            if line and spin != 0:
                columns[spin] = add(columns.get(spin, (sp.S.Zero,) * 2), scale(sp.S.NegativeOne, perp(line.distance)))
            on = gate_of(cut)
            for direction in self._directions(cut):
                entries += [on * dot(direction, columns[u]) if u in columns else sp.S.Zero for u in state.u]
            if cut.turns_alike:
                entries += [on * sp.diff(self._spin(cut), u) for u in state.u]
        return (*entries, *self.meshing.jacobian())

    def _line_drift(self, cut: Cut) -> Vector | None:
        line = self.lines.get(cut.joint)
        return line.drift if line else None

    def _bias(self, cut: Cut) -> Vector:
        total, line = self.displacements[cut.joint].bias(), self.lines.get(cut.joint)
        if not line:
            return total
        first = cut.first.link
        carried = scale(self.kinematics.squared_rate[first], line.distance)
        return add(total, carried, scale(-2 * self.kinematics.state.rate(first), perp(line.drift)))

    def _directions(self, cut: Cut) -> tuple[Vector, ...]:
        line = self.lines.get(cut.joint)
        return (line.normal,) if line else tuple(FIXED.values())

    def _turned(self, cut: Cut) -> sp.Expr:
        """By how much the links of ``cut`` miss the angle that it holds, without whole turns, as a length (m)."""
        state, held = self.kinematics.state, self.kinematics.mechanism.joints[cut.joint].angle
        angle = state.angle(cut.second.link) - state.angle(cut.first.link) - (symbol(held) if held else 0)
        return 2 * sp.Float(cut.arm) * sp.atan(sp.tan(angle / 2))

    def _spin(self, cut: Cut) -> sp.Expr:
        """How fast the links of ``cut`` turn against each other, likewise (m/s)."""
        state = self.kinematics.state
        return sp.Float(cut.arm) * (state.rate(cut.second.link) - state.rate(cut.first.link))

    def _rows(self, vector: Callable[[Cut], Vector], turned: Callable[[Cut], sp.Expr]) -> tuple[sp.Expr, ...]:
        rows: list[sp.Expr] = []
        for cut in self.topology.cuts:
            found, on = vector(cut), gate_of(cut)
            rows += [on * dot(direction, found) for direction in self._directions(cut)]
            rows += [on * turned(cut)] if cut.turns_alike else []
        return tuple(rows)


def gate_of(cut: Cut) -> sp.Expr:
    """What the rows of a joint are times: 1 unless it lets go or takes hold."""
    return symbol(cut.gate) if cut.gate else sp.S.One
