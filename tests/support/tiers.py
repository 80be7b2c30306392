"""Which parameters of a test run in ``make test``, and which in ``make hard`` alone."""

from __future__ import annotations

from collections import defaultdict
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


def leave_samples(items: Iterable[pytest.Item]) -> None:
    """Make all but some cases hard of each test that has the mark ``sample(count)``.

    ``count`` of its cases that are not hard by themselves stay, spread evenly over them from the first to the last. The
    mark is for cases that are alike; where some cover more than others, :func:`all_hard_but` chooses them.
    """
    cases: defaultdict[tuple[Any, ...], list[pytest.Item]] = defaultdict(list)
    for item in items:
        if item.get_closest_marker("sample") and not item.get_closest_marker("hard"):
            cases[item.path, getattr(item, "cls", None), getattr(item, "originalname", item.name)].append(item)
    for same in cases.values():
        mark = same[0].get_closest_marker("sample")
        assert mark is not None
        (count,) = mark.args
        kept = {round(k * (len(same) - 1) / max(count - 1, 1)) for k in range(count)}
        for k, item in enumerate(same):
            if k not in kept:
                item.add_marker(pytest.mark.hard)
