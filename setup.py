"""The compiled extension of the runtime, once for every precision; everything else is in pyproject.toml."""

import importlib.util
import os
import shutil
import sys
from pathlib import Path

from Cython.Build import cythonize
from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext

INSTALL = """no C compiler found: looked for $CC, cc, gcc, clang and the ziglang package; install one and try again:
  Debian, Ubuntu:  apt install gcc libc6-dev
  Fedora:          dnf install gcc
  macOS:           xcode-select --install
  elsewhere:       pip install '.[zig]', which brings the compiler of the ziglang package"""

PRECISIONS = {"_core": "0", "_float": "1", "_wide": "2"}
"""``CCGEN_PRECISION`` of each extension (runtime/core/base/real.h)."""

LAST_FLAGS = os.environ.get("CCGEN_LAST_FLAGS", "").split()
"""Flags behind all others, which they can take back: ``make coverage`` compiles without optimisation."""


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

    def build_extension(self, ext: Extension) -> None:
        """Compile one, its objects in a folder of their own: every precision has the same sources."""
        shared, self.build_temp = self.build_temp, str(Path(self.build_temp) / ext.name)
        super().build_extension(ext)
        self.build_temp = shared


cores = [
    Extension(
        f"ccgen.runtime.{name}",
        [f"runtime/{name}.pyx", *sorted(map(str, Path("runtime/core").rglob("*.c")))],
        include_dirs=["runtime", "runtime/core"],
        define_macros=[("CCGEN_PRECISION", precision)],
        depends=[
            "runtime/_core.pyx",
            "runtime/model.h",
            "runtime/ccgen.h",
            *map(str, Path("runtime/face").glob("*.pxi")),
            *map(str, Path("runtime/core").rglob("*.h")),
        ],
        extra_compile_args=[
            "-O3",
            "-fno-math-errno",
            "-g0",
            "-std=c11",
            "-fvisibility=hidden",
            *LAST_FLAGS,
        ],  # glibc has an advance() too
    )
    for name, precision in PRECISIONS.items()
]
setup(
    ext_modules=cythonize(cores, build_dir=".cache"),
    cmdclass={"build_ext": BuildExt},
    options={"build": {"build_base": os.environ.get("CCGEN_BUILD_BASE", ".cache/setuptools")}},
)
