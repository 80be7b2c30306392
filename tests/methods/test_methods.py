"""The integration methods: conditions on their coefficients, order in flight and across impacts, and their traits."""

from __future__ import annotations

import re
from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.special import ellipj, ellipk, ellipkinc

from ccgen.generator import load_scene, loop
from ccgen.runtime import methods, simulate

from ..oracles import polygons
from ..oracles.maximal import Array
from ..support.folders import ROOT
from ..support.pendulum import MODULUS, OMEGA, PENDULUM, exact_pendulum
from ..support.workshop import Workshop

METHOD_FILES = ROOT / "runtime" / "core" / "methods"
METHODS = ("dop853", "gauss", "dopri5", "radau")

FLOOR = """[[ground]]
point = [0, -0.8]
restitution = 0.8
"""


RULE = "../algebra/gauss_rule.h"


def table(file: str, name: str) -> Array:
    """A table of numbers as a C source has it."""
    text = (METHOD_FILES / file).read_text()
    found = re.search(rf"double {name}(?:\[\w+\])+ = \{{(.*?)\}};", text, re.S)
    assert found, name
    rows = re.findall(r"\{([^{}]*)\}", found[1]) or [found[1]]
    numbers = [[quotient(x) for x in row.split(",") if x.strip()] for row in rows]
    width = max(map(len, numbers))
    return np.squeeze(np.array([row + [np.longdouble(0)] * (width - len(row)) for row in numbers]))


def quotient(text: str) -> np.longdouble:
    """A number, or one over another, in all its digits."""
    above, _, below = (part.strip().removesuffix("L") for part in text.partition("/"))
    return np.longdouble(above) / np.longdouble(below or "1")


def scalar(file: str, name: str) -> float:
    found = re.search(rf"\b{name} = ([-0-9.e]+)", (METHOD_FILES / file).read_text())
    assert found
    return float(found[1])


# -- coefficients --------------------------------------------------------------------------------------------------


def collocates(a: Array, b: Array, c: Array, order: int) -> None:
    """Quadrature of the order, and stages that are integrals of polynomials of as many degrees as there are stages."""
    for k in range(1, order + 1):
        assert abs(b @ c ** (k - 1) - 1.0 / k) <= 4e-17 * 8
    for k in range(1, len(c) + 1):
        assert np.max(np.abs(a @ c ** (k - 1) - c**k / k)) <= 1e-16


def test_gauss_collocates() -> None:
    a, twice = table("gauss_tableau.h", "ONCE").T, table("gauss_tableau.h", "TWICE").T
    b, c = table(RULE, "WEIGHT"), table(RULE, "NODE")
    collocates(a, b, c, 16)
    assert np.max(np.abs(a @ a - twice)) <= 1e-16
    assert np.max(np.abs(b * (1 - c) - table("gauss_tableau.h", "WEIGHT2"))) <= 1e-17
    assert abs(b @ c**16 - 1 / 17) > 1e-12  # 16 it is, and no more


def test_gauss_is_symmetric_and_symplectic() -> None:
    a, b, c = table("gauss_tableau.h", "ONCE").T, table(RULE, "WEIGHT"), table(RULE, "NODE")
    assert np.max(np.abs(c + c[::-1] - 1)) <= 1e-16
    assert np.max(np.abs(a + a[::-1, ::-1] - b)) <= 1e-16
    assert np.max(np.abs(b[:, None] * a + (b[:, None] * a).T - np.outer(b, b))) <= 1e-17


def test_gauss_finds_legendre_coefficients() -> None:
    x = 2.0 * np.asarray(table(RULE, "NODE"), dtype=float) - 1.0
    matrix = np.asarray(table("gauss_tableau.h", "LEGENDRE"), dtype=float)
    values = np.polynomial.legendre.legvander(x, 7)
    assert np.max(np.abs(matrix.T @ values - np.eye(8))) <= 3e-15


def test_radau_collocates_and_falls_apart_into_modes() -> None:
    file = "radau_tableau.h"
    a, c = table(file, "ONCE"), table(file, "NODE")
    collocates(a, a[2], c, 5)
    assert np.max(np.abs(a @ a - table(file, "TWICE"))) <= 1e-16
    real, re_, im = (scalar(file, name) for name in ("REAL", "COMPLEX_REAL", "COMPLEX_IMAGINARY"))
    blocks = np.array([[real, 0, 0], [0, re_, im], [0, -im, re_]])
    assert np.max(np.abs(table(file, "INVERSE") @ a @ table(file, "MODES") - blocks)) <= 1e-15
    estimate = table(file, "ESTIMATE")  # with `real` at the start: a quadrature of order 3 less the end of the step
    weights = estimate @ a
    assert abs(real + weights.sum()) <= 1e-16
    for k in (2, 3):
        assert abs(weights @ c ** (k - 1)) <= 1e-16


