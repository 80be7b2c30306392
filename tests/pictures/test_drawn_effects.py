"""What pictures draw where effects act: coils, dashpots, arcs, teeth, belts, blocks in guides, ropes; and axes."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from ccgen.generator import load_scene
from ccgen.runtime import Run, simulate
from ccgen.runtime.pictures.frames import frame_times, sample
from ccgen.runtime.pictures.link_colours import link_colours
from ccgen.runtime.pictures.player import content
from ccgen.runtime.pictures.plot import draw, round_below
from ccgen.runtime.pictures.strokes import Stroke, straightened, strokes
from ccgen.runtime.pictures.view import view_of

from ..support.folders import SCENES
from ..support.rigid_polygon import bouncing
from ..support.workshop import Workshop

ALL = """
name = "parts"
[ground_link]
points = { O = [0, 0], S = [0, 1], P = [2, 0], edge = [5, 5] }
[[link]]
name = "arm"
rod = { mass = 1, between = ["A", "B"] }
points = { A = [0, 0], M = [0.5, 0], B = [1, 0] }
[[link]]
name = "wheel"
disc = { mass = 1, radius = 0.2, centre = "C" }
points = { C = [0, 0] }
[[link]]
name = "cart"
mass = 1
inertia = 1
com = [0, 0]
points = { C = [0, 0], D = [0.3, 0] }
[[joint]]
name = "hinge"
between = ["ground.O", "arm.A"]
[[joint]]
name = "axle"
between = ["ground.P", "wheel.C"]
[[joint]]
name = "guide"
type = "prismatic"
between = ["ground.O", "cart.C"]
axis = [1, 0]
[[spring]]
name = "coil"
between = ["ground.S", "arm.B"]
stiffness = 2
[[damper]]
name = "pot"
between = ["ground.S", "arm.B"]
damping = 1
[[torsion]]
name = "spiral"
joint = "hinge"
stiffness = 1
[[stop]]
name = "bar"
joint = "hinge"
lowest = "-80 deg"
restitution = 0
[[motor]]
name = "mover"
joint = "axle"
torque = 0.1
[[motor]]
name = "pusher"
joint = "guide"
force = 0.1
[[brake]]
name = "shoes"
joint = "hinge"
torque = 0.1
[[brake]]
name = "pads"
joint = "guide"
force = 0.1
[[force]]
name = "push"
point = "arm.B"
vector = [0, -0.3]
[[force]]
name = "along"
point = "arm.B"
vector = [0.3, 0]
frame = "link"
[[force]]
name = "shake"
point = "cart.D"
vector = ["sin(t)", 0.1]
[[torque]]
name = "twist"
link = "wheel"
torque = -0.2
[[belt]]
name = "band"
joints = ["hinge", "axle"]
radii = [0.1, 0.2]
[[rope]]
name = "line"
between = ["ground.P", "cart.C"]
over = ["ground.S"]
length = 4.5
restitution = 0
[start]
slides = { guide = 1.0 }
[gravity]
[run]
until = 0.2
"""


@pytest.fixture(scope="module")
def run(workshop: Workshop) -> Run:
    return simulate(workshop.model(ALL))


def drawn(run: Run) -> dict[str, list[Stroke]]:
    """The strokes of a run by what they are called after."""
    found: dict[str, list[Stroke]] = {}
    for stroke in strokes(run.model, sample(run, frame_times(run, 100.0)), 1.0):
        found.setdefault(stroke.name, []).append(stroke)
    return found


def test_what_acts_between_points_ends_at_them(run: Run) -> None:
    """A coil and a dashpot from (0, 1) to the arm's end; the dashpot beside the coil."""
    q = run.q[-1]
    poses, tip = run.model.poses(q), run.model.point("arm.B", q)
    (coil,), (rod, cylinder) = drawn(run)["coil"], drawn(run)["pot"]
    corners = coil.corners(poses)
    assert corners[0] == pytest.approx([0, 1]) and corners[-1] == pytest.approx(tip)
    assert rod.corners(poses)[0] == pytest.approx([0, 1]) and cylinder.corners(poses)[-1] == pytest.approx(tip)
    way = (tip - [0, 1]) / np.hypot(*(tip - [0, 1]))
    across = (corners - [0, 1]) @ [-way[1], way[0]]
    assert across.max() == pytest.approx(-across.min()) and 0.01 < across.max() < 0.1
    assert ((rod.corners(poses) - [0, 1]) @ [-way[1], way[0]])[2] > across.max()


