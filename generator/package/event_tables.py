"""The contract's arrays of numbers on events of a scene: where they end a run, and what they set."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from ..mechanism.implied import Implied
from ..mechanism.links import ANY, FROM_0_TO_1, NOT_NEGATIVE, OFF_OR_ON, POSITIVE, Parameter
from ..scene.scene import Scene
from .parameter_data import resting_data

DOMAINS = {ANY: 0, NOT_NEGATIVE: 1, POSITIVE: 2, FROM_0_TO_1: 3, OFF_OR_ON: 4}
"""What parameters may be set to, as enum ccgen_domain of the contract numbers it."""
FOLDED = -1


def event_tables(scene: Scene, parameters: Sequence[Parameter], implied: Iterable[Implied]) -> dict[str, list[int]]:
    """They are empty where a scene has no events. ``parameters`` are those of the compiled model; others are folded
    into its code. Those on which ``implied`` joints rest cannot be set."""
    if not scene.indicators:
        return {}
    values = scene.values_of_events
    numbers = {one.path: number for number, one in enumerate(parameters)}
    rest = resting_data(scene.mechanism, implied)
    numbers = {path: FOLDED if path in rest else number for path, number in numbers.items()}
    domains = {one.path: DOMAINS[one.domain] for one in parameters}
    latches = _latches(scene)
    return {
        "stops_at": [event.stop for event in scene.events],
        "value_of": [one.event for one in values],
        "value_to": [numbers.get(one.path, FOLDED) for one in values],
        "value_within": [domains.get(one.path, 0) for one in values],
        "value_forgets": [number for one in values for number in latches.get(one.path, (0, 0))],
    }


def _latches(scene: Scene) -> dict[str, tuple[int, int]]:
    """Of each gate the first of the values that its effect holds, and how many they are."""
    found, first = {}, 0
    for index, effect in enumerate(scene.effects):
        count = len(effect.latches())
        if gate := scene.gate(index):
            found[gate.path] = (first, count)
        first += count
    return found
