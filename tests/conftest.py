"""Fixtures that every test may use: a cache of its own for the session, and models built once."""

from __future__ import annotations

import gc
import os
from collections.abc import Iterator
from pathlib import Path

import pytest

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
"""Set before numpy is imported: tests run side by side, and threads of linear algebra that wait for a busy core spin.
With as many workers as cores a singular value decomposition of 200 rows takes a hundred times as long otherwise."""

gc.set_threshold(20_000, 50, 100)
"""Derivations make many small terms and few cycles: looked through for those after every 700 terms, as Python does by
itself, a session takes a tenth longer."""

pytest.register_assert_rewrite("tests.support")  # before it is imported: what a failed assertion there compared

from .support.quick import is_quick  # noqa: E402
from .support.skips import skips  # noqa: E402
from .support.tiers import LARGE, leave_large, leave_samples  # noqa: E402
from .support.workshop import Workshop  # noqa: E402


def pytest_configure(config: pytest.Config) -> None:
    """Count skips, and say at the end for which reasons tests were skipped."""
    config.pluginmanager.register(skips())


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Mark what the tiers run, before any tests are chosen by their marks: what of samples only ``make hard`` runs, and
    the quick tests, which ``make quick`` runs. Of surveys only cases that are named, and those that every ``make hard``
    runs, are left unless CCGEN_LARGE asks for all."""
    leave_samples(items)
    if not LARGE and not any("::" in argument for argument in config.args):
        late = leave_large(items)
        config.hook.pytest_deselected(items=late)
        left = set(late)
        items[:] = [item for item in items if item not in left]
    for item in items:
        if is_quick(item):
            item.add_marker("quick")


def pytest_xdist_auto_num_workers() -> int:
    """One more than there are cores: a worker that waits for a compiler or a command leaves its core to another."""
    return len(os.sched_getaffinity(0)) + 1 if hasattr(os, "sched_getaffinity") else (os.cpu_count() or 1) + 1


@pytest.fixture(scope="session", autouse=True)
def own_cache(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """Generated packages go into a folder of this session, never into the user's cache; tests side by side share it."""
    base = tmp_path_factory.getbasetemp()
    folder = (base.parent if "PYTEST_XDIST_WORKER" in os.environ else base) / "cache"
    folder.mkdir(exist_ok=True)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("CCGEN_CACHE_DIR", os.environ.get("CCGEN_TEST_CACHE_DIR", str(folder)))
        yield folder


@pytest.fixture(scope="session")
def workshop(tmp_path_factory: pytest.TempPathFactory, own_cache: Path) -> Workshop:
    return Workshop(tmp_path_factory.mktemp("workshop"))
