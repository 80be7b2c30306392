"""Ctrl-C in tests: a process that a shell began in the background ignores it, and so does what that starts."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def heeding_ctrl_c() -> Iterator[None]:
    """Ctrl-C raises ``KeyboardInterrupt`` here, and reaches what is started here, however the tests were
    started."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
