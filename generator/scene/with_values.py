"""A scene whose parameters have other values, as ``--set`` gives them."""

from __future__ import annotations

from collections.abc import Mapping

from .read import read_tables
from .scene import Scene


def with_values(scene: Scene, values: Mapping[str, float]) -> Scene:
    """The scene with these ``values`` (SI units) by paths of parameters, its start assembled anew with them from what
    the scene asks of it: what its file gives with those numbers, but for what else is worked out from them, as an
    inertia from a mass.

    Values of parameters that the scene does not have are left aside. Raises ``SceneError`` where there is no such
    start, and ``ValueError`` for a scene that was changed after it was read.
    """
    return read_tables(scene.to_dict(), scene.name, scene.name, values=values)
