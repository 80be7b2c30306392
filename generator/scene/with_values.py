"""A scene whose parameters, or whose start, have other values, as ``--set`` gives them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from .read import read_tables
from .scene import Scene

STARTS = {
    "angles": "rad",
    "slides": "m",
    "angular_velocities": "rad/s",
    "sliding_velocities": "m/s",
    "tilt": "rad",
    "height": "m",
}
"""Keys of ``[start]`` that are one number, or one by link or joint, and what that measures."""


def start_values(scene: Scene) -> dict[str, str]:
    """The values that ``[start]`` of a scene gives, by paths as ``start.angles.crank``, and their units."""
    return {path: unit for path, unit, _, _ in _given(scene, scene.to_dict())}


def _given(scene: Scene, tables: Mapping[str, Any]) -> Iterator[tuple[str, str, Any, str | int]]:
    """Of each of these values its path, its unit, and where in ``tables`` it stands: in what, and at which key."""
    start = tables.get("start", {})
    for key, unit in STARTS.items():
        given = start.get(key)
        if isinstance(given, Mapping):
            yield from ((f"start.{key}.{name}", unit, given, name) for name in given)
        elif isinstance(given, list):  # one for each link
            links = (link.name for link in scene.mechanism.links)
            yield from (
                (f"start.{key}.{name}", unit, given, k) for k, name in zip(range(len(given)), links, strict=False)
            )
        elif given is not None:
            yield f"start.{key}", unit, start, key


def with_values(scene: Scene, values: Mapping[str, float]) -> Scene:
    """The scene with these ``values`` (SI units) by paths of parameters, and of :func:`start_values`, its start
    assembled anew with them from what the scene asks of it: what its file gives with those numbers, but for what else
    is worked out from them, as an inertia from a mass.

    Values of parameters that the scene does not have are left aside. Raises ``SceneError`` where there is no such
    start, and ``ValueError`` for a scene that was changed after it was read.
    """
    tables = scene.to_dict()
    for path, _, where, key in list(_given(scene, tables)):
        if path in values:
            where[key] = values[path]
    return read_tables(tables, scene.name, scene.name, values=values)
