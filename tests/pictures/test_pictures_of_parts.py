"""Springs, dampers, guides and blocks in pictures; frames that are apart; axes about what is constant."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from ccgen.generator import load_scene
from ccgen.runtime import Run, simulate
from ccgen.runtime.pictures.frames import sample, view_of
from ccgen.runtime.pictures.guides import guides_of
from ccgen.runtime.pictures.plot import Drawing, instants, is_area, keep_level, pivots_of
from ccgen.runtime.pictures.strut_shape import shape

from ..support.folders import SCENES
from ..support.player_page import data_of
from ..support.workshop import Workshop

SHUTTLE = """
name = "shuttle"
[ground_link]
points = { O = [0, 0], W = [-0.5, 0], H = [0.2, 0.6] }
[[link]]
name = "ram"
mass = 2
inertia = 0.1
com = [0.1, 0]
points = { A = [0, 0], B = [0.2, 0] }
[[joint]]
name = "guide"
type = "prismatic"
between = ["ground.O", "ram.A"]
axis = "30 deg"
angle = "30 deg"
[[spring]]
name = "coil"
between = ["ground.W", "ram.B"]
stiffness = 100
length = 0.6
[[damper]]
between = ["ground.H", "ram.B"]
damping = 1
[start]
slides = { guide = 0.3 }
[run]
until = 1
"""


@pytest.fixture(scope="module")
def shuttle(workshop: Workshop) -> Run:
    return simulate(workshop.model(SHUTTLE))


@pytest.mark.parametrize("kind", ["spring", "damper"])
def test_a_strut_goes_from_end_to_end_at_any_length(kind: str) -> None:
    """Along the way between its ends, of the same width at any length, both sides alike."""
    for length in (0.2, 1.0, 3.0):
        ends = np.array([[1.0, 2.0], [1.0 + 0.6 * length, 2.0 + 0.8 * length]])
        points = shape(kind, ends, 0.05)
        assert np.allclose(points[0], ends[0], atol=1e-15) and np.allclose(points[-1], ends[1], atol=1e-15)
        away = points[np.isfinite(points[:, 0])] - ends[0]
        along, aside = away @ [0.6, 0.8], away @ [-0.8, 0.6]
        assert along.min() == pytest.approx(0.0, abs=1e-15) and along.max() == pytest.approx(length)
        assert aside.max() == pytest.approx(0.05) and aside.min() == pytest.approx(-0.05)
    assert np.isfinite(shape(kind, np.zeros((2, 2)), 0.05)).any()  # both ends at one place


def test_struts_guides_and_blocks_are_where_the_links_are(shuttle: Run) -> None:
    """On the axes: ends at the points that the scene names, the block about the slider's, the guide along the line."""
    from matplotlib.figure import Figure

    frames = sample(shuttle, np.array([0.0, 0.31, 0.77]))
    view = view_of(shuttle.model, frames)
    guides = guides_of(shuttle.model, frames, view.size)
    assert [guide.kind for guide in guides] == ["line", "block"]
    drawing = Drawing(Figure().subplots(), shuttle.model, view, guides)
    along = np.array([np.cos(np.pi / 6), np.sin(np.pi / 6)])
    for k in range(3):
        drawing.show(frames, k, view.centre[k])
        slide = shuttle.model.slides(frames.q[k])["guide"]
        tip = (slide + 0.2) * along
        for line, foot in zip(drawing._struts, ([-0.5, 0.0], [0.2, 0.6]), strict=True):
            drawn = np.column_stack(line.get_data())
            assert np.allclose(drawn[0], foot, atol=1e-14) and np.allclose(drawn[-1], tip, atol=1e-12)
        line, block = drawing._guides
        ends = np.column_stack(line.get_data())
        assert np.abs(ends @ [-along[1], along[0]]).max() < 1e-14
        assert (ends @ along).min() < slide < (ends @ along).max()
        corners = block.get_xy()[:4]
        assert np.allclose(corners.mean(axis=0), slide * along, atol=1e-12)
        assert np.allclose((corners[1] - corners[0]) / np.hypot(*(corners[1] - corners[0])), along, atol=1e-12)


