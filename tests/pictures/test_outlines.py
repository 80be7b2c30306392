"""``outline`` of a link: what pictures draw of it, and nothing else that it changes."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from ccgen.generator import Scene, SceneError, load_scene
from ccgen.generator.pipeline import listing
from ccgen.runtime import simulate
from ccgen.runtime.pictures.player import content
from ccgen.runtime.pictures.plot import draw

from ..support.workshop import Workshop

WHEEL = """
name = "wheel"
[ground_link]
points = { O = [0, 0] }
[[link]]
name = "wheel"
plate = { mass = 1, corners = ["A", "B", "C"] }
points = { A = [0.1, 0], hub = [0, 0], B = [-0.1, 0.1], C = [-0.1, -0.1] }
[[link]]
name = "arm"
rod = { mass = 1 }
points = { A = [0, 0], B = [0.3, 0] }
[[joint]]
between = ["ground.O", "wheel.hub"]
[[joint]]
between = ["wheel.A", "arm.A"]
[gravity]
[run]
until = 0.5
"""
ROUND = 'outline = ["A", "B", [-0.2, 0], "C"]\n'


def of_wheel(text: str) -> str:
    return WHEEL.replace('name = "wheel"\nplate', f'name = "wheel"\n{text}plate')


def test_default_is_the_plate_and_else_all_points(workshop: Workshop) -> None:
    """The hub is no corner: drawn through it, the triangle would have a dent that its mass has not."""
    model = workshop.model(WHEEL)
    assert [outline.tolist() for outline in model.outlines] == [
        [[0.1, 0], [-0.1, 0.1], [-0.1, -0.1]],
        [[0, 0], [0.3, 0]],
    ]
    plain = workshop.model(WHEEL.replace(', corners = ["A", "B", "C"]', ""))
    assert "drawn" not in plain.data and len(plain.outlines[0]) == 4


def test_a_plate_is_drawn_in_the_order_of_its_corners(workshop: Workshop) -> None:
    """Points in another order would draw a bow tie, of another area than the plate's."""
    order = WHEEL.replace('["A", "B", "C"]', '["A", "hub", "C", "B"]')
    (outline, _) = workshop.model(order).outlines
    assert outline.tolist() == [[0.1, 0], [0, 0], [-0.1, -0.1], [-0.1, 0.1]]


def test_outlines_are_drawn_and_change_nothing_else(workshop: Workshop) -> None:
    plain, model = workshop.model(WHEEL), workshop.model(of_wheel(ROUND))
    assert model.outlines[0].tolist() == [[0.1, 0], [-0.1, 0.1], [-0.2, 0], [-0.1, -0.1]]
    assert model.outlines[1].tolist() == plain.outlines[1].tolist()
    assert model.length == plain.length and model.points == plain.points
    run, other = simulate(model), simulate(plain)
    assert np.array_equal(run.q, other.q)
    wheel, arm = content(run)["links"]
    assert np.ravel(wheel["outline"]).tolist() == [0.1, 0, -0.1, 0.1, -0.2, 0, -0.1, -0.1]
    assert np.ravel(arm["outline"]).tolist() == [0, 0, 0.3, 0]


def test_the_listing_does_not_know_outlines(tmp_path: Path) -> None:
    def scene(text: str) -> Scene:
        (tmp_path / "wheel.toml").write_text(text)
        return load_scene(tmp_path / "wheel.toml")

    assert listing(scene(WHEEL)) == listing(scene(of_wheel(ROUND)))
    assert scene(WHEEL).canonical() != scene(of_wheel(ROUND)).canonical()


def test_points_of_outlines_move_with_parameters(workshop: Workshop) -> None:
    model = workshop.model(of_wheel(ROUND))
    model.parameters["wheel.points.B.x"] = -0.15
    assert model.outlines[0][1].tolist() == [-0.15, 0.1]
    model.parameters["wheel.points.B.x"] = -0.1
    assert json.dumps(model.data["drawn"]["wheel"][2]) == "[-0.2, 0.0]"


def test_nothing_is_drawn(workshop: Workshop, tmp_path: Path) -> None:
    """Of one link, and of all, of which the plot and the page are none the worse."""
    text = of_wheel("outline = []\n").replace("rod =", "outline = []\nrod =")
    run = simulate(workshop.model(text))
    assert [len(outline) for outline in run.model.outlines] == [0, 0]
    run.plot(tmp_path / "plot.png")
    assert [np.size(link["outline"]) for link in content(run)["links"]] == [0, 0]
    run.animate(tmp_path / "player.html")
    alone = "[[link]]\noutline = []\nmass = 1\ninertia = 1\ncom = [0, 0]\npoints = { A = [0, 0] }\n[gravity]\n"
    falling = simulate(workshop.model(alone + "[run]\nuntil = 0.1\n"))
    falling.plot(tmp_path / "plot.png")


