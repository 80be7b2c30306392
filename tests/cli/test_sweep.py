"""``ccgen sweep SCENE PLAN`` and ``ccgen replay``."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from ccgen.generator.cli.app import app
from ccgen.generator.cli.clean import clean
from ccgen.runtime.sweep.results import Results

from ..support.folders import SCENES

SCENE = str(SCENES / "falling-hexagon.toml")
PLAN = """
observe = ["joint_0.y"]
[run]
until = 0.3
[[vary]]
parameter = "gravity.g"
values = [5.0, 9.81]
[[vary]]
start = "link_0.y"
values = [-3.0, 1.5]
"""


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("plan.toml").write_text(PLAN)


def call(*words: str) -> tuple[int, str, str]:
    done = CliRunner().invoke(app, list(words))
    return done.exit_code, done.stdout, done.stderr


def test_a_plan_becomes_a_table_and_a_run_of_it_a_player() -> None:
    code, out, err = call("sweep", SCENE, "plan.toml", "--plot", "--netcdf", "table.nc", "--zarr", "table.zarr")
    assert code == 0, err
    assert out.splitlines()[-1].endswith("sweep.png, table.nc, table.zarr")
    assert Path("table.zarr/joint_0.y/c/0").exists()
    assert out.splitlines()[0] == "4 runs: 2 refused, 2 done"
    assert "inside ground_0 by 3 m; raise or move the start" in out.splitlines()[1]
    folder = Path("results/plan-sweep")
    assert (folder / "sweep.png").read_bytes().startswith(b"\x89PNG") and Path("table.nc").stat().st_size > 100
    fallen = Results(folder).column("joint_0.y")[[1, 3]]
    assert fallen == pytest.approx(1.5 - np.array([5.0, 9.81]) * 0.3**2 / 2, abs=1e-12)  # nothing is struck
    code, out, err = call("replay", str(folder), SCENE, "plan.toml", "3")
    assert code == 0, err
    assert (folder / "run-3" / "player.html").exists() and "run 3: reached t = 0.3 s" in out
    before = {file.name: file.read_bytes() for file in folder.glob("part-*")}
    assert call("sweep", SCENE, "plan.toml", "--threads", "1")[0] == 0
    assert {file.name: file.read_bytes() for file in folder.glob("part-*")} == before


def test_what_is_wrong_is_told_before_the_first_run() -> None:
    Path("bad.toml").write_text(PLAN.replace("gravity.g", "gravity.gg").replace("joint_0.y", "joint_0.z"))
    code, _, err = call("sweep", SCENE, "bad.toml")
    assert code == 2 and "bad.toml:6: vary[0].parameter: gravity.gg: found no such parameter" in err
    assert "bad.toml:2: observe: found 'joint_0.z'" in err and not Path("results").exists()
    Path("bad.toml").write_text(PLAN.replace("[5.0, 9.81]", '["5 m/s^2", "9.81 kg"]'))
    code, _, err = call("sweep", SCENE, "bad.toml")
    assert code == 2 and 'bad.toml:7: vary[0].values: found "9.81 kg": that is a mass, not' in err
    assert '"5 m/s^2"' not in err and not Path("results").exists()
    code, _, err = call("sweep", SCENE, "plan.toml", "--threads", "0", "--chunk", "x")
    assert code == 2 and "--threads: found '0', expected a whole number" in err and "--chunk: found 'x'" in err
    assert call("sweep", SCENE, "plan.toml", "-q")[0] == 0
    code, _, err = call("replay", "results/plan-sweep", SCENE, "plan.toml", "4")
    assert code == 2 and "run: found 4, expected a number from 0 to 3" in err
    code, _, err = call("replay", "results/plan-sweep", SCENE, "plan.toml", "0")
    assert code == 2 and "inside ground_0" in err
    code, _, err = call("sweep", SCENE, "plan.toml", "--set", "link_0.mass=3")
    assert code == 2 and "found a sweep with another parameters" in err


def test_faults_of_a_plan_have_the_lines_of_their_keys() -> None:
    """Of a key that lacks the line of its table, of an argument of a run that of its key; in a CSV file its own."""
    Path("few.csv").write_text("gravity.g\n")
    Path("bad.toml").write_text(
        "observe = [1]\n\n[run]\nuntil = 1.0\nrtol = -1\nmethode = 1\n[[vary]]\nparameter = 'gravity.g'\n"
        "[[vary]]\ncount = 3\nstart = 'link_0.y'\nfrom = 0.0\n[table]\nfile = 'few.csv'\n"
    )
    code, _, err = call("sweep", SCENE, "bad.toml")
    places = [line.removeprefix("ccgen: ").split(": found")[0] for line in err.splitlines()]
    assert code == 2 and places == [
        "bad.toml:6: run.methode",
        "bad.toml:5: run: rtol",
        "bad.toml:1: observe",
        *(f"bad.toml:7: vary[0].{key}" for key in ("from", "to", "count")),
        "bad.toml:9: vary[1].to",
        "bad.toml: few.csv: heading",
        "bad.toml: few.csv",
    ]


def test_tables_go_where_nothing_of_others_is() -> None:
    """Told before the first run, and all at once."""
    Path("mine.nc").write_text("mine")
    Path("mine").mkdir()
    code, _, err = call("sweep", SCENE, "plan.toml", "--netcdf", "mine.nc", "--zarr", "mine")
    assert code == 2 and not Path("results").exists() and Path("mine.nc").read_text() == "mine"
    assert [line.split(", expected")[0] for line in err.splitlines()] == [
        "--netcdf: mine.nc: found what ccgen did not write",
        "--zarr: mine: found what ccgen did not write",
    ]


def test_clean_removes_what_sweeps_have_written_alone() -> None:
    """A sweep, its chart, its tables and a run of it made again; an unfinished one too; nothing of others."""
    folder = Path("results/plan-sweep")
    inside = ("--netcdf", str(folder / "t.nc"), "--zarr", str(folder / "t.zarr"))
    assert call("sweep", SCENE, "plan.toml", "-q")[0] == 0
    assert call("sweep", SCENE, "plan.toml", "--plot", *inside)[0] == 0
    assert call("replay", str(folder), SCENE, "plan.toml", "1")[0] == 0
    assert call("replay", str(folder), SCENE, "plan.toml", "1")[0] == 0  # over its own files
    stopped = Path("results/stopped")
    stopped.mkdir()
    for name in ("manifest.json", "part-000000.parquet"):
        (stopped / name).write_bytes((folder / name).read_bytes())
    for name in ("piece-0000000001-0000000002.arrow", ".manifest.json.part", ".lock"):
        (stopped / name).write_bytes(b"")
    mine = [folder / "notes.txt", folder / "t.zarr" / "notes.txt", folder / "run-1" / "notes.txt", stopped / "part.csv"]
    mine += [Path("results/mine/part-000000.parquet"), Path("results/mine/sweep.png"), stopped / "sweep.png"]
    for file in mine:
        file.parent.mkdir(exist_ok=True)
        file.write_text("mine")
    assert sorted(clean(Path("results"))) == sorted(mine)
    assert sorted(file for file in Path("results").rglob("*") if file.is_file()) == sorted(mine)
    for file in mine:
        file.unlink()
    assert clean(Path("results")) == [] and not Path("results").exists()


def test_replay_leaves_files_of_others() -> None:
    assert call("sweep", SCENE, "plan.toml", "-q")[0] == 0
    Path("mine").mkdir()
    Path("mine/plot.png").write_text("mine")
    code, _, err = call("replay", "results/plan-sweep", SCENE, "plan.toml", "1", "--out", "mine")
    assert code == 2 and "found the file plot.png, which ccgen did not write" in err
    assert Path("mine/plot.png").read_text() == "mine" and len(list(Path("mine").iterdir())) == 1
