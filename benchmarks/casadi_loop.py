"""Forward dynamics of W(n) by CasADi: symbolic sparse system in maximal coordinates, written out as C."""

import sys
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
from workload import GRAVITY, INERTIA, LENGTH, MASS

FUNCTION, JACOBIAN = "casadi_acceleration", "casadi_jacobian"


def version() -> str:
    """Version of the CasADi at hand; ends the program with advice where there is none."""
    try:
        return str(import_module("casadi").__version__)
    except ModuleNotFoundError:
        sys.exit("CasADi is not installed; run: python -m pip install -e .[peers]")


def write_source(n: int, folder: Path) -> Path:
    """Write C of (q, u) -> du/dt; q is the position of joint 0, then the angles of all links."""
    ca = import_module("casadi")
    q, u = ca.SX.sym("q", n + 2), ca.SX.sym("u", n + 2)
    return _write(ca, ca.Function(FUNCTION, [q, u], [_acceleration(ca, n, q[2:], u[2:])], {"cse": True}), n, folder)


def write_jacobian(n: int, folder: Path) -> Path:
    """Write C of (q, u) -> the derivatives (n + 2, 2 n + 4) of du/dt by q and u, column by column."""
    ca = import_module("casadi")
    q, u = ca.SX.sym("q", n + 2), ca.SX.sym("u", n + 2)
    dense = ca.densify(ca.jacobian(_acceleration(ca, n, q[2:], u[2:]), ca.vertcat(q, u)))
    return _write(ca, ca.Function(JACOBIAN, [q, u], [dense], {"cse": True}), n, folder)


def _write(ca: Any, function: Any, n: int, folder: Path) -> Path:
    path = folder / f"{function.name()}_{n}.c"
    generator = ca.CodeGenerator(path.name, {"with_header": False})
    generator.add(function)
    path.write_text(generator.dump())
    return path


def _acceleration(ca: Any, n: int, angles: Any, rates: Any) -> Any:
    """du/dt with constant data: joint forces by CasADi's sparse LDL of A M^-1 A^T, then Newton-Euler."""
    arm_x, arm_y = LENGTH / 2 * ca.cos(angles), LENGTH / 2 * ca.sin(angles)
    jacobian, bias = ca.SX(2 * n, 3 * n), ca.SX(2 * n, 1)
    for k in range(n):
        for link, sign in (((k - 1) % n, 1.0), (k, -1.0)):
            jacobian[2 * k, 3 * link] = jacobian[2 * k + 1, 3 * link + 1] = sign
            jacobian[2 * k, 3 * link + 2] = -arm_y[link]
            jacobian[2 * k + 1, 3 * link + 2] = arm_x[link]
            bias[2 * k] += rates[link] ** 2 * arm_x[link]
            bias[2 * k + 1] += rates[link] ** 2 * arm_y[link]
    weighted = jacobian @ ca.diag(ca.SX(np.tile([1 / MASS, 1 / MASS, 1 / INERTIA], n)))
    free = ca.SX(np.tile([0.0, -GRAVITY, 0.0], n))
    diagonal, factor, ordering = ca.ldl(weighted @ jacobian.T, True)
    forces = ca.ldl_solve(bias - jacobian @ free, diagonal, factor, ordering)
    centres = free + weighted.T @ forces
    spin = centres[2]
    x = centres[0] + spin * arm_y[0] + rates[0] ** 2 * arm_x[0]
    y = centres[1] - spin * arm_x[0] + rates[0] ** 2 * arm_y[0]
    return ca.vertcat(x, y, centres[2::3])
