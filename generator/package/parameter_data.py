"""The part of a package's data that says which parameters a model has, what they may be, and which stay."""

from __future__ import annotations

from collections.abc import Iterable

from ..effect_base.effect import Effect
from ..mechanism.implied import Implied
from ..mechanism.links import Parameter
from ..mechanism.mechanism import Mechanism


def parameter_data(parameters: Iterable[Parameter]) -> list[dict[str, object]]:
    """Paths, values and domains."""
    return [{"path": one.path, "value": one.value, "domain": vars(one.domain)} for one in parameters]


def data_over_time(effects: Iterable[Effect]) -> dict[str, str]:
    """The paths of what effects have over time where a number would be a parameter, and what that is."""
    return {path: law.told for effect in effects for path, law in effect.over_time().items()}


def resting_data(mechanism: Mechanism, implied: Iterable[Implied]) -> dict[str, str]:
    """The paths of parameters that must keep their values, each with the ``implied`` joint that rests on it."""
    return {one.path: mechanism.joints[idle.joint].name for idle in implied for one in idle.rests_on}
