"""Finds a C compiler and turns sources into the model's extension module."""

from __future__ import annotations

import importlib.util
import os
import platform
import shlex
import shutil
import subprocess
import sys
import sysconfig
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

from .kept_steps import Steps
from .processor import native

OPTIMISE = ("-O2", "-march=native", "-fno-math-errno")
LANGUAGE = ("-std=c11", "-fPIC")
LANES = ("-ffp-contract=fast",)
"""Flags besides, for what works in lanes: products and sums in one operation; -std=c11 alone forbids it."""

WIDTHS = ("2", "4", "8")
"""Lanes that ``$CCGEN_LANES`` may ask for."""


BINDING = "ccgen_binding"
"""What Cython takes the name of the binding's module to be; Python finds each by that of its own extension module."""

BOUND = "-DCCGEN_BOUND"
"""Flag by which the C of a model is called the same in every extension module (``model.h``)."""

NAMES = """\
const char ccgen_bound_name[] = "{name}", ccgen_bound_hash[] = "{hash}";
extern const struct ccgen_model ccgen_model_bound;
const struct ccgen_model *const ccgen_bound_model = &ccgen_model_bound;

void *PyInit_{binding}(void);
__attribute__((visibility("default"))) void *PyInit_{module}(void);
void *PyInit_{module}(void) {{ return PyInit_{binding}(); }}
"""
"""C of what a model's own names are: the rest of an extension module is compiled once for all that are alike but for
their names and hashes."""


class CompileError(Exception):
    """No compiler, or one that failed; the message says what was tried and what to do."""


@dataclass(frozen=True)
class Compiler:
    """A command that compiles C, and what identifies it for the cache."""

    command: tuple[str, ...]
    version: str

    def flags(self) -> tuple[str, ...]:
        """Of all that is generated; ``$CCGEN_LANES`` sets the width of vectors, else the machine does."""
        asked = os.environ.get("CCGEN_LANES")
        if asked and asked not in WIDTHS:
            raise CompileError(
                f"the environment variable CCGEN_LANES is {asked!r}, expected one of {', '.join(WIDTHS)}; correct it"
            )
        return (*LANGUAGE, *OPTIMISE, *((f"-DCCGEN_LANES={asked}",) if asked else ()))


def find_compiler() -> Compiler:
    """``$CC``, else ``cc``, ``gcc`` or ``clang`` on the path, else the compiler of the ``ziglang`` wheel.

    One on the path that cannot tell its version is passed over: it stands for a compiler that is to be installed yet.
    Raises :class:`CompileError` when there is none.
    """
    asked = os.environ.get("CC")
    if asked:
        command = tuple(shlex.split(asked))
        if not shutil.which(command[0]):
            raise CompileError(f"the environment variable CC names {asked!r}, which is not a program on this machine")
        return Compiler(command, _version(command))
    broken = ""
    for path in filter(None, map(shutil.which, ("cc", "gcc", "clang"))):
        if _answers(path):
            return Compiler((path,), _version((path,)))
        broken += f" ({path} --version fails)"
    if importlib.util.find_spec("ziglang"):
        command = (sys.executable, "-m", "ziglang", "cc")
        return Compiler(command, _version(command))
    raise CompileError(
        f"no C compiler found: looked for $CC, cc, gcc, clang and the ziglang package{broken}; "
        "install gcc or clang, or run: python -m pip install 'ccgen[zig]'"
    )


def _answers(path: str) -> bool:
    """Whether a compiler on the path tells its version."""
    try:
        return subprocess.run([path, "--version"], capture_output=True, check=False).returncode == 0
    except OSError:
        return False


def _version(command: tuple[str, ...]) -> str:
    """First line of ``--version``, with the machine it compiles for (native code must not travel)."""
    done = subprocess.run([*command, "--version"], capture_output=True, text=True, check=False)
    line = done.stdout.splitlines()[0] if done.stdout else " ".join(command)
    return f"{line}; {platform.machine()} {native()}"


def extension_module(hash_: str) -> str:
    """Name of the package's extension module; its own for each scene, since a process keeps what it loaded by name."""
    return f"_model_{hash_}"