def test_what_acts_at_joints_turns_with_them(run: Run) -> None:
    """The spiral's outer end goes with the arm, its inner one stays; the stop stands at its angle; so does the arc."""
    first, last = run.model.poses(run.q[0]), run.model.poses(run.q[-1])
    found = drawn(run)
    (spiral,), (bar,), (arc,) = found["spiral"], found["bar"], found["mover"]
    angles = [np.arctan2(*spiral.corners(poses)[-1][::-1]) for poses in (first, last)]
    assert angles == pytest.approx([first[0, 2], last[0, 2]])
    assert spiral.corners(first)[0] == pytest.approx(spiral.corners(last)[0])
    for poses in (first, last):
        foot, head = bar.corners(poses)
        assert [np.arctan2(y, x) for x, y in (foot, head)] == pytest.approx(np.radians([-80, -80]))
        assert np.arctan2(*(arc.corners(poses)[0] - [2, 0])[::-1]) == pytest.approx(poses[1, 2])


def test_belts_touch_their_wheels(run: Run) -> None:
    """No corner of the belt is inside of a pulley, and each pulley has some; the straight part is a tangent of both."""
    corners = drawn(run)["band"][0].corners(run.model.poses(run.q[0]))
    small, large = np.hypot(*corners.T), np.hypot(*(corners - [2, 0]).T)
    assert small.min() == pytest.approx(0.1) and large.min() == pytest.approx(0.2)
    assert np.all(np.isclose(small, 0.1) | np.isclose(large, 0.2))
    jump = int(np.argmax(np.hypot(*np.diff(corners, axis=0).T)))
    tangent = corners[jump + 1] - corners[jump]
    assert tangent @ corners[jump] == pytest.approx(0, abs=1e-12)
    assert tangent @ (corners[jump + 1] - [2, 0]) == pytest.approx(0, abs=1e-12)


def test_blocks_slide_between_rails(run: Run) -> None:
    (left, right, block), (arrow,) = drawn(run)["guide"], drawn(run)["pusher"]
    assert block.filled
    for q in (run.q[0], run.q[-1]):
        poses = run.model.poses(q)
        corners, rails = block.corners(poses), [rail.corners(poses) for rail in (left, right)]
        assert corners[:4].mean(axis=0) == pytest.approx(poses[2, :2])
        assert rails[0][0, 1] == pytest.approx(-rails[1][0, 1]) and np.ptp(rails[0][:, 1]) == pytest.approx(0)
        assert rails[0][0, 0] < corners[:, 0].min() and corners[:, 0].max() < rails[0][1, 0]
        assert arrow.corners(poses)[1, 0] > arrow.corners(poses)[0, 0]


def test_ropes_are_dashed_where_they_are_slack(run: Run) -> None:
    pytest.importorskip("matplotlib")
    (rope,) = drawn(run)["line"]
    poses = run.model.poses(run.q[0])
    assert rope.corners(poses) == pytest.approx(np.array([[2, 0], [0, 1], [1, 0]])) and rope.slack(poses)
    assert not Stroke("tight", "way", rope.at, rope.points, "ink", length=5**0.5 + 2**0.5).slack(poses)
    (line,) = artists(draw(run).subfigs[0].axes[0], "line")
    assert line.get_linestyle() == "--"


def artists(axes: Any, name: str) -> list[Any]:
    return [line for line in axes.lines if line.get_gid() == name]


def test_the_figure_has_them_all(run: Run) -> None:
    pytest.importorskip("matplotlib")
    axes = draw(run).subfigs[0].axes[-1]
    poses = run.model.poses(run.q[-1])
    for name, found in drawn(run).items():
        lines = [one for one in found if not one.filled]
        for line, stroke in zip(artists(axes, name), lines, strict=True):
            assert line.get_xydata().shape == stroke.corners(poses).shape
    assert {"coil", "pot", "spiral", "bar", "mover", "pusher", "band", "line", "guide"} <= set(drawn(run))


def test_pivots_stand_where_something_hangs(run: Run) -> None:
    """The ground's point of no joint and no spring has none."""
    pivots = content(run)["groundPoints"]
    assert sorted(pivots) == [[0, 0], [0, 1], [2, 0]]


