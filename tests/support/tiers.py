"""Which parameters of a test run in ``make test``, which in ``make hard`` alone, and which with ``CCGEN_LARGE=1``."""

from __future__ import annotations

import os
from collections import defaultdict
from collections.abc import Iterable
from typing import Any

import pytest

LARGE = "CCGEN_LARGE" in os.environ
"""Surveys run with their largest counts, and with all their cases (``make figures``, ``CCGEN_LARGE=1 make hard``)."""


def many(usual: int, large: int) -> int:
    """How many cases a survey draws: the first ``usual`` of ``large``, and with ``CCGEN_LARGE=1`` all of them."""
    return large if LARGE else usual


def all_hard_but(*kept: Any, of: Iterable[Any]) -> list[Any]:
    """The parameters ``of`` a test, all of them hard but those that are ``kept`` for ``make test``."""
    cases = list(of)
    missing = [case for case in kept if case not in cases]
    assert not missing, f"found {missing} to be kept, expected some of {cases}"
    return [case if case in kept else hard(case) for case in cases]


def hard(*case: Any) -> Any:
    """One case of a test, which ``make hard`` runs."""
    return pytest.param(*case, marks=pytest.mark.hard)


def leave_samples(items: Iterable[pytest.Item]) -> None:
    """Make all but some cases hard of each test that has the mark ``sample(count)``.

    ``count`` of its cases that are not hard by themselves stay, spread evenly over them from the first to the last. The
    mark is for cases that are alike; where some cover more than others, :func:`all_hard_but` chooses them.
    """
    for same in _by_test(item for item in items if not item.get_closest_marker("hard")):
        for item in _beside_sample(same, "sample"):
            item.add_marker(pytest.mark.hard)


def leave_large(items: Iterable[pytest.Item]) -> list[pytest.Item]:
    """What runs with ``CCGEN_LARGE=1`` alone: of the hard cases of each test with the mark ``large(count)`` all but
    ``count``, spread evenly over them from the first to the last. With ``large(count, id, ...)`` those that are named
    run always."""
    return [item for same in _by_test(filter(is_hard, items)) for item in _beside_sample(same, "large")]


def is_hard(item: pytest.Item) -> bool:
    return item.get_closest_marker("hard") is not None


def _by_test(items: Iterable[pytest.Item]) -> Iterable[list[pytest.Item]]:
    cases: defaultdict[tuple[Any, ...], list[pytest.Item]] = defaultdict(list)
    for item in items:
        cases[item.path, getattr(item, "cls", None), getattr(item, "originalname", item.name)].append(item)
    return cases.values()


def _beside_sample(same: list[pytest.Item], mark: str) -> list[pytest.Item]:
    """The cases of a test that are not among those of its mark, none where it has no such mark."""
    found = same[0].get_closest_marker(mark)
    if found is None:
        return []
    count, *named = found.args
    kept = {round(k * (len(same) - 1) / max(count - 1, 1)) for k in range(count)}
    return [item for k, item in enumerate(same) if k not in kept and item.callspec.id not in named]  # type: ignore[attr-defined]
