"""The command line as a person or a script meets it: exit codes, what is printed, what is written."""

from __future__ import annotations

import os
import re
import select
import signal
import subprocess
import time
from pathlib import Path

import numpy as np
import pytest

from ccgen.runtime import methods

from ..support.command_line import CCGEN, LONGEST, PENDULUM, Done, ccgen, written
from ..support.folders import SCENES
from ..support.heeding import heeding_ctrl_c
from ..support.tiers import hard

HEXAGON = str(SCENES / "falling-hexagon.toml")

IMPACTS = """
0.4515236409857 joint_0  4.4294469181  7.3085874148 109.626750000
0.5497839476458 joint_1  5.5574692024 16.9704401049  62.470400883
0.7701908095116 joint_0  1.7758695811  2.8748494802  61.194061447
0.9241375542824 joint_0  0.9113049152  2.1441771281  60.705561659
0.9461333789875 joint_3  3.6884589011 15.8650497918  46.076165628
0.9512380368467 joint_0  1.2059028786  3.1062090704  45.139719014
"""
"""Time, contact, speed before, impulse and energy after of the first impacts, from two independent programs."""


# Generating


@pytest.mark.parametrize(
    ("options", "package", "freedoms"),
    [
        (("--links", "6"), "loop6", 6),
        hard(("--links", "3", "--pinned"), "pinned3", 1),
        hard(("--links", "3", "--open"), "chain3", 5),
        hard(("--links", "3", "--open", "--hinged", "--gravity"), "hinged3", 3),
        (("--scene", str(SCENES / "open-chain.toml")), "open_chain", 5),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, tuple) else "",
)
def test_generate(options: tuple[str, ...], package: str, freedoms: int, tmp_path: Path) -> None:
    from ccgen.runtime import load_model

    done = ccgen(*options, at=tmp_path)
    assert (done.returncode, done.stdout, done.stderr) == (0, f"build/{package}\n", "")
    assert [path.name for path in tmp_path.iterdir()] == ["build"]
    files = {path.name for path in (tmp_path / "build" / package).iterdir()}
    assert {"equations.txt", "model.c", "model.h", "model.json", "__init__.py", "build.json"} <= files
    model = load_model(tmp_path / "build" / package)
    assert model.dof == freedoms
    assert ("gravity.g" in model.parameters) == ("--gravity" in options or "--scene" in options)


def test_generate_into_another_folder(tmp_path: Path) -> None:
    done = ccgen("--links", "6", "--out", "models/mine", at=tmp_path)
    assert (done.returncode, done.stdout, done.stderr) == (0, "models/mine/loop6\n", "")
    assert (tmp_path / "models" / "mine" / "loop6" / "model.c").is_file()


def test_generate_with_derivatives(tmp_path: Path) -> None:
    """By a scene and by sizes; a package without them has no such file."""
    from ccgen.runtime import load_model

    (tmp_path / "pendulum.toml").write_text(PENDULUM)
    for options, package in ((("--links", "3"), "loop3"), (("--scene", "pendulum.toml"), "pendulum")):
        done = ccgen(*options, "--derivatives", "--out", "with", at=tmp_path)
        assert (done.returncode, done.stdout, done.stderr) == (0, f"with/{package}\n", "")
        assert (tmp_path / "with" / package / "derivatives.c").is_file()
    q, u = (model := load_model(tmp_path / "with" / "pendulum")).start()
    rod = 9.81 * 1.5  # a uniform rod of 1 m: 3 g / 2 l
    assert model.acceleration_jacobian(q, u)[0, 0] == pytest.approx(rod * np.sin(q[0]), abs=1e-12)
    assert ccgen("--scene", "pendulum.toml", "--out", "without", at=tmp_path).returncode == 0
    assert not (tmp_path / "without" / "pendulum" / "derivatives.c").exists()
    refused = ccgen("show", "pendulum.toml", "--derivatives", at=tmp_path)
    assert refused.returncode != 0
    assert "--derivatives" in refused.stderr


