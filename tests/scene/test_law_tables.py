"""Faults of laws and of expressions of the state, each told in a sentence, with its key and what to write instead."""

from __future__ import annotations

import pytest

from ccgen.generator import SceneError
from ccgen.generator.documents.show import show_text
from ccgen.generator.pipeline import listing
from ccgen.generator.scene import load_scene
from ccgen.generator.scene.states import DEEPEST
from ccgen.runtime import simulate

from ..support.workshop import Workshop

SCENE = """
name = "arm"
[let]
length = 0.5
[ground_link]
points = { O = [0, 0], R = [0, -1] }
[[link]]
name = "rod"
rod = { mass = 1 }
points = { A = [0, 0], B = ["length", 0] }
[[link]]
name = "car"
rod = { mass = 1, between = ["A", "B"] }
points = { A = [0, 0], B = [0.1, 0] }
[[joint]]
name = "hip"
between = ["ground.O", "rod.A"]
[[joint]]
name = "rail"
type = "prismatic"
between = ["ground.R", "car.A"]
axis = [1, 0]
"""
FREE = '[[motor]]\njoint = "hip"\ntorque = "?"\n'
NAMED = '[[law]]\nname = "lift"\nvalue = "-kp*angle(hip)"\nparameters = { kp = 3 }\n'


CURVED = """
[[law]]
name = "lift"
value = "gas(slide(rail))"
curves = { gas = { rows = [[0, 0], [1, 2]], order = 1 } }
"""


def law(value: str, parameters: str = "", name: str = "lift", more: str = "") -> str:
    return f'[[law]]\nname = "{name}"\nvalue = "{value}"\nparameters = {{ {parameters} }}\n{more}'


def load(value: str) -> str:
    return FREE.replace("?", value)


