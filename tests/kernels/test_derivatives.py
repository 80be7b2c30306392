"""Derivatives of a model's functions: against differences in wide numbers, and refused where they are none."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings

from ..oracles.random_mechanisms import Sketch
from ..support.derivative_checks import check_derivatives
from ..support.effect_examples import CONTACTS, EXAMPLES, LOADS, SCENE
from ..support.folders import ROOT
from ..support.random_mechanism_checks import DRAWN, FEW, first
from ..support.random_mechanism_checks import EXAMPLES as COUNT
from ..support.workshop import Workshop
from .test_random_mechanisms import sketches

SCENES = ROOT / "scenes"


def both(workshop: Workshop, text: str) -> tuple[Any, Any]:
    return workshop.model(text, derivatives=True), workshop.model(text, "wide")


def near_start(model: Any, seed: int = 0, away: float = 0.05) -> tuple[Any, Any]:
    """A state off the closure: functions have derivatives there as well."""
    rng = np.random.default_rng(seed)
    q, u = model.start()
    return q + rng.normal(scale=away, size=q.shape), u + rng.normal(size=u.shape)


@pytest.mark.sample(2)
@pytest.mark.parametrize("scene", ["four-bar", "falling-hexagon", "jansen-driven", "planetary"])
def test_derivatives_are_those_of_differences(scene: str, workshop: Workshop) -> None:
    model, wide = both(workshop, (SCENES / f"{scene}.toml").read_text())
    check_derivatives(model, wide, *near_start(model))


@pytest.mark.hard
def test_loads_of_every_effect_have_derivatives(workshop: Workshop) -> None:
    """With a driven joint, gears, a rack and a belt, inputs and formulas of time."""
    loads = {key: text for key, text in LOADS.items() if "joint_1" not in text}
    text = SCENE + "".join(loads.values()) + EXAMPLES["gravity"] + EXAMPLES["drive"] + EXAMPLES["gear"]
    model, wide = both(workshop, text)
    check_derivatives(model, wide, *near_start(model))


@pytest.mark.sample(1)
@pytest.mark.parametrize("kind", CONTACTS)
def test_gaps_of_every_contact_have_derivatives(kind: str, workshop: Workshop) -> None:
    model, wide = both(workshop, SCENE + EXAMPLES[kind])
    check_derivatives(model, wide, *near_start(model), of=("gaps", "gap_rates", "acceleration"))


PENDULUMS = """
name = "pendulums"
[ground_link]
points = { O = [0, 0], P = [1, 0] }
[[link]]
name = "first"
rod = { mass = 1 }
points = { A = [0, 0], B = [1, 0] }
[[link]]
name = "second"
rod = { mass = 2 }
points = { A = [0, 0], B = [0.5, 0] }
[[link]]
name = "third"
rod = { mass = 3 }
points = { A = [0, 0], B = [0.7, 0] }
[[joint]]
between = ["ground.O", "first.A"]
[[joint]]
between = ["ground.P", "second.A"]
[[joint]]
between = ["second.B", "third.A"]
[gravity]
[start.angles]
first = "-60 deg"
second = "20 deg"
third = "50 deg"
"""


def test_what_reads_some_of_the_angles_has_their_cosines(workshop: Workshop) -> None:
    """What derivatives of accelerations are made of is given the same ones: the solution reads none of the first."""
    model, wide = both(workshop, PENDULUMS)
    assert model.folder is not None and "c = at->cs + 1;" in (model.folder / "derivatives.c").read_text()
    check_derivatives(model, wide, *near_start(model), of=("acceleration",))


@settings(DRAWN, max_examples=FEW // 5)
@given(sketch=sketches(meshes=True))
def test_random_mechanisms_have_derivatives(sketch: Sketch, workshop: Workshop) -> None:
    check_sketch(sketch, workshop)


@pytest.mark.hard
@settings(DRAWN, max_examples=COUNT)
@given(sketch=sketches())
@first(6)
def test_many_random_mechanisms_have_derivatives(sketch: Sketch, workshop: Workshop) -> None:
    check_sketch(sketch, workshop)


def check_sketch(sketch: Sketch, workshop: Workshop) -> None:
    """Where rows depend on each other, along motions; else by all there is.

    What effects hold is held in derivatives, but set anew at every state of a difference: such sketches are left out.
    """
    model, wide = both(workshop, sketch.toml("random-mechanism"))
    if model.kernels.sizes["latches"]:
        return
    q, _ = model.state_from_poses(sketch.poses, np.zeros_like(sketch.poses))
    rng = np.random.default_rng(7)
    motions = model.motions(q)
    u = motions @ rng.normal(size=motions.shape[1])
    if len(q) - motions.shape[1] < len(model.rows) + len(model.data["drives"]):
        check_along_motions(model, wide, q, u)
    else:
        check_derivatives(model, wide, q, u, of=("acceleration", "multipliers", "energy"))


def check_along_motions(model: Any, wide: Any, q: Any, u: Any) -> None:
    """By the rates, along motions: those that keep the loops' rates zero."""
    motions = model.motions(q)
    found = model.derivatives("acceleration", q, u, 0.3, wrt={"u": motions}, contacts=())
    h = 2.0**-10
    for k, direction in enumerate(motions.T):
        sides = [wide.acceleration(q, u + s * h * direction, 0.3, contacts=()) for s in (1, -1)]
        wanted = (sides[0] - sides[1]) / (2 * h)
        scale = max(float(np.max(np.abs(found))), 1.0)
        assert np.max(np.abs(found[:, k] - wanted)) <= 1e-6 * scale


