"""The compiled extension of the runtime, once for every precision; everything else is in pyproject.toml."""

from pathlib import Path

from Cython.Build import cythonize
from setuptools import Extension, setup

PRECISIONS = {"_core": "0", "_float": "1", "_wide": "2"}
"""``CCGEN_PRECISION`` of each extension (runtime/core/real.h)."""

cores = [
    Extension(
        f"ccgen.runtime.{name}",
        [f"runtime/{name}.pyx", *sorted(map(str, Path("runtime/core").glob("*.c")))],
        include_dirs=["runtime"],
        define_macros=[("CCGEN_PRECISION", precision)],
        depends=[
            "runtime/_core.pyx",
            "runtime/model.h",
            *map(str, Path("runtime/face").glob("*.pxi")),
            *map(str, Path("runtime/core").glob("*.h")),
        ],
        extra_compile_args=["-O2", "-g0", "-std=c11", "-fvisibility=hidden"],  # glibc has an advance() too
    )
    for name, precision in PRECISIONS.items()
]
setup(ext_modules=cythonize(cores, build_dir=".cache"), options={"build": {"build_base": ".cache/setuptools"}})
