"""Where links, points and contacts are and how fast they move, and the energy of it."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import FloatArray
from .compiled import Compiled
from .lines import Lines
from .mass_centres import NAME, mass_centre
from .numbers import read_name


class Geometry(Compiled):
    """A compiled model whose states can be looked at."""

    def poses(self, q: ArrayLike) -> FloatArray:
        """Per link x, y (m) and angle (rad) of its frame, (links, 3)."""
        return self._of_q("poses", q, (len(self.links), 3))

    def velocities(self, q: ArrayLike, u: ArrayLike) -> FloatArray:
        """Per link the velocity of its frame's origin (m/s) and its angular velocity (rad/s), (links, 3)."""
        states, single = self._state(q, u)
        found = self.kernels.of_state("velocities", *states).reshape(len(states[0]), len(self.links), 3)
        return found[0] if single else found

    def point(self, name: str, q: ArrayLike) -> FloatArray:
        """Position (2,) in m of a joint (``joint_3``), of a point of a link, welded or the ground (``link_0.A``), or of
        a link's mass centre (``link_0.com``), unless a point of the link has that name."""
        name = read_name(name, "name", "a joint or of a point")
        name = self.data["welded_points"].get(name, name)
        link, _, point = name.partition(".")
        if link == "ground" and point in self.data["ground_names"]:
            place = self.ground_points[self.data["ground_names"].index(point)]
            return np.array(np.broadcast_to(place, (*np.shape(q)[:-1], 2)))
        if name not in self.points and point == NAME and (centre := mass_centre(self, link)):
            poses = self.poses(q)[..., centre.link, :]
            cos, sin = np.cos(poses[..., 2]), np.sin(poses[..., 2])
            arm = (cos * centre.x - sin * centre.y, sin * centre.x + cos * centre.y)
            return np.ascontiguousarray(poses[..., :2] + np.stack(arm, axis=-1), dtype=self.core.REAL)
        if name not in self.points:
            raise ValueError(f"name: found point {name!r}, expected one of: {', '.join(self.points)}")
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
        """Gap of every contact (contacts,), positive outside: from a ground in m, from a stop in rad; infinite of one
        whose effect is off."""
        found = self._of_q("gaps", q, (len(self.contacts),))
        found[..., [self.contacts.index(contact) for contact in self.off_contacts]] = np.inf
        return found

    def gap_rates(self, q: ArrayLike, u: ArrayLike) -> FloatArray:
        """Rates of the gaps (contacts,) in m/s, of stops in rad/s."""
        states, single = self._state(q, u)
        found = self.kernels.of_state("gap_rates", *states)
        return found[0] if single else found

    @property
    def lines(self) -> Lines:
        """The lines of the sliding joints."""
        return Lines(self.data, self._coordinates)

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

    def energy(self, q: ArrayLike, u: ArrayLike) -> tuple[Any, Any]:
        """Kinetic and potential energy (J); the potential is zero at y = 0."""
        states, single = self._state(q, u)
        found = self.kernels.of_state("energy", *states)
        return (found[0, 0].item(), found[0, 1].item()) if single else (found[:, 0].copy(), found[:, 1].copy())
