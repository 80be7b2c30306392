"""Starts that are drawn, against circle intersections worked out by hand: four-bars, a five-bar, loops that float."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pytest

from ccgen.generator.mechanism.assembly import Contradiction, rates
from ccgen.generator.mechanism.branch import Branch, branches, place
from ccgen.generator.mechanism.layout import lay_out
from ccgen.generator.mechanism.topology import span
from ccgen.generator.scene import Scene, SceneError, chain, load_scene, loop, read_tables

from ..support.drawn_linkages import BASE, COUPLER, CRANK, ROCKER, cranks, four_bar, rod
from ..support.folders import SCENES


def circles(first: complex, r: float, second: complex, s: float) -> tuple[complex, complex]:
    """The two points at distance r from ``first`` and s from ``second``: left of the way between them, and right."""
    d = abs(second - first)
    along = (r * r - s * s + d * d) / (2.0 * d)
    across = math.sqrt(r * r - along * along)
    unit = (second - first) / d
    return first + unit * complex(along, across), first + unit * complex(along, -across)


def five_bar(start: Mapping[str, Any], drives: Sequence[Mapping[str, Any]] = ()) -> Scene:
    """Two cranks on the ground, joined by two bars that meet at ``tip``."""
    tables = {
        "ground_link": {"points": {"O": [0.0, 0.0], "Q": [1.0, 0.0]}},
        "link": [rod("left", 0.5), rod("up", 0.8), rod("down", 0.8), rod("right", 0.5)],
        "joint": [
            {"name": "a", "between": ["ground.O", "left.A"]},
            {"name": "b", "between": ["left.B", "up.A"]},
            {"name": "tip", "between": ["up.B", "down.A"]},
            {"name": "c", "between": ["down.B", "right.B"]},
            {"name": "d", "between": ["ground.Q", "right.A"]},
        ],
        "start": dict(start),
    } | ({"drive": list(drives)} if drives else {})
    return read_tables(tables, "five-bar", "five-bar")


def at(scene: Scene, joint: str) -> complex:
    """Where a joint is at the start."""
    names = [found.name for found in scene.mechanism.joints]
    return place(scene.mechanism, scene.start.poses, scene.mechanism.joints[names.index(joint)].second)


def branch(scene: Scene) -> dict[str, int]:
    """The turn at each joint of a mechanism with one loop."""
    found = one_branch(scene)
    names = [scene.mechanism.joints[joint].name for joint in found.loop.joints]
    return dict(zip(names, found.signs, strict=True))


def one_branch(scene: Scene) -> Branch:
    cuts = [cut.joint for cut in span(scene.mechanism).cuts]
    (found,) = branches(scene.mechanism, scene.start.poses, cuts)
    return found


def closed(scene: Scene) -> bool:
    """Whether both sides of every joint are in one place."""
    ends = [
        [place(scene.mechanism, scene.start.poses, end) for end in (joint.first, joint.second)]
        for joint in scene.mechanism.joints
    ]
    return max(abs(second - first) for first, second in ends) < 1e-14


# Some angles


@pytest.mark.parametrize("crank", [-2.0, -0.4, 0.3, 1.1, 2.5])
@pytest.mark.parametrize("side", [0, 1])
def test_an_angle_that_is_given_stays_and_the_others_follow(crank: float, side: int) -> None:
    """The crank's angle alone, and roughly where the elbow is: the circles of coupler and rocker meet there."""
    knee = CRANK * np.exp(1j * crank)
    elbow = circles(knee, COUPLER, BASE, ROCKER)[side]
    drawn = [round(elbow.real, 1), round(elbow.imag, 1)]
    scene = four_bar({"angles": {"crank": crank}, "joints": {"elbow": drawn}})
    assert closed(scene)
    assert abs(at(scene, "elbow") - circles(at(scene, "knee"), COUPLER, BASE, ROCKER)[side]) < 1e-14
    alone = four_bar({"angles": {"crank": crank}})
    assert alone.start.poses[0][2] == pytest.approx(crank, abs=1e-14)
    assert min(abs(at(alone, "elbow") - meet) for meet in circles(knee, COUPLER, BASE, ROCKER)) < 1e-14
    assert alone.start.assembled_by == 0.0


