"""Derivatives are written where they are asked for, and nothing else changes with them."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import pytest

from ccgen.generator import generate, load_scene
from ccgen.generator.compile.compiler import find_compiler
from ccgen.generator.pipeline import Variant, _hash
from ccgen.generator.scene import loop

from ..support.folders import ROOT, RUNTIME
from ..support.tiers import hard

STRICT = ("-std=c11", "-Wall", "-Wextra", "-Werror", "-O2", "-march=native", "-c", "-o", "/dev/null")


def test_who_does_not_ask_has_the_same_bytes(tmp_path: Path) -> None:
    """Besides a declaration and a line in the descriptor, and the hash, which tells the two apart."""
    scene = load_scene(ROOT / "scenes" / "four-bar.toml")
    plain, asked = generate(scene, tmp_path / "plain"), generate(scene, tmp_path / "asked", derivatives=True)
    without, name = _hash(scene, Variant()), scene.package
    files = {path.name for path in asked.iterdir()} - {path.name for path in plain.iterdir()}
    assert sorted(file for file in files if file.endswith((".c", ".h"))) == ["derivatives.c"]
    texts = [path for path in plain.iterdir() if path.suffix in (".c", ".h", ".txt", ".pyx", ".py", ".json")]
    for path in texts:
        if path.name == "build.json":
            continue
        text = (asked / path.name).read_text().replace(_hash(scene, Variant(derivatives=True)), without)
        if path.name == "model.c":
            assert "ccgen_derivatives" not in path.read_text()
            text = text.replace(
                f"\nextern const struct ccgen_derivatives CCGEN_CALLED(ccgen_derivatives, {name});\n", ""
            )
            text = text.replace(f"    .derivatives = &CCGEN_CALLED(ccgen_derivatives, {name}),\n", "")
        assert text == path.read_text(), path.name


@pytest.mark.parametrize("precision", ["double", hard("float"), hard("wide")])
@pytest.mark.parametrize("kind", ["four-bar", hard("falling-hexagon"), hard("jansen-driven"), hard("ring")])
def test_derivatives_compile_without_a_warning(kind: str, precision: str, tmp_path: Path) -> None:
    scene = loop(30, gravity=True) if kind == "ring" else load_scene(ROOT / "scenes" / f"{kind}.toml")
    folder = generate(scene, tmp_path, precision=precision, derivatives=True)
    command = [*find_compiler().command, *STRICT, f"-I{RUNTIME}", "derivatives.c"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[:3000]


@pytest.mark.slow
def test_lines_of_derivatives_are_few() -> None:
    """Of a long ring they are loops: its text does not grow with its links."""
    from ccgen.generator.pipeline import derive_scene
    from ccgen.generator.program.dialects import C
    from ccgen.generator.program.program import lower
    from ccgen.generator.program.routine import Routines
    from ccgen.generator.write_c.render import Banner, render_derivatives

    sizes = []
    for links in (10, 20):
        _, equations = derive_scene(loop(links, gravity=True))
        routines = Routines(lower(equations), C.term)
        text = render_derivatives(Banner("a", "a", "0", "0"), equations, routines)
        of_residual = re.search(r"static int residual_q_tangent.*?\n}\n", text, re.S)
        assert of_residual
        sizes.append(of_residual[0].partition("for (int block")[2].count("\n"))
    assert sizes[1] < 2 * sizes[0]
