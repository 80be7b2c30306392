"""Scenes: a TOML file or a shorthand, read, checked, and made consistent. Nothing here needs SymPy."""

from .errors import Fault, SceneError
from .kinds import TABLES, TableKind
from .load import chain, load_scene, loop, pinned
from .read import read_tables
from .scene import RunSettings, Scene, Sketch, Start
from .toml_text import plain

__all__ = [
    "TABLES",
    "Fault",
    "RunSettings",
    "Scene",
    "SceneError",
    "Sketch",
    "Start",
    "TableKind",
    "chain",
    "load_scene",
    "loop",
    "pinned",
    "plain",
    "read_tables",
]
