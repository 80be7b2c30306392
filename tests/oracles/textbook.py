"""Equations of motion from ``sympy.physics.mechanics``, by Kane's and by Lagrange's method, at numeric states.

For chains in a row: pin k of the system joins link k-1 to link k, a first pin on the ground holds link 0, and a last
pin back to link 0 or to the ground closes a loop. Coordinates are the place of link 0's frame (free mechanisms) and the
absolute angles.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import sympy as sp
from sympy.physics import mechanics

from .maximal import GROUND, Array, Pin, System

Evaluate = Callable[[Array, Array], tuple[Array, Array]]
"""(coordinates, rates) -> (second derivatives of the coordinates, closing force on the last pin's link ``b``)."""


@dataclass
class _Model:
    """Frames, points and constraints that both methods start from."""

    system: System

    def __post_init__(self) -> None:
        pins = list(self.system.pins)
        n = self.system.size
        self.free = not pins or pins[0].a != GROUND
        tree = n - 1 if self.free else n
        inner, self.closing = pins[:tree], pins[tree:]
        t = mechanics.dynamicsymbols._t
        base = list(mechanics.dynamicsymbols("x y")) if self.free else []
        self.q = [*base, *(mechanics.dynamicsymbols(f"q:{n}") if n > 1 else [mechanics.dynamicsymbols("q0")])]
        self.u = list(mechanics.dynamicsymbols(f"u:{len(self.q)}"))
        self.kinematic = [u - q.diff(t) for u, q in zip(self.u, self.q, strict=True)]
        self.inertial = mechanics.ReferenceFrame("N")
        self.zero = mechanics.Point("O")
        self.zero.set_vel(self.inertial, 0)
        self._place(inner, len(base))

    def _place(self, inner: list[Pin], base: int) -> None:
        n, frame = self.system.size, self.inertial
        self.frames: list[Any] = []
        self.origins: list[Any] = []
        self.bodies: list[Any] = []
        for k in range(n):
            self.frames.append(frame.orientnew(f"B{k}", "Axis", [self.q[base + k], frame.z]))
            self.frames[k].set_ang_vel(frame, self.u[base + k] * frame.z)
            origin = mechanics.Point(f"P{k}")
            if base and k == 0:
                origin.set_pos(self.zero, self.q[0] * frame.x + self.q[1] * frame.y)
                origin.set_vel(frame, self.u[0] * frame.x + self.u[1] * frame.y)
            else:
                pin = inner[k - 1] if base else inner[k]
                start = self.at(pin.a, pin.on_a)
                origin.set_pos(start, -self._vector(k, pin.on_b))
                origin.set_vel(frame, self._speed(pin.a, start) + self._swing(k, -self._vector(k, pin.on_b)))
            self.origins.append(origin)
            self._body(k)

    def _body(self, k: int) -> None:
        centre = self.at(k, tuple(self.system.com[k]))
        inertia = (mechanics.inertia(self.frames[k], 0, 0, float(self.system.inertia[k])), centre)
        body = mechanics.RigidBody(f"R{k}", centre, self.frames[k], float(self.system.mass[k]), inertia)
        body.potential_energy = body.mass * self.system.gravity * centre.pos_from(self.zero).dot(self.inertial.y)
        self.bodies.append(body)

    def _vector(self, link: int, on: tuple[float, float]) -> Any:
        axes = self.inertial if link == GROUND else self.frames[link]
        return float(on[0]) * axes.x + float(on[1]) * axes.y

    def _swing(self, link: int, arm: Any) -> Any:
        return self.frames[link].ang_vel_in(self.inertial).cross(arm)

    def _speed(self, link: int, point: mechanics.Point) -> Any:
        return point.vel(self.inertial)

    def at(self, link: int, on: tuple[float, float]) -> mechanics.Point:
        """A point of a link, with its velocity."""
        name = f"{link}_{on}"
        if link == GROUND:
            point = self.zero.locatenew(name, self._vector(link, on))
            point.set_vel(self.inertial, 0)
            return point
        point = self.origins[link].locatenew(name, self._vector(link, on))
        point.set_vel(self.inertial, self.origins[link].vel(self.inertial) + self._swing(link, self._vector(link, on)))
        return point

    def closure(self) -> list[sp.Expr]:
        found = []
        for pin in self.closing:
            gap = self.at(pin.b, pin.on_b).pos_from(self.at(pin.a, pin.on_a))
            found += [gap.dot(self.inertial.x), gap.dot(self.inertial.y)]
        return found

    def numeric(self, matrix: Any, right: Any) -> Callable[[Array, Array], Array]:
        """Solution of ``matrix @ x = right`` as a function of numbers."""
        t = mechanics.dynamicsymbols._t
        rates = {q.diff(t): u for q, u in zip(self.q, self.u, strict=True)}
        plain = sp.symbols(f"z:{2 * len(self.q)}")
        names = dict(zip([*self.q, *self.u], plain, strict=True))
        sides = [m.subs(rates).xreplace(names) for m in (matrix, right)]
        function = sp.lambdify(plain, sides, cse=True)

        def solved(q: Array, u: Array) -> Array:
            left, known = function(*q, *u)
            return np.linalg.solve(np.asarray(left, float), np.asarray(known, float).ravel())

        return solved


def kane(system: System) -> Evaluate:
    """Kane's equations; the last two angular velocities depend on the others where a loop is closed."""
    model = _Model(system)
    closure, t = model.closure(), mechanics.dynamicsymbols._t
    free = len(model.q) - len(closure)
    rates = {q.diff(t): u for q, u in zip(model.q, model.u, strict=True)}
    extra: dict[str, Any] = {}
    if closure:
        extra = {
            "q_dependent": model.q[free:],
            "u_dependent": model.u[free:],
            "configuration_constraints": closure,
            "velocity_constraints": [entry.diff(t).subs(rates) for entry in closure],
        }
    method = mechanics.KanesMethod(
        model.inertial, q_ind=model.q[:free], u_ind=model.u[:free], kd_eqs=model.kinematic, **extra
    )
    down = -system.gravity * model.inertial.y
    loads = [(body.masscenter, body.mass * down) for body in model.bodies]
    method.kanes_equations(model.bodies, loads)
    solve = model.numeric(method.mass_matrix, method.forcing)
    return lambda q, u: (solve(q, u), np.zeros(0))


def lagrange(system: System) -> Evaluate:
    """Lagrange's equations with multipliers for the closing pin."""
    model = _Model(system)
    t = mechanics.dynamicsymbols._t
    speeds = {u: q.diff(t) for q, u in zip(model.q, model.u, strict=True)}
    energy = sum(body.kinetic_energy(model.inertial) - body.potential_energy for body in model.bodies)
    method = mechanics.LagrangesMethod(energy.subs(speeds), model.q, hol_coneqs=model.closure())
    method.form_lagranges_equations()
    n = len(model.q)
    full = sp.Matrix(method.mass_matrix_full)[n:, n:]
    solve = model.numeric(full, sp.Matrix(method.forcing_full)[n:, :])

    def evaluate(q: Array, u: Array) -> tuple[Array, Array]:
        x = solve(q, u)
        return x[:n], x[n:]

    return evaluate
