"""What ``ccgen run`` remarks on runs that are right: friction that creeps, redundant rows."""

from __future__ import annotations

import math
from typing import Any

import pytest

from ccgen.generator import loop
from ccgen.generator.cli.remarks import print_remarks
from ccgen.generator.scene import read_tables
from ccgen.runtime import simulate

from ..support.drawn_linkages import cranks, four_bar
from ..support.workshop import Workshop

T, RATE, SECONDS = 2.0, 0.01, 3.0


def wheel(moment: float, **friction: Any) -> dict[str, Any]:
    """A wheel of 0.01 kg m2 that a constant moment turns against dry friction."""
    return {
        "ground_link": {"points": {"O": [0, 0]}},
        "link": [{"name": "wheel", "mass": 1, "inertia": 0.01, "com": [0, 0], "points": {"O": [0, 0]}}],
        "joint": [{"name": "hinge", "between": ["ground.O", "wheel.O"]}],
        "torque": [{"link": "wheel", "torque": moment}],
        **friction,
    }


def sledge(force: float) -> dict[str, Any]:
    """A sledge of 10 g on a line, with the same friction in newtons."""
    return {
        "ground_link": {"points": {"O": [0, 0]}},
        "link": [{"name": "sledge", "mass": 0.01, "inertia": 0.01, "com": [0, 0], "points": {"O": [0, 0]}}],
        "joint": [{"name": "hinge", "type": "prismatic", "between": ["ground.O", "sledge.O"], "axis": [1, 0]}],
        "force": [{"point": "sledge.O", "vector": [force, 0]}],
        "joint_friction": [{"dry": T}],
    }


def remarks(tables: dict[str, Any], workshop: Workshop, capsys: pytest.CaptureFixture[str]) -> str:
    scene = read_tables(tables, "creeps", "creeps")
    run = simulate(workshop.model(scene), until=SECONDS, rtol=1e-7, method="radau")
    print_remarks(scene, run)
    return capsys.readouterr().err


@pytest.mark.parametrize("part", [0.02, 0.5, 0.9])
@pytest.mark.parametrize(
    ("friction", "of"),
    [
        ({"joint_friction": [{"dry": T}]}, "joint_friction_0"),
        ({"brake": [{"name": "clasp", "joint": "hinge", "torque": T, "rate": RATE}]}, "clasp"),
    ],
)
def test_a_joint_that_creeps_is_told(
    part: float, friction: dict[str, Any], of: str, workshop: Workshop, capsys: pytest.CaptureFixture[str]
) -> None:
    """Friction T tanh(w/w0) holds a part p of T at w = w0 artanh(p): beyond tanh 1 = 0.76 that is faster than w0."""
    told = remarks(wheel(part * T, **friction), workshop, capsys)
    if part > math.tanh(1.0):
        assert told == ""
        return
    far = math.degrees(RATE * math.atanh(part) * SECONDS)
    assert f"note: hinge creeps against the dry friction of {of}, slower than its rate of 0.01 rad/s" in told
    assert f"for 3 s of the run and by {far:.3g}° in all" in told and told.count("\n") == 1


def test_on_a_line_it_is_told_in_metres(workshop: Workshop, capsys: pytest.CaptureFixture[str]) -> None:
    told = remarks(sledge(0.5 * T), workshop, capsys)
    assert f"rate of 0.01 m/s for 3 s of the run and by {RATE * math.atanh(0.5) * SECONDS:.3g} m in all" in told


def test_of_a_pin_in_a_slot_the_way_along_it_is_told(workshop: Workshop, capsys: pytest.CaptureFixture[str]) -> None:
    """It turns too, which the friction along its line does not resist."""
    tables = sledge(0.5 * T)
    tables["joint"][0] |= {"type": "pin-in-slot"}
    told = remarks(tables, workshop, capsys)
    assert f"rate of 0.01 m/s for 3 s of the run and by {RATE * math.atanh(0.5) * SECONDS:.3g} m in all" in told


