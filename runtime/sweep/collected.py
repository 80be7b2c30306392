"""Runs that have come back, in any order: kept on disk as pieces until their part is whole, and then written as one."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from ..extras import needed
from .folder import PIECE, SweepError, SweepFolder, table_of

EVERY = 1.0
"""Seconds after which runs that have come back are put on disk: what a sudden end costs."""


class Collected:
    """What there is of the missing parts of a folder, by the numbers of runs.

    Pieces that an earlier sweep has left are taken up; those of parts that are whole are removed.
    """

    def __init__(self, folder: SweepFolder) -> None:
        self.folder, self.saved = folder, time.monotonic()
        self.missing = set(folder.missing())
        self.stretches: dict[int, tuple[int, Any]] = {}  # by the first run of each: its end, and a table or its file
        for file in sorted(folder.path.iterdir()):
            if found := PIECE.match(file.name):
                first, last = int(found[1]), int(found[2])
                if self._part(first) in self.missing:
                    self.stretches[first] = last, file
                else:
                    file.unlink()
        self.left = {part: sum(last - first for first, last in self._gaps(part)) for part in self.missing}
        for part in sorted(part for part, left in self.left.items() if not left):
            self._finish(part)

    @property
    def done(self) -> int:
        """How many runs there are, those of parts that are whole among them."""
        return int(self.folder.manifest["runs"]) - sum(self.left.values())

    def gaps(self) -> list[tuple[int, int]]:
        """First and last run of each stretch that is to be made, in order, none of them in two parts."""
        return [gap for part in sorted(self.missing) for gap in self._gaps(part)]

    def add(self, first: int, columns: Mapping[str, Any]) -> None:
        """Keep runs from ``first`` on, of one part; a part that they make whole is written."""
        table = table_of(columns, self.folder.manifest["units"])
        self.stretches[first] = first + table.num_rows, table
        part = self._part(first)
        self.left[part] -= table.num_rows
        if not self.left[part]:
            self._finish(part)
        elif time.monotonic() > self.saved + EVERY:
            self.save()

    def save(self) -> None:
        """Put all that is in memory on disk: stretches that follow each other in one file."""
        together: list[tuple[int, int, list[Any]]] = []
        for first, (last, table) in self._sorted():
            if isinstance(table, Path):
                continue
            if together and together[-1][1] == first and self._part(together[-1][0]) == self._part(first):
                begin, _, tables = together.pop()
                together.append((begin, last, [*tables, table]))
            else:
                together.append((first, last, [table]))
        for first, last, tables in together:
            name = f"piece-{first:010d}-{last:010d}.arrow"
            self.folder.write(name, _packed(tables))
            for one in [one for one in self.stretches if first <= one < last]:
                del self.stretches[one]
            self.stretches[first] = last, self.folder.path / name
        self.saved = time.monotonic()

    def _finish(self, part: int) -> None:
        """Write a part that is whole, and remove its pieces."""
        begin, end = self.folder.rows(part)
        own = [(first, table) for first, (_, table) in self._sorted() if begin <= first < end]
        self.folder.write_part(part, _joined([_unpacked(one) if isinstance(one, Path) else one for _, one in own]))
        self.missing.discard(part)
        del self.left[part]
        for first, table in own:
            del self.stretches[first]
            if isinstance(table, Path):
                table.unlink()

    def _part(self, run: int) -> int:
        return run // int(self.folder.manifest["part"])

    def _sorted(self) -> list[tuple[int, tuple[int, Any]]]:
        return sorted(self.stretches.items(), key=lambda one: one[0])

    def _gaps(self, part: int) -> Iterator[tuple[int, int]]:
        at, end = self.folder.rows(part)
        for first, (last, _) in self._sorted():
            if at <= first < end:
                if at < first:
                    yield at, first
                at = last
        if at < end:
            yield at, end


def _joined(tables: list[Any]) -> Any:
    """One table of several; the same whatever pieces it came in."""
    return needed("pyarrow", "a sweep").concat_tables(tables).combine_chunks()


def _packed(tables: list[Any]) -> bytes:
    arrow, table = needed("pyarrow", "a sweep"), _joined(tables)
    buffer = arrow.BufferOutputStream()
    with arrow.ipc.new_file(buffer, table.schema) as writer:
        writer.write_table(table)
    content: bytes = buffer.getvalue().to_pybytes()
    return content


def _unpacked(file: Path) -> Any:
    """Raises :class:`SweepError` for a piece that cannot be read."""
    arrow = needed("pyarrow", "a sweep")
    try:
        return arrow.ipc.open_file(arrow.py_buffer(file.read_bytes())).read_all()
    except (OSError, arrow.ArrowInvalid) as error:
        raise SweepError(f"{file}: found a piece that cannot be read ({error}); remove it, and start again") from error
