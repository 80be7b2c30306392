"""Builds models for tests, each once."""

from __future__ import annotations

from pathlib import Path
from typing import Any


class Workshop:
    """Builds models from scenes or scene texts, each once; ``scene`` reads a text without building it.

    No dataclass: Hypothesis prints the fields of those, and all models are too long to be read."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.built: dict[str, Any] = {}

    def __repr__(self) -> str:
        return f"<Workshop: {len(self.built)} models>"

    def scene(self, text: str) -> Any:
        """The scene that a TOML text describes."""
        from ccgen.generator import load_scene

        file = self.folder / f"scene_{len(list(self.folder.glob('scene_*')))}.toml"
        file.write_text(text, encoding="utf-8")
        return load_scene(file)

    def model(self, scene: Any, precision: str = "double", *, derivatives: bool = False, fold: bool = False) -> Any:
        """The compiled model of a scene or of a scene's text, in that precision, with derivatives, folded if asked."""
        from ccgen.generator import generate
        from ccgen.runtime import load_model

        if isinstance(scene, str):
            scene = self.scene(scene)
        key = scene.canonical() + precision + "derivatives" * derivatives + "fold" * fold
        if key not in self.built:
            out = self.folder / f"build_{len(self.built)}"
            self.built[key] = load_model(
                generate(scene, out=out, precision=precision, derivatives=derivatives, fold=fold)
            )
        return self.built[key]
