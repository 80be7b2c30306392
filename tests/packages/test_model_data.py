"""The data of a package: as its schema says, checked when it is loaded, and each parameter with its domain."""

from __future__ import annotations

import copy
import hashlib
import importlib.util
import json
import shutil
from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any, get_args

import jsonschema
import pytest

from ccgen.generator import generate, load_scene
from ccgen.generator.effect_base.contact import LAWS
from ccgen.generator.effects import REGISTRY
from ccgen.generator.package.data import model_data
from ccgen.generator.package.parts import seal
from ccgen.generator.package.schema import ModelData, schema_text
from ccgen.generator.pipeline import derive_scene
from ccgen.generator.write_c.precision import PRECISIONS
from ccgen.runtime import load_model
from ccgen.runtime.loading.check import SCHEMA, fault
from ccgen.runtime.model.parameters import unmet

from ..support.folders import ROOT, SCENES

EFFECTS = """
name = "effects"

[chain]
links = 3
hinged = true
length = 1.0
mass = 1.0
inertia = 0.1

[gravity]
direction = [0.1, -1]

[[ground]]
point = [0.5, -8]
normal = [0.1, 1]
restitution = 0.5
friction = 0.3
radius = 0.1
contacts = ["link_2.B"]

[[spring]]
between = ["link_0.B", "ground.O"]
stiffness = 3.0
length = 0.5

[[damper]]
between = ["link_1.B", "ground.O"]
damping = 0.2

[[torsion]]
joint = "joint_1"
stiffness = 2.0
angle = 0.1
damping = 0.1

[[joint_friction]]
joints = ["joint_0"]
viscous = 0.1
dry = 0.2
rate = 0.01

[[drag]]
point = "link_2.B"
linear = 0.1
quadratic = 0.2
speed = 0.01

[[motor]]
joint = "joint_2"
angle = 0.3
stiffness = 5.0
damping = 0.4

[[stop]]
joint = "joint_1"
lowest = -2.0
highest = 2.0
restitution = 0.4
"""


@cache
def data(name: str) -> dict[str, Any]:
    """The data of a scene's model, without compiling it."""
    scene = load_scene(SCENES / f"{name}.toml")
    topology, equations = derive_scene(scene)
    found: dict[str, Any] = json.loads(json.dumps(model_data(scene, topology, equations, "0", 1)))
    return found


@pytest.fixture(scope="module")
def effects(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    file = tmp_path_factory.mktemp("effects") / "effects.toml"
    file.write_text(EFFECTS)
    scene = load_scene(file)
    return json.loads(json.dumps(model_data(scene, *derive_scene(scene), "0", 1)))  # type: ignore[no-any-return]


def script() -> ModuleType:
    spec = importlib.util.spec_from_file_location("model_schema", ROOT / "docs" / "scripts" / "model_schema.py")
    assert spec and spec.loader
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_schema_and_table_are_written_from_the_generator() -> None:
    """Else run docs/scripts/model_schema.py --write."""
    assert SCHEMA.read_text() == schema_text()
    assert script().page() == (ROOT / "docs" / "model.md").read_text()


def test_precisions_of_the_schema_are_those_of_the_generator() -> None:
    assert set(get_args(ModelData.model_fields["precision"].annotation)) == set(PRECISIONS)


@pytest.mark.parametrize("name", ["falling-hexagon", "four-bar", "slider-crank", "jansen-driven"])
def test_data_are_as_the_schema_says(name: str) -> None:
    jsonschema.validate(data(name), json.loads(schema_text()), jsonschema.Draft202012Validator)
    assert fault(data(name)) == ""


def damaged(value: Any, here: str = "") -> Iterator[tuple[str, Any]]:
    """Places in the data, each with the whole data in which it lacks a key, or has a key or a value that cannot be."""
    wrong: dict[type, list[Any]] = {
        str: [1, None, True],
        int: ["1", None, 0.5],
        float: [[], None, True],
        bool: [0, None],
        list: [{}, None],
    }
    if isinstance(value, dict):
        for key, inside in value.items():
            yield from ((place, {**value, key: other}) for place, other in damaged(inside, f"{here}.{key}"))
            yield f"{here}.{key}", {name: other for name, other in value.items() if name != key}
        yield f"{here}.extra", {**value, "extra": object}
    if isinstance(value, list) and value:
        for place, other in damaged(value[0], f"{here}[0]"):
            yield place, [other, *value[1:]]
    for other in wrong.get(type(value), []):
        yield here, other


def test_the_runtime_and_a_validator_find_the_same_faults(effects: dict[str, Any]) -> None:
    """In the data of a scene with most effects, wherever a key is missing or new, or a value of another type."""
    judge = jsonschema.Draft202012Validator(json.loads(schema_text()))
    seen = 0
    for place, wrong in damaged(copy.deepcopy(effects)):
        said = fault(wrong)
        assert bool(said) != judge.is_valid(wrong), (place, said)
        assert not said or said.partition(":")[0] == place.removeprefix(".") or place.startswith("[") or "[" in place
        seen += bool(said)
    assert seen > 150


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"contract": 3}, r"model.json: contract: found 3, expected \d+"),
        ({"contract": None}, r"model.json: contract: found None, expected \d+"),
        ({"links": "a"}, "model.json: links: found 'a', expected an array"),
        ({"links": ["a", 2]}, r"model.json: links\[1\]: found 2, expected a string"),
        ({"law": "hertz"}, f"model.json: law: found 'hertz', expected one of {', '.join(map(repr, LAWS))}"),
        (
            {"run": {"until": 0.0, "rtol": 1e-9, "atol": None, "on_gain": "stop"}},
            "model.json: run.until: found 0.0, expected more than 0",
        ),
        ({"between": [[0]]}, r"model.json: between\[0\]: found 1 values, expected 2"),
        ({"colour": 1}, "model.json: colour: found a key that no model has"),
    ],
)
def test_data_that_are_wrong_are_not_loaded(change: dict[str, Any], told: str, package: Path) -> None:
    written(package, json.loads((package / "model.json").read_text()) | change)
    with pytest.raises(ImportError, match=f"{package}: the model cannot be loaded: {told}.*generate it again"):
        load_model(package)