# -- one state or many, one direction or many ------------------------------------------------------------------------


def test_a_batch_has_those_of_each_state(workshop: Workshop) -> None:
    model = workshop.model((SCENES / "four-bar.toml").read_text(), derivatives=True)
    states = [near_start(model, seed) for seed in range(5)]
    q, u = (np.array(part) for part in zip(*states, strict=True))
    t = np.linspace(0.0, 1.0, 5)
    for of in ("acceleration", "reactions", "energy"):
        found = model.derivatives(of, q, u, t, wrt=("u", "q", "crank.mass"))
        for i in range(5):
            one = model.derivatives(of, q[i], u[i], t[i], wrt=("u", "q", "crank.mass"))
            assert found[i] == pytest.approx(one, rel=1e-12, abs=1e-12 * np.abs(one).max())


def test_along_a_direction_it_is_the_matrix_times_that(workshop: Workshop) -> None:
    model = workshop.model((SCENES / "four-bar.toml").read_text(), derivatives=True)
    q, u = near_start(model)
    rng = np.random.default_rng(1)
    by = {"q": rng.normal(size=(3, 11)), "u": rng.normal(size=(3, 11)), "coupler.inertia": rng.normal(size=11)}
    whole = model.acceleration_jacobian(q, u, wrt=("q", "u", "coupler.inertia"))
    wanted = whole @ np.vstack([by["q"], by["u"], by["coupler.inertia"]])
    assert model.acceleration_jacobian(q, u, wrt=by) == pytest.approx(wanted, rel=1e-11, abs=1e-11)


def test_columns_come_as_they_are_asked_for(workshop: Workshop) -> None:
    model = workshop.model((SCENES / "four-bar.toml").read_text(), derivatives=True)
    q, u = near_start(model)
    both_ = model.acceleration_jacobian(q, u)
    assert model.acceleration_jacobian(q, u, wrt=("u", "q", "u")) == pytest.approx(
        np.hstack([both_[:, 3:], both_[:, :3], both_[:, 3:]]), rel=1e-13
    )
    assert model.acceleration_jacobian(q, u, wrt=()).shape == (3, 0)


# -- what is refused ---------------------------------------------------------------------------------------------------


def test_a_model_without_derivatives_says_how_to_get_them(workshop: Workshop) -> None:
    model = workshop.model((SCENES / "four-bar.toml").read_text())
    with pytest.raises(ValueError, match=r"generate\(scene, derivatives=True\)"):
        model.acceleration_jacobian(*model.start())


def test_names_that_are_none_are_all_said(workshop: Workshop) -> None:
    model = workshop.model((SCENES / "four-bar.toml").read_text(), derivatives=True)
    with pytest.raises(Exception, match=r"(?s)crank\.mas.*wheel") as raised:
        model.acceleration_jacobian(*model.start(), wrt=("crank.mas", "wheel.mass"))
    assert isinstance(raised.value, KeyError)
    with pytest.raises(ValueError, match="expected one of acceleration"):
        model.derivatives("weight", *model.start())
    with pytest.raises(ValueError, match=r"expected \(3, directions\)"):
        model.acceleration_jacobian(*model.start(), wrt={"q": np.ones((2, 4))})
    with pytest.raises(ValueError, match="as many of each"):
        model.acceleration_jacobian(*model.start(), wrt={"q": np.ones((3, 4)), "u": np.ones((3, 2))})


