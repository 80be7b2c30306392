"""Messages of docs/troubleshooting.md are messages of the code, and some of them are provoked here."""

from __future__ import annotations

import ast
import re
from functools import cache
from pathlib import Path

import pytest

from ccgen.generator import SceneError, load_scene

from ..support.folders import ROOT

TEXT = (ROOT / "docs" / "troubleshooting.md").read_text(encoding="utf-8")
ENTRIES = re.findall(r"^### (.+)\n\n```text\n(.+)\n```$", TEXT, re.MULTILINE)
HOLE = "…"
LEAST = 6
"""Letters of a piece that are worth looking for."""

ROD = '[[link]]\nname = "{0}"\nrod = {{ mass = 1 }}\npoints = {{ A = [0, 0], B = [{1}, 0] }}\n'
GROUND = "[ground_link]\npoints = { O = [0, 0], Q = [5, 0] }\n"
PIN = '[[joint]]\nbetween = ["{0}", "{1}"]\n'
HINGED = GROUND + ROD.format("a", 1) + PIN.format("ground.O", "a.A")
FOUR_BAR = (
    GROUND.replace("[5, 0]", "[0.6, 0]")
    + ROD.format("a", 0.2)
    + ROD.format("b", 0.5)
    + ROD.format("c", 0.5)
    + PIN.format("ground.O", "a.A")
    + PIN.format("a.B", "b.A")
    + PIN.format("b.B", "c.B")
    + PIN.format("ground.Q", "c.A")
)
WRONG = {
    "`[link]` in place of `[[link]]`": '[link]\nname = "a"\n[[link]]\nname = "b"\n',
    "The file is no TOML": "[loop]\nlinks: 6\n",
    "An unknown key": "[loop]\nlinks = 6\nmas = 1\n",
    "A unit of something else, or none known": HINGED.replace("mass = 1", 'mass = "20 cm"').replace(
        "rod = { mass", "inertia = 1\ncom = [0, 0]\n#"
    )
    + '[[link]]\nname = "b"\ninertia = 1\ncom = [0, 0]\nmass = "20 cm"\npoints = { A = [0, 0] }\n'
    + PIN.format("a.B", "b.A"),
    "A point or joint that is not there": HINGED.replace('"a.A"', '"arm.A"'),
    "A link without mass, inertia or mass centre": HINGED.replace("rod = { mass = 1 }", "mass = 1"),
    "A massless link that nothing holds": HINGED
    + '[[link]]\nname = "b"\nmass = 0\ninertia = 0\ncom = [0, 0]\npoints = { A = [0, 0], B = [1, 0] }\n'
    + PIN.format("a.B", "b.A"),
    "A ground that nothing touches": HINGED + "[[ground]]\nrestitution = 0\n",
    "A load that jumps": HINGED + '[[motor]]\njoint = "joint_0"\ntorque = "-sign(rate(joint_0))"\n',
    "A load that hangs on forces": HINGED + '[[motor]]\njoint = "joint_0"\ntorque = "-force(joint_0)"\n',
    "A prescribed motion of the state": HINGED + '[[drive]]\njoint = "joint_0"\nspeed = "1 - angle(joint_0)"\n',
    "A law that needs its own value": HINGED + '[[law]]\nname = "lift"\nvalue = "2*lift"\n',
    "The loop cannot be closed": FOUR_BAR.replace("[0.6, 0]", "[6, 0]"),
    "Two links are not connected": HINGED + ROD.format("b", 1),
    "Velocities that pull a loop apart": FOUR_BAR + "[start]\nangular_velocities = { a = 1, b = 7, c = -9 }\n",
    "The start is inside the ground": HINGED + '[[ground]]\nrestitution = 0\npoint = [0, 1]\ncontacts = ["a.B"]\n',
}
"""Scenes with the fault that an entry is about."""


@cache
def words_of_the_code() -> tuple[str, ...]:
    """All texts in the code of both packages; what is put into them stands as a hole."""
    found: list[str] = []
    for folder in ("generator", "runtime"):
        for path in sorted((ROOT / folder).rglob("*.py")):
            for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
                if isinstance(node, ast.JoinedStr):
                    parts = (part.value if isinstance(part, ast.Constant) else HOLE for part in node.values)
                    found.append("".join(map(str, parts)))
                elif isinstance(node, ast.Constant) and isinstance(node.value, str):
                    found.append(node.value)
    return tuple(found)


def pieces(message: str) -> list[str]:
    """The words between holes."""
    return [piece.strip() for piece in message.split(HOLE) if len(piece.strip()) >= LEAST]


def strange(message: str) -> list[str]:
    """Pieces of a message that stand in no text of the code: whole, or clause by clause where it puts them together."""
    clauses = [
        clause for piece in pieces(message) for clause in ([piece] if is_known(piece) else re.split("[;,:] ", piece))
    ]
    return [clause for clause in clauses if not is_known(clause)]


def is_known(words: str) -> bool:
    return any(words in text for text in words_of_the_code())


def test_there_are_entries() -> None:
    assert len(ENTRIES) > 25
    assert {title for title, _ in ENTRIES} >= {*WRONG}


@pytest.mark.parametrize("title", [title for title, _ in ENTRIES if title not in WRONG])
def test_messages_are_those_of_the_code(title: str) -> None:
    message = dict(ENTRIES)[title]
    assert pieces(message), "a message without words says nothing"
    assert strange(message) == []


def test_a_message_that_the_code_has_not_is_found() -> None:
    assert strange("found no C compiler in …; install another machine") != []


@pytest.mark.parametrize("title", WRONG)
def test_scenes_with_the_fault_print_the_message(title: str, tmp_path: Path) -> None:
    """The words of the entry, with anything in its holes."""
    message = dict(ENTRIES)[title]
    pattern = ".*".join(map(re.escape, message.split(HOLE)))
    file = tmp_path / "wrong.toml"
    file.write_text(WRONG[title], encoding="utf-8")
    with pytest.raises(SceneError) as caught:
        load_scene(file)
    assert re.search(pattern, str(caught.value), re.DOTALL), caught.value
