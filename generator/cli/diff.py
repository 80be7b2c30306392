"""``ccgen diff OLD NEW``: whether two sets of equations are the same."""

from __future__ import annotations

from pathlib import Path

import typer

from ..pipeline import listing
from .folders import check_there
from .progress import progress
from .refusal import Faults, fail, refusing
from .scene_file import read

LISTING = "equations.txt"


def diff(old: str, new: str) -> None:
    """Print what differs; exit code 0 when nothing does, 1 when something does, 2 when they cannot be compared."""
    from ..program.compare import compare
    from ..program.reading import ListingError

    with refusing(ListingError), progress() as tell:
        tell.stage("derive")
        faults = Faults()
        texts = [faults.of(equations, Path(name)) or "" for name in (old, new)]
        faults.stop_if_any()
        tell.stage("compare")
        report = compare(texts[0], texts[1], old, new)
    if not report.same:
        typer.echo(report.text, nl=False)
    typer.echo(report.numbers)
    raise typer.Exit(0 if report.same else 1)


def equations(path: Path) -> str:
    """The listing that ``path`` means: that of a generated folder, of a scene, or the file itself."""
    check_there(path, f"a generated folder, an {LISTING} or a scene")
    file = path / LISTING if path.is_dir() else path
    if not file.is_file():
        fail(f"{file}: found no such file, expected a generated folder, an {LISTING} or a scene")
    if file.suffix == ".toml":
        return listing(read(file))
    try:
        return file.read_text(encoding="utf-8")
    except OSError as error:
        fail(f"{file}: cannot be read ({error.strerror}), expected a generated folder, an {LISTING} or a scene")
    except UnicodeDecodeError:
        fail(f"{file}: found bytes that are not UTF-8, expected a generated folder, an {LISTING} or a scene")
