"""``ccgen orbit``: a periodic motion, its branch as a table, and the bifurcation diagram."""

from __future__ import annotations

import csv
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

from ccgen.generator.cli.app import app
from ccgen.generator.cli.clean import clean
from ccgen.runtime.orbits import diagram
from ccgen.runtime.orbits.diagram import draw_branches

from ..support.shaken_table import SHAKEN, TABLE
from ..support.simplest_walker import STONES

PHASE = 1.0
NEAR = ("--guess", "fall.slide=0.0283", "--guess", "fall.slide_rate=0.87")


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    text = SHAKEN.replace("*t)", f"*t + {PHASE})")
    Path("table.toml").write_text(
        text.replace("shaker = 0.0", f"shaker = {TABLE.amplitude * math.sin(PHASE)!r}") + "rtol = 1e-12\n"
    )


def call(*words: str) -> tuple[int, str, str]:
    done = CliRunner().invoke(app, list(words))
    return done.exit_code, done.stdout, done.stderr


def test_a_motion_is_printed_and_followed() -> None:
    words = ("orbit", "table.toml", "--section", "2/10", *NEAR, "--along", "bounce.restitution=0.4:0.62")
    code, out, err = call(*words, "--double", "--settled", "3")
    assert code == 0, err
    lines = out.splitlines()
    assert lines[0] == "bouncing-table: stable periodic motion; period 0.2 s"
    printed = [complex(line.rpartition(" ")[0].replace(" ", "").replace("i", "j")) for line in lines[3:5]]
    assert np.sort_complex(printed) == pytest.approx(np.sort_complex(TABLE.multipliers), abs=1e-8)
    assert "  flip at 0.607631885939" in lines and "  end: bounce.restitution reached 0.62" in lines
    (doubled,) = (k for k, line in enumerate(lines) if "motions of 2 crossings" in line)
    assert lines[doubled + 1] == "  end: at the flip at 0.607631885939, where it begins"
    assert lines[doubled + 2] == "  end: bounce.restitution reached 0.62"
    results = Path("results/bouncing-table-orbit")
    assert lines[-1] == f"written: {results / 'branch.csv'}, {results / 'branch.png'}"
    assert (results / "branch.png").read_bytes().startswith(b"\x89PNG")
    with (results / "branch.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert {row["branch"] for row in rows} == {"0", "1"}
    kinds = {row["bifurcation"]: float(row["bounce.restitution"]) for row in rows if row["bifurcation"]}
    strength = TABLE.strength
    assert kinds["fold"] == pytest.approx((math.pi - strength) / (math.pi + strength), abs=1e-12)
    for row in rows:
        if row["branch"] == "0":  # the product of both multipliers is e²
            first, second = (complex(*(float(row[f"{part}(multiplier {k})"]) for part in ("re", "im"))) for k in (0, 1))
            assert first * second == pytest.approx(float(row["bounce.restitution"]) ** 2, abs=1e-8)
            # at the fold one is 1, on whichever side it was rounded: that motion is not stable
            assert row["stable"] == str(int(max(abs(first), abs(second)) < 1.0 - 1e-7))
            assert row["bifurcation"] != "fold" or row["stable"] == "0"
    changed_files_stay(results)


def changed_files_stay(results: Path) -> None:
    """Files that ccgen wrote are replaced, those that were changed are not."""
    (results / "branch.csv").write_text("mine")
    code, _, err = call("orbit", "table.toml", "--section", "0.2", *NEAR, "--along", "bounce.restitution=0.49:0.51")
    assert code == 2 and "branch.csv, which ccgen did not write or which has changed since" in err


@pytest.mark.parametrize(
    ("along", "said"),
    [("bounce.restitution=0.499:0.501", "bounce.restitution"), ("gravity.g=9.80:9.82", "gravity.g [m/s²]")],
)
def test_the_axis_of_a_branch_has_the_unit_of_its_parameter(
    along: str, said: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A plain number has none."""
    labels = []

    def draw(*branches: Any, **options: Any) -> None:
        labels.append(draw_branches(*branches, **options).axes[0].get_xlabel())

    monkeypatch.setattr(diagram, "draw_branches", draw)
    code, _, err = call("orbit", "table.toml", "--section", "0.2", *NEAR, "--along", along)
    assert code == 0, err
    assert labels == [said]


def test_a_motion_is_found_in_segments() -> None:
    """Three periods, each in a segment of its own: multipliers by hand, to the third power. A branch of them goes on in
    segments, and a rough guess needs more than one step."""
    words = ("orbit", "table.toml", "--section", "0.2", *NEAR, "--crossings", "3", "--segments", "3")
    code, out, err = call(*words, "--most", "20", "--along", "bounce.restitution=0.49:0.51")
    assert code == 0, err
    lines = out.splitlines()
    assert lines[0] == "bouncing-table: stable periodic motion; period 0.6 s"
    printed = [complex(line.rpartition(" ")[0].replace(" ", "").replace("i", "j")) for line in lines[3:5]]
    expected = np.sort_complex(np.array(TABLE.multipliers) ** 3)
    assert np.sort_complex(printed) == pytest.approx(expected, abs=1e-8)
    assert "  end: bounce.restitution reached 0.51" in lines
    code, _, err = call(*words, "--most", "1")
    assert code == 2 and "found no periodic motion in 1 step of Newton's method in 3 segments" in err
    code, _, err = call("orbit", "table.toml", "--section", "0.2", *NEAR, "--segments", "3")
    assert code == 2 and "segments: found 3 with 1 crossing, expected a divisor of 1: in a model that depends" in err
    assert "ask for 3 crossings (--crossings 3, or crossings=3 from Python)" in err


def test_a_walker_on_the_command_line() -> None:
    Path("walker.toml").write_text(STONES)
    words = ["orbit", "walker.toml", "--section", "swing.foot, stone", "--advances", "stance.x"]
    for text in ("stance.angle=swing.angle", "swing.angle=stance.angle", "stance.x=0", "stance.y=0"):
        words += ["--relabel", text]
    code, out, err = call(*words, "--rtol", "1e-11", "--method", "dop853")
    assert code == 0, err
    assert out.startswith("walker-on-stones: stable periodic motion; period 3.8824585")
    code, parted, err = call(*words, "--rtol", "1e-11", "--method", "dop853", "--segments", "3")
    assert code == 0, err
    assert parted.splitlines()[0] == out.splitlines()[0]


def test_runs_find_their_model_after_an_orbit() -> None:
    """A model with derivatives is another one; it does not take the place of that of a run."""
    assert call("run", "table.toml", "--until", "0.1", "--quiet")[0] == 0
    assert call("orbit", "table.toml", "--section", "0.2", *NEAR, "--quiet")[0] == 0
    code, out, err = call("plot", "results/bouncing-table", "fall.slide")
    assert code == 0 and out.startswith("written: "), err
    assert not clean(Path("build")) and not Path("build").exists()


def test_all_that_is_wrong_is_told_at_once() -> None:
    words = ("--guess", "fall", "--crossings", "0", "--rtol", "-1", "--double", "--settled", "no")
    words += ("--segments", "0", "--most", "1.5")
    code, _, err = call("orbit", "table.toml", "--section", "soon", *words)
    assert code == 2
    for part in (
        '--section: found "soon", expected a time as 0.2, a contact as ball.C,ground_0, or a coordinate',
        '--guess: found "fall", expected NAME=VALUE',
        "--crossings: found '0', expected a whole number",
        "--rtol: found -1.0, expected a number above 0",
        "--double: found without --along",
        "--settled: found 'no'",
        "--segments: found '0', expected a whole number, at least 1",
        "--most: found '1.5', expected a whole number, at least 1",
    ):
        assert part in err, err
    code, _, err = call(
        "orbit", "table.toml", "--section", "0.2", "--guess", "ball.slide=1", "--guess", "fall.slide=1 kg"
    )
    assert code == 2 and "--guess: found ball.slide, expected one of shaker.slide, fall.slide, shaker.slide_rate" in err
    assert "--guess fall.slide: found" in err
    code, _, err = call("orbit", "table.toml", "--section", "fall.slide=high")
    assert code == 2 and '--section: found "fall.slide=high", expected a coordinate and its value' in err
    for words in (
        ("--section", "fall.slide=5 s"),
        ("--section", "0.2", "--relabel", "fall.slide=5 deg"),
        ("--section", "0.2", "--along", "gravity.g=5 cm:12"),
    ):
        code, _, err = call("orbit", "table.toml", *words)
        assert code == 2 and f"{words[-2]}" in err and ", not a" in err, err
    code, _, err = call("orbit", "table.toml", "--section", "fall.slide=5 cm")
    assert code == 2 and "found a coordinate in a model that depends on time, expected the period" in err
    code, _, err = call("orbit", "table.toml", "--section", "0.2", "--relabel", "fall.slide=2*fall.slide")
    assert code == 2 and '--relabel fall.slide: found "2*fall.slide", expected a number, or one of shaker.slide' in err
    code, _, err = call("orbit", "table.toml", "--section", "0.2", *NEAR, "--along", "bounce.restitution=0.7")
    assert code == 2 and "expected PARAM=LOW:HIGH" in err
    code, _, err = call("orbit", "table.toml", "--section", "0.2", *NEAR, "--along", "bounce.restitution=0.6:0.7")
    assert code == 2 and "expected a range around 0.5" in err
    words = ("--along", "bounce.restitution=0.4:0.7", "--show", "height")
    code, _, err = call("orbit", "table.toml", "--section", "0.2", *NEAR, *words)
    assert code == 2 and "--show: found height, expected one of shaker.slide" in err


def test_an_equilibrium_is_told_as_one() -> None:
    """A rod that hangs comes back without having moved; one that swings a little does move."""
    Path("rod.toml").write_text(
        'name = "rod"\n[chain]\nlinks = 1\nhinged = true\n[start]\nangles = ["-90 deg"]\n[gravity]\n'
    )
    code, out, err = call("orbit", "rod.toml", "--section", "0.3", "--guess", "link_0.angle=-1.6")
    assert code == 0, err
    assert out.startswith(
        "rod: neutral equilibrium, at which nothing moves, compared after 0.3 s; give a --guess that "
    )
    table = Path("rod.toml").read_text() + '[[torque]]\nlink = "link_0"\ntorque = "1e-5*sin(2*pi*t/0.3)"\n'
    Path("shaken.toml").write_text(table)
    code, out, err = call("orbit", "shaken.toml", "--section", "0.3")
    assert code == 0, err
    assert out.startswith("rod: neutral periodic motion")