def extension_file(module: str) -> str:
    """Name of the file of that extension module, by which a Python tells whether it can load it."""
    return f"{module}{sysconfig.get_config_var('EXT_SUFFIX')}"


def cythonize(folder: Path, steps: Steps) -> None:
    """``_binding.pyx`` to C, in a process of its own so that it can run beside the derivation.

    The binding is the same for every scene, so that Cython, which takes longer than all else of a small model, and its
    compilation run once; the names that are a model's own come in when it is linked.
    """
    arguments = ("-3", "--module-name", BINDING, "_binding.pyx")
    made_from = (
        version("cython").encode(),
        sys.version.encode(),
        " ".join(arguments).encode(),
        _text(folder, "_binding.pyx"),
    )
    command = (sys.executable, "-m", "cython", *arguments)
    steps.fetch_or_make(folder / "_binding.c", made_from, lambda: run_command(command, folder, "Cython"))


def compile_model(
    compiler: Compiler, folder: Path, module: str, name: str, hash_: str, steps: Steps, more: Iterable[str] = ()
) -> None:
    """Compile the binding, the model and its lanes side by side and link them into the extension ``module``.

    ``name`` is the scene's and ``hash_`` the model's; ``more`` are sources besides that work in lanes.
    """
    names = NAMES.format(name=name, hash=hash_, binding=BINDING, module=module)
    (folder / "_names.c").write_text(names)
    jobs = {
        "model.c": (*compiler.flags(), BOUND, "-I."),
        "lanes.c": (*compiler.flags(), *LANES, BOUND, "-I."),
        **{source: (*compiler.flags(), *LANES, BOUND, "-I.") for source in more},
        "_binding.c": (*LANGUAGE, "-O1", f"-I{sysconfig.get_path('include')}"),
    }
    objects = tuple(source.replace(".c", ".o") for source in jobs)
    with ThreadPoolExecutor() as pool:
        done = [pool.submit(_compile, compiler, flags, source, folder, steps) for source, flags in jobs.items()]
        for job in done:
            job.result()
    # names that all models have mean those of the same file, whatever other models are loaded
    shared = ("-bundle", "-undefined", "dynamic_lookup") if sys.platform == "darwin" else ("-shared", "-Wl,-Bsymbolic")
    linked = ("-std=c11", "-fPIC", *shared, "_names.c", *objects)
    run_command((*compiler.command, *linked, "-lm", "-o", extension_file(module)), folder, "the linker")
    for rest in ("_names.c", *objects):
        (folder / rest).unlink()


def _compile(compiler: Compiler, flags: tuple[str, ...], source: str, folder: Path, steps: Steps) -> None:
    """One source to its object file, unless the same has been compiled before with the same flags.

    A model's source is known by what the preprocessor makes of it: without comments, which name scene and links, and
    with the headers. The binding, which is the same for all, is known by its bytes: Python's headers are long.
    """
    said = (compiler.version, sys.version, *compiler.command, *flags, source)
    seen = _preprocessed(compiler, flags, source, folder) if BOUND in flags else _text(folder, source)
    command = (*compiler.command, *flags, "-c", source)
    result = folder / source.replace(".c", ".o")
    made_from = (*(text.encode() for text in said), seen)
    steps.fetch_or_make(result, made_from, lambda: run_command(command, folder, "the C compiler"))


def _preprocessed(compiler: Compiler, flags: tuple[str, ...], source: str, folder: Path) -> bytes:
    """What the compiler reads of a source: headers and macros put in, comments left out."""
    return run_command((*compiler.command, *flags, "-E", "-P", source), folder, "the C compiler").encode()


def _text(folder: Path, name: str) -> bytes:
    return (folder / name).read_bytes()


def run_command(command: tuple[str, ...], folder: Path, what: str) -> str:
    """What a command prints."""
    try:
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    except OSError as error:
        raise CompileError(f"{what} could not be started ({' '.join(command)}): {error.strerror}") from error
    if done.returncode:
        output = "\n".join((done.stdout + done.stderr).strip().splitlines()[-20:])
        raise CompileError(f"{what} failed ({' '.join(command)}):\n{output}")
    return done.stdout
