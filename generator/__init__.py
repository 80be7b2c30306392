"""From a scene to a compiled model: ``generate(load_scene("scene.toml"))``."""

from .builder import Mechanism
from .compile.compiler import CompileError
from .package.replace import OutputError
from .pipeline import generate
from .program.errors import FoldError
from .rebuild import rebuild
from .scene import Scene, SceneError, chain, load_scene, loop, pinned
from .version import VERSION as __version__

__all__ = [
    "CompileError",
    "FoldError",
    "Mechanism",
    "OutputError",
    "Scene",
    "SceneError",
    "__version__",
    "chain",
    "generate",
    "load_scene",
    "loop",
    "pinned",
    "rebuild",
]
