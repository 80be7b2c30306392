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
    Path("my/planet.toml").mkdir()
    Path("build").mkdir()


@pytest.mark.parametrize(
    ("name", "near"),
    [
        ("my/hexagn.toml", "; near it is falling-hexagon.toml"),
        ("my/Hexagon", "; near it is falling-hexagon.toml"),
        ("my/four_bar.toml", "; near it is four-bar.toml"),
        ("my/plan.tom", "; near it is plan.toml"),
        ("my/planes.toml", "; near it is plan.toml"),
        ("my/strandbeest.toml", ""),
        ("mine/four-bar.toml", "; there is no folder mine"),
    ],
)
def test_names_that_may_be_meant(name: str, near: str) -> None:
    for read in (load_scene, ccgen.load, ccgen.simulate):
        with pytest.raises(SceneError) as error:
            read(name)  # type: ignore[operator]
        assert str(error.value) == f"{name}: {SAID}{near}; correct the name"


MISSPELT = f"my/four-bra.toml: {SAID}; near it is four-bar.toml; correct the name"
PLAN = "my/plam.toml: found nothing there, expected a plan (TOML); near it is plan.toml; correct the name"


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
                "my/result: found nothing there, expected the folder of a sweep; near it is results; correct the name",
            ],
        ),
        (
            "plot my/results/four-bra",
            [
                "my/results/four-bra: found nothing there, expected a folder of results, or the .npz file of a run; "
                "near it is four-bar; correct the name"
            ],
        ),
        (
            "diff my/four-bra.toml my/four-bar.toml",
            [
                "my/four-bra.toml: found nothing there, expected a generated folder, an equations.txt or a scene; "
                "near it is four-bar.toml; correct the name"
            ],
        ),
    ],
)
def test_every_command_names_them(command: str, told: list[str]) -> None:
    done = CliRunner().invoke(app, command.split())
    assert done.exit_code == 2
    assert done.stderr.splitlines() == told


def test_several_names_are_near() -> None:
    for name in ("leg-1.toml", "leg-2.toml"):
        Path("my", name).write_text("")
    with pytest.raises(SceneError, match=r"; near it are leg-\d\.toml and leg-\d\.toml; correct the name"):
        load_scene("my/leg-3.toml")


@pytest.mark.parametrize("command", ["sweep my/four-bar.toml my", "replay my/results my/four-bar.toml my 0"])
def test_a_folder_is_no_plan(command: str) -> None:
    """Told before a model is generated."""
    done = CliRunner().invoke(app, command.split())
    assert done.exit_code == 2
    assert done.stderr == "my: found a folder, expected a plan (TOML); name a file\n"
    assert not any(Path("build").iterdir())


def test_of_many_names_the_first_by_the_alphabet_are_looked_at(monkeypatch: pytest.MonkeyPatch) -> None:
    """Not those that the system happens to list first."""
    monkeypatch.setattr("ccgen.generator.scene.near_files.MOST", 2)
    for k in range(20):
        Path("my", f"wheel-{k:02}.toml").write_text("")
    for k in reversed(range(3)):
        Path("my", f"aaaa-{k}.toml").write_text("")
    with pytest.raises(SceneError, match=r"; near it are aaaa-[01]\.toml and aaaa-[01]\.toml; correct the name"):
        load_scene("my/aaaa-9.toml")
