"""Builds docs/gallery: of every entry of entries.toml a moving picture of its run, and index.md.

    python docs/scripts/gallery.py                   # all pictures and the index; says what each run finds
    python docs/scripts/gallery.py woodpecker klann  # these alone, and the index
    python docs/scripts/gallery.py --index           # the index alone

Pictures play in real time unless an entry says how many times slower, or faster; their clock is then that of the
picture. Where one has more than ``MOST`` bytes, frames are left out.
"""

from __future__ import annotations

import argparse
import tempfile
import tomllib
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import gallery_numbers
import numpy as np
from PIL import Image, ImageSequence

from ccgen.generator import generate, load_scene
from ccgen.runtime import load_model, simulate
from ccgen.runtime.pictures.gif import write_gif

ROOT = Path(__file__).parents[2]
GALLERY = ROOT / "docs" / "gallery"
MOST = 400_000
"""Largest size of a picture, in bytes."""
LEAST_RATE = 6.0
"""Frames per second below which a motion is not seen as one."""
INTRODUCTION = """\
# Gallery

Mechanisms that move. Each has a scene, a question that it answers, and a number that `tests/hard/test_gallery.py`
holds against an answer that owes nothing to `ccgen`. This page and its pictures are made by

    python docs/scripts/gallery.py

from [entries.toml](entries.toml); it prints what each run finds beside the answer. With the name of an entry behind, it
makes that one picture.
"""


@dataclass(frozen=True)
class Entry:
    """A row of entries.toml; ``answer``, ``unit`` and ``within`` are of the number that is tested."""

    name: str
    title: str
    scene: str
    question: str
    number: str
    answer: float
    unit: str
    within: float
    independent: str
    until: float | None = None
    slower: float = 1.0
    impacts: bool = True

    @property
    def picture(self) -> str:
        return f"{self.name}.gif"

    @property
    def command(self) -> str:
        until = "" if self.until is None else f" --until {self.until:g}"
        return f"ccgen run {self.scene}{until} --gif"


class Shown:
    """A run as a picture shows it: what its writer asks of a run, at times that are ``slower`` times as long, and with
    impacts or without."""

    def __init__(self, run: Any, slower: float, impacts: bool) -> None:
        self.run, self.slower = run, slower
        self.t = np.asarray(run.t, dtype=float) * slower
        shown = run.impacts if impacts else ()
        self.impacts = [replace(impact, t=float(impact.t) * slower) for impact in shown]

    def at(self, t: Any) -> Any:
        """The state at times of the picture's clock."""
        return self.run.at(np.clip(np.asarray(t) / self.slower, self.run.t[0], self.run.t[-1]))

    def __getattr__(self, name: str) -> Any:
        return getattr(self.run, name)


def entries() -> list[Entry]:
    """The rows of entries.toml, in their order."""
    return [Entry(**row) for row in tomllib.loads((GALLERY / "entries.toml").read_text(encoding="utf-8"))["entry"]]


def index(rows: list[Entry]) -> str:
    """The text of index.md."""
    parts = [INTRODUCTION]
    for row in rows:
        pace = "" if row.slower == 1 else f" The picture, and its clock, go {_pace(row.slower)}."
        parts.append(
            f"## {row.title}\n\n![{row.title}]({row.picture})\n\n{row.question}{pace}\n\n    {row.command}\n\n"
            f"[{row.scene}](../../{row.scene}). **{_number(row.answer)} {row.unit}** is {row.number}. "
            f"Known from: {row.independent} The run agrees within {row.within:g} {row.unit}.\n"
        )
    return "\n".join(parts)


def _pace(slower: float) -> str:
    return f"{slower:g} times slower" if slower > 1 else f"{1 / slower:g} times as fast"


def _number(value: float) -> str:
    return f"{value:.12g}"


def run_of(row: Entry, folder: str | None = None) -> Any:
    """The run of an entry, until the end of its picture. Without a folder the model stays in the cache."""
    with tempfile.TemporaryDirectory() as own:
        return simulate(load_model(generate(load_scene(ROOT / row.scene), folder or own)), until=row.until)


def draw(row: Entry, run: Any) -> Path:
    """The moving picture of a run, thinned to ``MOST`` bytes."""
    path = GALLERY / row.picture
    write_gif(Shown(run, row.slower, row.impacts), path)  # type: ignore[arg-type]
    whole = path.read_bytes()
    every = 1
    while path.stat().st_size > MOST:
        every += 1
        path.write_bytes(whole)
        thin(path, every)
    return path


def thin(path: Path, every: int) -> None:
    """Keep of a GIF each ``every``-th frame, for as long as those that it stands for were seen.

    Raises ``ValueError`` where fewer than ``LEAST_RATE`` frames a second are left.
    """
    with Image.open(path) as picture:
        pace = picture.info["duration"]
        if 1000 / (pace * every) < LEAST_RATE:
            raise ValueError(
                f"{path.name}: found more than {MOST} bytes at {LEAST_RATE:g} frames a second; show less of it"
            )
        frames = [frame.copy() for k, frame in enumerate(ImageSequence.Iterator(picture)) if k % every == 0]
    some = frames[:: max(1, len(frames) // 8)]
    sheet = Image.new("RGB", (frames[0].width, frames[0].height * len(some)))
    for k, frame in enumerate(some):
        sheet.paste(frame.convert("RGB"), (0, k * frame.height))
    colours = sheet.quantize(64)
    flat = [frame.convert("RGB").quantize(palette=colours, dither=Image.Dither.NONE) for frame in frames]
    flat[0].save(path, save_all=True, append_images=flat[1:], duration=pace * every, loop=0, disposal=1, optimize=False)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", help="entries to draw; all without any")
    parser.add_argument("--index", action="store_true", help="write the index alone")
    given = parser.parse_args()
    rows = entries()
    unknown = set(given.names) - {row.name for row in rows}
    if unknown:
        parser.error(f"found {', '.join(sorted(unknown))}, expected names of {', '.join(row.name for row in rows)}")
    for row in rows:
        if given.index or (given.names and row.name not in given.names):
            continue
        run = run_of(row)
        path = draw(row, run)
        found = gallery_numbers.NUMBERS[row.name](run)
        print(f"{path.name}: {path.stat().st_size // 1000} kB; {row.number}: {_number(found)}, ", end="")
        print(f"answer {_number(row.answer)} {row.unit}")
    (GALLERY / "index.md").write_text(index(rows), encoding="utf-8")


if __name__ == "__main__":
    main()
