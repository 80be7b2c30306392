"""The JSON Schema for editors knows every word of scene files, and takes what the reader takes."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path
from typing import Any

import jsonschema
import pytest

from ccgen.generator.scene import TABLES
from ccgen.generator.scene.editor_schema import editor_schema

from ..support.effect_examples import EXAMPLES, SCENE
from ..support.folders import ROOT, SCENES
from ..support.legs import LEG, PLACES

SCHEMA: dict[str, Any] = json.loads(editor_schema())
JUDGE = jsonschema.Draft202012Validator(SCHEMA)


def wrong(text: str) -> list[str]:
    return [error.json_path for error in JUDGE.iter_errors(tomllib.loads(text))]


def test_the_stored_schema_is_that_of_the_tables() -> None:
    """Else run docs/scripts/scene_schema.py --write."""
    jsonschema.Draft202012Validator.check_schema(SCHEMA)
    assert (ROOT / "docs" / "scene.schema.json").read_text(encoding="utf-8") == editor_schema()


@pytest.mark.parametrize("path", sorted(SCENES.glob("*.toml")), ids=lambda path: path.stem)
def test_scenes_are_valid(path: Path) -> None:
    assert wrong(path.read_text()) == []


@pytest.mark.parametrize("key", EXAMPLES)
def test_every_effect_is_known(key: str) -> None:
    assert wrong(SCENE + EXAMPLES[key]) == []
    assert wrong(SCENE + EXAMPLES[key].replace(" = ", "_ = ", 1))


def test_every_key_is_told() -> None:
    for key, kind in TABLES.items():
        one = SCHEMA["properties"][key]
        table = SCHEMA["$defs"][(one["items"] if kind.many else one)["$ref"].rpartition("/")[2]]
        assert table.get("properties", {}).keys() == kind.keys.keys(), key


def test_parts_are_known() -> None:
    assert wrong(LEG + PLACES) == []
    assert wrong(LEG.replace("inertia", "inertai") + PLACES) == ["$.part[0].link[0]"]
    assert wrong(LEG.replace("[part.start]", "[part.start]\ntilt = 1") + PLACES) == ["$.part[0].start"]
    assert wrong(LEG + PLACES.replace("mirror = true", 'mirror = "left"')) == ["$.place[1].mirror"]
