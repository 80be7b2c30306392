"""Integrals over time that effects ask for: rates of links that no scene has and nothing feels."""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray
from .compiled import Compiled


def integral_rows(model: Compiled) -> FloatArray:
    """Rows (integrals, nu) that pick the integrals from the quasi-velocities: a motion that is asked of the mechanism
    leaves them as they are."""
    integrators = model.data.get("integrators", ())
    coordinates = [(kind, of) for kind, of in model.data["coordinates"]]
    rows = np.zeros((len(integrators), len(model.u_names)))
    for row, one in zip(rows, integrators, strict=True):
        row[coordinates.index(("angle", one["link"]))] = 1.0
    return rows


def refuse_integrals(model: Compiled) -> None:
    """Raises ``ValueError`` where an effect has an integral: what it is at rest, loads and history say together."""
    integrators = model.data.get("integrators", ())
    if integrators:
        names = ", ".join(one["name"] for one in integrators)
        raise ValueError(
            f"{model.name}: found {names}, expected a model without integrals over time for an equilibrium: at rest "
            "they are whatever holds the errors at zero; write a [[drive]] in place of such a [[motor]], whose "
            "reaction is then its torque, or let a run come to rest"
        )
