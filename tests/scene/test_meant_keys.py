"""Which key an unknown one is taken for: by its spelling, its value, and what stands beside it."""

from __future__ import annotations

from typing import Any

import pytest

from ccgen.generator.effect_base.table import Table
from ccgen.generator.scene import SceneError, read_tables
from ccgen.generator.scene.kinds import MODELS
from ccgen.generator.scene.meant import holds, kinds_of, unknown_key

ARM = {
    "ground_link": {"points": {"O": [0, 0]}},
    "link": [{"name": "arm", "rod": {"mass": 1.0}, "points": {"A": [0, 0], "B": [1, 0]}}],
    "joint": [{"name": "hinge", "between": ["ground.O", "arm.A"]}],
}

MEANT: dict[str, tuple[dict[str, Any], str, str]] = {
    "another word for all that lacks": ({"force": [{"point": "arm.B", "force": [1, 2]}]}, "force[0].force", "vector"),
    "the spelling, where the value fits": (
        {"force": [{"point": "arm.B", "vector": [1, 2], "frme": "link"}]},
        "force[0].frme",
        "frame",
    ),
    "a number with its unit": (
        {"torsion": [{"joint": "hinge", "stifness": "2 N m/rad"}]},
        "torsion[0].stifness",
        "stiffness",
    ),
    "a key of a table in a table": (
        {"link": [{**ARM["link"][0], "rod": {"mas": 1.0}}]},  # type: ignore[dict-item]
        "link[0].rod.mas",
        "mass",
    ),
    "a table of the scene": ({"gravty": {"g": 9.81}}, "gravty", "gravity"),
    "another of several tables": (
        {"torsoin": [{"joint": "hinge", "stiffness": 1}], "torsion": []},
        "torsoin",
        "torsion",
    ),
}

NOT_MEANT: dict[str, tuple[dict[str, Any], str, str]] = {
    "a key that is there": (
        {"force": [{"point": "arm.B", "vector": [1, 2], "vectr": [1, 2]}]},
        "force[0].vectr",
        'remove it, "vector" is there already',
    ),
    "a list for a text": (
        {"force": [{"point": "arm.B", "vector": [1, 2], "fram": [1, 2]}]},
        "force[0].fram",
        "remove it",
    ),
    "a table for a number": ({"gravity": {"gg": {"x": 1}}}, "gravity.gg", "remove it"),
    "a number for tables": ({"links": 3}, "links", "remove it"),
    "a table that is there": (
        {"gravity": {"g": 9.81}, "gravty": {"g": 1.6}},
        "gravty",
        'remove it, "gravity" is there already',
    ),
}


def advice(tables: dict[str, Any], key: str) -> str:
    with pytest.raises(SceneError) as caught:
        read_tables({**ARM, **tables}, "arm.toml", "arm")
    (message,) = [fault.message for fault in caught.value.faults if fault.key == key]
    assert message.startswith("found an unknown key, expected one of "), message
    return message.rpartition("; ")[2]


@pytest.mark.parametrize("case", MEANT)
def test_the_key_that_is_meant(case: str) -> None:
    tables, key, meant = MEANT[case]
    assert advice(tables, key) == f'write "{meant}"'


@pytest.mark.parametrize("case", NOT_MEANT)
def test_what_is_not_meant(case: str) -> None:
    tables, key, told = NOT_MEANT[case]
    assert advice(tables, key) == told


def test_the_value_goes_to_the_key_that_is_meant() -> None:
    """Nothing is told to lack whose value stands at the unknown key."""
    with pytest.raises(SceneError) as caught:
        read_tables({**ARM, "force": [{"point": "arm.B", "force": [1, 2]}]}, "arm.toml", "arm")
    assert [fault.key for fault in caught.value.faults] == ["force[0].force"]


VALUES = (1, "2 m", True, [1.0, 2.0], ["a", "b"], [[0.0, 1.0], [1.0, 2.0]], {"A": [0.0, 1.0]})


@pytest.mark.parametrize("kind", MODELS)
@pytest.mark.parametrize("value", VALUES, ids=str)
def test_advice_is_never_a_key_that_is_there_or_takes_no_such_value(kind: str, value: object) -> None:
    """Of every table of a scene, every key misspelt, alone and beside the right one."""
    model: type[Table] = MODELS[kind]
    kinds = kinds_of(model)
    for key in kinds:
        for given in ((), (key,)):
            told = unknown_key(f"{key}x", value, kinds, given).rpartition('write "')
            if told[1]:
                meant = told[2].rstrip('"')
                assert meant not in given
                assert holds(kinds[meant], value)
            elif holds(kinds[key], value):
                assert given
