"""The record of one simulated motion: what happened, how exactly, and the states between its rows."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..arrays import FloatArray
from ..model.forces import Motion
from ..model.numbers import read_numbers
from ..precision import ascending
from .drawable import Drawable
from .event import Event
from .frozen import freeze, restore
from .impact import Impact
from .in_force import InForce
from .joint_change import JointChange
from .phase import Phase


class Step(Protocol):
    """How a run goes on from its rows."""

    def between(self, t: float, times: FloatArray, q: FloatArray, u: FloatArray, /) -> tuple[FloatArray, FloatArray]:
        """The state (q, u) at t between two rows that follow each other, at ``times`` (2,), q and u (2, n).

        Raises ``ValueError`` where none is found."""


class Forces(Protocol):
    """Accelerations and forces along a run, which may jump at the times ``since`` (n,)."""

    @property
    def since(self) -> FloatArray: ...

    def __call__(self, t: FloatArray, q: FloatArray, u: FloatArray, /) -> Motion:
        """Those at times t (b,) and states q, u (b, n) of the run."""


@dataclass(frozen=True, eq=False)
class Record:
    """The rows t (nt,), q (nt, nq), u (nt, nu) of a run, its impacts and phases, its end and its audits.

    Checks itself; the states between the rows are what ``advance`` finds there. :class:`~..run.Run` says what
    each of its fields is.
    """

    model: Drawable
    t: FloatArray
    q: FloatArray
    u: FloatArray
    impacts: tuple[Impact, ...]
    phases: tuple[Phase, ...]
    success: bool
    message: str
    nfev: int
    closure_max: float
    energy_drift: float
    advance: Step = field(repr=False)
    motion: Forces | None = field(default=None, repr=False)
    method: str = ""
    drift: str = "projected"
    rest_speed: float = 0.0
    choices: int = 0
    chosen_at: float | None = None
    closure_rate_max: float = 0.0
    acceleration_error: float = 0.0
    changes: tuple[JointChange, ...] = ()
    events: tuple[Event, ...] = ()
    unexplained: FloatArray = field(default_factory=lambda: np.zeros(0), repr=False)
    traced: tuple[FloatArray, NDArray[np.int32]] | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        freeze(self, "t", "q", "u", "unexplained")
        if self.t.ndim != 1 or not self.t.size or not ascending(self.t):
            raise ValueError("times of a run must be a row of at least one number that never decreases")
        for name, names in (("q", self.model.q_names), ("u", self.model.u_names)):
            shape = getattr(self, name).shape
            if shape != (self.t.size, len(names)):
                raise ValueError(
                    f"{name} of a run has shape {shape}, expected {(self.t.size, len(names))}: (times, names)"
                )
        if self.unexplained.shape not in ((0,), self.t.shape):
            raise ValueError(
                f"unexplained of a run has shape {self.unexplained.shape}, expected {self.t.shape} or none"
            )
        recorded = set(self.t.tolist()) if self.impacts else set()
        for impact in self.impacts:
            if impact.u_minus.shape != self.u.shape[1:]:
                found, wanted = impact.u_minus.shape, self.u.shape[1:]
                raise ValueError(f"velocities of the impact at t = {impact.t} have shape {found}, expected {wanted}")
            if impact.t not in recorded:
                raise ValueError(f"impact at t = {impact.t} is at none of the recorded times")
        times = [impact.t for impact in self.impacts]
        if times != sorted(times):
            raise ValueError("impacts of a run must be in the order of time")
        if any(after.start != before.end for before, after in zip(self.phases, self.phases[1:], strict=False)):
            raise ValueError("each phase of a run must start where the one before it ends")
        if not (self.closure_max >= 0 and self.energy_drift >= 0):
            raise ValueError(f"audits of a run are {self.closure_max} and {self.energy_drift}, expected numbers >= 0")

    def __setstate__(self, state: dict[str, Any]) -> None:
        restore(self, {"unexplained": np.zeros(0), "traced": None} | state)  # runs of earlier versions have none

    def __repr__(self) -> str:
        end = "" if self.success else f", stopped early: {self.message}"
        found = f"{self.t.size} rows, {len(self.impacts)} impacts{end}"
        return f"<Run of {self.model.name} to t = {self.t[-1]:.6g} s: {found}>"

    @property
    def stretches(self) -> tuple[Record, ...]:
        """The runs of one model each that this one is put together from, where events have set parameters or switched
        effects between them."""
        return (self,)

    @property
    def in_force(self) -> InForce:
        """Which model is in force when: with the parameters of then, and without the effects that are off then."""
        return InForce.of_one(self.model)

    def model_at(self, t: float) -> Drawable:
        """The model in force at t (s), as :meth:`~..run.Run.model_at` says."""
        time = read_numbers(t, "t", self.t.dtype)
        if time.ndim or not self.t[0] <= time <= self.t[-1]:
            raise ValueError(f"t: found {t!r}, expected a time within the run, from {self.t[0]} to {self.t[-1]} s")
        return self.in_force.models[int(self.in_force.at(np.atleast_1d(time))[0])]

    def at(self, t: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """The state (q, u) at t, a number or a row of them, as accurate as the run; after-impact at an impact time.

        Starts from the last recorded row that is not later than t and goes on from there, with contacts in one step,
        without them by steps as those of the run. Where that leads away from the next row, as beside a singular
        configuration, where branches cross, it comes back from there.
        """
        times = read_numbers(t, "t", self.t.dtype)
        if times.ndim > 1:
            raise ValueError(f"t: found shape {times.shape}, expected a number or a row of them")
        outside = times[~((times >= self.t[0]) & (times <= self.t[-1]))]
        if outside.size:
            raise ValueError(
                f"t: found {outside.flat[0]:g} s, expected times within the run, which goes from t = {self.t[0]} to "
                f"{self.t[-1]} s"
            )
        wanted = np.atleast_1d(times)
        rows = np.searchsorted(self.t, wanted, side="right") - 1
        q, u = self.q[rows], self.u[rows]
        for k in np.flatnonzero(wanted > self.t[rows]):
            two = slice(rows[k], rows[k] + 2)
            q[k], u[k] = self.advance.between(wanted[k].item(), self.t[two], self.q[two], self.u[two])
        return (q, u) if times.ndim else (q[0], u[0])

    def contact_forces(self, t: ArrayLike) -> FloatArray:
        """Force of every contact at t along its normal and along the ground, (contacts, 2); of times (b, contacts, 2).

        In N, of ``model.contacts`` in their order; of a stop the moment (N m), in the first. Zero where it is apart. It
        acts on the link of the contact's point; a link that this touches has the opposite. Along the ground is the
        normal turned clockwise: the direction of forward sliding. At an impact time as after it: what acts there is an
        impulse, `Impact.impulses`. From the state, contacts held as the run has held them (theory, section 5.10);
        forces that are not unique, as under a table with four legs, are those of least norm.
        """
        return self._forces(t, "pushes")

    def reactions(self, t: ArrayLike) -> FloatArray:
        """Per joint the force x, y (N) and the moment (N m) on its second link at t, with what contacts push.

        (joints, 3), or (b, joints, 3) for a row of times; at an impact time as after it, where it is impulses that act,
        `Impact.reactions`. Those of redundant joints are of least norm.
        """
        return self._forces(t, "reactions")

    def accelerations(self, t: ArrayLike) -> FloatArray:
        """Quasi-accelerations (nu,) at t, or (b, nu) for a row of times, with what contacts push; as ``reactions``."""
        return self._forces(t, "u_dot")

    def joint_angles(self, t: ArrayLike | None = None) -> dict[str, FloatArray]:
        """Per joint that turns the angle of its second link against its first (rad) at t, or at the rows of the run.

        Turns are counted: an angle goes on beyond 2π.
        """
        return dict(self.model.joint_angles(self.q if t is None else self.at(t)[0]))  # no parameters are in them

    def _forces(self, t: ArrayLike, what: str) -> FloatArray:
        if self.motion is None:
            raise ValueError("this run knows no forces: it was not made by simulate")
        q, u = self.at(t)
        times = np.atleast_1d(np.asarray(t, dtype=self.t.dtype))
        found: FloatArray = getattr(self.motion(times, np.atleast_2d(q), np.atleast_2d(u)), what)
        return found if np.ndim(t) else found[0]
