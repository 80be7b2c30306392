"""Parts that are written once and placed: what comes out is what a hand would write, and wrong ones are told."""

from __future__ import annotations

import contextlib
import copy
import math
import random
import tomllib
from pathlib import Path
from typing import Any

import pytest

from ccgen.generator import SceneError, load_scene
from ccgen.generator.effects import REGISTRY
from ccgen.generator.pipeline import listing
from ccgen.generator.scene import read_tables
from ccgen.generator.scene.errors import Report
from ccgen.generator.scene.locate import locate
from ccgen.generator.scene.placing import place_parts

from ..support.folders import ROOT, SCENES
from ..support.legs import LEG, PLACES

BY_HAND = ROOT / "tests" / "oracles" / "strandbeest-by-hand.toml"


def placed(text: str) -> dict[str, Any]:
    report = Report("")
    tables = place_parts(tomllib.loads(text), report)[0]
    report.stop_if_any()
    return dict(tables)


def faults(text: str) -> list[tuple[int | None, str, str]]:
    with pytest.raises(SceneError) as caught:
        read_tables(tomllib.loads(text), "legs.toml", "legs", locate(text))
    return [(fault.line, fault.key, fault.message) for fault in caught.value.faults]


def line_of(text: str, part: str) -> int:
    return text[: text.index(part)].count("\n") + 1


def test_as_a_hand_would_write_it() -> None:
    """Every number of the two legs, the second mirrored, turned by a right angle and of another length."""
    found = placed(LEG + PLACES)
    assert "part" not in found and "place" not in found
    assert found["let"] == {
        **{"l": "40 cm", "rho": 2},
        **{"l_left": 0.5, "w_left": "l_left/4", "l_right": "2*l", "w_right": "l_right/4"},
    }
    left, shin, mirrored, other = found["link"]
    assert left == {
        "name": "thigh_left",
        "mass": "rho*l_left",
        "inertia": 0.01,
        "com": ["l_left/2", "w_left"],
        "points": {"A": [0, 0], "B": ["l_left", "w_left"]},
    }
    assert shin["points"] == {"A": [0, 0], "F": [0.3, 0.1]}
    assert mirrored["com"] == ["l_right/2", "-(w_right)"]
    assert mirrored["points"]["B"] == ["l_right", "-(w_right)"]
    assert other["rod"] == {"mass": "300 g", "between": ["A", [0.1, -0.2]]}
    assert [joint["name"] for joint in found["joint"]] == ["top_left", "knee_left", "top_right", "knee_right"]
    assert [joint["between"] for joint in found["joint"]] == [
        ["ground.O", "thigh_left.A"],
        ["thigh_left.B", "shin_left.A"],
        ["thigh_left.B", "thigh_right.A"],
        ["thigh_right.B", "shin_right.A"],
    ]
    tendon, top, mirrored_tendon, mirrored_top = found["torsion"]
    assert tendon == {"name": "tendon_left", "joint": "knee_left", "stiffness": 4, "angle": "30 deg"}
    assert mirrored_tendon["angle"] == pytest.approx(-math.pi / 6, abs=1e-16)
    assert (top["angle"], mirrored_top["angle"]) == (0.2, pytest.approx(1.5 * math.pi - 0.2, abs=1e-15))
    assert found["stop"][0]["lowest"] == "-20 deg" and found["stop"][0]["highest"] == "1 + w_left"
    assert found["stop"][1]["lowest"] == "-(1 + w_right)"
    assert found["stop"][1]["highest"] == pytest.approx(math.pi / 9, abs=1e-16)
    assert found["spring"][1] == {"between": ["top_right", "shin_right.F"], "stiffness": "100*w_right"}
    angles = found["start"]["angles"]
    assert {name: angles[name] for name in ("thigh_left", "shin_left")} == {"thigh_left": "-80 deg", "shin_left": -1.2}
    turned = 1.5 * math.pi
    assert angles["thigh_right"] == pytest.approx(turned + math.radians(80), abs=1e-15)
    assert angles["shin_right"] == pytest.approx(turned + 1.1, abs=1e-15)
    assert found["start"]["angular_velocities"] == {"thigh_left": 2, "thigh_right": -2}


