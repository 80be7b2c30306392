"""The quadratic form V_k handed from tips to root, and the elimination of variables from it (theory, section 4).

V = ½ zᵀHz + zᵀl over accelerations and closure multipliers z. Flight and impact share H and differ in l.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import sympy as sp

from ..equations.ledger import Ledger
from ..equations.names import (
    A_X,
    A_Y,
    ALPHA,
    Variable,
    gain_name,
    hessian_name,
    linear_name,
    place,
    solution_name,
    turn,
)
from .vectors import Vector, dot, perp

FLIGHT, IMPACT = False, True
"""Whether it is an impact: which of the two right sides of the same equations is meant."""


def sign(*variables: Variable) -> int:
    """−1 where a multiplier takes part: B, γ, C, d carry the sign that theory, eq. 4.3 gives them."""
    return -1 if any(v.kind == "lambda" for v in variables) else 1


@dataclass
class Form:
    """Coefficients of V over ``variables``; absent entries are zero. ``linear[impact][v]``."""

    variables: list[Variable]
    hessian: dict[tuple[Variable, Variable], sp.Expr] = field(default_factory=dict)
    linear: dict[bool, dict[Variable, sp.Expr]] = field(default_factory=lambda: {FLIGHT: {}, IMPACT: {}})

    def h(self, v: Variable, w: Variable) -> sp.Expr:
        return self.hessian.get((v, w) if v <= w else (w, v), sp.S.Zero)

    def add_h(self, v: Variable, w: Variable, value: sp.Expr) -> None:
        key = (v, w) if v <= w else (w, v)
        self.hessian[key] = self.hessian.get(key, sp.S.Zero) + value

    def l(self, impact: bool, v: Variable) -> sp.Expr:  # noqa: E743 (the symbol of theory, eq. 4.4)
        return self.linear[impact].get(v, sp.S.Zero)

    def add_l(self, impact: bool, v: Variable, value: sp.Expr) -> None:
        self.linear[impact][v] = self.l(impact, v) + value

    def column(self, v: Variable) -> Vector:
        """Derivatives of V by a and ``v``."""
        return (self.h(A_X, v), self.h(A_Y, v))

    def leave_open(self, link: int) -> None:
        """Give the link's angular acceleration its number, so that links nearer to the root can tell it from theirs."""
        name = {ALPHA: turn(link)}
        self.variables = [name.get(v, v) for v in self.variables]
        named = {(name.get(v, v), name.get(w, w)): x for (v, w), x in self.hessian.items()}
        self.hessian = {(v, w) if v <= w else (w, v): x for (v, w), x in named.items()}
        self.linear = {i: {name.get(v, v): x for v, x in part.items()} for i, part in self.linear.items()}

    def substitute(self, by: Substitution, let: Naming | None = None) -> Form:
        """V of the new variables, with S z' + z₀ in the place of z: SᵀHS and Sᵀ(l + H z₀) (theory, eq. 4.3 and 4.5).

        ``let`` names rows of H S and of l + H z₀ where they enter more than one entry.
        """
        let = let or (lambda new, v, value: value)
        open_ = [v for v in self.variables if v not in by.rows]
        rows = {v: {v: sp.S.One} for v in open_} | {v: by.rows[v] for v in self.variables if v in by.rows}
        new = sorted({w for row in rows.values() for w in row})
        result = Form(list(dict.fromkeys([w for v in by.rows for w in rows.get(v, ())] + open_)))
        still = {v: self.l(FLIGHT, v) + sp.Add(*(self.h(v, w) * x for w, x in by.constant.items())) for v in rows}
        felt = {v: let(None, v, x) if v in by.rows and rows[v] else x for v, x in still.items()}
        linear = {FLIGHT: felt, IMPACT: {v: self.l(IMPACT, v) for v in rows}}
        for impact, part in linear.items():
            for v, value in part.items():
                for w, x in rows[v].items():
                    result.add_l(impact, w, x * value)
        moved: dict[tuple[Variable, Variable], sp.Expr] = {}
        for w in new:
            for v in rows:
                value = sp.Add(*(self.h(v, u) * row[w] for u, row in rows.items() if w in row))
                moved[v, w] = let(w, v, value) if v in by.rows else value
        for i, w in enumerate(new):
            for other in new[i:]:
                value = sp.Add(*(row[w] * moved[v, other] for v, row in rows.items() if w in row))
                result.add_h(w, other, self._along(w, by, value) if w == other else value)
        return result

    def _along(self, w: Variable, by: Substitution, value: sp.Expr) -> sp.Expr:
        """The diagonal entry of ``w``; where V is that of a point's mass, only the direction's length counts."""
        xx, even = self.h(A_X, A_X), self.h(A_X, A_Y) == 0 and self.h(A_X, A_X) == self.h(A_Y, A_Y)
        return xx if even and w in by.directions else value

    def without_mass(self) -> Form:
        """The form without its second derivatives by a."""
        kept = {key: x for key, x in self.hessian.items() if not {*key} <= {A_X, A_Y}}
        return Form(list(self.variables), kept, self.linear)

    def add(self, other: Form) -> None:
        """Add another form, over its variables too."""
        self.variables += [v for v in other.variables if v not in self.variables]
        for (v, w), value in other.hessian.items():
            if value != 0:
                self.add_h(v, w, value)
        for impact, part in other.linear.items():
            for v, value in part.items():
                if value != 0:
                    self.add_l(impact, v, value)


