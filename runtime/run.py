"""The record of one simulated motion: what happened, how exactly, and ways to keep and to see it."""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from .extras import needed
from .frames import Drawable, FloatArray
from .precision import finite

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from .forces import Along

Advance = Callable[[float, FloatArray, FloatArray, float], tuple[FloatArray, FloatArray]]
FORMAT_VERSION = 1


@dataclass(frozen=True, eq=False)
class Impact:
    """Contacts that struck together at the instant t.

    `contacts` are (point, ground) names, `impulses` (k,) theirs along the grounds' normals in N s (of a stop,
    whose names are a joint and `stop_0.lowest` or `.highest`, in N m s), `u_minus` and
    `u_plus` (nu,) the velocities before and after, `energy_loss` the energy that went, in J. `friction` (k,) are the
    impulses along the grounds (N s), and `reactions` (joints, 3) those of the joints, x, y (N s) and moment (N m s), on
    their outboard links. Where a loop comes to lie in a line on the ground it strikes itself: the impulses of the
    contacts that lie there are zero then, and so are the joints', which have no bounds.
    """

    t: float
    contacts: tuple[tuple[str, str], ...]
    u_minus: FloatArray
    u_plus: FloatArray
    impulses: FloatArray
    energy_loss: float
    friction: FloatArray = field(default_factory=lambda: np.zeros(0))
    reactions: FloatArray = field(default_factory=lambda: np.zeros((0, 3)))

    def __post_init__(self) -> None:
        _freeze(self, "u_minus", "u_plus", "impulses", "friction", "reactions")
        if self.u_minus.ndim != 1 or self.u_plus.shape != self.u_minus.shape:
            shapes = f"{self.u_minus.shape} and {self.u_plus.shape}"
            raise ValueError(f"velocities of an impact have shapes {shapes}, expected (nu,) for both")
        if not self.contacts or self.impulses.shape != (len(self.contacts),):
            raise ValueError(f"impact has {len(self.contacts)} contacts and impulses of shape {self.impulses.shape}")
        if self.friction.shape not in ((0,), self.impulses.shape) or self.reactions.shape[1:] != (3,):
            shapes = f"{self.friction.shape} and {self.reactions.shape}"
            raise ValueError(
                f"impact has friction and reactions of shapes {shapes}, expected (contacts,) or none, and (joints, 3)"
            )
        if not (math.isfinite(self.t) and math.isfinite(self.energy_loss)):
            raise ValueError(f"impact has time {self.t} and energy loss {self.energy_loss}, expected finite numbers")

    def __setstate__(self, state: dict[str, Any]) -> None:
        _restore(self, state)


@dataclass(frozen=True)
class Phase:
    """A stretch of the motion of one kind; an impact starts and ends at the same instant.

    In a phase of kind "contact" the `contacts`, (point, ground) names, stay closed, and `how` says how each does:
    "smooth"; "sticks"; "slides forward" or "slides backward", forward being along the ground with its normal to the
    left; "at the limit, forward" or "backward" of its friction while other contacts keep it from sliding; "carried" by
    others; "touches" where there is friction but nothing presses, as between what moves side by side.
    """

    kind: Literal["flight", "impact", "contact"]
    start: float
    end: float
    contacts: tuple[tuple[str, str], ...] = ()
    how: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if self.kind not in ("flight", "impact", "contact"):
            raise ValueError(f"phase is of kind {self.kind!r}, not 'flight', 'impact' or 'contact'")
        if len(self.how) != len(self.contacts):
            raise ValueError(
                f"phase has {len(self.contacts)} contacts, and says of {len(self.how)} how they stay closed"
            )
        if (self.kind == "contact") != bool(self.contacts):
            raise ValueError(f"phase of kind {self.kind!r} has {len(self.contacts)} contacts that stay closed")
        if not self.start <= self.end < np.inf:
            raise ValueError(f"phase goes from {self.start} to {self.end}")