WRONG: dict[str, tuple[str, str, str]] = {
    "a name that is not known": (load("k*angle(hip)"), "motor[0].torque", "k is not known here; the quantities are t"),
    "a joint that is not there": (load("angle(hop)"), "motor[0].torque", "hop in angle(...) is no joint"),
    "a link for a joint": (load("angle(rod)"), "motor[0].torque", "write direction(rod) for the angle of that link"),
    "a point that is not there": (
        load("y(rod.C)"),
        "motor[0].torque",
        "rod.C in y(...) is no point",
    ),
    "an angle of what slides": (load("angle(rail)"), "motor[0].torque", "rail in angle(...) does not turn"),
    "a length of what turns": (load("slide(hip)"), "motor[0].torque", "hip in slide(...) does not slide"),
    "too many arguments": (load("x(rod.B, rod.A)"), "motor[0].torque", "x(...) is of a point; the quantities"),
    "too few arguments": (load("distance(rod.B)"), "motor[0].torque", "distance(...) is of a point and a point"),
    "one of a least": (load("min(angle(hip))"), "motor[0].torque", "min(...) is of two or more"),
    "two of a clip": (load("clip(angle(hip), 1)"), "motor[0].torque", "clip(...) takes three arguments"),
    "a clip upside down": (load("clip(angle(hip), 1, -1)"), "motor[0].torque", "a least that is not below the most"),
    "a rate of a rate": (load("rate(rate(hip))"), "motor[0].torque", "rate(...) is of one quantity alone"),
    "a rate of a law": (NAMED + load("rate(lift)"), "motor[0].torque", "rate(lift) can have accelerations in it"),
    "an acceleration": (load("acceleration(hip)"), "motor[0].torque", "the load would hang on itself"),
    "a force": (load("-0.1*force(hip)"), "motor[0].torque", "write positions and rates, or the law of that force"),
    "a sign": (load("-sign(rate(hip))"), "motor[0].torque", "jumps, which no load may; write tanh(x/w)"),
    "a comparison": (
        load("angle(hip) > 0"),
        "motor[0].torque",
        "write min(...), max(...) or clip(...)",
    ),
    "a choice": (load("1 if t > angle(hip) else 0"), "motor[0].torque", "write min(...), max(...) or clip(...)"),
    "an angle that jumps": (load("atan2(y(rod.B), x(rod.B))"), "motor[0].torque", "jumps by a turn"),
    "a power that is no number": (load("angle(hip)**0.5"), "motor[0].torque", "exponents are whole numbers"),
    "a parameter as a power": (law("angle(hip)**n", "n = 2"), "law[0].value", "exponents are whole numbers"),
    "what divides by zero": (
        load("1/(angle(hip) - angle(hip))"),
        "motor[0].torque",
        "by what is always zero",
    ),
    "a function that is not known": (load("sinh(angle(hip))"), "motor[0].torque", "sinh(...) is not known here"),
    "a prescribed motion": (
        '[[drive]]\njoint = "hip"\nspeed = "-angle(rod)"\n',
        "drive[0].speed",
        "it has angle(...), which is of the state, and what is prescribed or wanted is a function of the time alone; "
        "write a [[motor]] with a torque or a force of the state",
    ),
    "a prescribed motion by a law": (
        NAMED + '[[drive]]\njoint = "hip"\nangle = "t + lift"\n',
        "drive[0].angle",
        "it has lift, which is of the state",
    ),
    "a wanted angle": (
        '[[motor]]\njoint = "hip"\nangle = "slide(rail)"\nstiffness = 3\n',
        "motor[0].angle",
        "what is prescribed or wanted is a function of the time alone",
    ),
    "a law that needs itself": (law("2*lift"), "law[0].value", "needs its own value (lift -> lift)"),
    "laws in a ring": (
        law("2*drop") + law("t + hold", name="drop") + law("abs(lift)", name="hold"),
        "law[0].value",
        "needs its own value (lift -> drop -> hold -> lift), expected laws that do not; take it out of one of them",
    ),
    "a parameter that is no number": (
        law("kp*t", "kp = true"),
        "law[0].parameters.kp",
        "found true, expected",
    ),
    "a parameter that is not used": (
        law("kp*t", "kp = 1, kd = 2"),
        "law[0].parameters.kd",
        "value does not have",
    ),
    "a parameter that means something": (law("angle(hip)*t", "t = 1"), "law[0].parameters.t", "means nothing else"),
    "a parameter as a quantity": (law("slide*2", "slide = 1"), "law[0].parameters.slide", "means nothing else"),
    "a parameter as a number of let": (law("length*t", "length = 1"), "law[0].parameters.length", "none of [let]"),
    "a parameter as a law": (
        NAMED + law("lift", "lift = 1", "b"),
        "law[1].parameters.lift",
        "a name that is no",
    ),
    "a law as a number of let": (law("t", name="length"), "law[0].name", "expected a name that is none of [let]"),
    "a law as a function": (law("t", name="clip"), "law[0].name", "expected a name that means nothing else"),
    "a law as an output": (law("t", name="energy"), "law[0].name", "expected a name that no other output of a run has"),
    "two laws of one name": (NAMED + NAMED, "law[1].name", 'found "lift" a second time'),
    "a law called as a link": (law("t", name="rod"), "law[0].name", 'found "rod" a second time'),
    "a law called as a joint": (law("t", name="rail"), "law[0].name", "expected a name that no joint has; rename it"),
    "a law without a name": ('[[law]]\nvalue = "t"\n', "law[0].name", "missing, expected a name of letters"),
    "a law without a value": (
        '[[law]]\nname = "lift"\n',
        "law[0].value",
        "missing, expected a number or",
    ),
    "a unit that is none": (
        law("t", more='unit = "Nmm"\n'),
        "law[0].unit",
        'found "Nmm", expected',
    ),
    "an equals sign": (law("lift = 2*t"), "law[0].value", "an expression has no = in it"),
    "a curve of a number": (
        CURVED.replace("gas(slide(rail))", "t*gas(2)"),
        "law[0].value",
        "gas(...) is of a number that stays; write what it is there",
    ),
    "a curve of two": (CURVED.replace("gas(slide(rail))", "gas(t, t)"), "law[0].value", "gas(...) takes one argument"),
    "a curve without an argument": (CURVED.replace("gas(slide(rail))", "gas*t"), "law[0].value", "needs an argument"),
    "a curve that is not used": (CURVED.replace("gas(slide(rail))", "t"), "law[0].curves.gas", "value does not have"),
    "a curve called as a function": (CURVED.replace("gas", "exp"), "law[0].curves.exp", "means nothing else"),
    "a curve that goes back": (
        CURVED.replace("[1, 2]", "[-1, 2]"),
        "law[0].curves.gas.rows",
        "row 1 has x = -1 after x = 0",
    ),
    "a curve that comes again": (
        CURVED.replace("order = 1", 'order = 1, ends = "periodic"'),
        "law[0].curves.gas.ends",
        'found "periodic", expected what it does before the first row and after the last, "rest" (stay) or "straight"',
    ),
    "a curve that a load has": (load("gas(angle(hip))"), "motor[0].torque", "gas(...) is not known here"),
    "a law with a slip": (NAMED + load("2*lfit"), "motor[0].torque", "the laws are lift; the quantities are t"),
    "a law with a slip, meant": (NAMED + load("lfit"), "motor[0].torque", 'write "lift"'),
    "a law that is called": (
        NAMED + load("lift(hip)"),
        "motor[0].torque",
        "lift is a law, which is not called; write l",
    ),
    "a law that stays": (
        NAMED + '[[torsion]]\njoint = "hip"\nstiffness = "2*lift"\n',
        "torsion[0].stiffness",
        "lift is a law, which changes with the state, and this is a number that stays; laws stand in loads",
    ),
    "an angle behind a link": (
        load("3*rod.angle"),
        "motor[0].torque",
        "rod.angle is no arithmetic; write direction(rod)",
    ),
    "an angle behind a joint": (law("t*hip.angle"), "law[0].value", "write angle(hip)"),
    "a rate behind a joint": (law("t*hip.angular_velocity"), "law[0].value", "write rate(hip)"),
    "a rate behind a link": (law("t*rod.omega"), "law[0].value", "write rate(direction(rod))"),
    "a length behind a joint": (law("t*rail.slide"), "law[0].value", "write slide(rail)"),
    "a rate of a length behind a joint": (law("t*rail.slide_rate"), "law[0].value", "write rate(slide(rail))"),
    "a point alone": (law("t*rod.B"), "law[0].value", "write x(rod.B) or y(rod.B)"),
    "a coordinate behind a point": (law("t*rod.B.x"), "law[0].value", "write x(rod.B)"),
    "a parameter of another law": (
        NAMED + load("2*kp*angle(hip)"),
        "motor[0].torque",
        "it is a parameter of the law lift, and stands in its value alone",
    ),
    "a parameter of a law behind it": (
        NAMED + load("2*lift.kp"),
        "motor[0].torque",
        "kp is a parameter of the law lift",
    ),
    "a power that is broken": (
        law("p*angle(hip)**1.3", "p = 2"),
        "law[0].value",
        "exponents are whole numbers up to 64; write exp(1.3 * log(angle(hip))) for this power of what is positive",
    ),
    "a unit without its space": (law("t", more='unit = "Nm"\n'), "law[0].unit", 'write "N m"'),
    "a value that cannot be read": (
        law("kp*(angle(hip)", "kp = 2"),
        "law[0].value",
        "it cannot be read, with 2 ( and 1 )",
    ),
    "an event that jumps": ('[[event]]\nwhen = "sign(rate(hip))"\n', "event[0].when", "write what stands in it alone"),
    "an event of a force": (
        '[[event]]\nwhen = "fx(hip) - 3"\n',
        "event[0].when",
        "fx(...) follows from the accelerations, which events do not know; write positions and rates",
    ),
    "a parameter that an event sets without its law": (
        NAMED + '[[event]]\nwhen = "t - 1"\nset = { kp = 2 }\n',
        "event[0].set.kp",
        'expected the path of a parameter, as "lift.kp"',
    ),
    "an event of a law that is not there": (
        '[[event]]\nwhen = "lift - 1"\n',
        "event[0].when",
        "lift is not known here",
    ),
    "a value for a load of the state": (
        load("-3*angle(hip)") + '[[event]]\nwhen = "t - 1"\nset = { "motor_0.torque" = 2 }\n',
        "event[0].set.motor_0.torque",
        "which is given over time, and by the state: -3 * angle(hip)",
    ),
}