def test_the_page_has_them(shuttle: Run, tmp_path: Path) -> None:
    data = data_of(shuttle.animate(tmp_path / "shuttle.html").read_text(encoding="utf-8"))
    assert [strut["kind"] for strut in data["struts"]] == ["spring", "damper"]
    assert data["struts"][0]["ends"] == [[-1, -0.5, 0.0], [0, 0.2, 0.0]]
    assert sorted(data["shapes"]) == ["damper", "spring"]
    assert [(guide["kind"], guide["link"]) for guide in data["guides"]] == [("line", -1), ("block", 0)]
    assert data["groundPoints"] == [[-0.5, 0.0], [0.2, 0.6]]  # and no pivot where the guide begins


def test_carriages_have_no_guides(workshop: Workshop) -> None:
    """Bodies that are free have carriages that nobody sees; the crank's slider has a guide and a block."""
    run = simulate(workshop.model(load_scene(SCENES / "loose-slider-crank.toml")), until=0.01)
    frames = sample(run, np.array([0.0, 0.01]))
    guides = guides_of(run.model, frames, 1.0)
    assert all(guide.link < 0 or len(run.model.outlines[guide.link]) for guide in guides)
    assert len(guides) < 2 * len(run.model.slides(run.q[0]))


def test_points_in_a_line_are_no_area() -> None:
    assert not is_area(np.array([[0.0, 0.0], [1.0, 0.5], [2.0, 1.0]]))
    assert not is_area(np.array([[0.0, 0.0], [1.0, 0.0]])) and not is_area(np.zeros((3, 2)))
    assert is_area(np.array([[0.0, 0.0], [1.0, 0.5], [2.0, 0.9]]))


def test_ends_of_edges_are_no_pivots(workshop: Workshop) -> None:
    model = workshop.model(
        SHUTTLE + '[[touch]]\nbetween = ["ram.B", ["ground.W", "ground.H"]]\nradius = 0.01\nrestitution = 0.5\n'
    )
    assert pivots_of(model, ()).tolist() == [[0.0, 0.0]]


def test_frames_of_impacts_are_apart_and_the_largest(workshop: Workshop) -> None:
    """Of a ring that comes to rest by hundreds of impacts, most of them at the end."""
    run = simulate(workshop.model(load_scene(SCENES / "falling-hexagon.toml")), until=2.5)
    assert len(run.impacts) > 100
    shown = instants(run)
    times = np.array([t for t, _ in shown])
    assert len(times) == 6 and np.diff(times).min() >= 2.5 / 24
    largest = max(range(len(run.impacts)), key=lambda k: run.impacts[k].energy_loss)
    assert f"impact {largest + 1}" in [title for _, title in shown]


def test_what_is_constant_but_for_rounding_is_drawn_so() -> None:
    """A gap of 1e-16 m of a mechanism of a metre; an energy of 36 J that keeps 14 digits. What changes is left."""
    from matplotlib.figure import Figure

    t = np.linspace(0.0, 1.0, 50)
    for constant, size, least in ((0.0, 1.0, 0.1), (36.0, 0.0, 3.0)):
        axes = Figure().subplots()
        curve = constant + 1e-16 * max(1.0, constant) * np.sin(40 * t)
        axes.plot(t, curve)
        keep_level(axes, [curve, np.full(50, np.nan)], size)
        low, high = axes.get_ylim()
        assert high - low > least and low < constant < high
    axes = Figure().subplots()
    axes.plot(t, 1e-3 * t)
    before = axes.get_ylim()
    keep_level(axes, [1e-3 * t], 1.0)
    keep_level(axes, [np.full(50, np.nan)])
    assert axes.get_ylim() == before
