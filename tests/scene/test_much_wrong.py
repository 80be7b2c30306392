"""Files that are no scenes, numbers without squares, and thousands of faults: told soon, and in few words."""

from __future__ import annotations

from pathlib import Path

import pytest

from ccgen.generator import SceneError, load_scene
from ccgen.generator.scene.errors import MOST_TOLD
from ccgen.generator.scene.limits import LARGEST, MOST_BYTES

from ..support.folders import SCENES

RODS = 'name = "rods"\n[chain]\nlinks = 1\nhinged = true\n'


def refused(path: Path | str) -> SceneError:
    with pytest.raises(SceneError) as caught:
        load_scene(path)
    return caught.value


def written(tmp_path: Path, text: str) -> Path:
    file = tmp_path / "scene.toml"
    file.write_text(text)
    return file


@pytest.mark.skipif(not Path("/dev/zero").exists(), reason="needs a file without end")
def test_a_file_without_end_is_no_scene() -> None:
    said = f"found more than {MOST_BYTES} bytes, expected a scene file (TOML) of at most that; name another file"
    assert str(refused("/dev/zero")) == f"/dev/zero: {said}"


@pytest.mark.parametrize("number", ["1e308", "1e200"])
def test_a_number_without_a_square_is_named(number: str, tmp_path: Path) -> None:
    """How far the point of a tooth is out: the square of its slope's length is taken, and is none."""
    assert float(number) > LARGEST
    text = (SCENES / "escapement.toml").read_text()
    size = next(line for line in text.splitlines() if line.startswith("S = "))
    error = refused(written(tmp_path, text.replace(size, f"S = {number}")))
    (fault,) = error.faults
    assert fault.key == "let.S" and fault.message.startswith(
        f"found {float(number):g}, expected a number of 7e-155 to 1e+154"
    )


@pytest.mark.parametrize(
    "text",
    [
        RODS + "[gravity]\n" + "\n".join(f'a{k} = "b{k} + 1"' for k in range(5_000)),
        RODS + "\n".join(f'[[force]]\nlink = "x{k}"\nbad{k} = 3' for k in range(400)),
        'name = "m"\n[let]\n' + "\n".join(f'a{k} = "b{k} + 1"' for k in range(450)),
    ],
)
def test_of_many_faults_the_first_are_told(text: str, tmp_path: Path) -> None:
    """All are there to be read by a program; a person gets fifty lines, none longer than a few hundred signs."""
    error = refused(written(tmp_path, text))
    lines = str(error).splitlines()
    assert len(error.faults) > MOST_TOLD and len(lines) == MOST_TOLD + 1
    assert lines[-1].endswith(f": and {len(error.faults) - MOST_TOLD} more; mend these first")
    assert max(map(len, lines)) < 1_000
