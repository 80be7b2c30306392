"""Rows of meshes: linear in the links' angles and the lengths of sliding joints, with constant levers (eq. 3.4)."""

from __future__ import annotations

import sympy as sp

from ..equations.names import State, place, slide_name, sliding_name
from ..mechanism.links import GROUND
from ..mechanism.meshes import Mesh
from ..mechanism.topology import MeshRow
from .kinematics import Kinematics
from .vectors import symbol


def passed(mesh: Mesh, state: State) -> sp.Expr:
    """What has passed the pitch point on one side since the start, less that on the other (m)."""
    total = sp.S.Zero
    for term in mesh.terms:
        if term.slide is not None:
            total += term.sign * (sp.Symbol(slide_name(term.slide)) - symbol(term.start))
        else:
            turned = state.angle(term.second) - state.angle(term.first) - symbol(term.start)
            total += term.sign * symbol(term.radius) * turned
    return total


class Meshing:
    """The rows of all meshes, behind those of the cut joints, in m.

    ``levers[j]`` are a row's derivatives by the links' angles (m), ``lengths[j]`` those by the lengths of sliding
    joints, by the number j of the row's multiplier.
    """

    def __init__(self, kinematics: Kinematics) -> None:
        self.kinematics, self.rows = kinematics, kinematics.topology.meshes
        self.levers: dict[int, dict[int, sp.Expr]] = {}
        self.lengths: dict[int, dict[int, int]] = {}
        for row in self.rows:
            sums: dict[int, sp.Expr] = {}
            for term in row.mesh.terms:
                for link, sign in ((term.second, term.sign), (term.first, -term.sign)):
                    if link != GROUND and term.slide is None:
                        sums[link] = sums.get(link, sp.S.Zero) + sign * symbol(term.radius)
            named = {k: kinematics.ledger.let(f"lever_{place(k)}_{row.joint}", sums[k]) for k in sorted(sums)}
            self.levers[row.joint] = {k: lever for k, lever in named.items() if lever != 0}
            self.lengths[row.joint] = row.mesh.lengths()
            kinematics.ledger.close(f"levers of {row.mesh.name}")

    def at(self, link: int) -> tuple[tuple[MeshRow, sp.Expr], ...]:
        """The rows in which the link's angle is, each with its lever (m)."""
        return tuple((row, self.levers[row.joint][link]) for row in self.rows if link in self.levers[row.joint])

    def along(self, joint: int) -> tuple[tuple[MeshRow, int], ...]:
        """The rows in which the length of a sliding joint is, each with its sign."""
        found = ((row, self.lengths[row.joint].get(joint, 0)) for row in self.rows)
        return tuple((row, sign) for row, sign in found if sign)

    def residual(self) -> tuple[sp.Expr, ...]:
        """The rows themselves (m)."""
        return tuple(passed(row.mesh, self.kinematics.state) for row in self.rows)

    def rate(self) -> tuple[sp.Expr, ...]:
        """Their rates (m/s)."""
        return tuple(sp.Add(*(x * u for u, x in self._columns(row).items())) for row in self.rows)

    def bias(self) -> tuple[sp.Expr, ...]:
        """What they accelerate at with no accelerations: nothing, since levers are constant."""
        return (sp.S.Zero,) * len(self.rows)

    def jacobian(self) -> tuple[sp.Expr, ...]:
        """Their derivatives by u, row by row."""
        columns = [self._columns(row) for row in self.rows]
        return tuple(column.get(u, sp.S.Zero) for column in columns for u in self.kinematics.state.u)

    def _columns(self, row: MeshRow) -> dict[sp.Expr, sp.Expr]:
        """The row's derivatives by those quasi-velocities that it depends on."""
        state, found = self.kinematics.state, dict[sp.Expr, sp.Expr]()
        for link, lever in self.levers[row.joint].items():
            rate = state.rate(link)
            if rate != 0:
                found[rate] = found.get(rate, sp.S.Zero) + lever
        for joint, sign in self.lengths[row.joint].items():
            found[sp.Symbol(sliding_name(joint))] = sp.Integer(sign)
        return found
