"""Which tests may be skipped: ``tests/may_be_skipped.toml`` says for which reasons, and why that is right.

What was skipped is printed at the end of a session, grouped by reason. With ``CCGEN_SKIPS=listed`` in the environment,
as where all that tests need is installed, a skip for a reason that is not in the list fails the session.
"""

from __future__ import annotations

import os
import re
import tomllib
from collections import Counter
from pathlib import Path
from typing import Any

LIST = Path(__file__).resolve().parents[1] / "may_be_skipped.toml"


def listed_reasons(text: str) -> dict[str, str]:
    """Pattern of the reason of a skip -> why it may be; patterns match the whole reason.

    Raises ``ValueError`` where an entry has other keys, an empty text, or no pattern.
    """
    entries = tomllib.loads(text).get("skip", [])
    for entry in entries:
        if sorted(entry) != ["reason", "why"] or not all(isinstance(entry[key], str) and entry[key] for key in entry):
            raise ValueError(f"{LIST.name}: found the entry {entry}, expected the texts 'reason' and 'why'")
        re.compile(entry["reason"])
    return {entry["reason"]: entry["why"] for entry in entries}


def reason_of(report: Any) -> str:
    """Why a report says that its test, or all tests of its file, were skipped."""
    reason = report.longrepr[2] if isinstance(report.longrepr, tuple) else str(report.longrepr)
    return " ".join(reason.removeprefix("Skipped: ").split())


class Skips:
    """Counts the skips of a session, as a plugin of pytest."""

    def __init__(self, reasons: dict[str, str], strict: bool) -> None:
        self.reasons, self.strict = reasons, strict
        self.found: Counter[str] = Counter()

    def unlisted(self) -> list[str]:
        """The reasons that are in no entry of the list."""
        return [reason for reason in sorted(self.found) if not any(re.fullmatch(p, reason) for p in self.reasons)]

    def pytest_runtest_logreport(self, report: Any) -> None:
        if report.skipped and not hasattr(report, "wasxfail"):
            self.found[reason_of(report)] += 1

    def pytest_collectreport(self, report: Any) -> None:
        if report.skipped:
            self.found[reason_of(report)] += 1

    def pytest_sessionfinish(self, session: Any) -> None:
        if self.strict and self.unlisted() and not hasattr(session.config, "workerinput"):
            session.exitstatus = 1

    def pytest_terminal_summary(self, terminalreporter: Any) -> None:
        if not self.found:
            return
        unlisted = self.unlisted()
        terminalreporter.section("skipped")
        for reason, count in sorted(self.found.items()):
            terminalreporter.write_line(f"{count:5d}  {reason}{'  (not listed)' if reason in unlisted else ''}")
        if self.strict and unlisted:
            terminalreporter.write_line(
                f"FAILED: found {len(unlisted)} reasons that tests/{LIST.name} does not have, expected none; "
                "install what is missing"
            )


def skips() -> Skips:
    """The plugin, with the list of the repository."""
    return Skips(listed_reasons(LIST.read_text(encoding="utf-8")), os.environ.get("CCGEN_SKIPS") == "listed")
