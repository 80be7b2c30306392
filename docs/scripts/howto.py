"""Runs the pages of docs/howto and compares what they print with what they say: ``python docs/scripts/howto.py``.

On a page, from top to bottom: a ``toml`` fence is saved as a scene under its name, a ``c`` fence that begins with
``/* NAME.c:`` as that file; ``python`` fences are one program, and what one prints is the ``text`` fence behind it;
of a ``console`` fence the lines with ``$`` are run in one shell, and the others are what they print, with ``...`` for
any lines. Pages are named without .md, all unless given. ``--write`` writes what was printed into them.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import os
import re
import subprocess
import sys
import tempfile
from dataclasses import dataclass, replace
from pathlib import Path

PAGES = Path(__file__).resolve().parents[1] / "howto"
FENCE = re.compile(r"^```(\w+)\n(.*?)^```$", re.DOTALL | re.MULTILINE)
SCENE = re.compile(r'\Aname = "([\w-]+)"')
PROGRAM = re.compile(r"\A/\* (\w+\.c):")


@dataclass(frozen=True)
class Printed:
    """What a fence of a page says, where its text lies in the page, and what was printed."""

    said: str
    start: int
    end: int
    found: str

    @property
    def agrees(self) -> bool:
        """Whether all lines are there in their order; ``...`` stands for any lines, and a message may come before."""
        return bool(re.fullmatch(_pattern(self.said), self.found, re.DOTALL))


def run_page(text: str, folder: Path) -> list[Printed]:
    """Run a page in an empty folder, which becomes the current one meanwhile; what it prints beside each fence."""
    found: list[Printed] = []
    space: dict[str, object] = {"__name__": "__page__"}
    printed = ""
    with _inside(folder):
        for fence in FENCE.finditer(text):
            kind, code = fence[1], fence[2]
            if kind == "toml" and (name := SCENE.match(code)):
                Path(f"{name[1]}.toml").write_text(code)
            elif kind == "c" and (program := PROGRAM.match(code)):
                Path(program[1]).write_text(code)
            elif kind == "python":
                with contextlib.redirect_stdout(io.StringIO()) as out:
                    exec(compile(code, "page", "exec"), space)
                printed = _without_ends(out.getvalue())
            elif kind == "text":
                found.append(Printed(code, *fence.span(2), printed))
            elif kind == "console":
                found.append(Printed(code, *fence.span(2), _session(re.findall(r"^\$ (.*)$", code, re.MULTILINE))))
    return found


def rewritten(text: str, found: list[Printed]) -> str:
    """The page with what was printed; fences that have ``...`` in them stay."""
    for one in sorted(found, key=lambda one: -one.start):
        if "...\n" not in one.said:
            text = text[: one.start] + one.found + text[one.end :]
    return text


def _pattern(said: str) -> str:
    return "".join(r"(.*\n)?" if line == "...\n" else re.escape(line) for line in said.splitlines(keepends=True))


def _session(commands: list[str]) -> str:
    """Commands, each with what it prints, in one shell with the ``python`` and ``ccgen`` of this Python on its path."""
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ.get('PATH', '')}"
    done = subprocess.run(
        ["sh", "-ec", "\n".join(f"{command}\nprintf '\\0'" for command in commands)],
        capture_output=True,
        text=True,
        env={**os.environ, "PATH": path, "COLUMNS": "1000"},
        timeout=300,
        check=False,
    )
    if done.returncode:
        raise RuntimeError(f"{commands}: exit code {done.returncode}\n{done.stderr}")
    answers = done.stdout.split("\0")
    return _without_ends("".join(f"$ {command}\n{said}" for command, said in zip(commands, answers, strict=False)))


def _without_ends(text: str) -> str:
    """Lines without spaces at their ends, which editors take away."""
    return "".join(f"{line.rstrip()}\n" for line in text.splitlines())


@contextlib.contextmanager
def _inside(folder: Path):  # type: ignore[no-untyped-def]
    before = Path.cwd()
    os.chdir(folder)
    try:
        yield
    finally:
        os.chdir(before)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("pages", nargs="*", help="names of pages without .md; all unless given")
    parser.add_argument("--write", action="store_true", help="write what was printed into the pages")
    asked = parser.parse_args()
    names = asked.pages or sorted(path.stem for path in PAGES.glob("*.md"))
    wrong = 0
    for name in names:
        file = PAGES / f"{name}.md"
        text = file.read_text(encoding="utf-8")
        with tempfile.TemporaryDirectory() as folder:
            found = run_page(text, Path(folder))
        if asked.write:
            new = rewritten(text, found)
            file.write_text(new, encoding="utf-8")
            found = [replace(one, said=one.found) if "...\n" not in one.said else one for one in found]
        for one in found:
            if not one.agrees:
                wrong += 1
                print(f"{name}: the page says\n{one.said}and this was printed\n{one.found}")
        print(f"{name}: {len(found)} printed, {sum(one.agrees for one in found)} as the page says")
    return wrong != 0


if __name__ == "__main__":
    sys.exit(main())
