"""Numbers in quotes: units, what each key measures, arithmetic; and what is wrong with them."""

from __future__ import annotations

import json
import math
import pickle
import re
from collections.abc import Iterator
from typing import Annotated, Any, get_args, get_origin

import pytest

from ccgen.generator.effect_base.arithmetic import ExpressionError, Written
from ccgen.generator.effect_base.expression_of_time import InTime
from ccgen.generator.effect_base.table import Columns, Table
from ccgen.generator.effect_base.units import KINDS, UNITS, dimension_of, read_unit
from ccgen.generator.effect_base.written_numbers import Measured, read_number, read_quantity
from ccgen.generator.scene import SceneError, chain, read_tables
from ccgen.generator.scene.read import MODELS

IN_SI = {
    "20 cm": 0.2, "5 mm": 0.005, "35mm": 0.035, "-4.5e2 mm": -0.45, "1 in": 0.0254, "3 ft": 0.9144, "7 cm^2": 0.0007,
    "400 g": 0.4, "2 t": 2000.0, "1 lb": 0.45359237, "5 N/mm": 5000.0, "90 N mm": 0.09, "2 kNm": 2000.0,
    "3 kg m^2": 3.0, "3 kg·m²": 3.0, "500 g cm^2": 5e-5, "7.85 g/cm^3": 7850.0, "3 m/s²": 3.0, "3 kg m/s^2": 3.0,
    "1.5 min": 90.0, "20 ms": 0.02, "10 Hz": 10.0, "50 %": 0.5, "3 1/s": 3.0, "2 W/(m s)": 2.0, "5 μm": 5e-6,
    "30 deg": math.radians(30.0), "0.2 rad": 0.2, "0.5 rev": math.pi, "60 rpm": 2 * math.pi,
    "2 N m/deg": 2 * 180 / math.pi, "10 deg/s": math.radians(10.0), "0 mm": 0.0,
}  # fmt: skip


@pytest.mark.parametrize("text", IN_SI)
def test_units_are_put_into_si(text: str) -> None:
    """To the last digit where the unit is a fraction of that in SI."""
    found = read_quantity(text, None)
    assert found == (IN_SI[text] if not re.search("deg|rev|rpm", text) else pytest.approx(IN_SI[text], rel=1e-15))


@pytest.mark.parametrize("unit", KINDS)
def test_examples_of_kinds_are_of_that_kind(unit: str) -> None:
    _, example = KINDS[unit]
    assert read_number(example, (unit,)) == read_quantity(example, None) or unit == "1"
    assert all(KINDS[other][0] == KINDS[unit][0] or other != unit for other in KINDS)


def test_prefixes_agree() -> None:
    for name, unit in UNITS.items():
        for prefix, factor in (("k", 1000), ("m", 1e-3), ("c", 1e-2)):
            if prefix + name in UNITS and UNITS[prefix + name].dimension == unit.dimension:
                assert float(UNITS[prefix + name].factor) == pytest.approx(factor * float(unit.factor), rel=1e-15)


# text, the unit of its key, words of what is said
WRONG_TEXTS: dict[str, tuple[str, tuple[str, ...], str]] = {
    "another kind": ("400 g", ("m",), 'that is a mass, not a length in m; write one such as "20 cm"'),
    "one of two kinds": ("1 s", ("N m", "N"), "that is a time, not a moment in N m or a force in N"),
    "no kind that has a name": ("3 kg m/s", ("N",), "that is something in kg m s^-1, not a force in N"),
    "a unit of a number": ("5 m", ("1",), "that is a length, not a number without a unit; write it without a unit"),
    "a moment for a stiffness": ("5 N m", ("N m/rad",), "that is a moment, not a stiffness against turning in N m/rad"),
    "turns or radians": ("10 Hz", ("rad/s",), "Hz may mean turns or radians per second; write rpm, rev/s or rad/s"),
    "an unknown unit": ("2 furlong", ("m",), '"furlong" is no unit that is known; the units are %, kg, g'),
    "a unit in capitals": ("20 CM", ("m",), 'write "20 cm"'),
    "a unit that is another in capitals": ("20 MN", ("N",), '"MN" is no unit that is known'),
    "a product without a sign": ("2 rho l", ("kg",), 'write "2*rho*l" for a product'),
    "a unit as a word": ("400 gramm", ("kg",), 'write "400 g"'),
    "a word in the plural": ("3 Seconds", ("s",), 'write "3 s"'),
    "a unit in the plural": ("2 lbs", ("kg",), 'write "2 lb"'),
    "a unit in two ways": ("2 W/m s", ("N",), '"W/m s" could be read in two ways; write "W/(m s)"'),
    "two strokes": ("3 m//s", ("m/s",), '"m//s" is no unit that is known'),
    "a comma": ("0,6", ("m",), "it has a comma; write 0.6"),
    "a comma before a unit": ("0,6 cm", ("m",), 'it has a comma; write "0.6 cm"'),
    "degrees": ("10 degrees", ("rad",), 'write "10 deg", or a number of rad without quotes'),
    "a sign of degrees": ("10°", ("rad",), 'write "10 deg"'),
    "a unit above a number": ("60 s / 30", ("s",), "units stand behind a single number, not in arithmetic; give 60 s"),
    "units in arithmetic": ("20 cm + 5 mm", ("m",), "units stand behind a single number, not in arithmetic"),
    "a unit behind arithmetic": ("2*20 cm", ("m",), "give 20 cm a name in [let], and write that here"),
    "a name": ("far", ("m",), "far is not known here; the only name is pi; write a number without quotes"),
    "the time": ("2*t", ("m",), "t is the time, and this is a number that stays"),
    "a division by zero": ("1/(2 - 2)", ("m",), "it divides by zero, so that it has no finite value"),
    "a root of less than zero": ("sqrt(-1)", ("m",), "it has no finite value, as a root of a negative number has none"),
    "too large": ("exp(1000)", ("m",), "it has no finite value, because it is too large"),
    "too large a unit": ("1e308 km", ("m",), "it has no finite value, because it is too large"),
    "a roof": ("2^3", ("m",), "write ** for ^"),
    "nothing": ("", ("m",), "it cannot be read"),
    "something of Python's": ("__import__('os')", ("m",), "__import__(...) is not known here"),
    "two arguments": ("atan2(1)", ("rad",), "atan2(...) takes two arguments"),
    "very long": ("1" * 3000, ("m",), "it has 3000 characters"),
    "an exponent without end": ("1e999999999 mm", ("m",), "because it is too large"),
}  # fmt: skip


