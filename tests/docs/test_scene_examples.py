"""What docs/scenes.md shows of numbers in quotes and of links made of bodies is read, and is what it says."""

from __future__ import annotations

import re
import tomllib
from typing import Any

import pytest

from ccgen.generator.effect_base.arithmetic import FUNCTIONS
from ccgen.generator.effect_base.units import UNITS
from ccgen.generator.scene import Scene, SceneError, load_scene, read_tables
from ccgen.generator.scene.part_tables import PartTable, PlaceTable
from ccgen.generator.scene.schema import MOST_CORNERS, DiscTable, PlateTable, PointMassTable, RodTable

from ..support.folders import ROOT

SCENES = (ROOT / "docs" / "scenes.md").read_text(encoding="utf-8")


def section(title: str) -> str:
    """The text under a heading, to the next of any kind."""
    return re.split(r"\n#{2,3} ", SCENES.partition(f"# {title}\n")[2])[0]


def examples(title: str) -> list[Scene]:
    texts = re.findall(r"```toml\n(.*?)```", section(title), re.DOTALL)
    return [read_tables(tomllib.loads(text), "scene", "scene") for text in texts]


def test_names_of_numbers() -> None:
    (scene,) = examples("Numbers: units, names, arithmetic")
    lengths = [link.points["B"].values()[0] for link in scene.mechanism.links]
    assert lengths == [0.2, 0.2, 0.1]
    assert [link.mass.value for link in scene.mechanism.links if link.mass] == pytest.approx([2 * 7850 * 0.2**3] * 3)


def test_a_scene_in_words_is_that_in_numbers() -> None:
    words, numbers = examples("Links made of rods, plates and discs")
    assert words.canonical() == numbers.canonical()


def test_units_and_functions_are_those_that_are_read() -> None:
    """The table has every unit, and the list every function."""
    text = section("Numbers: units, names, arithmetic")
    rows = [line.split("|")[2] for line in text.partition("| of | units |")[2].splitlines() if line.startswith("| ")]
    assert {unit for row in rows for unit in re.findall(r"`([^`]+)`", row)} == UNITS.keys()
    (functions,) = re.findall(r"the functions `([^`]+)`", text)
    assert {*functions.split()} == {*FUNCTIONS}


def test_keys_of_bodies_are_those_that_are_read() -> None:
    text = section("Links made of rods, plates and discs")
    keys = {
        key for line in text.splitlines() if line.startswith("|") for key in re.findall(r"`(\w+)`", line.split("|")[2])
    }
    tables = (RodTable, PlateTable, DiscTable, PointMassTable)
    assert keys == {key for table in tables for key in table.model_fields}
    assert f"3 to {MOST_CORNERS} places" in text


def test_the_fault_of_a_unit() -> None:
    """The line of the text is the line that is printed."""
    text = '[ground_link]\npoints = { O = [0, 0] }\n\n\n[[link]]\ncom = [0, 0]\ninertia = 1\nmass = "20 cm"\n'
    tables: dict[str, Any] = tomllib.loads(
        text + 'points = { A = [0, 0] }\n[[joint]]\nbetween = ["ground.O", "link_0.A"]'
    )
    with pytest.raises(SceneError) as caught:
        read_tables(tables, "arm.toml", "arm", {("link", 0, "mass"): 8})
    assert f"\n    {caught.value}\n" in section("Numbers: units, names, arithmetic")


def test_lines_of_the_first_mechanism() -> None:
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    (text,) = re.findall(r"```toml\n(name = \"my-four-bar\".*?)```", readme, re.DOTALL)
    now = text.count("\n")
    was = now + 2 * len(tomllib.loads(text)["link"])
    told = f"had {was} lines with nine numbers\nworked out by hand, and has {now}"
    assert told in section("Links made of rods, plates and discs")


def test_the_faults_of_the_wrong_file() -> None:
    """All of them, in the words of the text."""
    text = section("Errors")
    (toml,) = re.findall(r"```toml\n(.*?)```", text, re.DOTALL)
    with pytest.raises(SceneError) as caught:
        read_tables(tomllib.loads(toml), "bad.toml", "bad")
    printed = re.findall(r"^    bad\.toml:\d+: (.*)$", text, re.MULTILINE)
    assert sorted(f"{fault.key}: {fault.message}" for fault in caught.value.faults) == sorted(printed)


def test_two_legs_of_a_part() -> None:
    (scene,) = examples("`[[part]]` and `[[place]]`")
    names = [link.name for link in scene.mechanism.links]
    assert names == ["body", "thigh_left", "shin_left", "thigh_right", "shin_right"]
    text = section("`[[part]]` and `[[place]]`")
    assert f"links here are {', '.join(f'`{name}`' for name in names)}" in text.replace("\n", " ")
    lengths = [link.points["foot"].values()[0] for link in scene.mechanism.links if "foot" in link.points]
    assert lengths == pytest.approx([0.4, 0.44])
    walker = (ROOT / "scenes" / "walker.toml").read_text().count("\n")
    assert f"six legs in {walker} lines" in text


def test_keys_of_parts_are_those_that_are_read() -> None:
    text = section("`[[part]]` and `[[place]]`")
    rows = [line.split("|") for line in text.splitlines() if line.startswith("| ") and "---" not in line]
    keys = {key for row in rows[1:] for key in re.findall(r"`(\w+)`", row[2])}
    assert keys == {*PartTable.model_fields, *PlaceTable.model_fields, "link", "joint", "ground_link", "place"}


def test_the_mechanism_call_by_call() -> None:
    (text,) = [code for code in re.findall(r"```python\n(.*?)```", SCENES, re.DOTALL) if "Mechanism(" in code]
    space: dict[str, Any] = {}
    exec(text.partition("\nrun = ")[0], space)
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    (first,) = re.findall(r"```toml\n(name = \"my-four-bar\".*?)```", readme, re.DOTALL)
    tables = {key: table for key, table in tomllib.loads(first).items() if key != "run"}
    assert space["four_bar"].scene().canonical() == load_scene(tables).canonical()
