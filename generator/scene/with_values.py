"""A scene whose parameters have other values, as ``--set`` gives them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..mechanism.links import Parameter
from .scene import Scene


def with_values(scene: Scene, values: Mapping[str, float], poses: ArrayLike) -> Scene:
    """The scene with these ``values`` (SI units) by paths of parameters; its start has the ``poses`` (links, 3).

    Values of parameters that the scene does not have are left aside.
    """
    placed = tuple((float(x), float(y), float(angle)) for x, y, angle in np.asarray(poses))
    return replace(
        scene,
        mechanism=_changed(scene.mechanism, values),
        effects=_changed(scene.effects, values),
        start=replace(scene.start, poses=placed),
    )


def _changed(part: Any, values: Mapping[str, float]) -> Any:
    """The part of a scene with the values of all parameters within it."""
    if isinstance(part, Parameter):
        return replace(part, value=values[part.path]) if part.path in values else part
    if isinstance(part, Mapping):
        return {key: _changed(one, values) for key, one in part.items()}
    if isinstance(part, Sequence) and not isinstance(part, str):
        return tuple(_changed(one, values) for one in part)
    if is_dataclass(part) and not isinstance(part, type):
        return replace(
            part, **{one.name: _changed(getattr(part, one.name), values) for one in fields(part) if one.init}
        )
    return part
