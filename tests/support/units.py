"""The same mechanism in other units: parameters, start and times in numbers that are so many times as large."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any

import numpy as np

from ccgen.runtime import Model, Run, simulate
from ccgen.runtime.arrays import FloatArray

DIMENSIONS = {
    r"mass": (1, 0, 0),
    r"inertia": (1, 2, 0),
    r"gravity\.g": (0, 1, -2),
    r"spring_\d+\.stiffness": (1, 0, -2),
    r"(damper|spring)_\d+\.damping": (1, 0, -1),
    r"torsion_\d+\.stiffness": (1, 2, -2),
    r"torsion_\d+\.damping": (1, 2, -1),
    r"(motor|torque)_\d+\.torque": (1, 2, -2),
    r"(normal|direction)\.[xy]|restitution|friction|lowest|highest": (0, 0, 0),
    r"length|radius|com\.[xy]|points\.\w+\.[xy]|point\.[xy]": (0, 1, 0),
}
"""Exponents of mass, length and time of the parameters whose path ends so."""


@dataclass(frozen=True)
class Units:
    """How many new units of mass, length and time are one old unit."""

    mass: float
    length: float
    time: float

    def factor(self, dimension: tuple[int, int, int]) -> float:
        return float(self.mass ** dimension[0] * self.length ** dimension[1] * self.time ** dimension[2])

    def parameters(self, model: Model) -> dict[str, float]:
        """The model's parameters in the new units."""
        return {path: value * self.factor(_dimension(path)) for path, value in model.parameters.items()}

    def coordinates(self, model: Model) -> FloatArray:
        """By what coordinates are multiplied, (nq,)."""
        return np.array([1.0 if kind == "angle" else self.length for kind, _ in model.data["coordinates"]])

    def model(self, model: Model) -> Model:
        """The model in the new units, its scene's duration too."""
        run: dict[str, Any] = {**model.data["run"], "until": model.data["run"]["until"] * self.time}
        return Model(model._descriptor, {**model.data, "run": run}).with_parameters(self.parameters(model))

    def run(self, model: Model, q: FloatArray, u: FloatArray, until: float, **options: Any) -> Run:
        """The run from a start and to an end in old units, in new ones."""
        by = self.coordinates(model)
        return simulate(self.model(model), q * by, u * by / self.time, until=until * self.time, **options)


def _dimension(path: str) -> tuple[int, int, int]:
    for end, dimension in DIMENSIONS.items():
        if re.search(rf"(^|\.|_)({end})$", path):
            return dimension
    raise KeyError(path)
