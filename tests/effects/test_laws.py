"""Loads that are expressions of the state, and laws: against closed forms, built-in effects and controllers."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline, PchipInterpolator
from scipy.special import ellipk

from ccgen.generator.cli.known_outputs import possible_outputs
from ccgen.generator.documents.show import show_text
from ccgen.generator.pipeline import listing
from ccgen.generator.scene import load_scene
from ccgen.runtime import Model, linearise, simulate

from ..support.folders import ROOT
from ..support.workshop import Workshop

PENDULUM = """
name = "pendulum"
[ground_link]
points = { O = [0, 0] }
[[link]]
name = "rod"
rod = { mass = 1.2 }
points = { A = [0, 0], B = [0.8, 0] }
[[joint]]
name = "hip"
between = ["ground.O", "rod.A"]
[gravity]
[start]
angles = { rod = -0.4 }
angular_velocities = { rod = 1.1 }
[run]
until = 3
rtol = 1e-11
"""
PD = """
[[law]]
name = "lift"
value = "-kp*(angle(hip) - 0.3) - kd*rate(hip)"
parameters = { kp = 30.0, kd = 2.0 }
unit = "N m"
[[motor]]
joint = "hip"
torque = "lift"
"""
MASS = """
name = "mass"
[ground_link]
points = { O = [0, 0] }
[[link]]
name = "mass"
mass = 1.0
inertia = 0.01
com = [0, 0]
points = { c = [0, 0] }
[[joint]]
name = "guide"
type = "prismatic"
between = ["ground.O", "mass.c"]
axis = [1, 0]
[run]
rtol = 1e-12
"""
ROUNDING = 1e-13


def accelerations(model: Model, count: int = 20) -> Any:
    """At states drawn alike for every model."""
    random = np.random.default_rng(7)
    q, u = (random.uniform(-1.5, 1.5, (count, len(model.q_names))) for _ in "qu")
    return np.array([model.acceleration(one, rate) for one, rate in zip(q, u, strict=True)])


def alike(workshop: Workshop, text: str, law: str, effect: str) -> None:
    """What a law does and what an effect does is the same, to rounding."""
    by_law, by_effect = (accelerations(workshop.model(text + more)) for more in (law, effect))
    assert np.abs(by_law - by_effect).max() <= ROUNDING * np.abs(by_effect).max()


# -- the same as built-in effects -------------------------------------------------------------------------------------

ARM = PENDULUM.replace(
    '[[joint]]\nname = "hip"',
    '[[link]]\nname = "fore"\nrod = { mass = 0.7 }\npoints = { A = [0, 0], B = [0.5, 0] }\n[[joint]]\nname = "knee"\n'
    'between = ["rod.B", "fore.A"]\n[[joint]]\nname = "hip"',
)
"""With a second link."""


@pytest.mark.parametrize(
    ("law", "effect"),
    [
        (
            '[[motor]]\njoint = "knee"\ntorque = "-3*(angle(knee) - 0.2) - 0.4*rate(knee)"\n',
            '[[torsion]]\njoint = "knee"\nstiffness = 3\nangle = 0.2\ndamping = 0.4\n',
        ),
        (
            '[[force]]\npoint = "fore.B"\nvector = ["-0.7*vx(fore.B)", "-0.7*rate(y(fore.B))"]\n',
            '[[drag]]\npoint = "fore.B"\nlinear = 0.7\n',
        ),
        (
            '[[law]]\nname = "v"\nvalue = "sqrt(vx(fore.B)**2 + vy(fore.B)**2)"\n[[force]]\npoint = "fore.B"\n'
            'vector = ["-0.7*v*vx(fore.B)", "-0.7*v*vy(fore.B)"]\n',
            '[[drag]]\npoint = "fore.B"\nquadratic = 0.7\nspeed = 0\n',
        ),
        (
            '[[law]]\nname = "pull"\nvalue = "k*(distance(ground.O, fore.B) - 0.6) + 2*rate(distance(ground.O, fore.B))'
            '"\nparameters = { k = 9 }\n[[law]]\nname = "per"\nvalue = "-pull/distance(fore.B, ground.O)"\n'
            '[[force]]\npoint = "fore.B"\nvector = ["per*x(fore.B)", "per*y(fore.B)"]\n',
            '[[spring]]\nbetween = ["ground.O", "fore.B"]\nstiffness = 9\nlength = 0.6\n'
            '[[damper]]\nbetween = ["ground.O", "fore.B"]\ndamping = 2\n',
        ),
        (
            '[[torque]]\nlink = "fore"\ntorque = "-2*direction(fore) - rate(direction(fore))*0.3"\n',
            '[[input]]\nname = "m"\nlink = "fore"\n',
        ),
    ],
    ids=["torsion", "drag", "quadratic drag", "spring", "torque"],
)
def test_a_law_is_what_an_effect_is(law: str, effect: str, workshop: Workshop) -> None:
    if "input" not in effect:
        alike(workshop, ARM, law, effect)
        return
    by_law, by_input = workshop.model(ARM + law), workshop.model(ARM + effect)
    for q, u in np.random.default_rng(3).uniform(-1.5, 1.5, (9, 2, 2)):
        moment = -2 * q[list(by_law.q_names).index("theta_1")] - 0.3 * u[list(by_law.u_names).index("w_1")]
        expected = by_input.acceleration(q, u, inputs={"m": moment})
        assert by_law.acceleration(q, u) == pytest.approx(expected, rel=1e-13, abs=1e-13)


def test_a_force_along_a_line_is_a_spring(workshop: Workshop) -> None:
    law = '[[motor]]\njoint = "guide"\nforce = "-7*slide(guide) - 0.3*rate(guide)"\n'
    spring = '[[motor]]\njoint = "guide"\nposition = 0\nstiffness = 7\ndamping = 0.3\n'
    alike(workshop, MASS, law, spring)


def test_a_brake_presses_as_the_state_says(workshop: Workshop) -> None:
    """Where the effort is not positive it does not act."""
    model = workshop.model(MASS + '[[brake]]\njoint = "guide"\nforce = "3*slide(guide) - 0.6"\nrate = 0.1\n')
    for x, v in ((0.5, 0.2), (0.21, -0.3), (0.19, 0.4), (-1.0, 0.2)):
        force = -max(3 * x - 0.6, 0.0) * math.tanh(v / 0.1)
        assert model.acceleration([x], [v])[0] == pytest.approx(force, rel=1e-13, abs=1e-15)


# -- closed forms ------------------------------------------------------------------------------------------------------


def test_duffing_comes_back_after_its_period(workshop: Workshop) -> None:
    """x'' = -(x + a x³): the period is 4 K(m)/sqrt(1 + a A²) with m = a A²/(2 (1 + a A²))."""
    a, size = 0.7, 1.3
    model = workshop.model(
        MASS + '[[law]]\nname = "pull"\nvalue = "-(slide(guide) + a*slide(guide)**3)"\nparameters = { a = 0.7 }\n'
        '[[force]]\npoint = "mass.c"\nvector = ["pull", 0]\n[start]\nslides = { guide = 1.3 }\n'
    )
    stiff = 1 + a * size**2
    period = 4 * ellipk(a * size**2 / (2 * stiff)) / math.sqrt(stiff)
    run = simulate(model, until=5 * period)
    assert run.q[-1, 0] == pytest.approx(size, abs=1e-9)
    assert abs(run.u[-1, 0]) <= 1e-9 * size * stiff
    (q,), _ = run.at(period / 2)
    assert q == pytest.approx(-size, abs=1e-9)


def test_a_torque_speed_line_brings_a_shaft_to_its_speed(workshop: Workshop) -> None:
    """T = T0 (1 - ω/ω0) on an inertia I: ω = ω0 (1 - exp(-T0 t/(I ω0)))."""
    inertia, torque, idle = 0.5, 3.0, 20.0
    model = workshop.model(
        """
