"""``[let]``: names of numbers, whatever their order; what is wrong with them is told where it stands, and once."""

from __future__ import annotations

import math
import tomllib
from itertools import permutations
from pathlib import Path
from typing import Any

import pytest

from ccgen.generator.pipeline import listing
from ccgen.generator.scene import Scene, SceneError, chain, load_scene, read_tables

WORDS = """\
name = "four-bar"

[let]
crank = "20 cm"
bar = "2.5*crank"
rho = "2 kg/m"
speed = 12
reach = "3*crank"

[ground_link]
points = { O = [0, 0], Q = ["reach", 0] }

[[link]]
name = "crank"
rod = { mass_per_length = "rho" }
points = { A = [0, 0], B = ["crank", 0] }

[[link]]
name = "coupler"
rod = { mass_per_length = "rho" }
points = { A = [0, 0], B = ["bar", 0] }

[[link]]
name = "rocker"
rod = { mass_per_length = "rho" }
points = { A = [0, 0], B = ["bar", 0] }

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
angular_velocities = { crank = "speed" }

[[motor]]
joint = "joint_0"
torque = "rho*sin(-speed*t) + atan2(speed, 3)*t"

[gravity]
"""
NUMBERS = WORDS[: WORDS.index("[let]")] + WORDS[WORDS.index("[ground_link]") :].replace(
    '"reach"', "0.6000000000000001"
).replace('B = ["crank", 0]', "B = [0.2, 0]").replace('["bar", 0]', "[0.5, 0]").replace(
    'crank = "speed"', "crank = 12"
).replace(
    'rod = { mass_per_length = "rho" }', "mass = 0.4\ninertia = 0.0013333333333333333\ncom = [0.1, 0]", 1
).replace('rod = { mass_per_length = "rho" }', "mass = 1\ninertia = 0.020833333333333332\ncom = [0.25, 0]").replace(
    "rho*sin(-speed*t) + atan2(speed, 3)*t", "2.0*sin(-12*t) + atan2(12, 3)*t"
)


def read(text: str, tmp_path: Path) -> Scene:
    path = tmp_path / "scene.toml"
    path.write_text(text, encoding="utf-8")
    return load_scene(path)


def test_words_and_numbers_are_one_scene(tmp_path: Path) -> None:
    """The same record, and the same bytes of its equations."""
    words, numbers = read(WORDS, tmp_path), read(NUMBERS, tmp_path)
    assert '"speed"' not in NUMBERS and "[let]" not in NUMBERS
    assert words.canonical() == numbers.canonical()
    assert listing(words) == listing(numbers)


def one(let: dict[str, Any], length: object = "a") -> Scene:
    return chain(1, chain={"length": length}, let=let)


def length_of(scene: Scene) -> float:
    return scene.mechanism.links[0].points["B"].values()[0]


@pytest.mark.parametrize("order", [*permutations(range(4))])
def test_order_does_not_matter(order: tuple[int, ...]) -> None:
    given = [("a", "b + c"), ("b", "2*d"), ("c", "sqrt(d)"), ("d", "400 cm")]
    assert length_of(one(dict(given[k] for k in order))) == 10.0


@pytest.mark.parametrize(
    ("value", "number"),
    [(3, 3.0), (0.25, 0.25),
     ("20 cm", 0.2), ("pi", math.pi), ("-2**2 + 5", 1.0), ("1e3", 1000.0), ("1 rev", 2 * math.pi)],
)  # fmt: skip
def test_values(value: object, number: float) -> None:
    assert length_of(chain(1, chain={"length": "1*a"}, let={"a": value})) == pytest.approx(number, rel=1e-15)


def test_negative_numbers_keep_their_sign_in_expressions() -> None:
    """-2 squared is 4, as a name, also in an expression of time."""
    scene = chain(1, True, let={"a": -2, "b": "-0.5"}, motor=[{"joint": "joint_0", "torque": "a**2*t - b**3 + 2**-a"}])
    (motor,) = scene.effects
    assert motor.drive.torque.at(1.0) == 4.0 + 0.125 + 4.0  # type: ignore[attr-defined]


def test_names_may_be_those_of_units() -> None:
    """Behind a number stands a unit, by itself a name."""
    assert length_of(one({"m": 3, "a": "2*m"})) == 6.0
    assert length_of(one({"m": 3, "a": "2 m"})) == 2.0


def test_names_are_no_parameters() -> None:
    assert "let" not in one({"a": 2}).canonical()
    assert one({"a": 2}).canonical() == one({"a": 2, "unused": 7}).canonical()


