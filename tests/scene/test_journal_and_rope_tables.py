"""What is wrong in a ``[[journal]]`` or a ``[[rope]]``: every fault with its key, what was found, and what to do."""

from __future__ import annotations

import pytest

from ccgen.generator.effects.rope import Rope
from ccgen.generator.scene import SceneError

from ..support.workshop import Workshop

LINKS = """
[ground_link]
points = { O = [0, 0], P = [0, 2], Q = [1, 2] }
[[link]]
name = "arm"
mass = 1.0
inertia = 0.1
com = [0.5, 0]
points = { A = [0, 0], B = [1, 0] }
[[link]]
name = "rod"
mass = 1.0
inertia = 0.1
com = [0.5, 0]
points = { A = [0, 0], B = [1, 0], C = [0.5, 0.1] }
[[joint]]
name = "hook"
between = ["ground.O", "arm.A"]
[[joint]]
name = "knee"
between = ["arm.B", "rod.A"]
[start]
angles = { arm = 0.0, rod = 0.0 }
"""
JOURNAL = LINKS + (
    '[[journal]]\nbetween = ["rod.B", ["ground.O", "ground.Q"]]\nradius = 0.1\nclearance = 2.0\nrestitution = 0.5\n'
)
ROPE = LINKS + '[[rope]]\nbetween = ["ground.O", "rod.B"]\nover = ["ground.P"]\nlength = 5.0\nrestitution = 0.5\n'
SIDES = 'between = ["rod.B", ["ground.O", "ground.Q"]]'
ENDS = 'between = ["ground.O", "rod.B"]'
OVER = 'over = ["ground.P"]'
BAD: dict[str, tuple[str, str, str, str, tuple[str, ...]]] = {
    "no such pin": (
        JOURNAL,
        SIDES,
        'between = ["rod.X", "ground.Q"]',
        "journal[0].between[0]",
        ("journal's", "A, B, C"),
    ),
    "no such bearing": (JOURNAL, SIDES, 'between = ["rod.B", "ground.X"]', "journal[0].between[1]", ("two points",)),
    "a slot first": (
        JOURNAL,
        SIDES,
        'between = [["ground.O", "ground.Q"], "rod.B"]',
        "journal[0].between[0]",
        ("second place",),
    ),
    "one link": (JOURNAL, SIDES, 'between = ["rod.B", "rod.A"]', "journal[0].between", ("two places on rod",)),
    "a pin of both": (JOURNAL, SIDES, 'between = ["knee", "rod.C"]', "journal[0].between", ("two places on rod",)),
    "a slot of two links": (
        JOURNAL,
        SIDES,
        'between = ["rod.B", ["ground.O", "arm.A"]]',
        "journal[0].between[1]",
        ("they are on different links",),
    ),
    "a slot without length": (
        JOURNAL,
        SIDES,
        'between = ["rod.B", ["ground.O", "ground.O"]]',
        "journal[0].between[1]",
        ("at the same place",),
    ),
    "whose bearing": (
        JOURNAL,
        SIDES,
        'between = ["ground.Q", "knee"]',
        "journal[0].between[1]",
        ("a pin of arm and rod", 'write "arm.B" or "rod.A"'),
    ),
    "no clearance": (JOURNAL, "clearance = 2.0\n", "", "journal[0].clearance", ("missing", "add it")),
    "clearance zero": (JOURNAL, "clearance = 2.0", "clearance = 0", "journal[0].clearance", ("found 0", "positive")),
    "a bearing too small": (
        JOURNAL,
        "clearance = 2.0",
        'clearance = "0.1 - 0.2"',
        "journal[0].clearance",
        ('"0.1 - 0.2" (-0.1)', "positive"),
    ),
    "another unit": (JOURNAL, "clearance = 2.0", 'clearance = "2 kg"', "journal[0].clearance", ("kg",)),
    "negative radius": (JOURNAL, "radius = 0.1", "radius = -0.1", "journal[0].radius", ("found -0.1",)),
    "restitution of a journal": (JOURNAL, "restitution = 0.5", "restitution = 2", "journal[0].restitution", ("to 1",)),
    "friction": (JOURNAL, "radius = 0.1", "radius = 0.1\nfriction = -1", "journal[0].friction", ("positive",)),
    "start outside": (
        JOURNAL,
        "clearance = 2.0",
        "clearance = 0.5",
        "journal[0]",
        ("rod.B 1.78885 m from the middle line of ground.O-ground.Q", "at most the clearance, 0.5 m", "widen"),
    ),
    "start outside a bearing": (
        JOURNAL,
        SIDES,
        'between = ["rod.B", "ground.P"]',
        "journal[0]",
        ("rod.B 2.82843 m from the middle, ground.P", "at most the clearance"),
    ),
    "no such end": (ROPE, ENDS, 'between = ["ground.O", "rod.X"]', "rope[0].between[1]", ('"rod.X"', "A, B, C")),
    "no such eyelet": (ROPE, OVER, 'over = ["ground.P", "eye"]', "rope[0].over[1]", ('"eye"', "the joints are hook")),
    "one end": (ROPE, ENDS, 'between = ["rod.B"]', "rope[0].between", ("write 2 values",)),
    "three ends": (ROPE, ENDS, 'between = ["rod.B", "rod.A", "arm.A"]', "rope[0].between", ("write 2 values",)),
    "twice": (ROPE, OVER, 'over = ["ground.P", "ground.P"]', "rope[0].over[1]", ("twice in a row", "remove one")),
    "eyelet at the end": (ROPE, OVER, 'over = ["rod.B"]', "rope[0].between[1]", ("twice in a row",)),
    "a rope on one link": (
        ROPE,
        f"{ENDS}\n{OVER}",
        'between = ["rod.B", "rod.C"]\nover = ["knee"]',
        "rope[0].between",
        ('"rod.B", "knee", "rod.C"', "neighbours all on one link", "change one"),
    ),
    "length zero": (ROPE, "length = 5.0", "length = 0", "rope[0].length", ("found 0", "positive")),
    "no restitution": (ROPE, "restitution = 0.5", "", "rope[0].restitution", ("missing",)),
    "law": (ROPE, "length = 5.0", 'length = 5.0\nlaw = "hooke"', "rope[0].law", ("newton, poisson",)),
    "friction of a rope": (ROPE, "length = 5.0", "length = 5.0\nfriction = 1", "rope[0].friction", ("unknown key",)),
    "too short": (
        ROPE,
        "length = 5.0",
        "length = 4.5",
        "rope[0]",
        ("4.82843 m along ground.O - ground.P - rod.B", "at most the length of rope_0, 4.5 m", "make it longer"),
    ),
    "ends meet": (
        ROPE,
        f"{ENDS}\n{OVER}\nlength = 5.0",
        'between = ["ground.O", "arm.A"]',
        "rope[0]",
        ("ground.O and arm.A at the same place", "expected a length of rope_0 beside that; add length"),
    ),
    "a piece without length": (
        ROPE.replace("O = [0, 0],", "O = [0, 0], R = [2, 0],"),
        OVER,
        'over = ["ground.R"]',
        "rope[0]",
        ("ground.R and rod.B at the same place", "has no direction"),
    ),
    "no length at the start": (
        ROPE.replace("O = [0, 0],", "O = [0, 0], R = [2, 0],"),
        f"{ENDS}\n{OVER}\nlength = 5.0",
        'between = ["ground.R", "rod.B"]',
        "rope[0]",
        ("ground.R and rod.B at the same place", "expected a length of rope_0 beside that; add length"),
    ),
}


