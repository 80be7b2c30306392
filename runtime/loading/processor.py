"""What the processor at hand can do, for code that was compiled for one."""

from __future__ import annotations

import platform
import subprocess
import sys
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any


def unfit(compiled_for: Mapping[str, Any]) -> str:
    """Why code cannot run here that was ``compiled_for`` that processor, in words; empty if it can.

    ``compiled_for`` has the machine and the name of a processor and the features that the code ``needs``, by the names
    of Linux. Where it does not say, or this system does not, the processors must have the same name.
    """
    here, features = platform.machine(), _features()
    if compiled_for["machine"] != here:
        return f"it was compiled for {compiled_for['machine']}, and this machine is {here}"
    if compiled_for["needs"] is None or features is None:
        same = compiled_for["name"] == _name()
        return "" if same else f"it was compiled for {compiled_for['name']!r}, and this processor is {_name()!r}"
    missing = [feature for feature in compiled_for["needs"] if feature not in features]
    return f"it was compiled for a processor with {', '.join(missing)}, which this one has not" if missing else ""


@cache
def _features() -> frozenset[str] | None:
    """Features of the first processor as Linux names them; ``None`` where nothing tells."""
    try:
        with Path("/proc/cpuinfo").open() as lines:
            for line in lines:
                key, _, value = line.partition(":")
                if key.strip() in ("flags", "Features"):
                    return frozenset(value.split())
    except OSError:
        return None
    return None


@cache
def _name() -> str:
    """The processor's name as the system gives it, which may be nothing."""
    if sys.platform == "darwin":
        ask = ("sysctl", "-n", "machdep.cpu.brand_string")
        return subprocess.run(ask, capture_output=True, text=True, check=False).stdout.strip()
    return platform.processor()
