"""Slips that are made often: one sentence that says what to write, and nothing that only follows from it."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import pytest

from ccgen.generator.scene import SceneError, load_scene, read_tables

FOUR_BAR = """\
name = "four-bar"
[ground_link]
points = { O = [0, 0], Q = [0.6, 0] }
[[link]]
name = "crank"
mass = 1
inertia = 0.1
com = [0.1, 0]
points = { A = [0, 0], B = [0.2, 0] }
[[link]]
name = "coupler"
mass = 1
inertia = 0.1
com = [0.3, 0]
points = { A = [0, 0], B = [0.6, 0] }
[[link]]
name = "rocker"
mass = 1
inertia = 0.1
com = [0.2, 0]
points = { A = [0, 0], B = [0.4, 0] }
[[joint]]
between = ["ground.O", "crank.A"]
[[joint]]
between = ["crank.B", "coupler.A"]
[[joint]]
between = ["coupler.B", "rocker.B"]
[[joint]]
between = ["ground.Q", "rocker.A"]
[start]
angles = { crank = "90 deg", coupler = "20 deg", rocker = "100 deg" }
"""

# the slip: what stands in the file, what is written for it, line of the fault, its key, words of the one sentence
SLIPS: dict[str, tuple[str, str, int, str, tuple[str, ...]]] = {
    "one joint in single brackets": (
        '[[joint]]\nbetween = ["ground.O"',
        '[joint]\nbetween = ["ground.O"',
        22,
        "",
        ("found [joint]", "write [[joint]]"),
    ),
    "ground for ground_link": ("[ground_link]", "[ground]", 2, "ground", ("with points", "write [ground_link]")),
    "a unit without quotes": (
        "mass = 1\ninertia = 0.1\ncom = [0.1",
        "mass = 400 g\ninertia = 0.1\ncom = [0.1",
        6,
        "",
        ('write "400 g", in quotes, for a number with its unit',),
    ),
    "a unit without quotes in a point": (
        "Q = [0.6, 0]",
        "Q = [60 cm, 0]",
        3,
        "",
        ('write "60 cm", in quotes, for a number with its unit',),
    ),
    "a comma in a number": (
        "mass = 1\ninertia = 0.1\ncom = [0.1",
        'mass = "0,4"\ninertia = 0.1\ncom = [0.1',
        6,
        "link[0].mass",
        ('found "0,4"', "write 0.4"),
    ),
    "a unit of something else": (
        "Q = [0.6, 0]",
        'Q = ["60 kg", 0]',
        3,
        "ground_link.points.Q[0]",
        ("that is a mass, not a length in m", 'write one such as "20 cm"'),
    ),
    "a sign of degrees": ('"90 deg"', '"90°"', 31, "start.angles.crank", ('write "90 deg"',)),
    "a word for a joint": (
        'between = ["ground.O"',
        'type = "hinge"\nbetween = ["ground.O"',
        23,
        "joint[0].type",
        ('write "revolute"',),
    ),
    "points in one text": (
        '["crank.B", "coupler.A"]',
        '"crank.B, coupler.A"',
        25,
        "joint[1].between",
        ('write ["crank.B", "coupler.A"]',),
    ),
    "a speed of a motor": (
        "[start]",
        '[[motor]]\njoint = "joint_0"\nspeed = 3\n[start]',
        32,
        "motor[0].speed",
        ("a speed that is given is a [[drive]]",),
    ),
    "a table of angles": (
        "[start]",
        '[[motor]]\njoint = "joint_0"\nstiffness = 1\nangle = [[0, 0], [1, 1]]\n[start]',
        33,
        "motor[0].angle",
        ("write rows over time as { rows = [[t, value], ...], order = 3 }",),
    ),
    "a roof for a power": (
        "[start]",
        '[[motor]]\njoint = "joint_0"\ntorque = "3*t^2"\n[start]',
        32,
        "motor[0].torque",
        ("write ** for ^",),
    ),
    "a vector of gravity": (
        "[start]",
        "[gravity]\ng = [0, -9.81]\n[start]",
        31,
        "gravity.g",
        ("write g = 9.81 and direction = [0, -9.81]",),
    ),
    "gravity in the start": ("[start]", "[start]\ngravity = 9.81", 31, "start.gravity", ("write [gravity]",)),
    "a method in the scene": (
        "[start]",
        '[run]\nmethod = "radau"\n[start]',
        31,
        "run.method",
        ("ccgen run --method NAME",),
    ),
    "a comma for a point": (
        "mass = 1\ninertia = 0.1\ncom = [0.1",
        "mass = 0,4  # kg\ninertia = 0.1\ncom = [0.1",
        6,
        "",
        ("write 0.4, with a point for the comma",),
    ),
    "curved quotes": ('name = "coupler"', "name = “coupler”", 11, "", ("write straight quotes",)),
    "a colon": ('name = "four-bar"', 'name: "four-bar"', 1, "", ("write = for :",)),
    "two equal signs": ('name = "four-bar"', 'name == "four-bar"', 1, "", ("write one = alone between",)),
    "a colon before an equal sign": ("mass = 1\n", "mass := 1\n", 6, "", ("write one = alone between",)),
    "an equal sign apart": ('name = "four-bar"', 'name = = "a = b"', 1, "", ("write one = alone between",)),
    "no equal sign": ('name = "four-bar"', 'name "four-bar"', 1, "", ("write KEY = VALUE, with = between",)),
    "a quote that is open": ('name = "coupler"', 'name = "coupler', 11, "", ("close the quotes",)),
    "a link's name": (
        'name = "crank"',
        'name = "crnk"',
        23,
        "joint[0].between[1]",
        ('there is no link "crank", which joints name 2 times',),
    ),
    "a link's name twice": ('name = "coupler"', 'name = "crank"', 11, "link[1].name", ('found "crank" a second time',)),
    "a link's name in other letters": ('name = "crank"', 'name = "кривошип"', 5, "link[0].name", ("letters, digits",)),
}


@pytest.mark.parametrize("slip", SLIPS)
def test_a_slip_has_one_sentence(slip: str, tmp_path: Path) -> None:
    old, new, line, key, words = SLIPS[slip]
    assert FOUR_BAR.count(old) >= 1
    path = tmp_path / "slip.toml"
    path.write_text(FOUR_BAR.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(SceneError) as caught:
        load_scene(path)
    (fault,) = caught.value.faults
    assert (fault.line, fault.key) == (line, key)
    for word in words:
        assert word in fault.message


def test_all_single_brackets_are_told_together(tmp_path: Path) -> None:
    path = tmp_path / "single.toml"
    path.write_text(FOUR_BAR.replace("[[joint]]", "[joint]").replace("[[link]]", "[link]"))
    with pytest.raises(SceneError) as caught:
        load_scene(path)
    assert [fault.line for fault in caught.value.faults] == [4, 10, 16, 22, 24, 26, 28]


def test_a_slot_the_wrong_way_round_is_told_by_its_freedom() -> None:
    """A slot on the crank instead of on the lever: the pivot holds the crank, only the lever swings."""

    def quick_return(*slot: str) -> dict[str, Any]:
        return {
            "ground_link": {"points": {"C": [0, 0.3], "O": [0, 0]}},
            "link": [
                {"name": "crank", "mass": 1, "inertia": 0.1, "com": [0, 0], "points": {"A": [0, 0], "P": [0.12, 0]}},
                {"name": "lever", "mass": 1, "inertia": 0.1, "com": [0.3, 0], "points": {"A": [0, 0], "B": [0.6, 0]}},
            ],
            "joint": [
                {"name": "axle", "between": ["ground.C", "crank.A"]},
                {"name": "pivot", "between": ["ground.O", "lever.A"]},
                {"name": "slot", "type": "pin-in-slot", "between": [*slot], "axis": [1, 0]},
            ],
            "start": {"angles": {"crank": "0 deg", "lever": "70 deg"}},
            "drive": [{"joint": "axle", "speed": 6.283}],
        }

    read_tables(quick_return("lever.A", "crank.P"), "quick", "quick")
    with pytest.raises(SceneError) as caught:
        read_tables(quick_return("crank.P", "lever.A"), "quick", "quick")
    (fault,) = caught.value.faults
    assert fault.key == "drive[0]"
    for words in (
        "found axle driven, which the other joints hold still",
        "has 1 degree of freedom",
        "of slot has the slot",
    ):
        assert words in fault.message


# -- large and strange ----------------------------------------------------------------------------------------------


def many(table: str, count: int) -> str:
    return "".join(f"[[{table}]]\nrestitution = 0.5\npoint = [0, {-k}]\n" for k in range(count))


LARGE: dict[str, tuple[str, tuple[str, ...]]] = {
    "grounds": (FOUR_BAR + many("ground", 2000), ("ground[500]", "found 2000 tables, expected at most 500")),
    "wrong grounds": (
        FOUR_BAR + "[[ground]]\nrestitution = 5\n" * 20000,
        ("ground[49].restitution", ": and 451 more; mend these first"),
    ),
    "rows of a motor": (
        FOUR_BAR + '[[motor]]\njoint = "joint_0"\ntable = [' + ", ".join(f"[{k}, 1]" for k in range(20000)) + "]\n",
        ("motor[0].table: found 20000 rows, expected at most 500", "[[input]]"),
    ),
    "links": (FOUR_BAR + "[[link]]\nmass = 1\n" * 20000, ("link[2000]: found 20003 tables, expected at most 2000",)),
    "a header": (
        FOUR_BAR + "[" + ".".join(["a"] * 20000) + "]\n",
        ("found a key of 20000 parts, expected at most 64",),
    ),
    "a dotted key": (FOUR_BAR + '."b c" . '.join(["a"] * 5000) + "= 1\n", ("found a key of 9999 parts",)),
    "arrays": (FOUR_BAR + "x = " + "[" * 2000 + "]" * 2000 + "\n", ("more than 64 deep",)),
    "inline tables": (FOUR_BAR + "x = " + "{ a = " * 500 + "1" + " }" * 500 + "\n", ("more than 64 deep",)),
    "a number": (FOUR_BAR.replace("mass = 1", "mass = " + "9" * 5000, 1), ("found a number of 5000 digits",)),
}


@pytest.mark.parametrize("case", LARGE)
def test_large_input_is_told_in_seconds(case: str, tmp_path: Path) -> None:
    """A sentence with its line, within seconds of this process's own time."""
    text, words = LARGE[case]
    path = tmp_path / "large.toml"
    path.write_text(text)
    begun = time.process_time()
    with pytest.raises(SceneError) as caught:
        load_scene(path)
    assert time.process_time() - begun < 10.0
    for word in words:
        assert word in str(caught.value)
    assert all(len(line) < 700 for line in str(caught.value).splitlines())


