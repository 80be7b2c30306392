"""What commands print: figures with their scale, lists that say what they leave out, no minus before a zero."""

from __future__ import annotations

import re
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from ccgen.generator.cli.report import energy_moved, row
from ccgen.generator.program.program import Counts
from ccgen.runtime import simulate

from ..support.command_line import PENDULUM, ccgen
from ..support.folders import SCENES
from ..support.tiers import hard
from ..support.workshop import Workshop

DRIVEN = """\
name = "driven"
[chain]
links = 1
hinged = true
[gravity]
g = 9.81
[[drive]]
joint = "joint_0"
speed = 3.0
[run]
until = 0.5
rtol = 1e-7
"""


def test_the_energy_that_moves_is_that_of_the_fall(workshop: Workshop) -> None:
    """A rod of 1 kg and 1 m falls from level and passes the lowest point, half a metre down, between two rows."""
    moved = energy_moved(simulate(workshop.model(PENDULUM), until=20.0))
    assert 0.99 * 9.81 * 0.5 < moved <= (1.0 + 1e-9) * 9.81 * 0.5


def test_the_audit_has_its_scale(tmp_path: Path) -> None:
    (tmp_path / "pendulum.toml").write_text(PENDULUM.replace("until = 0.5", "until = 1.0"))
    done = ccgen("run", "pendulum.toml", at=tmp_path)
    assert done.returncode == 0
    assert re.search(r"energy kept to [\d.e+-]+ J of 4\.\d+ J; method gauss", done.stdout)


@pytest.mark.hard
def test_one_line_on_loops_unless_more_is_asked_for(tmp_path: Path) -> None:
    """The beach animal has 14 loops."""
    scene = str(SCENES / "strandbeest.toml")
    (line,) = ccgen("show", scene, at=tmp_path).stderr.splitlines()
    assert line.startswith("strandbeest: 14 loops closed, angles changed by up to ")
    assert line.endswith("; -v for their branches")
    first, *branches = ccgen("show", scene, "-v", at=tmp_path).stderr.splitlines()
    assert first == line.removesuffix("; -v for their branches")
    assert len(branches) == 14 and all(line.startswith("strandbeest: branch ") for line in branches)
    assert ccgen("show", scene, "--quiet", at=tmp_path).stderr == ""


SKETCH = """
[pinned]
links = 3
[start]
angles = [1.2, 0.1, -1.3]
[gravity]
[run]
until = 0.1
"""


@pytest.mark.parametrize(
    ("command", "results"),
    [
        hard(("run", "sketch.toml"), ""),
        hard(("run", "sketch.toml", "--rtol", "1e-3", "--method", "dopri5"), ""),
        hard(("--scene", "sketch.toml"), "build/sketch\n"),
        (("show", "sketch.toml"), None),
        hard(("equilibrium", "sketch.toml"), None),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, tuple) else "",
)
def test_quiet_is_quiet(command: tuple[str, ...], results: str | None, tmp_path: Path) -> None:
    """One remark as usual, all with -v, none with --quiet; beside its results a run prints nothing then."""
    (tmp_path / "sketch.toml").write_text(SKETCH)
    usual, all_, none = (ccgen(*command, *more, at=tmp_path) for more in ((), ("-v",), ("-q",)))
    assert (usual.returncode, all_.returncode, none.returncode) == (0, 0, 0)
    (line,) = usual.stderr.splitlines()
    assert line.startswith("sketch: 1 loop closed, angles changed by up to ") and line.endswith("; -v for its branch")
    assert all_.stderr.count("\n") == 2 and "sketch: branch " in all_.stderr
    assert none.stderr == ""
    assert none.stdout == (usual.stdout if results is None else results)