def test_an_angle_beside_others_goes_as_near_as_it_can() -> None:
    """Crank and rocker given so that the coupler is too short: their angles change, and least in squares."""
    scene = four_bar({"angles": {"crank": math.pi, "rocker": 0.2}})
    assert closed(scene)
    assert scene.start.assembled_by > 0.1
    assert scene.start.turned[0][0] in ("crank", "rocker")


# Joints and poses


@pytest.mark.parametrize("crank", [-2.0, 0.3, 1.1, 2.5])
@pytest.mark.parametrize("side", [0, 1])
def test_exact_joints_are_kept(crank: float, side: int) -> None:
    knee = CRANK * np.exp(1j * crank)
    elbow = circles(knee, COUPLER, BASE, ROCKER)[side]
    joints = {"knee": [knee.real, knee.imag], "elbow": [elbow.real, elbow.imag]}
    scene = four_bar({"joints": joints})
    assert closed(scene)
    assert abs(at(scene, "knee") - knee) < 1e-14 and abs(at(scene, "elbow") - elbow) < 1e-14
    assert (scene.start.assembled_by, scene.start.missed_by < 1e-14) == (0.0, True)
    # right of the way from knee to pivot the loop knee, elbow, pivot, motor runs counter-clockwise there
    assert branch(scene)["elbow"] == (1 if branch_turn(knee, elbow) > 0.0 else -1)


def branch_turn(knee: complex, elbow: complex) -> float:
    """The turn at the elbow on the loop's own way, which starts there and goes to the pivot."""
    return ((elbow - knee).conjugate() * (BASE - elbow)).imag


@pytest.mark.sample(1)
@pytest.mark.parametrize("side", [0, 1])
def test_a_rough_drawing_is_the_nearest_assembly_of_its_branch(side: int) -> None:
    """Angles of the drawing by hand; the assembled ones have the smallest sum of squared changes from them."""
    knee, elbow = complex(0.05, 0.23), (complex(0.45, 0.5), complex(0.4, -0.36))[side]
    scene = four_bar({"joints": {"knee": [knee.real, knee.imag], "elbow": [elbow.real, elbow.imag]}})
    assert closed(scene)
    drawn = np.angle([knee, elbow - knee, elbow - BASE])
    found = np.array([pose[2] for pose in scene.start.poses])
    best = math.inf
    for crank in np.linspace(-math.pi, math.pi, 200001):
        there = CRANK * complex(math.cos(crank), math.sin(crank))
        meet = circles(there, COUPLER, BASE, ROCKER)[side]
        turned = np.angle(np.array([there, meet - there, meet - BASE]) * np.exp(-1j * drawn))
        best = min(best, float(turned @ turned))
    assert float((found - drawn) @ (found - drawn)) == pytest.approx(best, rel=1e-6)
    assert scene.start.assembled_by == np.abs(found - drawn).max() > 1e-3
    missed = max(abs(at(scene, "knee") - knee), abs(at(scene, "elbow") - elbow))
    assert scene.start.missed_by == pytest.approx(missed, rel=1e-12)


def test_links_are_never_stretched() -> None:
    """A drawing twice as large has the same angles."""
    once = four_bar({"joints": {"knee": [0.05, 0.2], "elbow": [0.45, 0.45], "motor": [0, 0], "pivot": [0.6, 0]}})
    twice = four_bar({"joints": {"knee": [0.1, 0.4], "elbow": [0.9, 0.9], "motor": [0, 0], "pivot": [1.2, 0]}})
    assert np.allclose(once.start.poses, twice.start.poses, atol=1e-13)
    assert closed(twice)


