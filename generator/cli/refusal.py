"""Refusing: a sentence on standard error and an exit code, instead of a traceback."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import NoReturn

import typer

WRONG_INPUT = 2
"""Exit code: what was asked cannot be done."""
STOPPED_EARLY = 3
"""Exit code: a simulation ended before its time, with results written."""


def fail(message: str, code: int = WRONG_INPUT) -> NoReturn:
    """Say ``message`` on standard error and stop with ``code``."""
    typer.echo(message, err=True)
    raise typer.Exit(code)


@contextmanager
def refusing(*kinds: type[Exception]) -> Iterator[None]:
    """Errors of these ``kinds`` become their sentence and exit code 2; others are faults of ccgen and show as such."""
    try:
        yield
    except kinds as error:
        fail(f"ccgen: {error}")
