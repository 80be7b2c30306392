"""The pictures of a run: the page that plays, the figure, and the moving picture."""

from __future__ import annotations

import re
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ccgen.runtime.pictures.frames import frame_times, placed, sample, shown_impacts
from ccgen.runtime.pictures.instants import instants
from ccgen.runtime.pictures.plot import draw
from ccgen.runtime.pictures.view import view_of
from ccgen.runtime.run import Run

from ..support.player_page import data_of
from ..support.rigid_polygon import G, bouncing
from ..support.stiff_crank import turning


@pytest.fixture(scope="module")
def run() -> Run:
    return bouncing()


@pytest.fixture(scope="module")
def page(run: Run, tmp_path_factory: pytest.TempPathFactory) -> str:
    return run.animate(tmp_path_factory.mktemp("page") / "a.html").read_text(encoding="utf-8")


# --- frames and views


def test_frames_are_regular_and_have_the_impacts(run: Run) -> None:
    times = frame_times(run, 60)
    impacts = [impact.t for impact in run.impacts]
    assert times[0] == 0.0 and times[-1] == 1.25 and np.all(np.diff(times) > 1e-5)
    assert set(impacts) <= set(times)
    regular = np.setdiff1d(times, impacts)
    assert regular * 60 == pytest.approx(np.arange(76), abs=1e-9)


def test_a_regular_frame_gives_way_to_an_impact_beside_it(run: Run) -> None:
    near = replace(run, t=np.where(run.t == run.impacts[0].t, 27 / 60 + 1e-8, run.t), impacts=(), phases=())
    near = replace(near, impacts=(replace(run.impacts[0], t=27 / 60 + 1e-8),))
    times = frame_times(near, 60)
    assert np.count_nonzero(np.abs(times - 0.45) < 1e-6) == 1 and near.impacts[0].t in times