def test_a_five_bar_goes_where_its_tip_is_drawn() -> None:
    """Two of four links drawn by their joints; the tip of the others is one of two circle intersections."""
    b, c = 0.5 * np.exp(2j), 1.0 + 0.5 * np.exp(0.9j)
    for tip in circles(b, 0.8, c, 0.8):
        joints = {"b": [b.real, b.imag], "c": [c.real, c.imag], "tip": [tip.real + 0.1, tip.imag - 0.05]}
        rough = five_bar({"joints": joints})
        assert closed(rough) and abs(at(rough, "tip") - tip) < 0.2
        exact = five_bar({"joints": joints | {"tip": [tip.real, tip.imag]}})
        assert abs(at(exact, "tip") - tip) < 1e-14 and exact.start.assembled_by == 0.0
        # the tip not drawn at all: the cranks stay as they are drawn
        bare = five_bar({"joints": {"b": joints["b"], "c": joints["c"]}})
        assert abs(at(bare, "b") - b) < 1e-14 and abs(at(bare, "c") - c) < 1e-14
        assert min(abs(at(bare, "tip") - meet) for meet in circles(b, 0.8, c, 0.8)) < 1e-14


def test_a_tip_alone_says_which_way_a_driven_five_bar_bends() -> None:
    """The cranks are where drives have them, and of the bars nothing is said but where they meet: exactly, or to a
    fifth of their length, which no angle follows from; without whole turns."""
    b, c = 0.5 * np.exp(2j), 1.0 + 0.5 * np.exp(0.9j)
    drives = [{"joint": "a", "angle": 2.0}, {"joint": "d", "angle": 0.9}]
    for tip in circles(b, 0.8, c, 0.8):
        for away in (0.0, 0.16, -0.16, 0.16j, -0.16j):
            drawn = tip + away
            scene = five_bar({"joints": {"tip": [drawn.real, drawn.imag]}}, drives)
            assert closed(scene) and abs(at(scene, "tip") - tip) < 1e-9
            assert all(abs(angle) <= math.pi for _, _, angle in scene.start.poses)


def test_a_tip_alone_brings_a_free_five_bar_there() -> None:
    """Wherever both cranks reach; the loop closes with it."""
    for drawn in (0.5 + 0.9j, 0.2 - 0.7j, 0.8 + 0.3j):
        scene = five_bar({"joints": {"tip": [drawn.real, drawn.imag]}})
        assert closed(scene) and abs(at(scene, "tip") - drawn) < 1e-9


def test_a_pose_tells_its_neighbours() -> None:
    """The coupler's pose alone: crank and rocker have both ends known, so they need no angle."""
    elbow = circles(0.2j, COUPLER, BASE, ROCKER)[0]
    angle = math.degrees(float(np.angle(elbow - 0.2j)))
    scene = four_bar({"poses": {"coupler": [0.0, 0.2, f"{angle} deg"]}})
    assert abs(at(scene, "knee") - 0.2j) < 1e-14 and abs(at(scene, "elbow") - elbow) < 1e-14
    assert scene.start.assembled_by == 0.0


