"""No package hides a module that Python would find without it."""

from __future__ import annotations

import dataclasses
import sys
import sysconfig
from pathlib import Path

import pytest

from ccgen.generator import OutputError, SceneError, generate, load_scene, loop
from ccgen.generator.scene.module_names import hidden_module

ROD = "[chain]\nlinks = 1\n"


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("os", "a module of Python's own"),
        ("platform", "a module of Python's own"),
        ("sys", "a module of Python's own"),
        ("ccgen", "ccgen itself"),
        ("numpy", "an installed module (.*numpy"),
        ("mpmath", "an installed module (.*mpmath"),
        ("typing-extensions", "an installed module (.*typing_extensions.py"),
    ],
)
def test_names_of_modules_are_refused(name: str, told: str, tmp_path: Path) -> None:
    file = tmp_path / f"{name}.toml"
    expected = f"the name of {told.replace('(', '[(]')}.*, expected one that hides no module"
    file.write_text(ROD)
    with pytest.raises(SceneError, match=f'name: found the file\'s name "{name}", {expected}; add a name'):
        load_scene(file)
    file.write_text(f'# a rod\nname = "{name}"\n{ROD}mass = -1\n')
    with pytest.raises(SceneError, match=f'{file}:2: name: found "{name}", {expected}; change it') as caught:
        load_scene(file)
    assert len(caught.value.faults) == 2
    stages: list[str] = []
    with pytest.raises(OutputError, match=f"{name}: found the name of .*give the scene another name"):
        generate(dataclasses.replace(loop(3), name=name), tmp_path / "build", stages.append)
    assert stages == [] and not (tmp_path / "build").exists()


@pytest.mark.parametrize("name", ["pendulum", "four-bar", "os2", "numpy-arm", "falling_hexagon"])
def test_other_names_are_taken(name: str, tmp_path: Path) -> None:
    (tmp_path / f"{name}.toml").write_text(ROD)
    assert load_scene(tmp_path / f"{name}.toml").name == name


def test_scripts_beside_the_scene_do_not_count(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """pendulum.py that uses pendulum.toml is usual; and what is on the path by chance decides nothing."""
    (tmp_path / "pendulum.py").write_text("")
    (tmp_path / "pendulum.toml").write_text(ROD)
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.syspath_prepend("")
    assert load_scene("pendulum.toml").name == "pendulum"


def test_generated_packages_among_those_installed_hide_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    package = generate(loop(3), tmp_path)
    monkeypatch.setattr(sysconfig, "get_path", lambda kind: str(tmp_path))
    assert hidden_module("loop3") is None
    (package / "build.json").unlink()
    assert hidden_module("loop3") == f"an installed module ({package / '__init__.py'})"


def test_all_of_python_s_modules_are_known() -> None:
    assert all(hidden_module(name) for name in sys.stdlib_module_names)