def test_what_only_looks_large_is_read(tmp_path: Path) -> None:
    """Brackets, dots and digits in texts and comments, and long rows of numbers, are none of these."""
    path = tmp_path / "fine.toml"
    row = ", ".join(["0.5"] * 2)
    strange = "# " + "[" * 200 + "9" * 900 + "\n# " + ".".join(["a"] * 100) + "\n"
    path.write_text(strange + FOUR_BAR.replace("com = [0.1, 0]", f"com = [\n{row}\n]", 1))
    load_scene(path)


@pytest.mark.parametrize(
    "value", [10**400, -(10**5000), [[[[[[1]]]]]], {"a": 1}], ids=["400", "5000", "lists", "table"]
)
@pytest.mark.parametrize(
    "place", [("run", "until"), ("gravity", "g"), ("start", "tilt"), ("start", "angles"), ("motor", "torque")]
)
def test_values_of_any_size_are_refused_with_a_sentence(place: tuple[str, str], value: object) -> None:
    """From programs as well, where no reader looks at them first."""
    table, key = place
    inside: object = {key: value} if table != "motor" else [{"joint": "joint_1", key: value}]
    with pytest.raises(SceneError) as caught:
        read_tables({"chain": {"links": 2}, table: inside}, "odd", "odd")
    assert all(len(line) < 400 for line in str(caught.value).splitlines())