def test_more_than_two_joints_of_a_link_fit_in_least_squares() -> None:
    """A plate with three pins drawn askew: its angle is the one that fits best, as a search finds it."""
    points = {"A": [0.0, 0.0], "B": [1.0, 0.0], "C": [0.3, 0.8]}
    plate = {"name": "plate", "mass": 1.0, "inertia": 0.1, "com": [0.4, 0.3], "points": points}
    ends = [rod(name, 1.0) for name in ("a", "b", "c")]
    joints = [{"name": f"pin_{key}", "between": [f"plate.{key.upper()}", f"{key}.A"]} for key in "abc"]
    drawn = {"pin_a": [0.1, 0.2], "pin_b": [0.7, 0.9], "pin_c": [-0.4, 1.0]}
    tables = {"link": [plate, *ends], "joint": joints, "start": {"joints": drawn}}
    scene = read_tables(tables, "plate", "plate")
    local = np.array([complex(*xy) for xy in points.values()])
    there = np.array([complex(*xy) for xy in drawn.values()])

    def misfit(angle: float) -> float:
        off = there - local * np.exp(1j * angle)
        return float(np.sum(np.abs(off - off.mean()) ** 2))

    x, y, angle = scene.start.poses[0]
    assert all(misfit(angle) < misfit(angle + step) for step in (-1e-4, 1e-4))
    # each pin counts twice, once for each of its links; both are in one place, so the plate lies amid the drawing
    assert complex(x, y) == pytest.approx(complex(np.mean(there - local * np.exp(1j * angle))), abs=1e-14)


def test_a_drawn_loop_floats_where_it_is_drawn() -> None:
    """A regular hexagon drawn turned and moved; and the same drawing one and a half times as large."""
    corners = 2.0 + 3.0j + np.exp(1j * (np.arange(6) * math.pi / 3 + 0.2))
    drawn = {f"joint_{k}": [corner.real, corner.imag] for k, corner in enumerate(corners)}
    scene = loop(6, start={"joints": drawn})
    assert max(abs(at(scene, name) - complex(*xy)) for name, xy in drawn.items()) < 1e-14
    large = 2.0 + 3.0j + 1.5 * (corners - 2.0 - 3.0j)
    scaled = loop(6, start={"joints": {f"joint_{k}": [c.real, c.imag] for k, c in enumerate(large)}})
    assert np.allclose(scaled.start.poses, scene.start.poses, atol=1e-13)
    assert scaled.start.missed_by == pytest.approx(0.5, abs=1e-13)
    lifted = loop(6, start={"joints": drawn, "height": 1.0})
    assert min(at(lifted, name).imag for name in drawn) == pytest.approx(1.0, abs=1e-14)


# Faults


def faults(text: str, start: str) -> list[str]:
    with pytest.raises(SceneError) as caught:
        read_tables(tomllib.loads(text + start), "scene.toml", "scene")
    return [str(fault) for fault in caught.value.faults]


CHAIN = "[chain]\nlinks = 3\n[start]\n"


def test_every_fault_of_a_drawing_at_once() -> None:
    found = faults(
        CHAIN,
        "joints = { joint_1 = [0, 1], joint_2 = [1, 1], joint_9 = [0, 0] }\n"
        "poses = { link_0 = [0, 0, 0.1], link_7 = [0, 0, 0] }\n"
        'angles = { link_0 = 0.3, link_1 = "20 deg" }\nposition = [0, 1]\ntilt = 0.1\n',
    )
    said = "\n".join(found)
    assert len(found) == 6
    assert "start.joints.joint_9: found an unknown joint, expected one of joint_1, joint_2; correct the name" in said
    assert "start.poses.link_7: found an unknown link, expected one of link_0, link_1, link_2; correct the name" in said
    assert "start.poses.link_0: found an angle of link_0 beside a pose of link_0, expected one of them" in said
    assert "start.joints.joint_1: found joint_1 and joint_2 beside an angle of link_1" in said
    assert "start.position: found a position beside drawn joints or poses, expected none" in said
    assert "start.tilt: found a tilt beside drawn joints or poses" in said


@pytest.mark.parametrize(
    ("start", "key", "expected"),
    [
        ("joints = { joint_1 = [0] }", "start.joints.joint_1", "write 2 values"),
        ("joints = [[0, 1]]", "start.joints", "a table by name"),
        ('poses = { link_0 = [0, 1, "ten"] }', "start.poses.link_0[2]", "ten is not known here"),
        ('poses = { link_0 = ["1 deg", 1, 0] }', "start.poses.link_0[0]", "that is an angle, not a length in m"),
        ("poses = { link_0 = [0, 1] }", "start.poses.link_0", "write 3 values"),
        ("joints = { joint_1 = [0, nan] }", "start.joints.joint_1[1]", "finite number"),
    ],
)
def test_a_drawing_of_the_wrong_shape(start: str, key: str, expected: str) -> None:
    (found,) = faults(CHAIN, start)
    assert f"{key}: found" in found and expected in found