[ground_link]
points = { O = [0, 0] }
[[link]]
name = "rotor"
mass = 1
inertia = 0.5
com = [0, 0]
points = { C = [0, 0] }
[[joint]]
name = "axle"
between = ["ground.O", "rotor.C"]
[[motor]]
joint = "axle"
torque = "3*(1 - rate(axle)/20)"
[run]
rtol = 1e-12
"""
    )
    t = np.linspace(0, 10, 9)
    run = simulate(model, until=10.0)
    speed = run.values("axle.angular_velocity", t=t)["axle.angular_velocity"]
    assert speed == pytest.approx(idle * (1 - np.exp(-torque / (inertia * idle) * t)), rel=1e-10, abs=1e-10)


def test_eigenvalues_of_a_controlled_pendulum(workshop: Workshop) -> None:
    """Upright under kp, kd: J λ² + kd λ + kp - m g l/2 = 0."""
    text = PENDULUM + '[[law]]\nname = "hold"\nvalue = "-kp*(angle(hip) - pi/2) - kd*rate(hip)"\n'
    text += 'parameters = { kp = 30, kd = 2 }\n[[motor]]\njoint = "hip"\ntorque = "hold"\n'
    found = linearise(workshop.model(text, derivatives=True), [math.pi / 2])
    roots = np.roots([1.2 * 0.8**2 / 3, 2.0, 30.0 - 1.2 * 9.81 * 0.4])
    assert np.sort_complex(np.linalg.eigvals(found.A)) == pytest.approx(np.sort_complex(roots), rel=1e-12)


# -- the same as controllers in Python ---------------------------------------------------------------------------------


def test_a_controller_in_python_does_the_same(workshop: Workshop) -> None:
    model = workshop.model(PENDULUM + PD)
    given = workshop.model(PENDULUM + '[[input]]\nname = "push"\njoint = "hip"\n')
    compiled = simulate(model)
    asked = simulate(given, inputs=lambda t, q, u: [-30.0 * (q[0] - 0.3) - 2.0 * u[0]])
    assert asked.q[-1] == pytest.approx(compiled.q[-1], rel=1e-9)
    assert asked.u[-1] == pytest.approx(compiled.u[-1], rel=1e-8, abs=1e-9)


def test_what_a_law_gives_is_an_output(workshop: Workshop) -> None:
    run = simulate(workshop.model(PENDULUM + PD))
    expected = -30.0 * (run.q[:, 0] - 0.3) - 2.0 * run.u[:, 0]
    assert run.outputs["lift"] == "N m"
    assert run["lift"] == pytest.approx(expected, rel=1e-14, abs=1e-13)
    assert np.array_equal(run["lift"], run["motor_0.torque"])
    frame = run.to_dataframe(["lift"])
    assert frame.attrs["units"]["lift"] == "N m"


def test_work_of_a_law_is_booked(workshop: Workshop) -> None:
    """To rounding, also through kinks, and with power that goes in and out."""
    kinked = PD.replace('torque = "lift"', 'torque = "clip(lift, -4, 4)*min(1, 0.2 + abs(rate(hip)))"')
    spread = '[[force]]\npoint = "fore.B"\nvector = ["3*y(fore.B)", "t*x(rod.B)"]\n'
    for text in (PENDULUM + PD, PENDULUM + kinked, ARM + spread):
        run = simulate(workshop.model(text), rtol=1e-13)
        assert run.success and run.energy_drift < 2e-12
        assert np.ptp(run["energy"]) > 0.1


# -- kinks -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("expression", "reference"),
    [
        ("clip(-40*slide(guide), -3, 5)", lambda t, x, v: min(max(-40 * x, -3), 5)),
        ("-9*abs(slide(guide)) - 20*slide(guide)", lambda t, x, v: -9 * abs(x) - 20 * x),
        ("min(-5*slide(guide), 1 - 30*slide(guide), 2)", lambda t, x, v: min(-5 * x, 1 - 30 * x, 2)),
        ("max(-8*slide(guide), -2 - rate(guide)) + sin(3*t)", lambda t, x, v: max(-8 * x, -2 - v) + math.sin(3 * t)),
        ("-abs(min(4*slide(guide), 1) + 0.5) - 3*slide(guide)", lambda t, x, v: -abs(min(4 * x, 1) + 0.5) - 3 * x),
        ("min(t, 1)*max(-10*slide(guide), -6)", lambda t, x, v: min(t, 1) * max(-10 * x, -6)),
    ],
)
def test_kinks_are_where_steps_end(expression: str, reference: Any, workshop: Workshop) -> None:
    """Against another program's run in pieces so small that none of its kinks matters."""
    text = MASS + f'[[motor]]\njoint = "guide"\nforce = "{expression}"\n[start]\nslides = {{ guide = 0.4 }}\n'
    run = simulate(workshop.model(text), until=3.0)

    def slope(t: float, y: Any) -> list[float]:
        return [y[1], reference(t, y[0], y[1])]

    other = solve_ivp(slope, (0, 3), [0.4, 0.0], method="DOP853", rtol=1e-12, atol=1e-13, max_step=2e-3)
    assert run.success and run.energy_drift < 1e-11
    assert [run.q[-1, 0], run.u[-1, 0]] == pytest.approx(other.y[:, -1], abs=2e-9)