@pytest.mark.parametrize("sign", ["\x1b[2J", "\n", "\u202e", "\u2028", "\x9b", "\x00"])
def test_control_characters_are_escaped(sign: str) -> None:
    """A fault is one line, whatever the file's texts hold, in values and in keys."""
    tables = {"chain": {"links": 2}, "name": f"a{sign}b", f"k{sign}": 1, "start": {"angles": {f"link{sign}": 1.0}}}
    with pytest.raises(SceneError) as caught:
        read_tables(tables, "odd", "odd")
    lines = str(caught.value).splitlines()
    assert len(lines) == len(caught.value.faults) == 3
    assert all(sign not in line and "\\" in line for line in lines)


@pytest.mark.parametrize("size", [1e-320, 5e-324, 1e-200, 1.0, 1e200, 1.7e308])
def test_directions_of_any_length(size: float) -> None:
    """Only where they point counts: a 45 degree slope, with tiny normals and huge ones."""
    scene = read_tables(
        {
            "chain": {"links": 1},
            "start": {"height": 1.0},
            "ground": [{"restitution": 0, "normal": [size, size]}],
            "gravity": {"direction": [-size, -size]},
        },
        "slope",
        "slope",
    )
    gravity, ground = scene.effects
    half = 0.5**0.5
    assert ground.planes()[0][2].values() == pytest.approx((half, half), rel=1e-15)
    assert [p.value for p in gravity.parameters()[1:]] == pytest.approx([-half, -half], rel=1e-15)