def test_a_loop_that_cannot_close_is_named_with_its_miss() -> None:
    """The crank reaches 1.65 of the 0.05 that the others leave: 2.0 against 0.5 + 0.45 + 0.6."""
    with pytest.raises(SceneError) as caught:
        four_bar({"angles": {"crank": 0.3, "coupler": 2.0, "rocker": 1.0}}, crank=2.0)
    (fault,) = caught.value.faults
    assert "no way to close the loop" in fault.message
    for name in ("crank", "coupler", "rocker", "ground", "motor", "knee", "elbow", "pivot"):
        assert name in fault.message
    assert "misses by 0.45 m" in fault.message


def test_joints_that_contradict_each_other_are_named() -> None:
    """Three cranks on one bar, the third far too long: any two close a loop with the bar, not all three."""
    with pytest.raises(SceneError) as caught:
        cranks(lengths=(1.0, 1.0, 4.0), angles=(1.0, 1.0, 1.0, 0.0))
    (fault,) = caught.value.faults
    joints = "foot_0, foot_1, foot_2, head_0, head_1, head_2"
    assert f"found joints that do not close together from this start ({joints}): each loop" in fault.message
    assert "expected 0; change lengths" in fault.message


@pytest.mark.slow
def test_the_loop_at_fault_is_named_among_several() -> None:
    """The third crank cannot reach the bar at all: its loop is named, the one that closes is not."""
    with pytest.raises(SceneError) as caught:
        cranks(lengths=(1.0, 1.0, 9.0), angles=(1.0, 1.0, 1.0, 0.0))
    (fault,) = caught.value.faults
    assert "found no way to close the loop bar - crank_0 - ground - crank_2 " in fault.message
    assert "misses by 4 m at head_2" in fault.message, "9 m against 2 m of feet, 2 m of bar and 1 m of crank"


# The branch


def inside(point: complex, corners: tuple[complex, complex, complex]) -> bool:
    """Whether a point lies in a triangle."""
    pairs = zip(corners, (*corners[1:], corners[0]), strict=True)
    return len({((q - p).conjugate() * (point - p)).imag > 0.0 for p, q in pairs}) == 1


@pytest.mark.parametrize("crank", [-2.4, -0.4, 0.3, 1.1, 2.5])
def test_the_two_assemblies_of_a_four_bar_have_opposite_turns(crank: float) -> None:
    """Left and right of the way from knee to pivot. Crossed: motor and elbow on one side of it, neither enclosed."""
    knee, pivot = CRANK * np.exp(1j * crank), complex(BASE)
    motor_left = -math.sin(crank) * CRANK * BASE > 0.0
    turns = []
    for elbow, left in zip(circles(knee, COUPLER, BASE, ROCKER), (True, False), strict=True):
        scene = four_bar({"joints": {"knee": [knee.real, knee.imag], "elbow": [elbow.real, elbow.imag]}})
        turns.append(branch(scene)["elbow"])
        enclosed = inside(0j, (knee, elbow, pivot)) or inside(elbow, (0j, knee, pivot))
        assert one_branch(scene).crossed == ((motor_left == left) and not enclosed)
    assert turns == [-1, 1]


def test_a_polygon_turns_one_way_and_once_round() -> None:
    found = one_branch(loop(7))
    assert len(set(found.signs)) == 1 and not found.crossed
    assert abs(math.fsum(turn or 0.0 for turn in found.turns)) == pytest.approx(2.0 * math.pi, abs=1e-12)
    assert abs(found.turns[0] or 0.0) == pytest.approx(2.0 * math.pi / 7.0, abs=1e-12)


