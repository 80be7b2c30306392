"""Output of commands as the documentation prints it is what they print; calls have the arguments that they take."""

from __future__ import annotations

import inspect
import re
import shlex
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from ccgen.runtime import ensemble, simulate

from ..support.command_line import ccgen
from ..support.folders import ROOT
from ..support.leaning_rod import LEANING

SAMPLE = re.compile(r"```console\n\$ (ccgen (?:show|run) \S+)\n(.*?)```", re.DOTALL)
ELSEWHERE = {"leaning-rod.toml": LEANING.replace('"leaning"', '"leaning-rod"')}
"""Scenes that are run in a document and stand in none."""
FIGURE = re.compile(r"-?\d[\d.]*(e[+-]\d+)?")
SCENE = re.compile(r"```toml\n(name = .*?)```", re.DOTALL)


def samples() -> list[tuple[str, str, str]]:
    """Document, command and what is printed under it."""
    documents = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
    return [(str(d.relative_to(ROOT)), *found) for d in documents for found in SAMPLE.findall(d.read_text())]


def test_there_are_samples() -> None:
    assert {document for document, _, _ in samples()} >= {"README.md", "docs/scenes.md"}


@pytest.mark.parametrize(("document", "command", "printed"), samples(), ids=lambda text: text.partition("\n")[0])
def test_commands_print_what_the_documentation_says(document: str, command: str, printed: str, tmp_path: Path) -> None:
    """Lines between lines of three dots stand together, those before the first at the top.

    The words of runs alone: how many steps they take, and their last digits, differ with the machine.
    """
    _, verb, scene = command.split()
    for name, text in ELSEWHERE.items():
        (tmp_path / name).write_text(text)
    if (ROOT / scene).exists():
        scene = str(ROOT / scene)
    else:  # a scene that the document gives itself
        for text in SCENE.findall((ROOT / document).read_text()):
            (tmp_path / f"{text.splitlines()[0].split('=')[1].strip().strip(chr(34))}.toml").write_text(text)
    done = ccgen(verb, scene, at=tmp_path)
    assert done.returncode == 0, done.stderr
    output = done.stderr + done.stdout
    if verb == "run":
        output, printed = (FIGURE.sub("0", text) for text in (output, printed))
    parts = re.split(r"^\.\.\.\n", printed, flags=re.MULTILINE)
    assert output.startswith(parts[0])
    for part in parts[1:]:
        assert f"\n{part}" in output


def test_the_script_of_the_front_page_prints_what_it_says(tmp_path: Path) -> None:
    """Beside the scene of the page, in a process of its own; what is printed stands behind the call."""
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    (scene,) = SCENE.findall(readme)
    (script,) = re.findall(r"```python\n(.*?)```", readme, re.DOTALL)
    (said,) = re.findall(r"^print\(.*\) +# (.*)$", script, re.MULTILINE)
    (tmp_path / "my-four-bar.toml").write_text(scene)
    done = subprocess.run(
        [sys.executable, "-c", script], cwd=tmp_path, capture_output=True, text=True, timeout=300, check=False
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout == f"{said}\n"


def test_commands_of_the_front_page_work(tmp_path: Path) -> None:
    """Those in its text, one after the other, each without a word of a fault."""
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    (scene,) = SCENE.findall(readme)
    (tmp_path / "my-four-bar.toml").write_text(scene)
    commands = re.findall(r"^    ccgen (.*?) +#", readme, re.MULTILINE)
    assert len(commands) >= 3
    for command in commands:
        done = ccgen(*shlex.split(command), at=tmp_path)
        assert done.returncode == 0, (command, done.stderr)
        assert "--plot" not in command or (tmp_path / "results" / "my-four-bar" / "outputs.png").exists()


def test_the_front_page_is_short() -> None:
    """What it would say more belongs on a page of docs/."""
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    assert readme.count("\n") <= 120
    assert len(readme.split()) <= 1000


@pytest.mark.parametrize("function", [simulate, ensemble])
def test_calls_are_documented_with_all_their_arguments(function: Callable[..., Any]) -> None:
    """The call in docs/model.md has them in their order, and the table or the text above it says what each does."""
    text = (ROOT / "docs" / "model.md").read_text()
    pattern = rf"^    {function.__name__}\((.*?)\)\n(.*?)\n### "
    call, said = re.search(pattern, text, re.DOTALL | re.MULTILINE).groups()  # type: ignore[union-attr]
    parameters = inspect.signature(function).parameters
    assert [one.partition("=")[0].strip() for one in call.split(",") if one.strip() != "*"] == list(parameters)
    for name, parameter in parameters.items():
        if parameter.default is not inspect.Parameter.empty:
            assert f"`{name}`" in said, name
