"""Skips are counted by their reason, and fail a session that wants all of them in the list."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from ..support.skips import LIST, listed_reasons
from ..support.tiers import hard

ROOT = Path(__file__).resolve().parents[2]
TESTS = """
import pytest
{whole}

@pytest.mark.skipif(True, reason="root may write everywhere")
def test_listed(): ...

def test_within():
    pytest.skip("{reason}")
"""


def session(folder: Path, strict: bool, reason: str = "root may write everywhere", whole: str = "") -> tuple[int, str]:
    """Exit status and output of a session of its own that skips two tests."""
    (folder / "test_skipping.py").write_text(TESTS.format(reason=reason, whole=whole))
    (folder / "conftest.py").write_text(
        "from tests.support.skips import skips\n\n\n"
        "def pytest_configure(config):\n    config.pluginmanager.register(skips())\n"
    )
    environment = os.environ | {"PYTHONPATH": str(ROOT), "CCGEN_SKIPS": "listed" if strict else ""}
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "--rootdir", folder, folder],
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    return done.returncode, done.stdout


def test_listed_reasons_are_counted_and_pass(tmp_path: Path) -> None:
    code, output = session(tmp_path, strict=True)
    assert code == 0 and "    2  root may write everywhere\n" in output, output


@pytest.mark.parametrize("whole", ["", hard("pytest.importorskip('no_such_package')")])
def test_other_reasons_fail_where_all_are_to_be_listed(tmp_path: Path, whole: str) -> None:
    """Within a test, and where a whole file is skipped as it is collected."""
    code, output = session(tmp_path, strict=True, reason="the moon is full", whole=whole)
    assert code == 1 and "(not listed)" in output and "FAILED: found 1 reasons that tests/may_be_skipped.toml" in output
    code, output = session(tmp_path, strict=False, reason="the moon is full", whole=whole)
    assert code == (5 if whole else 0) and "(not listed)" in output, output


def test_wrong_entries_are_refused() -> None:
    for wrong in ('[[skip]]\nreason = "a"', '[[skip]]\nreason = ""\nwhy = "b"', '[[skip]]\nreason = "a"\nwhy = 1'):
        with pytest.raises(ValueError, match=r"may_be_skipped\.toml: found the entry"):
            listed_reasons(wrong)
    assert all(len(why) > 20 for why in listed_reasons(LIST.read_text(encoding="utf-8")).values())