def test_a_flat_loop_has_no_side() -> None:
    """A parallelogram laid flat: every corner is in line, and the text says so."""
    scene = loop(4, start={"angles": [0.0, 0.0, math.pi, math.pi]})
    assert set(one_branch(scene).signs) == {0}
    assert "in line at every joint" in one_branch(scene).text(scene.mechanism)


def sliding(tilt: float, shift: float = 0.0) -> Scene:
    """A slider-crank, turned by ``tilt``; the guide's line passes ``shift`` above the crank's axle."""
    line = shift * 1j * np.exp(1j * tilt)
    tables = {
        "ground_link": {"points": {"O": [0, 0], "G": [line.real, line.imag]}},
        "link": [rod("crank", 0.2), rod("rod", 0.6), rod("slider", 0.1)],
        "joint": [
            {"name": "motor", "between": ["ground.O", "crank.A"]},
            {"name": "crank_pin", "between": ["crank.B", "rod.A"]},
            {"name": "wrist_pin", "between": ["rod.B", "slider.A"]},
            {
                "name": "guide",
                "type": "prismatic",
                "axis": tilt,
                "angle": tilt,
                "between": ["ground.G", "slider.A"],
            },
        ],
        "start": {"angles": {"crank": 1.0 + tilt, "rod": -0.3 + tilt, "slider": tilt}},
    }
    return read_tables(tables, "slider", "slider")


@pytest.mark.parametrize("shift", [0.0, 0.07])
@pytest.mark.parametrize("tilt", [0.0, 0.3, 1.9, -2.6])
def test_a_guide_at_a_pin_is_no_corner_of_its_own(tilt: float, shift: float) -> None:
    """The three pins are a triangle, whose turns are those of a whole turn; rounding has no say in it."""
    scene = sliding(tilt, shift)
    found = one_branch(scene)
    turns = dict(zip([scene.mechanism.joints[k].name for k in found.loop.joints], found.turns, strict=True))
    assert turns["guide"] is None and branch(scene)["guide"] == 0
    others = [turn for turn in turns.values() if turn is not None]
    assert len(others) == 3 and math.fsum(others) == pytest.approx(-2.0 * math.pi, abs=1e-12)
    text = found.text(scene.mechanism)
    assert text.startswith("wrist_pin - guide - motor - crank_pin: open; right at wrist_pin, motor, crank_pin; nearest")
    for nudge in (1e-13, -1e-13, 1e-13j, -1e-13j):
        poses = [(x + nudge.real * k, y + nudge.imag * k, a) for k, (x, y, a) in enumerate(scene.start.poses)]
        (moved,) = branches(scene.mechanism, poses, [cut.joint for cut in span(scene.mechanism).cuts])
        assert moved.text(scene.mechanism) == text


def test_a_slot_away_from_the_pins_keeps_its_corner() -> None:
    scene = load_scene(SCENES / "quick-return.toml")
    cuts = [cut.joint for cut in span(scene.mechanism).cuts]
    slot = branches(scene.mechanism, scene.start.poses, cuts)[0]
    assert set(slot.signs) == {1} and None not in slot.turns


# Start velocities from any subset


def test_one_rate_gives_the_others_as_the_linkage_says() -> None:
    """Angular velocities of a four-bar by the classical formula, from any one of them."""
    elbow = circles(0.2j, COUPLER, BASE, ROCKER)[0]
    start: dict[str, Any] = {"joints": {"knee": [0.0, 0.2], "elbow": [elbow.real, elbow.imag]}}
    angles = [pose[2] for pose in four_bar(start).start.poses]
    a, b, c = angles
    crank = 3.0
    coupler = -crank * CRANK * math.sin(a - c) / (COUPLER * math.sin(b - c))
    rocker = crank * CRANK * math.sin(a - b) / (ROCKER * math.sin(c - b))
    wanted = {"crank": crank, "coupler": coupler, "rocker": rocker}
    subsets: list[dict[str, float]] = [{name: rate} for name, rate in wanted.items()]
    subsets += [{"crank": crank, "rocker": rocker}, wanted]  # more than there are degrees of freedom, but consistent
    for given in subsets:
        scene = four_bar(start | {"angular_velocities": given})
        assert [v[2] for v in scene.start.velocities] == pytest.approx(list(wanted.values()), rel=1e-12)


