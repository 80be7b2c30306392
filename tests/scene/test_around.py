"""Points of a link round a circle, and outlines that a touch names by their link."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from ccgen.generator import Scene, load_scene
from ccgen.generator.pipeline import listing
from ccgen.generator.scene.errors import SceneError

WHEEL: dict[str, Any] = {
    "name": "wheel",
    "mass": 1.0,
    "inertia": 0.1,
    "com": [0, 0],
    "points": {"O": [0, 0], "P": [0.3, 0.1]},
}
TEETH: dict[str, Any] = {"count": 5, "points": {"T": ["20 cm", 0], "R": ["15 cm", "10 deg"]}}
PAWL: dict[str, Any] = {"name": "pawl", "rod": {"mass": 0.1}, "points": {"A": [0, 0], "tip": [0.5, 0]}}
TOUCH = [{"between": ["pawl.tip", "wheel"], "radius": 0.004, "restitution": 0.0}]
AXLES = [{"between": ["ground.O", "wheel.O"]}, {"between": ["ground.Q", "pawl.A"]}]


def tables(wheel: dict[str, Any], **more: Any) -> dict[str, Any]:
    """A wheel and a pawl on axles of their own."""
    ground = {"points": {"O": [0, 0], "Q": [0.0, 0.6]}}
    return {"name": "teeth", "ground_link": ground, "link": [wheel, PAWL], "joint": AXLES, **more}


def places(scene: Scene, link: str = "wheel") -> dict[str, complex]:
    found = next(one for one in scene.mechanism.links if one.name == link)
    return {name: complex(*point.values()) for name, point in found.points.items()}


def faults(wheel: dict[str, Any], **more: Any) -> list[str]:
    with pytest.raises(SceneError) as caught:
        load_scene(tables(wheel, **more))
    return [str(fault) for fault in caught.value.faults]


@pytest.mark.parametrize(("clockwise", "way"), [(False, 1), (True, -1)])
@pytest.mark.parametrize(("centre", "at"), [({}, 0), ({"centre": "P"}, 0.3 + 0.1j), ({"centre": ["1 cm", 0]}, 0.01)])
def test_points_stand_round_a_circle(clockwise: bool, way: int, centre: dict[str, Any], at: complex) -> None:
    scene = load_scene(tables({**WHEEL, "around": {**TEETH, **centre, "clockwise": clockwise}}))
    found = places(scene)
    assert [*found] == ["O", "P", *(f"{name}{k}" for k in range(5) for name in "TR")]
    for k in range(5):
        turn = np.exp(way * 2j * math.pi * k / 5)
        assert found[f"T{k}"] == pytest.approx(at + 0.2 * turn, abs=1e-16)
        assert found[f"R{k}"] == pytest.approx(at + 0.15 * np.exp(1j * math.radians(10)) * turn, abs=1e-16)
    assert scene.mechanism.outlines["wheel"] == tuple(f"{name}{k}" for k in range(5) for name in "TR")


def test_right_angles_are_exact_and_joints_hold_such_points() -> None:
    wheel = {**WHEEL, "around": {"count": 4, "points": {"H": [0.2, 0]}}}
    joints = [*AXLES, {"between": ["wheel.H3", "rod.A"]}]
    rod = {"name": "rod", "rod": {"mass": 1}, "points": {"A": [0, 0], "B": [0.4, 0]}}
    scene = load_scene({**tables(wheel), "link": [wheel, PAWL, rod], "joint": joints})
    assert [places(scene)[f"H{k}"] for k in range(4)] == [0.2, 0.2j, -0.2, -0.2j]
    for quarter in range(1, 101):
        around = {"count": 4 * quarter, "points": {"H": [0.2, 0]}}
        found = places(load_scene(tables({**WHEEL, "around": around})))
        assert [found[f"H{k * quarter}"] for k in range(4)] == [0.2, 0.2j, -0.2, -0.2j]


def test_a_plate_is_the_outline() -> None:
    """A regular polygon of n corners on a circle R has the area n R²/2 sin(2π/n), and about its centre the inertia
    m R²/6 (2 + cos(2π/n))."""
    n, radius = 7, 0.2
    wheel = {"name": "wheel", "plate": {"mass_per_area": 3.0}, "points": {"O": [0, 0]}}
    around = {"count": n, "points": {"C": [radius, 0.4]}}
    link = load_scene(tables({**wheel, "around": around})).mechanism.links[0]
    mass = 3.0 * n * radius**2 / 2 * math.sin(2 * math.pi / n)
    assert link.mass and link.mass.value == pytest.approx(mass, rel=1e-14)
    inertia = mass * radius**2 / 6 * (2 + math.cos(2 * math.pi / n))
    assert link.inertia and link.inertia.value == pytest.approx(inertia, rel=1e-14)


@pytest.mark.parametrize("outline", [{"outline": []}, {"outline": ["C0", "C1"]}])
def test_a_plate_that_is_drawn_otherwise_is_as_heavy(outline: dict[str, Any]) -> None:
    wheel = {"name": "wheel", "plate": {"mass_per_area": 3.0}, "points": {"O": [0, 0]}}
    wheel["around"] = [{"count": 7, "points": {"C": [0.2, 0.4]}}, {"count": 3, "points": {"H": [0.05, 0]}}]
    plain, drawn = (load_scene(tables({**wheel, **more})).mechanism.links[0] for more in ({}, outline))
    assert (plain.mass, plain.inertia, plain.com) == (drawn.mass, drawn.inertia, drawn.com)


def test_several_circles() -> None:
    """The later one about a point of the first."""
    holes = {"count": 3, "points": {"H": [0.05, 0]}, "centre": "T1"}
    scene = load_scene(tables({**WHEEL, "around": [TEETH, holes]}))
    found = places(scene)
    assert found["H0"] == found["T1"] + 0.05 and {"H2", "T4", "R4"} <= found.keys()
    assert len(scene.mechanism.outlines["wheel"]) == 10


def test_an_outline_of_its_own_is_kept() -> None:
    scene = load_scene(tables({**WHEEL, "around": TEETH, "outline": ["T0", "T2", "T4"]}))
    assert scene.mechanism.outlines["wheel"] == ("T0", "T2", "T4")


def test_a_mirrored_wheel_is_the_mirror_image() -> None:
    part = {
        "name": "side",
        "link": [{**WHEEL, "around": {**TEETH, "centre": "P"}}],
        "joint": [{"name": "axle", "between": ["ground.O", "wheel.O"]}],
        "ground_link": {"points": {"O": [0, 0]}},
    }
    place = [{"part": "side", "name": "left"}, {"part": "side", "name": "right", "mirror": True}]
    scene = load_scene({"name": "two", "part": [part], "place": place})
    left, right = places(scene, "wheel_left"), places(scene, "wheel_right")
    assert left.keys() == right.keys() and len(left) == 12
    for name, place_of in left.items():
        assert right[name] == pytest.approx(place_of.conjugate(), abs=1e-16)


RING = [f"wheel.{name}{k}" for k in range(5) for name in "TR"]


def test_a_link_stands_for_its_outline() -> None:
    """The same listing, to the byte, as with all corners in the table."""
    wheel = {**WHEEL, "around": TEETH}
    touch = {"name": "teeth", "radius": [0.004, 0], "restitution": 0.0}
    short, long = (
        load_scene(tables(wheel, touch=[{**touch, "between": ["pawl.tip", side]}]))
        for side in ("wheel", [*RING, RING[0]])
    )
    assert listing(short) == listing(long)
    assert "polygon of 10 edges" in short.effects[0].describe(short.mechanism)


def test_of_two_links_both_outlines_touch() -> None:
    pawl = {**PAWL, "points": {**PAWL["points"], "C": [0.2, 0.1]}, "rod": {"mass": 0.1, "between": ["A", "tip"]}}
    wheel = {**WHEEL, "around": TEETH}
    scenes = []
    for outline, side in (
        (["A", "tip", "C"], "pawl"),
        (["A", "tip", "C"], ["pawl.A", "pawl.tip", "pawl.C", "pawl.A"]),
    ):
        touch = {"between": [side, "wheel"], "radius": 0.001, "restitution": 0.0}
        scenes.append(load_scene({**tables(wheel, touch=[touch]), "link": [wheel, {**pawl, "outline": outline}]}))
    assert listing(scenes[0]) == listing(scenes[1])


def test_a_corner_that_closes_an_outline_is_one_of_it() -> None:
    ring = ["T0", "T2", "T4", "R4"]
    scenes = [
        load_scene(tables({**WHEEL, "around": TEETH, "outline": outline}, touch=TOUCH))
        for outline in (ring, [*ring, "T0"])
    ]
    assert listing(scenes[0]) == listing(scenes[1])


def test_a_link_of_a_part_stands_for_its_outline() -> None:
    """In each place for that of the place, as in a scene without parts."""
    part = {
        "name": "side",
        "link": [{**WHEEL, "around": TEETH}, PAWL],
        "joint": AXLES,
        "ground_link": {"points": {"O": [0, 0], "Q": [0.0, 0.6]}},
        "touch": TOUCH,
    }
    place = [{"part": "side", "name": "l"}, {"part": "side", "name": "r", "mirror": True, "at": [2, 0]}]
    scene = load_scene({"name": "two", "part": [part], "place": place})
    said = [effect.describe(scene.mechanism) for effect in scene.effects]
    assert [one.partition(",")[0] for one in said] == [
        f"pawl_{side}.tip against wheel_{side} (polygon of 10 edges)" for side in "lr"
    ]


def test_a_joint_called_as_an_outline_is_told() -> None:
    axle = {"name": "wheel", "between": ["ground.O", "wheel.O"]}
    with pytest.raises(SceneError) as caught:
        load_scene({**tables({**WHEEL, "around": TEETH}, touch=TOUCH), "joint": [axle, AXLES[1]]})
    (found,) = map(str, caught.value.faults)
    assert 'touch[0].between[1]: found "wheel", a joint and a link with an outline, expected one of them' in found


def test_an_outline_with_corners_without_names_is_no_edge() -> None:
    """Also of a link with two points, whose line would be an edge if it had no outline."""
    bar = {"name": "wheel", "mass": 1, "inertia": 0.1, "com": [0, 0], "points": {"O": [0, 0], "B": [0, -1]}}
    found = faults({**bar, "outline": ["O", "B", [0.5, 0.5]]}, touch=TOUCH)
    assert len(found) == 1 and 'touch[0].between[1]: found "wheel"' in found[0]
    for outline in ([], ["O", "B"]):
        scene = load_scene(tables({**bar, "outline": outline}, touch=TOUCH))
        assert len(scene.effects) == 1


@pytest.mark.parametrize("clockwise", ["yes", 0, []])
def test_a_mirrored_circle_with_a_wrong_way_is_told(clockwise: Any) -> None:
    part = {
        "name": "side",
        "link": [{**WHEEL, "around": {**TEETH, "clockwise": clockwise}}],
        "joint": [{"name": "axle", "between": ["ground.O", "wheel.O"]}],
        "ground_link": {"points": {"O": [0, 0]}},
    }
    with pytest.raises(SceneError, match=r"around\.clockwise: found .*, expected true or false"):
        load_scene({"name": "two", "part": [part], "place": [{"part": "side", "name": "right", "mirror": True}]})


def test_an_outline_of_two_corners_is_an_edge() -> None:
    wheel = {**WHEEL, "outline": ["O", "P"], "points": {**WHEEL["points"], "Z": [0.1, -0.1]}}
    touch = {"between": ["pawl.tip", "wheel"], "radius": 0.01, "restitution": 0.0}
    long = {**touch, "between": ["pawl.tip", ["wheel.O", "wheel.P"]]}
    short, written = (load_scene(tables(wheel, touch=[one])) for one in (touch, long))
    assert len(short.effects) == 1
    for a, b in zip(listing(short).splitlines(), listing(written).splitlines(), strict=True):
        assert a == b or "radius" in a


WRONG: dict[str, tuple[dict[str, Any], str, str]] = {
    "no count": ({"around": {"points": {"T": [0.2, 0]}}}, "link[0].around.count", "missing, expected how often"),
    "count of zero": ({"around": {**TEETH, "count": 0}}, "link[0].around.count", "found 0"),
    "too many": (
        {"around": {**TEETH, "count": 251}},
        "link[0].around.count",
        "251 times 2 points, expected at most 500",
    ),
    "no points": ({"around": {"count": 3, "points": {}}}, "link[0].around.points", "expected the points of"),
    "no angle": ({"around": {"count": 3, "points": {"T": [0.2]}}}, "link[0].around.points.T", "write 2 values"),
    "a name twice": (
        {"around": {"count": 3, "points": {"P": [1, 0]}}, "points": {"P1": [0, 0], "O": [0, 0]}},
        "link[0].around.points",
        "found P1, which is a point of the link already",
    ),
    "names that run together": (
        {"around": {"count": 12, "points": {"T": [1, 0], "T1": [1, 0.1]}}},
        "link[0].around.points",
        "end in a digit",
    ),
    "no such centre": ({"around": {**TEETH, "centre": "C"}}, "link[0].around.centre", 'found "C", expected a point'),
    "unknown key": ({"around": {**TEETH, "radius": 1}}, "link[0].around.radius", "found an unknown key"),
}


@pytest.mark.parametrize("case", WRONG)
def test_faults_name_key_and_advice(case: str) -> None:
    more, key, said = WRONG[case]
    found = faults({**WHEEL, **more})
    assert len(found) == 1 and f"{key}: " in found[0] and said in found[0]


def test_a_touch_of_a_link_without_outline_says_what_to_do() -> None:
    found = faults(WHEEL | {"points": {"O": [0, 0], "A": [1, 0], "B": [0, 1]}}, touch=TOUCH)
    assert len(found) == 1 and "give it an outline of its points, or list those that are its corners" in found[0]
    found = faults(
        WHEEL | {"points": {"O": [0, 0], "A": [1, 0], "B": [0, 1]}, "outline": ["O", "A", [0, 1]]}, touch=TOUCH
    )
    assert len(found) == 1 and "give it an outline of its points" in found[0]


def test_degrees_without_a_unit_are_remarked_on() -> None:
    around = {"count": 3, "points": {"T": [0.2, 30]}}
    scene = load_scene(tables({**WHEEL, "around": around}))
    remarks = [str(one) for one in scene.remarks]
    assert any("link[0].around.points.T[1]" in one and '"30 deg" for degrees' in one for one in remarks)
