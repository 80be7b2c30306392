"""The last stage: a package whose sources are written is compiled, and its record says how."""

from __future__ import annotations

from pathlib import Path

from ..package.parts import DERIVATIVES, write_record
from .cache import contract_version
from .compiler import Compiler, compile_model, extension_file, extension_module
from .kept_steps import Steps
from .memory import tell_of_memory
from .processor import processor


def compile_package(compiler: Compiler, folder: Path, name: str, hash_: str, key: str, steps: Steps) -> None:
    """Compile the model of the scene ``name``, whose sources lie in ``folder`` and whose binding is C already; then
    write the record of its parts and its ``key``.

    ``hash_`` is that of the model. Raises ``CompileError`` where the compiler fails."""
    extension = extension_module(hash_)
    more = tuple(file for file in (DERIVATIVES,) if (folder / file).exists())
    tell_of_memory(name, folder / "model.c")
    compile_model(compiler, folder, extension, name, hash_, steps, more)
    steps.keep()
    facts = {
        "compiler": compiler.version,
        "flags": list(compiler.flags()),
        "processor": processor(compiler.command, compiler.flags()),
        "contract": contract_version(),
        "extension": extension_file(extension),
    }
    write_record(folder, key, facts)
