"""The map of the generator: scene → mechanism → equations → program → sources → compiled package.

stage     module              input → output
tree      mechanism.topology  Mechanism → Topology (virtual open chain and cut joints)
derive    derive.derivation   Mechanism, Topology, effects → Equations (named assignments)
lower     program.program     Equations → Program (one function per kernel)
write     emit                Equations, Program → equations.txt, model.c, _binding.pyx, package data
compile   emit.compiler       sources → extension module
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

from .emit.cache import HEADERS, fetch_or_build, is_current, key_of, runtime_folder
from .emit.compiler import Compiler, compile_model, cythonize, extension_module, find_compiler
from .scene.scene import Scene
from .version import VERSION

if TYPE_CHECKING:
    from .derive.equations import Equations
    from .emit.render import Banner
    from .mechanism.topology import Topology

Progress = Callable[[str], None]


def generate(scene: Scene, out: str | PathLike[str] = "build", progress: Progress | None = None) -> Path:
    """Derive, write and compile the model of ``scene``, or find it in the cache; returns ``out/<package>``.

    ``progress`` is told each stage's name as it begins. Raises ``CompileError`` (no working compiler) and
    ``OutputError`` (a folder that cannot be written); nothing is left half written.
    """
    if not isinstance(scene, Scene):
        raise TypeError(f"scene: found {type(scene).__name__}, expected a Scene; read a file with load_scene(path)")
    tell = progress or (lambda stage: None)
    compiler = find_compiler()
    key = key_of(scene.canonical(), compiler.version, *compiler.command, *compiler.flags())
    target = Path(out) / scene.package
    if not is_current(target, key):
        tell("look in the cache")
        fetch_or_build(key, target, lambda folder: _build(scene, compiler, folder, tell))
    return target


def derive_scene(scene: Scene) -> tuple[Topology, Equations]:
    """The first two stages: the virtual open chain, and all equations."""
    from .derive.derivation import derive
    from .mechanism.topology import span

    topology = span(scene.mechanism)
    return topology, derive(scene.mechanism, topology, scene.effects)


def listing(scene: Scene) -> str:
    """The text of ``equations.txt``; needs no compiler."""
    from .emit.listing import name_index, write_listing

    topology, equations = derive_scene(scene)
    return write_listing(scene.name, equations, name_index(scene, topology))


def _build(scene: Scene, compiler: Compiler, folder: Path, tell: Progress) -> None:
    """Write and compile everything into an empty folder."""
    from .emit.render import Banner, render_binding, render_package

    hash_ = hashlib.sha256(scene.canonical().encode()).hexdigest()[:16]
    banner = Banner(scene.name, scene.package, VERSION, hash_)
    (folder / "_binding.pyx").write_text(render_binding(banner))
    extension = extension_module(hash_)
    (folder / "__init__.py").write_text(render_package(banner, extension))
    for header in HEADERS:
        (folder / header).write_bytes((runtime_folder() / header).read_bytes())
    with ThreadPoolExecutor(1) as beside:
        binding = beside.submit(cythonize, folder, extension)
        _write_model(scene, banner, folder, tell)
        tell("compile")
        binding.result()
    compile_model(compiler, folder, extension)
    record = {"compiler": compiler.version, "flags": list(compiler.flags())}
    (folder / "build.json").write_text(json.dumps(record, indent=1) + "\n")


def _write_model(scene: Scene, banner: Banner, folder: Path, tell: Progress) -> None:
    """The stages from the tree to the sources."""
    tell("derive")
    topology, equations = derive_scene(scene)
    tell("write")
    from .emit.data import model_data, point_names
    from .emit.listing import name_index, write_listing
    from .emit.render import Sizes, render_c
    from .program.program import lower

    program, mechanism = lower(equations), scene.mechanism
    index = name_index(scene, topology)
    sizes = Sizes(
        nq=len(equations.state.q),
        nu=len(equations.state.u),
        rows=2 * len(topology.cuts),
        links=len(mechanism.links),
        joints=len(mechanism.joints),
        points=len(point_names(mechanism)),
        contacts=len(equations.contacts),
        parameters=len(program.parameters),
        constants=len(program.parameters) + len(program.constants),
        inputs=sum(len(effect.inputs()) for effect in scene.effects),
    )
    data = model_data(scene, topology, equations, banner.hash)
    (folder / "equations.txt").write_text(write_listing(scene.name, equations, index))
    (folder / "model.c").write_text(render_c(banner, program, sizes, topology.root, index))
    (folder / "model.json").write_text(json.dumps(data, indent=1) + "\n")