@pytest.mark.parametrize("case", WRONG)
def test_what_is_wrong_is_told_in_a_sentence(case: str, workshop: Workshop) -> None:
    text, key, told = WRONG[case]
    with pytest.raises(SceneError) as caught:
        workshop.scene(SCENE + text)
    found = {fault.key: fault.message for fault in caught.value.faults}
    assert told in found[key], found
    assert len(found) == 1, found


def test_a_law_as_a_plain_table_is_known(workshop: Workshop) -> None:
    """What is wrong with the table is not followed by that nobody knows the law."""
    with pytest.raises(SceneError) as caught:
        workshop.scene(SCENE + NAMED.replace("[[law]]", "[law]") + load("lift"))
    assert [fault.key for fault in caught.value.faults] == ["law"]


def test_what_may_be_set_in_place_of_a_load_is_told(workshop: Workshop) -> None:
    model = workshop.model(SCENE + NAMED + load("2*lift") + load("-3*angle(hip)"))
    for path, told in {
        "motor_0.torque": "found a load that the scene gives by the state, expected a parameter; set what its law has, "
        "as lift.kp",
        "motor_1.torque": "give it a [[law]] with parameters in the scene, and set those",
        "kp": "found no such parameter, expected one of the model, as lift.kp; correct the name",
    }.items():
        with pytest.raises(KeyError) as caught:
            simulate(model, params={path: 1.0})
        assert told in str(caught.value)


