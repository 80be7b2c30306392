"""What the parameters of a scene measure, told by the tables that they come from."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, get_args

from pydantic.fields import FieldInfo

from ..effect_base.expression_of_time import InTime
from ..effect_base.table import Table, kind_of_key
from ..effect_base.written_numbers import Measured
from .bodies import GROUND_NAME
from .kinds import MODELS, SHORTHAND
from .scene import Scene
from .schema import GroundLinkTable, JointTable, LinkTable


def units_of(scene: Scene, path: str) -> tuple[str, ...]:
    """The units one of which a parameter has, as ``kg`` for ``crank.mass``; none where its table has no such key."""
    if unit := next((one.unit for one in scene.parameters() if one.path == path), ""):
        return (unit,)
    owner, _, below = path.partition(".")
    key = below.partition(".")[0]
    kinds = (kind_of_key(model, key) for model in _models(scene, owner, path))
    return tuple(dict.fromkeys(unit for kind in kinds if kind is not None for unit in _units(kind)))


def _models(scene: Scene, owner: str, path: str) -> Iterator[type[Table]]:
    """The tables that a parameter may come from."""
    if owner == GROUND_NAME:
        yield GroundLinkTable
    if owner in {link.name for link in scene.mechanism.links}:
        yield from (LinkTable, *SHORTHAND.values())
    if owner in {joint.name for joint in (*scene.mechanism.joints, *scene.mechanism.open)}:
        yield JointTable
    for key, effect in zip(scene.keys_of_effects, scene.effects, strict=False):
        if any(parameter.path == path for parameter in effect.parameters()):
            yield MODELS[key]


def _units(kind: Any) -> Iterator[str]:
    """The units of all numbers in a type."""
    for mark in getattr(kind, "__metadata__", ()):
        for one in mark.metadata if isinstance(mark, FieldInfo) else [mark]:
            if isinstance(one, Measured | InTime):
                yield from one.units
    for part in get_args(kind):
        yield from _units(part)
