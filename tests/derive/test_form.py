"""The quadratic form V: new variables in the place of others, against SᵀHS and Sᵀ(l + H z₀) in numbers."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp

from ccgen.generator.derive.form import FLIGHT, IMPACT, Form, Substitution, carried
from ccgen.generator.equations.names import A_X, A_Y, ALPHA, SLIDE, Variable, multiplier, turn

OPEN = [multiplier(3, "x"), multiplier(3, "y"), turn(7)]


def random_form(variables: list[Variable], rng: np.random.Generator, even: bool = False) -> Form:
    form = Form(list(variables))
    for i, v in enumerate(variables):
        for w in variables[i:]:
            form.add_h(v, w, sp.Float(rng.normal()))
        for impact in (FLIGHT, IMPACT):
            form.add_l(impact, v, sp.Float(rng.normal()))
    if even:
        form.hessian[A_X, A_Y], form.hessian[A_Y, A_Y] = sp.S.Zero, form.hessian[A_X, A_X]
    return form


def numbers(form: Form, variables: list[Variable]) -> tuple[np.ndarray, dict[bool, np.ndarray]]:
    hessian = np.array([[float(form.h(v, w)) for w in variables] for v in variables])
    return hessian, {i: np.array([float(form.l(i, v)) for v in variables]) for i in (FLIGHT, IMPACT)}


SUBSTITUTIONS = {
    "pin": Substitution(carried((0.3, -0.7)), {A_X: sp.Float(0.4), A_Y: sp.Float(-1.1)}),
    "follows": Substitution(carried((0.3, -0.7)) | {ALPHA: {ALPHA: sp.S.One}}, {A_X: sp.Float(0.4)}),
    "driven": Substitution(
        carried((0.3, -0.7)) | {ALPHA: {ALPHA: sp.S.One}}, {A_Y: sp.Float(0.4), ALPHA: sp.Float(2.5)}
    ),
    "on the ground": Substitution({A_X: {}, A_Y: {}, ALPHA: {}}, {A_X: sp.Float(0.4), ALPHA: sp.Float(0.9)}),
    "slide": Substitution(
        carried((0.3, -0.7), {SLIDE: (sp.Float(0.6), sp.Float(0.8))}) | {ALPHA: {ALPHA: sp.S.One}}, directions=(SLIDE,)
    ),
}


@pytest.mark.parametrize("even", [False, True])
@pytest.mark.parametrize("name", SUBSTITUTIONS)
def test_substitution_is_the_congruence(name: str, even: bool) -> None:
    by, rng = SUBSTITUTIONS[name], np.random.default_rng(2)
    old = [A_X, A_Y, *([ALPHA] if ALPHA in by.rows else []), *OPEN]
    form = random_form(old, rng, even)
    new = sorted({w for row in by.rows.values() for w in row} | set(OPEN))
    T = np.array([[float(by.rows.get(v, {v: sp.S.One}).get(w, 0)) for w in new] for v in old])
    t = np.array([float(by.constant.get(v, 0)) for v in old])
    hessian, linear = numbers(form, old)
    found = form.substitute(by)
    assert set(found.variables) == set(new)
    changed, moved = numbers(found, new)
    np.testing.assert_allclose(changed, T.T @ hessian @ T, rtol=1e-13, atol=1e-14)
    np.testing.assert_allclose(moved[FLIGHT], T.T @ (linear[FLIGHT] + hessian @ t), rtol=1e-13, atol=1e-14)
    np.testing.assert_allclose(moved[IMPACT], T.T @ linear[IMPACT], rtol=1e-13, atol=1e-14)


def test_names_are_asked_for_where_entries_are_used_again() -> None:
    form, asked = random_form([A_X, A_Y, *OPEN], np.random.default_rng(3)), []

    def let(new: Variable | None, v: Variable, value: sp.Expr) -> sp.Expr:
        asked.append((new, v))
        return value

    form.substitute(SUBSTITUTIONS["pin"], let)
    assert {(None, A_X), (None, A_Y), (ALPHA, A_X), (ALPHA, A_Y)} <= set(asked)
    assert all(v in (A_X, A_Y) for _, v in asked)
