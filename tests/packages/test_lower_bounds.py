"""What ``make oldest`` installs is what pyproject.toml says."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parents[2]
PROJECT = """
[project]
dependencies = ["numpy>=1.26", "sympy>=1.13"]
optional-dependencies = { browser = ["playwright>=1.40"], test = ["ccgen[browser]", "pytest>=8.2", "numpy>=1.26"] }
"""


@pytest.fixture(scope="module")
def script() -> Any:
    spec = importlib.util.spec_from_file_location("lower_bounds", ROOT / "backend" / "lower_bounds.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_bounds_of_the_project_and_of_what_its_tests_need(script: Any) -> None:
    found = script.lower_bounds(PROJECT)
    assert found == ["numpy==1.26", "sympy==1.13", "playwright==1.40", "pytest==8.2"]


def test_every_requirement_of_ccgen_has_a_bound(script: Any) -> None:
    found = script.lower_bounds((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    assert len(found) > 20 and "pytest-xdist==3.6" in found


def test_a_requirement_without_one_is_refused(script: Any) -> None:
    with pytest.raises(ValueError, match=r"found 'numpy<3', expected a name, >= and a version"):
        script.lower_bounds(PROJECT.replace("numpy>=1.26", "numpy<3"))
