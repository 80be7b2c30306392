"""The one compiled extension of the runtime; everything else is in pyproject.toml."""

from pathlib import Path

from Cython.Build import cythonize
from setuptools import Extension, setup

core = Extension(
    "ccgen.runtime._core",
    ["runtime/_core.pyx", *sorted(map(str, Path("runtime/core").glob("*.c")))],
    include_dirs=["runtime"],
    depends=["runtime/model.h", *map(str, Path("runtime/core").glob("*.h"))],
    extra_compile_args=["-O2", "-g0", "-std=c11", "-fvisibility=hidden"],  # glibc has an advance() too
)
setup(ext_modules=cythonize([core], build_dir=".cache"), options={"build": {"build_base": ".cache/setuptools"}})
