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


@pytest.mark.parametrize("times", [52, 53, 1000])
def test_of_many_the_first_are_told(times: int, tmp_path: Path) -> None:
    """Without a number of others where these were not looked for."""
    told = faults("a = 1\n" * times, tmp_path)
    assert told[:50] == [f"{line}: a: {AGAIN.format(1)}" for line in range(2, 52)]
    assert told[50:] == [" and more; mend these first"]


def test_fifty_are_all(tmp_path: Path) -> None:
    assert len(faults("a = 1\n" * 51, tmp_path)) == 50
    assert faults("a = 1\n" * 51 + "b\n", tmp_path)[50] == " and 1 more; mend these first"


def test_no_more_is_read_than_is_worth_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Letters of all rounds together; the first of them reads seven, each some more."""
    monkeypatch.setattr("ccgen.generator.scene.not_toml.MOST_READ", 60)
    *told, last = faults("a = 1\n" * 20, tmp_path)
    assert 1 <= len(told) <= 6 and last == " and more; mend these first"


def test_places_are_those_of_the_file(tmp_path: Path) -> None:
    """Where what stands before them was mended to read on."""
    (again, unread) = faults("a = 1\na = 2 b\n", tmp_path)
    assert again == f"2: a: {AGAIN.format(1)}"
    assert unread.startswith("2: found no valid TOML: ") and "(at line 2, column 7)" in unread
    told = faults("[link] \n[link] x\n", tmp_path)
    assert "(at line 2, column 8)" in told[-1], told


def test_advice_is_on_what_is_written(tmp_path: Path) -> None:
    """A curved quote in the text of a key that stands twice is none around a value; nor is one in a text."""
    told = faults('"\u201ca" = 1\n"\u201ca" = 2 b\n', tmp_path)
    assert told[-1].endswith("; correct the line")
    assert faults('a = "it\u2019s" b\n', tmp_path)[0].endswith("; correct the line")
    assert faults("a = 1\na = \u201cb\u201d\n", tmp_path)[-1].endswith('; write straight quotes, ", for curved ones')


def test_a_header_within_a_text_is_none(tmp_path: Path) -> None:
    text = 'name = """\n[link]\n"""\n[run]\n[run]\n'
    assert faults(text, tmp_path) == [f"5: run: {AGAIN.format(4)}"]
    assert faults('a = """\n[link]\n"""\na = 1\n[ link ]\n', tmp_path) == [
        f"4: a: {AGAIN.format(1)}",
        "5: found [link], expected [[link]], of which there are several; write [[link]]",
    ]


@pytest.mark.parametrize("first", ["a = 1", "a = [1, 2]", 'a = "{}"', "a = []"])
def test_a_value_is_no_table(first: str, tmp_path: Path) -> None:
    said = (
        "found within a, which line 1 gives as a value, expected that to be a table; write one of them with another "
        "name, or leave one out"
    )
    assert faults(f"{first}\na.b = 2\n", tmp_path) == [f"2: a.b: {said}"]
    assert faults(f"{first}\n[a.b]\n", tmp_path) == [f"2: a.b: {said}"]


def test_an_empty_key_is_named(tmp_path: Path) -> None:
    assert faults('"" = 1\n"" = 2\n', tmp_path) == [f'2: "": {AGAIN.format(1)}']
    assert faults('[run]\n"" = 1\n"" = 2\n', tmp_path) == [f'3: run."": {AGAIN.format(2)}']
