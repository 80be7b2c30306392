"""What sets in within a small part of the first step, or of any other: friction, drag, a ground that gives way.

All against the equations written out and integrated by SciPy in short steps (oracles/resisted.py).
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from ccgen.runtime import sensitivities, simulate

from ..oracles.maximal import Array
from ..oracles.resisted import ARM, BEAM, MECHANISMS, Resisted, Values
from ..support.workshop import Workshop

METHODS = ("gauss", "dop853", "dopri5", "radau")
UNTIL = {"beam": 0.3, "arm": 0.3, "disc": 0.03}
ALLOWED = 100.0
"""Times rtol: what the end of a run may be off by, of coordinates and velocities of 1 or their size."""


def case(name: str, seed: int, speed: float) -> tuple[Resisted, Values, Array, Array]:
    """A mechanism, what is drawn for it, its coordinates, and its velocities of about `speed`."""
    rng = np.random.default_rng([7, seed])
    mechanism = MECHANISMS[name]
    values, q = mechanism.draw(rng)
    return mechanism, values, q, speed * rng.normal(size=mechanism.size)


def off(run: Any, right: Array) -> float:
    found = np.concatenate([run.q[-1], run.u[-1]])
    wanted = right[: len(found)]
    assert run.success
    return float(np.max(np.abs(found - wanted) / np.maximum(1.0, np.abs(wanted))))


def growth(mechanism: Any, values: dict[str, float], q: Array, u: Array, right: Array) -> float:
    """What the motion to 1 s makes of an error of 1 of the start at most: arms that swing over magnify it."""
    found, count, step = 1.0, q.size + u.size, 1e-6
    for moved in step * np.eye(count):
        end = mechanism.run(values, q + moved[: q.size], u + moved[q.size :], 1.0)
        change = np.abs(end - right)[:count] / np.maximum(1.0, np.abs(right[:count]))
        found = max(found, float(np.max(change)) / step)
    return found


@pytest.mark.parametrize("rtol", [1e-6, 1e-9, 1e-12])
@pytest.mark.parametrize("method", METHODS)
def test_a_brake_sets_in_at_once(method: str, rtol: float, workshop: Workshop) -> None:
    """A beam of 0.8 kg is let go under a brake of 0.5 N m: within a millisecond of 0.1 s."""

    def rate(_: float, y: Array) -> list[float]:
        return [y[1], -0.5 * np.tanh(y[1] / 1e-3) / 0.1 - 0.8 * 9.81 * 0.25 * np.cos(y[0]) / 0.1]

    text = BEAM.split("[[joint_friction]]")[0] + "[gravity]\n[start]\nangles = { beam = 1.0 }\n"
    right = solve_ivp(rate, (0.0, 0.1), [1.0, 0.0], method="DOP853", rtol=1e-13, atol=1e-15, max_step=1e-4).y[:, -1]
    assert right[1] == pytest.approx(-0.575987821455, abs=1e-11)
    run = simulate(workshop.model(text), until=0.1, rtol=rtol, method=method)
    assert off(run, right) <= ALLOWED * rtol


@pytest.mark.sample(8)
@pytest.mark.parametrize(
    ("name", "seed"),
    [(name, seed) for name, count in (("beam", 80), ("arm", 80), ("disc", 40)) for seed in range(count)],
)
def test_starts_from_rest(name: str, seed: int, workshop: Workshop) -> None:
    """The end, and the work of all resistances, by every method; radau near rounding agrees with SciPy."""
    mechanism, values, q, u = case(name, seed, 0.0)
    model = workshop.model(mechanism.scene)
    right = mechanism.run(values, q, u, UNTIL[name])
    options: dict[str, Any] = {"until": UNTIL[name], "params": values}
    assert off(simulate(model, q, u, rtol=1e-13, method="radau", **options), right) <= 1e-11
    for method in METHODS:
        for rtol in (1e-9, 1e-6) if method in ("gauss", "radau") else (1e-9,):
            run = simulate(model, q, u, rtol=rtol, method=method, **options)
            chance = 10.0 if method.startswith("dop") else 1.0  # estimates of one step that vanish by chance
            assert off(run, right) <= chance * ALLOWED * rtol, (method, rtol)
            assert run.energy_drift <= ALLOWED * rtol * max(1.0, abs(right[-1]))


@pytest.mark.sample(4)
@pytest.mark.parametrize(
    ("name", "seed", "speed"), [("beam", seed, 0.5) for seed in range(60)] + [("arm", seed, 0.5) for seed in range(40)]
)
def test_velocities_that_pass_through_zero(name: str, seed: int, speed: float, workshop: Workshop) -> None:
    """The change of sign lies anywhere in a step, also at its very ends."""
    mechanism, values, q, u = case(name, seed, speed)
    model = workshop.model(mechanism.scene)
    right = mechanism.run(values, q, u, 1.0)
    for method in ("gauss", "radau"):
        for rtol in (1e-9, 1e-6):
            run = simulate(model, q, u, until=1.0, rtol=rtol, method=method, params=values)
            missed, allowed = off(run, right), ALLOWED
            if missed > ALLOWED * rtol:  # of what the motion magnifies a tenth counts, and no more than tenfold
                allowed = min(max(ALLOWED, 0.1 * ALLOWED * growth(mechanism, values, q, u, right)), 10.0 * ALLOWED)
            assert missed <= allowed * rtol, (method, rtol)


@pytest.mark.parametrize(("name", "seed", "rtol"), [("beam", 18, 1e-9), ("beam", 45, 1e-6), ("arm", 30, 1e-6)])
def test_a_bend_lies_below_the_first_coefficients(name: str, seed: int, rtol: float, workshop: Workshop) -> None:
    """Errors were 835, 419 and 495 times rtol while the last coefficients counted by their ratio to the first alone."""
    mechanism, values, q, u = case(name, seed, 0.5)
    run = simulate(workshop.model(mechanism.scene), q, u, until=1.0, rtol=rtol, params=values)
    assert off(run, mechanism.run(values, q, u, 1.0)) <= ALLOWED * rtol


@pytest.mark.parametrize("rtol", [1e-9, 1e-12])
def test_smooth_loads_take_no_shorter_steps(rtol: float, workshop: Workshop) -> None:
    """What a smooth step leaves of the accelerations at its ends goes on from its last coefficients, and is not counted
    as unseen: a load that hardly acts takes few more steps than none, for which ends are not looked at."""
    scene = ARM.split("[[brake]]")[0] + "%s[gravity]\n[start]\nangles = { upper = 1.0, fore = 0.5 }\n"
    load = '[[joint_friction]]\njoints = ["elbow"]\nviscous = 1e-12\n'
    free, loaded = (simulate(workshop.model(scene % text), until=3.0, rtol=rtol) for text in ("", load))
    assert len(loaded.t) <= 1.25 * len(free.t)


@pytest.mark.sample(3)
@pytest.mark.parametrize("speed", [0.0, 0.5])
@pytest.mark.parametrize("seed", range(15))
def test_derivatives_of_the_end(seed: int, speed: float, workshop: Workshop) -> None:
    """By what resists, each times what it is derived by: against equations that are derived by complex steps."""
    mechanism, values, q, u = case("beam", seed, speed)
    acts = {"brake_0": "torque", "joint_friction_0": "dry", "drag_0": "quadratic"}
    names = [path for path in values if values[f"{path.split('.')[0]}.{acts[path.split('.')[0]]}"] > 0.0]
    n, count, step = 3, len(names), 1e-30

    def rate(t: float, z: Array) -> Array:
        y = z.reshape(count + 1, n)
        out = [np.real(mechanism.rate(values)(t, y[0]))]
        for name, column in zip(names, y[1:], strict=True):
            moved = {**values, name: complex(values[name], step)}
            out.append(np.imag(mechanism.rate(moved)(t, y[0] + 1j * step * column)) / step)
        return np.concatenate(out)

    start = np.concatenate([q, u, np.zeros(1 + count * n)])
    end = solve_ivp(rate, (0.0, 0.3), start, method="DOP853", rtol=1e-12, atol=1e-13, first_step=1e-6, max_step=6e-3)
    right = end.y[:, -1].reshape(count + 1, n)[1:, :2].T
    model = workshop.model(mechanism.scene, derivatives=True)
    for method in ("gauss", "radau"):
        found = sensitivities(model, names, ["q", "u"], q, u, until=0.3, rtol=1e-9, method=method, params=values)
        size = np.array([values[name] for name in names])
        assert np.max(np.abs(found.jacobian - right) * size) <= 1e-7


@pytest.mark.parametrize("precision", ["float", "wide"])
@pytest.mark.parametrize("seed", range(6))
def test_other_numbers(precision: str, seed: int, workshop: Workshop) -> None:
    mechanism, values, q, u = case("beam", seed, 0.0)
    rtol = {"float": 1e-5, "wide": 1e-12}[precision]
    right = mechanism.run(values, q, u, 0.3)
    run = simulate(workshop.model(mechanism.scene, precision), q, u, until=0.3, rtol=rtol, params=values)
    assert off(run, right) <= ALLOWED * rtol


def let_go(since: float, until: float) -> str:
    """The beam, which a motor holds against its weight exactly, and half as much at the end of a ramp."""
    weight = float(0.8 * 9.81 * 0.25 * np.cos(1.0))
    resisted: str = BEAM.split("[[joint_friction]]")[0].replace("torque = 0.5", "torque = 0.3")
    rows = f"[[0.0, {weight!r}], [{since!r}, {weight!r}], [{until!r}, {0.5 * weight!r}]]"
    return resisted + f'[[motor]]\njoint = "hinge"\ntable = {rows}\n[gravity]\n[start]\nangles = {{ beam = 1.0 }}\n'


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("ramp", [1e-3, 0.1])
def test_a_load_that_begins_to_go_from_rest(ramp: float, method: str, workshop: Workshop) -> None:
    """The brake sets in behind a corner in time, which ends a step and begins no phase."""
    weight = 0.8 * 9.81 * 0.25 * np.cos(1.0)

    def rate(t: float, y: Array) -> list[float]:
        held = weight * (1.0 - 0.5 * min(max(t - 0.2, 0.0) / ramp, 1.0))
        moment = held - 0.8 * 9.81 * 0.25 * np.cos(y[0]) - 0.3 * np.tanh(y[1] / 1e-3)
        return [y[1], moment / 0.1]

    y = np.array([1.0, 0.0])
    for span in ((0.2, 0.2 + ramp), (0.2 + ramp, 0.5)):
        y = solve_ivp(rate, span, y, method="DOP853", rtol=1e-13, atol=1e-15, first_step=1e-7, max_step=1e-3).y[:, -1]
    run = simulate(workshop.model(let_go(0.2, 0.2 + ramp)), until=0.5, rtol=1e-9, method=method)
    assert off(run, y) <= ALLOWED * 1e-9


@pytest.mark.parametrize("method", ["gauss", "radau"])
def test_a_brake_that_lets_go(method: str, workshop: Workshop) -> None:
    """From its creep, behind which other friction sets in: a switch of an effect; and a run that goes on from there."""
    text = BEAM.split("[[joint_friction]]")[0].replace("torque = 0.5", "torque = 3.0\nends = 0.1")
    text += "[[joint_friction]]\ndry = 0.5\nrate = 1e-4\n[gravity]\n[start]\nangles = { beam = 1.0 }\n"

    def rate(t: float, y: Array) -> list[float]:
        moment = 0.5 * np.tanh(y[1] / 1e-4) + (3.0 * np.tanh(y[1] / 1e-3) if t < 0.1 else 0.0)
        return [y[1], -(0.8 * 9.81 * 0.25 * np.cos(y[0]) + moment) / 0.1]

    y = np.array([1.0, 0.0])
    for span in ((0.0, 0.1 - 1e-15), (0.1, 0.2)):
        y = solve_ivp(rate, span, y, method="Radau", rtol=1e-12, atol=1e-14, first_step=1e-8, max_step=1e-3).y[:, -1]
    model = workshop.model(text)
    whole = simulate(model, until=0.2, rtol=1e-9, method=method)
    assert off(whole, y) <= ALLOWED * 1e-9
    part = simulate(model, until=0.1, rtol=1e-9, method=method)
    assert off(simulate(model, state=part.state, until=0.2), y) <= ALLOWED * 1e-9


@pytest.mark.parametrize("method", METHODS)
def test_behind_an_impact_that_all_but_stops(method: str, workshop: Workshop) -> None:
    """A beam falls onto a stop and comes back a thousandth as fast: friction changes its sign within the next step."""
    text = BEAM.split("[[joint_friction]]")[0] + "[gravity]\n[start]\nangles = { beam = 1.0 }\n"
    text = text.replace("[gravity]", '[[stop]]\njoint = "hinge"\nlowest = 0.9\nrestitution = 0.002\n[gravity]')

    def rate(_: float, y: Array) -> list[float]:
        return [y[1], (-0.5 * np.tanh(y[1] / 1e-3) - 0.8 * 9.81 * 0.25 * np.cos(y[0])) / 0.1]

    def touches(_: float, y: Array) -> float:
        return float(y[0] - 0.9)

    touches.terminal, touches.direction = True, -1.0  # type: ignore[attr-defined]
    tight: dict[str, Any] = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-15, "events": touches}
    down = solve_ivp(rate, (0.0, 1.0), [1.0, 0.0], max_step=1e-4, **tight)
    up = -0.002 * down.y[1, -1]
    back = solve_ivp(rate, (0.0, 1.0), [0.9, up], first_step=1e-9, max_step=1e-5, **tight)
    run = simulate(workshop.model(text), until=0.3, rtol=1e-10, method=method)
    assert run.impacts[0].t == pytest.approx(down.t[-1], abs=1e-9)
    assert run.impacts[1].t - run.impacts[0].t == pytest.approx(back.t[-1], rel=1e-6)
