"""A driven four-bar of rods in eighty digits: positions by Newton's method, forces by Newton's and Euler's equations.

It goes through change points on its branch: the angles are carried on from two places before, which are so near that
the other branch is farther off than what that misses.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from mpmath import mp, mpf

DIGITS = 80
GRAVITY = "9.81"


@dataclass(frozen=True)
class FourBar:
    """Crank a from the origin, coupler b, rocker c from (d, 0), their masses; the crank turns at ``rate`` from
    ``angle``, and a torque acts on the rocker."""

    lengths: tuple[str, str, str, str]
    masses: tuple[str, str, str]
    rate: str
    angle: str
    torque: str = "0"

    def scene(self, until: float) -> str:
        """Names: crank, coupler, rocker; axle, p1, p2, hub, each force on the second of them."""
        a, b, c, d = self.lengths
        links = "".join(
            f'[[link]]\nname = "{name}"\nrod = {{ mass = {mass} }}\npoints = {{ A = [0, 0], B = [{length}, 0] }}\n'
            for name, mass, length in zip(("crank", "coupler", "rocker"), self.masses, (a, b, c), strict=True)
        )
        between = {"axle": ("ground.O", "crank.A"), "p1": ("crank.B", "coupler.A"), "p2": ("coupler.B", "rocker.B")}
        joints = "".join(
            f'[[joint]]\nname = "{name}"\nbetween = ["{one}", "{other}"]\n'
            for name, (one, other) in (between | {"hub": ("ground.Q", "rocker.A")}).items()
        )
        with mp.workdps(DIGITS):
            phi, psi = (float(x) for x in self.start())
        load = "" if self.torque == "0" else f'[[torque]]\nlink = "rocker"\ntorque = {self.torque}\n'
        return (
            f'name = "four-bar"\n[ground_link]\npoints = {{ O = [0, 0], Q = [{d}, 0] }}\n{links}{joints}{load}'
            f"[start]\nangles = {{ crank = {self.angle}, coupler = {phi!r}, rocker = {psi!r} }}\n"
            f'[[drive]]\njoint = "axle"\nangle = "{self.angle} + {self.rate}*t"\n'
            f"[gravity]\n[run]\nuntil = {until}\n"
        )

    def start(self) -> tuple[Any, Any]:
        """Angles of coupler and rocker at the start, where the coupler is turned to the left of the way from the
        crank's end to the rocker's hinge."""
        theta = mpf(self.angle)
        a, b, c, d = map(mpf, self.lengths)
        tip, far = a * mp.expj(theta), mpf(d)
        span = far - tip
        apart = abs(span)
        cosine = (b * b + apart * apart - c * c) / (2 * b * apart)
        phi = mp.arg(span) + mp.acos(cosine)
        end = tip + b * mp.expj(phi)
        return phi, mp.arg(end - far)

    def closed(self, theta: Any, phi: Any, psi: Any) -> tuple[Any, Any]:
        """The angles nearest to those given at which the loop is closed."""
        a, b, c, d = map(mpf, self.lengths)
        for _ in range(200):
            miss = a * mp.expj(theta) + b * mp.expj(phi) - d - c * mp.expj(psi)
            by_phi, by_psi = 1j * b * mp.expj(phi), -1j * c * mp.expj(psi)
            below = by_phi.real * by_psi.imag - by_phi.imag * by_psi.real
            more = (
                -(miss.real * by_psi.imag - miss.imag * by_psi.real) / below,
                -(by_phi.real * miss.imag - by_phi.imag * miss.real) / below,
            )
            phi, psi = phi + more[0], psi + more[1]
            if abs(more[0]) + abs(more[1]) < mpf(10) ** (20 - DIGITS):
                return phi, psi
        raise AssertionError(f"not closed at {theta}")

    def along(self, thetas: list[Any]) -> dict[Any, tuple[Any, Any]]:
        """Angles at those of the crank, each carried on from the two before."""
        found = {}
        last: list[tuple[Any, Any, Any]] = []
        for theta in thetas:
            if len(last) < 2:
                guess = self.start() if not last else last[-1][1:]
            else:
                (t0, *x0), (t1, *x1) = last[-2:]
                part = (theta - t1) / (t1 - t0)
                guess = tuple(one + part * (one - other) for one, other in zip(x1, x0, strict=True))
            found[theta] = self.closed(theta, *guess)
            last.append((theta, *found[theta]))
        return found

    def forces(self, theta: Any, phi: Any, psi: Any) -> dict[str, float]:
        """Forces on the second links, the drive's torque, and accelerations at a place."""
        a, b, c, _ = map(mpf, self.lengths)
        m1, m2, m3 = map(mpf, self.masses)
        w, g, load = mpf(self.rate), mpf(GRAVITY), mpf(self.torque)
        rows = mp.matrix([[-b * mp.sin(phi), c * mp.sin(psi)], [b * mp.cos(phi), -c * mp.cos(psi)]])
        rates = mp.lu_solve(rows, mp.matrix([a * w * mp.sin(theta), -a * w * mp.cos(theta)]))
        e = [mp.expj(theta), mp.expj(phi), mp.expj(psi)]
        r2, r3 = rates[0], rates[1]
        bias = a * w * w * e[0] + b * r2 * r2 * e[1] - c * r3 * r3 * e[2]
        turn = mp.lu_solve(rows, mp.matrix([bias.real, bias.imag]))
        A2, A3 = turn[0], turn[1]
        tip = -a * w * w * e[0]
        centres = [tip / 2, tip + (1j * A2 - r2 * r2) * b / 2 * e[1], (1j * A3 - r3 * r3) * c / 2 * e[2]]
        # unknown: axle (2), p1 (2), p2 (2), hub (2), torque
        matrix, right = mp.zeros(9, 9), mp.zeros(9, 1)
        links = [  # mass, length, direction, (force number, sign, part of the length) ..., acceleration of angle
            (m1, a, e[0], ((0, 1, 0), (1, -1, 1)), mpf(0)),
            (m2, b, e[1], ((1, 1, 0), (2, -1, 1)), A2),
            (m3, c, e[2], ((2, 1, 1), (3, 1, 0)), A3),
        ]
        for k, (mass, length, along, pins, turning) in enumerate(links):
            for number, sign, part in pins:
                arm = (mpf(part) - mpf(1) / 2) * length * along
                matrix[3 * k, 2 * number] += sign
                matrix[3 * k + 1, 2 * number + 1] += sign
                matrix[3 * k + 2, 2 * number] -= sign * arm.imag
                matrix[3 * k + 2, 2 * number + 1] += sign * arm.real
            right[3 * k], right[3 * k + 1] = mass * centres[k].real, mass * (centres[k].imag + g)
            right[3 * k + 2] = mass * length * length / 12 * turning
        matrix[2, 8] = 1
        right[8] -= load
        found = mp.lu_solve(matrix, right)
        names = [f"{joint}.{part}" for joint in ("axle", "p1", "p2", "hub") for part in ("fx", "fy")]
        told = {name: float(found[k]) for k, name in enumerate(names)}
        return told | {
            "axle.moment": float(found[8]),
            "coupler.angular_acceleration": float(A2),
            "rocker.angular_acceleration": float(A3),
        }

    def beside(self, place: Any, distances: list[Any]) -> dict[Any, dict[str, float]]:
        """Forces at signed ``distances`` of the crank's angle from a change point at the angle ``place``."""
        start = mpf(self.angle)
        way = [start + (place - mpf("0.2") - start) * k / 200 for k in range(201)]
        before = [place - mpf("0.2") * mpf(2) ** -k for k in range(1, 46)]
        wanted = sorted(place + mpf(x) for x in distances)
        behind = [2 * place - x for x in reversed(before)]
        thetas = sorted({*way, *before, *behind, *wanted})
        angles = self.along(thetas)
        return {x: self.forces(place + mpf(x), *angles[place + mpf(x)]) for x in distances}