def test_rates_that_contradict_each_other_are_refused() -> None:
    start = {"joints": {"knee": [0.0, 0.2], "elbow": [0.45, 0.42]}, "angular_velocities": {"crank": 1.0, "rocker": 9.0}}
    with pytest.raises(SceneError) as caught:
        four_bar(start)
    (fault,) = caught.value.faults
    assert fault.key == "start.angular_velocities"
    assert "crank, rocker" in fault.message and "correct one of them or give fewer" in fault.message


def test_rates_of_several_loops() -> None:
    """A ring of twelve with nine angular velocities given at random: all hold, and the loop stays closed."""
    random = np.random.default_rng(3)
    scene = loop(12)
    layout, angles = lay_out(scene.mechanism), np.array([pose[2] for pose in scene.start.poses])
    given = {
        int(link): float(rate) for link, rate in zip(random.permutation(12)[:9], random.normal(size=9), strict=True)
    }
    found = rates(layout, angles, given)
    assert all(found[link] == rate for link, rate in given.items())
    assert np.abs(layout.jacobian(angles) @ found).max() < 1e-12
    with pytest.raises(Contradiction):
        rates(layout, angles, dict(enumerate(random.normal(size=12).tolist())))


def test_a_free_chain_needs_no_assembly() -> None:
    assert chain(3, start={"joints": {"joint_1": [1.0, 0.5], "joint_2": [1.5, 1.2]}}).start.assembled_by == 0.0


@pytest.mark.parametrize("length", [0.6, 0.594, 0.582, 0.57, 0.558, 0.7])
def test_links_that_lie_on_each_other_go_to_the_nearer_side(length: float) -> None:
    """Two links drawn folded, angles 0, between two that are given: of both sides on which the triangle closes that
    with the smaller sum of squares, and no whole turns; in closed form by the cosine rule."""
    parts = "".join(
        f'[[link]]\nname = "{name}"\nrod = {{ mass = 1 }}\npoints = {{ A = [0, 0], B = [{size}, 0] }}\n'
        for name, size in (("left", 0.4), ("upper", length), ("lower", 0.6), ("right", 0.3))
    )
    pins = [("ground.O", "left.A"), ("left.B", "upper.A"), ("upper.B", "lower.B"), ("lower.A", "right.B")]
    pins.append(("ground.Q", "right.A"))
    joints = "".join(f'[[joint]]\nbetween = ["{one}", "{other}"]\n' for one, other in pins)
    start = '[start]\nangles = { left = "100 deg", right = "70 deg" }\n'
    text = 'name = "five"\n[ground_link]\npoints = { O = [0, 0], Q = [0.8, 0] }\n' + parts + joints + start
    found = [pose[2] for pose in load_scene(tomllib.loads(text)).start.poses]
    p, r = 0.4 * np.exp(1j * np.radians(100.0)), 0.8 + 0.3 * np.exp(1j * np.radians(70.0))
    bend = np.arccos((length**2 + abs(r - p) ** 2 - 0.36) / (2.0 * length * abs(r - p)))
    sides = []
    for sign in (1.0, -1.0):
        upper = float(np.angle(r - p) + sign * bend)
        sides.append((upper, float(np.angle(p + length * np.exp(1j * upper) - r))))
    nearest = min(sides, key=lambda pair: sum(angle**2 for angle in pair))
    assert found[1:3] == pytest.approx(nearest, abs=1e-12)