@pytest.mark.parametrize("case", WRONG_TEXTS)
def test_wrong_texts(case: str) -> None:
    text, units, words = WRONG_TEXTS[case]
    with pytest.raises(ExpressionError) as caught:
        read_number(text, units)
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1e-3", 1e-3), ("-2.5", -2.5), ("2*pi/3", 2 * math.pi / 3), ("sqrt(2)/2", math.sqrt(2) / 2), ("2**-2", 0.25),
        ("atan2(-1, -1)", -0.75 * math.pi), ("asin(1) + acos(1) + atan(1)", 0.75 * math.pi), ("cos(pi)", -1.0),
    ],
)  # fmt: skip
def test_arithmetic(text: str, value: float) -> None:
    assert read_number(text, ("m",)) == pytest.approx(value, rel=1e-15)


def test_a_written_number_is_a_number() -> None:
    """It keeps its text through a pickle; two texts of one number are one."""
    number = read_number("20 cm", ("m",))
    again = pickle.loads(pickle.dumps(number))
    assert isinstance(again, Written) and (again, again.text, again.dimension) == (0.2, "20 cm", dimension_of("m"))
    assert number == read_number("200 mm", ("m",)) and repr(number) == "0.2"


# -- what keys measure ----------------------------------------------------------------------------------------------


def leaves(kind: Any, marks: tuple[Any, ...] = ()) -> Iterator[tuple[Any, tuple[Any, ...]]]:
    """Types in a type that have no others in them, with their marks."""
    if get_origin(kind) is Annotated:
        inner, *own = get_args(kind)
        yield from leaves(inner, (*own, *marks))
    elif columns := next((mark for mark in marks if isinstance(mark, Columns)), None):
        for one in columns.kinds:
            yield from leaves(one)
    elif any(isinstance(mark, InTime) for mark in marks):
        yield float, marks
    elif get_origin(kind) in (list, dict) or (get_args(kind) and get_origin(kind) is not None and kind is not None):
        inner = [get_args(kind)[-1]] if get_origin(kind) in (list, dict) else [*get_args(kind)]
        for one in inner:
            yield from leaves(one, marks if get_origin(kind) not in (list, dict) else ())
    else:
        yield kind, marks


def all_tables(model: type[Table]) -> Iterator[type[Table]]:
    yield model
    for field in model.model_fields.values():
        for kind, _ in leaves(field.annotation):
            if isinstance(kind, type) and issubclass(kind, Table):
                yield from all_tables(kind)


def number_keys() -> Iterator[tuple[str, Any, tuple[str, ...]]]:
    """Every number of every table: its key, its field, the units that it is marked with."""
    for top in MODELS.values():
        for model in all_tables(top):
            for key, field in model.model_fields.items():
                for kind, marks in leaves(field.annotation, tuple(field.metadata)):
                    if kind in (float, int):
                        units = [mark.units for mark in marks if isinstance(mark, Measured | InTime)]
                        yield f"{model.__name__}.{key}", field, (units[0] if units else ())


def test_every_number_of_a_scene_says_what_it_measures() -> None:
    keys = [*number_keys()]
    assert len(keys) > 80
    assert not [key for key, _, units in keys if not units]


def test_units_in_words_are_those_of_the_marks() -> None:
    """What a fault says is expected names the unit; of rows and poses one of them."""
    for key, field, units in number_keys():
        for unit in units:
            assert read_unit(unit)
            if unit not in ("1",) and not key.startswith("StartTable.poses"):
                assert re.search(rf"(?<!\w){re.escape(unit)}(?!\w)", field.description), (key, unit)


