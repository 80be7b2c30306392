"""The reference of the site has every public name of both packages, once, and each has a docstring."""

from __future__ import annotations

import importlib
import inspect
import re

import pytest

from ..support.folders import ROOT


@pytest.mark.parametrize("package", ["generator", "runtime"])
def test_reference_has_the_public_names(package: str) -> None:
    module = importlib.import_module(f"ccgen.{package}")
    text = (ROOT / "docs" / "site" / f"{package}.rst").read_text(encoding="utf-8")
    named = re.findall(r"^\.\. auto(\w+):: (\w+)$", text, re.MULTILINE)
    public = [name for name in module.__all__ if not name.startswith("__")]
    assert sorted(name for _, name in named) == sorted(public)
    for kind, name in named:
        thing = getattr(module, name)
        assert inspect.getdoc(thing), name
        exception = isinstance(thing, type) and issubclass(thing, Exception)
        assert kind == ("exception" if exception else "class" if isinstance(thing, type) else "function"), name
