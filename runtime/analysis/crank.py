"""The torque that a driven crank needs over one turn, found along the branch on which the mechanism starts."""

from __future__ import annotations

import bisect
import math
import os
import sys
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import BoolArray, FloatArray
from ..extras import needed
from ..files import read_path, write_whole
from ..model.drives import drive_columns
from ..model.integrators import integral_rows
from ..model.lined_up import lined_up
from ..model.model import Model, check_model
from ..model.numbers import read_name, told
from ..precision import need_doubles
from .contacts import CLOSED, DEEPEST, Contacts, inside
from .extremes import largest

SINGULAR = 1e4
"""A position whose rows have a larger condition number is at a change point: the walk goes over it, not onto it."""
NEAR = 100.0
"""One with a larger condition number may lie beside a change point: rounding times its cube is in accelerations, 1e-10
here."""
BESIDE = np.cos(np.pi * (2 * np.array([0, 1, 2, 3, 4, 7, 8, 9, 10, 11]) + 1) / 24.0)
"""Where neighbours lie that tell it, from -1 to 1: Chebyshev points but for the innermost two."""
WIDTHS = (0.15, 0.05, 0.017)
"""Up to how far they lie from it, rad of the crank: less where a surface, a dead point or a corner is near."""
STRIDE, SHORTEST = 5e-3, 1e-7
"""Steps along the turn, rad of the crank."""
MISS = 0.05
"""A step that is corrected by more than this part of its length is halved."""
REPEATS = 1e-9
"""Torques at both ends of a turn that differ by less than this part of the largest are the same."""
SLIDING = 1e-9
"""A contact that slides slower than this part of the fastest motion rolls or sticks."""

Sample = tuple[FloatArray, FloatArray, FloatArray, float, float]
"""q, u, u̇, the torque, and the sizes of what it is the sum of, which rounding is a part of."""


@dataclass(frozen=True)
class DrivingTorque:
    """The torque (samples,) in N m at ``joint`` that turns it at the constant ``rate`` (rad/s), over one turn; at the
    rate zero, that which holds it at each angle.

    ``angle`` (samples,) is that of the joint (rad): its second link's less its first's. Positive torque acts on the
    second link counter-clockwise. ``q``, ``u`` and ``u_dot`` are the motion.

    ``largest`` and ``smallest`` are torque and angle where it is that, between the samples too: of each crest of these,
    refined to rounding.

    ``mean`` is the mean torque over the turn: zero unless something takes work, or the mechanism does not come back.
    ``mean_error`` is what it differs by from that of every second sample: of a smooth torque rounding, of one with
    corners, or near a change point, not.

    ``closed`` are the (point, ground) names of contacts that are closed at some sample. What they push does no work in
    this motion and is not in the torque.
    """

    model: Model
    joint: str
    rate: float
    angle: FloatArray
    torque: FloatArray
    q: FloatArray
    u: FloatArray
    u_dot: FloatArray
    closed: tuple[tuple[str, str], ...]
    largest: tuple[float, float]
    smallest: tuple[float, float]
    mean: float
    mean_error: float

    @property
    def peak(self) -> float:
        """The torque of largest magnitude, with its sign."""
        return max(self.largest[0], self.smallest[0], key=abs)

    def plot(self, path: str | os.PathLike[str] | None = None) -> Any:
        """The figure of torque over angle, saved as a PNG where a path is given."""
        target = None if path is None else read_path(path, "a .png file")
        if target is not None and target.suffix != ".png":
            raise ValueError(f"path: a plot is saved as .png, found {target.name!r}, expected a name that ends so")
        figure_module = needed("matplotlib.figure", "a plot of a torque")
        backend = needed("matplotlib.backends.backend_agg", "a plot of a torque")
        figure = figure_module.Figure(figsize=(7, 3.6), dpi=100, layout="constrained")
        backend.FigureCanvasAgg(figure)
        axes = figure.subplots()
        turned, whole = np.degrees(self.angle - self.angle[0]), 360.0 * _way(self.rate)
        axes.plot(np.append(turned, whole), np.append(self.torque, self.torque[0]), color="#4477aa")
        axes.axhline(0.0, color="#888888", linewidth=0.6)
        axes.set_xlim(*sorted((0.0, whole)))
        axes.set_xlabel(f"{self.joint}: turned from {round(float(np.degrees(self.angle[0])), 6) + 0.0:.4g}° [°]")
        axes.set_ylabel("torque [N m]")
        motion = f"for {self.rate:.4g} rad/s" if self.rate else "at rest"
        axes.set_title(f"{self.model.name}: torque at {self.joint} {motion}", fontsize=11)
        axes.grid(True, color="#e6e6e6", linewidth=0.6)
        axes.spines[["top", "right"]].set_visible(False)
        if target is not None:
            write_whole(target, lambda part: figure.savefig(part, format="png", metadata={"Software": "ccgen"}))
        return figure


