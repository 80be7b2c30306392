"""Impulses of the joints behind a jump of the velocities, from the momenta of the links."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..arrays import FloatArray
from .model import Model

Terms = Sequence[Mapping[str, Any]]
"""The terms of a mesh, as a model's data has them."""


def impulses_behind(
    model: Model, meshes: Mapping[str, Terms], q: FloatArray, before: FloatArray, after: FloatArray
) -> FloatArray:
    """Impulses (joints, 3) of a model's joints, x, y (N s) and moment (N m s) at the joint, on their second links, by
    which velocities (links, 3) of its links, given as those of the frames, jump from ``before`` to ``after``.

    Newton's and Euler's laws for every link (docs/theory.md, eq. 5.27); of redundant joints those of least norm.
    ``meshes`` are the terms of gears, racks and belts, whose impulses are moments on wheels and carriers, and forces
    along lines.
    """
    poses, count = np.asarray(model.poses(q), dtype=float), len(model.links)
    change = np.zeros((count, 3))
    change[: len(before)] = after - before
    numbers = model.parameters.get
    turned = [
        _turned(poses[k, 2], np.array([numbers(f"{name}.com.x", 0.0), numbers(f"{name}.com.y", 0.0)]))
        for k, name in enumerate(model.links)
    ]
    wanted = np.zeros((count, 3))
    for k, name in enumerate(model.links):
        mass, inertia = numbers(f"{name}.mass", 0.0), numbers(f"{name}.inertia", 0.0)
        moved = change[k, :2] + change[k, 2] * np.array([-turned[k][1], turned[k][0]])
        wanted[k] = *(mass * moved), inertia * change[k, 2]
    columns, owners = [], []
    driven = {drive["joint"] for drive in model.data["drives"]}
    for number, joint in enumerate(model.joints):
        place = _place(model, joint, q, poses)
        for force in _carried(model, joint, poses, driven):
            column = np.zeros((count, 3))
            for link, sign in zip(model.data["between"][number], (-1.0, 1.0), strict=True):
                if link >= 0:
                    arm = place - (poses[link, :2] + turned[link])
                    moment = force[2] + arm[0] * force[1] - arm[1] * force[0]
                    column[link] += sign * np.array([force[0], force[1], moment])
            columns.append(column.ravel())
            owners.append((number, force))
    found = np.zeros((len(model.joints), 3))
    columns += [_of_mesh(model, terms, q, poses, turned).ravel() for terms in meshes.values()]
    if columns:
        sizes = np.linalg.lstsq(np.array(columns).T, wanted.ravel(), rcond=1e-12)[0]
        for size, (number, force) in zip(sizes, owners, strict=False):
            found[number] += size * force
    return found


def _of_mesh(
    model: Model,
    terms: Terms,
    q: FloatArray,
    poses: FloatArray,
    turned: Sequence[FloatArray],
) -> FloatArray:
    """What a mesh of size 1 N s does to the links (links, 3), about their mass centres."""
    column = np.zeros((len(model.links), 3))
    for term in terms:
        if term["slide"] is None:
            moment = term["sign"] * model.parameters[term["radius"]]
            for link, sign in zip(term["links"], (-1.0, 1.0), strict=True):
                if link >= 0:
                    column[link, 2] += sign * moment
            continue
        line = model.lines.direction(term["slide"], poses)
        place = np.asarray(model.point(term["slide"], q), dtype=float)
        for link, sign in zip(model.data["lines"][term["slide"]]["links"], (-1.0, 1.0), strict=True):
            if link >= 0:
                x, y = place - (poses[link, :2] + turned[link])
                force = sign * term["sign"] * line
                column[link] += (*force, x * force[1] - y * force[0])
    return column


def _place(model: Model, joint: str, q: FloatArray, poses: FloatArray) -> FloatArray:
    """Where the joint is; one that slides and does not turn, at its end on the later of its links."""
    line = model.data["lines"].get(joint)
    if line is None or line["angle"] is None or line["links"][1] > line["links"][0]:
        return np.asarray(model.point(joint, q), dtype=float)
    link, point = line["links"][0], np.asarray(model._coordinates(line["points"])[0], dtype=float)
    return np.asarray(poses[link, :2] + _turned(poses[link, 2], point))


def _carried(model: Model, joint: str, poses: FloatArray, driven: set[str]) -> list[FloatArray]:
    """The forces and moments (3,) of size 1 that a joint can carry."""
    along_x, along_y, moment = np.eye(3)
    lines = model.data["lines"]
    if joint not in lines:
        return [along_x, along_y, *([moment] if joint in driven else [])]
    if joint in driven:
        found = [along_x, along_y]
    else:
        line = model.lines.direction(joint, poses)
        found = [np.array([-line[1], line[0], 0.0])]
    return [*found, moment] if lines[joint]["angle"] is not None else found


def _turned(angle: float, v: FloatArray) -> FloatArray:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([c * v[0] - s * v[1], s * v[0] + c * v[1]])