def test_a_scene_of_parts_is_a_scene() -> None:
    text = LEG + PLACES
    by_hand = load_scene(placed(text))
    scene = load_scene(tomllib.loads(text))
    assert scene.canonical() == by_hand.canonical() and listing(scene) == listing(by_hand)
    assert scene.to_dict() == tomllib.loads(text)
    assert tomllib.loads(scene.to_toml()) == tomllib.loads(text)


@pytest.mark.slow
def test_a_machine_of_parts_is_that_by_hand() -> None:
    """The strandbeest: the same equations, byte for byte, from the file that had every leg; starts to rounding."""
    scene, by_hand = load_scene(SCENES / "strandbeest.toml"), load_scene(BY_HAND)
    assert scene.mechanism == by_hand.mechanism
    assert listing(scene) == listing(by_hand)
    size = max(abs(value) for pose in by_hand.start.poses for value in pose[:2])
    for pose, other in zip(scene.start.poses, by_hand.start.poses, strict=True):
        assert math.dist(pose[:2], other[:2]) <= 1e-13 * size
        assert abs(math.remainder(pose[2] - other[2], 2 * math.pi)) <= 1e-13


def test_parts_in_parts() -> None:
    text = """
    [ground_link]
    points = { O = [0, 0] }
    [[part]]
    name = "foot"
    ports = ["ankle"]
    let = { size = 1 }
    [[part.link]]
    name = "sole"
    rod = { mass = 1 }
    points = { A = [0, 0], B = ["size", 0.1] }
    [[part.joint]]
    name = "ankle_pin"
    between = ["ankle", "sole.A"]
    [[part]]
    name = "leg"
    ports = ["hip"]
    let = { s = 2, turn = "10 deg" }
    [[part.link]]
    name = "bone"
    rod = { mass = 1 }
    points = { A = [0, 0], B = [1, 0] }
    [[part.joint]]
    name = "hip_pin"
    between = ["hip", "bone.A"]
    [[part.place]]
    part = "foot"
    name = "front"
    mirror = true
    ports = { ankle = "bone.B" }
    let = { size = "3*s" }
    [[part.place]]
    part = "foot"
    name = "stump"
    angle = "turn"
    ports = { ankle = "hip" }
    [[place]]
    part = "leg"
    name = "a"
    mirror = true
    ports = { hip = "ground.O" }
    [[place]]
    part = "leg"
    name = "b"
    let = { s = 5 }
    ports = { hip = "bone_a.B" }
    """
    found = placed(text)
    names = [f"{name}_{leg}" for leg in "ab" for name in ("bone", "sole_front", "sole_stump")]
    assert [link["name"] for link in found["link"]] == names
    lengths = {link["name"]: link["points"]["B"] for link in found["link"]}
    assert lengths["sole_front_a"] == ["size_front_a", 0.1] and lengths["sole_front_b"] == ["size_front_b", -0.1]
    assert lengths["sole_stump_a"] == ["size_stump_a", -0.1]
    assert found["let"]["size_front_a"] == "3*s_a" and found["let"]["s_b"] == 5 and found["let"]["size_stump_b"] == 1
    between = {joint["name"]: joint["between"] for joint in found["joint"]}
    assert between["ankle_pin_front_b"] == ["bone_b.B", "sole_front_b.A"]
    assert between["ankle_pin_stump_a"] == ["ground.O", "sole_stump_a.A"]
    assert between["ankle_pin_stump_b"] == ["bone_a.B", "sole_stump_b.A"]
    scene = load_scene(found)
    lengths_found = [link.points["B"].values()[0] for link in scene.mechanism.links]
    assert lengths_found == [1, 6, 1, 1, 15, 1]


def test_scenes_without_parts_are_not_touched() -> None:
    tables = tomllib.loads(LEG.partition("[[part]]")[0])
    assert place_parts(tables, Report(""))[0] is tables


def test_every_effect_says_what_a_mirror_makes_of_it() -> None:
    """A new effect may leave that open; then it cannot be in a part that is turned, which is told."""
    for entry in REGISTRY:
        if entry.many:
            assert entry.turned is not None, entry.key
            assert entry.turned.keys() <= entry.table.model_fields.keys()


