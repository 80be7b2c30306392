"""Hashes of what is written of every shipped scene, to be compared between Pythons.

A line for each file: the scene's text as it is kept, its listing, its C and its ``model.json``. Nothing is compiled.
"""

from __future__ import annotations

import hashlib
import sys
import tempfile
from pathlib import Path

from ccgen.generator import load_scene
from ccgen.generator.pipeline import Variant, _hash, _write_model
from ccgen.generator.write_c.render import Banner

ROOT = Path(__file__).resolve().parents[2]


def main(names: list[str]) -> None:
    """Those whose names are given, else all."""
    for file in sorted((*ROOT.glob("scenes/*.toml"), *ROOT.glob("scenes/gallery/*.toml"))):
        if names and file.stem not in names:
            continue
        scene = load_scene(file)
        with tempfile.TemporaryDirectory() as folder:
            banner = Banner(scene.name, scene.package, "0", _hash(scene, Variant()))
            _write_model(scene, banner, Path(folder), lambda stage: None)
            texts = {made.name: made.read_bytes() for made in sorted(Path(folder).iterdir())}
        for name, text in {"scene": scene.canonical().encode(), **texts}.items():
            print(f"{hashlib.sha256(text).hexdigest()[:32]}  {file.stem}/{name}", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