def test_texts_are_the_numbers_that_they_stand_for() -> None:
    """The same scene in units and in SI is the same scene, down to what is generated from."""
    words = chain(
        3,
        True,
        {"g": "981 cm/s^2", "direction": ["0", "-2/2"]},
        chain={"links": "6/2", "length": ["20 cm", "0.5 m", 1], "mass": "400 g", "com": "50 mm"},
        start={"angles": ["30 deg", "pi/4", "0.1 rev"], "angular_velocities": ["60 rpm", "10 deg/s", 0]},
        ground=[
            {"point": [0, "-2 m"], "restitution": "50 %", "contacts": ["link_2.B"], "radius": "1 cm", "friction": "1/4"}
        ],
        motor=[{"joint": "joint_0", "table": [["0 s", "1 Nm"], ["20 ms", "2 N m"]]}],
        spring=[{"between": ["ground.O", "link_2.B"], "stiffness": "5 N/mm", "length": "1 dm"}],
        torsion=[{"joint": "joint_1", "stiffness": "2 N m/rad", "angle": "-10 deg", "damping": "1 N m s/rad"}],
        force=[{"point": "link_1.B", "vector": ["2 kN", "3*sin(2*t)"]}],
        run={"until": "1.5 min", "rtol": "1e-3*1e-6"},
    )
    numbers = chain(
        3,
        True,
        {"g": 9.81, "direction": [0, -1]},
        chain={"length": [0.2, 0.5, 1.0], "mass": 0.4, "com": 0.05},
        start={
            "angles": [math.radians(30), math.pi / 4, 0.1 * (2 * math.pi)],
            "angular_velocities": [60 * (math.pi / 30), 10 * math.radians(1), 0],
        },
        ground=[{"point": [0, -2], "restitution": 0.5, "contacts": ["link_2.B"], "radius": 0.01, "friction": 0.25}],
        motor=[{"joint": "joint_0", "table": [[0, 1], [0.02, 2]]}],
        spring=[{"between": ["ground.O", "link_2.B"], "stiffness": 5000, "length": 0.1}],
        torsion=[{"joint": "joint_1", "stiffness": 2, "angle": math.radians(-10), "damping": 1}],
        force=[{"point": "link_1.B", "vector": [2000, "3*sin(2*t)"]}],
        run={"until": 90, "rtol": 1e-3 * 1e-6},
    )
    assert words.canonical() == numbers.canonical()


SLIDER: dict[str, Any] = {
    "ground_link": {"points": {"O": [0, 0]}},
    "link": [{"name": "block", "mass": 1, "inertia": 1, "com": [0, 0], "points": {"C": [0, 0]}}],
    "joint": [{"name": "guide", "between": ["ground.O", "block.C"]}],
}


JOINT_UNITS: list[tuple[str, str, dict[str, Any], str, str]] = [
    ("revolute", "drive", {"speed": "20 mm/s"}, "speed", "a speed, expected an angular velocity in rad/s"),
    ("prismatic", "drive", {"speed": "20 rpm"}, "speed", "an angular velocity, expected a speed in m/s"),
    ("revolute", "motor", {"angle": 1, "stiffness": "5 N/m"}, "stiffness", "a stiffness, expected a stiffness against"),
    ("revolute", "motor", {"angle": 1, "stiffness": 1, "limit": "5 N"}, "limit", "a force, expected a moment in N m"),
    ("prismatic", "motor", {"table": [[0, 1], [1, "2 N m"]]}, "table[1][1]", "a moment, expected a force in N"),
    ("prismatic", "joint_friction", {"dry": "2 N m"}, "dry", "a moment, expected a force in N"),
    ("revolute", "joint_friction", {"viscous": "2 N s/m"}, "viscous", "a damping, expected a damping against turning"),
]


@pytest.mark.parametrize(("kind", "name", "table", "key", "words"), JOINT_UNITS)
def test_units_fit_the_kind_of_joint(kind: str, name: str, table: dict[str, Any], key: str, words: str) -> None:
    joint = {**SLIDER["joint"][0], "type": kind, **({"axis": [1, 0]} if kind == "prismatic" else {})}
    whole = table | ({} if name == "joint_friction" else {"joint": "guide"})
    with pytest.raises(SceneError) as caught:
        read_tables(SLIDER | {"joint": [joint], name: [whole]}, "slider", "slider")
    (fault,) = caught.value.faults
    assert fault.key == f"{name}[0].{key}" and words in fault.message


def test_a_fault_shows_the_text_and_its_number() -> None:
    with pytest.raises(SceneError) as caught:
        chain(2, chain={"mass": "-400 g"}, run={"rtol": "3/2"})
    assert [fault.message.partition(",")[0] for fault in caught.value.faults] == [
        'found "-400 g" (-0.4)',
        'found "3/2" (1.5)',
    ]


@pytest.mark.parametrize("kind", MODELS)
def test_editors_are_told_that_numbers_may_be_texts(kind: str) -> None:
    """Tables have a JSON schema, in which what is a number may be a text too."""
    text = json.dumps(MODELS[kind].model_json_schema())
    assert kind == "let" or '"string"' in text