def test_an_effect_that_does_not_say_is_refused_in_a_mirror(monkeypatch: pytest.MonkeyPatch) -> None:
    from ccgen.generator.scene import placing

    entry = placing.EFFECTS["spring"]
    silent = type(entry)(entry.key, entry.many, entry.table, entry.build)
    monkeypatch.setattr(placing, "EFFECTS", {**placing.EFFECTS, "spring": silent})
    found = faults(LEG + PLACES)
    assert [(key, message[:40]) for _, key, message in found] == [
        ("place[1].mirror", "found a part with a [[spring]], of which")
    ]


# -- wrong ones --------------------------------------------------------------------------------------------------------


def test_faults_stand_in_the_part_and_are_told_once() -> None:
    text = LEG.replace("inertia = 0.01", "inertia = -1") + PLACES
    assert [(line, key) for line, key, _ in faults(text)] == [
        (line_of(text, "inertia = -1"), "part[0].link[0].inertia")
    ]


def test_faults_of_names_of_numbers_stand_where_they_are_given() -> None:
    text = LEG.replace('w = "l/4"', 'w = "l/0"') + PLACES.replace('l = "2*l"', 'l = "2*k"')
    assert [(line, key) for line, key, _ in faults(text)] == [
        (line_of(text, 'let = { l = 0.5, w = "l/0" }'), "part[0].let.w"),
        (line_of(text, 'let = { l = "2*k" }'), "place[1].let.l"),
    ]


def test_faults_of_ports_stand_in_the_place() -> None:
    text = LEG + PLACES.replace('"thigh_left.B"', '"thigh_left.C"')
    ((line, key, message),) = faults(text)
    assert (line, key) == (line_of(text, "thigh_left.C"), "place[1].ports.hip")
    assert message.startswith('found "thigh_left.C", expected a point of thigh_left: A, B')


WRONG = {
    "unknown part": ('part = "leg"\nname = "right"', 'part = "lag"\nname = "right"', "place[1].part", "one of leg"),
    "no port": (
        'ports = { hip = "thigh_left.B" }',
        "",
        "place[1].ports.hip",
        "missing, expected a point for every port",
    ),
    "unknown port": ('{ hip = "ground.O" }', '{ hip = "ground.O", hop = "x.y" }', "place[0].ports.hop", "one of hip"),
    "unknown name": ('{ l = "2*l" }', "{ k = 3 }", "place[1].let.k", "found k, which leg does not have"),
    "two parts": ("[[place]]", '[[part]]\nname = "leg"\n[[place]]', "part[1].name", "a second time"),
    "a port named as a joint": (
        'name = "top"',
        'name = "hip"',
        "part[0].ports[0]",
        '"hip", which is a joint of the part',
    ),
    "a port named as a link": (
        'ports = ["hip"]',
        'ports = ["hip", "shin"]',
        "part[0].ports[1]",
        'found "shin", which is a link of the part too, expected a name of its own; rename one',
    ),
    "a port twice": ('ports = ["hip"]', 'ports = ["hip", "hip"]', "part[0].ports[1]", "which is a port of the part"),
    "key of a part": ('ports = ["hip"]', 'ports = ["hip"]\nlinks = 3', "part[0].links", "place; remove it"),
    "rows of a part": ('ports = ["hip"]', 'ports = ["hip"]\nlinks = [{ name = "a" }]', "part[0].links", 'write "link"'),
    "a gravity": ("[part.start]", "[part.gravity]\n[part.start]", "part[0].gravity", "found an unknown key"),
    "a height": ("[part.start]", "[part.start]\nheight = 1", "part[0].start.height", "write it in [start]"),
    "unknown link": ("angles = { thigh", "angles = { thing", "part[0].start.angles.thing", "one of thigh, shin"),
    "in a place": ("angles = { shin = -1.1", "angles = { chin = -1.1", "place[1].start.angles.chin", "of thigh, shin"),
    "a mirror": ("mirror = true", "mirror = 1", "place[1].mirror", "true or false"),
    "a wrong turn": ('angle = "90 deg"', 'angle = "90 cm"', "place[1].angle", "that is a length, not an angle"),
    "itself": (
        "[part.start]",
        '[[part.place]]\npart = "leg"\nname = "x"\n[part.start]',
        "part[0].place[0].part",
        "leg in leg",
    ),
    "a word": ("let = { l = 0.5", "let = { lambda = 0.5", "part[0].let.lambda", "no word of Python's own"),
    "the same name": ('name = "right"', 'name = "left"', "part[0].link[0].name", '"thigh_left" a second time'),
}