Naming = Callable[[Variable | None, Variable, sp.Expr], sp.Expr]
"""Names an entry of H S, by its new and its old variable, or of l + H z₀, with ``None`` for the new one."""


@dataclass(frozen=True)
class Substitution:
    """z = S z' + z₀: ``rows`` of S by the old variables that change, and z₀ in flight; ``constant`` is zero in impact.

    ``directions`` are new variables whose column of S is a unit vector.
    """

    rows: Mapping[Variable, Mapping[Variable, sp.Expr]]
    constant: Mapping[Variable, sp.Expr] = field(default_factory=dict)
    directions: tuple[Variable, ...] = ()


def carried(arm: Vector, further: Mapping[Variable, Vector] | None = None) -> dict[Variable, dict[Variable, sp.Expr]]:
    """Rows of S where the acceleration of a point is a + α arm⊥, and ``further`` variables along their directions."""
    swing = perp(arm)
    rows: dict[Variable, dict[Variable, sp.Expr]] = {A_X: {A_X: sp.S.One}, A_Y: {A_Y: sp.S.One}}
    for axis, v in enumerate((A_X, A_Y)):
        for w, direction in {ALPHA: swing, **(further or {})}.items():
            if direction[axis] != 0:
                rows[v][w] = direction[axis]
    return rows


@dataclass(frozen=True)
class Solution:
    """An eliminated block: v = −(gains · remaining variables + constant), kept for the sweep outwards.

    ``guard`` is what must stay away from zero, and what it is compared with where the block itself says that. A dyad's
    multipliers have no gains: ``dyad`` gives them once its angular accelerations are known.
    """

    link: int
    variables: tuple[Variable, ...]
    gains: dict[tuple[Variable, Variable], sp.Expr]
    constant: dict[tuple[bool, Variable], sp.Expr]
    guard: sp.Expr | None = None
    scale: sp.Expr | None = None
    dyad: Dyad | None = None


@dataclass(frozen=True)
class Dyad:
    """What gives a dyad's multipliers: ``inverse`` of the rows' derivatives by its two angular accelerations, and the
    entries of ∂V/∂α for both of them, over all variables but the multipliers themselves."""

    inverse: tuple[Vector, Vector]
    slopes: dict[tuple[Variable, Variable], sp.Expr]
    constant: dict[tuple[bool, Variable], sp.Expr]