MOST_SAMPLES = 10_000_000
"""Of a turn: their states take a gigabyte where a mechanism has a dozen coordinates."""


def check_rate(rate: object) -> None:
    """Raise ``ValueError`` unless a crank can turn, or rest, at this rate (rad/s)."""
    number: Any = rate if isinstance(rate, int | float | np.floating | np.integer) else math.nan
    if not abs(number) <= sys.float_info.max:
        raise ValueError(f"rate: found {rate!r}, expected a finite number, in rad/s; correct it")


def _way(rate: float) -> float:
    """The way round in which a crank turns, 1.0 counter-clockwise, -1.0 clockwise; what rests is turned the first."""
    return -1.0 if rate < 0.0 else 1.0


def driving_torque(
    model: Model, joint: str, rate: float, samples: int = 360, q: ArrayLike | None = None
) -> DrivingTorque:
    """The torque that turns ``joint`` of a mechanism with one degree of freedom once, at the constant ``rate`` (rad/s).

    The turn begins at ``q``, the scene's start unless given, and keeps to its branch. Beside change points, where the
    torque is a limit and rounding grows, the polynomial through neighbours on both sides stands. Loads are those
    at t = 0, and effects that ``[start] off`` names are absent. With the rate zero the
    mechanism rests at every angle: there is no inertia in the torque, nor friction or damping, which need a speed.

    Contacts bar the way and do not push: those that the motion closes for a moment, or keeps closed, do no work in it.
    Friction of a contact that slides would, by a force that the motion does not give.
    Raises ``ValueError`` where the joint does not determine the motion; where it cannot be turned right round, because
    of a dead point, or of a contact whose gap would become negative; and where a rough contact slides.
    """
    check_model(model)
    need_doubles(model.precision, model.name, "a driving torque")
    joint = read_name(joint, "joint", "a joint")
    if joint in model.data["lines"]:
        raise ValueError(f"joint: found {joint}, which slides along a line, expected a joint that turns; name another")
    drive = drive_columns(model, [joint])[:, 0]
    others = [one["joint"] for one in model.data["drives"] if one["joint"] != joint]
    if others:
        raise ValueError(
            f"joint: found {joint} beside driven {', '.join(others)}, expected no other joint whose motion is given; "
            f"name {others[0]}, or leave out its [[drive]]"
        )
    check_rate(rate)
    if not isinstance(samples, int | np.integer) or not 2 <= samples <= MOST_SAMPLES:
        raise ValueError(f"samples: found {told(samples)}, expected at least 2, and at most {MOST_SAMPLES}")
    first = model.start()[0] if q is None else model.assemble(q)
    if np.ndim(first) != 1:
        raise ValueError(f"q: found shape {np.shape(first)}, expected one configuration ({len(model.q_names)},)")
    if depth := inside(model, first, DEEPEST):
        raise ValueError(f"q: found {depth}, expected a configuration outside all surfaces; begin elsewhere")
    turn = _Turn(model, drive, joint, float(rate), first)
    turned = 2.0 * np.pi * np.arange(samples + 1) / samples
    rows = [turn.sample(one) for one in turned]
    torque = np.array([row[3] for row in rows])
    high = largest(lambda at: turn.sample(at)[3], turned, torque)
    low = largest(lambda at: -turn.sample(at)[3], turned, -torque)
    qs, us, dots = (np.array([row[k] for row in rows[:-1]]) for k in range(3))
    angle = qs @ drive
    return DrivingTorque(
        model,
        joint,
        float(rate),
        angle,
        torque[:-1],
        qs,
        us,
        dots,
        turn.closed(qs),
        (high[0], float(angle[0]) + turn.way * high[1]),
        (-low[0], float(angle[0]) + turn.way * low[1]),
        *_mean(torque),
    )