@pytest.mark.parametrize("case", WRONG)
def test_wrong_parts_and_places(case: str) -> None:
    old, new, key, sentence = WRONG[case]
    text = LEG + PLACES
    assert old in text
    text = text.replace(old, new, 1)
    found = [(one, message) for _, one, message in faults(text)]
    assert [message for one, message in found if one == key and sentence in message], found
    assert all(line is not None for line, _, _ in faults(text))


def test_a_part_itself_is_one_of_several() -> None:
    path_free = LEG.replace("[[part]]", "[part]").split("[[part.link]]")[0]
    ((_, key, message), *_) = faults(path_free + "[[link]]\nrod = { mass = 1 }\npoints = { A = [0, 0], B = [1, 0] }\n")
    assert key == "part" and "expected an array of tables; write [[part]]" in message


def test_what_else_is_wrong_is_told_with_faults_of_parts() -> None:
    text = LEG + PLACES.replace('part = "leg"', 'part = "lag"') + "\n[run]\nuntil = -1\n[gravty]\n"
    assert [key for _, key, _ in faults(text)] == ["place[0].part", "place[1].part", "run.until", "gravty"]


def test_parts_that_stand_nowhere_are_remarked_on() -> None:
    text = LEG.replace("[[part]]", '[[part]]\nname = "arm"\n[[part]]', 1) + PLACES
    scene = read_tables(tomllib.loads(text), "legs.toml", "legs", locate(text))
    assert scene.remarks == ("legs.toml:10: part[0]: arm stands nowhere, because no [[place]] names it",)


@pytest.mark.hard
def test_too_many_places_are_refused_soon() -> None:
    """Thirty parts, each twice in the next, would be a thousand million."""
    parts: list[dict[str, Any]] = [{"name": "p0", "link": [{"name": "a"}]}]
    for k in range(1, 31):
        parts.append({"name": f"p{k}", "place": [{"part": f"p{k - 1}", "name": name} for name in "ab"]})
    with pytest.raises(SceneError, match="found parts of more than 20000 tables in all their places"):
        load_scene({"part": parts, "place": [{"part": "p30", "name": "x"}]})


def test_angles_by_number_cannot_be_added_to() -> None:
    text = LEG + PLACES + "\n[start]\nangles = [0, 0, 0, 0]\n"
    found = [(key, message) for _, key, message in faults(text)]
    assert {key for key, _ in found} == {
        "part[0].start.angles.thigh",
        "part[0].start.angles.shin",
        "place[1].start.angles.shin",
    }
    assert all("expected a table, which this is added to" in message for _, message in found)


def test_scene_files_tell_single_headers(tmp_path: Path) -> None:
    path = tmp_path / "legs.toml"
    path.write_text('[part]\nname = "a"\n[part]\nname = "b"\n')
    with pytest.raises(SceneError, match=r"found \[part\], expected \[\[part\]\]"):
        load_scene(path)


JUNK: list[Any] = [
    *(3, -1.5, "x", "2*l", "20 cm", True, [], {}, [1, 2], [[1]], {"a": 1}, "leg", "hip", "thigh.A", "a.b.c", "lambda"),
    *(math.nan, 10**50, "", ["hip"], [{}], [1, "x"]),
]


@pytest.mark.parametrize("seed", range(60))
def test_whatever_stands_in_parts_is_read_or_refused(seed: int) -> None:
    """One to three values replaced, left out or added, anywhere."""
    draw = random.Random(seed)
    tables = tomllib.loads(LEG + PLACES)
    for _ in range(draw.choice((1, 1, 2, 3))):
        node = tables
        while True:
            keys = [*node] if isinstance(node, dict) else [*range(len(node))]
            key = draw.choice(keys) if keys else None
            inside = node[key] if key is not None else None
            if not isinstance(inside, dict | list) or not inside or draw.random() < 0.3:
                break
            node = inside
        if key is not None and draw.random() < 0.2:
            del node[key]
        elif key is not None and draw.random() < 0.8:
            node[key] = copy.deepcopy(draw.choice(JUNK))
        elif isinstance(node, dict):
            node[draw.choice(["foo", "name", "mirror", "angle", "axis", "type"])] = copy.deepcopy(draw.choice(JUNK))
    with contextlib.suppress(SceneError):
        load_scene(tables)
