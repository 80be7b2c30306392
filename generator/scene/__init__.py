"""Scenes: a TOML file or a shorthand, read, checked, and made consistent. Nothing here needs SymPy."""

from .errors import Fault, SceneError
from .read import chain, load_scene, loop, pinned, read_tables
from .scene import RunSettings, Scene, Sketch, Start

__all__ = [
    "Fault",
    "RunSettings",
    "Scene",
    "SceneError",
    "Sketch",
    "Start",
    "chain",
    "load_scene",
    "loop",
    "pinned",
    "read_tables",
]