def test_quiet_says_what_goes_wrong(tmp_path: Path) -> None:
    """Wrong input and early stops, with their exit codes; warnings of doubtful figures."""
    (tmp_path / "sketch.toml").write_text(SKETCH)
    wrong = ccgen("run", "sketch.toml", "--until", "-1", "--quiet", at=tmp_path)
    assert (wrong.returncode, wrong.stdout) == (2, "") and wrong.stderr.startswith("--until: found -1")
    (tmp_path / "sketch.toml").write_text(SKETCH.replace("[gravity]", "[gravity]\ng = 1e300"))
    stopped = ccgen("run", "sketch.toml", "--quiet", at=tmp_path)
    assert (stopped.returncode, stopped.stdout) == (3, "")
    assert re.fullmatch(r"sketch: stopped at t = .*\n", stopped.stderr)
    refused = ccgen("run", "sketch.toml", "-q", "-v", at=tmp_path)
    assert (refused.returncode, refused.stderr) == (
        2,
        "--quiet: found beside --verbose, expected one of them; leave one out\n",
    )
    before = ccgen("-q", "run", "sketch.toml", at=tmp_path)
    assert before.returncode == 2 and "--quiet: found before the command run, expected behind it" in before.stderr


def test_show_prints_the_equations_only_where_asked(tmp_path: Path) -> None:
    """The summary is the beginning of what --equations prints, and has every heading."""
    (tmp_path / "sketch.toml").write_text(SKETCH)
    summary = ccgen("show", "sketch.toml", at=tmp_path).stdout
    whole = ccgen("show", "sketch.toml", "--equations", at=tmp_path).stdout
    assert whole.startswith(summary) and "u_dot" not in summary and "u_dot" in whole
    assert summary.count("\n") < 40 < whole.count("\n")
    for heading in ("links", "joints", "loops", "branch", "degrees of freedom", "effects", "operations"):
        assert f"\n{heading}  " in summary


def test_no_zero_has_a_minus() -> None:
    """An impact whose figures are zero but for rounding below."""
    model: Any = SimpleNamespace(
        contacts=[("joint_0", "ground_0")], stops=[], gap_rates=lambda q, u: [-1e-13], energy=lambda q, u: (-1e-13, 0.0)
    )
    impact: Any = SimpleNamespace(
        t=1.0, contacts=[("joint_0", "ground_0")], impulses=[-0.0], energy_loss=-1e-12, u_minus=None, u_plus=None
    )
    run: Any = SimpleNamespace(q=np.zeros((1, 1)), t=np.ones(1))
    assert row(model, run, impact) == ("1.000000000000", "joint_0", *["0.000000000"] * 4)


def test_one_is_not_many() -> None:
    assert str(Counts(1, 1, 1, 1, 1)) == (
        "3 operations (1 sum, 1 product, 1 quotient) and 1 sine with its cosine and 1 other function"
    )
    assert str(Counts(2, 0, 2, 2)) == "4 operations (2 sums, 0 products, 2 quotients) and 2 sines with their cosines"


def test_a_torque_needs_a_joint(tmp_path: Path) -> None:
    done = ccgen("torque", str(SCENES / "slider-crank.toml"), at=tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == (
        "JOINT: found none, expected the joint that drives, one of: motor, crank_pin, wrist_pin; "
        "name it behind the scene file\n"
    )


def test_a_torque_needs_a_joint_that_turns(tmp_path: Path) -> None:
    scene = str(SCENES / "slider-crank.toml")
    done = ccgen("torque", scene, "nope", at=tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == (
        f"JOINT: found 'nope', which does not turn in {scene}, "
        "expected the joint that drives, one of: motor, crank_pin, wrist_pin; name one of them\n"
    )


def test_a_torque_turns_the_only_driven_joint(tmp_path: Path) -> None:
    done = ccgen("torque", str(SCENES / "jansen-driven.toml"), at=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "axle turned once at 1 rad/s" in done.stdout


@pytest.mark.hard
def test_a_motion_that_drives_give_has_no_price_of_accuracy(tmp_path: Path) -> None:
    (tmp_path / "driven.toml").write_text(DRIVEN)
    done = ccgen("cost", "driven.toml", at=tmp_path)
    assert done.returncode == 0
    last = done.stdout.splitlines()[-1]
    assert last.startswith("drives and loops give the whole motion: errors are up to ")
    assert "keep the scene's: gauss at rtol 1e-07" in last
    assert "for 1e-" not in done.stdout
    (tmp_path / "rough.toml").write_text(DRIVEN.replace("speed = 3.0", 'speed = "3 + 20*sin(40*t)"'))
    rough = ccgen("cost", "rough.toml", "--error", "1e-9", at=tmp_path)
    assert rough.stdout.splitlines()[-1].startswith("for 1e-09: ")