class Eliminator:
    """Eliminates variables from one link's form, naming what arises."""

    def __init__(self, link: int, form: Form, ledger: Ledger) -> None:
        self.link, self.form, self.ledger = link, form, ledger

    def name_entries(self, only: tuple[Variable, ...] | None = None, suffix: str = "") -> None:
        """Give every entry (or every entry that touches ``only``) its name, with a suffix while it is not yet final."""
        form = self.form
        for key in sorted(form.hessian):
            if only is None or key[0] in only or key[1] in only:
                factor = sign(*key)
                form.hessian[key] = factor * self.ledger.let(
                    hessian_name(self.link, *key) + suffix, factor * form.hessian[key]
                )
        for impact in (FLIGHT, IMPACT):
            for v in sorted(form.linear[impact]):
                if only is None or v in only:
                    factor = sign(v)
                    form.linear[impact][v] = factor * self.ledger.let(
                        linear_name(self.link, v, impact) + suffix, factor * form.linear[impact][v]
                    )

    def eliminate(self, block: tuple[Variable, ...]) -> Solution:
        """Make V stationary in the one or two variables of ``block`` and substitute (theory, eq. 4.7 and 4.8)."""
        self.name_entries(only=block)
        self._show(block)
        inverse, guard = self._inverse(block)
        rest = [v for v in self.form.variables if v not in block]
        touched = [v for v in rest if any(self.form.h(e, v) != 0 for e in block)]
        gains, constant = {}, {}
        for v in touched:
            for row, e in enumerate(block):
                value = sp.Add(*(inverse[row][column] * self.form.h(other, v) for column, other in enumerate(block)))
                factor = sign(v) * sign(e) if e.kind != "lambda" else 1
                gains[e, v] = factor * self.ledger.let(gain_name(self.link, e, v), factor * value)
        for impact in (FLIGHT, IMPACT):
            for row, e in enumerate(block):
                value = sp.Add(*(inverse[row][column] * self.form.l(impact, o) for column, o in enumerate(block)))
                constant[impact, e] = self.ledger.let(gain_name(self.link, e, None, impact), value)
        self._substitute(block, touched, gains, constant)
        return Solution(self.link, block, gains, constant, guard)

    def close_dyad(self, block: tuple[Variable, ...], scale: sp.Expr) -> Solution:
        """Solve two closure rows for two angular accelerations and substitute (theory, eq. 4.15 and 4.16).

        ``scale`` is the greatest square that the determinant of the rows' derivatives can have.
        """
        self.name_entries(only=block)
        self._show(block)
        form, let, k = self.form, self.ledger.let, place(self.link)
        turns, rows = block[:2], block[2:]
        if any(form.h(row, v) != 0 for row in rows for v in form.variables if v.kind == "lambda"):
            raise ValueError(f"rows {rows} of a dyad share an eliminated link with other rows")
        jacobian = [[form.h(row, e) for e in turns] for row in rows]
        cut = f"{k}_{rows[0].joint}"
        determinant = let(f"detG_{cut}", jacobian[0][0] * jacobian[1][1] - jacobian[0][1] * jacobian[1][0])
        reciprocal = let(f"idetG_{cut}", 1 / determinant)
        inverse = (
            (let(f"iG_{cut}_xx", jacobian[1][1] * reciprocal), -let(f"iG_{cut}_xy", jacobian[0][1] * reciprocal)),
            (-let(f"iG_{cut}_yx", jacobian[1][0] * reciprocal), let(f"iG_{cut}_yy", jacobian[0][0] * reciprocal)),
        )
        rest = [v for v in form.variables if v not in block]
        gains, constant = {}, {}
        for v in rest:
            column = (form.h(rows[0], v), form.h(rows[1], v))
            if column != (0, 0):
                for e, line in zip(turns, inverse, strict=True):
                    gains[e, v] = let(gain_name(self.link, e, v), dot(line, column))
        for impact in (FLIGHT, IMPACT):
            right = (form.l(impact, rows[0]), form.l(impact, rows[1]))
            for e, line in zip(turns, inverse, strict=True):
                constant[impact, e] = let(gain_name(self.link, e, None, impact), dot(line, right))
        slopes = {(e, v): form.h(e, v) for e in turns for v in (*rest, *turns) if form.h(e, v) != 0}
        at_rest = {(i, e): form.l(i, e) for i in (FLIGHT, IMPACT) for e in turns}
        self._substitute_dyad(turns, rest, gains, constant)
        self._forget(block)
        dyad = Dyad(inverse, slopes, at_rest)
        return Solution(self.link, block, gains, constant, determinant**2, scale, dyad)

    def _substitute_dyad(
        self,
        turns: tuple[Variable, ...],
        rest: list[Variable],
        gains: dict[tuple[Variable, Variable], sp.Expr],
        constant: dict[tuple[bool, Variable], sp.Expr],
    ) -> None:
        """Eq. 4.16: with α = −(Â z + d̂), H −= H_zα Â + Âᵀ (H_αz − D Â) and l −= H_zα d̂ + Âᵀ (l_α − D d̂)."""
        form, let = self.form, self.ledger.let
        moved = {}
        for e in turns:
            for v in rest:
                taken = sp.Add(*(form.h(e, f) * gains[f, v] for f in turns if (f, v) in gains))
                factor = sign(v)
                value = factor * let(f"Q{gain_name(self.link, e, v)}", factor * (form.h(e, v) - taken))
                if value != 0:
                    moved[e, v] = value
        for i, v in enumerate(rest):
            for w in rest[i:]:
                terms = [form.h(e, v) * gains[e, w] for e in turns if (e, w) in gains]
                terms += [gains[e, v] * moved[e, w] for e in turns if (e, v) in gains and (e, w) in moved]
                if terms:
                    form.add_h(v, w, -sp.Add(*terms))
        for impact in (FLIGHT, IMPACT):
            left = {}
            for e in turns:
                taken = sp.Add(*(form.h(e, f) * constant[impact, f] for f in turns))
                left[e] = let(f"Q{gain_name(self.link, e, None, impact)}", form.l(impact, e) - taken)
            for v in rest:
                terms = [form.h(e, v) * constant[impact, e] for e in turns]
                terms += [gains[e, v] * left[e] for e in turns if (e, v) in gains]
                if any(term != 0 for term in terms):
                    form.add_l(impact, v, -sp.Add(*terms))

    def _show(self, block: tuple[Variable, ...]) -> None:
        """The equations that are being solved, in flight and in impact, for the reader of the listing."""
        for impact in (FLIGHT, IMPACT):
            for e in block:
                unknowns = {v: sp.Symbol(solution_name(self.link, v, impact)) for v in self.form.variables}
                terms = [self.form.h(e, v) * unknown for v, unknown in unknowns.items()]
                self.ledger.remark(unknowns[e], sp.Add(*terms, self.form.l(impact, e)))

    def _substitute(
        self,
        block: tuple[Variable, ...],
        touched: list[Variable],
        gains: dict[tuple[Variable, Variable], sp.Expr],
        constant: dict[tuple[bool, Variable], sp.Expr],
    ) -> None:
        """H_vw −= H_ve H_ee⁻¹ H_ew and l_v −= H_ve H_ee⁻¹ l_e."""
        form = self.form
        for i, v in enumerate(touched):
            for w in touched[i:]:
                form.add_h(v, w, -sp.Add(*(form.h(e, v) * gains[e, w] for e in block)))
            for impact in (FLIGHT, IMPACT):
                form.add_l(impact, v, -sp.Add(*(form.h(e, v) * constant[impact, e] for e in block)))
        self._forget(block)

    def _forget(self, block: tuple[Variable, ...]) -> None:
        """Leave the eliminated variables out of the form, and what has become zero."""
        form = self.form
        form.variables = [v for v in form.variables if v not in block]
        form.hessian = {key: x for key, x in form.hessian.items() if not set(key) & set(block) and x != 0}
        form.linear = {
            i: {v: x for v, x in part.items() if v not in block and x != 0} for i, part in form.linear.items()
        }

    def _inverse(self, block: tuple[Variable, ...]) -> tuple[list[list[sp.Expr]], sp.Expr | None]:
        """H_ee⁻¹: a reciprocal, or the adjugate over the determinant of a 2 × 2 block.

        Closure rows that nothing behind them moves have none. Their guard always fails, and the runtime solves for
        them on the way of section 8.
        """
        h, let = self.form.h, self.ledger.let
        closes = block[0].kind == "lambda"
        if len(block) == 1:
            (e,) = block
            pivot = sign(e, e) * h(e, e)
            if closes and pivot == 0:
                return [[sp.S.Zero]], sp.S.Zero
            inverse = sign(e, e) * let(f"i{hessian_name(self.link, e, e)}", 1 / pivot)
            return [[inverse]], pivot if closes else None
        e, f = block
        factor = sign(e, f)
        xx, xy, yy = factor * h(e, e), factor * h(e, f), factor * h(f, f)
        kind, label = hessian_name(self.link, e, f).rsplit("_", 1)[0].split("_", 1)
        determinant = let(f"det{kind}_{label}", xx * yy - xy**2)
        if closes and determinant == 0:
            return [[sp.S.Zero] * 2] * 2, sp.S.Zero
        reciprocal = let(f"idet{kind}_{label}", 1 / determinant)
        i_xx = let(f"i{kind}_{label}_xx", yy * reciprocal)
        i_xy = let(f"i{kind}_{label}_xy", xy * reciprocal)
        i_yy = let(f"i{kind}_{label}_yy", xx * reciprocal)
        return [[factor * i_xx, -factor * i_xy], [-factor * i_xy, factor * i_yy]], determinant
