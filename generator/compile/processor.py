"""What the processor must be able to do for code that a compiler made for it."""

from __future__ import annotations

import os
import platform
import re
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

LIKE_ITS_FLAG = (
    *("sse4_1", "sse4_2", "sse4a", "ssse3", "popcnt", "movbe", "avx", "avx2", "fma", "fma4", "f16c", "xop", "tbm"),
    *("adx", "bmi2", "gfni", "vaes", "vpclmulqdq", "avx512f", "avx512dq", "avx512cd", "avx512bw", "avx512vl"),
    *("avx512ifma", "avx512vbmi"),
)
"""Flags of Linux whose macros of the compiler have the same name."""

X86 = {f"__{flag.upper()}__": flag for flag in LIKE_ITS_FLAG} | {
    "__SSE3__": "pni",
    "__LZCNT__": "abm",
    "__BMI__": "bmi1",
    "__AVXVNNI__": "avx_vnni",
    "__AVX512VBMI2__": "avx512_vbmi2",
    "__AVX512VNNI__": "avx512_vnni",
    "__AVX512BITALG__": "avx512_bitalg",
    "__AVX512VPOPCNTDQ__": "avx512_vpopcntdq",
    "__AVX512BF16__": "avx512_bf16",
    "__AVX512FP16__": "avx512_fp16",
    "__APX_F__": "apx",
}
ARM = {
    "__ARM_FEATURE_ATOMICS": "atomics",
    "__ARM_FEATURE_CRC32": "crc32",
    "__ARM_FEATURE_DOTPROD": "asimddp",
    "__ARM_FEATURE_FP16_VECTOR_ARITHMETIC": "asimdhp",
    "__ARM_FEATURE_BF16_VECTOR_ARITHMETIC": "bf16",
    "__ARM_FEATURE_MATMUL_INT8": "i8mm",
    "__ARM_FEATURE_SVE": "sve",
    "__ARM_FEATURE_SVE2": "sve2",
}
FEATURES = {"x86_64": X86, "amd64": X86, "i686": X86, "aarch64": ARM, "arm64": ARM}
"""By machine: macros that a compiler predefines when it may use instructions, and the kernel's names for these."""


def processor(command: Sequence[str], flags: Sequence[str]) -> dict[str, object]:
    """Where code runs that a compiler ``command`` makes with ``flags``: machine, processor, and features it ``needs``.

    The features are those that the compiler says that it may use, by the names that Linux gives them in
    ``/proc/cpuinfo``; ``None`` where it does not say.
    """
    return {"machine": platform.machine(), "name": processor_name(), "needs": _needs(command, flags)}


def _needs(command: Sequence[str], flags: Sequence[str]) -> list[str] | None:
    features = FEATURES.get(platform.machine().lower())
    ask = (*command, *flags, "-dM", "-E", "-x", "c", os.devnull)
    done = subprocess.run(ask, capture_output=True, text=True, check=False)
    macros = set(re.findall(r"^#define (\w+)", done.stdout, re.MULTILINE))
    if features is None or done.returncode or not macros:
        return None
    return sorted({feature for macro, feature in features.items() if macro in macros})


def processor_name() -> str:
    """The processor's name as the system gives it, which may be nothing."""
    if sys.platform == "darwin":
        ask = ("sysctl", "-n", "machdep.cpu.brand_string")
        return subprocess.run(ask, capture_output=True, text=True, check=False).stdout.strip()
    return platform.processor()


def native() -> str:
    """What ``-march=native`` depends on, where the system tells."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return processor_name()
    wanted = ("model name", "flags", "Features", "CPU part")
    found: dict[str, str] = {}
    for line in lines:
        key, _, value = line.partition(":")
        if key.strip() in wanted:
            found.setdefault(key.strip(), value.strip())
    return " ".join(found.values())
