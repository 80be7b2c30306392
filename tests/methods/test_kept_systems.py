"""What steps keep of those before them, accelerations, Jacobians, factors: what these know nothing of is seen."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from ccgen.runtime import simulate

from ..support.workshop import Workshop

ROD = """
name = "turned-rod"
[[link]]
name = "rod"
rod = { mass = 1.0 }
points = { A = [0, 0], B = [1, 0] }
[ground_link]
points = { O = [0, 0] }
[[joint]]
name = "hinge"
between = ["ground.O", "rod.A"]
[[input]]
name = "torque"
joint = "hinge"
[start]
angles = { rod = 0.3 }
"""
DRY = ROD.replace("turned", "dry").replace(
    "[start]", '[[joint_friction]]\njoints = ["hinge"]\ndry = 1.0\nrate = 1e-7\n[start]'
)
INERTIA = 1.0 / 3.0


def off(run: Any, q: float, u: float) -> float:
    """Of the end, absolute or relative, whichever is less."""
    assert run.success, run.message
    return float(max(abs(run.q[-1, 0] - q) / max(1.0, abs(q)), abs(run.u[-1, 0] - u) / max(1.0, abs(u))))


@pytest.mark.parametrize("rtol", [1e-7, 1e-9, 1e-11])
def test_a_torque_jumps_within_a_step(rtol: float, workshop: Workshop) -> None:
    """Steps become a thousand times shorter there than the one before, whose accelerations know nothing of the jump."""
    model = workshop.model(ROD)
    rng = np.random.default_rng(1)
    for at, by in [
        (0.296391, 2.48164),
        *zip(rng.uniform(0.2, 0.8, 20), 10.0 ** rng.uniform(-3.0, 0.5, 20), strict=True),
    ]:

        def torque(t: float, _: Any, __: Any, at: float = at, by: float = by) -> dict[str, float]:
            return {"torque": 1.0 + (by if t >= at else 0.0)}

        run = simulate(model, until=1.0, rtol=rtol, method="radau", inputs=torque)
        left = 1.0 - at
        q, u = 0.3 + (0.5 + by * left**2 / 2.0) / INERTIA, (1.0 + by * left) / INERTIA
        assert off(run, q, u) <= 10.0 * rtol, (at, by)


@pytest.mark.parametrize("rtol", [1e-3, 1e-4, 1e-6])
@pytest.mark.parametrize("within", [0.1, 0.01, 0.001])
def test_what_was_stiff_is_let_go(within: float, rtol: float, workshop: Workshop) -> None:
    """Damping of 1e8 N m s holds the rod and vanishes about 0.5 s: by systems that still have it, all corrections are
    small, and the rod would never begin to turn."""

    def damping(t: float) -> float:
        return float(0.5e8 * (1.0 - np.tanh((t - 0.5) / within)))

    def rate(t: float, y: Any) -> list[float]:
        return [y[1], (1.0 - damping(t) * y[1]) / INERTIA]

    tight: dict[str, Any] = {"method": "Radau", "rtol": 1e-10, "atol": 1e-12, "max_step": within / 5.0}
    right = solve_ivp(rate, (0.0, 1.0), [0.3, 0.0], **tight).y[:, -1]
    run = simulate(
        workshop.model(ROD),
        until=1.0,
        rtol=rtol,
        method="radau",
        inputs=lambda t, _, u: {"torque": 1.0 - damping(t) * u[0]},
    )
    assert off(run, *right) <= 10.0 * rtol


@pytest.mark.parametrize("rtol", [1e-4, 1e-6])
@pytest.mark.parametrize("apart", [0.005, 0.05])
def test_dry_friction_breaks_away(apart: float, rtol: float, workshop: Workshop) -> None:
    """From creep at 1e-7 rad/s, ten million to one stiff, the rod slides from 0.25 s on, I du/dt = 0.4 (t - 0.25),
    but for friction's last part, 1e-6 s of the break-away."""
    t = np.arange(0.0, 1.0 + apart / 2.0, apart)
    table = {"t": t, "torque": 0.9 + 0.4 * t}
    run = simulate(workshop.model(DRY), until=1.0, rtol=rtol, method="radau", inputs=table)
    slides = 0.75
    q, u = 0.3 + 0.4 * slides**3 / 6.0 / INERTIA, 0.4 * slides**2 / 2.0 / INERTIA
    assert off(run, q, u) <= 10.0 * rtol


@pytest.mark.parametrize("rtol", [1e-3, 1e-4, 1e-6])
@pytest.mark.parametrize("method", ["gauss", "dop853", "dopri5", "radau"])
def test_a_state_goes_on_under_another_torque(method: str, rtol: float, workshop: Workshop) -> None:
    """From 1 N m to -20 N m: nothing that steps remember is of the second, and they are as exact as those of a run that
    begins there."""
    model = workshop.model(ROD + "[gravity]\n")
    first = simulate(model, until=1.0, rtol=rtol, method=method, inputs={"torque": 1.0})

    def rate(_: float, y: Any) -> list[float]:
        return [y[1], (-20.0 - 9.81 * 0.5 * np.cos(y[0])) / INERTIA]

    begin = [first.q[-1, 0], first.u[-1, 0]]
    right = solve_ivp(rate, (0.0, 1.0), begin, method="DOP853", rtol=1e-12, atol=1e-12).y[:, -1]
    second = simulate(model, state=first.state, until=2.0, inputs={"torque": -20.0})
    anew = simulate(model, first.q[-1], first.u[-1], until=1.0, rtol=rtol, method=method, inputs={"torque": -20.0})
    assert off(second, *right) <= 10.0 * (off(anew, *right) + rtol)