def test_all_faults_are_told_at_once(workshop: Workshop) -> None:
    text = law("-kp*angle(hop)", "kp = 3, t = 1") + load("lift + foo*rate(hip)") + '[[force]]\npoint = "rod.B"\n'
    text += 'vector = ["sign(x(rod.B))", "angle(hip, hip)"]\n'
    with pytest.raises(SceneError) as caught:
        workshop.scene(SCENE + text)
    keys = {fault.key for fault in caught.value.faults}
    assert keys == {
        "law[0].value",
        "law[0].parameters.t",
        "motor[0].torque",
        "force[0].vector[0]",
        "force[0].vector[1]",
    }


def test_short_forms_are_those_of_events(workshop: Workshop) -> None:
    """``rate`` of a joint, ``vx`` and ``vy``, in loads and in events."""
    short = load("rate(hip) + rate(rail)*vx(rod.B) - vy(car.B)") + '[[event]]\nwhen = "rate(rail) - vy(rod.B)"\n'
    long = short.replace("rate(hip)", "rate(angle(hip))").replace("rate(rail)", "rate(slide(rail))")
    for axis in "xy":
        for point in ("rod.B", "car.B"):
            long = long.replace(f"v{axis}({point})", f"rate({axis}({point}))")
    assert workshop.scene(SCENE + short).canonical() == workshop.scene(SCENE + long).canonical()


def test_a_number_is_a_law(workshop: Workshop) -> None:
    scene = workshop.scene(SCENE + '[[law]]\nname = "push"\nvalue = 3\n' + load("2*push"))
    assert scene.effects[-1].value.text == "3.0"


def test_numbers_of_let_are_numbers_and_units_are_read(workshop: Workshop) -> None:
    text = law("-kp*(angle(hip) - length)", "kp = '2 kN m/rad'")
    scene = workshop.scene(SCENE + text)
    assert scene.effects[0].describe(scene.mechanism) == "-kp * (angle(hip) - 0.5), lift.kp = 2000.0"


def test_show_says_on_what_a_load_depends(workshop: Workshop) -> None:
    text = " ".join(show_text(workshop.scene(SCENE + NAMED + load("lift + 0.1*rate(rail)")), False, False).split())
    assert "lift: -kp * angle(hip), lift.kp = 3.0" in text
    assert "motor_0: motor_0.torque = lift + 0.1 * rate(slide(rail))" in text


def test_scenes_with_laws_go_through_files(workshop: Workshop) -> None:
    scene = workshop.scene(SCENE + NAMED + load("lift"))
    again = load_scene(scene.to_dict())
    assert again.canonical() == scene.canonical()


def chained(count: int) -> str:
    """Laws of which each names the one before twice."""
    rows = [law("t + min(angle(hip), 1)", name="a1")]
    rows += [law(f"0.5*a{k - 1} + max(a{k - 1}, 0)", name=f"a{k}") for k in range(2, count + 1)]
    return "".join(rows)


def test_laws_in_a_row_stand_once_each(workshop: Workshop) -> None:
    """Their equations grow with their number, not with the ways through them."""
    event = f'[[event]]\nwhen = "a{DEEPEST} - 3"\n'
    text = listing(workshop.scene(SCENE + chained(DEEPEST) + load(f"min(a{DEEPEST}, 5)") + event))
    assert len(text.splitlines()) < 700
    with pytest.raises(SceneError, match="found a law behind 20 others that name one another, expected at most 20"):
        workshop.scene(SCENE + chained(DEEPEST + 1))