@pytest.mark.parametrize(
    "friction",
    [
        {"joint_friction": [{"dry": T, "viscous": 0.5}]},
        {"joint_friction": [{"name": "grease", "dry": T}]},
        {"brake": [{"name": "clasp", "joint": "hinge", "KEY": T}]},
    ],
    ids=["viscous", "named", "brake"],
)
@pytest.mark.parametrize("tables", [wheel(1.0), sledge(1.0)], ids=["turns", "slides"])
def test_effects_say_what_tells_their_friction(
    tables: dict[str, Any], friction: dict[str, Any], workshop: Workshop
) -> None:
    """Less what is viscous, that is T tanh(w/w0) at any rate w."""
    slides = "force" in tables
    rows = {key: [{("force" if slides else "torque") if k == "KEY" else k: x for k, x in row.items()} for row in of]
            for key, of in friction.items()}  # fmt: skip
    scene = read_tables({key: x for key, x in tables.items() if key != "joint_friction"} | rows, "rubs", "rubs")
    (effect, rub), = [(effect, rub) for effect in scene.effects for rub in effect.rubs(scene.mechanism)]  # fmt: skip
    model, rate = workshop.model(scene), rub.rate.value
    run = simulate(model, u0=[0.7 * rate], until=0.0)
    viscous = rub.viscous.value * 0.7 * rate if rub.viscous else 0.0
    assert -run[f"{effect.title}.{rub.told}"][0] - viscous == pytest.approx(T * math.tanh(0.7), rel=1e-12)


@pytest.mark.parametrize(
    ("moment", "start"),
    [(0.005 * T, {}), (0.0, {}), (1.5 * T, {}), (0.0, {"angular_velocities": {"wheel": 3.0}})],
    ids=["hardly loaded", "not loaded", "slides", "comes to rest"],
)
def test_what_holds_no_load_is_not_told(
    moment: float, start: dict[str, Any], workshop: Workshop, capsys: pytest.CaptureFixture[str]
) -> None:
    tables = wheel(moment or 1e-9, joint_friction=[{"dry": T}], start=start)
    assert remarks(tables, workshop, capsys) == ""


@pytest.mark.parametrize(
    "friction",
    [
        {"brake": [{"joint": "hinge", "torque": T, "rate": RATE, "begins": 2.0 * SECONDS}]},
        {"brake": [{"joint": "hinge", "torque": T, "rate": RATE, "ends": 1e-3}]},
        {"brake": [{"joint": "hinge", "torque": "-2 + 0*t", "rate": RATE}]},
        {"brake": [{"joint": "hinge", "torque": 0.0, "rate": RATE}]},
        {"joint_friction": [{"dry": 0.0, "viscous": 1e-6}]},
    ],
    ids=["not yet", "no more", "less than none", "none", "viscous"],
)
def test_what_does_not_act_is_not_told(
    friction: dict[str, Any], workshop: Workshop, capsys: pytest.CaptureFixture[str]
) -> None:
    """The wheel turns on more slowly than the rate of a friction that is not there."""
    tables = wheel(1e-9, start={"angular_velocities": {"wheel": 0.4 * RATE}}, **friction)
    assert remarks(tables, workshop, capsys) == ""


def test_evaluations_that_are_all_dense_are_told(workshop: Workshop, capsys: pytest.CaptureFixture[str]) -> None:
    """Of three parallel cranks one is redundant wherever they stand. A four-bar has none, and a parallelogram that
    starts flat one at its start alone."""
    scene = cranks([1.0] * 3, [1.1] * 3 + [0.0])
    run = simulate(workshop.model(scene), until=0.1)
    print_remarks(scene, run)
    told = capsys.readouterr().err
    assert told.startswith(f"note: 1 of {len(run.model.rows)} closure rows follow from the others all along the run")
    assert f"all of its {run.nfev} evaluations went by the dense solution" in told
    for other in (
        four_bar({"angles": {"crank": 1.0}}),
        loop(4, start={"angles": [0.0, 0.0, math.pi, math.pi], "angular_velocities": [1.0, 0.0, 1.0, 0.0]}),
    ):
        print_remarks(other, simulate(workshop.model(other), until=0.1))
        assert capsys.readouterr().err == ""
