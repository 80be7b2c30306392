"""Runs as functions of numbers: values and derivatives beside a closed form, searches of SciPy, and wrong use."""

from __future__ import annotations

import re
import sys
import threading
from typing import Any

import numpy as np
import pytest
from scipy.optimize import least_squares, minimize

from ccgen.runtime import run_function, sensitivities

from ..support.bounced import AT, BOUNCED, OUTPUTS, WRT, X, bounced, bounced_jacobian
from ..support.driven_crank import CRANK
from ..support.workshop import Workshop


@pytest.fixture(scope="module")
def ball(workshop: Workshop) -> Any:
    return workshop.model(BOUNCED, derivatives=True)


def test_it_is_the_closed_form(ball: Any) -> None:
    function = run_function(ball, WRT, OUTPUTS, at=AT, inputs={"push": 0.8})
    assert function.columns[:4] == ("u0[ball.x]", "u0[ball.y]", "u0[ball.angle]", "ball.mass")
    assert np.array_equal(function.x0, X) and function.count == 4
    moved = X * np.array([1.1, -0.9, 2.0, 0.8, 1.05, 0.9, 1.3])
    for x in (X, moved):
        assert function(x) == pytest.approx(bounced(x), rel=1e-11)
        assert function.jacobian(x) == pytest.approx(bounced_jacobian(x), rel=1e-10, abs=1e-11)
    value, jacobian = function.value_and_jacobian(moved)
    assert np.array_equal(value, function.value(moved)) and np.array_equal(jacobian, function.jacobian(moved))
    assert function.evaluations == 2
    v, w = np.arange(7.0) - 2.0, np.array([1.0, -2.0, 3.0, 0.5])
    assert function.jvp(moved, v) == pytest.approx(bounced_jacobian(moved) @ v, rel=1e-10)
    assert function.vjp(moved, w) == pytest.approx(w @ bounced_jacobian(moved), rel=1e-10, abs=1e-11)