RHOMBUS = """
name = "rhombus"
[ground_link]
points = { O = [0, 0], Q = [1, 0], R = [2, 0] }
[[link]]
name = "a"
rod = { mass = 1 }
points = { A = [0, 0], B = [1, 0] }
[[link]]
name = "b"
rod = { mass = 1 }
points = { A = [0, 0], B = [1, 0] }
[[link]]
name = "c"
rod = { mass = 1, between = ["A", "C"] }
points = { A = [0, 0], B = [1, 0], C = [LENGTH, 0] }
[[joint]]
between = ["ground.O", "a.A"]
[[joint]]
between = ["ground.Q", "b.A"]
[[joint]]
between = ["a.B", "c.A"]
[[joint]]
between = ["b.B", "c.B"]
EXTRA
[start]
angles = { a = START, b = START, c = 0 }
[gravity]
"""


def test_in_a_singular_configuration_there_are_none(workshop: Workshop) -> None:
    """A parallelogram that is flat; near it there are."""
    text = RHOMBUS.replace("LENGTH", "1").replace("START", '"60 deg"').replace("EXTRA", "")
    model, wide = both(workshop, text)
    flat = np.zeros(3)
    with pytest.raises(ValueError, match="singular configuration"):
        model.acceleration_jacobian(flat, np.zeros(3))
    check_derivatives(model, wide, model.assemble(np.array([1e-3, 1e-3, 0.0])), np.zeros(3), of=("energy",))


def test_redundant_joints_have_those_along_motions(workshop: Workshop) -> None:
    """A third rod that the parallelogram does not need: closed form of one degree of freedom, all rods of 1 kg and 1 m.

    The rods have 3 · 1/3 kg m², the coupler's 1 kg goes round at 1 m: with gravity the angle has φ'' = −g cos φ · k.
    """
    extra = """
[[link]]
name = "d"
rod = { mass = 1 }
points = { A = [0, 0], B = [1, 0] }
[[joint]]
between = ["ground.R", "d.A"]
[[joint]]
between = ["d.B", "c.C"]
"""
    text = RHOMBUS.replace("LENGTH", "2").replace("START", '"60 deg"').replace("EXTRA", extra)
    model = workshop.model(text.replace("c = 0 }", 'c = 0, d = "60 deg" }'), derivatives=True)
    q, _ = model.start()
    motions = model.motions(q)
    assert motions.shape == (len(q), 1)
    one = motions[:, 0] / motions[0, 0]
    phi, g = q[0], 9.81
    factor = g * (3 * 0.5 + 1.0) / (3 * (1.0 / 3.0) + 1.0)
    along = model.acceleration_jacobian(q, np.zeros(len(q)), wrt={"q": one[:, None]})[:, 0]
    assert along[0] == pytest.approx(factor * np.sin(phi), rel=1e-10)
    with pytest.raises(ValueError, match="open loops which redundant joints close"):
        model.acceleration_jacobian(q, np.zeros(len(q)))
    with pytest.raises(ValueError, match="least norm"):
        model.derivatives("multipliers", q, np.zeros(len(q)), wrt={"q": one[:, None]})


def test_a_closed_contact_is_told(workshop: Workshop) -> None:
    model = workshop.model(
        'name = "pressed"\n[chain]\nlinks = 1\nhinged = true\nlength = 1.0\nmass = 1.0\ninertia = 0.1\n[gravity]\n'
        "[[ground]]\npoint = [0, 0]\nrestitution = 0.5\n[start]\nangles = { link_0 = 0 }\n",
        derivatives=True,
    )
    q, u = model.start()
    with pytest.raises(ValueError, match="closed contact"):
        model.acceleration_jacobian(q, u)
    assert np.all(np.isfinite(model.acceleration_jacobian(q, u, contacts=())))
    assert np.all(np.isfinite(model.derivatives("gaps", q, u)))