def _mean(values: FloatArray) -> tuple[float, float]:
    """The mean of values (n + 1,) at equal distances, and what it differs by from that of half as many.

    By the trapezoidal rule, which is exact to rounding where smooth values repeat themselves (Trefethen and Weideman,
    2014), and by Simpson's, which follows from it, where they do not.
    """

    def rule(step: int) -> float:
        part = values[::step]
        return float(np.mean(part[:-1]) + (part[-1] - part[0]) / (2.0 * (len(part) - 1)))

    repeats = abs(values[-1] - values[0]) <= REPEATS * float(np.max(np.abs(values)))
    if (len(values) - 1) % (2 if repeats else 4):
        return rule(1), math.inf
    one, two = rule(1), rule(2)
    if repeats:
        return one, abs(one - two)
    simpson = (4.0 * one - two) / 3.0
    return simpson, abs(simpson - (4.0 * two - rule(4)) / 3.0)


class _Turn:
    """A turn of the crank from ``first``: the closure's rows and the crank's own angle determine the configuration."""

    def __init__(self, model: Model, drive: FloatArray, joint: str, rate: float, first: FloatArray) -> None:
        self.model, self.drive, self.joint, self.rate = model, drive, joint, rate
        self.contacts, self.way = Contacts(model), _way(rate)
        self.units = np.array([1.0 if kind == "angle" else model.length for kind, _ in model.data["coordinates"]])
        """Of the coordinates: the condition of the rows does not hang on the mechanism's size."""
        values = np.linalg.svd(self._rows(first), compute_uv=False)
        if len(values) < len(first) or self.condition(first) > SINGULAR:
            free = len(first) - int(np.linalg.matrix_rank(np.asarray(model.jacobian(first), dtype=float)))
            raise ValueError(
                f"{joint}: its angle does not determine the motion here, expected a mechanism with one degree of "
                f"freedom (found {free}; contacts do not count), away from dead and change points; start elsewhere or "
                "name another"
            )
        self.angles, self.passed = [0.0], [first]
        """Regular configurations on the way: from each of them the walk can go on."""
        self.behind: _Turn | None = None
        """The turn the other way round, for what lies before the first configuration."""

    def closed(self, qs: FloatArray) -> tuple[tuple[str, str], ...]:
        """Contacts that are closed in some of ``qs`` (samples, nq)."""
        ever = np.any([self.contacts.depths(q) >= -CLOSED for q in qs], axis=0)
        return tuple(contact for contact, touched in zip(self.model.contacts, ever, strict=True) if touched)

    def sample(self, turned: float) -> Sample:
        """The motion after the crank has turned by that (rad), in the direction of the rate."""
        reached = self._reach(turned)
        condition = self.condition(reached)
        if condition <= NEAR:
            return self._sample(reached)
        found = self._sample(reached)
        off, refused = float(np.finfo(float).eps) * condition**3 * found[4], ValueError()
        for width in WIDTHS:
            try:
                told_by_others, spread = _at_zero([self._sample(self._reach(turned + width * part)) for part in BESIDE])
            except ValueError as error:  # there is no way to all of them
                refused = error
                continue
            if spread < off:
                found, off = told_by_others, spread
            if off <= np.finfo(float).eps * NEAR**3 * found[4]:  # as well as anywhere; nearer to it rounding is larger
                break
        if off > found[4] and refused.args:
            raise refused
        return found

    def _reach(self, wanted: float) -> FloatArray:
        """The configuration there, from the nearest one behind it that has been passed."""
        if wanted < 0.0:
            self.behind = self.behind or _Turn(self.model, self.drive, self.joint, -self.way, self.passed[0])
            return self.behind._reach(-wanted)
        last = bisect.bisect_right(self.angles, wanted) - 1
        if self.angles[last] == wanted:
            return self.passed[last]
        reached = self._walk(self.passed[last], self.angles[last], wanted)
        if self.condition(reached) <= SINGULAR:
            self.angles.insert(last + 1, wanted)
            self.passed.insert(last + 1, reached)
        return reached

    def condition(self, q: FloatArray) -> float:
        """Condition number of the rows at ``q``, in the mechanism's units."""
        values = np.linalg.svd(self._rows(q) * self.units, compute_uv=False)
        return float(values[0] / max(values[min(len(values), len(q)) - 1], 1e-300))

    def _rows(self, q: FloatArray) -> FloatArray:
        return np.vstack([self.model.jacobian(q) / self.model.length, integral_rows(self.model), self.drive])

    def _motion(self, q: FloatArray) -> tuple[FloatArray, FloatArray]:
        """What q changes by per radian of the crank, counted in the direction of the rate: its first and second
        derivative (nu,)."""
        rows, along = self._rows(q), self._along(q)
        bias = self.model.kernels.of_state("closure_bias", q[None], along[None])[0] / self.model.length
        return along, np.linalg.lstsq(rows, np.append(-bias, np.zeros(len(rows) - len(bias))), rcond=1e-12)[0]

    def _along(self, q: FloatArray) -> FloatArray:
        rows = self._rows(q)
        wanted = np.append(np.zeros(len(rows) - 1), self.way)
        return np.asarray(np.linalg.lstsq(rows, wanted, rcond=1e-12)[0], dtype=float)

    def _sample(self, q: FloatArray) -> Sample:
        """The torque does the work that the motion takes, per radian of the crank: no other force does any."""
        along, bend = self._motion(q)
        self._check_sliding(q, along)
        u, u_dot = abs(self.rate) * along, self.rate**2 * bend
        force = self.model.kernels.inverse_dynamics(q[None], u[None], 0.0, u_dot[None])[0]
        return q, u, u_dot, float(force @ along) * self.way, float(np.abs(force) @ np.abs(along))

    def _check_sliding(self, q: FloatArray, u: FloatArray) -> None:
        """No rough contact slides: by its friction it would take work, and nothing says how hard it pushes."""
        closed = (self.contacts.depths(q) >= -CLOSED) & (self.contacts.friction > 0.0)
        rows = self.contacts.tangents(q)
        slides = closed & (np.abs(rows @ u) > SLIDING * np.linalg.norm(rows, axis=1) * np.linalg.norm(u))
        slides &= np.abs(self.contacts.normals(q) @ u) <= SLIDING * np.linalg.norm(rows, axis=1) * np.linalg.norm(u)
        if np.any(slides):
            point, ground = self.model.contacts[int(np.argmax(slides))]
            raise ValueError(
                f"{self.joint}: {point} slides on rough {ground}, and the motion does not give its friction; leave "
                "out the contact, or simulate the motion"
            )

    def _walk(self, q: FloatArray, angle: float, wanted: float) -> FloatArray:
        """From ``q`` at ``angle`` to ``wanted`` (rad), on the branch that continues the motion smoothly."""
        step, over, bar = STRIDE, False, -1
        while wanted - angle > 1e-12:
            h = min(step, wanted - angle)
            along, bend = self._motion(q)
            change = h * along + h * h / 2.0 * bend
            found = self._corrected(q + change, float(self.drive @ q) + self.way * h)
            bar = -1 if found is None else self._bar(q, along, found, h)
            if found is None or bar >= 0 or np.linalg.norm(found - q - change) > MISS * np.linalg.norm(change):
                step = h / 2.0
                if over or step < SHORTEST:
                    raise ValueError(self._stuck(angle, bar, q))
            elif self.condition(found) > SINGULAR and h < wanted - angle:
                step, over = 1.3 * h, True  # over the change point rather than onto it
            else:
                q, angle, step, over = found, angle + h, min(STRIDE, 2.0 * h), False
        return q

    def _bar(self, q: FloatArray, along: FloatArray, found: FloatArray, h: float) -> int:
        """A contact whose gap is negative at ``found``, or, by its rates, on the way there from ``q``, ``h`` (rad) of
        the crank; −1 for none."""
        if not len(self.contacts):
            return -1
        gaps, ends = -self.contacts.depths(q), -self.contacts.depths(found)
        states = np.array([q, found]), np.array([along, self._along(found)])
        rate, last = self.model.kernels.of_state("gap_rates", *states) / self.contacts.sizes
        dips = (rate < 0.0) & (last > 0.0)
        least = np.where(dips, np.minimum(gaps + rate * _meeting(gaps, ends, rate, last, dips, h), ends), ends)
        worst = int(np.argmin(least))
        return worst if least[worst] < -DEEPEST else -1

    def _stuck(self, angle: float, bar: int, q: FloatArray) -> str:
        """Why the crank goes no further than to ``angle`` (rad), at ``q``: contact ``bar``, or a dead point where that
        is −1."""
        where = f"{self.joint} cannot be turned right round: it comes to a stop after {np.degrees(angle):.6g}°"
        if bar < 0:
            open_ = np.linalg.svd(self._rows(q))[2][len(q) - 1]  # the motion that rows exclude least
            why = f"{lined_up(self.model, q, open_)}no motion closes the loops beyond"
            return f"{where}: {why}, expected a crank; name another joint"
        point, ground = self.model.contacts[bar]
        what = "" if ground in self.model.stops | self.model.slide_ends else "the surface of "
        advice = "leave that out, turn it the other way, or name another joint"
        return f"{where}, where {point} reaches {what}{ground}, which would push; {advice}"

    def _corrected(self, q: FloatArray, crank: float) -> FloatArray | None:
        """The configuration near ``q`` with loops shut and the crank at ``crank`` (rad), ``None`` where none is."""
        for _ in range(12):
            rows, shut = self._rows(q), self.model.closure(q) / self.model.length
            miss = np.concatenate([shut, np.zeros(len(rows) - len(shut) - 1), [self.drive @ q - crank]])
            step = np.linalg.lstsq(rows, miss, rcond=1e-9)[0]
            q = q - step
            if np.max(np.abs(step)) <= 1e-13 * (1.0 + np.max(np.abs(q))):
                return q
        return q if np.max(np.abs(miss)) < 1e-12 else None


