"""The compiled core of the runtime; everything else is in pyproject.toml.

The core over doubles is compiled here. Those over floats and over long doubles are compiled when a model first asks for
one (generator/compile/core.py), or here as well with ``CCGEN_CORES=all``, as for the wheels of a release.
"""

import hashlib
import importlib.util
import os
import re
import shutil
import sys
import sysconfig
import time
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path

from Cython import __version__ as CYTHON  # noqa: N812
from Cython.Compiler.Main import compile as cythonize
from setuptools import Distribution, Extension, setup
from setuptools.command.build_ext import build_ext

INSTALL = """no C compiler found: looked for $CC, cc, gcc, clang and the ziglang package; install one and try again:
  Debian, Ubuntu:  apt install gcc libc6-dev
  Fedora:          dnf install gcc
  macOS:           xcode-select --install
  elsewhere:       pip install '.[zig]', which brings the compiler of the ziglang package"""

LAST_FLAGS = os.environ.get("CCGEN_LAST_FLAGS", "").split()
"""Flags behind all others, which they can take back: ``make coverage`` compiles without optimisation."""

RUNTIME = Path("runtime")
BUILT = Path(os.environ.get("CCGEN_BUILD_BASE", ".cache/setuptools"))

LINKED = Path(".editable")
"""The package as links into the checkout, which an editable installation puts on Python's path."""

SAID_EVERY = 3.0
"""Seconds between two lines that say how far it is."""

_found = importlib.util.spec_from_file_location("core_recipe", Path("generator/compile/core_recipe.py").resolve())
recipe = importlib.util.module_from_spec(_found)
_found.loader.exec_module(recipe)


def wanted() -> list[str]:
    """Types of numbers whose cores are compiled here: by ``$CCGEN_CORES``, "one" (doubles) unless it says "all"."""
    asked = os.environ.get("CCGEN_CORES") or "one"
    if asked not in ("one", "all"):
        raise SystemExit(f"the environment variable CCGEN_CORES is {asked!r}, expected one or all; correct it")
    return ["double"] if asked == "one" else list(recipe.MODULES)


class BuildExt(build_ext):
    """Extensions compiled by ``$CC``, by the compiler that Python was, by ``cc``, ``gcc`` or ``clang``, or by zig."""

    def build_extensions(self) -> None:
        """Compile all; without a compiler say what to install."""
        usual = getattr(self.compiler, "compiler_so", None)
        if usual and not shutil.which(usual[0]):
            found = next(filter(shutil.which, ("cc", "gcc", "clang")), None)
            if os.environ.get("CC") or not (found or importlib.util.find_spec("ziglang")):
                raise SystemExit(INSTALL)
            zig = [sys.executable, "-m", "ziglang", "cc", "-mcpu=baseline"]
            command = [found] if found else zig
            shared = ["-bundle", "-undefined", "dynamic_lookup"] if sys.platform == "darwin" else ["-shared"]
            self.compiler.set_executables(
                compiler=command, compiler_so=[*command, "-fPIC", "-DNDEBUG"], linker_so=[*command, *shared]
            )
        super().build_extensions()

    def copy_extensions_to_source(self) -> None:
        """Put them in place; of cores that were not compiled now, those of an earlier build go."""
        for name in set(recipe.MODULES.values()) - {ext.name.rpartition(".")[2] for ext in self.extensions}:
            Path("runtime", f"{name}{sysconfig.get_config_var('EXT_SUFFIX')}").unlink(missing_ok=True)
        super().copy_extensions_to_source()

    def build_extension(self, ext: Extension) -> None:
        """Compile one, its files side by side, Cython among them; of an earlier build what has changed since."""
        # Its own, since every precision has the same sources, and the same for every way to install.
        folder = BUILT / f"core.{sysconfig.get_platform()}-{sys.implementation.cache_tag}" / ext.name
        folder.mkdir(parents=True, exist_ok=True)
        face, *sources = map(Path, ext.sources)
        jobs = [lambda source=source: self.compiled(ext, source, folder) for source in sources]
        jobs.insert(0, lambda: self.compiled(ext, self.written(face, folder), folder))
        began = said = time.monotonic()
        with ThreadPoolExecutor(self.parallel if isinstance(self.parallel, int) else processors()) as pool:
            running = [pool.submit(job) for job in jobs]
            for count, job in enumerate(as_completed(running)):
                job.result()
                if time.monotonic() - said > SAID_EVERY:
                    said = time.monotonic()
                    print(f"the core: {count + 1} of {len(jobs)} files after {said - began:.0f} s", flush=True)
        target = Path(self.get_ext_fullpath(ext.name))
        target.parent.mkdir(parents=True, exist_ok=True)
        objects = [str(job.result()) for job in running]
        self.compiler.link_shared_object(objects, str(target), build_temp=str(folder))
        print(f"the core: compiled into {target.name} in {time.monotonic() - began:.0f} s", flush=True)

    def written(self, face: Path, folder: Path) -> Path:
        """The C that Cython makes of the face, unless it has of the same."""
        name, result = f"ccgen.runtime.{face.stem}", folder / f"{face.stem}.c"
        read = [face, *(file for file in recipe.read_files(RUNTIME) if file.suffix != ".h")]
        key = digest_of(CYTHON, name, *map(str, read), *(file.read_bytes() for file in read))
        if not holds(result, key):
            if cythonize(str(face), full_module_name=name, output_file=str(result)).num_errors:
                raise SystemExit(f"{face}: Cython found errors, above")
            keep(result, key)
        return result

    def compiled(self, ext: Extension, source: Path, folder: Path) -> Path:
        """The object file of one source, unless it is there of the same: of files, flags and compiler.

        The files are those that the compiler said it had read, its own and Python's left out."""
        own = [*recipe.flags(source), *LAST_FLAGS]
        place = source.relative_to(folder) if source.is_relative_to(folder) else source
        result = (folder / place).with_suffix(".o")
        depends = result.with_suffix(".d")
        result.parent.mkdir(parents=True, exist_ok=True)
        said = [*map(str, self.compiler.compiler_so), *own, *ext.include_dirs, *self.compiler.include_dirs]

        def key() -> str:
            return digest_of(*said, repr(ext.define_macros), *(file.read_bytes() for file in named(depends)))

        if not (depends.is_file() and all(file.is_file() for file in named(depends)) and holds(result, key())):
            macros = [f"-D{name}={value}" for name, value in ext.define_macros]
            folders = [f"-I{one}" for one in (*ext.include_dirs, *self.compiler.include_dirs)]
            make = ["-MMD", "-MF", str(depends), "-c", str(source), "-o", str(result)]
            self.compiler.spawn([*self.compiler.compiler_so, *macros, *folders, *own, *make])
            keep(result, key())
        return result