def test_dopri5_meets_its_conditions() -> None:
    a, c, e = (table("dopri5_tableau.h", name) for name in ("A", "C", "E"))
    a = np.pad(a, ((0, 0), (0, 7 - a.shape[1])))
    assert np.max(np.abs(a.sum(axis=1) - c)) <= 1e-15
    b = a[6]
    for k in range(1, 6):
        assert abs(b @ c ** (k - 1) - 1 / k) <= 1e-16 * 4
    trees = {1 / 6: b @ a @ c, 1 / 12: b @ a @ c**2, 1 / 8: (b * c) @ a @ c, 1 / 24: b @ a @ a @ c}
    trees |= {1 / 20: b @ a @ c**3, 1 / 10: (b * c**2) @ a @ c, 1 / 15: (b * c) @ a @ c**2}
    trees |= {
        1 / 60: b @ a @ a @ c**2,
        1 / 40: b @ a @ (c * (a @ c)),
        1 / 30: (b * c) @ a @ a @ c,
        1 / 120: b @ a @ a @ a @ c,
    }
    for wanted, found in trees.items():
        assert abs(found - wanted) <= 1e-15
    assert abs(e.sum()) <= 1e-16
    for k in (2, 3, 4):
        assert abs(e @ c ** (k - 1)) <= 1e-16
    assert abs(e @ c**4) > 1e-4


# -- order ---------------------------------------------------------------------------------------------------------


STEPS = {"gauss": (2, 3, 4, 5), "dop853": (10, 14, 20, 28), "dopri5": (40, 60, 90, 140), "radau": (40, 60, 90, 140)}
ORDERS = {"gauss": (13.5, 19.0), "dop853": (7.0, 9.5), "dopri5": (4.6, 5.6), "radau": (4.6, 5.6)}


def test_all_methods_are_tested() -> None:
    assert sorted(methods(estimating=True)) == sorted(METHODS)


@pytest.mark.quick
@pytest.mark.parametrize("method", METHODS)
def test_order_in_flight(method: str, workshop: Workshop) -> None:
    """Against the exact swing of a rod, at fixed steps."""
    model = workshop.model(PENDULUM)
    errors = []
    for count in STEPS[method]:
        run = simulate(model, until=1.5, step=1.5 / count, method=method)
        assert run.success
        assert len(run.t) == count + 1
        errors.append(np.max(np.abs(run.q[:, 0] - exact_pendulum(run.t))))
    order = -np.polyfit(np.log(STEPS[method]), np.log(errors), 1)[0]
    assert ORDERS[method][0] <= order <= ORDERS[method][1], errors


@cache
def bounces(until: float, e: float = 0.8) -> tuple[tuple[float, ...], float, float]:
    """A rod that swings down onto a floor under its tip: times of its impacts, angle and rate at the end, exactly.

    Energy gives the rate at the floor; between impacts the rod swings up and back on a symmetric arc.
    """
    at, t, rate, times = -np.arcsin(0.8), 0.0, 0.0, []
    modulus, phase = MODULUS, -ellipk(MODULUS)  # level and at rest: a quarter of a period before the lowest place
    while True:
        deflection = at + np.pi / 2
        here = ellipkinc(np.arcsin(np.sin(deflection / 2) / np.sqrt(modulus)), modulus)
        hit = t + (-here - phase) / OMEGA if not times else t + (2 * ellipk(modulus) - 2 * here) / OMEGA
        if hit > until:
            break
        times.append(hit)
        rate = 2 * OMEGA * np.sqrt(modulus - np.sin(deflection / 2) ** 2)
        rate, t = e * rate, hit
        modulus = np.sin(deflection / 2) ** 2 + (rate / (2 * OMEGA)) ** 2
    here = ellipkinc(np.arcsin(np.sin((at + np.pi / 2) / 2) / np.sqrt(modulus)), modulus)
    sn, cn, *_ = ellipj(OMEGA * (until - t) + here, modulus)
    return tuple(times), 2 * np.arcsin(np.sqrt(modulus) * sn) - np.pi / 2, 2 * OMEGA * np.sqrt(modulus) * cn


BOUNCE_STEPS = {"gauss": (4, 5, 6), "dop853": (14, 20, 28, 36), "dopri5": (40, 60, 90, 140), "radau": (40, 60, 90, 140)}


