"""Where two bodies touch: on a surface, not at the centre of the disc that a contact is called after."""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray
from ..record.drawable import Drawable
from ..record.record import Record
from .frames import placed

TOUCHING = 0.02
"""Part of the extent of what is drawn by which a rim, drawn with corners, may miss the place where it is touched."""


class ContactPlaces:
    """Where the closed contacts of a model are; what does not change between configurations is found once."""

    def __init__(self, model: Drawable) -> None:
        self.model = model
        self.planes = model.ground_planes()
        self.ropes = {rope.name for rope in model.ropes}
        outlines = [(disc, disc.outline) for disc in model.discs]
        self.size = max([1e-300, *(float(np.abs(outline).max()) for _, outline in outlines)])
        self.bodies = [(disc, outline, float(np.hypot(*(outline - disc.centre).T).max())) for disc, outline in outlines]

    def at(self, contact: tuple[str, str], q: FloatArray) -> FloatArray:
        """The place (2,), in m, of a closed contact at the configuration q (nq,).

        On a ground it is the ground's nearest place; of two bodies the nearest place of the surface that the contact's
        disc or point touches. Of a stop it is the joint, of a rope its end: these touch nowhere.
        """
        name, ground = contact
        point = np.asarray(self.model.point(name, q), dtype=float)
        if ground in self.planes:
            on_plane, normal = self.planes[ground]
            return np.asarray(point - ((point - on_plane) @ normal) * normal)
        if ground in self.model.stops | self.model.slide_ends or ground in self.ropes:
            return point
        return self._on_surface(point, np.asarray(self.model.poses(q), dtype=float))

    def _on_surface(self, point: FloatArray, poses: FloatArray) -> FloatArray:
        """Of all discs and edges the nearest place of that one which a disc about the point, or the point, touches."""
        others, radii, best, found = [], {0.0}, TOUCHING * self.size, point
        for disc, outline, reach in self.bodies:
            pose = np.zeros(3) if disc.fixed else poses[disc.link]
            centre = placed(disc.centre[None], pose)[0]
            away = float(np.hypot(*(centre - point)))
            if away >= 1e-9 * self.size:
                others.append((disc, outline, pose, centre, away - reach))
            elif disc.round:
                radii.add(disc.radius)
        for disc, outline, pose, centre, least in others:
            if least > max(radii) + best:
                continue
            place = _on_rim(centre, disc.radius, point) if disc.round else _on_line(placed(outline, pose), point)
            miss = min(abs(float(np.hypot(*(place - point))) - radius) for radius in radii)
            if miss < best:
                best, found = miss, place
        return found


class StruckPlaces:
    """Where contacts were when they struck in a run, by the models that were in force then."""

    def __init__(self, run: Record) -> None:
        self.in_force = run.in_force
        self.places: dict[int, ContactPlaces] = {}

    def at(self, number: int, contact: tuple[str, str], q: FloatArray) -> FloatArray:
        """The place (2,), in m, of a contact of the impact of that ``number``, from 1 on, at its configuration."""
        model = self.in_force.at_impact(number - 1)
        return self.places.setdefault(id(model), ContactPlaces(model)).at(contact, q)


def _on_rim(centre: FloatArray, radius: float, point: FloatArray) -> FloatArray:
    """The place on a circle that is nearest to the point."""
    away = point - centre
    return np.asarray(centre + radius * away / float(np.hypot(*away)))


def _on_line(corners: FloatArray, point: FloatArray) -> FloatArray:
    """The place on a line through corners (m, 2) that is nearest to the point."""
    start, along = corners[:-1], np.diff(corners, axis=0)
    square = np.maximum(np.sum(along**2, axis=1), 1e-300)
    part = np.clip(np.sum((point - start) * along, axis=1) / square, 0.0, 1.0)
    places = start + part[:, None] * along
    return np.asarray(places[np.argmin(np.sum((places - point) ** 2, axis=1))])