def test_data_that_lack_a_key_are_not_loaded(package: Path) -> None:
    whole = json.loads((package / "model.json").read_text())
    assert len(whole) > 30
    for key in whole:
        if key == "parts":  # what is drawn where effects act may be nothing
            continue
        written(package, {name: value for name, value in whole.items() if name != key})
        with pytest.raises(ImportError, match=rf"model.json: {key}: found (nothing|None), expected"):
            load_model(package)
    written(package, [])
    with pytest.raises(ImportError, match=r"model.json: the whole: found \[\], expected an object"):
        load_model(package)
    written(package, whole)
    assert load_model(package).links == ("link_0", "link_1", "link_2")


@pytest.fixture(scope="module")
def generated(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("generated")
    (folder / "effects.toml").write_text(EFFECTS)
    return generate(load_scene(folder / "effects.toml"), out=folder)


@pytest.fixture
def package(generated: Path, tmp_path: Path) -> Path:
    """A copy, which may be damaged."""
    return Path(shutil.copytree(generated, tmp_path / "effects"))


def written(package: Path, found: object) -> None:
    """Put other data into a package, as if they had been generated so."""
    content = json.dumps(found).encode()
    (package / "model.json").write_bytes(content)
    record = json.loads((package / "build.json").read_text())
    record["parts"]["model.json"] = {"size": len(content), "sha256": hashlib.sha256(content).hexdigest()}
    (package / "build.json").write_text(json.dumps(record | {"seal": seal(record)}))


# -- domains ----------------------------------------------------------------------------------------------------------


def bounds_of(kind: str, key: str) -> tuple[float | None, float | None] | None:
    """Lowest and highest value of a key of an effect's table in a scene; ``None`` where there is no such key."""
    table = next((entry.table for entry in REGISTRY if entry.key == kind), None)
    if table is None or key not in table.model_fields:
        return None
    text = json.dumps(table.model_json_schema()["properties"][key])
    low, high = ("minimum" in text or "exclusiveMinimum" in text), '"maximum"' in text
    return 0.0 if low else None, 1.0 if high else None


def test_domains_are_those_of_the_tables_in_scenes(effects: dict[str, Any]) -> None:
    """A parameter may become what its table may say; where that is positive, also zero unless it divides."""
    compared = 0
    for one in effects["parameters"]:
        name, key, *_ = one["path"].split(".")
        if (bounds := bounds_of(name.rpartition("_")[0] or name, key)) is None:
            continue
        domain = one["domain"]
        lowest = domain["minimum"] if domain["above"] is None else domain["above"]
        assert (lowest, domain["maximum"]) == bounds, one["path"]
        compared += 1
    assert compared >= 20


def test_a_model_refuses_what_is_outside_a_domain(package: Path) -> None:
    model = load_model(package)
    for one in model.data["parameters"]:
        domain, path = one["domain"], one["path"]
        outside = [bound - 1.0 for bound in (domain["minimum"],) if bound is not None]
        outside += [bound for bound in (domain["above"],) if bound is not None]
        outside += [bound + 1.0 for bound in (domain["maximum"],) if bound is not None]
        for value in outside:
            with pytest.raises(ValueError, match=f"{path}: found {value}, expected a"):
                model.parameters[path] = value
        assert model.parameters[path] == one["value"]
    for path, value in (("spring_0.stiffness", -1.0), ("joint_friction_0.rate", 0.0), ("link_0.mass", 0.0)):
        with pytest.raises(ValueError, match=f"{path}: found {value}, expected a"):
            model.parameters[path] = value
    model.parameters["spring_0.stiffness"] = 0.0
    assert model.parameters["spring_0.stiffness"] == 0.0


@pytest.mark.parametrize(
    ("domain", "good", "bad", "said"),
    [
        ((None, None, None), (-1e300, 0.0), (), ""),
        ((0.0, None, None), (0.0, 3.0), (-1e-300,), "a number that is not negative"),
        ((None, 0.0, None), (1e-300,), (0.0, -1.0), "a positive number"),
        ((0.0, None, 1.0), (0.0, 1.0), (-0.1, 1.1), "a number from 0 to 1"),
        ((None, 2.0, 3.0), (2.5, 3.0), (2.0, 3.5), "a number more than 2 and at most 3"),
    ],
)
def test_domains_in_words(domain: tuple[Any, ...], good: tuple[float, ...], bad: tuple[float, ...], said: str) -> None:
    given = dict(zip(("minimum", "above", "maximum"), domain, strict=True))
    assert [unmet(given, value) for value in good] == [""] * len(good)
    assert [unmet(given, value) for value in bad] == [said] * len(bad)


def test_the_law_is_that_of_the_run() -> None:
    """Also without a ground: stops follow it too. One that is not in the list falls to no other."""
    scene = load_scene(SCENES / "falling-hexagon.toml")
    derived = derive_scene(scene)

    def law(name: Any, **changes: Any) -> object:
        return model_data(replace(scene, run=replace(scene.run, law=name), **changes), *derived, "0", 1)["law"]

    assert scene.run.law == LAWS[0]
    for one in LAWS:
        assert law(one) == law(one, effects=()) == one
    *most, last = map(repr, LAWS)
    with pytest.raises(ValueError, match=rf"law\n +Input should be {', '.join(most)} or {last}"):
        law("hooke")