@dataclass(frozen=True, eq=False)
class Run:
    """A simulated motion: rows t (nt,), q (nt, nq), u (nt, nu); an impact is two rows of the same t, before and after.

    `model` carries the parameter values that the motion was computed with. `advance(t0, q0, u0, h)` is the state that
    one projected step of the run's method reaches from a recorded row; `motion(t, q, u)` the forces along the run.
    `success` says whether the end was reached,
    `message` why not. Audits: `closure_max`, the largest gap of a cut joint (m), and `energy_drift`, the largest
    unexplained change of energy (J), over all rows; `closure_rate_max`, the largest speed at which one opens (m/s).
    `acceleration_error` is how far accelerations are from right, relative to the largest of a state, as far as the
    masses are at fault: their rounding at some of the rows, or where it is repaired, what could not be.
    `method` and `drift` say how it was integrated and how the loops were kept shut.
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
    advance: Advance = field(repr=False)
    motion: Along | None = field(default=None, repr=False)
    method: str = ""
    drift: str = "projected"
    closure_rate_max: float = 0.0
    acceleration_error: float = 0.0

    def __post_init__(self) -> None:
        _freeze(self, "t", "q", "u")
        if self.t.ndim != 1 or not self.t.size or (self.t[1:] < self.t[:-1]).any():
            raise ValueError("times of a run must be a row of at least one number that never decreases")
        for name, names in (("q", self.model.q_names), ("u", self.model.u_names)):
            shape = getattr(self, name).shape
            if shape != (self.t.size, len(names)):
                raise ValueError(
                    f"{name} of a run has shape {shape}, expected {(self.t.size, len(names))}: (times, names)"
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
        _restore(self, state)

    def __repr__(self) -> str:
        end = "" if self.success else f", stopped early: {self.message}"
        found = f"{self.t.size} rows, {len(self.impacts)} impacts{end}"
        return f"<Run of {self.model.name} to t = {self.t[-1]:.6g} s: {found}>"

    def at(self, t: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """The state (q, u) at t, a number or a row of them, as accurate as the run; after-impact at an impact time.

        Starts from the last recorded row that is not later than t and goes on from there, with contacts in one step,
        without them by steps as those of the run.
        """
        try:
            times = np.asarray(t, dtype=self.t.dtype)
        except (TypeError, ValueError):
            raise ValueError(f"t: found {t!r}, expected a number or a row of them") from None
        if times.ndim > 1:
            raise ValueError(f"times have shape {times.shape}, expected a number or a row of them")
        if not np.all((times >= self.t[0]) & (times <= self.t[-1])):
            raise ValueError(f"the run goes from t = {self.t[0]} to {self.t[-1]}; asked for {times}")
        wanted = np.atleast_1d(times)
        rows = np.searchsorted(self.t, wanted, side="right") - 1
        q, u = self.q[rows], self.u[rows]
        for k in np.flatnonzero(wanted > self.t[rows]):
            start = self.t[rows[k]].item()
            q[k], u[k] = self.advance(start, self.q[rows[k]], self.u[rows[k]], wanted[k].item() - start)
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
        """Per joint the force x, y (N) and the moment (N m) on its outboard link at t, with what contacts push.

        (joints, 3), or (b, joints, 3) for a row of times; at an impact time as after it, where it is impulses that act,
        `Impact.reactions`. Those of redundant joints are of least norm.
        """
        return self._forces(t, "reactions")

    def _forces(self, t: ArrayLike, what: str) -> FloatArray:
        if self.motion is None:
            raise ValueError("this run knows no forces: it was not made by simulate")
        q, u = self.at(t)
        times = np.atleast_1d(np.asarray(t, dtype=self.t.dtype))
        found: FloatArray = getattr(self.motion(times, np.atleast_2d(q), np.atleast_2d(u)), what)
        return found if np.ndim(t) else found[0]

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write everything recorded to an .npz file, whole or not at all; `numpy.load` reads it."""
        target = Path(path)
        if target.suffix != ".npz":
            raise ValueError(f"a run is saved as .npz, found {target.name!r}; use another name")
        write_whole(target, lambda part: np.savez_compressed(part, allow_pickle=False, **self._arrays()))
        return target

    def _arrays(self) -> dict[str, Any]:
        """The run as named arrays without objects; contacts of impact k are impact_offsets[k]:impact_offsets[k + 1]."""
        impacts, parameters = self.impacts, dict(self.model.parameters)
        contacts = [contact for impact in impacts for contact in impact.contacts]
        joints = len(self.model.joints)

        def known(found: FloatArray, shape: tuple[int, ...]) -> FloatArray:
            return found if found.shape == shape else np.zeros(shape)

        return {
            "format": np.array("ccgen run"),
            "format_version": np.array(FORMAT_VERSION),
            "model": np.array(self.model.name),
            "q_names": _texts(self.model.q_names),
            "u_names": _texts(self.model.u_names),
            "parameter_names": _texts(parameters),
            "parameter_values": np.array(list(parameters.values()), dtype=float),
            "t": self.t,
            "q": self.q,
            "u": self.u,
            "impact_t": np.array([impact.t for impact in impacts], dtype=float),
            "impact_offsets": np.cumsum([0] + [len(impact.contacts) for impact in impacts]),
            "impact_points": _texts(point for point, _ in contacts),
            "impact_grounds": _texts(ground for _, ground in contacts),
            "impact_impulses": np.concatenate([np.zeros(0)] + [impact.impulses for impact in impacts]),
            "impact_friction": np.concatenate(
                [np.zeros(0)] + [known(impact.friction, impact.impulses.shape) for impact in impacts]
            ),
            "impact_reactions": np.reshape(
                [known(impact.reactions, (joints, 3)) for impact in impacts], (len(impacts), joints, 3)
            ),
            "impact_u_minus": np.reshape([impact.u_minus for impact in impacts], (-1, self.u.shape[1])),
            "impact_u_plus": np.reshape([impact.u_plus for impact in impacts], (-1, self.u.shape[1])),
            "impact_energy_loss": np.array([impact.energy_loss for impact in impacts], dtype=float),
            "phase_kinds": _texts(phase.kind for phase in self.phases),
            "phase_starts": np.array([phase.start for phase in self.phases], dtype=float),
            "phase_ends": np.array([phase.end for phase in self.phases], dtype=float),
            "phase_offsets": np.cumsum([0] + [len(phase.contacts) for phase in self.phases]),
            "phase_points": _texts(point for phase in self.phases for point, _ in phase.contacts),
            "phase_how": _texts(how for phase in self.phases for how in phase.how),
            "phase_grounds": _texts(ground for phase in self.phases for _, ground in phase.contacts),
            "success": np.array(self.success),
            "message": np.array(self.message),
            "nfev": np.array(self.nfev),
            "method": np.array(self.method),
            "drift": np.array(self.drift),
            "closure_max": np.array(self.closure_max),
            "closure_rate_max": np.array(self.closure_rate_max),
            "energy_drift": np.array(self.energy_drift),
            "acceleration_error": np.array(self.acceleration_error),
        }

    def to_xarray(self) -> Any:
        """The run as an xarray.Dataset: rows over `t`, impacts over `impact`, their contacts over `contact`.

        What a run has none of, as impacts, is left out with its dimension. As a table: :meth:`to_dataframe`.
        """
        xarray = needed("xarray", "a run as a Dataset")
        arrays = self._arrays()
        kinetic, potential = self.model.energy(self.q, self.u)
        owners = np.repeat(np.arange(len(self.impacts)), np.diff(arrays["impact_offsets"]))
        data = {
            "q": (("t", "coordinate"), self.q, {"long_name": "coordinates", "units": "see q_units"}),
            "u": (("t", "velocity"), self.u, {"long_name": "velocities", "units": "see u_units"}),
            "kinetic_energy": ("t", kinetic, {"units": "J"}),
            "potential_energy": ("t", potential, {"units": "J"}),
            "u_minus": (("impact", "velocity"), arrays["impact_u_minus"], {"units": "see u_units"}),
            "u_plus": (("impact", "velocity"), arrays["impact_u_plus"], {"units": "see u_units"}),
            "energy_loss": ("impact", arrays["impact_energy_loss"], {"units": "J"}),
            "impulse": (
                "contact",
                arrays["impact_impulses"],
                {"units": "N s; stops: N m s" if self.model.stops else "N s"},
            ),
            "friction_impulse": ("contact", arrays["impact_friction"], {"units": "N s"}),
            "joint_impulse": (
                ("impact", "joint", "component"),
                arrays["impact_reactions"],
                {"units": "N s; the moment: N m s"},
            ),
            "parameters": ("parameter", arrays["parameter_values"], {"units": "SI"}),
        }
        coordinates = {
            "t": ("t", self.t, {"long_name": "time", "units": "s"}),
            "coordinate": arrays["q_names"],
            "q_units": ("coordinate", _texts(_unit(name) for name in self.model.q_names)),
            "velocity": arrays["u_names"],
            "u_units": ("velocity", _texts(f"{_unit(name)}/s" for name in self.model.u_names)),
            "joint": _texts(self.model.joints),
            "component": _texts(("x", "y", "moment")),
            "impact_t": ("impact", arrays["impact_t"], {"units": "s"}),
            "contact_impact": ("contact", owners, {"long_name": "number of the impact, from 0"}),
            "contact_point": ("contact", arrays["impact_points"]),
            "contact_ground": ("contact", arrays["impact_grounds"]),
            "parameter": arrays["parameter_names"],
        }
        facts = ("model", "success", "message", "nfev", "closure_max", "energy_drift")
        attributes = {name: arrays[name].item() for name in facts}
        attributes["success"] = int(self.success)  # netCDF has no truth values
        dataset = xarray.Dataset(data, coordinates, attributes)
        found = dataset.drop_dims([name for name, size in dataset.sizes.items() if not size])
        return found if self.impacts else found.drop_vars(["joint", "component"], errors="ignore")

    def to_dataframe(self) -> Any:
        """The run's rows as a pandas.DataFrame over `t` (s): coordinates and velocities by name, and the energies.

        An impact is two rows of the same t, before and after. `attrs["units"]` has the unit of every column.
        """
        pandas = needed("pandas", "a run as a DataFrame")
        kinetic, potential = self.model.energy(self.q, self.u)
        columns = dict(zip(self.model.q_names, self.q.T, strict=True)) | dict(
            zip(self.model.u_names, self.u.T, strict=True)
        )
        units = {name: _unit(name) for name in self.model.q_names}
        units |= {name: f"{_unit(name)}/s" for name in self.model.u_names}
        columns |= {"kinetic_energy": kinetic, "potential_energy": potential}
        frame = pandas.DataFrame(columns, index=pandas.Index(self.t, name="t"))
        frame.attrs["units"] = units | {"kinetic_energy": "J", "potential_energy": "J"}
        return frame

    def plot(self, path: str | os.PathLike[str] | None = None) -> Figure:
        """A figure of poses, energy, heights and closure over time; with a path it is also saved there, as a PNG,
        in place of what is there."""
        from .plot import draw

        figure: Figure = draw(self, path)
        return figure

    def animate(self, path: str | os.PathLike[str]) -> Path:
        """Write the motion as a page that plays in a browser (.html) or as a moving picture (.gif)."""
        target = Path(path)
        if target.suffix == ".html":
            from .player import write_player

            return write_player(self, target)
        if target.suffix == ".gif":
            from .gif import write_gif

            return write_gif(self, target)
        raise ValueError(f"an animation is an .html page or a .gif picture, found {target.name!r}; use one of the two")


