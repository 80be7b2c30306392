"""What the player's page holds: outputs, points, places of contacts, frames, and its size."""

from __future__ import annotations

import html
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ccgen.runtime import Run, simulate
from ccgen.runtime.pictures import player
from ccgen.runtime.pictures.charted import MOST_OUTPUTS
from ccgen.runtime.pictures.contact_place import ContactPlaces
from ccgen.runtime.pictures.named_points import mass_centres, named_points

from ..support.player_page import data_of
from ..support.rigid_polygon import bouncing
from ..support.stiff_crank import turning
from ..support.touching_scenes import cradle
from ..support.wheel import NORMAL, RADIUS, wheel
from ..support.workshop import Workshop


@pytest.fixture(scope="module")
def run() -> Run:
    return bouncing()


@pytest.fixture(scope="module")
def swinging(workshop: Workshop) -> Run:
    return simulate(workshop.model(cradle(3, 0.0)), until=1.0)


# --- outputs below the motion


def test_energies_jump_at_impacts(run: Run) -> None:
    chart = player.content(run)["chart"]
    assert [column["name"] for column in chart["columns"]] == ["energy", "kinetic_energy", "potential_energy"]
    t, energy = np.array(chart["t"]), np.array(chart["columns"][0]["values"])
    twice = np.flatnonzero(np.diff(t) == 0)
    assert t[twice] == pytest.approx([impact.t for impact in run.impacts], abs=1e-9)
    assert energy[twice] - energy[twice + 1] == pytest.approx([i.energy_loss for i in run.impacts], abs=2e-3)
    flat = np.setdiff1d(np.arange(len(t) - 1), twice)
    assert np.abs(np.diff(energy))[flat].max() < 1e-3


def test_columns_are_the_runs_outputs(swinging: Run) -> None:
    content = player.content(swinging, ["ball_0.C.ax", "energy"])
    assert content["plotted"] == ["ball_0.C.ax", "energy"]
    chart = content["chart"]
    assert len(chart["columns"]) <= MOST_OUTPUTS + 4
    columns = {column["name"]: column for column in chart["columns"]}
    assert {"ball_0.angle", "hook_2.force", "touch_0.ball_0.C.gap", "ball_2.C.speed", "ball_0.C.ax"} <= {*columns}
    assert "touch_0.ball_0.C.friction" not in columns  # smooth: nothing but zeros
    t = np.array(chart["t"])
    single = ~np.isin(t, t[:-1][np.diff(t) == 0])
    at = np.clip(t[single], 0.0, 1.0)
    expected = swinging.values(*columns, t=at)
    for name, column in columns.items():
        found = np.array(column["values"], dtype=float)[single]
        assert column["unit"] == swinging.outputs[name]
        assert found == pytest.approx(expected[name], abs=3e-6 * np.abs(found).max() + 1e-6), name


def test_what_is_plotted_must_be_an_output(run: Run, swinging: Run, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"found 'ball_0\.angel', which nothing is called, expected .* ball_0\.angle"):
        swinging.save_player(tmp_path / "a.html", ["ball_0.angel"])
    with pytest.raises(TypeError, match=r"outputs: found 'energy', expected a list of names"):
        swinging.save_player(tmp_path / "a.html", "energy")
    with pytest.raises(ValueError, match=r"found joint_0\.x, but this run, .*, knows energies only"):
        run.save_player(tmp_path / "a.html", ["joint_0.x"])
    with pytest.raises(ValueError, match=r"a player is saved as \.html, found 'a\.pdf'"):
        run.save_player(tmp_path / "a.pdf")
    assert not list(tmp_path.iterdir())


