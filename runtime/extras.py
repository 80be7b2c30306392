"""Packages that only some results need, imported when they are asked for."""

from __future__ import annotations

from importlib import import_module
from typing import Any

EXTRAS = {
    "matplotlib": "plot",
    "PIL": "plot",
    "xarray": "data",
    "pandas": "data",
    "pyarrow": "sweep",
    "scipy": "sweep",
    "zarr": "zarr",
    "distributed": "cluster",
    "control": "control",
    "jax": "jax",
    "torch": "torch",
    "casadi": "casadi",
}
INSTALL_NAMES = {"PIL": "pillow"}


def needed(module: str, purpose: str) -> Any:
    """The imported `module`; where it is missing, an ImportError that says what to install for which `purpose`."""
    package = module.partition(".")[0]
    try:
        return import_module(module)
    except ImportError as missing:
        name = INSTALL_NAMES.get(package, package)
        raise ImportError(
            f"{purpose} needs the package {name}, which is not installed; "
            f'install it with: pip install {name} (or pip install "ccgen[{EXTRAS[package]}]")'
        ) from missing
