"""The figures that the hard cases reach, and the table of them that ``make figures`` prints."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from ..support.reach import Reach

REACHED = "reached"


@pytest.fixture
def reach(record_property: Callable[[str, object], None]) -> Reach:
    """Note that a figure has been reached, and hold it to its bound: ``reach(what, figure, bound)``."""

    def note(what: str, figure: float, bound: float) -> None:
        record_property(REACHED, (what, float(figure), float(bound)))
        assert figure <= bound, what

    return note


def pytest_terminal_summary(terminalreporter: Any) -> None:
    reports = [*terminalreporter.getreports("passed"), *terminalreporter.getreports("failed")]
    figures = [noted for report in reports for name, noted in report.user_properties if name == REACHED]
    if not figures:
        return
    width = max(len(what) for what, _, _ in figures)
    terminalreporter.write_line("")
    terminalreporter.write_line(f"{'hard case':<{width}}  {'reached':>9}  {'bound':>9}")
    for what, figure, bound in figures:
        terminalreporter.write_line(f"{what:<{width}}  {figure:9.1e}  {bound:9.1e}")
