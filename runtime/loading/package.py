"""A generated package on disk: whether it is whole, and runs here, is found out before anything of it is loaded."""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib.machinery import EXTENSION_SUFFIXES
from pathlib import Path
from typing import Any

from .check import fault
from .processor import unfit

RECORD, DATA = "build.json", "model.json"


@dataclass(frozen=True)
class Package:
    """A package in ``folder``: its data, the file of its compiled module, and the ``seal`` that tells its content."""

    folder: Path
    data: Mapping[str, Any]
    extension: Path
    seal: str


def read_package(folder: Path) -> Package:
    """The package in ``folder``, each of its parts that are loaded compared with the size and hash in its record.

    Raises ``FileNotFoundError`` when there is none, and ``ImportError`` when it is damaged, compiled for another
    Python, another runtime or another processor, or has data that are not as ``model.schema.json`` says.
    """
    if not (folder / RECORD).is_file() and not (folder / DATA).is_file():
        raise FileNotFoundError(
            f"path: found {folder}, which is not a generated model, expected one; make one with: ccgen --scene FILE"
        )
    record = _record(folder)
    name = record["extension"]
    if name[name.index(".") :] not in EXTENSION_SUFFIXES:
        raise _useless(folder, f"its compiled module {name} is one for another Python than this")
    if record["contract"] != _contract():
        versions = f"it was generated for contract version {record['contract']}, this runtime has {_contract()}"
        raise _useless(folder, versions)
    if why := unfit(record["processor"]):
        raise _useless(folder, why)
    _part(folder, name, record)
    data = json.loads(_part(folder, DATA, record))
    if isinstance(data, dict) and data.get("contract") != _contract():
        raise _useless(folder, f"{DATA}: contract: found {data.get('contract')!r}, expected {_contract()}")
    if why := fault(data):
        raise _useless(folder, f"{DATA}: {why}")
    return Package(folder, data, folder / name, record["seal"])


def _record(folder: Path) -> dict[str, Any]:
    try:
        record = json.loads((folder / RECORD).read_bytes())
        plain = {name: value for name, value in record.items() if name != "seal"}
        if "seal" not in record:
            raise _useless(folder, f"its {RECORD} has no hashes of its parts, as from an earlier version")
        if record["seal"] == hashlib.sha256(json.dumps(plain, sort_keys=True).encode()).hexdigest():
            return dict(record)
    except (OSError, ValueError, TypeError, AttributeError, RecursionError) as error:
        raise _useless(folder, f"its {RECORD} cannot be read") from error
    raise _useless(folder, f"its {RECORD} is damaged")


def _part(folder: Path, name: str, record: Mapping[str, Any]) -> bytes:
    """The content of a file of the package, which is as it was written."""
    try:
        content = (folder / name).read_bytes()
    except OSError as error:
        raise _useless(folder, f"its {name} cannot be read ({error.strerror})") from error
    part = record["parts"][name]
    if len(content) != part["size"]:
        raise _useless(folder, f"its {name} is damaged: found {len(content)} bytes, expected {part['size']}")
    if hashlib.sha256(content).hexdigest() != part["sha256"]:
        raise _useless(folder, f"its {name} is damaged: it has changed since it was written")
    return content


def _useless(folder: Path, why: str) -> ImportError:
    return ImportError(f"{folder}: the model cannot be loaded: {why}; generate it again here", path=str(folder))


@cache
def _contract() -> int:
    """Version of the contract of this runtime, from its header."""
    header = (Path(__file__).parents[1] / "model.h").read_text()
    return int(re.findall(r"#define CCGEN_CONTRACT_VERSION (\d+)", header)[0])
