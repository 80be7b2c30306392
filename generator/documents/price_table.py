"""The table of what each effect adds in operations, for the summary that ``ccgen show`` prints."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import astuple

from ..program.prices import Price
from ..program.program import Counts

HEADINGS = ("effect", "adds to", "sums", "products", "quotients", "sines", "functions")
"""Columns; a sine comes with its cosine, a square root counts as a quotient."""

Row = tuple[str, ...]


def price_rows(prices: Sequence[Price]) -> tuple[Row, ...]:
    """One row for each part of the model that an effect adds operations to; one that adds none says so."""
    rows: list[Row] = []
    for price in prices:
        parts = [(group, counts) for group, counts in price.added.items() if counts != Counts()]
        for index, (group, counts) in enumerate(parts or [("nothing", Counts())]):
            rows.append((price.title if index == 0 else "", group, *map(str, astuple(counts))))
    return tuple(rows)


def price_lines(prices: Sequence[Price]) -> tuple[str, ...]:
    """The table as lines of text, words to the left and numbers to the right of their columns."""
    if not prices:
        return ()
    table = [HEADINGS, *price_rows(prices)]
    widths = [max(len(row[column]) for row in table) for column in range(len(HEADINGS))]
    return tuple(
        "  ".join(cell.ljust(width) if column < 2 else cell.rjust(width) for column, (cell, width) in enumerate(cells))
        for cells in ([*zip(row, widths, strict=True)] for row in table)
    )
