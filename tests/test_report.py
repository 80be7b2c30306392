"""What commands print: figures with their scale, lists that say what they leave out, no minus before a zero."""

from __future__ import annotations

import re
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

from ccgen.generator.cli.report import energy_moved, row
from ccgen.generator.program.program import Counts
from ccgen.runtime import simulate

from .conftest import Workshop
from .test_cli import PENDULUM, SCENES, ccgen

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


def test_branches_left_out_are_counted(tmp_path: Path) -> None:
    """The beach animal has 14 loops, 8 of which are told."""
    lines = ccgen("show", str(SCENES / "strandbeest.toml"), at=tmp_path).stderr.splitlines()
    assert sum(": branch " in line for line in lines) == 8
    assert lines[-1] == "strandbeest: and 6 more; ccgen show has all"


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
