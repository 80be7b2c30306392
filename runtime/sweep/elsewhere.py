"""Chunks made by the workers of an executor: sent ahead, and sent again where a worker dies with them."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator, Mapping
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, CancelledError, Executor, Future, wait
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any

from .chunk import chunk_of, make_elsewhere
from .folder import SweepError
from .plan import Plan
from .sizes import Sizes
from .source import NoModelError, Source

TRIES = 4
"""How often a chunk is sent, where workers die with it."""
AHEAD = 3
"""Chunks for every worker that are sent before the first is back."""
LOST = frozenset({"KilledWorker", "FutureCancelledError", "CommClosedError", "TimeoutError", "FutureLostError"})
"""Names of errors of Dask that say that a worker is gone, or what it had."""
Made = Generator[tuple[int, dict[str, Any]], None, None]
"""Chunks by their first runs, and their columns."""


@dataclass
class Sent:
    """A chunk, how often it was sent, and whether with the files of the model."""

    first: int
    last: int
    tries: int = 1
    whole: bool = field(default=False)


class Elsewhere:
    """Makes chunks by an executor, a Dask client, or a function that gives an executor: where all workers of one are
    gone, a second one is made by it. ``built`` is called with what built the model of the worker, for every chunk."""

    def __init__(
        self,
        source: Source,
        plan: Plan,
        executor: Any,
        threads: int | None,
        built: Callable[[Mapping[str, Any]], None],
    ) -> None:
        self.source, self.plan, self.threads, self.built = source, plan, threads or 1, built
        self.another: Callable[[], Executor] | None = None if hasattr(executor, "submit") else executor
        self.client = executor if hasattr(executor, "get_executor") else None
        self.executor = self._begin(executor)
        self.waiting: dict[Future[Any], Sent] = {}

    def made(self, chunks: Iterator[tuple[int, int]], sizes: Sizes) -> Made:
        """Every chunk once, in the order in which they come back. Raises :class:`SweepError` where workers die again
        and again with one, and where they have no model."""
        try:
            more = True
            while more or self.waiting:
                while more and len(self.waiting) < AHEAD * self._workers():
                    following = next(chunks, None)
                    more = following is not None
                    if following is not None:
                        self._send(Sent(*following))
                if self.waiting:
                    yield from self._back(sizes)
        finally:
            for future in self.waiting:
                future.cancel()
            if self.another is not None:
                self.executor.shutdown(wait=not self.waiting, cancel_futures=True)

    def _back(self, sizes: Sizes) -> Made:
        """Those that are back by now, at least one; others are sent again."""
        for future in wait(self.waiting, return_when=FIRST_COMPLETED).done:
            sent = self.waiting.pop(future, None)
            if sent is None:  # sent again with another one, whose executor has broken
                continue
            try:
                columns, seconds, build = future.result()
            except NoModelError as error:
                self._bring(sent, error)
            except (Exception, CancelledError) as error:
                self._lost(sent, error)
            else:
                sizes.took(sent.last - sent.first, seconds)
                self.built(build)
                yield sent.first, columns

    def _send(self, sent: Sent) -> None:
        source, chunk = self.source, chunk_of(self.plan, sent.first, sent.last)
        sent.whole = bool(source.files)
        try:
            self.waiting[self.executor.submit(make_elsewhere, source, chunk, self.threads)] = sent
        except BrokenExecutor as error:
            self._lost(sent, error)

    def _bring(self, sent: Sent, error: NoModelError) -> None:
        """Send a chunk again with the files of the model, which a worker has not."""
        if sent.whole or self.source.rebuild is None:
            raise SweepError(
                f"a worker cannot load the model: {error}; let all workers see its folder, or give rebuild="
                "ccgen.generator.rebuild, by which they compile it themselves"
            ) from error
        if not self.source.files:
            self.source = self.source.with_files()
        self._send(sent)

    def _lost(self, sent: Sent, error: BaseException) -> None:
        """Send a chunk again where it was the worker, not the work, that failed; else raise."""
        if not _is_of_worker(error):
            raise error
        if sent.tries >= TRIES:
            raise SweepError(
                f"workers died {TRIES} times with the runs {sent.first} to {sent.last - 1} ({type(error).__name__}: "
                f"{error}); see what they say themselves, as of memory; start again: it goes on with what is done"
            ) from error
        again = [sent]
        if isinstance(error, BrokenExecutor):
            if self.another is None:
                raise SweepError(
                    f"a worker of the executor died, and with it the executor ({error}); start again with another one: "
                    "it goes on with what is done; a function that makes executors, given in its place, does so itself"
                ) from error
            again += self.waiting.values()
            self.waiting.clear()
            with suppress(Exception):
                self.executor.shutdown(wait=False, cancel_futures=True)
            self.executor = self._begin(self.another)
        for one in again:
            one.tries += 1
            self._send(one)

    def _begin(self, given: Any) -> Executor:
        if self.client is not None:
            found: Executor = self.client.get_executor(pure=False)
            return found
        if self.another is not None:
            return self.another()
        return given  # type: ignore[no-any-return]

    def _workers(self) -> int:
        if self.client is not None:
            return max(1, int(sum(self.client.nthreads().values())))
        return int(getattr(self.executor, "_max_workers", 1))


def _is_of_worker(error: BaseException) -> bool:
    """Whether a worker has failed, and not its work."""
    names = {kind.__name__ for kind in type(error).__mro__}
    return isinstance(error, BrokenExecutor | CancelledError | ConnectionError) or bool(names & LOST)
