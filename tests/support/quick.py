"""Which tests are quick: those that compile nothing and start no process, told by what they and their fixtures name.

A test that a file gains later falls under the same rule without a word. Where the rule is wrong, a mark says so:
``@pytest.mark.quick`` for one that compiles a small model which other quick tests share, ``@pytest.mark.slow`` for one
that computes long.
"""

from __future__ import annotations

from collections.abc import Iterator
from types import CodeType, FunctionType
from typing import Any

LASTING = frozenset({"generate", "ccgen", "subprocess", "CliRunner", "Written", "compiler", "multiprocessing"})
"""Names of what compiles, or starts processes or whole commands."""


def is_quick(item: Any) -> bool:
    """Whether a test is quick: as its marks say, else neither it nor a fixture of it names what lasts."""
    if item.get_closest_marker("slow") or item.get_closest_marker("hard"):
        return False
    if item.get_closest_marker("quick"):
        return True
    if "hard" in item.path.parts or "workshop" in item.fixturenames:
        return False
    fixtures = item.session._fixturemanager
    definitions = [d for name in item.fixturenames for d in fixtures.getfixturedefs(name, item) or ()]
    functions = [item.function, *(definition.func for definition in definitions)]
    return LASTING.isdisjoint(name for function in functions for name in named(function, set()))


def named(function: Any, seen: set[Any]) -> Iterator[str]:
    """All names in a function's code, and in the functions and classes of the tests that it names, and so on."""
    code = getattr(function, "__code__", None)
    if code is None or code in seen:
        return
    seen.add(code)
    for name in names_in(code):
        yield name
        found = function.__globals__.get(name)
        if isinstance(found, FunctionType) and found.__module__.startswith("tests."):
            yield from named(found, seen)
        elif isinstance(found, type) and found.__module__.startswith("tests."):
            for method in vars(found).values():
                yield from named(method, seen)


def names_in(code: CodeType) -> Iterator[str]:
    """Names of globals and attributes in code and in the code within it."""
    yield from code.co_names
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from names_in(constant)
