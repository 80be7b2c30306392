"""A generated model as its user has it in hand: what it can be asked, each in one line."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import FloatArray
from ..files import read_path, write_whole
from .assembly import assemble, project
from .c_header import c_header, check_beside
from .derivatives import derivatives
from .directions import Wrt
from .dynamics import at_states, impact
from .forces import Contacts
from .geometry import Geometry
from .inputs import Values
from .joint_motion import joint_angles, joint_rates, slide_rates
from .masses import mass_matrix, motions
from .points import point_acceleration, point_jacobian, point_velocity
from .poses import read_states
from .start import Begin, begun, degrees_of_freedom, start


class Model(Geometry):
    """A mechanism's equations of motion in flight and impact, compiled.

    States are ``q`` (nq,) and ``u`` (nu,), or batches (b, nq) and (b, nu); results then have a leading axis b too. SI
    units, y up, angles counter-clockwise in radians. Wrong shapes, numbers that are not finite, and angles so large
    that their digits are gone raise ``ValueError``.
    """

    def __init__(
        self,
        descriptor: object,
        data: Mapping[str, Any],
        values: Mapping[str, float] | None = None,
        folder: Path | None = None,
        begin: Begin | None = None,
    ) -> None:
        self._copy: tuple[Model | None, tuple[int, int]] = None, (0, 0)
        self._start: tuple[int, FloatArray, FloatArray] | None = None
        self._begin = begin
        super().__init__(descriptor, data if begin is None else begun(data, begin), values, folder)

    def __repr__(self) -> str:
        counts = ((len(self.links), "link"), (len(self.joints), "joint"), (self.dof, "degree"))
        links, joints, degrees = (f"{count} {word}{'s' * (count != 1)}" for count, word in counts)
        return f"<Model {self.name}: {links}, {joints}, {degrees} of freedom>"

    # -- copies ----------------------------------------------------------------------------------------------------

    def __copy__(self) -> Model:
        return self.with_parameters(None)

    def __deepcopy__(self, memo: object) -> Model:
        return self.with_parameters(None)

    def as_it_is(self) -> Model:
        """A model with the values of now, which stays as it is when this one's change; the same one until they do."""
        copy, changes = self._copy
        if copy is None or changes != (self._changes, copy._changes):
            copy = self.with_parameters(None)
            self._copy = copy, (self._changes, copy._changes)
        return copy

    def as_nobody_changes_it(self) -> Model:
        """This model, of whose values nobody is told who could change them: :meth:`as_it_is` gives it and no copy."""
        self._copy = self, (self._changes, self._changes)
        return self

    def with_parameters(self, values: Mapping[str, float] | None) -> Model:
        """A model of its own with other parameter values; this one stays as it is."""
        every = self._parameters if values is None else {**self._parameters, **self._parameters.checked(values)}
        other = Model(self._descriptor, self.data, every, self.folder, self._begin)
        other.pieces_of_time = self.pieces_of_time  # no parameter changes how fast loads change
        return other

    def with_start(self, poses: ArrayLike, velocities: ArrayLike) -> Model:
        """A model of its own that starts with its links at ``poses`` (links, 3) moving with ``velocities`` (links, 3),
        instead of where the scene starts; this one stays as it is.

        Raises ``ValueError`` as ``state_from_poses`` does.
        """
        read_states(self, poses, velocities)
        rows = [tuple(map(tuple, np.asarray(of, dtype=float).tolist())) for of in (poses, velocities)]
        begin = Begin(rows[0], rows[1], tuple(self._parameters.values()))
        return Model(self._descriptor, self.data, self._parameters, self.folder, begin)

    @property
    def dof(self) -> int:
        """Degrees of freedom at the scene's start: quasi-velocities less the rank of the closure and driven joints."""
        return degrees_of_freedom(self)

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
        return at_states(self, q, u, t, inputs, contacts, "u_dot")

    def multipliers(
        self, q: ArrayLike, u: ArrayLike, t: ArrayLike = 0.0, inputs: Values | None = None, contacts: Contacts = None
    ) -> FloatArray:
        """Closure multipliers (rows,): force on the second side of each cut joint, in the rows' directions, N.

        With what contacts push, as in ``acceleration``.
        """
        return at_states(self, q, u, t, inputs, contacts, "multipliers")

    def reactions(
        self, q: ArrayLike, u: ArrayLike, t: ArrayLike = 0.0, inputs: Values | None = None, contacts: Contacts = None
    ) -> FloatArray:
        """Per joint the force x, y (N) and the moment (N m) on its second link ``second_links[joint]``, (joints, 3).

        With what contacts push, as in ``acceleration``; those of a run: ``run.reactions``.
        """
        return at_states(self, q, u, t, inputs, contacts, "reactions")

    def contact_forces(
        self, q: ArrayLike, u: ArrayLike, t: ArrayLike = 0.0, inputs: Values | None = None, contacts: Contacts = None
    ) -> FloatArray:
        """Force of each of ``contacts`` along its normal and along the ground, (contacts, 2), in N; zero where apart.

        It acts on the link of the contact's point; a link that this touches has the opposite. Along the ground is the
        normal turned clockwise: the direction of forward sliding. Of a stop the moment (N m) is in the first. As in
        ``acceleration``; forces that are not unique, as under a table with four legs, are those of least norm. Those of
        a run: ``run.contact_forces``.
        """
        return at_states(self, q, u, t, inputs, contacts, "pushes")

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
        return impact(self, q, u, contacts, restitution)

    def acceleration_jacobian(
        self,
        q: ArrayLike,
        u: ArrayLike,
        t: ArrayLike = 0.0,
        inputs: Values | None = None,
        wrt: Wrt = ("q", "u"),
        contacts: Contacts = None,
    ) -> FloatArray:
        """Derivatives (nu, columns) of the quasi-accelerations in flight: ``derivatives("acceleration", …)``."""
        return derivatives(self, "acceleration", q, u, t, inputs, wrt, contacts)

    def derivatives(
        self,
        of: str,
        q: ArrayLike,
        u: ArrayLike,
        t: ArrayLike = 0.0,
        inputs: Values | None = None,
        wrt: Wrt = ("q", "u"),
        contacts: Contacts = None,
    ) -> FloatArray:
        """Derivatives of a function of the state, exact to rounding (theory, section 11): its shape, then (columns,).

        ``of`` is "acceleration" (nu,), "multipliers" (rows,), "reactions" (joints, 3), "closure" and "closure_rate"
        (rows,), "gaps" and "gap_rates" (contacts,), "poses" and "velocities" (links, 3), "points" (points, 2), joints
        first, "energy" (2,), kinetic and potential, "power" () or "outputs" (told,). ``wrt`` are names, each with a
        column for every entry: "q", "u", "t", "inputs", an input, a parameter by its path; or a mapping of names to
        directions (entries, columns), along which it is derived, those of all names together. Units are those of the
        function per unit of what it is derived by. States may be a batch, as in ``acceleration``.

        Only a model generated with ``derivatives=True`` has them; ``ValueError`` says so of others. Accelerations and
        what follows from them are those of flight, whatever contacts are closed with ``contacts=()``; without it a
        closed contact raises. ``ValueError`` too in singular configurations, where joints are redundant and a direction
        opens their loops, or forces are asked for, and where a derivative is not finite. At a kink it is that of the
        side on which the state counts: where an effect's switching function is not positive, below zero of an absolute
        value. What effects hold is held.
        """
        return derivatives(self, of, q, u, t, inputs, wrt, contacts)

    # -- kinematics ------------------------------------------------------------------------------------------------

    def point_jacobian(self, name: str, q: ArrayLike) -> FloatArray:
        """Derivatives (2, nu) by u of the velocity of a joint or a named point, as ``point`` knows them."""
        return point_jacobian(self, name, q)

    def point_velocity(self, name: str, q: ArrayLike, u: ArrayLike) -> FloatArray:
        """Velocity (2,) in m/s of a joint or a named point, as ``point`` knows them."""
        return point_velocity(self, name, q, u)

    def point_acceleration(
        self,
        name: str,
        q: ArrayLike,
        u: ArrayLike,
        t: ArrayLike = 0.0,
        inputs: Values | None = None,
        contacts: Contacts = None,
        *,
        u_dot: ArrayLike | None = None,
    ) -> FloatArray:
        """Acceleration (2,) in m/s² of a joint or a named point (theory, eq. 2.4 and 2.6), that of the mechanism being
        as in ``acceleration``, or ``u_dot`` (nu,) where it is given. Those along a run: ``run.point``.
        """
        if u_dot is None:
            u_dot = at_states(self, q, u, t, inputs, contacts, "u_dot")
        elif inputs is not None or contacts is not None:
            raise ValueError("u_dot: found beside inputs or contacts, expected alone: accelerations are given by it")
        return point_acceleration(self, name, q, u, u_dot)

    def joint_angles(self, q: ArrayLike) -> dict[str, FloatArray]:
        """Per joint that turns the angle of its second link against its first (rad), turns counted; as ``slides``."""
        return joint_angles(self, q)

    def joint_rates(self, q: ArrayLike, u: ArrayLike) -> dict[str, FloatArray]:
        """Rates (rad/s) of the ``joint_angles``."""
        return joint_rates(self, q, u)

    def slide_rates(self, q: ArrayLike, u: ArrayLike) -> dict[str, FloatArray]:
        """Rates (m/s) of the ``slides``."""
        return slide_rates(self, q, u)

    def mass_matrix(self, q: ArrayLike) -> FloatArray:
        """Mass matrix M (nu, nu) of the open chain in u: the kinetic energy is uᵀ M u / 2 (theory, eq. 7.2)."""
        return mass_matrix(self, q)

    def motions(self, q: ArrayLike) -> FloatArray:
        """The motions (nu, dof) at one configuration that keep loops shut and driven joints still: columns Z with
        Zᵀ M Z = 1, more of them where closure rows depend on each other (theory, section 8).

        Column k has a coordinate of its own, at which it is positive and all later columns are zero: it is the motion
        that an impulse there gives while the coordinates of the columns before stand still, with half a joule of
        kinetic energy. Coordinates are taken by how easily they move, of like ones the first.
        """
        return motions(self, q)

    # -- programs in C ---------------------------------------------------------------------------------------------

    def write_header(self, path: str | os.PathLike[str]) -> Path:
        """Write the parameters as they are now, the start and the settings of a simulation as a header for C.

        It names the model by its package, as ``falling_hexagon_q``; ``docs/c.md`` has a program. Raises ``ValueError``
        for a model in other numbers than doubles, and for a place in its package: that is for ccgen's own files alone.
        """
        target, text = read_path(path, "a header"), c_header(self)
        check_beside(target, self.folder)
        write_whole(target, lambda part: part.write(text.encode()))
        return target

    # -- states ----------------------------------------------------------------------------------------------------

    def start(self) -> tuple[FloatArray, FloatArray]:
        """The scene's start (q, u); where parameters have changed since, the nearest that is closed and driven,
        with the angles, lengths and speeds that the scene gives, where the loops leave them free."""
        if self._start is None or self._start[0] != self._changes:
            self._start = self._changes, *start(self)
        _, q, u = self._start
        return q.copy(), u.copy()

    def state_from_poses(self, poses: ArrayLike, velocities: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """State (q, u) of links at ``poses`` (links, 3) moving with ``velocities`` (links, 3), or of a batch of them.

        Nothing is projected.

        Raises ``ValueError`` when joints miss by more than 1e-6 of the mechanism's length, or their
        velocities by more than that per second.
        """
        return read_states(self, poses, velocities)

    def assemble(self, q: ArrayLike) -> FloatArray:
        """The consistent configuration nearest to ``q`` in joint displacements (least squares), loops shut to rounding.

        Raises ``ValueError`` when the loops cannot be closed from there, with the miss that remains.
        """
        return assemble(self, q)

    def project(self, q: ArrayLike, u: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """The state nearest to (q, u) on the closure, in the metric of the mass matrix (theory, section 6).

        Raises ``ValueError`` when it does not converge: assemble a configuration that is far from closed first.
        """
        return project(self, q, u)


def check_model(given: object) -> None:
    """Raise ``TypeError`` unless the argument ``model`` is one."""
    if not isinstance(given, Model):
        raise TypeError(f"model: found {type(given).__name__}, expected a Model; load one with load_model(folder)")


def with_params(model: Model, params: Mapping[str, float] | None) -> Model:
    """The model with the values of the argument ``params``, or as it is now. Raises ``TypeError`` where they are no
    mapping, and as ``with_parameters`` does."""
    if params is None:
        return model.as_it_is()
    if not isinstance(params, Mapping):
        raise TypeError(f"params: found {type(params).__name__}, expected a mapping of parameter names to values")
    return model.with_parameters(params)
