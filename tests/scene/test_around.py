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


def test_several_circles() -> None:
    holes = {"count": 3, "points": {"H": [0.05, 0]}}
    scene = load_scene(tables({**WHEEL, "around": [TEETH, holes]}))
    assert {"H0", "H2", "T4", "R4"} <= places(scene).keys()
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


def test_an_outline_of_two_corners_is_an_edge() -> None:
    wheel = {**WHEEL, "outline": ["O", "P"], "points": {**WHEEL["points"], "Z": [0.1, -0.1]}}
    touch = {"between": ["pawl.tip", "wheel"], "radius": 0.01, "restitution": 0.0}
    long = {**touch, "between": ["pawl.tip", ["wheel.O", "wheel.P"]]}
    short, written = (load_scene(tables(wheel, touch=[one])) for one in (touch, long))
    assert len(short.effects) == 1
    for a, b in zip(listing(short).splitlines(), listing(written).splitlines(), strict=True):
        assert a == b or "radius" in a


TOUCH = [{"between": ["pawl.tip", "wheel"], "radius": 0.004, "restitution": 0.0}]
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