def test_outlines_of_welded_links(workshop: Workshop) -> None:
    """One after the other, each as it says or else all its points, in the body's frame."""
    weld = '[[joint]]\ntype = "weld"\nbetween = ["arm.B", "flag.F"]\nangle = "90 deg"\n'
    flag = '[[link]]\nname = "flag"\nmass = 0.1\ninertia = 0.01\ncom = [0, 0]\npoints = { F = [0, 0], G = [0.2, 0] }\n'
    text = WHEEL.replace("[[joint]]", flag + 'outline = ["F", [0.1, 0.1]]\n[[joint]]', 1) + weld
    model = workshop.model(text)
    assert model.outlines[1] == pytest.approx(np.array([[0, 0], [0.3, 0], [0.3, 0], [0.2, 0.1]]), abs=1e-15)


def test_wrong_outlines(tmp_path: Path) -> None:
    path = tmp_path / "wheel.toml"
    path.write_text(of_wheel('outline = ["A", "D", [1], 3]\n'))
    with pytest.raises(SceneError) as caught:
        load_scene(path)
    keys = [fault.key for fault in caught.value.faults]
    assert {"link[0].outline[2]", "link[0].outline[3]"} <= set(keys)
    path.write_text(of_wheel('outline = ["A", "D"]\n'))
    with pytest.raises(SceneError, match=r'link\[0\].outline\[1\]: found "D", expected a point of the link: A, hub'):
        load_scene(path)


STONE = """
name = "stone"
[[link]]
name = "stone"
mass = 1
inertia = 1e-4
com = [0, 0]
points = { C = [0, 0] }
[start]
position = [1, 2]
velocity = [3, 4]
[gravity]
[run]
until = 0.8
"""


def test_a_link_of_one_point_is_a_dot_on_its_way(workshop: Workshop) -> None:
    """A thrown stone is where its parabola is, and the view stands still round all of that."""
    pytest.importorskip("matplotlib")
    run = simulate(workshop.model(STONE))
    poses, _ = draw(run).subfigs
    times = np.linspace(0.0, 0.8, len(poses.axes))
    for axes, t in zip(poses.axes, times, strict=True):
        dots = [line for line in axes.lines if line.get_marker() == "o" and line.get_color() != "white"]
        assert [line.get_xydata().tolist() for line in dots] == [
            [pytest.approx([1 + 3 * t, 2 + 4 * t - 4.905 * t * t], abs=1e-9)]
        ]
        (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
        assert left < 1.0 and right > 3.4 and low < 2.0 and high > 2 + 16 / 2 / 9.81
    shown = content(run)
    assert shown["links"][0]["outline"] == [[0.0, 0.0]] and not shown["view"]["follow"]


def test_a_view_of_one_point_has_the_ground_in_it(workshop: Workshop) -> None:
    """What hangs on a spring is seen with the point that it hangs on."""
    pytest.importorskip("matplotlib")
    spring = '[ground_link]\npoints = { O = [-3, 4] }\n[[spring]]\nbetween = ["ground.O", "stone.C"]\nstiffness = 9\n'
    run = simulate(workshop.model(STONE + spring))
    for axes in draw(run).subfigs[0].axes:
        (left, right), (_, high) = axes.get_xlim(), axes.get_ylim()
        assert left < -3.0 and high > 4.0 and right - left < 50.0


def test_a_plate_is_drawn_with_its_corners(workshop: Workshop) -> None:
    """Not as the polygon of the link's points, unless it says so."""
    plate = "plate = { mass = 1, corners = [[0, 0], [2, 0], [2, 1], [0, 1]] }"
    text = f'[[link]]\nname = "box"\n{plate}\npoints = {{ A = [0, 0], B = [1, 2], C = [3, 1] }}\n'
    outlines = [workshop.model(text + more).outlines[0] for more in ("", 'outline = ["A", "B", "C"]\n')]
    assert np.allclose(outlines[0], [[0, 0], [2, 0], [2, 1], [0, 1]])
    assert np.allclose(outlines[1], [[0, 0], [1, 2], [3, 1]])