@pytest.mark.quick
def test_version_and_help(tmp_path: Path) -> None:
    assert re.fullmatch(r"ccgen \d+\.\d+\S*\n", ccgen("--version", at=tmp_path).stdout)
    for options in (("--help",), ("run", "--help"), ("show", "--help"), ("diff", "--help")):
        done = ccgen(*options, at=tmp_path)
        assert (done.returncode, done.stderr) == (0, "")
        assert "Usage: ccgen" in done.stdout
    *most, last = methods()
    told = " ".join(ccgen("run", "--help", at=tmp_path).stdout.split())
    named = re.search(r"integration method: (\S.*?) or (\w+) \[gauss\]", told)
    assert named and {*named[1].split(", "), named[2]} == {*most, last}


# Running


def test_run(tmp_path: Path) -> None:
    done = ccgen("run", HEXAGON, "--rtol", "1e-12", at=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    rows = [line.split() for line in done.stdout.splitlines() if re.match(r"\d+ +\d", line)]
    assert [row[0] for row in rows] == [str(k + 1) for k in range(len(rows))]
    for row, expected in zip(rows, IMPACTS.split("\n")[1:-1], strict=False):
        t, contact, speed, impulse, energy = expected.split()
        assert abs(float(row[1]) - float(t)) < 2e-12
        assert row[2] == contact
        assert [-float(row[3]), float(row[4])] == pytest.approx([float(speed), float(impulse)], abs=1e-8)
        assert float(row[6]) == pytest.approx(float(energy), abs=1e-8)
    together = next(line.split() for line in done.stdout.splitlines() if line.lstrip().startswith("joint_5"))
    assert float(together[1]) == pytest.approx(-5.5574692024, abs=1e-8)
    assert "t = 1.2 s, impacts: 7, steps: " in done.stdout
    assert written(tmp_path / "results") == [
        "falling-hexagon/.ccgen.json",
        "falling-hexagon/forces.png",
        "falling-hexagon/player.html",
        "falling-hexagon/plot.png",
        "falling-hexagon/result.npz",
    ]
    for name in ("result.npz", "plot.png", "player.html"):
        assert f"results/falling-hexagon/{name}" in done.stdout.splitlines()[-1]
    with np.load(tmp_path / "results" / "falling-hexagon" / "result.npz") as result:
        assert result["t"][-1] == 1.2
        assert bool(result["success"])


KANE = """
name = "kane"
[chain]
links = 2
hinged = true
[start]
angles = ["-70 deg", "-60 deg"]
angular_velocities = [1.0, 0.5]
[gravity]
g = 9.81
[[ground]]
point = [0, -1.8057182352]
restitution = 0.7
friction = 0.5
contacts = ["link_1.B"]
[run]
until = 5.0
"""
"""A double pendulum whose tip strikes rough ground; at some impact Newton's law would add energy."""


@pytest.mark.hard
def test_run_that_stops_early(tmp_path: Path) -> None:
    (tmp_path / "kane.toml").write_text(KANE + 'on_gain = "stop"\n')
    done = ccgen("run", "kane.toml", "--out", "here", "--gif", at=tmp_path)
    assert done.returncode == 3
    assert len(done.stderr.splitlines()) == 1
    assert done.stderr.startswith("kane: stopped at t = ")
    assert done.stderr.count("stopped") == 1
    assert "add energy" in done.stderr
    files = [".ccgen.json", "animation.gif", "forces.png", "player.html", "plot.png", "result.npz"]
    assert written(tmp_path / "here") == files
    assert "link_1.B" in done.stderr
    with np.load(tmp_path / "here" / "result.npz") as result:
        assert not bool(result["success"])


@pytest.mark.hard
def test_run_with_less_restitution_says_so(tmp_path: Path) -> None:
    (tmp_path / "kane.toml").write_text(KANE)
    done = ccgen("run", "kane.toml", "--out", "here", at=tmp_path)
    assert done.returncode == 0, done.stderr
    told = (
        r"warning: \d+ of \d+ impacts, .* would have gained energy by Newton's law, or have no impulses by it; "
        r".* \d+% of it at least; .*\n"
    )
    assert re.fullmatch(told, done.stderr), done.stderr
    with np.load(tmp_path / "here" / "result.npz") as result:
        assert bool(result["success"])
        shares = result["impact_restitution_share"]
        assert 0.0 < shares.min() < 1.0 and shares.max() == 1.0
        assert done.stdout.count("% of restitution)") == np.count_nonzero(shares < 1.0)


@pytest.mark.hard
def test_run_by_time_stepping(tmp_path: Path) -> None:
    (tmp_path / "kane.toml").write_text(KANE)
    done = ccgen("run", "kane.toml", "--method", "moreau", "--step", "1e-3", "--csv", "--gif", at=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    stretch = "time stepping from 0 s to 5 s"
    told = f"impacts are not told apart by time stepping\n{stretch}\nno forces: this run knows no forces"
    assert f"{told}: it went by time stepping" in done.stdout
    assert "method moreau" in done.stdout
    refused = ccgen("run", "kane.toml", "--method", "moreau", at=tmp_path)
    assert refused.returncode == 2 and refused.stderr.startswith("--step: found none beside method 'moreau'")


def test_run_without_contacts(tmp_path: Path) -> None:
    (tmp_path / "pendulum.toml").write_text(PENDULUM)
    done = ccgen("run", "pendulum.toml", "--until", "0.25", "--method", "dop853", at=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.startswith("no impacts\nlargest forces:\n  joint_0 ") and "\nt = 0.25 s" in done.stdout
    files = [".ccgen.json", "forces.png", "player.html", "plot.png", "result.npz"]
    assert written(tmp_path / "results") == [f"pendulum/{file}" for file in files]


@pytest.mark.hard
def test_interrupted_run_keeps_what_it_has(tmp_path: Path) -> None:
    """Ctrl-C comes when the line of progress on the terminal tells the first time that the simulation has reached."""
    many = PENDULUM.replace("links = 1", "links = 24")  # slow enough not to be done before the signal
    (tmp_path / "pendulum.toml").write_text(many)
    ccgen("--scene", "pendulum.toml", at=tmp_path)
    options = ("--until", "5e5", "--rtol", "1e-13", "--method", "dop853")
    terminal, end = os.openpty()
    with (tmp_path / "out").open("w+") as out, heeding_ctrl_c():
        process = subprocess.Popen(
            [CCGEN, "run", "pendulum.toml", *options],
            cwd=tmp_path,
            stdout=out,
            stderr=end,
            env={**os.environ, "TERM": "xterm", "COLUMNS": "120"},
        )
        os.close(end)
        try:
            err = told(terminal, until=" t = ")
            assert " t = " in err, err
            process.send_signal(signal.SIGINT)
            err += told(terminal)
            process.wait(LONGEST)
        finally:
            process.kill()
            os.close(terminal)
        out.seek(0)
        printed = out.read()
    assert process.returncode == 3, err
    assert re.search(r"pendulum: stopped at t = \S+ s: interrupted\r\n", err), err
    assert "result.npz" in printed
    files = [f"pendulum/{file}" for file in (".ccgen.json", "forces.png", "player.html", "plot.png", "result.npz")]
    assert written(tmp_path / "results") == files


def told(terminal: int, until: str | None = None) -> str:
    """What a process tells a terminal until it ends, or says that, or for as long as a command may take."""
    found, last = "", time.monotonic() + LONGEST
    while until is None or until not in found:
        if not select.select([terminal], [], [], max(0.0, last - time.monotonic()))[0] or time.monotonic() > last:
            break
        try:
            more = os.read(terminal, 65536)
        except OSError:  # the other side is closed
            break
        if not more:
            break
        found += more.decode(errors="replace")
    return found


# Showing and comparing


def test_show(tmp_path: Path) -> None:
    (tmp_path / "pendulum.toml").write_text(PENDULUM)
    done = ccgen("show", "pendulum.toml", at=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert "theta_0" in done.stdout
    assert "freedom" in done.stdout
    assert "u_dot" not in done.stdout
    assert "u_dot" in ccgen("show", "pendulum.toml", "--equations", at=tmp_path).stdout
    latex = ccgen("show", "pendulum.toml", "--latex", at=tmp_path)
    assert (latex.returncode, latex.stderr) == (0, "")
    assert "\\theta_" in latex.stdout
    expanded = ccgen("show", "pendulum.toml", "--expand", at=tmp_path)
    assert (expanded.returncode, expanded.stderr) == (0, "")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["pendulum.toml"]


def test_diff(tmp_path: Path) -> None:
    (tmp_path / "old.toml").write_text(PENDULUM)
    (tmp_path / "new.toml").write_text(PENDULUM.replace("9.81", "1.62"))
    assert ccgen("--scene", "old.toml", at=tmp_path).returncode == 0
    for old in ("build/pendulum", "build/pendulum/equations.txt", "old.toml"):
        same = ccgen("diff", old, "old.toml", at=tmp_path)
        assert (same.returncode, same.stdout, same.stderr) == (0, "the listings are the same\n", "")
    different = ccgen("diff", "build/pendulum", "new.toml", at=tmp_path)
    assert (different.returncode, different.stderr) == (1, "")
    lines = different.stdout.splitlines()
    assert lines[:2] == ["--- build/pendulum", "+++ new.toml"]
    assert "-g = 9.81  # gravity.g" in lines
    assert "+g = 1.62  # gravity.g" in lines
    assert lines[-1].startswith("the numbers differ")


def test_diff_of_equal_numbers(tmp_path: Path) -> None:
    (tmp_path / "old.toml").write_text(PENDULUM)
    ccgen("--scene", "old.toml", at=tmp_path)
    text = (tmp_path / "build" / "pendulum" / "equations.txt").read_text()
    (tmp_path / "new.txt").write_text(re.sub(r"\bc_0\b", "cosine_0", text))
    done = ccgen("diff", "build/pendulum", "new.txt", at=tmp_path)
    assert done.returncode == 1
    assert done.stdout.splitlines()[-1].startswith("the numbers agree")


@pytest.mark.parametrize("content", [hard(b"m = 1\n"), b"\xff\xfe", hard(b"")], ids=["text", "bytes", "empty"])
def test_diff_with_what_is_no_listing(content: bytes, tmp_path: Path) -> None:
    (tmp_path / "some.txt").write_bytes(content)
    done = ccgen("diff", HEXAGON, "some.txt", at=tmp_path)
    refused(done, "some.txt")


# Refusing


def refused(done: Done, *words: str) -> None:
    """Exit code 2 with a sentence, and no traceback."""
    assert done.returncode == 2, done.stderr
    assert done.stdout == ""
    assert done.stderr.endswith("\n")
    assert "Traceback" not in done.stderr
    for word in words:
        assert word in done.stderr


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("run", HEXAGON, "--rtol", "1e-16"), ("--rtol", "1e-15")),
        (("run", HEXAGON, "--rtol", "nan"), ("--rtol",)),
        (("run", HEXAGON, "--until", "inf"), ("--until",)),
        (("run", HEXAGON, "--until", "soon"), ("--until: found 'soon', expected a positive number of seconds",)),
        (("run", HEXAGON, "--step", "1e-12"), ("--step: found 1e-12 s for a run to t = ",)),
        (("run", HEXAGON, "--method", "euler"), ("--method: found 'euler'", "dop853")),
        (("run", HEXAGON, "--fast"), ("--fast",)),
        (("fly", HEXAGON), ("fly",)),
        (("show", HEXAGON, "--expand"), ()),
        (("diff", HEXAGON), ("NEW",)),
    ],
    ids=lambda value: " ".join(value[1:]) if isinstance(value, tuple) else "",
)
def test_refused_options(options: tuple[str, ...], words: tuple[str, ...], tmp_path: Path) -> None:
    refused(ccgen(*options, at=tmp_path), *words)
    assert written(tmp_path) == []


FAULTS = {
    "run nosuch.toml --until nan --rtol 5 --method foo --step soon -v -q": [
        "--quiet: found beside --verbose",
        "--until: found nan, expected a positive number of seconds; correct it",
        "--rtol: found 5.0, expected a number between 0 and 1",
        "--method: found 'foo', expected one of dop853",
        "--step: found 'soon', expected a positive number of seconds; correct it",
        "nosuch.toml: No such file or directory",
    ],
    "run bad.toml --until -1 --out bad.toml": [
        "--until: found -1.0",
        "bad.toml:2: chain.links: found 0",
        "bad.toml:5: gravity.g: found inf",
        "--out bad.toml: found a file",
    ],
    "--scene nosuch.toml --precision quad --out bad.toml": [
        "--precision: found 'quad'",
        "nosuch.toml: No such file",
        "--out bad.toml: found a file",
    ],
    "--links two --precision quad --hinged": [
        "--precision: found 'quad'",
        "--links: found 'two', expected a whole number of links; correct it",
        "--hinged: found without --open",
    ],
    "--links 2.5": ["--links: found '2.5', expected a whole number of links; correct it"],
    "--links 3 --gravity --fold show nosuch.toml": [
        "--links: found beside the command show",
        "--gravity: found beside the command show",
        "--fold: found before the command show",
    ],
    "--fold --precision quad": ["--fold: found without --links or --scene", "--precision: found without --links or"],
    "show nosuch.toml --plan foo": ["--plan: found 'foo', expected 'tip to root'", "nosuch.toml: No such file"],
    "show good.toml --plan dyads": ["--plan: found 'dyads', expected 'tip to root': the mechanism has no dyad"],
    "show good.toml --set bar.mass=2 --latex": [
        "--set: found beside --latex, expected without",
        "--set bar.mass: found no such parameter",
    ],
    "show good.toml --tolerances --latex --fold": [
        "--latex: found beside --tolerances",
        "--fold: found beside --tolerances",
    ],
    "cost nosuch.toml --error abc --until 0 --precision quad,half --fold": [
        "--fold: found without --effects",
        "--precision: found 'quad'",
        "--precision: found 'half'",
        "--error: found 'abc', expected a number from 1e-15 to 1; correct it",
        "--until: found 0.0",
        "nosuch.toml: No such file",
    ],
    "cost nosuch.toml --effects --error 3 --drift": [
        "--error: found beside --effects",
        "--drift: found beside --effects",
        "nosuch.toml: No such file",
    ],
    "torque good.toml nothing --rate abc --plot x.pdf": [
        "--rate: found 'abc', expected a finite number, in rad/s; correct it",
        "JOINT: found 'nothing'",
        "--plot x.pdf: found 'x.pdf'",
    ],
    "diff one.txt two.txt": ["one.txt: found nothing there", "two.txt: found nothing there"],
}
"""Commands, and the beginnings of all lines that they are refused with."""


@pytest.mark.sample(5)
@pytest.mark.parametrize("command", FAULTS)
def test_all_faults_of_a_command_are_told(command: str, tmp_path: Path) -> None:
    (tmp_path / "good.toml").write_text(PENDULUM)
    (tmp_path / "bad.toml").write_text("[chain]\nlinks = 0\n\n[gravity]\ng = inf\n")
    done = ccgen(*command.split(), at=tmp_path)
    refused(done)
    lines = done.stderr.splitlines()
    assert len(lines) == len(FAULTS[command]), done.stderr
    for line, beginning in zip(lines, FAULTS[command], strict=True):
        assert line.startswith(beginning)
    assert written(tmp_path) == ["bad.toml", "good.toml"]


def test_steps_of_one_length(tmp_path: Path) -> None:
    (tmp_path / "pendulum.toml").write_text(PENDULUM)
    done = ccgen("run", "pendulum.toml", "--step", "0.01", at=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    t = np.load(tmp_path / "results" / "pendulum" / "result.npz")["t"]
    assert t == pytest.approx(np.linspace(0.0, 0.5, 51), abs=1e-12)


def test_no_compiler(tmp_path: Path) -> None:
    environment = {"PATH": str(tmp_path / "nothing"), "CC": ""}
    for options in (("--links", "6"), ("run", HEXAGON)):
        refused(ccgen(*options, at=tmp_path, environment=environment), "no C compiler found", "install")
    refused(ccgen("--links", "6", at=tmp_path, environment={"CC": "no-such-cc -O1"}), "CC", "no-such-cc -O1")
    assert written(tmp_path) == []


def test_a_compiler_that_fails(tmp_path: Path) -> None:
    done = ccgen("--links", "3", at=tmp_path, environment={"CC": "false", "CCGEN_CACHE_DIR": str(tmp_path / "cache")})
    refused(done, "the C compiler failed", "false")
    assert [file for file in written(tmp_path) if not file.endswith(".lock")] == []


def test_folders_that_cannot_be_written(tmp_path: Path) -> None:
    (tmp_path / "build").write_text("a file")
    refused(ccgen("--links", "6", at=tmp_path), "--out build", "file")
    refused(ccgen("run", HEXAGON, at=tmp_path), "build", "file")
    refused(ccgen("run", HEXAGON, "--out", "build/below", at=tmp_path), "--out build/below", "file")
    assert written(tmp_path) == ["build"]


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_folders_without_permission(tmp_path: Path) -> None:
    (tmp_path / "closed").mkdir(mode=0o500)
    refused(ccgen("--links", "6", "--out", "closed/build", at=tmp_path), "--out closed/build", "permission")
