"""Work that several threads share, and the thread that waits for them: it tells how far they are, and takes Ctrl-C."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor, wait
from threading import Event

from .interruption import check

PAUSE = 0.05
"""Seconds between two looks of the thread that waits."""


def processors() -> int:
    """How many threads this process can have at work at once."""
    try:
        return len(os.sched_getaffinity(0))
    except AttributeError:  # where processes have no affinity
        return os.cpu_count() or 1


def share(work: Callable[[], None], threads: int, end: Callable[[], None], told: Callable[[], None] | None) -> bool:
    """Have ``work`` called by so many ``threads``, and wait until all are back; False where Ctrl-C came meanwhile.

    ``end`` is to have them come back soon, ``told`` is called now and then. What they raise is raised.
    """
    whole, at_work = True, list[Event]()

    def working() -> None:
        back = Event()
        at_work.append(back)
        try:
            work()
        finally:
            back.set()

    with ThreadPoolExecutor(threads) as pool:
        tasks: list[Future[None]] = []
        try:
            tasks += [pool.submit(working) for _ in range(threads)]
            while wait(tasks, PAUSE).not_done:
                check()
                if told is not None:
                    told()
        except KeyboardInterrupt:
            whole = False
            end()
        except BaseException:
            end()
            raise
    for back in at_work:
        back.wait()  # the pool does not know a thread that Ctrl-C broke the start of
    for task in tasks:
        task.result()
    return whole
