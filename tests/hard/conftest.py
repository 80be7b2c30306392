"""The figures that the hard cases reach, and the table of them that ``make hard`` prints."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import pytest

Reach = Callable[[str, float, float], None]
FIGURES: list[tuple[str, float, float]] = []


@pytest.fixture
def reach() -> Iterator[Reach]:
    """Note that a figure has been reached, and hold it to its bound: ``reach(what, figure, bound)``."""

    def note(what: str, figure: float, bound: float) -> None:
        FIGURES.append((what, float(figure), bound))
        assert figure <= bound, what

    yield note


def pytest_terminal_summary(terminalreporter: Any) -> None:
    if not FIGURES:
        return
    width = max(len(what) for what, _, _ in FIGURES)
    terminalreporter.write_line("")
    terminalreporter.write_line(f"{'hard case':<{width}}  {'reached':>9}  {'bound':>9}")
    for what, figure, bound in FIGURES:
        terminalreporter.write_line(f"{what:<{width}}  {figure:9.1e}  {bound:9.1e}")