def test_a_clipped_law_is_a_motor_with_a_limit(workshop: Workshop) -> None:
    """The runs are those of the built-in kink, to rounding."""
    limited = '[[motor]]\njoint = "hip"\nangle = 0.3\nstiffness = 30\ndamping = 2\nlimit = 4\n'
    clipped = PD.replace('torque = "lift"', 'torque = "clip(lift, -most, most)"').replace("most", "4")
    one, other = (simulate(workshop.model(PENDULUM + text)) for text in (limited, clipped))
    assert len(one.t) == pytest.approx(len(other.t), abs=2)
    assert one.q[-1] == pytest.approx(other.q[-1], rel=1e-10)


def test_laws_with_kinks_are_named_in_others(workshop: Workshop) -> None:
    """A kink stands once, wherever the law is named: in loads, laws, events, and switching functions of these."""
    text = (
        MASS
        + """
[[law]]
name = "held"
value = "clip(-k*slide(guide), -2, 2)"
parameters = { k = 40 }
[[law]]
name = "more"
value = "abs(held - 1) - 1"
[[motor]]
joint = "guide"
force = "min(held, 1.5) + 0.1*more"
[[event]]
name = "off_the_limit"
when = "held + 1.99999"
[[event]]
name = "turned"
when = "max(rate(guide), more)"
direction = "rising"
[start]
slides = { guide = 0.4 }
"""
    )
    run = simulate(workshop.model(text), until=3.0)

    def slope(t: float, y: Any) -> list[float]:
        held = min(max(-40 * y[0], -2), 2)
        return [y[1], min(held, 1.5) + 0.1 * (abs(held - 1) - 1)]

    def leaves(t: float, y: Any) -> float:
        return min(max(-40 * y[0], -2), 2) + 1.99999

    other = solve_ivp(slope, (0, 3), [0.4, 0.0], method="DOP853", rtol=1e-12, atol=1e-13, max_step=2e-3, events=leaves)
    assert run.q[-1, 0] == pytest.approx(other.y[0, -1], abs=2e-9)
    found = [event.t for event in run.events if event.name == "off_the_limit"]
    assert found == pytest.approx(other.t_events[0], abs=1e-8)
    assert any(event.name == "turned" for event in run.events)