# [let], and all that is told: key and words
WRONG: dict[str, tuple[object, dict[str, str]]] = {
    "no table": (5, {"let": "found 5, expected a table of names and numbers; write [let]"}),
    "a ring": (
        {"a": "b + 1", "b": "2*c", "c": "a", "d": "a"},
        {"let.a": "which needs its own value (a -> b -> c -> a), expected a number"},
    ),
    "itself": ({"a": "a + 1"}, {"let.a": "which needs its own value (a -> a)"}),
    "two rings": (
        {"a": "b", "b": "a", "c": "c*2"},
        {"let.a": "(a -> b -> a)", "let.c": "(c -> c)"},
    ),
    "unknown names": (
        {"a": "2*rho*l", "lenght": 3},
        {"let.a": "rho and l are not known here; the names are pi, a and lenght; write a number without quotes"},
    ),
    "a name that is like another": ({"a": "2*lenght", "length": 3}, {"let.a": 'write "length"'}),
    "division by zero": ({"a": "1/b", "b": "c - c", "c": 2}, {"let.a": "it divides by zero"}),
    "a root of less than zero": ({"a": "sqrt(0-1)"}, {"let.a": "as a root of a negative number has none"}),
    "too large": ({"a": "10**b", "b": 400}, {"let.a": "it has no finite value, because it is too large"}),
    "infinite": ({"a": math.inf}, {"let.a": "found inf, expected a number, or a text"}),
    "a whole number beyond doubles": ({"a": 10**400}, {"let.a": "found a number of 401 digits"}),
    "neither number nor text": ({"a": [1], "b": True}, {"let.a": "found [1], ", "let.b": "found true, "}),
    "a unit that is none": ({"a": "2 furlong"}, {"let.a": '"furlong" is no unit that is known'}),
    "names that mean something": (
        {"a": 1, "pi": 3, "t": 2, "sin": 1},
        dict.fromkeys(("let.pi", "let.t", "let.sin"), "expected a name that means nothing else in expressions"),
    ),
    "a word of Python's": ({"a": 1, "lambda": 3}, {"let.lambda": "a name that is no word of Python's own"}),
    "no name": ({"a": 1, "2b": 3, "b-c": 1}, dict.fromkeys(("let.2b", "let.b-c"), "expected letters, digits and _")),
    "a sum of a length and a mass": ({"a": "b + c", "b": "1 m", "c": "1 kg"}, {"let.a": "adds a mass and a length"}),
    "the time": ({"a": "2*t"}, {"let.a": "t is the time, and this is a number that stays"}),
    "too many": ({f"a{k}": k for k in range(501)} | {"a": 1}, {"let": "found 502 names, expected at most 500"}),
}  # fmt: skip


@pytest.mark.parametrize("case", WRONG)
def test_wrong_names(case: str) -> None:
    """What is wrong is told where it stands, not where it is used."""
    let, told = WRONG[case]
    with pytest.raises(SceneError) as caught:
        one(let, "a" if isinstance(let, dict) else 1)  # type: ignore[arg-type]
    assert {fault.key for fault in caught.value.faults} == told.keys()
    for fault in caught.value.faults:
        assert told[fault.key] in fault.message


def test_all_faults_at_once() -> None:
    """What is wrong in [let] hides nothing else, and what hangs on it is not told."""
    with pytest.raises(SceneError) as caught:
        chain(
            3,
            True,
            let={"a": "2*roh", "b": "sqrt(-4)", "c": "1 m"},
            chain={"length": ["a", "b", "2*x"], "mass": "c"},
            start={"angles": ["a", "b"]},
            motor=[{"joint": "nix", "torque": "a*sin(y*t)"}],
        )
    told = {fault.key: fault.message for fault in caught.value.faults}
    assert told.keys() == {
        "let.a", "let.b", "chain.length[2]", "chain.mass", "start.angles", "motor[0].joint", "motor[0].torque",
    }  # fmt: skip
    assert "x is not known here" in told["chain.length[2]"] and "that is a length, not a mass" in told["chain.mass"]


@pytest.mark.parametrize("name", ["variables", "constants", "parameters", "define"])
def test_other_names_for_let(name: str, tmp_path: Path) -> None:
    """One sentence, and none about what stands in it."""
    with pytest.raises(SceneError) as caught:
        read(WORDS.replace("[let]", f"[{name}]"), tmp_path)
    (fault,) = caught.value.faults
    assert (fault.line, fault.key) == (3, name)
    assert fault.message == f"found [{name}], expected names of numbers in [let]; write [let]"


def test_angles_without_a_unit_are_remarked_on() -> None:
    """Where the number has none either: it may be meant in degrees."""
    tables = tomllib.loads('[chain]\nlinks = 4\n[start]\nangles = ["a", "b", "2*c", "4*pi"]\n')
    tables["let"] = {"a": 90, "b": "400 deg", "c": "2*pi"}
    assert read_tables(tables, "file", "name").remarks == (
        'file: start.angles[0]: "a", 90, is taken as rad, 14.3 turns; write "90 deg" for degrees',
    )