def _meeting(
    gaps: FloatArray, ends: FloatArray, rate: FloatArray, last: FloatArray, dips: BoolArray, h: float
) -> FloatArray:
    """Where the tangents at both ends of a step of ``h`` (rad) meet: a gap that bends upwards is nowhere below."""
    return np.asarray((ends - gaps - last * h) / np.where(dips, rate - last, -1.0))


def _at_zero(sides: list[Sample]) -> tuple[Sample, float]:
    """What samples at the places :data:`BESIDE` tell of their middle, and how far the torque is off: that of the
    polynomial through them (Lagrange) from that without the outermost, which is more off."""
    every, inner = _weights(BESIDE), _weights(BESIDE[1:-1])
    found = [sum(weight * side[k] for weight, side in zip(every, sides, strict=True)) for k in range(5)]
    less = sum(weight * side[3] for weight, side in zip(inner, sides[1:-1], strict=True))
    q, u, u_dot, torque, _ = found
    size = max(side[4] for side in sides)
    return (q, u, u_dot, float(torque), size), float(abs(torque - less))  # type: ignore[return-value, arg-type]


def _weights(places: FloatArray) -> list[float]:
    """What values at ``places`` count in their polynomial at zero."""
    return [float(np.prod(-rest / (own - rest))) for own, rest in ((one, places[places != one]) for one in places)]