# -- parameters and derivatives ----------------------------------------------------------------------------------------


def test_parameters_of_laws_are_those_of_models(workshop: Workshop) -> None:
    model = workshop.model(PENDULUM + PD)
    assert model.parameters["lift.kp"] == 30.0 and model.parameters["lift.kd"] == 2.0
    stiff = simulate(model, params={"lift.kp": 60.0})
    written = simulate(workshop.model(PENDULUM + PD.replace("kp = 30.0", "kp = 60.0")))
    assert np.array_equal(stiff.q, written.q)


def test_events_set_parameters_of_laws(workshop: Workshop) -> None:
    """From an instant on it is the run of the other gain from there."""
    text = PENDULUM + PD + '[[event]]\nwhen = "t - 1"\nset = { "lift.kp" = "2*lift" }\n'
    run = simulate(workshop.model(text))
    plain = workshop.model(PENDULUM + PD)
    first = simulate(plain, until=1.0)
    gain = 2 * first["lift"][-1]
    second = simulate(plain, q0=first.q[-1], u0=first.u[-1], params={"lift.kp": gain}, until=2.0)
    assert run.events[0].parameters["lift.kp"] == pytest.approx(gain, rel=1e-12)
    assert run.q[-1] == pytest.approx(second.q[-1], abs=1e-9)


