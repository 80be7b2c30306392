"""The pages of docs/howto print what they say."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from types import ModuleType

import pytest

from ..support.folders import ROOT
from ..support.tiers import all_hard_but

PAGES = sorted(path.stem for path in (ROOT / "docs" / "howto").glob("*.md") if path.stem != "index")
KEPT = ("go-on", "equilibrium", "end-of-a-slide")
"""Three small ones; the others are compiled by ``make hard``."""
NEEDED = {"jax": "jax", "torch": "torch", "casadi": "casadi"}
"""Packages without which a page cannot be run, each an extra of its name."""


@pytest.fixture(scope="module")
def howto() -> ModuleType:
    """docs/scripts/howto.py, which runs pages."""
    spec = importlib.util.spec_from_file_location("howto_pages", ROOT / "docs" / "scripts" / "howto.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


@pytest.mark.slow
@pytest.mark.parametrize("page", all_hard_but(*KEPT, of=PAGES))
@pytest.mark.filterwarnings("ignore:`torch.jit.script` is deprecated:DeprecationWarning")  # in PyTorch's own code
def test_pages_print_what_they_say(page: str, howto: ModuleType, tmp_path: Path) -> None:
    if package := NEEDED.get(page):
        pytest.importorskip(package, reason=f"needs the package {package}: pip install 'ccgen[{package}]'")
    text = (ROOT / "docs" / "howto" / f"{page}.md").read_text(encoding="utf-8")
    found = howto.run_page(text, tmp_path)
    assert found, "a page without anything printed shows nothing"
    for one in found:
        assert one.agrees, f"the page says\n{one.said}and this was printed\n{one.found}"


def test_what_a_page_does_not_say_is_found(howto: ModuleType, tmp_path: Path) -> None:
    page = "```python\nprint(1)\nprint(2)\n```\n\n```text\n1\n{}```\n"
    assert [howto.run_page(page.format(end), tmp_path)[0].agrees for end in ("2\n", "3\n", "...\n", "")] == [
        True,
        False,
        True,
        False,
    ]
