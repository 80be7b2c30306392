"""What the compiler takes for memory is said before it is asked for, where it is much."""

from __future__ import annotations

import warnings
from pathlib import Path

import pytest

from ccgen.generator.compile.memory import peak, tell_of_memory


@pytest.mark.parametrize(("largest", "megabytes"), [(38_480, 55.7), (104_972, 100.8), (234_031, 220.7)])
def test_the_peak_is_what_was_measured(largest: int, megabytes: float) -> None:
    """GNU time's "maximum resident set size" of gcc -O2 for lattices of 2 × 2, 3 × 3 and 4 × 4 squares."""
    body = "{" + "x" * (largest - 4) + "\n}\n"
    assert peak("int small(void)\n{\n}\nint large(void)\n" + body) == pytest.approx(1e6 * megabytes, rel=0.05)


def test_much_is_told_and_little_is_not(tmp_path: Path) -> None:
    file = tmp_path / "model.c"
    file.write_text("void f(void)\n{" + "x" * 2_220_000 + "\n}\n")
    with pytest.warns(UserWarning, match=r"lattice: the C compiler will take about 6\.6 GB of memory for model\.c"):
        tell_of_memory("lattice", file)
    file.write_text("void f(void)\n{" + "x" * 400_000 + "\n}\n")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        tell_of_memory("lattice", file)
