"""Joints whose motion is given: where and how fast they are to be at the start, and what moves them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..arrays import FloatArray
from .assembly import nearest_closed
from .geometry import Geometry
from .tolerances import JOINT_MISS, start_miss

IMMOVABLE = 1e-9
"""Part of a contact's rate that must be free for an impulse to change it."""


def drive_columns(model: Geometry, joints: Sequence[str], what: str = "joints") -> FloatArray:
    """Generalized forces B (nu, joints) of unit torques at ``joints``, each named once; of unit forces along the lines
    of those that slide."""
    if isinstance(joints, str) or not joints or len(set(joints)) != len(joints):
        raise ValueError(f"{what}: found {joints!r}, expected a list of joints, at least one and each once")
    coordinates = [(kind, of) for kind, of in model.data["coordinates"]]
    columns = np.zeros((len(model.u_names), len(joints)))
    for column, name in enumerate(joints):
        if name not in model.joints:
            raise ValueError(f"{what}: found {name!r}, expected some of: {', '.join(model.joints)}")
        if name in model.data["lines"] and ("slide", name) in coordinates:
            columns[coordinates.index(("slide", name)), column] = 1.0
            continue
        if name in model.data["lines"]:
            raise ValueError(
                f"{what}: found {name!r}, a sliding joint whose length is no coordinate; name another joint"
            )
        for link, sign in zip(model.data["between"][model.joints.index(name)], (-1.0, 1.0), strict=True):
            leader = -1 if link < 0 else model.data["leaders"][link]
            if leader >= 0:
                columns[coordinates.index(("angle", leader)), column] += sign
    return columns


def drive_rows(model: Geometry) -> FloatArray:
    """Derivatives (drives, nu) of the driven joints' speeds by u."""
    joints = [drive["joint"] for drive in model.data["drives"]]
    return drive_columns(model, joints).T if joints else np.zeros((0, len(model.u_names)))


def drive_speeds(model: Geometry) -> FloatArray:
    """Prescribed speeds (drives,) at t = 0 in rad/s, or m/s along a line."""
    speeds = [drive["speed"] for drive in model.data["drives"]]
    return np.array([model.parameters[s] if isinstance(s, str) else s for s in speeds], dtype=float)


def drive_misses(model: Geometry, q: FloatArray) -> FloatArray:
    """How far driven joints (drives,) are from where they are to be at t = 0 (rad or m); 0 where that is open."""
    missing = []
    for drive, row in zip(model.data["drives"], drive_rows(model), strict=True):
        miss = 0.0 if drive["position"] is None else float(row @ q) - drive["position"]
        missing.append(miss if drive["slides"] else np.remainder(miss + np.pi, 2.0 * np.pi) - np.pi)
    return np.array(missing, dtype=float)


def put_where_driven(model: Geometry, q: FloatArray, u: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The nearest state in which driven joints are where they are to be at t = 0, and as fast, and loops shut."""
    if np.max(np.abs(drive_misses(model, q))) > start_miss(model.core.REAL, model.length):
        q = _nearest_driven(model, q)
    rows = np.vstack([drive_rows(model), model.jacobian(q)])
    speeds = drive_speeds(model)
    for _ in range(1 if model.precision == "double" else 3):  # solved in doubles, whatever the numbers of the model
        missing = np.append(speeds, np.zeros(len(model.rows))) - rows @ u
        u = u + np.linalg.lstsq(np.asarray(rows, dtype=float), np.asarray(missing, dtype=float), rcond=1e-12)[0]
    return q, u


def rate_rows(model: Geometry, kernel: str, q: FloatArray) -> FloatArray:
    """The rows (contacts, nu) of rates that are linear in u: of ``"gap_rates"`` or ``"slips"``."""
    units = np.eye(len(model.u_names), dtype=model.core.REAL)
    return np.asarray(model.kernels.of_state(kernel, np.tile(q, (len(units), 1)), units).T, dtype=float)


def driven_against(model: Geometry, q: FloatArray, u: FloatArray) -> tuple[str, str] | None:
    """A contact that closes although drives and loops alone give its motion, so that no impulse can change it."""
    if not model.data["drives"] or not model.contacts:
        return None
    given = np.asarray(np.vstack([drive_rows(model), model.jacobian(q) / model.length]), dtype=float)
    rows = rate_rows(model, "gap_rates", q)
    touching = (model.gaps(q) <= JOINT_MISS * model.length) & (model.gap_rates(q, u) < 0.0)
    for contact, row in zip(np.flatnonzero(touching), rows[touching], strict=True):
        left = row - given.T @ np.linalg.lstsq(given.T, row, rcond=1e-12)[0]
        if np.linalg.norm(left) <= IMMOVABLE * np.linalg.norm(row):
            return model.contacts[int(contact)]
    return None


def _nearest_driven(model: Geometry, q: FloatArray) -> FloatArray:
    """The nearest configuration that is closed and has driven joints where they are to be at t = 0."""
    free = np.array([drive["position"] is None for drive in model.data["drives"]])
    rows = np.where(free[:, None], 0.0, drive_rows(model)) * model.length

    def misses(x: FloatArray) -> FloatArray:
        return np.append(model.closure(x), drive_misses(model, x) * model.length)

    return nearest_closed(misses, lambda x: np.vstack([model.jacobian(x), rows]), model.displacements(), q)
