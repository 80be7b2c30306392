"""A mechanism whose joints let go and take hold, seen as one model through all that it becomes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any

import numpy as np

from ..arrays import FloatArray
from .disc import Disc
from .joint_gap import Ends
from .meshes import BEHIND, mesh_forces, mesh_names
from .model import Model
from .part import Part
from .poses import read_off, read_rates
from .rope import Rope


class Whole:
    """All structures of a mechanism, in the coordinates of the ``loosest``, in which all joints that change are open.

    ``structures`` are their models, the one at the start first. It can be recorded and drawn as a model can; what hangs
    on which joints hold is asked of a run.
    """

    def __init__(self, structures: Sequence[Model]) -> None:
        self.structures = tuple(structures)
        self.main = self.structures[0]
        self.data: Mapping[str, Any] = self.main.data
        said = self.data["switching"]
        self.opened: tuple[frozenset[str], ...] = tuple(frozenset(one["open"]) for one in said["structures"])
        self._aids: tuple[tuple[str, ...], ...] = tuple(tuple(one["aids"]) for one in said["structures"])
        self._loosest = max(range(len(self.opened)), key=lambda k: len(self.opened[k]))
        self.loosest = self.structures[self._loosest]
        self.name: str = self.main.name
        self.links: tuple[str, ...] = tuple(said["links"])
        self.joints: tuple[str, ...] = tuple(said["joints"])
        self.q_names, self.u_names = self.loosest.q_names, self.loosest.u_names
        self.q_of = self.loosest.q_of
        self.rows = tuple(dict.fromkeys(f"{mesh}{BEHIND}" for one in self.structures for mesh in mesh_names(one)))
        self.meshes: Mapping[str, Sequence[Mapping[str, Any]]] = said.get("meshes", {})
        self.contacts = tuple(dict.fromkeys(one for model in self.structures for one in model.contacts))
        self.told = tuple(dict.fromkeys(tuple(one) for model in self.structures for one in model.told))
        self.told_links = {name: link for model in self.structures for name, link in model.told_links.items()}
        self.stops = frozenset(stop for model in self.structures for stop in model.stops)
        self.slide_ends = frozenset(end for model in self.structures for end in model.slide_ends)
        self.parameters: Mapping[str, float] = dict(self.main.parameters)
        self.core, self.kernels, self.length = self.main.core, self.loosest.kernels, self.main.length
        self.time, self.duration, self.precision = self.main.time, self.main.duration, self.main.precision

    def __reduce__(self) -> tuple[type[Whole], tuple[tuple[Model, ...]]]:
        return Whole, (self.structures,)

    @cached_property
    def ends(self) -> dict[str, Ends]:
        """The ends of the joints that change."""
        return {name: Ends.of(self.main, said) for name, said in self.data["switching"]["ends"].items()}

    @cached_property
    def second_links(self) -> tuple[str, ...]:
        """The second link of each joint, on which its force is."""
        return tuple(
            next(model.second_links[model.joints.index(joint)] for model in self.structures if joint in model.joints)
            for joint in self.joints
        )

    @property
    def outboard(self) -> tuple[str, ...]:
        """``second_links``, by their name of before."""
        return self.second_links

    # -- from one structure to another --------------------------------------------------------------------------------

    def links_of(self, structure: int, q: FloatArray, u: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Poses and velocities (..., links, 3) of the scene's links in a structure's states."""
        model, count = self.structures[structure], len(self.links)
        return model.poses(q)[..., :count, :], model.velocities(q, u)[..., :count, :]

    def state_in(self, structure: int, poses: FloatArray, velocities: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The state (q, u) of a structure whose links are at ``poses`` (links, 3) and move with ``velocities``; of many
        (b, links, 3) those (b, n). Nothing is put onto its closure."""
        if poses.ndim == 3:
            states = [self.state_in(structure, *one) for one in zip(poses, velocities, strict=True)]
            return np.array([q for q, _ in states]), np.array([u for _, u in states])
        model = self.structures[structure]
        lines = model.data["lines"]
        for up in self._aids[structure][1::2]:
            point = model._coordinates([lines[up]["points"][1]])
            body = Ends("revolute", (-1, lines[up]["links"][1]), np.vstack([np.zeros((1, 2)), point]))
            place, speed = body.apart(poses, velocities)
            poses = np.vstack([poses, [[place[0], 0.0, 0.0]]])
            velocities = np.vstack([velocities, [[speed[0], 0.0, 0.0]]])
        return read_off(model, poses), read_rates(model, poses, velocities)

    def latched_in(self, structure: int, before: int, latched: FloatArray) -> FloatArray:
        """What effects hold (latches,) in the structure ``before`` as what those of a ``structure`` hold; not a number
        where they have held nothing."""
        return latched_as(self.structures[structure], self.structures[before], latched)

    def lifted(self, structure: int, q: FloatArray, u: FloatArray) -> tuple[FloatArray, FloatArray]:
        """A structure's states (..., n) in the coordinates of the loosest."""
        if structure == self._loosest:
            return q, u
        return self.state_in(self._loosest, *self.links_of(structure, q, u))

    def lifted_accelerations(self, structure: int, q: FloatArray, u: FloatArray, u_dot: FloatArray) -> FloatArray:
        """Quasi-accelerations (b, n) of a structure at its states, in the coordinates of the loosest.

        They are those by which a point of each link, and the link's angle, accelerate alike.
        """
        if structure == self._loosest or not len(q):
            return u_dot
        model, loosest = self.structures[structure], self.loosest
        q_all, u_all = self.lifted(structure, q, u)
        still = np.zeros_like(u_all)
        rows, wanted = [], []
        for number, link in enumerate(self.links):
            point = next(name for name in loosest.points if name.startswith(f"{link}."))
            rows.append(loosest.point_jacobian(point, q_all))
            moved = model.point_acceleration(point, q, u, u_dot=u_dot)
            wanted.append(moved - loosest.point_acceleration(point, q_all, u_all, u_dot=still))
            rows.append(_spin(loosest, number, len(q)))
            wanted.append(np.einsum("bij,bj->bi", _spin(model, number, len(q)), u_dot))
        A, b = np.concatenate(rows, axis=1), np.concatenate(wanted, axis=1)
        known = np.isfinite(b).all(axis=1)
        found = np.full_like(u_all, np.nan)
        found[known] = [_least(one, other) for one, other in zip(A[known], b[known], strict=True)]
        return found

    def reactions_of(self, structure: int, reactions: FloatArray) -> FloatArray:
        """Reactions (..., joints, 3) of a structure's model as those of all joints; zero of those that are open."""
        model = self.structures[structure]
        found = np.zeros((*reactions.shape[:-2], len(self.joints), 3), dtype=reactions.dtype)
        for k, joint in enumerate(self.joints):
            if joint in model.joints:
                found[..., k, :] = reactions[..., model.joints.index(joint), :]
        return found

    def meshes_of(self, structure: int, multipliers: FloatArray) -> FloatArray:
        """Of multipliers (..., rows) of a structure's model those of the meshes, the only rows that all structures
        have."""
        model = self.structures[structure]
        found = np.zeros((*multipliers.shape[:-1], len(self.rows)), dtype=multipliers.dtype)
        own = [self.rows.index(f"{mesh}{BEHIND}") for mesh in mesh_names(model)]
        found[..., own] = mesh_forces(model, multipliers)
        return found

    def pushes_of(self, structure: int, pushes: FloatArray) -> FloatArray:
        """Forces (..., contacts, 2) of a structure's contacts as those of all contacts."""
        model = self.structures[structure]
        found = np.zeros((*pushes.shape[:-2], len(self.contacts), 2), dtype=pushes.dtype)
        for own, contact in enumerate(model.contacts):
            found[..., self.contacts.index(contact), :] = pushes[..., own, :]
        return found

    def told_of(self, structure: int, told: FloatArray) -> FloatArray:
        """What effects tell (..., told) in a structure as that of all of them; zero of those that only others have."""
        found = np.zeros((*told.shape[:-1], len(self.told)), dtype=told.dtype)
        for own, one in enumerate(self.structures[structure].told):
            found[..., self.told.index(one)] = told[..., own]
        return found

    def name_in(self, model: Model, point: str) -> str:
        """A point by a name that a structure's model knows: an open joint is where its first moving end is."""
        if point in model.joints or point not in self.ends:
            return point
        first, second = self.data["switching"]["ends"][point]["names"]
        return str(second if self.ends[point].links[0] < 0 or self.ends[point].kind != "revolute" else first)

    def ends_of(self, joint: str) -> Ends:
        """The ends of any joint of the scene that slides or changes."""
        if joint in self.ends:
            return self.ends[joint]
        line = self.data["lines"][joint]
        numbers = self.main._coordinates([[line["axis"], line["angle"] or 0.0]])[0]
        first, second = line["links"]
        points = self.main._coordinates(line["points"])
        return Ends("pin-in-slot" if line["angle"] is None else "prismatic", (first, second), points, *numbers.tolist())

    def between(self, joint: str) -> tuple[int, int]:
        """The two links of a joint; -1: the ground."""
        if joint in self.ends:
            return self.ends[joint].links
        first, second = self.data["between"][self.main.joints.index(joint)]
        return first, second

    # -- as it is drawn -----------------------------------------------------------------------------------------------

    @property
    def points(self) -> tuple[str, ...]:
        """Names of all joints, and of the links' points."""
        return (*self.joints, *(name for name in self.loosest.points if "." in name))

    @property
    def outlines(self) -> tuple[FloatArray, ...]:
        return self.main.outlines[: len(self.links)]

    @property
    def discs(self) -> tuple[Disc, ...]:
        return self.main.discs

    @property
    def ropes(self) -> tuple[Rope, ...]:
        return self.main.ropes

    @property
    def parts(self) -> tuple[Part, ...]:
        return self.main.parts

    @property
    def off(self) -> tuple[str, ...]:
        """As those of the model of each structure."""
        return self.main.off

    @property
    def off_contacts(self) -> tuple[tuple[str, str], ...]:
        return tuple(dict.fromkeys(contact for one in self.structures for contact in one.off_contacts))

    @property
    def drawn_joints(self) -> tuple[str, ...]:
        return self.joints

    @property
    def drawn_ground_points(self) -> FloatArray:
        return self.main.drawn_ground_points

    def ground_planes(self) -> dict[str, tuple[FloatArray, FloatArray]]:
        return self.main.ground_planes()

    def poses(self, q: FloatArray) -> FloatArray:
        return self.loosest.poses(q)[..., : len(self.links), :]

    def velocities(self, q: FloatArray, u: FloatArray) -> FloatArray:
        return self.loosest.velocities(q, u)[..., : len(self.links), :]

    def point(self, name: str, q: FloatArray) -> FloatArray:
        return self.loosest.point(self.name_in(self.loosest, name), q)

    def point_velocity(self, name: str, q: FloatArray, u: FloatArray) -> FloatArray:
        return self.loosest.point_velocity(self.name_in(self.loosest, name), q, u)

    def point_acceleration(self, name: str, q: FloatArray, u: FloatArray, *, u_dot: FloatArray) -> FloatArray:
        return self.loosest.point_acceleration(self.name_in(self.loosest, name), q, u, u_dot=u_dot)

    def joint_angles(self, q: FloatArray) -> dict[str, FloatArray]:
        angles = self.poses(q)[..., 2]
        found = {}
        for joint in self.joints:
            line = self.data["lines"].get(joint)
            kind = self.ends[joint].kind if joint in self.ends else "prismatic" if line and line["angle"] else ""
            if kind == "prismatic" or (line and line["angle"] is not None):
                continue
            first, second = (0.0 * angles[..., 0] if link < 0 else angles[..., link] for link in self.between(joint))
            found[joint] = np.asarray(second - first)
        return found

    def slides(self, q: FloatArray) -> dict[str, FloatArray]:
        poses = self.poses(q)
        sliding = [
            j for j in self.joints if j in self.data["lines"] or (j in self.ends and self.ends[j].kind != "revolute")
        ]
        return {joint: self.ends_of(joint).along(poses, np.zeros_like(poses))[0] for joint in sliding}

    def gaps(self, q: FloatArray) -> FloatArray:
        """Gaps of all contacts (..., contacts); not a number of those that only other structures have."""
        own = self.loosest.gaps(q)
        found = np.full((*own.shape[:-1], len(self.contacts)), np.nan, dtype=own.dtype)
        found[..., [self.contacts.index(one) for one in self.loosest.contacts]] = own
        return found

    def gap_rates(self, q: FloatArray, u: FloatArray) -> FloatArray:
        """Rates of the ``gaps``, likewise."""
        own = self.loosest.gap_rates(q, u)
        found = np.full((*own.shape[:-1], len(self.contacts)), np.nan, dtype=own.dtype)
        found[..., [self.contacts.index(one) for one in self.loosest.contacts]] = own
        return found

    def closing_speed(self, joint: str, q: FloatArray, u: FloatArray) -> float:
        """How fast (m/s) what a joint that changes is to hold moves against it."""
        return float(np.linalg.norm(self.ends[joint].misses(self.poses(q), self.velocities(q, u), self.length)[1]))

    def energy(self, q: FloatArray, u: FloatArray) -> tuple[Any, Any]:
        return self.loosest.energy(q, u)

    def closure(self, q: FloatArray) -> FloatArray:
        return self.loosest.closure(q)


def _least(A: FloatArray, b: FloatArray) -> FloatArray:
    """The least-squares solution of A x = b; NumPy has it in doubles, and what is missing in other numbers is added."""
    rows = np.asarray(A, dtype=float)
    found = np.zeros(A.shape[1], dtype=b.dtype)
    for _ in range(1 if b.dtype == float else 3):
        found += np.linalg.lstsq(rows, np.asarray(b - A @ found, dtype=float), rcond=None)[0]
    return found


def latched_as(model: Model, before: Model, latched: FloatArray) -> FloatArray:
    """What effects of the model ``before`` hold (latches,) as what those of another ``model`` of the same scene hold;
    not a number where it has none of the name."""
    values = dict(zip(before.data.get("latches", []), latched, strict=True))
    return np.array([values.get(name, np.nan) for name in model.data.get("latches", [])])


def _spin(model: Model, link: int, count: int) -> FloatArray:
    """The row (count, 1, nu) by which a link's angular velocity follows from u."""
    row = np.zeros((count, 1, len(model.u_names)))
    leader = model.data["leaders"][link]
    if leader >= 0:
        coordinates = [(kind, of) for kind, of in model.data["coordinates"]]
        row[:, 0, coordinates.index(("angle", leader))] = 1.0
    return row