class LinkedWhereEditable(Distribution):
    """Installed editable, the packages lie in one folder, as setuptools wants it for a path that is written down.

    Otherwise it writes a program that finds them when Python starts, which type checkers and editors do not run.
    """

    def run_commands(self) -> None:
        """Run what was asked for, on the folder of links where that is an editable wheel and links can be made."""
        if "editable_wheel" in self.commands:
            try:
                link(self.package_dir)
            except OSError as error:
                shutil.rmtree(LINKED, ignore_errors=True)
                print(f"ccgen: type checkers and editors will not find it: found no way to make links here ({error})")
            else:
                self.package_dir = {"": str(LINKED)}
        super().run_commands()


def link(folders: dict[str, str]) -> None:
    """Make ``LINKED``, anew: in it the package ``ccgen`` of links to its own files and to the folders of its parts.

    They are relative, and whole folders wherever that is possible: a new file is there at once, and a checkout that is
    moved needs the installation alone again.
    """
    shutil.rmtree(LINKED, ignore_errors=True)
    package = LINKED / "ccgen"
    package.mkdir(parents=True)
    own = [file for file in Path(folders["ccgen"]).iterdir() if file.name != "__pycache__"]
    parts = [Path(folder) for name, folder in folders.items() if name.count(".") == 1]
    for place in (*own, *parts):
        (package / place.name).symlink_to(os.path.relpath(place, package), target_is_directory=place.is_dir())


def processors() -> int:
    """How many of them this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def named(depends: Path) -> list[Path]:
    """The files in a list for make, as the compiler writes it."""
    text = depends.read_text().partition(": ")[2].replace("\\\n", " ")
    return [Path(name.replace("\\ ", " ")) for name in re.split(r"(?<!\\)\s+", text.strip())]


def digest_of(*parts: str | bytes) -> str:
    """One number for all of them."""
    found = hashlib.sha256()
    for part in parts:
        content = part.encode() if isinstance(part, str) else part
        found.update(f"{len(content)} ".encode() + content)
    return found.hexdigest()


def holds(result: Path, key: str) -> bool:
    """Whether a file is there that was made of what has this ``key``, and whole."""
    try:
        return result.with_suffix(f"{result.suffix}.key").read_text() == f"{key} {digest_of(result.read_bytes())}"
    except OSError:
        return False


def keep(result: Path, key: str) -> None:
    """Note what a file was made of."""
    result.with_suffix(f"{result.suffix}.key").write_text(f"{key} {digest_of(result.read_bytes())}")


cores = [
    Extension(
        f"ccgen.runtime.{recipe.MODULES[precision]}",
        [f"runtime/{recipe.MODULES[precision]}.pyx", *map(str, recipe.c_files(RUNTIME))],
        include_dirs=["runtime", "runtime/core"],
        define_macros=[("CCGEN_PRECISION", recipe.PRECISIONS[precision])],
        depends=list(map(str, recipe.read_files(RUNTIME))),
    )
    for precision in wanted()
]
setup(
    distclass=LinkedWhereEditable,
    ext_modules=cores,
    cmdclass={"build_ext": BuildExt},
    options={"build": {"build_base": str(BUILT)}},
)
