"""Pictures of sliding joints and round feet: lengths along lines over time, and discs with a spoke."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from ccgen.generator import chain, load_scene
from ccgen.runtime import Model, Run, simulate
from ccgen.runtime.pictures.frames import sample
from ccgen.runtime.pictures.plot import draw
from ccgen.runtime.pictures.view import view_of

from ..support.folders import SCENES
from ..support.player_page import data_of
from ..support.wheel import RADIUS, wheel
from ..support.workshop import Workshop


@pytest.fixture(scope="module")
def slider(workshop: Workshop) -> Run:
    return simulate(workshop.model(load_scene(SCENES / "slider-crank.toml")), until=0.5)


@pytest.fixture(scope="module")
def rolling(workshop: Workshop) -> Run:
    return simulate(workshop.model(wheel("friction = 0.5")), until=1.0)


def model_of(run: Run) -> Model:
    assert isinstance(run.model, Model)
    return run.model


def test_lengths_are_those_of_the_geometry(slider: Run) -> None:
    """The guide lies on the x axis from the origin: its length is where the slider is."""
    model = model_of(slider)
    poses = model.poses(slider.q)
    (name,) = model.slides(slider.q)
    assert name == "guide"
    assert np.max(np.abs(model.slides(slider.q)[name] - poses[:, 2, 0])) <= 1e-13
    assert model.slides(slider.q[3])[name] == pytest.approx(poses[3, 2, 0], abs=1e-13)


@pytest.mark.parametrize("scene", ["quick-return", "equal-length-slider-crank"])
def test_lengths_of_all_lines_have_the_coordinates_among_them(scene: str, workshop: Workshop) -> None:
    """Lengths are coordinates where the joint is in the tree; the others follow from the points of both links."""
    model = workshop.model(load_scene(SCENES / f"{scene}.toml"))
    q = simulate(model, until=0.3).q
    lengths, poses = model.slides(q), model.poses(q)
    coordinates = [of for kind, of in model.data["coordinates"] if kind == "slide"]
    for column, joint in enumerate(coordinates, start=len(model.q_names) - len(coordinates)):
        assert np.max(np.abs(lengths[joint] - q[:, column])) <= 1e-13
    for joint, line in model.data["lines"].items():
        ends = []
        for link, point in zip(line["links"], line["points"], strict=True):
            x, y = (model.parameters[c] if isinstance(c, str) else c for c in point)
            pose = np.zeros((len(q), 3)) if link < 0 else poses[:, link]
            ends.append(pose[:, 0] + 1j * pose[:, 1] + (x + 1j * y) * np.exp(1j * pose[:, 2]))
        assert np.max(np.abs(np.abs(lengths[joint]) - np.abs(ends[1] - ends[0]))) <= 1e-12


def test_the_figure_shows_lengths_where_nothing_touches(slider: Run) -> None:
    pytest.importorskip("matplotlib")
    below = draw(slider).subfigs[1].axes[1]
    assert below.get_ylabel() == "along line [m]"
    (line,) = below.lines
    t, length = line.get_xydata().T
    assert line.get_label() == "guide" and np.ptp(length) > 0.1
    assert length == pytest.approx(model_of(slider).poses(slider.at(t)[0])[:, 2, 0], abs=1e-12)


def test_quick_turns_are_drawn_with_every_row(workshop: Workshop) -> None:
    """A crank that turns a hundred times: the guide's ends, coupler and crank in a line, are those of the geometry."""
    pytest.importorskip("matplotlib")
    model = workshop.model(load_scene(SCENES / "slider-crank.toml"))
    q, u = model.start()
    run = simulate(model, q, model.project(q, 300.0 * u / np.abs(u).max())[1], until=2.0)
    (name,) = model.slides(q)
    (line,) = draw(run).subfigs[1].axes[1].lines
    shown, rows = np.asarray(line.get_ydata()), model.slides(run.q)[name]
    turns = np.abs(run.q[-1] - run.q[0]).max() / (2.0 * np.pi)
    assert turns > 50
    assert shown.max() >= rows.max() and shown.min() <= rows.min()
    drawn = {float(y) for y in shown}
    tops = rows[1:-1][(rows[1:-1] > rows[:-2]) & (rows[1:-1] > rows[2:])]
    assert len(tops) > 50 and sum(float(y) in drawn for y in tops) >= 0.9 * len(tops)