@pytest.mark.parametrize("kinked", [False, True])
def test_derivatives_of_runs_by_gains(kinked: bool, workshop: Workshop) -> None:
    """Tangent, adjoint and differences agree, with kinks on the way too."""
    text = PD.replace('torque = "lift"', 'torque = "clip(lift, -4, 4)"') if kinked else PD
    model = workshop.model(PENDULUM + text, derivatives=True)
    gains = ["lift.kp", "lift.kd"]
    run = simulate(model, until=1.2)
    tangent = run.jacobian(gains)
    adjoint = run.vjp(np.eye(2), gains)
    assert adjoint == pytest.approx(tangent, rel=1e-8, abs=1e-10)
    for column, name in enumerate(gains):
        h = 1e-4
        ends = [
            simulate(model, until=1.2, rtol=1e-13, params={name: model.parameters[name] + k * h})
            for k in (-2, -1, 1, 2)
        ]
        y = np.array([[end.q[-1, 0], end.u[-1, 0]] for end in ends])
        difference = (y[0] - 8 * y[1] + 8 * y[2] - y[3]) / (12 * h)
        assert tangent[:, column] == pytest.approx(difference, rel=1e-6, abs=1e-8)


def test_derivatives_go_through_the_limit_of_a_motor(workshop: Workshop) -> None:
    text = '[[motor]]\njoint = "hip"\nangle = 0.3\nstiffness = 30\ndamping = 2\nlimit = 4\n'
    model = workshop.model(PENDULUM + text, derivatives=True)
    run = simulate(model, until=1.2)
    names = ["motor_0.limit", "motor_0.stiffness"]
    tangent, h = run.jacobian(names), 1e-4
    for column, name in enumerate(names):
        ends = [
            simulate(model, until=1.2, rtol=1e-13, params={name: model.parameters[name] + k * h})
            for k in (-2, -1, 1, 2)
        ]
        y = np.array([[end.q[-1, 0], end.u[-1, 0]] for end in ends])
        difference = (y[0] - 8 * y[1] + 8 * y[2] - y[3]) / (12 * h)
        assert tangent[:, column] == pytest.approx(difference, rel=1e-6, abs=1e-8)


def test_the_jacobian_of_radau_has_the_law(workshop: Workshop) -> None:
    """A stiff law costs a stiff method few steps, and both methods come to the same."""
    stiff = PENDULUM + PD.replace("kp = 30.0, kd = 2.0", "kp = 30.0, kd = 3000.0")
    model = workshop.model(stiff, derivatives=True)
    radau, gauss = (simulate(model, method=name, rtol=1e-9, until=1.0) for name in ("radau", "dop853"))
    assert radau.q[-1] == pytest.approx(gauss.q[-1], abs=1e-8)
    assert len(radau.t) < len(gauss.t) / 5


# -- variants of a model -----------------------------------------------------------------------------------------------


def test_folded_and_other_numbers(workshop: Workshop) -> None:
    text = PENDULUM + PD.replace('torque = "lift"', 'torque = "clip(lift, -4, 4)"')
    plain = workshop.model(text)
    for variant, near in (({"fold": True}, 1e-12), ({"precision": "wide"}, 1e-12), ({"precision": "float"}, 1e-5)):
        other = workshop.model(text, **variant)
        for x in (-0.4, 0.29, 0.5):
            expected = plain.acceleration([x], [0.3])
            assert other.acceleration([x], [0.3]) == pytest.approx(expected, rel=near)


def test_a_law_is_written_once_and_only_where_it_is_named(workshop: Workshop) -> None:
    text = listing(workshop.scene(PENDULUM + PD + '[[torque]]\nlink = "rod"\ntorque = "0.5*lift"\n'))
    assert text.count("\nlaw_0 = ") == 1
    assert "law" not in listing(workshop.scene(PENDULUM))


# -- effects that come and go ------------------------------------------------------------------------------------------


