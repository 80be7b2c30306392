"""Names of packages that would hide a module of Python, of ccgen or of what is installed."""

from __future__ import annotations

import site
import sys
import sysconfig
from importlib.machinery import PathFinder
from pathlib import Path

OWN = "ccgen"


def hidden_module(package: str) -> str | None:
    """Which module a generated ``package`` would hide from ``import`` where its folder is on Python's path, in words.

    Modules are those of Python itself, ccgen, and what is installed beside it; not what lies in the working folder or
    beside a script, so that the answer is the same wherever a scene is read. Generated packages hide nothing.
    """
    if package in sys.stdlib_module_names or package in sys.builtin_module_names:
        return "a module of Python's own"
    if package == OWN:
        return "ccgen itself"
    places = [*site.getsitepackages(), sysconfig.get_path("purelib"), sysconfig.get_path("platlib")]
    if site.ENABLE_USER_SITE:
        places.append(site.getusersitepackages())
    found = PathFinder.find_spec(package, list(dict.fromkeys(places)))
    if found is None:
        return None
    folder = Path(found.origin).parent if found.origin else Path(next(iter(found.submodule_search_locations or ())))
    if (folder / "model.json").is_file() and (folder / "build.json").is_file():
        return None
    return f"an installed module ({found.origin or folder})"
