"""Files and streams that take no more: what is said names them, and what has room is kept."""

from __future__ import annotations

import resource
import subprocess
from pathlib import Path

import pytest

from ..support.command_line import CCGEN

PENDULUM = (
    'name = "pendulum"\n[chain]\nlinks = 1\nhinged = true\n[gravity]\n[start]\nangles = [1]\n[run]\nuntil = 0.5\n'
)
LARGEST = 4096
"""Bytes of a file that the system lets through: a record of a run and each of its pictures are more."""


def call(
    *arguments: str, at: Path, room: int | None = None, out: str | None = None
) -> subprocess.CompletedProcess[str]:
    def limit() -> None:
        if room is not None:
            resource.setrlimit(resource.RLIMIT_FSIZE, (room, room))

    (at / "pendulum.toml").write_text(PENDULUM)
    with Path(out or at / "out").open("w") as stream:
        return subprocess.run(
            [CCGEN, *arguments], cwd=at, stdout=stream, stderr=subprocess.PIPE, text=True, preexec_fn=limit, check=False
        )


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a device that is full")
@pytest.mark.parametrize("command", ["show", "check"])
def test_a_standard_output_that_is_full_is_named(command: str, tmp_path: Path) -> None:
    arguments = (command, "pendulum.toml") if command == "show" else (command,)
    done = call(*arguments, at=tmp_path, out="/dev/full")
    assert (done.returncode, done.stderr) == (2, "ccgen: standard output: No space left on device\n")


def test_a_run_without_room_says_which_files_are_missing(tmp_path: Path) -> None:
    """The run itself is done, so its numbers are printed; it ends as one that lacks something does."""
    call("--scene", "pendulum.toml", at=tmp_path)
    done = call("run", "pendulum.toml", at=tmp_path, room=LARGEST)
    lines = [
        f"pendulum: {name} is not written: results/pendulum/{name}: File too large"
        for name in ("result.npz", "plot.png", "player.html", "forces.png")
    ]
    assert (done.returncode, done.stderr.splitlines()) == (3, lines)
    assert "t = 0.5 s, impacts: 0" in (tmp_path / "out").read_text()
    assert not [file for file in (tmp_path / "results" / "pendulum").iterdir() if file.name.endswith(".part")]
