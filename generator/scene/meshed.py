"""Meshes of a scene's effects: the mechanism that has them, and how wheels stand to each other at the start."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..effect_base.effect import Effect
from ..mechanism.layout import lay_out
from ..mechanism.links import GROUND
from ..mechanism.mechanism import Mechanism
from ..mechanism.meshes import MeshTerm
from .bodies import Bodies
from .errors import Path

Effects = Sequence[tuple[Path, Effect]]
Triple = tuple[float, float, float]


def meshed(bodies: Bodies, effects: Effects) -> Bodies:
    """The bodies with the meshes of the effects."""
    meshes = tuple(mesh for _, effect in effects if (mesh := effect.mesh()))
    return replace(bodies, mechanism=replace(bodies.mechanism, meshes=meshes)) if meshes else bodies


def as_assembled(mechanism: Mechanism, effects: Effects, poses: Sequence[Triple]) -> list[tuple[Path, Effect]]:
    """The effects, meshes as they are where links are at ``poses``."""
    if not mechanism.meshes:
        return list(effects)
    layout = lay_out(mechanism, driven=[joint for _, effect in effects for joint in effect.driven()])
    x = layout.read_off(np.array(poses, dtype=float))
    lengths = {line.joint: layout.unit * x[len(layout.base) + k] for k, line in enumerate(layout.lines)}

    def position(term: MeshTerm) -> float:
        if term.slide is not None:
            return float(lengths[term.slide])
        first, second = (0.0 if link == GROUND else poses[link][2] for link in (term.first, term.second))
        return second - first

    return [(path, effect.assembled(position)) for path, effect in effects]
