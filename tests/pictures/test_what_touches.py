"""What touches is what is drawn, where it touches: plates, bolts, flashes, gaps; and nothing that no scene has."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from ccgen.runtime import Run, simulate
from ccgen.runtime.pictures.marks import FLASH
from ccgen.runtime.pictures.plot import draw
from ccgen.runtime.record.force_history import write_csv

from ..support.workshop import Workshop

pytest.importorskip("matplotlib")

BOX = """
[[link]]
name = "box"
free = true
plate = { mass = 1, corners = ["A", "B", "C", "D"] }
points = { A = [0, 0], B = [0.4, 0], D = [0, 0.3], C = [0.4, 0.3] }
[[link]]
name = "ball"
free = true
disc = { mass = 0.5, radius = 0.1 }
points = { M = [0, 0] }
[gravity]
[[ground]]
restitution = 0.3
contacts = ["box.A", "box.B"]
[[touch]]
between = ["ball.M", ["box.D", "box.C"]]
radius = 0.1
restitution = 0.6
[start]
poses = { box = [0, 0, 0], ball = [0.2, 0.8, 0] }
[run]
until = 0.4
"""
BOLT = """
[ground_link]
points = { H = [0, 0] }
[[link]]
name = "door"
rod = { mass = 20, between = ["H", "E"] }
points = { H = [0, 0], E = [0.8, 0] }
[[link]]
name = "bolt"
mass = 0.1
inertia = 1e-5
com = [0, 0]
points = { C = [0, 0], P = [-0.05, -0.006], Q = [0.001, -0.006], R = [0.014, 0.006], T = [-0.05, 0.006] }
OUTLINE
[[joint]]
between = ["ground.H", "door.H"]
[[joint]]
name = "slide"
type = "prismatic"
between = ["door.E", "bolt.C"]
axis = [1, 0]
[run]
until = 0.2
"""


@pytest.fixture(scope="module")
def falling(workshop: Workshop) -> Run:
    return simulate(workshop.model(BOX))


def test_an_impact_is_drawn_where_the_disc_touches(falling: Run) -> None:
    """Not at its centre, a tenth of a metre above."""
    (pose,) = (axes for axes in draw(falling).subfigs[0].axes if axes.get_title().startswith("impact 1"))
    circles = [line.get_xydata() for line in pose.lines if line.get_color() == FLASH]
    assert np.min(np.abs(np.concatenate(circles) - [0.2, 0.3]).max(axis=1)) < 1e-9
    assert np.max(np.concatenate(circles)[:, 1]) < 0.3 + 1e-9


def test_every_contact_has_a_gap(falling: Run) -> None:
    """Two corners stay on the ground; the ball's gap is that to the edge of a link that moves."""
    below = draw(falling).subfigs[1].axes[1]
    curves = {line.get_label(): line.get_xydata() for line in below.lines if not line.get_label().startswith("_")}
    assert set(curves) == {"box.A", "box.B", "ball.M"}
    t, gap = curves["ball.M"][curves["ball.M"][:, 0] < 0.28].T
    assert gap == pytest.approx(0.4 - 0.5 * 9.81 * t**2, abs=1e-9)
    assert not below.texts  # nothing is said to be constant


def test_an_impact_at_the_start_has_a_line(workshop: Workshop) -> None:
    """Over the edge of the axes, which covers what is beneath it."""
    model = workshop.model(BOX)
    q, u = model.start()
    q, u = q.copy(), u.copy()
    height = model.q_of.index("ball_y.slide")
    q[height], u[height] = 0.4, -1.0  # onto the box
    run = simulate(model, q, u, until=0.1)
    assert run.impacts[0].t == 0.0
    for axes in draw(run).subfigs[1].axes:
        at_start = [line for line in axes.lines if line.get_color() == FLASH and line.get_xdata()[0] == 0.0]
        assert len(at_start) == 1 and not at_start[0].get_clip_on()
        assert at_start[0].get_zorder() > axes.spines["left"].get_zorder()


def test_a_table_of_forces_has_no_joint_that_the_scene_has_not(falling: Run, tmp_path: Path) -> None:
    """Links that move freely are placed by joints of their own, on which nothing acts."""
    assert len(falling.model.joints) > 0 == len(falling.model.drawn_joints)
    heading, *rows = list(csv.reader(write_csv(falling, tmp_path / "forces.csv").read_text().splitlines()))
    assert {column.rpartition(".")[0] for column in heading[1:]} == {
        "ground_0.box.A",
        "ground_0.box.B",
        "touch_0.ball.M",
    }
    assert all(len(row) == len(heading) for row in rows)


@pytest.mark.parametrize("outline", [True, False])
def test_a_bolt_with_an_outline_has_no_block_over_it(outline: bool, workshop: Workshop) -> None:
    """Between its rails; the block of one without would hide it, being larger."""
    text = BOLT.replace("OUTLINE", 'outline = ["P", "Q", "R", "T"]' if outline else "")
    axes = draw(simulate(workshop.model(text))).subfigs[0].axes[0]
    assert sum(line.get_gid() == "slide" for line in axes.lines) == 2
    assert sum(patch.get_gid() == "slide" for patch in axes.patches) == (not outline)
