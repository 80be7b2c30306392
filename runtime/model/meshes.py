"""Forces of gears, racks and belts: multipliers of closure rows, which are the last ones."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Protocol

import numpy as np

from ..arrays import FloatArray

BEHIND = ".mesh"
"""Behind the name of a mesh in that of its closure row."""


class Rows(Protocol):
    """What is asked of a model here."""

    @property
    def rows(self) -> Sequence[str]: ...
    @property
    def parameters(self) -> Mapping[str, float]: ...


def mesh_names(model: Rows) -> tuple[str, ...]:
    """Names of the meshes, in the order of their rows."""
    return tuple(row.removesuffix(BEHIND) for row in model.rows if row.endswith(BEHIND))


def mesh_forces(model: Rows, multipliers: FloatArray) -> FloatArray:
    """Of multipliers (…, rows) those of the meshes (…, meshes): the tangential force (N) at the pitch point that turns
    the first wheel counter-clockwise against its carrier, where it is positive."""
    return multipliers[..., len(model.rows) - len(mesh_names(model)) :]


def mesh_torques(model: Rows, forces: FloatArray) -> FloatArray:
    """Torques (…, meshes) of such ``forces`` on the first wheels, against their carriers (N m)."""
    radii = [model.parameters[f"{name}.radius_1"] for name in mesh_names(model)]
    return np.asarray(forces * np.array(radii, dtype=float))
