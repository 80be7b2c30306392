"""A generated model: its names, parameters, and the functions of its state."""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from .assemble import nearest_closed
from .drives import drive_rows, put_where_driven
from .failed_impact import failed_impact
from .forces import Contacts, flight_of, in_flight, motion_of
from .frames import Disc, FloatArray
from .inputs import Values, read_values
from .lines import Lines
from .parameters import Parameters
from .poses import check_angles, joint_miss, largest_angle, read_off, read_rates, read_state
from .precision import core_of, finite
from .samples import ROUNDING, samples

if TYPE_CHECKING:
    from ._core import Kernels

UNPROJECTED = {
    "not_closed": "it is too far from closed; assemble it first",
    "not_finite": "its closure is not a finite number; check the parameters",
}

KNOWN = 1e-9
"""Accelerations and jumps that are known less well than this, relative to the largest, come with a warning."""


class Model:
    """A mechanism's equations of motion in flight and impact, compiled.

    States are ``q`` (nq,) and ``u`` (nu,), or batches (b, nq) and (b, nu); results then have a leading axis b too. SI
    units, y up, angles counter-clockwise in radians. Wrong shapes, numbers that are not finite, and angles so large
    that their digits are gone are ``ValueError``s.
    """

    def __init__(
        self,
        descriptor: object,
        data: Mapping[str, Any],
        values: Mapping[str, float] | None = None,
        folder: Path | None = None,
    ) -> None:
        self._descriptor, self.data, self.folder = descriptor, data, folder
        self.name: str = data["name"]
        self.links = tuple(data["links"])
        self.joints = tuple(data["joints"])
        self.grounds = tuple(plane["name"] for plane in data["grounds"])
        self.stops = frozenset(data["stops"])
        self.points = tuple(data["points"])
        self.q_names = tuple(data["q_names"])
        self.u_names = tuple(data["u_names"])
        self.inputs = tuple(data["inputs"])
        self.angular = tuple(index for index, (kind, _) in enumerate(data["coordinates"]) if kind == "angle")
        self.cuts = tuple(data["cuts"])
        self.rows = tuple(data["rows"])
        self.outboard = tuple(data["outboard"])
        self.root: str = data["root"]
        self.folded: bool = data.get("folded", False)
        self.precision: str = data.get("precision", "double")
        self.core = core_of(self.precision)
        self.contacts: tuple[tuple[str, str], ...] = tuple((point, ground) for point, ground in data["contacts"])
        self._changes = 0
        self._copy: tuple[Model | None, tuple[int, int]] = None, (0, 0)
        folded = self.name if self.folded else ""
        self._parameters = Parameters(
            dict(data["parameters"]) | dict(values or {}), self._rebuild, folded, data.get("rests_on")
        )
        self._rebuild()
        if self.kernels.hash != data["hash"]:
            raise ImportError(f"the code and the data of {self.name} are of different scenes; generate the model again")

    def _rebuild(self) -> None:
        values = np.array([] if self.folded else list(self._parameters.values()), dtype=float)
        angular = [index for index, (_, ground) in enumerate(self.contacts) if ground in self.stops]
        kernels = self.core.Kernels(self._descriptor, values, self.length, self.data["law"], angular)
        if not np.all(np.isfinite(kernels.constants)):
            raise ValueError(
                f"{self.name}: the equations have no finite constants with these values (a normal of no length?)"
            )
        lost, usual = kernels.rounding(*samples(self.q_names, self.length, self.core.REAL)).max(axis=0).tolist()
        if lost > ROUNDING * float(np.finfo(self.core.REAL).eps) * usual:
            kernels.refine_from_now(usual)
        self.usual = usual
        self.kernels: Kernels = kernels
        self._changes += 1

    @property
    def length(self) -> float:
        """A length of the mechanism (m): the largest extent of a link."""
        extents = [float(np.ptp(outline, axis=0).max()) for outline in self.outlines if len(outline) > 1]
        return max(extents, default=0.0) or 1.0

    def __repr__(self) -> str:
        counts = ((len(self.links), "link"), (len(self.joints), "joint"), (self.dof, "degree"))
        links, joints, degrees = (f"{count} {word}{'s' * (count != 1)}" for count, word in counts)
        return f"<Model {self.name}: {links}, {joints}, {degrees} of freedom>"

    # -- copies ----------------------------------------------------------------------------------------------------

    def __copy__(self) -> Model:
        return self.with_parameters(None)

    def __deepcopy__(self, memo: object) -> Model:
        return self.with_parameters(None)

    def __reduce__(self) -> tuple[Any, ...]:
        """A pickle holds the folder of the package and the parameters; a process that reads it loads the model there.

        Raises ``TypeError`` for a model that is in no package.
        """
        from .load import reopen

        if self.folder is None:
            raise TypeError(f"{self.name}: found a model without a package, which cannot be pickled; load it from one")
        return reopen, (self.folder, self.name, self.data["hash"], dict(self._parameters))

    # -- what it is made of ----------------------------------------------------------------------------------------

    @property
    def parameters(self) -> Parameters:
        """Values by scene path (``link_0.mass``); set one and it takes effect at once."""
        return self._parameters

    def as_it_is(self) -> Model:
        """A model with the values of now, which stays as it is when this one's change; the same one until they do."""
        copy, changes = self._copy
        if copy is None or changes != (self._changes, copy._changes):
            copy = self.with_parameters(None)
            self._copy = copy, (self._changes, copy._changes)
        return copy

    def with_parameters(self, values: Mapping[str, float] | None) -> Model:
        """A model of its own with other parameter values; this one stays as it is."""
        other = Model(self._descriptor, self.data, self._parameters, self.folder)
        if values:
            other.parameters.update(values)
        return other

    @property
    def dof(self) -> int:
        """Degrees of freedom at the scene's start: quasi-velocities less the rank of the closure and driven joints."""
        jacobian = self.jacobian(read_off(self, np.array(self.data["start"]["poses"], dtype=float)))
        rows = np.vstack([jacobian, drive_rows(self) * self.length])
        coarse = max(1e-9, 100.0 * float(np.finfo(self.core.REAL).eps))
        rank = int(np.linalg.matrix_rank(np.asarray(rows, dtype=float), tol=coarse * self.length)) if len(rows) else 0
        return len(self.u_names) - rank

    @property
    def outlines(self) -> tuple[FloatArray, ...]:
        """Per link its named points in the link's frame, (m, 2) in m."""
        return tuple(self._coordinates(points) for points in self.data["outlines"])

    @property
    def discs(self) -> tuple[Disc, ...]:
        """Discs and edges of links and of the ground, by which they touch."""
        return tuple(
            Disc(disc["link"], ends[0], self._coordinates([[disc["radius"], 0.0]])[0, 0].item(), *ends[1:])
            for disc in self.data["discs"]
            for ends in [self._coordinates([disc[end] for end in ("point", "end") if end in disc])]
        )

    @property
    def ground_points(self) -> FloatArray:
        """Named points of the ground, (k, 2) in m."""
        return self._coordinates(self.data["ground_points"])

    def ground_planes(self) -> dict[str, tuple[FloatArray, FloatArray]]:
        """Per ground a point of its surface (2,) in m and its outward unit normal (2,)."""
        planes = {}
        for plane in self.data["grounds"]:
            point, normal = self._coordinates([plane["point"], plane["normal"]])
            planes[plane["name"]] = (point, normal / np.linalg.norm(normal))
        return planes

    def _coordinates(self, points: Sequence[Sequence[str | float]]) -> FloatArray:
        values = [[self._parameters[c] if isinstance(c, str) else c for c in point] for point in points]
        return np.array(values, dtype=float).reshape(-1, 2)

    # -- dynamics --------------------------------------------------------------------------------------------------

    def acceleration(
        self, q: ArrayLike, u: ArrayLike, t: ArrayLike = 0.0, inputs: Values | None = None, contacts: Contacts = None
    ) -> FloatArray:
        """Quasi-accelerations u̇ (nu,), loops held shut (theory, section 4), at the time ``t`` (s), or (b,) for a batch.

        Where closure rows lose rank (a flattened loop, a change point, redundant joints) the dependent ones are left
        out, and multipliers are those of least norm (theory, section 8). ``inputs`` are values by name or in the order
        of the model's ``inputs``, the same for all states of a batch; those that are left out are zero.

        Contacts that are closed (a gap of at most 1e-12 times the mechanism's length) push as a run would have them:
        without pulling, and with friction by Coulomb's law (theory, sections 5.6 and 5.7). ``contacts=()`` leaves them
        out. A list of contacts, (point, ground) names, holds just these, whether they push or pull, and rough ones by
        how they slide; a mapping of them says how each is held, in the words of ``Phase.how``. Raises ``ValueError``
        where an impact comes first, or a contact lies behind its surface.
        """
        return self._motion(q, u, t, inputs, contacts, "u_dot")

    def multipliers(
        self, q: ArrayLike, u: ArrayLike, t: ArrayLike = 0.0, inputs: Values | None = None, contacts: Contacts = None
    ) -> FloatArray:
        """Closure multipliers (rows,): force on the second side of each cut joint, in the rows' directions, N.

        With what contacts push, as in ``acceleration``.
        """
        return self._motion(q, u, t, inputs, contacts, "multipliers")

    def reactions(
        self, q: ArrayLike, u: ArrayLike, t: ArrayLike = 0.0, inputs: Values | None = None, contacts: Contacts = None
    ) -> FloatArray:
        """Per joint the force x, y (N) and the moment (N m) on its outboard link ``outboard[joint]``, (joints, 3).

        With what contacts push, as in ``acceleration``; those of a run: ``run.reactions``.
        """
        return self._motion(q, u, t, inputs, contacts, "reactions")

    def contact_forces(
        self, q: ArrayLike, u: ArrayLike, t: ArrayLike = 0.0, inputs: Values | None = None, contacts: Contacts = None
    ) -> FloatArray:
        """Force of each of ``contacts`` along its normal and along the ground, (contacts, 2), in N; zero where apart.

        It acts on the link of the contact's point; a link that this touches has the opposite. Along the ground is the
        normal turned clockwise: the direction of forward sliding. Of a stop the moment (N m) is in the first. As in
        ``acceleration``; forces that are not unique, as under a table with four legs, are those of least norm. Those of
        a run: ``run.contact_forces``.
        """
        return self._motion(q, u, t, inputs, contacts, "pushes")

    def _motion(
        self, q: ArrayLike, u: ArrayLike, t: ArrayLike, inputs: Values | None, contacts: Contacts, what: str
    ) -> FloatArray:
        states, single = self._state(q, u)
        times = self._times(t, len(states[0]))
        with self.given(inputs):
            if in_flight(self, states[0], contacts):
                found, inexact = flight_of(self, *states, times, what), self.kernels.inexact
            else:
                motion, inexact = motion_of(self, *states, times, contacts, reactions=what == "reactions")
                found = getattr(motion, what)
        self._warn_inexact("accelerations", inexact, 4)
        return found[0] if single else found

    def _times(self, t: ArrayLike, count: int) -> float | FloatArray:
        """One time for all ``count`` states, or each one's own."""
        times = np.asarray(t, dtype=float)
        if times.shape not in ((), (count,)) or not finite(times):
            raise ValueError(f"t: found {t!r}, expected a finite number, or one for each of {count} states")
        return times if times.ndim else float(times)

    def _warn_inexact(self, what: str, inexact: float, depth: int) -> None:
        if inexact > KNOWN:
            warnings.warn(
                f"{self.name}: masses differ so much that {what} are known to {inexact:.0e} of the "
                "largest only; make light links that carry heavy ones heavier, or leave them out",
                stacklevel=depth,
            )

    def energy(self, q: ArrayLike, u: ArrayLike) -> tuple[Any, Any]:
        """Kinetic and potential energy (J); the potential is zero at y = 0."""
        states, single = self._state(q, u)
        found = self.kernels.of_state("energy", *states)
        return (found[0, 0].item(), found[0, 1].item()) if single else (found[:, 0].copy(), found[:, 1].copy())

    def impact(
        self,
        q: ArrayLike,
        u: ArrayLike,
        contacts: Sequence[tuple[str, str]],
        restitution: ArrayLike | None = None,
    ) -> tuple[FloatArray, FloatArray]:
        """Velocities u⁺ (nu,) and normal impulses (k,) in N s when ``contacts`` strike together (theory, section 5).

        ``contacts`` are (point, ground) names, of stops (joint, stop.lowest or stop.highest), whose impulses are in
        N m s; ``restitution`` is a number or one per contact, else the grounds' own.
        Raises ``ValueError`` for unknown or repeated contacts, and where the model's law has no impulses for them, or
        would add energy.
        """
        chosen = [self._contact(contact) for contact in contacts]
        if len(set(chosen)) != len(chosen) or not chosen:
            raise ValueError(f"found contacts {list(contacts)}, expected at least one and each once")
        own = [self._parameters[f"{self.contacts[c][1].partition('.')[0]}.restitution"] for c in chosen]
        e = np.array(own if restitution is None else restitution, dtype=self.core.REAL)
        if e.shape not in ((), (len(chosen),)) or not np.all((e >= 0.0) & (e <= 1.0)):
            raise ValueError(f"found restitution {e}, expected a number from 0 to 1, or {len(chosen)} of them")
        e = np.ascontiguousarray(np.broadcast_to(e, (len(chosen),)))
        (q2, u2), single = self._state(q, u)
        results = []
        for one_q, one_u in zip(q2, u2, strict=True):
            u_plus, impulses, outcome = self.kernels.impact(one_q, one_u, np.array(chosen, dtype=np.int32), e)
            if outcome != "done":
                struck = " and ".join("{} on {}".format(*contact) for contact in contacts)
                reason = failed_impact(outcome, struck, self.data["law"])
                raise ValueError(f"{self.name}: no impact can be computed here ({outcome.replace('_', ' ')}): {reason}")
            self._warn_inexact("jumps", self.kernels.inexact, 3)
            results.append((u_plus, impulses[: len(chosen)]))
        if single:
            return results[0]
        return np.array([r[0] for r in results]), np.array([r[1] for r in results])

    def _contact(self, contact: tuple[str, str]) -> int:
        if isinstance(contact, str) or tuple(contact) not in self.contacts:
            known = ", ".join(f"({point}, {ground})" for point, ground in self.contacts) or "none"
            raise ValueError(f"found contact {contact!r}, expected one of: {known}")
        return self.contacts.index((contact[0], contact[1]))

    # -- geometry --------------------------------------------------------------------------------------------------

    def poses(self, q: ArrayLike) -> FloatArray:
        """Per link x, y (m) and angle (rad) of its frame, (links, 3)."""
        return self._of_q("poses", q, (len(self.links), 3))

    def velocities(self, q: ArrayLike, u: ArrayLike) -> FloatArray:
        """Per link the velocity of its frame's origin (m/s) and its angular velocity (rad/s), (links, 3)."""
        states, single = self._state(q, u)
        found = self.kernels.of_state("velocities", *states).reshape(len(states[0]), len(self.links), 3)
        return found[0] if single else found

    def point(self, name: str, q: ArrayLike) -> FloatArray:
        """Position (2,) in m of a joint (``joint_3``) or of a point of a link, welded or the ground (``link_0.A``)."""
        name = self.data["welded_points"].get(name, name)
        link, _, point = name.partition(".")
        if link == "ground" and point in self.data["ground_names"]:
            place = self.ground_points[self.data["ground_names"].index(point)]
            return np.array(np.broadcast_to(place, (*np.shape(q)[:-1], 2)))
        if name not in self.points:
            raise ValueError(f"found point {name!r}, expected one of: {', '.join(self.points)}")
        return np.ascontiguousarray(self._of_q("points", q, (len(self.points), 2))[..., self.points.index(name), :])

    def slides(self, q: ArrayLike) -> dict[str, FloatArray]:
        """Per sliding joint how far it is along its line (m), from the first link's point to the second's."""
        poses, lines = self.poses(q), self.lines
        return {joint: lines.lengths(joint, poses) for joint in self.data["lines"]}

    def closure(self, q: ArrayLike) -> FloatArray:
        """Miss of every cut joint (rows,), m: second side less first side, x then y, or across the line that it has."""
        return self._of_q("closure", q, (len(self.rows),))

    def jacobian(self, q: ArrayLike) -> FloatArray:
        """Derivatives A (rows, nu) of the closure rates by u."""
        return self._of_q("closure_jacobian", q, (len(self.rows), len(self.u_names)))

    def gaps(self, q: ArrayLike) -> FloatArray:
        """Gap of every contact (contacts,), positive outside: from a ground in m, from a stop in rad."""
        return self._of_q("gaps", q, (len(self.contacts),))

    def gap_rates(self, q: ArrayLike, u: ArrayLike) -> FloatArray:
        """Rates of the gaps (contacts,) in m/s, of stops in rad/s."""
        states, single = self._state(q, u)
        found = self.kernels.of_state("gap_rates", *states)
        return found[0] if single else found

    def _of_q(self, kernel: str, q: ArrayLike, shape: tuple[int, ...]) -> FloatArray:
        states, single = self._batch(q, "q", len(self.q_names))
        found = self.kernels.of_q(kernel, states).reshape(len(states), *shape)
        return found[0].copy() if single else found.copy()

    # -- states ----------------------------------------------------------------------------------------------------

    def start(self) -> tuple[FloatArray, FloatArray]:
        """The scene's start (q, u); where parameters have changed since, the nearest that is closed and driven."""
        poses = np.array(self.data["start"]["poses"], dtype=float)
        velocities = np.array(self.data["start"]["velocities"], dtype=float)
        q, u = read_off(self, poses), read_rates(self, poses, velocities)
        if self.cuts and np.max(np.abs(self.closure(q))) > joint_miss(self):
            q = self.assemble(q)
        if self.data["drives"]:
            q, u = put_where_driven(self, q, u)
        return self.project(q, u)

    def state_from_poses(self, poses: ArrayLike, velocities: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """State (q, u) of links at ``poses`` (links, 3) moving with ``velocities`` (links, 3), or of a batch of them.

        Nothing is projected.

        Raises ``ValueError`` when joints miss by more than 1e-6 m, or their velocities by more than 1e-6 m/s.
        """
        if np.ndim(poses) == 3 and np.shape(poses) == np.shape(velocities):
            states = [
                self.state_from_poses(*one) for one in zip(np.asarray(poses), np.asarray(velocities), strict=True)
            ]
            return np.array([q for q, _ in states]), np.array([u for _, u in states])
        return read_state(self, poses, velocities)

    @property
    def lines(self) -> Lines:
        """The lines of the sliding joints."""
        return Lines(self.data, self._coordinates)

    def assemble(self, q: ArrayLike) -> FloatArray:
        """The consistent configuration nearest to ``q`` in joint displacements (least squares), loops shut to rounding.

        Raises ``ValueError`` when the loops cannot be closed from there, with the miss that remains.
        """
        states, single = self._batch(q, "q", len(self.q_names))
        if not self.cuts:
            return states[0].copy() if single else states.copy()
        found = np.array([nearest_closed(self.closure, self.jacobian, self.displacements(), one) for one in states])
        return found[0] if single else found

    def displacements(self) -> FloatArray:
        """Joint displacements as a linear map of q: relative angles of joints, lengths of sliding joints in units of
        the mechanism's length, place and angle of a floating root."""
        count, coordinates = len(self.q_names), [(kind, of) for kind, of in self.data["coordinates"]]
        leaders = self.data["leaders"]
        rows = []
        for one, other in self.data["between"]:
            row = np.zeros(count)
            for link, sign in ((other, 1.0), (one, -1.0)):
                if link >= 0 and leaders[link] >= 0:
                    row[coordinates.index(("angle", leaders[link]))] += sign
            rows.append(row)
        for index, (kind, of) in enumerate(coordinates):
            if kind == "slide":
                rows.append(np.eye(count)[index] / self.length)
            elif kind in ("x", "y") or (self.root in self.links and of == self.links.index(self.root)):
                rows.append(np.eye(count)[index])
        return np.array(rows)

    def project(self, q: ArrayLike, u: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """The state nearest to (q, u) on the closure, in the metric of the mass matrix (theory, section 6).

        Raises ``ValueError`` when it does not converge: assemble a configuration that is far from closed first.
        """
        states, single = self._state(q, u)
        new_q, new_u, outcomes = self.kernels.project(*states)
        for index, outcome in enumerate(outcomes):
            if outcome != "done":
                which = "the state" if single else f"state {index}"
                raise ValueError(f"{self.name}: {which} cannot be put onto the closure: {UNPROJECTED[outcome]}")
        return (new_q[0], new_u[0]) if single else (new_q, new_u)

    def _state(self, q: ArrayLike, u: ArrayLike) -> tuple[tuple[FloatArray, FloatArray], bool]:
        qs, single = self._batch(q, "q", len(self.q_names))
        us, single_u = self._batch(u, "u", len(self.u_names))
        if qs.shape[0] != us.shape[0] or single != single_u:
            raise ValueError(f"q and u must hold equally many states, found shapes {np.shape(q)} and {np.shape(u)}")
        return (qs, us), single

    def _batch(self, x: ArrayLike, what: str, width: int) -> tuple[FloatArray, bool]:
        kind = self.core.REAL
        found = np.ascontiguousarray(x, dtype=kind) if np.ndim(x) else np.array(x, dtype=kind)
        if found.ndim not in (1, 2) or found.shape[-1] != width:
            raise ValueError(f"{what}: found shape {found.shape}, expected ({width},) or (states, {width})")
        rows, single = (found[None], True) if found.ndim == 1 else (found, False)
        if not self.core.all_within(found.ravel(), largest_angle(kind)):  # seldom: then what it is
            if not self.core.all_finite(found.ravel()):
                raise ValueError(f"{what}: found {found[~np.isfinite(found)][0]}, expected finite numbers")
            if what == "q":
                check_angles(self, rows)
        return rows, single

    def set_inputs(self, inputs: Values | None) -> None:
        """Values of the inputs for calls of the kernels that follow."""
        if self.inputs or inputs is not None:
            self.kernels.set_inputs(read_values(self.inputs, inputs))

    @contextmanager
    def given(self, inputs: Values | None) -> Iterator[None]:
        """Values of the inputs for calls of the kernels inside; outside they are zero."""
        self.set_inputs(inputs)
        try:
            yield
        finally:
            self.set_inputs(None)
