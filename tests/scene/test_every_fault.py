"""Every fault at once: no fault in a table hides another, and nothing that only follows is told."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from copy import deepcopy
from itertools import combinations
from typing import Any, get_args

import pytest
from pydantic.fields import FieldInfo

from ccgen.generator.effect_base.expression_of_state import InLaw, InLoad
from ccgen.generator.effect_base.expression_of_time import InTime
from ccgen.generator.effect_base.table import Named, Table
from ccgen.generator.effects import REGISTRY
from ccgen.generator.scene import SceneError, read_tables
from ccgen.generator.scene.read import MODELS, SHORTHAND
from ccgen.generator.scene.stand_ins import Names, stand_in

from ..support.effect_examples import EXAMPLES, SCENE
from ..support.tiers import all_hard_but

BARS = """
[ground_link]
points = { O = [0, 0] }
[[link]]
name = "crank"
mass = 1.0
inertia = 0.1
com = [0.5, 0]
points = { A = [0, 0], B = [1, 0] }
[[link]]
name = "rod"
mass = 1.0
inertia = 0.1
com = [0.5, 0]
points = { A = [0, 0], B = [1, 0] }
[[joint]]
type = "prismatic"
between = ["ground.O", "crank.A"]
axis = [1, 0]
[[joint]]
between = ["crank.B", "rod.A"]
"""
SCENES: dict[str, str] = {
    **{key: SCENE + text for key, text in EXAMPLES.items()},
    **{form: f"[{form}]\n{'count' if form == 'four_bars' else 'links'} = 4\n" for form in SHORTHAND},
    **dict.fromkeys(("link", "joint", "ground_link"), BARS),
    "start": "[chain]\nlinks = 3\n[start]\nangles = [0, 1, 2]\n",
    "release": SCENE + '[[release]]\njoint = "joint_1"\nat = 1\n',
    "hold": SCENE + '[[hold]]\njoint = "joint_1"\nat = 1\n',
    "event": SCENE + '[[event]]\nwhen = "t - 1"\nstop = true\n',
    "run": SCENE + "[run]\n",
    "output": SCENE + '[output]\ntable = ["t"]\ntimes = 3\n',
    "let": SCENE + "[let]\na = 1\n",
}
"""A good scene for every kind of table."""
NOTHING: list[Any] = [[[]]]
"""What no key takes."""
DIRECTIONS = ("normal", "direction", "axis")
PER_LINK = ("length", "mass", "inertia", "com", "angles", "angular_velocities")
KINDS = [*MODELS]


def table_of(tables: dict[str, Any], kind: str) -> dict[str, Any]:
    """The first table of a kind, one to write into."""
    table: dict[str, Any] = tables[kind][0] if isinstance(tables[kind], list) else tables[kind]
    return table


def marks(field: FieldInfo) -> str:
    return repr((field.annotation, field.metadata))


def wrong_values(model: type[Table], key: str) -> Iterator[object]:
    """Values that the key may not have, of several kinds as far as its field takes them for what they are."""
    field = model.model_fields[key]
    yield NOTHING
    if "Named(" in marks(field):
        listed = any(str(one).startswith("list[") for one in (field.annotation, *get_args(field.annotation)))
        yield ["nix", "nix.A"] if listed else "nix"
    if key in DIRECTIONS:
        yield [0, 0]
    if key in PER_LINK and "list[" in marks(field):
        yield [1.0, 1.0]
    if any(mark.__name__ in marks(field) for mark in (InTime, InLoad, InLaw)):
        yield ["sin(", 1] if "list[" in marks(field) else "sin("


def told(kind: str, values: dict[str, object]) -> set[str]:
    """Keys of the first table of that kind that have faults once it holds these values."""
    tables = deepcopy(tomllib.loads(SCENES[kind]))
    table_of(tables, kind).update(values)
    try:
        read_tables(tables, "scene", "scene")
    except SceneError as error:
        found = [fault.key.removeprefix(f"{kind}[0]").removeprefix(kind).lstrip(".") for fault in error.faults]
        return {key.partition("[")[0].partition(".")[0] for key in found}
    return set()


@pytest.mark.sample(3)
@pytest.mark.parametrize(
    "kind",
    all_hard_but("link", "joint", "ground_link", "start", "release", "event", "let", "ground", "touch", of=KINDS),
)
def test_no_fault_of_a_table_hides_another(kind: str) -> None:
    model = MODELS[kind]
    alone = [
        (key, value)
        for key in model.model_fields
        for value in wrong_values(model, key)
        if key in told(kind, {key: value})
    ]
    assert {key for key, _ in alone} == set(model.model_fields), "each key can be wrong"
    counted = {("links", key) for key in PER_LINK}  # how many there must be is not known without the number
    hidden = [
        ({one: a, other: b}, missing)
        for (one, a), (other, b) in combinations(alone, 2)
        if one != other and (one, other) not in counted and (missing := {one, other} - told(kind, {one: a, other: b}))
    ]
    assert not hidden


@pytest.mark.sample(12)
@pytest.mark.parametrize("kind", KINDS)
def test_what_no_key_takes_is_told_alone(kind: str) -> None:
    """Nothing follows from a value of the wrong kind, at an example that needs no other."""
    model = MODELS[kind]
    given = table_of(tomllib.loads(SCENES[kind]), kind)
    for key in given.keys() & model.model_fields.keys():
        assert told(kind, {key: NOTHING}) == {key}


@pytest.mark.parametrize("kind", KINDS)
def test_every_key_has_stand_ins(kind: str) -> None:
    """They pass the schema, and those of two readings differ."""
    model = MODELS[kind]
    known = Names(("j", "k"), ("a", "b"), ("a.A", "b.B"), ("a.A", "b.B"))
    example = table_of(tomllib.loads(SCENES[kind]), kind)
    for key in model.model_fields:
        values = [stand_in(model, (key,), None, number, known) for number in range(2)]
        for value in values:
            model.model_validate(example | {key: value})
        assert values[0] != values[1] or values[0] in ([], {}), key


def test_every_text_of_an_effect_is_marked_as_a_name() -> None:
    """A text that names something needs that of something there to stand in for it."""
    for entry in REGISTRY:
        for key, field in entry.table.model_fields.items():
            plain = marks(field).replace("typing.", "").replace("dict[Annotated[str", "dict[Annotated[key")
            if key != "name" and ("'str'" in plain or "[str" in plain or "str |" in plain):
                assert Named.__name__ in plain, f"{entry.key}.{key}"


# a scene, and all that is told of it: faults of meaning beside each other and beside wrong values, and what they hide
CHAIN = "[chain]\nlinks = 3\nhinged = true\n"
TOGETHER: dict[str, tuple[str, set[str]]] = {
    "joint and expression": (
        CHAIN + '[[motor]]\njoint = "joint_55"\ntorque = "sin("\n',
        {"motor[0].joint", "motor[0].torque"},
    ),
    "two laws, one wrong": (
        CHAIN + '[[motor]]\njoint = "joint_0"\ntorque = "2*sin(x)"\nangle = 1\n',
        {"motor[0].torque", "motor[0].angle"},
    ),
    "direction": (CHAIN + "[gravity]\ng = inf\ndirection = [0, 0]\n", {"gravity.g", "gravity.direction"}),
    "own pin": (
        CHAIN + '[[touch]]\nbetween = ["joint_1", "link_0.A"]\nradius = -1\nrestitution = 3\n',
        {"touch[0].between", "touch[0].radius", "touch[0].restitution"},
    ),
    "radii": (
        CHAIN + '[[ground]]\nrestitution = 3\ncontacts = ["link_0.B", "link_1.A", "nix"]\nradius = [1, 2]\n',
        {"ground[0].restitution", "ground[0].radius", "ground[0].contacts[2]"},
    ),
    "a start whose links are wrong": (
        "[loop]\nlinks = 4\nlength = [1, 1]\n[start]\nangles = [1, 2]\nheight = 1\nposition = [0, 0]\n",
        {"loop.length", "start.angles", "start.height"},
    ),
    "a start of a number of links that is none": (
        '[loop]\nlinks = "four"\nmass = [1, 2]\n[start]\nangles = [1, 2]\nheight = 1\nposition = [0, 0]\n',
        {"loop.links", "start.height"},
    ),
    "effects of links that are wrong": (
        BARS.replace("com = [0.5, 0]", "com = [0.5]") + '[[torque]]\nlink = "road"\ntorque = 1\n',
        {"link[0].com", "link[1].com", "torque[0].link"},
    ),
    "a joint that is wrong twice": (
        BARS.replace("axis = [1, 0]", "axis = [0, 0]").replace('"ground.O"', '"ground.P"'),
        {"joint[0].axis", "joint[0].between[0]"},
    ),
    "a start inside a ground that is wrong": (
        "[loop]\nlinks = 4\n[start]\nposition = [0, -1]\n[[ground]]\nrestitution = 0\nfriction = -1\n",
        {"ground[0].friction", "ground[0]"},
    ),
    "a link's name, and what names it": (BARS.replace('name = "rod"', 'name = "r o d"'), {"link[1].name"}),
    "a key that is meant otherwise": (CHAIN + '[[motor]]\njoint = "joint_0"\ntorqe = 1\n', {"motor[0].torqe"}),
    "another table is meant": (CHAIN + '[[motor]]\njoint = "nix"\nspeed = 1\n', {"motor[0].speed"}),
    "laws of impact that differ, in tables that are wrong": (
        CHAIN
        + '[[ground]]\nrestitution = 3\nlaw = "poisson"\n[[ground]]\nrestitution = 0\nfriction = -1\nlaw = "newton"\n',
        {"ground[0].restitution", "ground[1].friction", "ground[1].law"},
    ),
    "laws of impact, one that is none and two that differ": (
        CHAIN
        + '[[ground]]\nrestitution = 0\nlaw = "hooke"\n[[ground]]\nrestitution = 0\nlaw = "newton"\n'
        + '[run]\nlaw = "poisson"\n',
        {"ground[0].law", "ground[1].law"},
    ),
    "laws of impact, one that is none beside one": (
        CHAIN + '[[ground]]\nrestitution = 0\nlaw = "stronge"\n[run]\nlaw = "hooke"',
        {"run.law"},
    ),
    "a key that is meant as a law, beside another law": (
        CHAIN + '[[ground]]\nrestitution = 0\nlaw = "stronge"\n[run]\nlwa = "newton"',
        {"run.lwa", "ground[0].law"},
    ),
    "not a number": (CHAIN + "[start]\ntilt = inf\nangles = [1, inf]\n", {"start.tilt", "start.angles[1]"}),
}


@pytest.mark.parametrize("case", TOGETHER)
def test_told_together(case: str) -> None:
    text, keys = TOGETHER[case]
    with pytest.raises(SceneError) as caught:
        read_tables(tomllib.loads(text), "scene", "scene")
    assert {fault.key for fault in caught.value.faults} == keys
    places = [fault.key for fault in caught.value.faults]
    assert len(places) == len(keys) or case == "a start inside a ground that is wrong", "each fault is told once"