def test_the_page_can_evaluate_them(run: Run) -> None:
    """By the same formulas from the page's own numbers, at its last frame."""
    page = content(run)
    poses = np.array(page["poses"][-1]).reshape(-1, 3)
    given = [stroke for found in drawn(run).values() for stroke in found]
    assert sorted(part["name"] for part in page["parts"]) == sorted(stroke.name for stroke in given)
    for part in page["parts"]:
        colour, points = part["colour"], np.array(part.get("points", np.zeros((0, 2))))
        at = tuple((int(link), x, y) for link, x, y in part["at"])
        read = Stroke(part["name"], part["kind"], at, points, colour, tuple(part.get("links", (-1, -1))))
        corners = read.corners(poses)
        assert np.isfinite(corners).all() and len(corners) == max(len(points), len(at) if part["kind"] == "way" else 0)
    (rope,) = (part for part in page["parts"] if part["name"] == "line")
    assert rope["length"] == 4.5


def test_wheels_have_teeth_on_their_pitch_circles(workshop: Workshop) -> None:
    run = simulate(workshop.model(load_scene(SCENES / "planetary.toml")), until=0.1)
    teeth = drawn(run)["inner"]
    for stroke, radius in zip(teeth, (0.024, 0.018), strict=True):
        assert stroke.points[:, 0].min() < radius < stroke.points[:, 0].max() < 1.2 * radius
    assert {stroke.links[0] for stroke in teeth} == {1, 2}


def test_a_scene_without_such_effects_says_nothing_of_them(workshop: Workshop) -> None:
    model = workshop.model(ALL.partition("[[spring]]")[0] + "[gravity]\n[run]\nuntil = 0.2\n")
    assert "parts" not in model.data and [part.kind for part in model.parts] == ["slider"]


def test_links_in_line_are_bars() -> None:
    assert straightened(np.array([[0, 0], [0.5, 0], [1, 0], [-0.2, 0]])).tolist() == [[-0.2, 0], [1, 0]]
    assert len(straightened(np.array([[0, 0], [0.5, 0.01], [1, 0]]))) == 3


def test_links_that_meet_have_different_colours() -> None:
    """Seven rods in a ring: the seventh, whose turn the first colour is, meets the first rod."""
    run = bouncing(until=0.1, n=7)
    colours = link_colours(run.model, sample(run, run.t[:1]), 1.0)
    assert colours[:6] == [0, 1, 2, 3, 4, 5]
    assert all(one != other for one, other in zip(colours, [*colours[1:], colours[0]], strict=True))


def test_arrows_show_what_grounds_push(workshop: Workshop) -> None:
    """A stone at rest: one arrow, up from the ground, and one for the scale, by which it is its weight of 9.81 N; none
    unless asked for."""
    pytest.importorskip("matplotlib")
    stone = '[[link]]\nname = "stone"\nmass = 1\ninertia = 1\ncom = [0, 0]\npoints = { C = [0, 0] }\n'
    text = stone + '[[ground]]\nrestitution = 0\ncontacts = ["stone.C"]\n[gravity]\n[run]\nuntil = 0.1\n'
    run = simulate(workshop.model(text))
    texts = draw(run, forces=True).subfigs[0].axes[2].texts
    scale, arrow = [text for text in texts if text.arrow_patch is not None]
    assert np.allclose(arrow.xyann, (0, 0), atol=1e-12) and abs(arrow.xy[0]) < 1e-12
    assert [text.get_text() for text in texts if text.arrow_patch is None] == ["5 N"]
    assert scale.xy[1] == scale.xyann[1]
    assert 5.0 * arrow.xy[1] / (scale.xy[0] - scale.xyann[0]) == pytest.approx(9.81)
    plain = draw(run)
    assert not plain.subfigs[0].axes[2].texts
    below = plain.subfigs[1].axes[-1]
    assert "rounding" in below.texts[0].get_text() and np.ptp(below.get_ylim()) > 0.01


def test_no_label_is_cut_off(run: Run) -> None:
    pytest.importorskip("matplotlib")
    figure = draw(run)
    figure.canvas.draw()
    for axes in figure.subfigs[1].axes:
        box = axes.yaxis.label.get_window_extent()
        assert box.x0 > 0 and box.y0 > 0 and box.y1 < figure.bbox.height


