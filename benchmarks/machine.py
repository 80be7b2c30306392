"""One line on what the figures were measured on."""

import os
import platform
import subprocess
from functools import cache
from pathlib import Path

import numpy as np
from driver import COMPILER


@cache
def machine() -> str:
    """Processor, cores, compiler, Python and NumPy."""
    version = subprocess.run([*COMPILER, "--version"], capture_output=True, text=True, check=True).stdout
    parts = (_processor(), f"{os.cpu_count()} cores", platform.platform(), version.splitlines()[0])
    return ", ".join([*parts, f"Python {platform.python_version()}", f"NumPy {np.__version__}"])


def _processor() -> str:
    """Its name where the system tells it, with the widest vectors it has."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return platform.processor() or platform.machine()
    fields = {key.strip(): value.strip() for key, _, value in (line.partition(":") for line in lines)}
    vectors = next((name for name in ("avx512f", "avx2") if name in fields.get("flags", "").split()), "")
    return f"{fields.get('model name', platform.machine())} {vectors}".strip()