def write_whole(target: Path, write: Callable[[Any], object]) -> None:
    """Let `write` fill a file beside the target and put it in place only once it is complete."""
    if not target.parent.is_dir():
        raise FileNotFoundError(f"{target}: there is no folder {target.parent}; make it first")
    part = target.with_name(f".{target.name}.{os.getpid()}.part")
    try:
        with part.open("wb") as file:
            write(file)
        part.replace(target)
    finally:
        part.unlink(missing_ok=True)


def _freeze(record: object, *names: str) -> None:
    """Make the named fields read-only arrays of finite numbers, of the precision that they have."""
    for name in names:
        array = np.array(getattr(record, name))
        array = array if array.dtype.kind == "f" else array.astype(float)
        if not finite(array):
            raise ValueError(f"{name} of the {type(record).__name__.lower()} holds a number that is not finite")
        array.flags.writeable = False
        object.__setattr__(record, name, array)


def _restore(record: object, state: dict[str, Any]) -> None:
    """Fill a record from a pickle or a copy; its arrays are read-only as before."""
    vars(record).update(state)
    for value in state.values():
        if isinstance(value, np.ndarray):
            value.flags.writeable = False


def _texts(texts: Any) -> Any:
    return np.array(list(texts), dtype=np.str_)


def _unit(name: str) -> str:
    """The unit of a coordinate, and per second of a velocity, from its name: angles are theta_* and w_*."""
    return "rad" if name.startswith(("theta_", "w_")) else "m"
