"""Scenes as tables and as text again: what is written reads back to the same scene, and to the same equations."""

from __future__ import annotations

import copy
import dataclasses
import pickle
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ccgen.generator import Scene, SceneError, load_scene, loop
from ccgen.generator.pipeline import listing
from ccgen.generator.scene.toml_text import plain, toml_text

from ..oracles.random_mechanisms import KINDS, LOADS, draw
from ..support.effect_examples import EXAMPLES, SCENE
from ..support.folders import SCENES

FILES = sorted(SCENES.glob("*.toml"))


def again(scene: Scene) -> tuple[Scene, Scene]:
    """The scene read from its tables, and from its text."""
    return load_scene(scene.to_dict()), load_scene(tomllib.loads(scene.to_toml()))


@pytest.mark.sample(9)
@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_scenes_read_back(path: Path) -> None:
    scene = load_scene(path)
    for other in again(scene):
        assert other.canonical() == scene.canonical()
        assert other.start == scene.start and other.remarks == scene.remarks
        assert other.to_dict() == scene.to_dict() == tomllib.loads(path.read_text())


@pytest.mark.parametrize("name", ["four-bar", "falling-hexagon", "quick-return", "newtons-cradle"])
def test_listings_of_what_reads_back(name: str) -> None:
    scene = load_scene(SCENES / f"{name}.toml")
    assert {listing(other) for other in again(scene)} == {listing(scene)}


@pytest.mark.parametrize("seed", range(12))
def test_random_mechanisms_read_back(seed: int, tmp_path: Path) -> None:
    rng = np.random.default_rng(seed)
    kinds = [KINDS[k] for k in rng.integers(0, 3, 4)]
    parents = [-1, *(int(rng.integers(-1, k)) for k in range(1, 4))]
    loads = [LOADS[k] for k in rng.permutation(len(LOADS))[:4]]
    path = tmp_path / "drawn.toml"
    path.write_text(draw(kinds, parents, [("revolute", 1, 3)], loads, seed).toml("drawn"))
    scene = load_scene(path)
    for other in again(scene):
        assert other.canonical() == scene.canonical() and other.start == scene.start


@pytest.mark.parametrize("key", EXAMPLES)
def test_every_effect_reads_back(key: str) -> None:
    scene = load_scene(tomllib.loads(SCENE + EXAMPLES[key]))
    for other in again(scene):
        assert other.canonical() == scene.canonical()
        assert other.effects == scene.effects


def test_shorthand_has_its_tables() -> None:
    scene = loop(6, gravity=True, start={"height": 1.0, "tilt": "10 deg"}, ground=({"restitution": 0.5},))
    assert scene.to_dict()["name"] == "loop6" and scene.to_dict()["ground"] == [{"restitution": 0.5}]
    for other in again(scene):
        assert other.canonical() == scene.canonical()


KEYS = st.text(min_size=1, max_size=6)
VALUES = st.one_of(
    st.booleans(),
    st.integers(-(2**63), 2**63 - 1),
    st.floats(allow_nan=False, allow_infinity=False),
    st.text(max_size=12),
)
TABLES = st.dictionaries(
    KEYS,
    st.recursive(
        VALUES,
        lambda inner: st.lists(inner, max_size=3) | st.dictionaries(KEYS, inner, max_size=3),
        max_leaves=12,
    ),
    max_size=5,
)


@given(TABLES)
@settings(max_examples=300, deadline=None)
def test_any_tables_read_back(tables: dict[str, Any]) -> None:
    """Bit for bit: a number keeps its type, and zero its sign."""
    assert repr(sorted_keys(tomllib.loads(toml_text(tables)))) == repr(sorted_keys(tables))


def sorted_keys(value: Any) -> Any:
    if isinstance(value, dict):
        return [[key, sorted_keys(value[key])] for key in sorted(value)]
    return [sorted_keys(one) for one in value] if isinstance(value, list) else value


def test_long_tables_have_headers_of_their_own() -> None:
    long = {f"link_{k}": "30 deg" for k in range(20)}
    text = toml_text({"start": {"angles": long, "tilt": 1}, "name": "long"})
    assert text.startswith('name = "long"\n') and "\n[start.angles]\n" in text
    assert tomllib.loads(text) == {"name": "long", "start": {"tilt": 1, "angles": long}}


def test_values_of_programs_are_those_of_files() -> None:
    """Tuples, arrays and numbers of NumPy, and keys without a value."""
    given_ = {"a": (1, 2.5), "b": np.array([[1.0, 2.0]]), "c": np.float64(0.1), "d": np.int64(3), "e": None}
    found = plain({**given_, "f": np.float32(0.5), "g": {"h": np.bool_(True)}})
    wanted = {"a": [1, 2.5], "b": [[1.0, 2.0]], "c": 0.1, "d": 3, "f": 0.5, "g": {"h": True}}
    assert repr(found) == repr(wanted)


def test_values_that_no_file_can_have() -> None:
    with pytest.raises(TypeError, match="found 1 as a key of a table, expected a text"):
        load_scene({"let": {1: 2}})
    ring: dict[str, Any] = {}
    ring["let"] = ring
    with pytest.raises(ValueError, match="more than 64 deep"):
        load_scene(ring)
    with pytest.raises(TypeError, match="found 3, expected the name of a scene file"):
        load_scene(3)  # type: ignore[arg-type]


def test_faults_of_tables_are_those_of_files() -> None:
    with pytest.raises(SceneError) as caught:
        load_scene({"name": "arm", "chain": {"links": -1, "hinged": "yes"}, "gravty": {}})
    keys = [fault.key for fault in caught.value.faults]
    assert keys == ["gravty", "chain.links", "chain.hinged"] and {fault.file for fault in caught.value.faults} == {
        "arm"
    }


def test_tables_are_the_scenes_own() -> None:
    """Neither those that were given nor those that are handed out change it; a changed scene has none."""
    tables: dict[str, Any] = {"name": "arm", "chain": {"links": 2}}
    scene = load_scene(tables)
    tables["chain"]["links"] = 3
    scene.to_dict()["chain"]["links"] = 4
    assert scene.to_dict() == {"name": "arm", "chain": {"links": 2}}
    for same in (pickle.loads(pickle.dumps(scene)), copy.deepcopy(scene)):
        assert same == scene and same.to_dict() == scene.to_dict()
    changed = dataclasses.replace(scene, run=dataclasses.replace(scene.run, until=1.0))
    for other in (changed, loop(3, gravity=True).without(0)):
        with pytest.raises(ValueError, match="changed after it was read"):
            other.to_dict()
