"""Fixtures that every test may use: a cache of its own for the session, and models built once."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest


@pytest.fixture(scope="session", autouse=True)
def own_cache(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """Generated packages go into a folder of this session, never into the user's cache; tests side by side share it."""
    base = tmp_path_factory.getbasetemp()
    folder = (base.parent if "PYTEST_XDIST_WORKER" in os.environ else base) / "cache"
    folder.mkdir(exist_ok=True)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("CCGEN_CACHE_DIR", os.environ.get("CCGEN_TEST_CACHE_DIR", str(folder)))
        yield folder


@dataclass
class Workshop:
    """Builds models from scenes or scene texts, each once; ``scene`` reads a text without building it."""

    folder: Path
    built: dict[str, Any] = field(default_factory=dict)

    def __repr__(self) -> str:
        return f"<Workshop: {len(self.built)} models>"

    def scene(self, text: str) -> Any:
        """The scene that a TOML text describes."""
        from ccgen.generator import load_scene

        file = self.folder / f"scene_{len(list(self.folder.glob('scene_*')))}.toml"
        file.write_text(text, encoding="utf-8")
        return load_scene(file)

    def model(self, scene: Any, precision: str = "double") -> Any:
        """The compiled model of a scene or of a scene's text, in numbers of that precision."""
        from ccgen.generator import generate
        from ccgen.runtime import load_model

        if isinstance(scene, str):
            scene = self.scene(scene)
        key = scene.canonical() + precision
        if key not in self.built:
            self.built[key] = load_model(
                generate(scene, out=self.folder / f"build_{len(self.built)}", precision=precision)
            )
        return self.built[key]


@pytest.fixture(scope="session")
def workshop(tmp_path_factory: pytest.TempPathFactory, own_cache: Path) -> Workshop:
    return Workshop(tmp_path_factory.mktemp("workshop"))
