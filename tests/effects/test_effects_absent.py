"""An effect that a scene does not name leaves no trace: the same program as from a generator that never knew it."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import pytest

from ccgen.generator import pipeline
from ccgen.generator.effects import REGISTRY, Entry
from ccgen.generator.scene import Scene, read
from ccgen.generator.write_c.render import Banner

from ..support.effect_examples import EXAMPLES, SCENE
from ..support.tiers import LARGE, hard


def _program(text: str, folder: Path) -> dict[str, bytes]:
    """What is written for the scene before the compiler sees it."""
    scene = read.read_tables(tomllib.loads(text), "scene.toml", "plain")
    assert isinstance(scene, Scene)
    folder.mkdir()
    pipeline._write_model(scene, Banner(scene.name, scene.package, "0", "0"), folder, lambda stage: None)
    return {file.name: file.read_bytes() for file in folder.iterdir()}


def _without(entry: Entry, monkeypatch: pytest.MonkeyPatch) -> None:
    """The generator as if the effect had never been registered."""
    monkeypatch.setattr(read, "REGISTRY", tuple(e for e in REGISTRY if e is not entry))
    monkeypatch.setattr(read, "KEYS", tuple(key for key in read.KEYS if key != entry.key))


def test_every_effect_has_an_example() -> None:
    assert list(EXAMPLES) and {entry.key for entry in REGISTRY} == set(EXAMPLES)


ALONE = "nothing"
BESIDE = [(key, ALONE) for key in EXAMPLES] + [(key, "every other effect") for key in [*EXAMPLES][:: 1 if LARGE else 3]]
"""Beside every other effect each third one in ``make hard``: three programs of all of them take five seconds."""


@pytest.mark.parametrize(
    ("key", "beside"), [case if case in (("gravity", ALONE), ("drive", ALONE)) else hard(*case) for case in BESIDE]
)
def test_removing_a_table_removes_the_effect(
    key: str, beside: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Byte for byte."""
    (entry,) = (entry for entry in REGISTRY if entry.key == key)
    others = "" if beside == ALONE else "".join(example for other, example in EXAMPLES.items() if other != key)
    full = _program(SCENE + others + EXAMPLES[key], tmp_path / "full")
    bare = _program(SCENE + others, tmp_path / "bare")
    _without(entry, monkeypatch)
    assert _program(SCENE + others, tmp_path / "never") == bare
    assert set(bare) == {"equations.txt", "model.c", "lanes.c", "model.json"}
    for product in ("equations.txt", "model.c"):
        assert bare[product] != full[product]


@pytest.mark.parametrize("entry", REGISTRY, ids=lambda entry: entry.key)
def test_parameters_are_those_of_the_scene(entry: Entry) -> None:
    """Parameters are called after the table or its name, and nothing of the mechanism changes."""
    bare: Any = read.read_tables(tomllib.loads(SCENE), "scene.toml", "plain")
    scene: Any = read.read_tables(tomllib.loads(SCENE + EXAMPLES[entry.key]), "scene.toml", "plain")
    assert scene.mechanism == bare.mechanism
    found = [p.path for effect in scene.effects for p in effect.parameters()]
    assert len(set(found)) == len(found)
    assert all(path.startswith((f"{entry.key}.", f"{entry.key}_0.")) for path in found)