@pytest.mark.parametrize("method", METHODS)
def test_order_across_impacts(method: str, workshop: Workshop) -> None:
    """Times of the impacts and the state after them keep the order of the method."""
    model = workshop.model(PENDULUM.replace("method-pendulum", "method-bounce") + FLOOR)
    times, angle, rate = bounces(1.3)
    assert len(times) >= 2
    errors = []
    for count in BOUNCE_STEPS[method]:
        run = simulate(model, until=1.3, step=1.3 / count, method=method)
        assert run.success, run.message
        found = np.array([impact.t for impact in run.impacts])
        assert found.shape == np.shape(times)
        end = max(abs(run.q[-1, 0] - angle), abs(run.u[-1, 0] - rate))
        errors.append(max(np.max(np.abs(found - times)), end))
    order = -np.polyfit(np.log(BOUNCE_STEPS[method]), np.log(errors), 1)[0]
    assert order >= 0.8 * {"gauss": 16, "dop853": 8, "dopri5": 5, "radau": 5}[method], errors


@pytest.mark.quick
@pytest.mark.parametrize("method", METHODS)
def test_error_follows_the_tolerance(method: str, workshop: Workshop) -> None:
    model = workshop.model(PENDULUM.replace("method-pendulum", "method-bounce") + FLOOR)
    times, angle, rate = bounces(1.3)
    for rtol in (1e-5, 1e-7, 1e-9):
        run = simulate(model, until=1.3, rtol=rtol, method=method)
        assert run.success
        assert np.max(np.abs(np.array([impact.t for impact in run.impacts]) - times)) <= 10 * rtol
        assert abs(run.q[-1, 0] - angle) <= 30 * rtol
        assert abs(run.u[-1, 0] - rate) <= 100 * rtol


# -- traits --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("method", METHODS)
def test_methods_agree_on_a_falling_ring(method: str, workshop: Workshop) -> None:
    model = workshop.model(loop(6, gravity=True))
    q, u = model.state_from_poses(*polygons.perturbed(6))
    wanted = simulate(model, q, u, until=2.0, rtol=1e-13, method="gauss" if method == "dop853" else "dop853")
    run = simulate(model, q, u, until=2.0, rtol=1e-10, method=method)
    assert run.success
    assert np.max(np.abs(run.q[-1] - wanted.q[-1])) <= 3e-9
    between, _ = run.at(np.linspace(0.0, 2.0, 17))
    other, _ = wanted.at(np.linspace(0.0, 2.0, 17))
    assert np.max(np.abs(between - other)) <= 1e-8


@pytest.mark.parametrize("method", METHODS)
def test_work_closes_the_energy_balance(method: str, workshop: Workshop) -> None:
    """The stiff rocker loses most of its energy in its hinge; what it loses is accounted for."""
    model = workshop.model(load_scene(ROOT / "scenes" / "stiff-rocker.toml"))
    run = simulate(model, until=0.02, rtol=1e-9, method=method)
    lost = float(np.diff(np.sum(model.energy(run.q[[0, -1]], run.u[[0, -1]]), axis=0))[0])
    assert run.success
    assert lost < -0.1
    assert run.energy_drift <= 1e-7


@pytest.mark.parametrize("method", METHODS)
def test_an_input_over_time(method: str, workshop: Workshop) -> None:
    """A torque at the hinge by a function and by a table, without gravity: θ'' = T / I."""
    text = PENDULUM.replace("method-pendulum", "method-driven").replace("[gravity]\ng = 9.81\n", "")
    model = workshop.model(text + '[[input]]\nname = "torque"\njoint = "joint_0"\n')
    run = simulate(model, until=2.0, rtol=1e-9, method=method, inputs=lambda t, q, u: {"torque": np.cos(3 * t)})
    assert abs(run.q[-1, 0] - 3.0 * (1 - np.cos(6.0)) / 9.0) <= 1e-7
    run = simulate(model, until=2.0, rtol=1e-9, method=method, inputs={"t": [0.0, 1.0, 3.0], "torque": [0.0, 1.0, 1.0]})
    assert abs(run.u[-1, 0] - 3.0 * 1.5) <= 1e-7


def test_radau_takes_no_more_than_its_order_asks_for(workshop: Workshop) -> None:
    """Steps as the error of order 5 has them, not as the embedded formula of order 3 does: at a thousandth of the
    tolerance four times as many, not six; and what Newton's method needs is kept from step to step."""
    model = workshop.model(PENDULUM.replace("method-pendulum", "method-bounce") + FLOOR)
    times, angle, rate = bounces(1.3)
    coarse, fine = (simulate(model, until=1.3, rtol=rtol, method="radau") for rtol in (1e-9, 1e-12))
    assert np.max(np.abs(np.array([impact.t for impact in fine.impacts]) - times)) <= 1e-12
    assert max(abs(fine.q[-1, 0] - angle), abs(fine.u[-1, 0] - rate)) <= 1e-11
    assert len(fine.t) <= 4.5 * len(coarse.t) and fine.nfev <= 8_000