def test_a_load_that_is_off_does_nothing_and_its_law_goes_on(workshop: Workshop) -> None:
    """While the motor is off the pendulum swings as without one: its energy stays."""
    text = PENDULUM + PD.replace('torque = "lift"', 'torque = "clip(lift, -4, 4)"')
    text += '[[event]]\nwhen = "t - 0.5"\noff = ["motor_0"]\n[[event]]\nwhen = "t - 1"\non = ["motor_0"]\n'
    run = simulate(workshop.model(text))
    assert run.success and run.energy_drift < 1e-11
    found = run.values("energy", "lift", "motor_0.torque", "hip.angle", "hip.angular_velocity", t=[0.51, 0.75, 0.99])
    assert found["energy"] == pytest.approx(found["energy"][0], rel=1e-11)
    assert not found["motor_0.torque"].any()
    assert found["lift"] == pytest.approx(-30 * (found["hip.angle"] - 0.3) - 2 * found["hip.angular_velocity"])


def test_a_motor_at_a_joint_that_lets_go_has_its_law_until_then(workshop: Workshop) -> None:
    """Then the link that flies off turns at a constant rate, which it had."""
    text = ARM + '[[law]]\nname = "hold"\nvalue = "clip(-8*angle(knee) - 0.5*rate(knee), -2, 2)"\n'
    text += '[[motor]]\njoint = "knee"\ntorque = "hold"\n[[release]]\njoint = "knee"\nat = 0.8\n'
    run = simulate(workshop.model(text), until=1.5)
    assert run.success and run.energy_drift < 1e-11
    t = [0.8, 1.0, 1.5]
    turning = run.values("fore.angular_velocity", "motor_0.torque", t=t)
    assert turning["fore.angular_velocity"] == pytest.approx(turning["fore.angular_velocity"][0], rel=1e-12)
    assert not turning["motor_0.torque"][1:].any()
    before = simulate(workshop.model(text.partition("[[release]]")[0]), until=0.7)
    assert run.values("hold", t=0.7)["hold"] == pytest.approx(before["hold"][-1], rel=1e-8)


def test_a_cart_balances_its_pole(workshop: Workshop) -> None:
    """The scene: the force is kept to 6 N, and in the end the pole stands and the cart is where the way is counted."""
    scene = load_scene(ROOT / "scenes" / "balanced-cart.toml")
    assert {"push", "lean"} <= possible_outputs(scene).keys()
    run = simulate(workshop.model(scene))
    assert run.success and run.energy_drift < 1e-10
    assert np.abs(run["motor_0.force"]).max() == 6.0 < np.abs(run["push"]).max()
    assert [run["lean"][-1], run["rail.slide"][-1]] == pytest.approx([0, 0], abs=2e-3)


def test_closed_forms_name_laws(workshop: Workshop) -> None:
    text = show_text(workshop.scene(PENDULUM + PD), False, True)
    assert "law_0 = -p_law_0_kd*w_0 - p_law_0_kp*(theta_0 - 0.3)" in text and "Q[w_0] = law_0" in text


# -- functions by rows -------------------------------------------------------------------------------------------------

ROWS = [(-0.5, 4.0), (-0.1, 1.5), (0.05, 0.2), (0.2, -2.0), (0.6, -2.5)]


def curved(kind: str, ends: str = "rest", more: str = "") -> str:
    return MASS + (
        '[[law]]\nname = "push"\nvalue = "k*gas(slide(guide) + 0*t) - 0.1*rate(guide)"\nparameters = { k = 3 }\n'
        f'curves = {{ gas = {{ rows = {[list(row) for row in ROWS]}, {kind}, ends = "{ends}" }} }}\n'
        f'[[motor]]\njoint = "guide"\nforce = "push{more}"\n[start]\nslides = {{ guide = 0.9 }}\n'
    )


