"""The build backend: setuptools, and the C compiler of the ziglang package where the machine has none.

``pip`` asks it for what building needs, before it makes the environment that ``setup.py`` runs in.
"""

from __future__ import annotations

import os
import shutil
import sys
from collections.abc import Mapping

from setuptools import build_meta
from setuptools.build_meta import *  # noqa: F403

Settings = Mapping[str, object] | None

ZIG = "ziglang>=0.12"
COMPILERS = ("cc", "gcc", "clang")


def has_compiler() -> bool:
    """Whether ``$CC`` names a compiler, or there is one on the path."""
    return bool(os.environ.get("CC")) or any(map(shutil.which, COMPILERS)) or sys.platform == "win32"


def get_requires_for_build_wheel(config_settings: Settings = None) -> list[str]:
    """What ``pip install .`` needs besides setuptools and Cython."""
    return [*build_meta.get_requires_for_build_wheel(config_settings), *([] if has_compiler() else [ZIG])]


def get_requires_for_build_editable(config_settings: Settings = None) -> list[str]:
    """What ``pip install -e .`` needs besides setuptools and Cython."""
    return [*build_meta.get_requires_for_build_editable(config_settings), *([] if has_compiler() else [ZIG])]
