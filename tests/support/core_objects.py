"""The core's files compiled by themselves, each once for all tests that compile the same with the same flags."""

from __future__ import annotations

import hashlib
import os
import secrets
import shutil
import subprocess
from collections.abc import Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

BASE = ("-O0", "-std=c11", "-fPIC")


def core_objects(runtime: Path, flags: Sequence[str] = (), layers: Iterable[str] = ("*",)) -> list[str]:
    """Paths of the object files of the core in ``runtime``, a folder: of all its layers or of those that are named.

    They lie beside the models of this session, called by what goes into them; the tests of other processes find them.
    """
    if os.name != "posix" or not shutil.which("cc"):
        pytest.skip("needs cc")
    core = runtime / "core"
    command = ["cc", *BASE, *flags, *os.environ.get("CFLAGS", "").split(), f"-I{runtime}", f"-I{core}"]
    headers = hashlib.sha256()
    for header in sorted(runtime.rglob("*.h")):
        headers.update(str(header.relative_to(runtime)).encode() + header.read_bytes())
    kept = Path(os.environ["CCGEN_CACHE_DIR"]) / "core"
    kept.mkdir(mode=0o700, parents=True, exist_ok=True)

    def compiled(source: Path) -> str:
        said = " ".join((*BASE, *flags, os.environ.get("CFLAGS", ""), str(source.relative_to(core)))).encode()
        digest = hashlib.sha256(headers.digest() + said + b"\0" + source.read_bytes()).hexdigest()[:32]
        result = kept / f"{digest}.o"
        if not result.exists():
            beside = kept / f"{digest}.{secrets.token_hex(4)}.o"
            subprocess.run([*command, "-c", str(source), "-o", str(beside)], check=True)
            beside.replace(result)
        return str(result)

    sources = sorted(source for layer in layers for source in core.glob(f"{layer}/*.c"))
    with ThreadPoolExecutor(2) as pool:
        return list(pool.map(compiled, sources))
