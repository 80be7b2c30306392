"""Results of compilation steps, kept by the bytes that went into them.

A change of the generator that leaves a model's C as it was makes a new package and compiles nothing.
"""

from __future__ import annotations

import contextlib
import hashlib
import secrets
from collections.abc import Callable, Iterable
from pathlib import Path

from .cache import cache_folder

_DIGEST = hashlib.sha256().digest_size


class Steps:
    """The steps of one build. What they make is kept once the whole build has succeeded."""

    def __init__(self) -> None:
        self._made: list[tuple[Path, bytes]] = []

    def fetch_or_make(self, result: Path, made_from: Iterable[bytes], make: Callable[[], object]) -> None:
        """Put a step's ``result`` in place: the kept one of the same bytes, or what ``make`` writes.

        A kept result that is damaged is made again.
        """
        digest = hashlib.sha256()
        for part in made_from:
            digest.update(len(part).to_bytes(8, "big") + part)
        kept = cache_folder() / "steps" / digest.hexdigest()[:32]
        content = _read(kept)
        if content is not None:
            result.write_bytes(content)
            return
        make()
        self._made.append((kept, result.read_bytes()))

    def keep(self) -> None:
        """Keep what was made. Where nothing can be kept, the build is none the worse."""
        for kept, content in self._made:
            _keep(kept, content)


def _read(kept: Path) -> bytes | None:
    """What is kept there, if it is whole."""
    try:
        found = kept.read_bytes()
    except OSError:
        return None
    digest, content = found[:_DIGEST], found[_DIGEST:]
    return content if hashlib.sha256(content).digest() == digest else None


def _keep(kept: Path, content: bytes) -> None:
    """Write beside and rename, so that a reader finds all of it or nothing."""
    beside = kept.with_name(f"{kept.name}.{secrets.token_hex(4)}")
    try:
        kept.parent.mkdir(mode=0o700, exist_ok=True)
        beside.write_bytes(hashlib.sha256(content).digest() + content)
        beside.replace(kept)
    except OSError:
        with contextlib.suppress(OSError):
            beside.unlink(missing_ok=True)
