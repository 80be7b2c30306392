"""Meshes of a scene's effects: the mechanism that has them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from ..effect_base.effect import Effect
from .bodies import Bodies
from .errors import Path

Effects = Sequence[tuple[Path, Effect]]


def meshed(bodies: Bodies, effects: Effects) -> Bodies:
    """The bodies with the meshes of the effects."""
    meshes = tuple(mesh for _, effect in effects if (mesh := effect.mesh()))
    return replace(bodies, mechanism=replace(bodies.mechanism, meshes=meshes)) if meshes else bodies