def test_of_very_many_impacts_the_largest_are_shown(run: Run) -> None:
    """Forty instants with fifty impacts each, too near each other to be told apart: of each the one that takes most."""
    assert shown_impacts(run) == list(enumerate(run.impacts, start=1))
    one, times = run.impacts[0], [0.03 * k + 1e-9 * i for k in range(40) for i in range(50)]
    many = tuple(replace(one, t=t, energy_loss=float(n % 50 == n // 50)) for n, t in enumerate(times))
    rows = [np.repeat(row[:1], 2000, axis=0) for row in (run.q, run.u)]
    crowded = replace(run, t=np.array(times), q=rows[0], u=rows[1], impacts=many, phases=())
    assert [number for number, _ in shown_impacts(crowded)] == [50 * k + k + 1 for k in range(40)]


def test_view_is_still_for_small_motions_and_holds_all_of_them(run: Run) -> None:
    frames = sample(run, frame_times(run, 60))
    view = view_of(frames)
    assert view.follow == (False, False) and np.ptp(view.centre, axis=0) == pytest.approx([0, 0])
    assert np.all(np.abs(frames.joints - view.centre[:, None]) < view.half)
    assert view.size == pytest.approx(2.0, rel=0.03)


def test_view_follows_long_motions_along_their_axis_only() -> None:
    run = bouncing(drift=12.0)
    frames = sample(run, frame_times(run, 60))
    view = view_of(frames)
    assert view.follow == (True, False) and view.half[0] < 2.0
    assert view.centre[-1, 0] - view.centre[0, 0] == pytest.approx(12.0 * 1.25, rel=1e-9)
    assert np.all(np.abs(frames.joints - view.centre[:, None]) < view.half)


def test_outlines_are_placed_by_turning_then_moving() -> None:
    outline = np.array([[1.0, 0.0], [0.0, 2.0]])
    poses = np.array([[3.0, 4.0, np.pi / 2], [0.0, 0.0, 0.0]])
    assert placed(outline, poses) == pytest.approx(np.array([[[3, 5], [1, 4]], [[1, 0], [0, 2]]]), abs=1e-15)


# --- the page


def test_page_shows_the_free_fall(run: Run, page: str) -> None:
    data = data_of(page)
    t = np.array(data["t"])
    falling = t < run.impacts[0].t
    first = np.array(data["joints"])[falling][:, :2]
    start = run.model.point("joint_0", run.q[0])
    assert first == pytest.approx(start - np.outer(0.5 * G * t[falling] ** 2, [0, 1]), abs=2e-5)
    poses = np.array(data["poses"]).reshape(len(t), 6, 3)
    assert poses[falling, :, 2] == pytest.approx(np.tile(run.q[0, 2:], (falling.sum(), 1)), abs=1e-5)
    assert poses[:, :, :2] == pytest.approx(np.array(data["joints"]).reshape(-1, 6, 2), abs=1e-9)


def test_page_agrees_with_the_run_everywhere(run: Run, page: str) -> None:
    data = data_of(page)
    q, u = run.at(np.clip(data["t"], 0.0, 1.25))
    poses = np.array(data["poses"]).reshape(-1, 6, 3)
    assert poses == pytest.approx(run.model.poses(q), abs=2e-5)
    smooth = np.min(np.abs(np.array(data["t"])[:, None] - [impact.t for impact in run.impacts]), axis=1) > 1e-6
    energy = _energies(data)
    assert energy[smooth] == pytest.approx(np.stack(run.model.energy(q, u), axis=1)[smooth], abs=1e-4)


def _energies(data: dict[str, Any]) -> Any:
    """Kinetic and potential energy at every frame, of the two at an impact those after it."""
    columns = {column["name"]: column["values"] for column in data["chart"]["columns"]}
    rows = np.searchsorted(data["chart"]["t"], data["t"], side="right") - 1
    assert np.array_equal(np.array(data["chart"]["t"])[rows], data["t"])
    return np.array([columns["kinetic_energy"], columns["potential_energy"]]).T[rows]


def test_page_has_every_impact(run: Run, page: str) -> None:
    data = data_of(page)
    assert len(data["impacts"]) == len(run.impacts)
    for shown, impact in zip(data["impacts"], run.impacts, strict=True):
        assert shown["t"] == pytest.approx(impact.t, abs=1e-9) and shown["t"] in data["t"]
        assert shown["loss"] == pytest.approx(impact.energy_loss, rel=1e-5)
        ((point, ground),) = impact.contacts
        (contact,) = shown["contacts"]
        assert (contact["point"], contact["ground"]) == (point, ground)
        assert contact["impulse"] == pytest.approx(impact.impulses[0], rel=1e-5)
        assert contact["at"] == pytest.approx(run.model.point(point, run.at(impact.t)[0]), abs=2e-5)
        after = run.model.energy(run.at(impact.t)[0], impact.u_plus)
        assert _energies(data)[data["t"].index(shown["t"])] == pytest.approx(after, abs=1e-3)


def test_page_rounds_its_numbers(page: str) -> None:
    for row in data_of(page)["poses"]:
        assert all(abs(value * 1e5 - round(value * 1e5)) < 1e-6 for value in row)
    assert "-0.0," not in page


def test_page_is_complete_in_itself(page: str) -> None:
    class Reader(HTMLParser):
        def __init__(self) -> None:
            super().__init__()
            self.tags: list[str] = []
            self.ids: set[str] = set()

        def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
            self.tags.append(tag)
            self.ids |= {value for name, value in attrs if name == "id" and value}
            assert not {"src", "href"} & {name for name, _ in attrs}

    reader = Reader()
    reader.feed(page)
    assert "://" not in page and "@import" not in page and "@@" not in page and "link" not in reader.tags
    for wanted in ("canvas", "play", "scrub", "speed", "trace", "marks", "clock", "energy", "event"):
        assert wanted in reader.ids
    asked = set(re.findall(r'find\("(\w+)"\)', page))
    assert asked <= reader.ids
    assert re.findall(r'<option value="([\d.]+)"', page) == ["0.01", "0.1", "0.25", "0.5", "1", "2", "5"]


def test_page_bytes_are_the_same_again(page: str, tmp_path: Path) -> None:
    assert bouncing().animate(tmp_path / "b.html").read_bytes() == page.encode()


def test_names_cannot_break_the_page(tmp_path: Path) -> None:
    run = turning()
    page = run.animate(tmp_path / "a.html").read_text(encoding="utf-8")
    assert "<title>four-bar &lt;/script&gt;</title>" in page
    data = data_of(page)
    assert data["name"] == run.model.name and data["message"] == "made to stop"
    assert [len(link["outline"]) for link in data["links"]] == [2, 3, 2]
    assert data["groundPoints"] == [[0, 0], [1, 0]] and not data["grounds"] and not data["impacts"]


def test_moving_view_has_a_centre_for_every_frame(tmp_path: Path, page: str) -> None:
    data = data_of(bouncing(drift=12.0).animate(tmp_path / "a.html").read_text(encoding="utf-8"))
    assert data["view"]["follow"] and len(data["view"]["centre"]) == len(data["t"])
    assert len(data_of(page)["view"]["centre"]) == 1
    (ground,) = data["grounds"]
    assert ground == {"name": "ground_0", "point": [0, 0], "normal": [0, 1]}


def test_long_runs_get_fewer_frames(run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("ccgen.runtime.pictures.player.MOST_NUMBERS", 34 * 20)
    data = data_of(run.animate(tmp_path / "a.html").read_text(encoding="utf-8"))
    assert 20 <= len(data["t"]) <= 20 + 2 + len(run.impacts)


# --- the figure


def picture(path: Path) -> Any:
    image = pytest.importorskip("PIL.Image")
    return np.asarray(image.open(path).convert("RGB")).astype(int)


def has_colour(pixels: Any, colour: str, least: int = 20) -> bool:
    wanted = [int(colour[k : k + 2], 16) for k in (1, 3, 5)]
    return bool(np.count_nonzero(np.abs(pixels - wanted).max(axis=-1) < 24) >= least)


@pytest.mark.slow
def test_figure_is_drawn_at_its_size(run: Run, tmp_path: Path) -> None:
    figure = run.plot(tmp_path / "a.png")
    pixels = picture(tmp_path / "a.png")
    assert pixels.shape[1] == 1320 and pixels.shape[0] == pytest.approx(figure.get_figheight() * 120, abs=1)
    for colour in ("#4477aa", "#cc6677", "#117733", "#ddaa33", "#88ccee", "#aa4499", "#d55e00", "#222222"):
        assert has_colour(pixels, colour), colour
    ink = (pixels < 200).any(axis=-1)
    height, width = ink.shape
    for rows in (slice(0, height // 3), slice(height // 3, 2 * height // 3), slice(2 * height // 3, height)):
        assert ink[rows, : width // 2].mean() > 0.005 and ink[rows, width // 2 :].mean() > 0.005
    assert [path.name for path in tmp_path.iterdir()] == ["a.png"]


def test_figure_shows_the_curves_and_the_impacts(run: Run) -> None:
    collections = pytest.importorskip("matplotlib.collections")
    poses, below = draw(run).subfigs
    assert len(poses.axes) == 6
    energy, heights, closure = below.axes
    kinetic, potential, total = (energy.lines[k].get_xydata() for k in range(3))
    assert kinetic[:, 1] + potential[:, 1] == pytest.approx(total[:, 1])
    assert total[0, 1] - total[-1, 1] == pytest.approx(sum(impact.energy_loss for impact in run.impacts), rel=1e-9)
    for axes in below.axes:
        lines = [one for one in axes.collections if isinstance(one, collections.LineCollection)]
        marks = [line for some in lines for line in some.get_segments()]
        assert all(np.array_equal(line[:, 1], [0.0, 1.0]) for line in marks)  # of the height
        upright = [line[0, 0] for line in marks if line[0, 0] == line[1, 0]]
        assert upright == [impact.t for impact in run.impacts]
    lowest = heights.lines[0].get_xydata()
    falling = lowest[lowest[:, 0] < run.impacts[0].t]
    assert falling[:, 1] == pytest.approx(1 - 0.5 * G * falling[:, 0] ** 2, abs=1e-12)
    assert closure.get_yscale() == "log" and closure.get_xlim() == (0.0, 1.25)
    again = draw(run).subfigs[0].axes[2].get_title()
    assert again == "impact 1\n$t$ = 0.4515 s"


def test_figure_of_a_mechanism_without_contacts(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    figure = turning().plot(tmp_path / "a.png")
    assert "made to stop" in figure.get_suptitle()
    heights = figure.subfigs[1].axes[1]
    assert [line.get_label() for line in heights.lines] == ["joint_1", "joint_2"]
    assert has_colour(picture(tmp_path / "a.png"), "#eec9d0", 2000)  # the coupler is an area


def test_figure_of_one_instant_and_of_many_joints(run: Run, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    alone = replace(run, t=run.t[:1], q=run.q[:1], u=run.u[:1], impacts=(), phases=())
    alone.plot(tmp_path / "a.png")
    alone.animate(tmp_path / "a.html")
    alone.animate(tmp_path / "a.gif")
    figure = bouncing(until=0.1, n=24).plot()
    assert figure.subfigs[1].axes[1].get_legend() is None


def test_instants_of_a_run(run: Run) -> None:
    """The last impact looks as the end does."""
    assert [title for _, title in instants(run)] == ["start", "", "impact 1", "impact 2", "impact 3", "end"]
    assert [title for _, title in instants(run, 4)] == ["start", "impact 1", "impact 2", "end"]
    quiet = bouncing(until=0.25)
    assert [t for t, _ in instants(quiet)] == pytest.approx([0, 0.05, 0.1, 0.15, 0.2, 0.25])
    assert [title for _, title in instants(quiet)] == ["start", "", "", "", "", "end"]


def test_instants_of_many_impacts_are_even(run: Run) -> None:
    """Forty impacts, of which no few are larger than all others or far from all others."""
    times = np.linspace(0.0, 1.25, 42)
    rows = [np.repeat(row[:1], 42, axis=0) for row in (run.q, run.u)]
    many = tuple(replace(run.impacts[0], t=float(t)) for t in times[1:-1])
    crowded = replace(run, t=times, q=rows[0], u=rows[1], impacts=many, phases=())
    assert [title for _, title in instants(crowded)] == ["start", "", "", "", "", "end"]
    assert np.diff([t for t, _ in instants(crowded)]).min() > 0.1


def test_instants_of_a_turning_crank_differ() -> None:
    """Where even instants would show it in one place, others are taken; it ends where it began."""
    poses = sample(turning(), np.array([t for t, _ in instants(turning())])).joints
    apart = [np.hypot(*(one - other).T).max() for k, one in enumerate(poses[:-1]) for other in poses[:k]]
    assert min(apart) > 0.05


def test_a_frame_of_view_that_moves_says_where_it_is(run: Run) -> None:
    pytest.importorskip("matplotlib")
    moving, still = (draw(one).subfigs[0].axes for one in (bouncing(drift=12.0), run))
    assert all(axes.get_xlabel() == "x [m]" and len(axes.get_xticks()) for axes in moving)
    assert not any(axes.get_xlabel() or len(axes.get_xticks()) for axes in still)


# --- the moving picture


def test_gif_plays_in_real_time_and_shows_the_impact(run: Run, tmp_path: Path) -> None:
    images = pytest.importorskip("PIL.Image")
    path = run.animate(tmp_path / "a.gif")
    with images.open(path) as file:
        assert file.n_frames == 33 and file.info["duration"] == 40 and file.info["loop"] == 0
        frames = []
        for k in range(file.n_frames):
            file.seek(k)
            frames.append(np.asarray(file.convert("RGB")).astype(int))
    assert max(frames[0].shape) == 480
    struck = int(np.ceil(run.impacts[0].t * 25))
    assert has_colour(frames[struck], "#d55e00") and not has_colour(frames[struck - 1], "#d55e00")
    assert has_colour(frames[0], "#4477aa", 200) and np.abs(frames[0] - frames[10]).max() > 100
    assert [path.name for path in tmp_path.iterdir()] == ["a.gif"]


def test_gif_bytes_are_the_same_again(tmp_path: Path) -> None:
    pytest.importorskip("PIL")
    first, again = (bouncing(until=0.3).animate(tmp_path / name).read_bytes() for name in ("a.gif", "b.gif"))
    assert first == again