@pytest.mark.parametrize("ends", ["rest", "straight"])
@pytest.mark.parametrize("kind", ["order = 1", "order = 3", 'law = "monotone"'])
def test_curves_go_through_their_rows(kind: str, ends: str, workshop: Workshop) -> None:
    """As SciPy's, between the rows and beyond them; runs as another program's, to the order of the method."""
    x, y = np.array(ROWS).T
    rest = ends == "rest"
    if kind == "order = 1":
        slopes = np.diff(y) / np.diff(x)
        inside: Any = lambda at: np.interp(at, x, y)  # noqa: E731
        first, last = (0.0, 0.0) if rest else (slopes[0], slopes[-1])
    elif kind == "order = 3":
        inside = CubicSpline(x, y, bc_type="clamped" if rest else "natural")
        first, last = (0.0, 0.0) if rest else (inside(x[0], 1), inside(x[-1], 1))
    else:
        inside = PchipInterpolator(x, y)
        first, last = (0.0, 0.0) if rest else (inside(x[0], 1), inside(x[-1], 1))

    def gas(at: float) -> float:
        if at < x[0]:
            return float(y[0] + first * (at - x[0]))
        return float(y[-1] + last * (at - x[-1])) if at > x[-1] else float(inside(at))

    model = workshop.model(curved(kind, ends))
    if kind == 'law = "monotone"' and rest:  # at rest at the ends it is a cubic of its own there
        places = [-0.9, -0.5, -0.1, 0.05, 0.1, 0.2, 0.6, 0.8]
    else:
        places = [-0.9, -0.5, -0.3, -0.1, 0.0, 0.05, 0.1, 0.2, 0.45, 0.6, 0.8]
    for at in places:
        assert model.acceleration([at], [0.2])[0] == pytest.approx(3 * gas(at) - 0.02, rel=1e-12, abs=1e-12)
    if kind == 'law = "monotone"' and rest:
        return
    run = simulate(model, until=3.0)
    other = solve_ivp(
        lambda t, y: [y[1], 3 * gas(y[0]) - 0.1 * y[1]],
        (0, 3), [0.9, 0.0], method="DOP853", rtol=1e-12, atol=1e-13, max_step=2e-3,
    )  # fmt: skip
    assert run.success and run.energy_drift < 1e-11
    assert [run.q[-1, 0], run.u[-1, 0]] == pytest.approx(other.y[:, -1], abs=2e-9)


def test_curves_stand_in_events_and_in_derivatives(workshop: Workshop) -> None:
    event = '[[event]]\nname = "passed"\nwhen = "push - 1.5"\n[[law]]\nname = "idle"\nvalue = "line(t)"\n'
    event += "curves = { line = { rows = [[0, 0], [1, 2], [2, 1]], order = 1 } }\n"
    model = workshop.model(curved('law = "monotone"', "straight") + event, derivatives=True)
    run = simulate(model, until=2.0)
    assert [one.name for one in run.events]
    for one in run.events:
        assert run.values("push", t=one.t)["push"] == pytest.approx(1.5, abs=1e-9)
    assert run.values("idle", t=[0.5, 1.5])["idle"] == pytest.approx([1.0, 1.5], abs=1e-12)
    tangent = run.jacobian(["q0", "push.k"])
    h = 1e-4
    ends = [simulate(model, until=2.0, rtol=1e-13, params={"push.k": 3 + k * h}) for k in (-2, -1, 1, 2)]
    y = np.array([[end.q[-1, 0], end.u[-1, 0]] for end in ends])
    assert tangent[:, -1] == pytest.approx((y[0] - 8 * y[1] + 8 * y[2] - y[3]) / (12 * h), rel=1e-6, abs=1e-8)


def test_names_of_kinks_are_their_own(workshop: Workshop) -> None:
    """A law whose kinks stand in another order than what they are about, free of sides in the other's switching."""
    text = MASS + (
        '[[law]]\nname = "a"\nvalue = "sin(slide(guide)) + min(cos(t), abs(tanh(rate(guide))) + exp(-t))"\n'
        '[[law]]\nname = "b"\nvalue = "max(a, 0.2) - abs(a - 0.5)"\n'
        '[[motor]]\njoint = "guide"\nforce = "b - slide(guide)"\n[[brake]]\njoint = "guide"\nforce = "max(a, b)"\n'
        "[start]\nslides = { guide = 0.4 }\n"
    )

    def force(t: float, x: float, v: float) -> float:
        a = math.sin(x) + min(math.cos(t), abs(math.tanh(v)) + math.exp(-t))
        b = max(a, 0.2) - abs(a - 0.5)
        return b - x - max(a, b, 0.0) * math.tanh(v / 0.001)

    model = workshop.model(text)
    for x, v in np.random.default_rng(5).uniform(-1, 1, (20, 2)):
        assert model.acceleration([x], [v], t=0.7)[0] == pytest.approx(force(0.7, x, v), rel=1e-12)


