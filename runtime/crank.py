"""The torque that a driven crank needs over one turn, found along the branch on which the mechanism starts."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .drives import drive_columns
from .extras import needed
from .frames import FloatArray
from .model import Model
from .precision import need_doubles
from .run import write_whole

NEAR = 1e4
"""A position whose rows have a larger condition number is at a change point; its neighbours stand in for it."""
BESIDE = 1e-2
"""How far apart these neighbours are, rad of the crank."""
STRIDE, SHORTEST = 5e-3, 1e-7
"""Steps along the turn, rad of the crank."""
MISS = 0.05
"""A step that is corrected by more than this part of its length is halved."""

Sample = tuple[FloatArray, FloatArray, FloatArray, float]
"""q, u, u̇ and the torque."""


@dataclass(frozen=True)
class DrivingTorque:
    """The torque (samples,) in N m at ``joint`` that turns it at the constant ``rate`` (rad/s), over one turn.

    ``angle`` (samples,) is that of the joint (rad): its second link's less its first's. Positive torque acts on the
    second link counter-clockwise. ``q``, ``u`` and ``u_dot`` are the motion.
    """

    model: Model
    joint: str
    rate: float
    angle: FloatArray
    torque: FloatArray
    q: FloatArray
    u: FloatArray
    u_dot: FloatArray

    @property
    def mean(self) -> float:
        """Mean torque over the turn: zero unless something takes work."""
        return float(np.mean(self.torque))

    @property
    def peak(self) -> float:
        """The torque of largest magnitude, with its sign."""
        return float(self.torque[np.argmax(np.abs(self.torque))])

    def plot(self, path: str | os.PathLike[str] | None = None) -> Any:
        """The figure of torque over angle, saved as a PNG where a path is given."""
        target = None if path is None else Path(path)
        if target is not None and target.suffix != ".png":
            raise ValueError(f"a plot is saved as .png, found {target.name!r}; use another name")
        figure_module = needed("matplotlib.figure", "a plot of a torque")
        backend = needed("matplotlib.backends.backend_agg", "a plot of a torque")
        figure = figure_module.Figure(figsize=(7, 3.6), dpi=100, layout="constrained")
        backend.FigureCanvasAgg(figure)
        axes = figure.subplots()
        turned = np.degrees(self.angle - self.angle[0])
        axes.plot(
            np.append(turned, np.sign(self.rate) * 360.0), np.append(self.torque, self.torque[0]), color="#4477aa"
        )
        axes.axhline(0.0, color="#888888", linewidth=0.6)
        axes.set_xlim(*sorted((0.0, float(np.sign(self.rate)) * 360.0)))
        axes.set_xlabel(f"{self.joint}: turned from {np.degrees(self.angle[0]):.4g}° [°]")
        axes.set_ylabel("torque [N m]")
        axes.set_title(f"{self.model.name}: torque at {self.joint} for {self.rate:.4g} rad/s", fontsize=11)
        axes.grid(True, color="#e6e6e6", linewidth=0.6)
        axes.spines[["top", "right"]].set_visible(False)
        if target is not None:
            write_whole(target, lambda part: figure.savefig(part, format="png", metadata={"Software": None}))
        return figure


def driving_torque(
    model: Model, joint: str, rate: float, samples: int = 360, q: ArrayLike | None = None
) -> DrivingTorque:
    """The torque that turns ``joint`` of a mechanism with one degree of freedom once, at the constant ``rate`` (rad/s).

    The turn begins at ``q``, the scene's start unless given, and keeps to its branch. At change points, where the
    torque is a limit, the mean of two near neighbours stands. Loads are those at t = 0. Raises ``ValueError`` where the
    joint does not determine the motion, or cannot be turned right round.
    """
    need_doubles(model.precision, model.name, "a driving torque")
    if joint in model.data["lines"]:
        raise ValueError(f"joint: found {joint}, which slides along a line, expected a joint that turns; name another")
    drive = drive_columns(model, [joint])[:, 0]
    others = [one["joint"] for one in model.data["drives"] if one["joint"] != joint]
    if others:
        raise ValueError(
            f"joint: found {joint} beside driven {', '.join(others)}, expected no other joint whose motion is given; "
            f"name {others[0]}, or leave out its [[drive]]"
        )
    if not np.isfinite(rate) or rate == 0.0:
        raise ValueError(f"rate: found {rate}, expected a finite number other than zero")
    if samples < 2:
        raise ValueError(f"samples: found {samples}, expected at least 2")
    first = model.start()[0] if q is None else model.assemble(q)
    if np.ndim(first) != 1:
        raise ValueError(f"q: found shape {np.shape(first)}, expected one configuration ({len(model.q_names)},)")
    turn = _Turn(model, drive, joint, float(rate))
    turned = 2.0 * np.pi * np.arange(samples) / samples
    rows = turn.samples(first, turned)
    qs, us, dots = (np.array([row[k] for row in rows]) for k in range(3))
    return DrivingTorque(model, joint, float(rate), qs @ drive, np.array([row[3] for row in rows]), qs, us, dots)


@dataclass(frozen=True)
class _Turn:
    """A turn of the crank: the closure's rows and the crank's own angle determine the configuration."""

    model: Model
    drive: FloatArray
    joint: str
    rate: float

    def samples(self, first: FloatArray, turned: FloatArray) -> list[Sample]:
        """The motion after the crank has turned by each of ``turned`` (rad, rising, in the direction of the rate)."""
        values = np.linalg.svd(self._rows(first), compute_uv=False)
        if len(values) < len(first) or self.condition(first) > NEAR:
            raise ValueError(
                f"{self.joint}: its angle does not determine the motion here, expected a mechanism with one degree of "
                f"freedom (found {self.model.dof}), away from dead and change points; start elsewhere or name another"
            )
        found, here, angle = [], first, 0.0
        for wanted in turned:
            reached = here if wanted == angle else self._walk(here, angle, wanted)
            if self.condition(reached) <= NEAR:
                here, angle = reached, wanted
                found.append(self._sample(here))
                continue
            sides = []
            for beside in (wanted - 2 * BESIDE, wanted - BESIDE, wanted + BESIDE, wanted + 2 * BESIDE):
                here, angle = self._walk(here, angle, beside), beside
                sides.append(self._sample(here))
            found.append(_between(sides))
        return found

    def condition(self, q: FloatArray) -> float:
        """Condition number of the rows at ``q``."""
        values = np.linalg.svd(self._rows(q), compute_uv=False)
        return float(values[0] / max(values[min(len(values), len(q)) - 1], 1e-300))

    def _rows(self, q: FloatArray) -> FloatArray:
        return np.vstack([self.model.jacobian(q) / self.model.length, self.drive])

    def _motion(self, q: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Velocities and accelerations at the constant rate."""
        rows = self._rows(q)
        none = np.zeros(len(rows) - 1)
        u = np.linalg.lstsq(rows, np.append(none, self.rate), rcond=1e-12)[0]
        bias = self.model.kernels.of_state("closure_bias", q[None], u[None])[0] / self.model.length
        return u, np.linalg.lstsq(rows, np.append(-bias, 0.0), rcond=1e-12)[0]

    def _sample(self, q: FloatArray) -> Sample:
        """The torque does the work that the motion takes: no other force does any."""
        u, u_dot = self._motion(q)
        force = self.model.kernels.inverse_dynamics(q[None], u[None], 0.0, u_dot[None])[0]
        return q, u, u_dot, float(force @ u / self.rate)

    def _walk(self, q: FloatArray, angle: float, wanted: float) -> FloatArray:
        """From ``q`` at ``angle`` to ``wanted`` (rad), on the branch that continues the motion smoothly."""
        step, over = STRIDE, False
        while wanted - angle > 1e-12:
            h = min(step, wanted - angle)
            u, u_dot = self._motion(q)
            time = h / abs(self.rate)
            change = time * u + time * time / 2.0 * u_dot
            found = self._corrected(q + change, float(self.drive @ q) + np.sign(self.rate) * h)
            if found is None or np.linalg.norm(found - q - change) > MISS * np.linalg.norm(change):
                step = h / 2.0
                if over or step < SHORTEST:
                    raise ValueError(
                        f"{self.joint} cannot be turned right round: it comes to a stop after "
                        f"{np.degrees(angle):.6g}°, expected a crank; name another joint"
                    )
            elif self.condition(found) > NEAR and h < wanted - angle:
                step, over = 1.3 * h, True  # over the change point rather than onto it
            else:
                q, angle, step, over = found, angle + h, min(STRIDE, 2.0 * h), False
        return q

    def _corrected(self, q: FloatArray, crank: float) -> FloatArray | None:
        """The configuration near ``q`` with loops shut and the crank at ``crank`` (rad), ``None`` where none is."""
        for _ in range(12):
            miss = np.append(self.model.closure(q) / self.model.length, self.drive @ q - crank)
            step = np.linalg.lstsq(self._rows(q), miss, rcond=1e-9)[0]
            q = q - step
            if np.max(np.abs(step)) <= 1e-13 * (1.0 + np.max(np.abs(q))):
                return q
        return q if np.max(np.abs(miss)) < 1e-12 else None


def _between(sides: list[Sample]) -> Sample:
    """The middle of four samples at equal distances around it, by cubic interpolation."""
    q, u, u_dot, torque = (
        sum(weight * side[k] for weight, side in zip((-1 / 6, 2 / 3, 2 / 3, -1 / 6), sides, strict=True))
        for k in range(4)
    )
    return q, u, u_dot, float(torque)  # type: ignore[return-value]
