"""The contract's arrays of numbers on events of a scene: where they end a run, and what they set."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from ..mechanism.implied import Implied
from ..mechanism.links import ANY, FROM_0_TO_1, NOT_NEGATIVE, OFF_OR_ON, POSITIVE, Parameter
from ..scene.scene import HELD, Scene
from .parameter_data import resting_data

DOMAINS = {ANY: 0, NOT_NEGATIVE: 1, POSITIVE: 2, FROM_0_TO_1: 3, OFF_OR_ON: 4}
"""What parameters may be set to, as enum ccgen_domain of the contract numbers it."""
FOLDED = -1


def event_tables(
    scene: Scene, parameters: Sequence[Parameter], implied: Iterable[Implied]
) -> dict[str, list[int] | list[float]]:
    """They are empty where a scene has no events, and no joint lets go or takes hold. ``parameters`` are those of the
    compiled model; others are folded into its code. Those on which ``implied`` joints rest cannot be set."""
    if not scene.indicators:
        return {}
    values = scene.values_of_events
    numbers = {one.path: number for number, one in enumerate(parameters)}
    rest = resting_data(scene.mechanism, implied)
    numbers = {path: FOLDED if path in rest else number for path, number in numbers.items()}
    domains = {one.path: DOMAINS[one.domain] for one in parameters}
    latches = _latches(scene)
    return {
        "stops_at": [*(event.stop for event in scene.events), *(0 for _ in scene.changes)],
        "value_of": [one.event for one in values],
        "value_to": [numbers.get(one.path, FOLDED) for one in values],
        "value_within": [domains.get(one.path, 0) for one in values],
        "value_forgets": [number for one in values for number in latches.get(one.path, (0, 0))],
        **_change_tables(scene, numbers),
    }


def _change_tables(scene: Scene, numbers: Mapping[str, int]) -> dict[str, list[int] | list[float]]:
    """What is said of the changes among the indicators: their joint, its gate, and the limits of its force (N), its
    impulse (N s) and the distance (m) of its points; 0: none."""
    if not scene.changes:
        return {}
    joints = {joint.name: k for k, joint in enumerate(scene.mechanism.joints)}
    none, changes = [-1] * len(scene.events), scene.changes
    kinds = [0 if one.at is not None else 1 if one.force is not None else 2 if one.meets else 3 for one in changes]
    limits = [float(limit or 0.0) for one in changes for limit in (one.force, one.impulse, one.within)]
    return {
        "joint_of": [*none, *(joints[one.joint] for one in changes)],
        "gate_of": [*none, *(numbers[f"{one.joint}{HELD}"] for one in changes)],
        "held_before": [*none, *(int(one.kind == "release") for one in changes)],
        "change_by": [*none, *kinds],
        "limits": [*(0.0 for _ in range(3 * len(scene.events))), *limits],
    }


def _latches(scene: Scene) -> dict[str, tuple[int, int]]:
    """Of each gate the first of the values that its effect holds, and how many they are. Effects at joints that let go
    come back only where these take hold."""
    found, first = {}, 0
    for index, effect in enumerate(scene.effects):
        count = len(effect.latches())
        gates = [scene.gate(index), *(scene.mechanism.gates_at.get(joint) for joint in effect.at_joints())]
        for gate in filter(None, gates if count else gates[:1]):
            found[gate.path] = (first, count)
        first += count
    return found