def test_weighted_derivatives_need_no_jacobian(ball: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """They are taken back through the run; once there is a Jacobian, from that."""
    w = np.array([1.0, -2.0, 3.0, 0.5])
    function = run_function(ball, WRT, OUTPUTS, at=AT, inputs={"push": 0.8})
    with monkeypatch.context() as patch:
        patch.setattr("ccgen.runtime.functions.run_function.run_sensitivities", None)
        found = function.vjp(X, w)
    assert found == pytest.approx(w @ bounced_jacobian(X), rel=1e-10, abs=1e-11)
    function.jacobian(X)
    monkeypatch.setattr("ccgen.runtime.functions.run_function.run_vjp", None)
    assert function.vjp(X, w) == pytest.approx(found, rel=1e-12)
    assert function.evaluations == 1


@pytest.mark.parametrize("mode", ["tangent", "adjoint"])
def test_both_modes_are_the_closed_form(mode: Any, ball: Any) -> None:
    function = run_function(ball, WRT, OUTPUTS, at=AT, inputs={"push": 0.8}, mode=mode)
    assert function.jacobian(X) == pytest.approx(bounced_jacobian(X), rel=1e-10, abs=1e-11)


def test_what_it_gives_is_not_what_it_keeps(ball: Any) -> None:
    function = run_function(ball, "gravity.g", "ball.y", at=AT)
    x = function.x0
    for part in (*function.value_and_jacobian(x), function.value(x), x):
        part.fill(0.0)
    assert np.all(function(function.x0) != 0.0) and np.all(function.jacobian(function.x0) != 0.0)


def test_starts_and_all_outputs_are_those_of_sensitivities(ball: Any) -> None:
    """Also impact times, and a function, whose counts only a run tells."""

    def twice(t: float, q: Any, u: Any) -> Any:
        return 2.0 * q[:2], 2.0 * np.eye(3)[:2], np.zeros((2, 3))

    outputs, q0 = ["q", "impact_times", twice, "u", "kinetic_energy"], [0.1, 1.2, 0.3]
    function = run_function(ball, ["q0", "push"], outputs, q0, at=[0.3, 0.8])
    found = sensitivities(ball, ["q0", "push"], outputs, q0, at=[0.3, 0.8], until=0.8)
    assert function.count == 6 + 1 + 4 + 6 + 2
    assert np.array_equal(function.x0, [*q0, 0.0])
    assert function(function.x0) == pytest.approx(np.concatenate([np.ravel(v) for v in found.values.values()]))
    assert np.array_equal(function.jacobian(function.x0), found.jacobian)


def test_least_squares_find_what_a_run_was_made_with(ball: Any) -> None:
    truth = np.array([9.7, 0.62])
    function = run_function(ball, ["gravity.g", "ground_0.restitution"], "ball.y", at=np.linspace(0.05, 0.9, 9))
    wanted = function(truth)
    lowest, highest = function.bounds
    assert lowest.tolist() == [-np.inf, 0.0] and highest.tolist() == [np.inf, 1.0]
    found = least_squares(
        lambda x: function(x) - wanted, function.x0, jac=function.jacobian, bounds=function.bounds, xtol=1e-14
    )
    assert found.x == pytest.approx(truth, rel=1e-9)


def test_minimize_takes_a_number_with_its_gradient(ball: Any) -> None:
    """Of what is thrown up the energy at its end is least where it stands still on top: w = g t."""
    function = run_function(ball, "u0", "kinetic_energy", [0.0, 5.0, 0.0], at=0.4)
    found = minimize(function.value_and_gradient, function.x0, jac=True, tol=1e-12)
    assert found.x == pytest.approx([0.0, 9.81 * 0.4, 0.0], abs=1e-6)


@pytest.fixture(scope="module")
def slider(workshop: Workshop) -> Any:
    """A slider that is pulled away at a constant rate, until the crank and the rod are in one line."""
    text = CRANK.replace('"driven"', '"pulled"') + '[[drive]]\njoint = "guide"\nspeed = 0.2\n[run]\nuntil = 0.5\n'
    return workshop.model(text, derivatives=True)


def test_runs_that_stop_early(slider: Any) -> None:
    refusing = run_function(slider, "drive_0.speed", "crank.angle")
    assert np.isfinite(refusing(0.2)).all()
    for ask in (refusing.value, refusing.jacobian, refusing.value_and_gradient):
        with pytest.raises(ValueError, match=r"with drive_0.speed = 0.5: found a run that stopped early, .* 0\.2\d+ s"):
            ask(0.5)
    giving = run_function(slider, "drive_0.speed", "q", on_stop="nan", at=[0.1, 0.5])
    assert np.isnan(giving(0.5)).all() and giving(0.5).shape == (6,)
    with pytest.raises(ValueError, match=r"with drive_0.speed = 0.5: .*stopped early"):
        giving.jacobian(0.5)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"wrt": ["gravity.h", "ball.weight"]}, ("gravity.h", "ball.weight")),
        ({"wrt": ["u0", "u0"]}, ("wrt: found u0 2 times",)),
        ({"wrt": []}, ("wrt: found nothing",)),
        ({"outputs": ["ball.z", "q"]}, ("outputs: found 'ball.z'",)),
        ({"outputs": []}, ("outputs: found none",)),
        ({"outputs": ["q", "q"]}, ("outputs: found q 2 times",)),
        ({"at": [0.1, -1.0]}, ("none before 0",)),
        ({"at": [0.1, 2.0], "until": 1.0}, ("at: found 2 s, expected times to the end of the run, until = 1 s",)),
        ({"q0": [1.0]}, ("q0: found shape (1,), expected (3,)",)),
        ({"inputs": lambda t, q, u: 0.0}, ("inputs: found a controller, expected constants",)),
        ({"rtol": -1.0}, ("rtol",)),
        ({"mode": "both"}, ("mode: found 'both', expected one of auto",)),
        ({"on_stop": "ignore"}, ("on_stop: found 'ignore', expected one of refuse, nan",)),
        ({"wrt": "gravity.h", "outputs": "ball.z", "on_stop": ""}, ("gravity.h", "ball.z", "on_stop")),
    ],
)
def test_wrong_functions_are_refused(change: dict[str, Any], said: tuple[str, ...], ball: Any) -> None:
    given: dict[str, Any] = {"wrt": "u0", "outputs": "ball.y"} | change
    with pytest.raises((KeyError, ValueError)) as caught:
        run_function(ball, **given)
    assert all(part in str(caught.value) for part in said), str(caught.value)