def test_a_lone_body_flies_through_a_view_that_stands_still(workshop: Workshop) -> None:
    plate = (
        '[[link]]\nname = "plate"\nmass = 1\ninertia = 0.01\ncom = [0, 0]\npoints = { A = [-0.1, 0], B = [0.1, 0] }\n'
    )
    run = simulate(workshop.model(plate + "[start]\nvelocity = [8, 5]\n[gravity]\n[run]\nuntil = 1\n"))
    view = view_of(sample(run, frame_times(run, 20.0)))
    assert view.follow == (False, False) and view.half[0] > 4.0


def test_brakes_stand_on_the_first_link(run: Run) -> None:
    """Shoes about the pin, within the arcs of motors; pads beside the line."""
    poses = run.model.poses(run.q[-1])
    shoes, pads = drawn(run)["shoes"], drawn(run)["pads"]
    for shoe in shoes:
        assert np.all(np.hypot(*shoe.corners(poses).T) < 0.1) and shoe.filled and shoe.links == (-1, -1)
    assert shoes[0].corners(poses)[:, 1].min() > 0.0 > shoes[1].corners(poses)[:, 1].max()
    cart = run.model.point("cart.C", run.q[-1])
    for pad, side in zip(pads, (1.0, -1.0), strict=True):
        assert np.all(side * (pad.corners(poses) - cart)[:, 1] > 0.0)


def test_forces_say_how_large_they_are(run: Run, workshop: Workshop) -> None:
    """Those that stay; in plots and on the page of the player, with values that are set too."""
    said = {one.name: one.said for name in drawn(run) for one in drawn(run)[name] if one.said}
    assert said == {"push": "0.3 N", "along": "0.3 N"}
    assert {one["name"]: one["said"] for one in content(run)["parts"] if "said" in one} == said
    assert not {"0.3 N"} - {text.get_text() for text in draw(run).subfigs[0].axes[0].texts}
    heavier = simulate(run.model, until=0.01, params={"push.vector.y": -4.0})
    assert [one.said for one in drawn(heavier)["push"]] == ["4 N"]


@pytest.mark.parametrize(
    ("value", "below"), [(9.81, 5.0), (10.0, 10.0), (1.99, 1.0), (2.0, 2.0), (0.03, 0.02), (7e5, 5e5), (1.0, 1.0)]
)
def test_a_scale_is_a_round_number_that_fits(value: float, below: float) -> None:
    assert round_below(value) == below


def test_forces_are_arrows_and_torques_arcs(run: Run) -> None:
    poses, q = run.model.poses(run.q[-1]), run.q[-1]
    tip = run.model.point("arm.B", q)
    (push,), (along,), shake = drawn(run)["push"], drawn(run)["along"], drawn(run)["shake"]
    assert np.allclose(push.corners(poses)[1] - tip, [0.0, -0.25])
    assert np.allclose(along.corners(poses)[1] - tip, 0.25 * (tip - run.model.point("arm.A", q)))
    cart = run.model.point("cart.D", q)
    for arrow, axis in zip(shake, np.eye(2), strict=True):  # both ways, since it changes
        corners = arrow.corners(poses) - cart
        assert np.any(np.all(np.isclose(corners, 0.25 * axis), axis=1))
        assert np.any(np.all(np.isclose(corners, -0.25 * axis), axis=1))
    (twist,) = drawn(run)["twist"]
    x, y = (twist.corners(poses) - run.model.point("wheel.C", q))[:31].T
    assert np.all(np.diff(np.unwrap(np.arctan2(y, x))) < 0.0)  # clockwise


def test_no_arc_or_arrow_is_cut_off(run: Run) -> None:
    frames = sample(run, frame_times(run, 100.0))
    view = view_of(frames)
    for stroke in strokes(run.model, frames, 1.0):
        for k, poses in enumerate(frames.poses):
            assert np.all(np.abs(stroke.corners(poses) - view.centre[k]) < view.half), stroke.name


def test_the_view_of_a_disc_is_that_of_its_rim(workshop: Workshop) -> None:
    text = """
    [[link]]
    name = "wheel"
    disc = { mass = 1, radius = 0.5, centre = "C" }
    points = { C = [0, 0] }
    [[ground]]
    restitution = 0
    contacts = ["wheel.C"]
    radius = 0.5
    [start]
    position = [0, 0.5]
    velocity = [2, 0]
    [run]
    until = 1
    """
    run = simulate(workshop.model(text))
    view = view_of(sample(run, frame_times(run, 20.0)))
    assert np.allclose(view.half, 1.12 * np.array([1.5, 0.5])) and np.allclose(view.centre[0], [1.0, 0.5])