def drawn(random: np.random.Generator, depth: int) -> str:
    """An expression of all that there is, in words that Python and scenes have in common."""
    kinds = (
        ["number", "quantity", "t"] if depth == 0 else ["sum", "product", "power", "least", "size", "smooth", "clip"]
    )
    kind = random.choice(kinds)
    if kind == "number":
        return f"{random.uniform(-2, 2):.3f}"
    if kind in ("t", "quantity"):
        return "t" if kind == "t" else str(random.choice([*QUANTITIES]))
    a, b, c = (drawn(random, depth - 1) for _ in range(3))
    if kind == "sum":
        return f"({a} {random.choice(['+', '-'])} {b})"
    if kind == "product":
        return f"({a})*({b})" if random.random() < 0.5 else f"({a})/(3 + ({b})**2)"
    if kind == "power":
        return f"({a})**{random.integers(0, 4)}"
    if kind == "least":
        return f"{random.choice(['min', 'max'])}({a}, {b}, {c})"
    if kind == "clip":
        return f"clip({a}, -0.7, 0.3)"
    return f"abs({a})" if kind == "size" else f"{random.choice(['sin', 'cos', 'tanh', 'atan'])}({a})"


QUANTITIES = {
    "angle(hip)": lambda q, u: q[0],
    "rate(hip)": lambda q, u: u[0],
    "direction(fore)": lambda q, u: q[1],
    "angle(knee)": lambda q, u: q[1] - q[0],
    "rate(angle(knee))": lambda q, u: u[1] - u[0],
    "x(fore.B)": lambda q, u: 0.8 * math.cos(q[0]) + 0.5 * math.cos(q[1]),
    "vy(fore.B)": lambda q, u: 0.8 * math.cos(q[0]) * u[0] + 0.5 * math.cos(q[1]) * u[1],
    "distance(ground.O, fore.B)": lambda q, u: math.hypot(
        0.8 * math.cos(q[0]) + 0.5 * math.cos(q[1]), 0.8 * math.sin(q[0]) + 0.5 * math.sin(q[1])
    ),
}
FUNCTIONS = {name: getattr(math, name) for name in ("sin", "cos", "tanh", "atan")} | {
    "min": min,
    "max": max,
    "abs": abs,
}


def test_drawn_expressions_are_what_python_makes_of_them(workshop: Workshop) -> None:
    """Laws, what loads make of them, and functions of kinks within kinks."""
    random = np.random.default_rng(11)
    texts = [drawn(random, 3) for _ in range(16)]
    laws = "".join(f'[[law]]\nname = "a{k}"\nvalue = "{text} + 0*t"\n' for k, text in enumerate(texts))
    every = " + ".join(f"{random.choice(['abs', 'sin'])}(a{k})" for k in range(len(texts)))
    model = workshop.model(ARM + laws + f'[[motor]]\njoint = "hip"\ntorque = "{every}"\n')
    assert list(model.q_names) == ["theta_0", "theta_1"]
    for q, u in random.uniform(-1.5, 1.5, (6, 2, 2)):
        run = simulate(model, q, u, until=0.0)
        names = {name: str(float(of(q, u))) for name, of in QUANTITIES.items()}
        found = []
        for text in texts:
            put = text
            for name, value in sorted(names.items(), key=lambda one: -len(one[0])):
                put = put.replace(name, f"({value})")
            clip = {"clip": lambda x, low, high: min(max(x, low), high), "t": 0.0}
            found.append(eval(put, {"__builtins__": {}}, FUNCTIONS | clip))
        assert [run[f"a{k}"][0] for k in range(len(texts))] == pytest.approx(found, rel=1e-11, abs=1e-11)
        total = sum(getattr(math, one[:3], abs)(a) for one, a in zip(every.split(" + "), found, strict=True))
        assert run["motor_0.torque"][0] == pytest.approx(total, rel=1e-11, abs=1e-11)