def test_threads_share_a_function(ball: Any) -> None:
    """They ask for derivatives of one run at once, with inputs that one thread's end leaves to the others."""
    function = run_function(ball, ["push", "ball.mass"], ["ball.x", "ball.vx"], at=AT)
    x, w = np.array([0.8, 2.0]), np.ones(4)
    function.value(x)  # all derive this run
    wanted, failed = run_function(ball, ["push", "ball.mass"], ["ball.x", "ball.vx"], at=AT).vjp(x, w), list[object]()

    def ask() -> None:
        try:
            for _ in range(20):
                if np.max(np.abs(function.vjp(x, w) - wanted)) > 1e-12:
                    failed.append("other numbers")
        except ValueError as error:
            failed.append(error)

    before = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    try:
        threads = [threading.Thread(target=ask) for _ in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    finally:
        sys.setswitchinterval(before)
    assert failed == []


def test_wrong_kinds_are_refused(ball: Any, workshop: Workshop) -> None:
    with pytest.raises(TypeError, match="expected names"):
        run_function(ball, {"u0": np.eye(3)}, "ball.y")  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="model: found str, expected a Model"):
        run_function("ball", "u0", "ball.y")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="derivatives"):
        run_function(workshop.model(BOUNCED), "u0", "ball.y")


@pytest.mark.parametrize(
    ("x", "said"),
    [
        ([9.81], r"x: found shape (1,), expected (2,): gravity.g, ball.mass"),
        (9.81, r"x: found shape (), expected (2,)"),
        ([[9.81, 2.0]], r"x: found shape (1, 2), expected (2,)"),
        ([9.81, np.nan], "x: found what is no finite number for ball.mass"),
        (["a", "b"], "x: found 'a', expected numbers"),
        ([9.81 + 1j, 2.0], "expected real numbers"),
        ([9.81, -2.0], "with gravity.g = 9.81, ball.mass = -2: ball.mass: found -2.0"),
    ],
)
def test_wrong_vectors_are_refused(x: Any, said: str, ball: Any) -> None:
    function = run_function(ball, ["gravity.g", "ball.mass"], ["ball.x", "ball.y"])
    for ask in (function.value, function.jacobian, function.value_and_gradient, lambda x: function.vjp(x, [1.0, 1.0])):
        with pytest.raises(ValueError, match=re.escape(said)):
            ask(x)


def test_other_wrong_asking_is_refused(ball: Any) -> None:
    function = run_function(ball, ["gravity.g", "ball.mass"], ["ball.x", "ball.y"])
    with pytest.raises(ValueError, match="values: found 2 numbers, expected one, which has a gradient"):
        function.value_and_gradient(function.x0)
    with pytest.raises(ValueError, match=r"w: found shape \(3,\), expected \(2,\), a weight for each value"):
        function.vjp(function.x0, np.ones(3))
    with pytest.raises(ValueError, match=r"v: found shape \(1,\), expected \(2,\)"):
        function.jvp(function.x0, np.ones(1))
    alone = run_function(ball, "gravity.g", lambda t, q, u: q[1])
    for ask in (alone.value, alone.jacobian):
        with pytest.raises(ValueError, match=r"<lambda>: found float64, expected a tuple of values and of their"):
            ask(9.81)
    times = run_function(ball, "gravity.g", "impact_times", until=0.6)
    assert times.count == 1
    with pytest.raises(ValueError, match=r"with gravity.g = 50: found \d numbers, expected 1 as at x0"):
        times(50.0)


def test_what_has_no_derivative_is_refused_with_its_numbers(ball: Any) -> None:
    """The time of an impact: values are there, as behind it, derivatives are not."""
    hit = run_function(ball, "gravity.g", "q").run(9.81).impacts[0].t
    function = run_function(ball, "gravity.g", "ball.y", at=hit, until=0.9)
    assert function(9.81) == pytest.approx([0.0], abs=1e-12)
    with pytest.raises(ValueError, match=r"with gravity.g = 9.81: at: .* the time of an impact"):
        function.jacobian(9.81)
