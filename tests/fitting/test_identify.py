"""Parameters from measurements: against closed forms of least squares, and known values behind noise."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from ccgen.generator import load_scene, loop
from ccgen.runtime import identify, simulate

from ..support.folders import ROOT
from ..support.workshop import Workshop

BALL = """
name = "ball"
[[link]]
name = "ball"
mass = 0.5
inertia = 0.1
com = [0, 0]
points = { C = [0, 0] }
[start]
position = [0, 2]
velocity = [1, 3]
[gravity]
g = 9.0
[run]
until = 0.7
"""
AT = np.linspace(0.05, 0.7, 40)


@pytest.fixture(scope="module")
def ball(workshop: Workshop) -> Any:
    return workshop.model(BALL, derivatives=True)


def fallen(noise: float) -> Any:
    return 2.0 + 3.0 * AT - 9.81 * AT**2 / 2.0 + noise * np.random.default_rng(2).normal(size=AT.size)


def test_a_line_in_its_parameter_is_fitted_as_in_closed_form(ball: Any) -> None:
    """y = y0 + v t - g t^2 / 2: of g the estimate and its deviation are sums over the times."""
    y, sigma = fallen(0.01), 0.01
    found = identify(ball, {"ball.y": y}, AT, ["gravity.g"], sigma=sigma)
    a = -(AT**2) / 2.0
    wanted = a @ (y - 2.0 - 3.0 * AT) / (a @ a)
    rest = y - 2.0 - 3.0 * AT - wanted * a
    assert found.values["gravity.g"] == pytest.approx(wanted, rel=1e-10)
    assert found.deviations["gravity.g"] == pytest.approx(sigma / np.sqrt(a @ a), rel=1e-8)
    assert found.misfit == pytest.approx(np.sqrt(rest @ rest / (AT.size - 1)) / sigma, rel=1e-8)
    assert np.abs(found.residuals["ball.y"] - rest).max() <= 1e-9
    assert (
        found.converged
        and not found.undetermined
        and found.run.model.parameters["gravity.g"] == found.values["gravity.g"]
    )


def test_noise_is_that_of_the_residuals_where_it_is_not_given(ball: Any) -> None:
    y = fallen(0.01)
    told = identify(ball, {"ball.y": y}, AT, ["gravity.g"], sigma=0.01)
    found = identify(ball, {"ball.y": y}, AT, ["gravity.g"])
    assert found.values["gravity.g"] == pytest.approx(told.values["gravity.g"], rel=1e-10)
    assert found.misfit == 1.0 and found.noise["ball.y"] == pytest.approx(0.01 * told.misfit, rel=1e-8)
    assert found.deviations["gravity.g"] == pytest.approx(told.deviations["gravity.g"] * told.misfit, rel=1e-8)


def test_what_was_not_measured_is_left_out(ball: Any) -> None:
    y, kept = fallen(0.01), np.arange(AT.size) % 3 != 0
    found = identify(ball, {"ball.y": np.where(kept, y, np.nan)}, AT, ["gravity.g"], sigma=0.01)
    wanted = identify(ball, {"ball.y": y[kept]}, AT[kept], ["gravity.g"], sigma=0.01)
    assert found.values["gravity.g"] == pytest.approx(wanted.values["gravity.g"], rel=1e-12)
    assert found.deviations["gravity.g"] == pytest.approx(wanted.deviations["gravity.g"], rel=1e-9)


def test_what_moves_nothing_holds_nothing_up(ball: Any) -> None:
    """A parameter that no measurement depends on is told to be so, and the other is found as without it, as soon."""
    y = fallen(0.01)
    alone = identify(ball, {"ball.y": y}, AT, ["gravity.g"], sigma=0.01)
    found = identify(ball, {"ball.y": y}, AT, ["gravity.g", "ball.inertia"], sigma=0.01)
    assert found.converged and found.evaluations <= alone.evaluations + 2
    assert found.values["gravity.g"] == pytest.approx(alone.values["gravity.g"], rel=1e-10)
    assert found.deviations["gravity.g"] == pytest.approx(alone.deviations["gravity.g"], rel=1e-9)
    assert found.undetermined == ({"ball.inertia": 1.0},) and np.isinf(found.deviations["ball.inertia"])


def test_masses_of_a_swinging_linkage_are_told_up_to_their_scale(workshop: Workshop) -> None:
    """A four-bar that swings by its weight alone moves the same with all masses and inertias twice as large."""
    model = workshop.model(load_scene(ROOT / "scenes" / "four-bar.toml"), derivatives=True)
    wrt = [path for path in model.parameters if path.endswith((".mass", ".inertia"))]
    at = np.linspace(0.05, 2.0, 60)
    q, _ = simulate(model, until=2.0, rtol=1e-11).at(at)
    off = {path: model.parameters[path] * (1.1 if path == wrt[0] else 1.0) for path in wrt}
    found = identify(model, {"q": q}, at, wrt, sigma=1e-3, rtol=1e-11, params=off)
    assert found.misfit <= 1e-6 and _spans(found, wrt)
    assert max(len(way) for way in found.undetermined) == len(wrt)
    assert np.isinf([found.deviations[path] for path in wrt]).any()
    assert "changes nothing that was measured" in str(found)


def _spans(found: Any, wrt: list[str]) -> bool:
    """Whether equal relative changes of all are a combination of the open directions."""
    ways = np.array([[way.get(path, 0.0) for path in wrt] for way in found.undetermined]).T
    ones = np.ones(len(wrt))
    return bool(np.abs(ways @ np.linalg.lstsq(ways, ones, rcond=None)[0] - ones).max() <= 1e-3)


def test_six_parameters_of_a_falling_hexagon_through_its_impacts(workshop: Workshop) -> None:
    """Masses, restitution, friction and gravity from 200 noisy angles and places: each within four deviations, and the
    misfit that of the noise."""
    ground = [{"restitution": 0.6, "friction": 0.3}]
    scene = loop(6, gravity=True, start={"height": 0.5, "tilt": "8 deg"}, ground=ground)
    model = workshop.model(scene, derivatives=True)
    rng = np.random.default_rng(1)
    q, u = model.start()
    q, u = model.project(q, u + 0.3 * rng.normal(size=u.size))
    truth = {"ground_0.restitution": 0.55, "ground_0.friction": 0.35, "link_1.mass": 1.1, "link_2.mass": 0.9}
    truth |= {"link_4.mass": 1.2, "gravity.g": 9.7}
    at = np.linspace(0.01, 0.8, 25)
    run = simulate(model.with_parameters(truth), q, u, until=0.8)
    assert len(run.impacts) >= 3
    measured = run.at(at)[0] + 1e-3 * rng.normal(size=(25, q.size))
    assert measured.size == 200
    found = identify(model, {"q": measured}, at, list(truth), q, u, sigma=1e-3)
    assert found.converged and not found.undetermined
    far = [abs(found.values[path] - value) / found.deviations[path] for path, value in truth.items()]
    assert max(far) <= 4.0, far
    assert abs(found.misfit - 1.0) <= 4.0 / np.sqrt(2.0 * (200 - 6))
    exact = identify(model, {"q": run.at(at)[0]}, at, list(truth), q, u, sigma=1e-3)
    assert max(abs(exact.values[path] / value - 1.0) for path, value in truth.items()) <= 1e-7


def test_what_pulls_before_and_behind_an_event_is_told_apart(workshop: Workshop) -> None:
    """A ball in a drag that is set where it begins to fall: that of then, which is known, tells the mass, and so the
    drag before."""
    drag = (
        '[[damper]]\nname = "chute"\nbetween = ["ball.C", "ground.O"]\ndamping = 0.1\n[ground_link]\n'
        'points = { O = [0, 9] }\n[[event]]\nwhen = "rate(y(ball.C))"\nset = { "chute.damping" = "0.3*y(ball.C)" }\n'
    )
    model = workshop.model(BALL + drag, derivatives=True)
    truth = {"gravity.g": 9.81, "chute.damping": 0.14, "ball.mass": 0.55}
    run = simulate(model, params=truth, until=0.7, rtol=1e-12)
    (event,) = run.events
    assert 0.2 < event.t < 0.4
    y = run.values("ball.C.y", t=AT)["ball.C.y"]
    found = identify(model, {"ball.y": y}, AT, list(truth), rtol=1e-12)
    assert found.values == pytest.approx(truth, rel=1e-7)


def test_all_that_is_wrong_is_told_at_once(ball: Any) -> None:
    with pytest.raises(ValueError) as caught:
        identify(ball, {"ball.y": [1.0, 2.0], "ball.z": AT}, [*AT[:-1], -1.0], ["gravity.h"], sigma=-1.0, most=0)
    said = str(caught.value)
    for part in ("gravity.h", "none before 0", "ball.z", "most: found 0"):
        assert part in said, said
    with pytest.raises(ValueError, match=r"found shape \(2,\), expected \(40,\)"):
        identify(ball, {"ball.y": [1.0, 2.0]}, AT, ["gravity.g"])
    with pytest.raises(ValueError, match=r"found -1\.0, expected a standard deviation above 0"):
        identify(ball, {"ball.y": fallen(0.0)}, AT, ["gravity.g"], sigma=-1.0)
    with pytest.raises(ValueError, match="found 1 numbers, expected more than the 1 parameters"):
        identify(ball, {"ball.y": [1.0]}, [0.3], ["gravity.g"])