@pytest.mark.parametrize("case", BAD, ids=lambda case: case.replace(" ", "-"))
def test_faults_name_key_and_advice(case: str, workshop: Workshop) -> None:
    text, old, new, key, words = BAD[case]
    assert old in text
    with pytest.raises(SceneError) as caught:
        workshop.scene(text.replace(old, new))
    (fault,) = caught.value.faults
    assert f" {key}: " in f" {fault}" and all(word in str(fault) for word in words), str(fault)


def test_all_faults_at_once(workshop: Workshop) -> None:
    wrong = JOURNAL.replace(SIDES, 'between = ["rod.X", "ground.X"]').replace("clearance = 2.0", "clearance = -1")
    wrong += '[[rope]]\nbetween = ["rod.Y", "ground.O"]\nover = ["knie"]\nrestitution = -1\n'
    with pytest.raises(SceneError) as caught:
        workshop.scene(wrong)
    assert [fault.key for fault in caught.value.faults] == [
        "journal[0].between[0]",
        "journal[0].between[1]",
        "journal[0].clearance",
        "rope[0].between[0]",
        "rope[0].over[0]",
        "rope[0].restitution",
    ]


def test_a_length_is_taken_from_the_start_as_it_is_assembled(workshop: Workshop) -> None:
    """To twelve digits, so that every machine takes the same; the scene is known by it."""
    text = ROPE.replace("length = 5.0\n", "").replace("rod = 0.0", "rod = 1.0")
    scene = workshop.scene(text)
    (rope,) = scene.effects
    assert isinstance(rope, Rope) and rope.length
    assert rope.length.value == float(f"{2.0 + abs(1 + complex(0.5403023058681398, 0.8414709848078965) - 2j):.12g}")
    assert scene.canonical() != workshop.scene(text.replace("rod = 1.0", "rod = 1.1")).canonical()
    assert "rope_0.length" in [parameter.path for parameter in rope.parameters()]
