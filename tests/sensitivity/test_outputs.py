"""What is asked for of derivatives of runs, and what is refused."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from ccgen.runtime import sensitivities, simulate

from ..support.derived_scenes import FOUR_BAR, body
from ..support.workshop import Workshop

BALL = 'name = "ball"\n' + body(
    'contacts = ["body.A"]\nradius = 0.1\n',
    com="[0, 0]",
    position="[0, 1]",
    velocity="[1, 0]",
    spin=-10,
    restitution=0.6,
    friction=0.2,
    angle=0,
)
BAR = 'name = "bar"\n' + FOUR_BAR


@pytest.fixture
def ball(workshop: Workshop) -> Any:
    return workshop.model(BALL, derivatives=True)


@pytest.fixture
def bar(workshop: Workshop) -> Any:
    return workshop.model(BAR, derivatives=True)


def test_outputs_by_name_and_functions(bar: Any) -> None:
    """A point, an energy, a force in flight and a function: by the chain rule from the state."""
    names = ["coupler.B.x", "kinetic_energy", "axle.fx", "crank.angle"]

    def both(t: float, q: Any, u: Any) -> Any:
        return q[0] * u[0], u[0] * np.eye(len(q))[0], q[0] * np.eye(len(q))[0]

    wrt = ("crank.mass", "u0")
    found = sensitivities(bar, wrt, [*names, both, "q", "u"], until=0.3)
    q, u = found.run.q[-1], found.run.u[-1]
    by = {"q": found["q"], "u": found["u"], "crank.mass": [1, 0, 0, 0]}
    assert found["coupler.B.x"] == pytest.approx(
        bar.derivatives("points", q, u, wrt=by)[bar.points.index("coupler.B"), 0]
    )
    assert found["kinetic_energy"] == pytest.approx(bar.derivatives("energy", q, u, wrt=by)[0])
    assert found["axle.fx"] == pytest.approx(bar.derivatives("reactions", q, u, 0.3, wrt=by)[0, 0])
    assert found["both"] == pytest.approx(u[0] * found["q"][0] + q[0] * found["u"][0])
    assert found.values["both"] == pytest.approx(q[0] * u[0])
    assert found.values["coupler.B.x"] == pytest.approx(bar.point("coupler.B", q)[0])
    assert found.columns == ("crank.mass", "u0[crank.angle]", "u0[coupler.angle]", "u0[rocker.angle]")
    assert found.jacobian.shape == (5 + 6, 4)


def test_energy_stays_whatever_moves(bar: Any) -> None:
    """Of a motion without losses, along all directions of its start; by gravity it is its potential at the start."""
    found = sensitivities(
        bar, ("q0", "u0"), ["kinetic_energy", "potential_energy"], at=[0.0, 1.0], until=1.0, rtol=1e-13
    )
    total = found["kinetic_energy"] + found["potential_energy"]
    assert total[1] == pytest.approx(total[0], abs=1e-11 * np.max(np.abs(total)))


def test_times_in_any_order_between_rows_and_twice(ball: Any) -> None:
    times = [0.7, 0.2, 0.7, 0.9]
    found = sensitivities(ball, ("u0", "ground_0.restitution"), ["body.x", "q"], at=times, until=1.0, rtol=1e-12)
    assert found["body.x"].shape == (4, 4) and found["q"].shape == (4, 3, 4)
    for k, t in enumerate(times):
        alone = sensitivities(ball, ("u0", "ground_0.restitution"), ["body.x", "q"], until=t, rtol=1e-12)
        assert found["body.x"][k] == pytest.approx(alone["body.x"], abs=1e-10)
        assert found["q"][k] == pytest.approx(alone["q"], abs=1e-10)
        assert found.values["body.x"][k] == pytest.approx(alone.values["body.x"], abs=1e-11)


@pytest.mark.parametrize("method", ["dop853", "dopri5", "radau"])
def test_each_method_of_runs(method: str, ball: Any) -> None:
    """Derivatives follow the exact motion through the rows of the run, however these were found."""
    wrt = ("u0", "gravity.g", "ground_0.friction")
    wanted = sensitivities(ball, wrt, until=1.0, rtol=1e-12)
    found = sensitivities(ball, wrt, until=1.0, rtol=1e-8, method=method)
    assert found.jacobian == pytest.approx(wanted.jacobian, abs=1e-6 * np.max(np.abs(wanted.jacobian)))


def test_steps_of_fixed_length(bar: Any) -> None:
    wanted = sensitivities(bar, "u0", until=1.0, rtol=1e-12)
    found = sensitivities(bar, "u0", until=1.0, step=0.02)
    assert found.jacobian == pytest.approx(wanted.jacobian, abs=1e-9 * np.max(np.abs(wanted.jacobian)))


def test_inputs(workshop: Workshop) -> None:
    """A torque of an input at the crank: by differences of runs, a run being nearly linear in it."""
    model = workshop.model(BAR + '[[input]]\nname = "motor"\njoint = "axle"\n', derivatives=True)
    found = sensitivities(model, "motor", "crank.angle", inputs={"motor": 0.5}, until=0.5, rtol=1e-13)
    ends = [simulate(model, inputs={"motor": 0.5 + h}, until=0.5, rtol=1e-13)["crank.angle"][-1] for h in (1e-4, -1e-4)]
    assert found["crank.angle"] == pytest.approx((ends[0] - ends[1]) / 2e-4, rel=1e-7)
    with pytest.raises(ValueError, match="found a controller, expected constants"):
        sensitivities(model, "u0", inputs=lambda t, q, u: 0.0, until=0.1)
    with pytest.raises(ValueError, match="found a table over time, expected constants"):
        sensitivities(model, "u0", inputs={"t": [0, 1], "motor": [0, 1]}, until=0.1)


# -- what is refused ---------------------------------------------------------------------------------------------------


def test_what_is_wrong_with_a_call_is_all_said(ball: Any) -> None:
    with pytest.raises(ValueError, match=r"(?s)body\.mas.*outputs: found 'body\.z'.*at: found 7 s"):
        sensitivities(ball, ("u0", "body.mas"), ["body.x", "body.z"], at=[7.0], until=1.0)
    with pytest.raises(ValueError, match="wrt: found 'q', expected q0 or u0"):
        sensitivities(ball, "q", until=1.0)
    with pytest.raises(ValueError, match="wrt: found 'u0' more than once"):
        sensitivities(ball, ["u0", "q0", "u0"], until=1.0)
    with pytest.raises(ValueError, match="wrt: found nothing"):
        sensitivities(ball, (), until=1.0)
    with pytest.raises(ValueError, match=r"wrt: u0: found shape \(2, 1\), expected finite numbers \(3, directions\)"):
        sensitivities(ball, {"u0": [[1], [2]]}, until=1.0)
    with pytest.raises(ValueError, match="as many of each"):
        sensitivities(ball, {"u0": np.eye(3), "gravity.g": [1.0]}, until=1.0)
    with pytest.raises(TypeError, match="expected a Model"):
        sensitivities(None, "u0")  # type: ignore[arg-type]


def test_the_time_of_an_impact_is_no_time_for_outputs(ball: Any) -> None:
    t = simulate(ball, until=1.0).impacts[0].t
    with pytest.raises(ValueError, match="the time of an impact, at which the state jumps"):
        sensitivities(ball, "u0", at=t, until=1.0)


def test_a_model_without_derivatives_says_how_to_get_them(workshop: Workshop) -> None:
    with pytest.raises(ValueError, match=r"generate\(scene, derivatives=True\)"):
        sensitivities(workshop.model(BAR), "u0", until=0.1)


def test_bounces_that_accumulate_are_refused(ball: Any) -> None:
    with pytest.raises(ValueError, match="bounces accumulate"):
        sensitivities(ball, "u0", until=3.0)


SETTLING = 'name = "settling"\n' + body(
    'contacts = ["body.A"]\nradius = 0.1\n',
    com="[0, 0]",
    position="[0, 0.4]",
    velocity="[3, 1]",
    spin=60,
    restitution=0.5,
    friction=0.02,
    angle=0,
).replace("normal = [0.05, 1.0]", "normal = [0, 1]")


@pytest.mark.parametrize("restitution", [0.1, 0.5])
def test_bounces_that_accumulate_into_sliding_are_refused(restitution: float, workshop: Workshop) -> None:
    """The last of them close by rounding, and dividing by that has given derivatives of 1e5 where they are 0.04."""
    model = workshop.model(SETTLING, derivatives=True).with_parameters({"ground_0.restitution": restitution})
    assert sensitivities(model, ["u0"], ["body.x"], until=0.4)["body.x"][0] == pytest.approx(0.4, abs=1e-10)
    for mode in ("tangent", "adjoint"):
        with pytest.raises(ValueError, match="closes faster than 1e-06 of the mechanism's speeds, as where bounces"):
            sensitivities(model, ["u0"], ["body.x"], until=1.8, rtol=1e-12, mode=mode)


CHAIR = 'name = "chair"\n' + body(
    'contacts = ["body.A", "body.B"]\n',
    com="[0.2, 0.3]",
    position="[0, 1]",
    velocity="[0, 0]",
    angle=0,
    spin=0,
    restitution=0.3,
    friction=0.5,
).replace("[0.05, 1.0]", "[0.0, 1.0]").replace("friction = 0.5\n", "")


def test_two_feet_that_land_together_have_no_matrix(workshop: Workshop) -> None:
    """By its height there is a derivative, and the same for both feet; by its angle which foot comes first decides."""
    model = workshop.model(CHAIR, derivatives=True)
    high = {"q0": np.array([[0.0], [1.0], [0.0]])}
    found = sensitivities(model, high, "impact_times", until=0.6)
    assert len(found.run.impacts[0].contacts) == 2
    assert found["impact_times"][0, 0] == pytest.approx(1.0 / np.sqrt(2 * 9.81), rel=1e-9)
    with pytest.raises(ValueError, match=r"strike together at t = 0\.4515\d+ s, .*q0\[body\.angle\] parts"):
        sensitivities(model, "q0", until=0.6)


def test_a_contact_that_is_held_from_the_start_stays_so(workshop: Workshop) -> None:
    model = workshop.model(CHAIR.replace("[0, 1]", "[0, 0]").replace("[0.0, 1.0]", "[0.0, 1.0]"), derivatives=True)
    with pytest.raises(ValueError, match=r"held from the start on, which .* opens or makes strike or slide"):
        sensitivities(model, "u0", until=0.1)


def test_events_that_are_only_told_change_no_derivative(workshop: Workshop) -> None:
    """Nor do those that would do something later, or one that ends the run."""
    told = '[[event]]\nwhen = "y(body.A) - 0.5"\n'
    late = told + '[[event]]\nname = "late"\nwhen = "t - 0.8"\n'
    wrt = ("q0", "u0", "gravity.g")
    plain, with_events, ended = (
        workshop.model(BALL + text, derivatives=True)
        for text in ("", late + 'set = { "gravity.g" = 5 }\n', late + "stop = true\n")
    )
    one, other = (sensitivities(model, wrt, until=0.7) for model in (plain, with_events))
    assert np.array_equal(one.jacobian, other.jacobian) and other.run.events and other.passed
    last, whole = sensitivities(ended, wrt, until=1.0), sensitivities(plain, wrt, until=0.8)
    assert last.run.t[-1] == 0.8 and last.jacobian == pytest.approx(whole.jacobian, rel=1e-12, abs=1e-12)


def test_effects_with_kinks_are_refused(workshop: Workshop) -> None:
    text = BAR + "[[compliant_ground]]\npoint = [0, -9]\nload = 30\nrestitution = 0.2\nfriction = 0.4\n"
    with pytest.raises(ValueError, match="found effects with kinks at which loads may jump"):
        sensitivities(workshop.model(text, derivatives=True), "u0", until=0.1)


def test_stronges_law_is_covered_where_sliding_goes_on(workshop: Workshop) -> None:
    sliding = BALL.replace("friction = 0.2", "friction = 0.02").replace("[-10]", "[30]") + '[run]\nlaw = "stronge"\n'
    model = workshop.model(sliding, derivatives=True)
    newton = workshop.model(sliding.replace("stronge", "newton"), derivatives=True)
    wrt = ("u0", "ground_0.friction", "ground_0.restitution")
    assert sensitivities(model, wrt, until=0.7).jacobian == pytest.approx(
        sensitivities(newton, wrt, until=0.7).jacobian
    )
    sticking = workshop.model(BALL + '[run]\nlaw = "stronge"\n', derivatives=True)
    with pytest.raises(ValueError, match="Stronge's law"):
        sensitivities(sticking.with_parameters({"ground_0.friction": 0.9}), wrt, until=0.7)


def test_outputs_of_one_name_are_refused(ball: Any) -> None:
    """They are told by their names: one would hide the other."""
    both = [lambda t, q, u, k=k: (q[k], np.eye(3)[k], np.zeros(3)) for k in (0, 1)]
    with pytest.raises(ValueError, match="outputs: found <lambda> 2 times, expected names that differ"):
        sensitivities(ball, "u0", both, until=0.1)
    with pytest.raises(ValueError, match="outputs: found q 2 times"):
        simulate(ball, until=0.1).jacobian("u0", ["q", "u", "q"])
