"""The part of a package's data that says which parameters a model has, what they may be, and which stay."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from graphlib import TopologicalSorter

from ..effect_base.effect import Effect
from ..effect_base.expression_of_state import OfState
from ..effect_base.grammar_of_state import asked_in, laws_in
from ..mechanism.implied import Implied
from ..mechanism.links import Parameter
from ..mechanism.mechanism import Mechanism


def parameter_data(parameters: Iterable[Parameter]) -> list[dict[str, object]]:
    """Paths, values and domains."""
    return [{"path": one.path, "value": one.value, "domain": vars(one.domain)} for one in parameters]


def data_over_time(effects: Iterable[Effect]) -> dict[str, str]:
    """The paths of what effects have over time where a number would be a parameter, and what that is."""
    return {path: law.told for effect in effects for path, law in effect.over_time().items()}


def data_of_state(effects: Sequence[Effect], outputs: Sequence[str]) -> list[dict[str, object]]:
    """Laws, each behind those that it names, and loads that are expressions of the state: what they name and ask, and
    which of the ``outputs`` tell them."""
    laws = {name: value for effect in effects for name, value in effect.defines().items()}
    order = TopologicalSorter({name: laws_in(value.text) for name, value in laws.items()}).static_order()
    found = [_of_state(name, laws[name], False, [name]) for name in order]
    for effect in effects:
        for path, value in effect.over_time().items():
            if isinstance(value, OfState):
                own = [one for one in outputs if one.startswith(f"{path.partition('.')[0]}.")]
                found.append(_of_state(path, value, True, own))
    return found


def laws_of_loads(effects: Iterable[Effect]) -> dict[str, list[str]]:
    """The paths of loads that are expressions of the state, each with the laws that it names."""
    given = (one for effect in effects for one in effect.over_time().items())
    return {path: laws_in(value.text) for path, value in given if isinstance(value, OfState)}


def _of_state(name: str, value: OfState, load: bool, outputs: list[str]) -> dict[str, object]:
    text = {"name": name, "text": value.shown, "load": load}
    return {**text, "laws": laws_in(value.text), "asks": asked_in(value.text), "outputs": outputs}


def resting_data(mechanism: Mechanism, implied: Iterable[Implied]) -> dict[str, str]:
    """The paths of parameters that must keep their values, each with the ``implied`` joint that rests on it."""
    return {one.path: mechanism.joints[idle.joint].name for idle in implied for one in idle.rests_on}
