"""Runs as functions of JAX, PyTorch and CasADi: their own derivatives beside a closed form, and wrong use.

Skipped one by one where a package is missing.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from ccgen.runtime import run_function

from ..support.bounced import AT, BOUNCED, OUTPUTS, WRT, X, bounced, bounced_jacobian
from ..support.workshop import Workshop

MOVED = X * np.array([1.1, -0.9, 2.0, 0.8, 1.05, 0.9, 1.3])
NEAR: dict[str, Any] = {"rel": 1e-10, "abs": 1e-11}
WHY = "needs the package {0}: pip install 'ccgen[{0}]'"


@pytest.fixture(scope="module")
def function(workshop: Workshop) -> Any:
    return run_function(workshop.model(BOUNCED, derivatives=True), WRT, OUTPUTS, at=AT, inputs={"push": 0.8})


@pytest.mark.parametrize("package", ["jax", "torch", "casadi"])
def test_a_missing_package_is_named(package: str, function: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(ImportError, match=rf"needs the package {package}, .*pip install \"ccgen\[{package}\]\""):
        getattr(function, f"to_{package}")()


# -- JAX ---------------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def jax() -> Iterator[Any]:
    jax = pytest.importorskip("jax", reason=WHY.format("jax"))
    before = jax.config.jax_enable_x64
    jax.config.update("jax_enable_x64", True)
    yield jax
    jax.config.update("jax_enable_x64", before)


def test_jax_differentiates_both_ways(function: Any, jax: Any) -> None:
    run, x, wanted = function.to_jax(), jax.numpy.asarray(MOVED), bounced_jacobian(MOVED)
    assert np.asarray(run(x)) == pytest.approx(bounced(MOVED), rel=1e-11)
    for jacobian in (jax.jacobian(run), jax.jacrev(run), jax.jacfwd(run), jax.jit(jax.jacrev(run))):
        assert np.asarray(jacobian(x)) == pytest.approx(wanted, **NEAR)
    squares = jax.value_and_grad(lambda x: (run(x) ** 2).sum())
    for ask in (squares, jax.jit(squares)):
        value, gradient = ask(x)
        assert float(value) == pytest.approx(np.sum(bounced(MOVED) ** 2), rel=1e-11)
        assert np.asarray(gradient) == pytest.approx(2.0 * bounced(MOVED) @ wanted, **NEAR)
    v = jax.numpy.arange(7.0)
    assert np.asarray(jax.jvp(run, (x,), (v,))[1]) == pytest.approx(wanted @ np.arange(7.0), **NEAR)


def test_jax_maps_over_many(function: Any, jax: Any) -> None:
    many = np.stack([X, MOVED, 0.9 * X])
    run = function.to_jax()
    assert np.asarray(jax.vmap(run)(many)) == pytest.approx(np.array([bounced(x) for x in many]), rel=1e-11)
    for reverse in (False, True):
        jacobians = jax.jit(jax.vmap(jax.jacrev(function.to_jax(reverse=reverse))))(many)
        assert np.asarray(jacobians) == pytest.approx(np.array([bounced_jacobian(x) for x in many]), **NEAR)


def test_jax_backwards_asks_for_no_jacobian(function: Any, jax: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    asked, vjp = [], function.vjp
    monkeypatch.setattr(function, "vjp", lambda x, w: asked.append(w) or vjp(x, w))
    run, w = function.to_jax(reverse=True), np.array([1.0, -2.0, 3.0, 0.5])
    found = jax.jit(jax.grad(lambda x: run(x) @ w))(MOVED)
    assert np.asarray(found) == pytest.approx(w @ bounced_jacobian(MOVED), **NEAR)
    assert len(asked) == 1 and np.array_equal(asked[0], w)
    with pytest.raises(TypeError, match="forward-mode"):
        jax.jacfwd(run)(MOVED)


def test_wrong_use_of_jax_is_refused(function: Any, jax: Any) -> None:
    run, x = function.to_jax(), jax.numpy.asarray(MOVED)
    with pytest.raises(TypeError, match="x: found JAX numbers of type float32, expected float64"):
        run(x.astype("float32"))
    with pytest.raises(ValueError, match=r"x: found shape \(6,\), expected \(7,\): u0\[ball.x\]"):
        jax.jit(run)(x[:6])
    with pytest.raises(Exception, match=r"ball.mass: found -2.0, expected a positive number"):
        run(x.at[3].set(-2.0))
    with pytest.raises(ValueError, match="JVP"):  # JAX says that a callback has none
        jax.hessian(lambda x: run(x).sum())(x)
    jax.config.update("jax_enable_x64", False)
    try:
        for ask in (function.to_jax, lambda: run(MOVED)):
            with pytest.raises(ValueError, match=r"found 32-bit numbers, expected doubles.*jax_enable_x64"):
                ask()
    finally:
        jax.config.update("jax_enable_x64", True)


# -- PyTorch -----------------------------------------------------------------------------------------------------------


OWN = pytest.mark.filterwarnings("ignore:`torch.jit.script` is deprecated:DeprecationWarning")
"""What PyTorch warns of in its own code."""


@pytest.fixture(scope="module")
def torch() -> Any:
    return pytest.importorskip("torch", reason=WHY.format("torch"))


@OWN
def test_torch_differentiates_both_ways(function: Any, torch: Any) -> None:
    run, wanted = function.to_torch(), bounced_jacobian(MOVED)
    x = torch.tensor(MOVED, requires_grad=True)
    assert run(x).detach().numpy() == pytest.approx(bounced(MOVED), rel=1e-11)
    (run(x) ** 2).sum().backward()
    assert x.grad.numpy() == pytest.approx(2.0 * bounced(MOVED) @ wanted, **NEAR)
    for jacobian in (torch.func.jacrev(run), torch.func.jacfwd(run)):
        assert jacobian(x).detach().numpy() == pytest.approx(wanted, **NEAR)
    many = torch.tensor(np.stack([X, MOVED]))
    assert torch.func.vmap(run)(many).numpy() == pytest.approx(np.array([bounced(X), bounced(MOVED)]), rel=1e-11)


@OWN
def test_torch_checks_the_gradient(function: Any, torch: Any) -> None:
    """By its own differences, backwards and forwards."""
    x = torch.tensor(MOVED, requires_grad=True)
    assert torch.autograd.gradcheck(function.to_torch(), x, eps=1e-6, atol=1e-6, rtol=1e-6, check_forward_ad=True)


@OWN
def test_wrong_use_of_torch_is_refused(function: Any, torch: Any) -> None:
    run, x = function.to_torch(), torch.tensor(MOVED, requires_grad=True)
    with pytest.raises(TypeError, match=r"x: found PyTorch numbers of type torch.float32, expected torch.float64"):
        run(x.float())
    with pytest.raises(TypeError, match="x: found ndarray, expected a tensor of float64"):
        run(MOVED)
    with pytest.raises(ValueError, match=r"x: found shape \(7, 1\), expected \(7,\)"):
        run(x[:, None])
    with pytest.raises(ValueError, match="expected one on the CPU"):
        run(x.to("meta"))
    with pytest.raises(ValueError, match=r"ball.mass: found -2.0, expected a positive number"):
        run(torch.tensor([*MOVED[:3], -2.0, *MOVED[4:]], dtype=torch.float64))
    for second in (torch.func.hessian, lambda f: lambda x: torch.autograd.functional.hessian(f, x)):
        with pytest.raises(NotImplementedError, match="a second derivative asked for"):
            second(lambda x: run(x).sum())(x)


# -- CasADi ------------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def casadi() -> Any:
    return pytest.importorskip("casadi", reason=WHY.format("casadi"))


def test_casadi_differentiates_both_ways(function: Any, casadi: Any) -> None:
    run, wanted = function.to_casadi("bounced"), bounced_jacobian(MOVED)
    x, v = casadi.MX.sym("x", 7), casadi.DM(np.arange(7.0))
    asked = {
        "values": (run(x), bounced(MOVED)),
        "jacobian": (casadi.jacobian(run(x), x), wanted),
        "backwards": (casadi.gradient(casadi.sumsqr(run(x)), x), 2.0 * bounced(MOVED) @ wanted),
        "along": (casadi.jtimes(run(x), x, v), wanted @ np.arange(7.0)),
    }
    for name, (expression, value) in asked.items():
        found = np.array(casadi.Function(name, [x], [expression])(MOVED))
        assert found.reshape(value.shape) == pytest.approx(value, **NEAR), name


def test_ipopt_throws_a_ball_to_a_place(function: Any, casadi: Any) -> None:
    """The least push and change of the throw with which the ball is where it shall be: beside the solution of the same
    problem with the closed form in place of the run."""
    run = function.to_casadi()

    def solved(run: Any) -> Any:
        throw, push = casadi.MX.sym("throw", 2), casadi.MX.sym("push")
        x = casadi.vertcat(throw, X[2:6], push)
        problem = {
            "x": casadi.vertcat(throw, push),
            "f": casadi.sumsqr(throw - X[:2]) + push**2,
            "g": run(x)[casadi.DM([1, 3])],
        }
        quiet = {"ipopt.print_level": 0, "ipopt.sb": "yes", "print_time": False}
        options = quiet | {"ipopt.hessian_approximation": "limited-memory", "ipopt.tol": 1e-12}
        solver = casadi.nlpsol("solver", "ipopt", problem, options)
        found = solver(x0=[1.5, 0.5, 0.0], lbg=[1.8, 0.75], ubg=[1.8, 0.75])
        assert solver.stats()["success"], solver.stats()["return_status"]
        return np.array(found["x"]).ravel()

    def formula(x: Any) -> Any:
        vx, vy, m, g, e, push = (x[k] for k in (0, 1, 3, 4, 5, 6))
        sped = casadi.sqrt(vy**2 + 2.0 * g)
        late, s = AT[1], AT[1] - (vy + sped) / g
        at_last = vx * late + push * late**2 / (2.0 * m)
        return casadi.vertcat(0.0, at_last, 0.0, e * sped * s - g * s**2 / 2.0)

    found, wanted = solved(run), solved(formula)
    assert found == pytest.approx(wanted, rel=1e-7, abs=1e-8)
    x = np.array([*found[:2], *X[2:6], found[2]])
    assert bounced(x)[[1, 3]] == pytest.approx([1.8, 0.75], abs=1e-10)


def test_wrong_use_of_casadi_is_refused(function: Any, casadi: Any) -> None:
    for name in ("a run", "jac", "2nd", "run_", 3):
        with pytest.raises(ValueError, match=r"name: found .*, as CasADi has names"):
            function.to_casadi(name)
    run = function.to_casadi()
    with pytest.raises(RuntimeError, match="7-by-1"):  # CasADi's own words
        run(np.ones(6))
    with pytest.raises(RuntimeError, match=r"ball.mass: found -2.0, expected a positive number"):
        run([*MOVED[:3], -2.0, *MOVED[4:]])
    x = casadi.MX.sym("x", 7)
    with pytest.raises(RuntimeError, match="Derivatives cannot be calculated"):
        casadi.hessian(casadi.sumsqr(run(x)), x)
