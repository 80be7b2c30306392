"""Records of a scene in which parameters have other values."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass, replace
from typing import Any, TypeVar

from ..mechanism.links import Parameter

T = TypeVar("T")


def valued(part: T, values: Mapping[str, float]) -> T:
    """The part of a scene with these ``values`` (SI units), by their paths, of parameters within it."""
    found: T = _valued(part, values) if values else part
    return found


def _valued(part: Any, values: Mapping[str, float]) -> Any:
    if isinstance(part, Parameter):
        return replace(part, value=values[part.path]) if part.path in values else part
    if isinstance(part, Mapping):
        return {key: _valued(one, values) for key, one in part.items()}
    if isinstance(part, Sequence) and not isinstance(part, str):
        return tuple(_valued(one, values) for one in part)
    if is_dataclass(part) and not isinstance(part, type):
        return replace(part, **{one.name: _valued(getattr(part, one.name), values) for one in fields(part) if one.init})
    return part