def test_the_figure_shows_heights_where_something_touches(rolling: Run) -> None:
    pytest.importorskip("matplotlib")
    assert draw(rolling).subfigs[1].axes[1].get_ylabel() == "above ground [m]"


def test_the_figure_has_a_curve_for_every_contact(workshop: Workshop) -> None:
    """A rod between a floor and a wall: each end has two curves, its distance from either."""
    pytest.importorskip("matplotlib")
    walls = [{"restitution": 0.5}, {"restitution": 0.5, "point": [-2.0, 0.0], "normal": [1.0, 0.0]}]
    run = simulate(workshop.model(chain(1, gravity=True, start={"height": 1.0}, ground=walls)), until=0.1)
    assert len(run.model.contacts) == 4
    below = draw(run).subfigs[1].axes[1]
    assert below.get_ylabel() == "off grounds [m]"
    gaps = {
        f"{point} on {ground}": gap
        for (point, ground), gap in zip(run.model.contacts, run.model.gaps(run.q[0]), strict=True)
    }
    drawn = {line.get_label(): line.get_ydata()[0] for line in below.lines if line.get_label() in gaps}
    assert len(gaps) == 4 and drawn == pytest.approx(gaps, abs=1e-12)


def test_the_view_holds_the_discs(rolling: Run) -> None:
    (disc,) = model_of(rolling).discs
    assert (disc.link, disc.radius, disc.centre.tolist()) == (0, RADIUS, [0.0, 0.0])
    frames = sample(rolling, np.linspace(0.0, 1.0, 5))
    view = view_of(frames)
    assert np.all(np.abs(frames.poses[:, 0, :2] - view.centre) + RADIUS < view.half)


def test_a_disc_touches_its_ground_and_turns(rolling: Run) -> None:
    """The rim in the figure is a circle about the centre that reaches the slope; its spoke turns with the link."""
    pytest.importorskip("matplotlib")
    model, (point, normal) = model_of(rolling), next(iter(rolling.model.ground_planes().values()))
    first, last = (draw(rolling).subfigs[0].axes[k] for k in (0, -1))
    for axes, row in ((first, 0), (last, -1)):
        (rim,) = (line.get_xydata() for line in axes.lines if len(line.get_xydata()) > 50)
        centre, angle = model.poses(rolling.q[row])[0, :2], model.poses(rolling.q[row])[0, 2]
        assert np.hypot(*(rim[:-1] - centre).T) == pytest.approx(RADIUS, rel=1e-12)
        assert rim[-1] == pytest.approx(centre) and (rim[:-1] - point) @ normal == pytest.approx(
            ((rim[:-1] - centre) @ normal + RADIUS), abs=1e-8
        )
        assert rim[-2] - centre == pytest.approx(RADIUS * np.array([np.cos(angle), np.sin(angle)]), abs=1e-12)


def test_the_page_has_the_discs(rolling: Run, slider: Run, tmp_path: Path) -> None:
    (link,) = data_of(rolling.animate(tmp_path / "wheel.html").read_text(encoding="utf-8"))["links"]
    assert link["discs"] == [[0, 0, RADIUS]]
    assert all(
        link["discs"] == []
        for link in data_of(slider.animate(tmp_path / "slider.html").read_text(encoding="utf-8"))["links"]
    )


def test_a_radius_set_at_run_time_is_drawn(workshop: Workshop) -> None:
    model = workshop.model(wheel("friction = 0.5")).with_parameters({"ground_0.radius": 0.1})
    assert [disc.radius for disc in model.discs] == [0.1]
