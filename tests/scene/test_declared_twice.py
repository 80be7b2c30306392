"""Keys and tables that stand twice: each is told with its name and both lines, all of them at once."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from ccgen.generator import SceneError, load_scene
from ccgen.generator.scene.editor_schema import editor_schema

AGAIN = "found a second time, expected once; line {} has it too; write them as one, or leave one out"
APART = "found apart from the rest of {}, which line {} gives, expected within it; write it there"


def faults(text: str, folder: Path) -> list[str]:
    """What is told of a file, without its name."""
    file = folder / "my.toml"
    file.write_bytes(text.encode())
    with pytest.raises(SceneError) as error:
        load_scene(file)
    return [line.removeprefix(f"{file}:") for line in str(error.value).splitlines()]


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ('name = "a"\n\nname = "b"', [f"3: name: {AGAIN.format(1)}"]),
        ("[run]\nuntil = 1\n[run]\nrtol = 1\n", [f"3: run: {AGAIN.format(1)}"]),
        ("[[link]]\nmass = 1\n[[link]]\nmass = 2\nmass = 3\n", [f"5: link[1].mass: {AGAIN.format(4)}"]),
        ("[start]\nangles = { a = 1, b = 2, a = 3 }\n", [f"2: start.angles.a: {AGAIN.format(2)}"]),
        ("let = [\n1,\n2]\nlet = [\n3\n]\n", [f"4: let: {AGAIN.format(1)}"]),
        ("[start]\nangles = { a = 1 }\n[start.angles]\nb = 2\n", [f"3: start.angles: {AGAIN.format(2)}"]),
        ("[start]\nangles.a = 1\nangles = { b = 1 }\n", [f"3: start.angles: {AGAIN.format(2)}"]),
        ("[start]\nangles = { a = 1 }\nangles.b = 2\n", [f"3: start.angles.b: {APART.format('start.angles', 2)}"]),
        ('text = """\nname = 1\nname = 2\n"""\n"text" = 1\n', [f"5: text: {AGAIN.format(1)}"]),
    ],
)
@pytest.mark.parametrize("ends", ["\n", "\r\n"])
def test_a_key_that_stands_twice_is_named(text: str, told: list[str], ends: str, tmp_path: Path) -> None:
    assert faults(text.replace("\n", ends), tmp_path) == told


def lists() -> list[str]:
    """Tables of which there may be several, by what editors are told: of a scene, and of its parts."""
    schema = json.loads(editor_schema())
    whole, parts = schema["properties"], schema["$defs"]["PartTable"]["properties"]
    listed = [key for key, one in whole.items() if one.get("type") == "array"]
    return listed + [f"part.{key}" for key, one in parts.items() if "$ref" in one.get("items", {})]


def test_there_are_lists() -> None:
    assert {"link", "joint", "part", "place", "event", "hold", "release", "spring", "part.link"} <= {*lists()}


@pytest.mark.parametrize("name", lists())
@pytest.mark.parametrize("first", ["[{}]", "[[{}]]"])
def test_of_what_there_may_be_several_is_written_with_two_brackets(first: str, name: str, tmp_path: Path) -> None:
    first = first.format(name)
    single = f"found [{name}], expected [[{name}]], of which there are several; write [[{name}]]"
    told = faults(f"{first}\na = 1\n[{name}]\nb = 2\n", tmp_path)
    assert told == [f"{line}: {single}" for line in ((1, 3) if "[[" not in first else (3,))]


def test_all_are_told_at_once(tmp_path: Path) -> None:
    """With single headers of tables of which there are several, and what is no TOML behind them."""
    text = "[link]\nmass = 1\nmass = 2\n[run]\n[link]\n[run]\nuntil = { a = 1, a = 2 }\nlength = 20 cm\n"
    single = "found [link], expected [[link]], of which there are several; write [[link]]"
    *told, last = faults(text, tmp_path)
    assert told == [
        f"1: {single}",
        f"3: link[0].mass: {AGAIN.format(2)}",
        f"5: {single}",
        f"6: run: {AGAIN.format(4)}",
        f"7: run.until.a: {AGAIN.format(7)}",
    ]
    assert last.startswith("8: found no valid TOML: ") and last.endswith(
        'write "20 cm", in quotes, for a number with its unit'
    )


def test_of_many_the_first_are_told(tmp_path: Path) -> None:
    told = faults("a = 1\n" * 200, tmp_path)
    assert len(told) <= 52 and told[0] == f"2: a: {AGAIN.format(1)}"
