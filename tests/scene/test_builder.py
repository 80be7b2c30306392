"""Scenes built call by call: the tables of a file, whose faults are told with the line of the call."""

from __future__ import annotations

import inspect
import re
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ccgen.generator import Mechanism, SceneError, load_scene
from ccgen.generator.effects import REGISTRY
from ccgen.generator.pipeline import listing
from ccgen.generator.scene import TABLES
from ccgen.runtime import load_model

from ..support.effect_examples import EXAMPLES, SCENE
from ..support.folders import ROOT, SCENES


def four_bar() -> Mechanism:
    """The first mechanism of the README."""
    mechanism = Mechanism("my-four-bar").ground_link(points={"O": (0, 0), "Q": (0.6, 0)})
    mechanism.link("crank", rod={"mass": "400 g"}, points={"A": [0, 0], "B": ["20 cm", 0]})
    for name in ("coupler", "rocker"):
        mechanism.link(name, rod={"mass": 1.0}, points={"A": [0, 0], "B": np.array([0.5, 0])})
    for first, second in (("ground.O", "crank.A"), ("crank.B", "coupler.A"), ("coupler.B", "rocker.B")):
        mechanism.joint(between=(first, second))
    mechanism.joint(None, between=["ground.Q", "rocker.A"])
    mechanism.start(angles={"crank": "90 deg", "coupler": "20 deg", "rocker": "100 deg"})
    return mechanism.start(angular_velocities={"crank": 12.0}).gravity(g=9.81).run(until=3.0)


def readme() -> str:
    (text,) = re.findall(r"```toml\n(name = \"my-four-bar\".*?)```", (ROOT / "README.md").read_text(), re.DOTALL)
    return str(text)


def built(tables: dict[str, Any]) -> Mechanism:
    """The mechanism of a scene's tables, each by a call of its own."""
    mechanism = Mechanism(tables.get("name"))
    for key, value in tables.items():
        for table in value if isinstance(value, list) else [value]:
            if key != "name":
                assert getattr(mechanism, key)(**table) is mechanism
    return mechanism


def test_the_first_mechanism_without_a_file() -> None:
    scene = four_bar().scene()
    assert scene.canonical() == load_scene(tomllib.loads(readme())).canonical()
    assert listing(scene) == listing(load_scene(tomllib.loads(readme())))


@pytest.mark.sample(8)
@pytest.mark.parametrize("path", sorted(SCENES.glob("*.toml")), ids=lambda path: path.stem)
def test_every_scene_can_be_built(path: Path) -> None:
    mechanism, scene = built(tomllib.loads(path.read_text())), load_scene(path)
    assert mechanism.scene().canonical() == scene.canonical()
    assert load_scene(tomllib.loads(mechanism.to_toml())).canonical() == scene.canonical()
    assert Mechanism(tables=scene.to_dict()).scene().canonical() == scene.canonical()


@pytest.mark.sample(8)
@pytest.mark.parametrize("key", EXAMPLES)
def test_every_effect_is_a_method(key: str) -> None:
    tables = tomllib.loads(SCENE + EXAMPLES[key])
    assert listing(built(tables).scene()) == listing(load_scene(tables))
    assert key in dir(Mechanism())
    keys = [*inspect.signature(getattr(Mechanism(), key)).parameters]
    entry = next(entry for entry in REGISTRY if entry.key == key)
    assert sorted(keys) == sorted(entry.table.model_fields)


def test_words_hide_nothing() -> None:
    """No table is called as something else that a mechanism has."""
    assert not {*TABLES} & {*object.__dir__(Mechanism())}


def test_models_are_built(tmp_path: Path) -> None:
    model = load_model(four_bar().build(tmp_path))
    assert model.links == ("crank", "coupler", "rocker")


def test_all_faults_at_once_each_with_its_line() -> None:
    mechanism = Mechanism("arm").chain(links=2)
    first = inspect.currentframe().f_lineno  # type: ignore[union-attr]
    mechanism.spring("s", between=["link_0.A", "ground.O"], stifness=3)
    mechanism.start(height="high")
    mechanism.start(tilt="10 degrees").run(until=-1)
    with pytest.raises(SceneError) as caught:
        mechanism.scene()
    found = [(fault.key, (fault.line or 0) - first) for fault in caught.value.faults]
    assert ("spring[0].stifness", 1) in found and ("spring[0].stiffness", 1) not in found
    assert ("start.height", 2) in found and ("start.tilt", 3) in found and ("run.until", 3) in found
    assert {fault.file for fault in caught.value.faults} == {__file__}
    assert 'write "stiffness"' in str(caught.value)


def test_faults_of_several_files_have_no_lines() -> None:
    text = "def add(mechanism):\n    mechanism.chain(links=0)\n"
    space: dict[str, Any] = {}
    exec(compile(text, "other.py", "exec"), space)
    mechanism = Mechanism("arm")
    space["add"](mechanism)
    with pytest.raises(SceneError) as caught:
        mechanism.scene()
    assert [(fault.file, fault.line, fault.key) for fault in caught.value.faults] == [("arm", None, "chain.links")]


def test_a_part_is_a_mechanism_too() -> None:
    leg = Mechanism("leg").link("thigh", rod={"mass": 1}, points={"A": [0, 0], "B": [1, 0]})
    leg.joint(between=["hip", "thigh.A"])
    mechanism = Mechanism("legs").ground_link(points={"O": [0, 0]}).part(leg, ports=["hip"])
    for name in ("left", "right"):
        mechanism.place(name, part="leg", ports={"hip": "ground.O"})
    assert [link.name for link in mechanism.scene().mechanism.links] == ["thigh_left", "thigh_right"]
    leg.link("shin", rodd={})
    line = inspect.currentframe().f_lineno - 1  # type: ignore[union-attr]
    with pytest.raises(SceneError) as caught:
        Mechanism("legs").part(leg).place("left", part="leg").scene()
    assert {fault.line for fault in caught.value.faults if fault.key.startswith("part[0].link[1]")} == {line}


def test_wrong_calls_are_told() -> None:
    mechanism = Mechanism("arm")
    with pytest.raises(AttributeError, match="a mechanism has no sprng; write spring"):
        mechanism.sprng(stiffness=3)
    with pytest.raises(TypeError, match="link: found 3 without a key, expected one name before its keys"):
        mechanism.link("crank", 3)
    with pytest.raises(TypeError, match="start: found 'a' without a key, expected its keys by name"):
        mechanism.start("a")
    with pytest.raises(TypeError, match="link: found the names 'a' and 'b', expected one"):
        mechanism.link("a", name="b")
    assert repr(mechanism.chain(links=2).spring(stiffness=1)) == "<mechanism with name, chain, spring (1)>"


def test_calls_take_copies() -> None:
    points = {"A": [0, 0]}
    mechanism = Mechanism("arm").link("a", points=points)
    points["A"][0] = 5
    mechanism.to_dict()["link"][0]["points"]["A"][0] = 6
    assert mechanism.to_dict()["link"] == [{"name": "a", "points": {"A": [0, 0]}}]
