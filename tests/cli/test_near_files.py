"""Misspelt names of files: every command, and ``ccgen.load``, name those in the folder that may be meant."""

from __future__ import annotations

from pathlib import Path

import pytest
from typer.testing import CliRunner

import ccgen
from ccgen.generator import SceneError, load_scene
from ccgen.generator.cli.app import app

from ..support.folders import SCENES

SAID = "No such file or directory; expected a scene file (TOML)"


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("my").mkdir()
    for name in ("falling-hexagon.toml", "four-bar.toml", "plan.toml", "hexagon.txt", ".hexagon.toml"):
        Path("my", name).write_text((SCENES / "four-bar.toml").read_text())
    Path("my/results/four-bar").mkdir(parents=True)
    Path("build").mkdir()


@pytest.mark.parametrize(
    ("name", "near"),
    [
        ("my/hexagn.toml", ", as falling-hexagon.toml there"),
        ("my/Hexagon", ", as falling-hexagon.toml there"),
        ("my/four_bar.toml", ", as four-bar.toml there"),
        ("my/strandbeest.toml", ""),
        ("mine/four-bar.toml", "; there is no folder mine"),
    ],
)
def test_names_that_may_be_meant(name: str, near: str) -> None:
    for read in (load_scene, ccgen.load, ccgen.simulate):
        with pytest.raises(SceneError) as error:
            read(name)  # type: ignore[operator]
        assert str(error.value) == f"{name}: {SAID}{near}; correct the name"


MISSPELT = f"my/four-bra.toml: {SAID}, as four-bar.toml there; correct the name"
PLAN = "my/plam.toml: found no such file, expected a plan (TOML), as plan.toml there; correct the name"


@pytest.mark.parametrize(
    ("command", "told"),
    [
        ("run my/four-bra.toml", [MISSPELT]),
        ("show my/four-bra.toml", [MISSPELT]),
        ("--scene my/four-bra.toml", [MISSPELT]),
        ("cost my/four-bra.toml", [MISSPELT]),
        ("cost my/four-bra.toml --effects", [MISSPELT]),
        ("cost my/four-bra.toml --gradient", [MISSPELT]),
        ("torque my/four-bra.toml", [MISSPELT]),
        ("equilibrium my/four-bra.toml", [MISSPELT]),
        ("orbit my/four-bra.toml --section 1", [MISSPELT]),
        ("sweep my/four-bra.toml my/plam.toml", [MISSPELT, PLAN]),
        (
            "replay my/result my/four-bra.toml my/plam.toml 0",
            [
                MISSPELT,
                PLAN,
                "my/result: found no such file, expected the folder of a sweep, as results there; correct the name",
            ],
        ),
        (
            "plot my/results/four-bra",
            [
                "my/results/four-bra: found no such file, expected a folder of results, or the .npz file of a run, as "
                "four-bar there; correct the name"
            ],
        ),
        (
            "diff my/four-bra.toml my/four-bar.toml",
            [
                "my/four-bra.toml: found no such file, expected a generated folder, an equations.txt or a scene, as "
                "four-bar.toml there; correct the name"
            ],
        ),
    ],
)
def test_every_command_names_them(command: str, told: list[str]) -> None:
    done = CliRunner().invoke(app, command.split())
    assert done.exit_code == 2
    assert done.stderr.splitlines() == told
