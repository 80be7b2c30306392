"""Texts of shipped scenes with changes, and what is wrong with a text."""

from __future__ import annotations

from pathlib import Path

import pytest

from ccgen.generator import load_scene
from ccgen.generator.scene import SceneError

from .folders import SCENES


def scene(name: str, *changes: tuple[str, str]) -> str:
    """The text of a scene with parts of it replaced, each once."""
    text = (SCENES / f"{name}.toml").read_text()
    for old, new in changes:
        assert text.count(old) >= 1, old
        text = text.replace(old, new, 1)
    return text


def faults(text: str, folder: Path) -> list[tuple[int | None, str, str]]:
    """Line, key and message of everything that is wrong with a scene."""
    path = folder / "scene.toml"
    path.write_text(text)
    with pytest.raises(SceneError) as caught:
        load_scene(path)
    assert str(caught.value).startswith(f"{path}:")
    return [(fault.line, fault.key, fault.message) for fault in caught.value.faults]


def line_of(text: str, part: str) -> int:
    return text[: text.index(part)].count("\n") + 1


FLOOR = '[[ground]]\npoint = [0, -1]\nrestitution = 0.5\ncontacts = ["guide"]\n'