def test_what_is_not_known_is_null(swinging: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where forces have no solution the outputs that need none are there all the same."""

    class Broken:
        since = np.zeros(0)

        def __call__(self, *_: object) -> None:
            raise ValueError("no forces here")

    content = player.content(replace(swinging, motion=Broken()), ["hook_0.force", "ball_0.angle"])  # type: ignore[arg-type]
    columns = {column["name"]: column["values"] for column in content["chart"]["columns"]}
    assert set(columns["hook_0.force"]) == {None} and None not in columns["ball_0.angle"]
    assert "hook_1.force" not in columns


# --- points and contacts


def test_points_move_with_their_links(swinging: Run) -> None:
    points = {point.name: point for point in named_points(swinging)}
    assert {"ball_0.H", "ball_0.C", "ball_2.C"} <= {*points} and "hook_0" not in points
    q = swinging.at(0.7)[0]
    for point in points.values():
        x, y, angle = swinging.model.poses(q)[point.link]
        place = complex(x, y) + complex(*point.place) * np.exp(1j * angle)
        assert swinging.model.point(point.name, q) == pytest.approx([place.real, place.imag], abs=1e-12)
    assert [(one.name, one.mass, one.place.tolist()) for one in mass_centres(swinging)] == [
        (f"ball_{k}", 1.0, [0.0, -1.0]) for k in range(3)
    ]
    assert named_points(bouncing(until=0.1)) == [] and mass_centres(turning()) == []


def test_contacts_are_between_discs_and_on_grounds(swinging: Run, workshop: Workshop) -> None:
    strike = swinging.impacts[0]
    q = swinging.at(strike.t)[0]
    balls = [swinging.model.point(f"ball_{k}.C", q) for k in range(3)]
    for k in (0, 1):
        place = ContactPlaces(swinging.model).at((f"ball_{k}.C", f"touch_{k}"), q)
        assert place == pytest.approx((balls[k] + balls[k + 1]) / 2, abs=1e-9)
    rolling = simulate(workshop.model(wheel("friction = 0.5")), until=0.2)
    q = rolling.at(0.2)[0]
    place = ContactPlaces(rolling.model).at(("wheel.C", "ground_0"), q)
    assert place == pytest.approx(rolling.model.point("wheel.C", q) - RADIUS * NORMAL, abs=1e-9)


# --- frames and size


def test_short_runs_have_many_frames() -> None:
    """They are looked at slowly: three hundred even instants."""
    t = np.array(player.content(bouncing(until=0.3))["t"])
    assert len(t) == 301 and np.diff(t) == pytest.approx(0.001, abs=1e-9)


def test_fast_links_turn_little_between_frames() -> None:
    spinning = bouncing(until=20.0, height=1e4, spin=20.0)
    t = np.array(player.content(spinning)["t"])
    assert np.diff(t).max() * 20.0 <= player.TURN * 1.001


def test_the_page_keeps_to_its_size(run: Run) -> None:
    for bytes_ in (120_000, 80_000):
        page = player.page_of(run, bytes_)
        assert 0.5 * bytes_ < len(page) < bytes_
        assert data_of(page)["impactCount"] == 4
    few = data_of(page)["t"]
    assert few[0] == 0.0 and few[-1] == 1.25 and len(few) < len(player.content(run)["t"])


def test_notebooks_show_the_page_in_a_frame_of_its_own(run: Run) -> None:
    shown = run._repr_html_()
    found = re.fullmatch(
        r'<iframe title="([^"]*)" sandbox="allow-scripts" style="[^"]*" srcdoc="([^"]*)"></iframe>', shown
    )
    assert found and found[1] == "stiff-hexagon in motion"
    assert html.unescape(found[2]) == player.page_of(run, player.MOST_BYTES_IN_NOTEBOOK)
    assert len(shown) <= player.MOST_BYTES_IN_NOTEBOOK
    assert "</script>" not in turning()._repr_html_()  # a name of that kind ends nothing


def test_keys_are_told_apart() -> None:
    """One table says what each key does, for the page and for its help."""
    table = player.PAGE.read_text(encoding="utf-8").partition("const keys = [")[2].partition("\n];")[0]
    names = [
        name
        for names in re.findall(r"^  \[\[(.*?\"?)\], ", table, re.MULTILINE)
        for name in re.findall(r'"(.+?)"', names)
    ]
    assert len(names) == len(set(names)) >= 20
    assert {" ", "ArrowLeft", "Home", "End", "[", "]", "+", "-", "f", "t", "p", "?"} <= set(names)
