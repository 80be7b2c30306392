"""Outputs by name as a table for other programs."""

from __future__ import annotations

import csv
import io
import os
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ..files import read_path, write_whole
from .outputs import headings_of, values_of
from .record import Record


def write_outputs(run: Record, names: Sequence[str], path: str | os.PathLike[str], times: int | None = None) -> Path:
    """Write outputs as CSV: a heading with units, and of forces the links that they act on, and a line for each row of
    the run, an impact being two of them, or for each of so many even ``times`` from its start to its end."""
    target = read_path(path, "a file")
    t = None if times is None else np.linspace(run.t[0], run.t[-1], times, dtype=run.t.dtype)
    values, headings = values_of(run, names, t), headings_of(run.model)
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(["t [s]", *(headings[name] for name in values)])
    numbers = np.column_stack([run.t if t is None else t, *values.values()])
    table.writerows([[repr(float(x)) for x in row] for row in numbers.tolist()])
    write_whole(target, lambda part: part.write(text.getvalue().encode()))
    return target
