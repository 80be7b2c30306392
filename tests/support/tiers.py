"""Which parameters of a test run in ``make test``, and which in ``make hard`` alone."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import pytest


def all_hard_but(*kept: Any, of: Iterable[Any]) -> list[Any]:
    """The parameters ``of`` a test, all of them hard but those that are ``kept`` for ``make test``."""
    cases = list(of)
    missing = [case for case in kept if case not in cases]
    assert not missing, f"found {missing} to be kept, expected some of {cases}"
    return [case if case in kept else hard(case) for case in cases]


def hard(*case: Any) -> Any:
    """One case of a test, which ``make hard`` runs."""
    return pytest.param(*case, marks=pytest.mark.hard)
