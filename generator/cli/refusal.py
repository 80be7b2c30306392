"""Refusing: a sentence on standard error and an exit code, instead of a traceback."""

from __future__ import annotations

import os
import shlex
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, NoReturn, ParamSpec, TypeVar

import typer
from typer.core import TyperGroup

WRONG_INPUT = 2
"""Exit code: what was asked cannot be done."""
STOPPED_EARLY = 3
"""Exit code: a simulation ended before its time, with results written."""

P = ParamSpec("P")
T = TypeVar("T")


class Refused(typer.Exit):
    """A command that stops with a ``message``, which :class:`Commands` prints."""

    def __init__(self, message: str, code: int) -> None:
        super().__init__(code)
        self.message = message


def fail(message: str, code: int = WRONG_INPUT) -> NoReturn:
    """Stop with ``code``, and with ``message`` on standard error."""
    raise Refused(message, code)


class Commands(TyperGroup):
    """Commands that say on standard error why they stop."""

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        if args and args[0].endswith(".toml") and self.get_command(ctx, args[0]) is None:
            fail(f"{args[0]}: found a scene, expected a command before it; write ccgen run {shlex.join(args)}")
        return super().resolve_command(ctx, args)

    def invoke(self, ctx: Any) -> Any:
        try:
            found = super().invoke(ctx)
            sys.stdout.flush()
            return found
        except Refused as refused:
            _say(refused.message)
            raise
        except BrokenPipeError:
            raise  # who reads has read enough
        except OSError as error:
            _say(f"ccgen: {told(error)}")
            raise typer.Exit(WRONG_INPUT) from error


def _say(message: str) -> None:
    """Say it on standard error; what waits for a standard output that takes no more is dropped."""
    try:
        sys.stdout.flush()
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    typer.echo(message, err=True)


def told(error: Exception) -> str:
    """The sentence of an error; of one of the system the file and what the system says of it."""
    if not isinstance(error, OSError) or error.strerror is None:
        return str(error)
    return f"{'standard output' if error.filename is None else error.filename}: {error.strerror}"


class Faults:
    """Collects what is wrong with a command, so that all of it is said at once: options, and the scene."""

    def __init__(self) -> None:
        self._found: dict[str, None] = {}

    def of(self, check: Callable[P, T], *arguments: P.args, **options: P.kwargs) -> T | None:
        """What ``check`` gives; where it fails its message is noted, and this is ``None``."""
        try:
            return check(*arguments, **options)
        except Refused as refused:
            self.add(refused.message)
            return None

    def add(self, message: str) -> None:
        """Note a fault."""
        self._found[message] = None

    def about(self, option: str) -> bool:
        """Whether something was noted of an option."""
        return any(one.startswith((f"{option}:", f"{option} ")) for one in self._found)

    def stop_if_any(self) -> None:
        """Stop with exit code 2 and all that was noted, if there is any."""
        if self._found:
            fail("\n".join(self._found))


def read_option(text: str | None, check: Callable[[Any], None], unit: str = "") -> float | None:
    """The number that an option has, if it is there; exit code 2 where ``check`` refuses it, or it is none.

    One that has a ``unit`` may be written as scenes have it, ``2 s`` or ``2*pi/3``."""
    if text is None:
        return None
    found = value_of(text)
    if unit and isinstance(found, str):
        found = _measured(found, unit)
    with refusing_options():
        check(found)
    return float(found)


def _measured(text: str, unit: str) -> float | str:
    """The number (SI) that a text stands for, or the text where it is none of this ``unit``."""
    from .plan_numbers import written

    try:
        return written(text, unit)
    except ValueError:
        return text


def value_of(text: str) -> float | str:
    """The number that a text is, else the text."""
    try:
        return float(text)
    except ValueError:
        return text


@contextmanager
def refusing(*kinds: type[Exception]) -> Iterator[None]:
    """Errors of these ``kinds`` become their sentence and exit code 2; others are faults of ccgen and show as such."""
    try:
        yield
    except kinds as error:
        fail(f"ccgen: {told(error)}")


@contextmanager
def refusing_options() -> Iterator[None]:
    """A ``ValueError`` that names an argument becomes a fault of the option of that name."""
    try:
        yield
    except ValueError as error:
        fail("\n".join(f"--{line}" for line in str(error).splitlines()))
