"""Output of commands as the documentation prints it is what they print."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from ..support.command_line import ccgen
from ..support.folders import ROOT

SAMPLE = re.compile(r"```console\n\$ (ccgen show \S+)\n(.*?)```", re.DOTALL)
SCENE = re.compile(r"```toml\n(name = .*?)```", re.DOTALL)


def samples() -> list[tuple[str, str, str]]:
    """Document, command and what is printed under it."""
    documents = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
    return [(str(d.relative_to(ROOT)), *found) for d in documents for found in SAMPLE.findall(d.read_text())]


def test_there_are_samples() -> None:
    assert {document for document, _, _ in samples()} >= {"README.md", "docs/scenes.md"}


@pytest.mark.parametrize(("document", "command", "printed"), samples(), ids=lambda text: text.partition("\n")[0])
def test_show_prints_what_the_documentation_says(document: str, command: str, printed: str, tmp_path: Path) -> None:
    """Lines between lines of three dots stand together, those before the first at the top."""
    _, verb, scene = command.split()
    if (ROOT / scene).exists():
        scene = str(ROOT / scene)
    else:  # a scene that the document gives itself
        for text in SCENE.findall((ROOT / document).read_text()):
            (tmp_path / f"{text.splitlines()[0].split('=')[1].strip().strip(chr(34))}.toml").write_text(text)
    done = ccgen(verb, scene, at=tmp_path)
    assert done.returncode == 0, done.stderr
    output, parts = done.stderr + done.stdout, re.split(r"^\.\.\.\n", printed, flags=re.MULTILINE)
    assert output.startswith(parts[0])
    for part in parts[1:]:
        assert f"\n{part}" in output
