"""The core over other numbers than doubles, compiled when a model first asks for it.

The runtime, which does not import this package, starts ``python -m ccgen.generator.compile.core float``.
"""

from __future__ import annotations

import hashlib
import os
import platform
import shlex
import shutil
import sys
import sysconfig
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor, wait
from importlib.metadata import version
from pathlib import Path

from ..package.replace import OutputError, staging
from . import core_recipe
from .cache import cache_folder, runtime_folder, writing
from .compiler import CompileError, Compiler, find_compiler, run_command
from .processor import native

LANGUAGE = ("-fPIC", "-DNDEBUG", "-fwrapv")
"""Flags that Python adds to those of the core where it compiles extension modules."""

SAID_EVERY = 5.0
"""Seconds between two lines that say how far it is."""

SEAL = "sha256"
"""File beside a compiled core that tells whether it is whole."""


def core_file(precision: str, tell: Callable[[str], None]) -> Path:
    """The file of the core for numbers "float" or "wide", compiled into the user's cache unless it is there.

    Of two processes that ask at once one compiles. Where there is no compiler, and ``$CC`` names none, one that any
    compiler has made of the same, with the same flags, is as good. ``tell`` is told that it takes time, and how far it
    is. Raises :class:`CompileError` where there is no core and no compiler, or it fails, :class:`OutputError` where the
    cache cannot be written."""
    from filelock import FileLock

    runtime = runtime_folder()
    asked = (precision, os.environ.get("CFLAGS", ""), os.environ.get("LDFLAGS", ""))
    machine = (platform.machine(), native(), sys.version)
    key = _key(core_recipe.digest(runtime), version("cython"), *LANGUAGE, *machine, *asked)
    name = f"{core_recipe.MODULES[precision]}{sysconfig.get_config_var('EXT_SUFFIX')}"
    with writing(cache_folder(), private=True) as store, writing(store / "cores") as cores:
        try:
            compiler = find_compiler()
        except CompileError:
            kept = [] if os.environ.get("CC") else [one / name for one in sorted(cores.glob(f"{key}-*"))]
            found = next(filter(_whole, kept), None)
            if found is None:
                raise
            return found
        key = f"{key}-{_key(compiler.version, *compiler.command)[:16]}"
        found = cores / key / name
        if _whole(found):
            return found
        with FileLock(store / f"{key}.lock"):
            if not _whole(found):
                with staging(cores, own=True) as fresh:
                    _compile(compiler, precision, runtime, fresh, fresh / name, tell)
                    (fresh / SEAL).write_text(_seal(fresh / name))
                    shutil.rmtree(found.parent, ignore_errors=True)
                    fresh.rename(found.parent)
    return found


def _key(*parts: str) -> str:
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()[:32]


def _whole(file: Path) -> bool:
    try:
        return (file.parent / SEAL).read_text() == _seal(file)
    except OSError:
        return False


def _seal(file: Path) -> str:
    return hashlib.sha256(file.read_bytes()).hexdigest()


def _command(compiler: Compiler, precision: str) -> tuple[str, ...]:
    """What compiles any of the files: for every processor of the machine's kind, as the core of doubles is compiled."""
    any_processor = ("-mcpu=baseline",) if "ziglang" in compiler.command else ()
    asked = shlex.split(os.environ.get("CFLAGS", ""))
    return (
        *(*compiler.command, *any_processor, *LANGUAGE, *asked),
        f"-DCCGEN_PRECISION={core_recipe.PRECISIONS[precision]}",
    )


def _compile(
    compiler: Compiler, precision: str, runtime: Path, folder: Path, target: Path, tell: Callable[[str], None]
) -> None:
    """Compile and link it in an empty folder, in which nothing else stays."""
    face, work = f"{core_recipe.MODULES[precision]}.pyx", folder / "work"
    work.mkdir()
    include = (f"-I{runtime}", f"-I{runtime / 'core'}", f"-I{sysconfig.get_path('include')}")
    first = (*_command(compiler, precision), *include)

    def compiled(source: Path, result: Path) -> None:
        command = (*first, *core_recipe.flags(source), "-c", str(source), "-o", str(result))
        run_command(command, work, "the C compiler")

    def written() -> None:
        made, name = work / "face.c", f"ccgen.runtime.{core_recipe.MODULES[precision]}"
        command = (sys.executable, "-m", "cython", "-3", "--module-name", name, str(runtime / face), "-o", str(made))
        run_command(command, work, "Cython")
        compiled(made, work / "face.o")

    sources = core_recipe.c_files(runtime)
    objects = [work / f"{number}.o" for number in range(len(sources))]
    began = time.monotonic()
    tell(f"compiling the core for {precision} numbers, once: about half a minute")
    with ThreadPoolExecutor() as pool:
        running = [pool.submit(written), *(pool.submit(compiled, *one) for one in zip(sources, objects, strict=True))]
        for done in _done(running):
            tell(f"{done} of {len(running)} files after {time.monotonic() - began:.0f} s")
    shared = ("-bundle", "-undefined", "dynamic_lookup") if sys.platform == "darwin" else ("-shared",)
    asked = shlex.split(os.environ.get("LDFLAGS", ""))
    names = map(str, (work / "face.o", *objects))
    run_command((*first, *shared, *names, *asked, "-lm", "-o", str(target)), work, "the linker")
    shutil.rmtree(work)


def _done(running: Sequence[Future[None]]) -> Iterator[int]:
    """How many are done, every few seconds until all are; raises what one of them has raised."""
    left = set(running)
    while left:
        for job in wait(left, SAID_EVERY).done:
            left.discard(job)
            job.result()
        if left:
            yield len(running) - len(left)


def main(precision: str) -> int:
    """Print the file of the core; how far it is, and why there is none, on the other channel."""
    try:
        print(core_file(precision, lambda line: print(line, file=sys.stderr, flush=True)))
    except (CompileError, OutputError) as error:
        print(error, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
