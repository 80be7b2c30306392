"""The closed form with effects: generalized forces against the recursion and against inverse dynamics."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp

from ccgen.generator.documents.show import show_text
from ccgen.generator.pipeline import listing
from ccgen.generator.program.reading import Listing, read_listing

from ..support.closed_forms import LINKS, closed_form, put_in
from ..support.effect_examples import EXAMPLES, LOADS, MESHES
from ..support.tiers import all_hard_but
from ..support.workshop import Workshop


def _acting(form: str) -> str:
    """Every effect but drives and meshes, which hold a chain; a floating loop is loaded between its own points."""
    ground, joint = ("ground.O", "joint_0") if form != "loop" else ("link_0.A", "joint_3")
    text = "".join(table for key, table in EXAMPLES.items() if key not in ("drive", *MESHES))
    text = text.replace('"ground.O", "link_2.B"', f'"{ground}", "link_2.B"').replace('"joint_0"', f'"{joint}"')
    text += '[[input]]\nname = "push"\npoint = "link_1.B"\ndirection = [3, 4]\n'
    return text + '[[drag]]\npoint = "link_1.B"\nlinear = 2\n'


@pytest.mark.parametrize("form", all_hard_but(of=LINKS))
def test_the_closed_form_with_every_effect_moves_as_the_recursion(form: str, workshop: Workshop) -> None:
    """M u̇ + h = Q + Aᵀλ, A u̇ + Ȧ u = 0, solved densely at random states, against the accelerations of the listing."""
    scene = workshop.scene(LINKS[form] + _acting(form))
    shape, read = closed_form(scene), read_listing(listing(scene))
    assert shape.Q is not None
    values = {sp.Symbol(name): value for name, value in read.parameters.items()}
    matrices = [shape.M, shape.h, shape.Q, shape.A, shape.A_rate]
    rng = np.random.default_rng(8)
    nu, rows = len(shape.state.u), len(shape.multipliers)
    for _ in range(4):
        q, u, inputs = rng.uniform(-2, 2, nu), rng.uniform(-2, 2, nu), rng.uniform(-2, 2, len(_inputs(read)))
        data = values | dict(zip([*shape.state.q, *shape.state.u], [*q, *u], strict=True))
        data |= {sp.Symbol("t"): 0.37, **dict(zip(map(sp.Symbol, _inputs(read)), inputs, strict=True))}
        put_in(data, shape.forces)
        m, h, loads, a, bias = (np.array(part.xreplace(data), dtype=float) for part in matrices)
        kkt = np.block([[m, -a.T], [a, np.zeros((rows, rows))]])
        wanted = np.linalg.solve(kkt, np.concatenate([(loads - h).ravel(), -bias.ravel()]))
        given = {"q": q, "u": u, "t": np.array([0.37]), "inputs": inputs}
        found = read.evaluate("acceleration", given)
        both = np.concatenate([found["u_dot"], found["lambda"] if rows else []])
        assert both == pytest.approx(wanted, rel=1e-11, abs=1e-11 * float(np.max(np.abs(wanted))))


@pytest.mark.sample(4)
@pytest.mark.parametrize("key", LOADS)
def test_each_effect_has_its_generalized_forces(key: str, workshop: Workshop) -> None:
    """Q is the force that the inverse dynamics of the scene without the effect lack."""
    scene, bare = workshop.scene(LINKS["hinged"] + EXAMPLES[key]), workshop.scene(LINKS["hinged"])
    form, with_, without = closed_form(scene), read_listing(listing(scene)), read_listing(listing(bare))
    assert closed_form(bare).Q is None and form.Q is not None
    q, u, rates = np.array([[0.3, -0.8, 1.9], [0.7, 1.1, -0.4], [2.0, 1.0, -3.0]])
    given = {"q": q, "u": u, "t": np.array([0.37]), "inputs": np.full(len(_inputs(with_)), 1.7), "u_dot": rates}
    wanted = without.evaluate("inverse_dynamics", given | {"inputs": np.zeros(0)})["f"]
    wanted = wanted - with_.evaluate("inverse_dynamics", given)["f"]
    data = {sp.Symbol(name): value for name, value in with_.parameters.items()} | {sp.Symbol("t"): 0.37}
    data |= dict(zip([*form.state.q, *form.state.u], [*q, *u], strict=True))
    data |= {sp.Symbol(name): 1.7 for name in _inputs(with_)}
    put_in(data, form.forces)
    found = np.array(form.Q.xreplace(data), dtype=float).ravel()
    assert np.max(np.abs(wanted)) > 1e-3
    assert found == pytest.approx(wanted, rel=1e-12, abs=1e-12)


def _inputs(read: Listing) -> list[str]:
    return read.kernels["acceleration"].inputs["inputs"]


def test_a_torsional_spring_is_written_as_a_person_would(workshop: Workshop) -> None:
    spring = '[[torsion]]\njoint = "joint_0"\nstiffness = 2\ndamping = 1\n'
    scene = workshop.scene('name = "x"\n[chain]\nlinks = 1\nhinged = true\n' + spring)
    text = show_text(scene, False, True)
    for line in (
        "[flight: M u_dot + h = Q]\n",
        "M[w_0, w_0] = I_0 + m_0*c_0_x**2\n",
        "moment_torsion_0 = c_torsion_0*w_0 + k_torsion_0*theta_0\n",
        "Q[w_0] = -moment_torsion_0",
    ):
        assert line in text