def test_radau_takes_long_steps_where_others_cannot(workshop: Workshop) -> None:
    model = workshop.model(load_scene(ROOT / "scenes" / "stiff-rocker.toml"))
    slow = simulate(model, until=0.5, rtol=1e-6, method="dop853")
    quick = simulate(model, until=0.5, rtol=1e-6, method="radau")
    assert quick.success
    assert 10 * len(quick.t) < len(slow.t)
    assert np.max(np.abs(quick.q[-1] - slow.q[-1])) <= 1e-5


@pytest.mark.quick
def test_gauss_keeps_energy_for_long(workshop: Workshop) -> None:
    """A symplectic method at fixed step: the energy error of the pendulum swings, and does not grow, in 3000 steps."""
    model = workshop.model(PENDULUM)
    run = simulate(model, until=1500.0, step=0.5, method="gauss")
    energy = np.sum(model.energy(run.q, run.u), axis=0)
    early, late = np.ptp(energy[:300]), np.max(np.abs(energy[-300:] - energy[0]))
    assert run.success
    assert 1e-12 < early < 1e-4
    assert late <= 2.0 * early


def test_sums_are_compensated(workshop: Workshop) -> None:
    """A hundred thousand small steps of a free rod: the rounding of a step does not add up."""
    model = workshop.model("name = 'method-free'\n[chain]\nlinks = 1\n")
    q, _ = model.start()
    run = simulate(model, q, np.array([0.0, -0.35, 0.7]), until=100.0, step=0.001, method="gauss")
    spin = 0.7 * run.t
    turned = 0.5 * np.column_stack([np.cos(spin), np.sin(spin)]) - [0.5, 0.0]
    assert np.max(np.abs(run.q[:, 2] - spin)) <= 3e-14
    assert np.max(np.abs(run.q[:, :2] + turned - q[:2])) <= 1e-13


@pytest.mark.parametrize("rtol", [1e-6, 1e-8, 1e-10, 1e-12, 1e-14])
@pytest.mark.parametrize("name", ["n-four-bar", "parallelogram"])
def test_steps_whose_sweeps_do_not_converge_are_left_to_dop853(name: str, rtol: float, workshop: Workshop) -> None:
    """Singular places are passed, on the branch on which all uprights stay parallel, at every tolerance."""
    model: Any = workshop.model(load_scene(ROOT / "scenes" / f"{name}.toml"))
    run = simulate(model, rtol=rtol, method="gauss")
    uprights = slice(0, 3) if name == "n-four-bar" else slice(0, 3, 2)
    assert run.success, run.message
    assert np.max(np.ptp(run.q[:, uprights], axis=1)) <= 1e-3 * max(1.0, rtol / 1e-6)
    assert run.energy_drift <= 1000 * rtol + 1e-6  # as DOP853 keeps it


@pytest.mark.parametrize("drift", ["left", "damped"])
@pytest.mark.parametrize("name", ["falling-hexagon", "parallelogram"])
def test_sweeps_are_measured_across_the_closure_where_nothing_projects(
    name: str, drift: str, workshop: Workshop
) -> None:
    """Damped loops are stiff: steps of `gauss` whose sweeps do not contract go to DOP853. Those once counted as done
    that had not converged across the closure alone, as if that were put right: the hexagon was 1e-6 m open."""
    run = simulate(workshop.model(load_scene(ROOT / "scenes" / f"{name}.toml")), until=1.0, rtol=1e-9, drift=drift)
    assert run.success, run.message
    assert run.method == "gauss"
    assert run.closure_max <= 1e-9


@pytest.mark.quick
def test_a_step_back_is_as_exact_as_one_forward(workshop: Workshop) -> None:
    """`Run.at` takes such steps; those by `gauss` were of another method, and off by 10⁻⁸."""
    advance = simulate(workshop.model(PENDULUM), until=0.1, rtol=1e-12).advance
    assert advance is not None and advance.method == "gauss"
    angle = exact_pendulum(np.array([0.3, 0.4, 0.5]))
    speed = -np.sqrt(-3.0 * 9.81 * np.sin(angle[1]))
    for way in (1, -1):
        found, _ = advance(0.4, np.array([angle[1]]), np.array([speed]), 0.1 * way)
        assert found[0] == pytest.approx(angle[1 + way], abs=1e-14)


def test_unknown_methods_are_refused_with_all_names(workshop: Workshop) -> None:
    with pytest.raises(ValueError, match="found 'rk4', expected one of " + ", ".join(methods())):
        simulate(workshop.model(PENDULUM), method="rk4")
