"""Runs past change points: no derivative by what parts the branches, and those by all else."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

from ccgen.generator import load_scene
from ccgen.runtime import run_function, sensitivities, simulate
from ccgen.runtime.sensitivity.change_points import _on_the_way, losses
from ccgen.runtime.sensitivity.steps import Steps

from ..support.folders import SCENES
from ..support.workshop import Workshop

CRANK, ROCKER = "crank.points.B.x", "rocker.points.B.x"
PARTED = r"found a change point at t = ([\d.]+) s, at which loops can go on in two ways, and {0}, which parts them"
RHOMBUS = """name = "rhombus"
[loop]
links = 4
[start]
angular_velocities = [2.0, -1.0, 2.0, -1.0]
"""


@pytest.fixture(scope="module")
def bars(workshop: Workshop) -> Any:
    return workshop.model(load_scene(SCENES / "parallelogram.toml"), derivatives=True)


def differences(model: Any, along: dict[str, float], until: float, step: float = 2e-4) -> Any:
    """By what the end of a run changes, extrapolated from three steps."""

    def central(h: float) -> Any:
        ends = [
            simulate(
                model,
                until=until,
                rtol=1e-13,
                params={name: model.parameters[name] + side * h * part for name, part in along.items()},
            )
            for side in (1.0, -1.0)
        ]
        return np.concatenate([(getattr(ends[0], x)[-1] - getattr(ends[1], x)[-1]) / (2.0 * h) for x in ("q", "u")])

    rough, middle, fine = central(4.0 * step), central(2.0 * step), central(step)
    once = (4.0 * middle - rough) / 3.0, (4.0 * fine - middle) / 3.0
    return (16.0 * once[1] - once[0]) / 15.0


@pytest.mark.parametrize("miss", [0.0, 1e-4, 1e-2])
def test_where_a_sine_vanishes_is_found(miss: float) -> None:
    """Looked at once in a radian, from 200 phases on; and where it all but vanishes nothing is."""
    for phase in np.linspace(0.0, 1.0, 200, endpoint=False):
        times = phase + np.arange(12.0)
        values = np.column_stack([np.ones(12), np.hypot(np.sin(times), miss)])
        found = losses(times, values, 2, lambda t: np.array([1.0, np.hypot(np.sin(t), miss)]))
        zeros = [k * np.pi for k in range(5) if times[0] <= k * np.pi <= times[-1]]
        assert found == ([] if miss else pytest.approx(zeros, abs=1e-6))


def test_a_step_of_a_rounding_hides_none() -> None:
    """It has no middle: times at which rows are looked at grow, so that parabolas through three of them are some."""
    t, h = np.array([0.5, 1.0, np.nextafter(1.0, 2.0)]), np.array([0.5, np.spacing(1.0), 0.5])
    ends = np.append(t, 1.5)[:, None]
    ones = np.ones((3, 1))
    times, q = _on_the_way(Steps(t, h, ends[:-1] - 1.1, ones, ends[1:] - 1.1, ones))
    assert np.all(np.diff(times) > 0.0)
    assert q[:, 0] == pytest.approx(times - 1.1, abs=1e-15)
    found = losses(
        times, np.column_stack([np.ones(len(times)), np.abs(q[:, 0])]), 2, lambda t: np.array([1, abs(t - 1.1)])
    )
    assert found == pytest.approx([1.1], abs=1e-6)


def test_a_length_parts_a_parallelogram(bars: Any) -> None:
    """From the instant on at which its crank lies along the ground, and not before it."""
    run = simulate(bars, until=0.4, rtol=1e-13)
    flat = brentq(lambda t: np.sin(run.at(t)[0][0]), 0.1, 0.3, xtol=1e-15)
    for mode in ("tangent", "adjoint"):
        with pytest.raises(ValueError, match=PARTED.format(ROCKER)) as told:
            sensitivities(bars, [ROCKER], "rocker.angle", until=0.4, mode=mode)
        assert float(str(told.value).split(" t = ")[1].split()[0]) == pytest.approx(flat, abs=1e-7)
    with pytest.raises(ValueError, match=PARTED.format(CRANK)):
        run_function(bars, ["crank.mass", CRANK], "rocker.angle", until=0.4).jacobian([1.0, 1.0])
    before = 0.9 * flat
    found = sensitivities(bars, [ROCKER], until=before, rtol=1e-13).jacobian[:, 0]
    wanted = differences(bars, {ROCKER: 1.0}, before, 2e-5)
    assert np.abs(found - wanted).max() <= 1e-7 * np.abs(wanted).max()


@pytest.mark.parametrize(
    "along",
    [
        {"crank.mass": 1.0},
        {"gravity.g": 1.0},
        {CRANK: 1.0, ROCKER: 1.0},
        {CRANK: -0.3, ROCKER: -0.3, "rocker.mass": 1.0},
    ],
    ids=["mass", "gravity", "both lengths", "lengths and a mass"],
)
def test_what_leaves_it_a_parallelogram_has_derivatives(along: dict[str, float], bars: Any) -> None:
    """Past several change points, beside differences of runs."""
    wrt = {name: [part] for name, part in along.items()}
    found = sensitivities(bars, wrt, until=2.0, rtol=1e-13).jacobian[:, 0]
    wanted = differences(bars, along, 2.0)
    assert np.abs(found - wanted).max() <= 1e-7 * np.abs(wanted).max()


def test_one_that_misses_its_line_has_derivatives(bars: Any) -> None:
    """By a hundredth: it is a double rocker that turns back there."""
    near = bars.with_parameters({ROCKER: 1.01})
    found = sensitivities(near, [ROCKER], until=0.4, rtol=1e-13).jacobian[:, 0]
    wanted = differences(near, {ROCKER: 1.0}, 0.4, 2e-5)
    assert np.abs(found - wanted).max() <= 1e-6 * np.abs(wanted).max()


def test_a_floating_rhombus(workshop: Workshop) -> None:
    """It folds: by lengths refused from there on, by masses not."""
    model = workshop.model(RHOMBUS, derivatives=True)
    run = simulate(model, until=1.0)
    inner = run.q[:, 3] - run.q[:, 2]
    assert np.any(np.sin(inner[1:]) * np.sin(inner[:-1]) < 0.0)
    with pytest.raises(ValueError, match=PARTED.format("link_0.length")):
        sensitivities(model, ["link_0.length"], until=1.0)
    found = sensitivities(model, ["link_0.mass"], until=1.0, rtol=1e-13).jacobian[:, 0]
    wanted = differences(model, {"link_0.mass": 1.0}, 1.0)
    assert np.abs(found - wanted).max() <= 1e-7 * np.abs(wanted).max()


def test_two_that_come_there_at_once(workshop: Workshop) -> None:
    """The least singular value is not simple there; each length parts its own loop, or with its opposite one none."""
    text = (SCENES / "parallelogram.toml").read_text()
    links = text[text.index("[[link]]") : text.index("[start]")]
    for name in ("crank", "coupler", "rocker", "motor", "knee", "elbow", "pivot"):
        links = links.replace(f'"{name}', f'"{name}2')
    twice = text.replace("[start]", links + "[start]").replace(
        'angles = { crank = "60 deg", coupler = 0.0, rocker = "60 deg" }\nangular_velocities = { crank = 10.0 }',
        'angles = { crank = "60 deg", coupler = 0.0, rocker = "60 deg", crank2 = "60 deg", coupler2 = 0.0, '
        'rocker2 = "60 deg" }\nangular_velocities = { crank = 10.0, crank2 = 10.0 }',
    )
    model = workshop.model(twice, derivatives=True)
    for name in (ROCKER, ROCKER.replace("rocker", "rocker2")):
        with pytest.raises(ValueError, match=PARTED.format(name)):
            sensitivities(model, [name], until=0.4)
    assert np.all(np.isfinite(sensitivities(model, {ROCKER: [1.0], CRANK: [1.0]}, until=0.4).jacobian))
