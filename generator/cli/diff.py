"""``ccgen diff OLD NEW``: whether two sets of equations are the same."""

from __future__ import annotations

from pathlib import Path

import typer

from ..pipeline import listing
from .common import fail, progress, read, trouble

LISTING = "equations.txt"


def diff(old: str, new: str) -> None:
    """Print what differs; exit code 0 when nothing does, 1 when something does, 2 when they cannot be compared."""
    from ..program.compare import compare

    with trouble(), progress() as say:
        say("derive")
        texts = [equations(Path(name)) for name in (old, new)]
        say("compare")
        report = compare(texts[0], texts[1], old, new)
    if not report.same:
        typer.echo(report.text, nl=False)
    typer.echo(report.numbers)
    raise typer.Exit(0 if report.same else 1)


def equations(path: Path) -> str:
    """The listing that ``path`` means: that of a generated folder, of a scene, or the file itself."""
    if path.is_dir():
        path = path / LISTING
    if not path.is_file():
        fail(f"{path}: found no such file, expected a generated folder, an {LISTING} or a scene")
    return listing(read(path)) if path.suffix == ".toml" else path.read_text()
