"""``ccgen --links N`` and ``ccgen --scene FILE``: generate a model."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import typer

from ..compile.compiler import CompileError
from ..package.replace import OutputError
from ..pipeline import generate
from ..program.errors import FoldError
from ..scene import Scene, SceneError, chain, loop, pinned
from ..version import VERSION
from ..write_c.precision import PRECISIONS
from .detail import Detail
from .folders import check_folder
from .progress import progress
from .refusal import Faults, fail, refusing
from .scene_file import read, tell_assembly

WHOLE = re.compile(r"[+-]?[0-9]{1,30}")
"""Numbers of links, of any size that a person types."""


@dataclass(frozen=True)
class Standard:
    """The options that describe a mechanism without a scene file."""

    links: str | None
    pinned: bool = False
    open: bool = False
    hinged: bool = False
    gravity: bool = False

    def given(self) -> list[str]:
        """The options used."""
        return [f"--{name}" for name, value in vars(self).items() if value is not None and value is not False]

    def refuse(self, other: str, scene: Path | None = None) -> None:
        """Stop with exit code 2 if an option stands beside ``other``, which needs none."""
        given = self.given() + (["--scene"] if scene else [])
        if given:
            fail("\n".join(f"{one}: found beside {other}, expected one of them; leave out the other" for one in given))

    def scene(self) -> Scene:
        """The mechanism meant, or exit code 2 and a sentence that names the option for each fault."""
        faults = Faults()
        if self.links is None:
            faults.add(f"{self.given()[0]}: found without --links, expected a number of links; add --links N")
        elif not WHOLE.fullmatch(self.links):
            faults.add(f"--links: found {self.links!r}, expected a whole number of links; correct it")
        if self.open and self.pinned:
            faults.add(
                "--open: found beside --pinned, expected one of them; a chain is open or has both ends on the ground"
            )
        if self.hinged and not self.open:
            faults.add("--hinged: found without --open, expected an open chain; add --open")
        faults.stop_if_any()
        links = int(self.links or 0)
        try:
            if self.pinned:
                return pinned(links, self.gravity)
            return chain(links, self.hinged, self.gravity) if self.open else loop(links, self.gravity)
        except SceneError as error:
            text = "\n".join(f"--links {self.links}: {fault.message}" for fault in error.faults)
            for table, option in (("[loop]", "a loop"), ("[pinned]", "--pinned"), ("[chain]", "--open")):
                text = text.replace(table, option)
            fail(text)


def build(
    standard: Standard,
    scene_file: Path | None,
    out: Path,
    fold: bool,
    precision: str,
    derivatives: bool,
    detail: Detail,
    faults: Faults,
) -> None:
    """Generate the model into ``out`` and print the folder of its package."""
    faults.of(check_precision, precision)
    if fold and precision != "double":
        faults.add(f"--precision {precision}: found beside --fold, whose numbers are doubles; leave one out")
    if scene_file is not None:
        faults.of(standard.refuse, "--scene")
    scene = faults.of(standard.scene) if scene_file is None else faults.of(read, scene_file)
    faults.of(check_folder, out, "--out")
    faults.stop_if_any()
    assert scene
    tell_assembly(scene, detail)
    with refusing(CompileError, OutputError, FoldError), progress(detail) as tell:
        folder = generate(scene, out, tell.stage, fold=fold, precision=precision, derivatives=derivatives)
    typer.echo(str(folder))


def check_precision(name: str) -> str:
    """The name of a precision; exit code 2 where it is none."""
    if name not in PRECISIONS:
        fail(f"--precision: found {name!r}, expected one of {', '.join(PRECISIONS)}; correct it")
    return name


def print_version() -> None:
    """Print the version of ccgen."""
    typer.echo(f"ccgen {VERSION}")
