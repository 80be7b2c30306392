"""Files that are no scenes, numbers without squares, and thousands of faults: told soon, and in few words."""

from __future__ import annotations

import warnings
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


BARS = """
[let]
k = {k}
m = 1e300
[ground_link]
points = {{ O = [0, 0], Q = [2, 0] }}
""" + "".join(
    f"""
[[link]]
name = "{name}"
mass = 1
inertia = 1
com = [0, 0]
points = {{{{ A = [0, 0], B = [{size}, 0] }}}}
[[joint]]
between = ["{before}", "{name}.A"]
"""
    for name, before, size in (("a", "ground.O", "{length}"), ("b", "a.B", 1), ("c", "b.B", 1))
)
"""A loop of four bars, the first of which is ``length`` long, but for its last joint."""


@pytest.mark.parametrize(
    ("length", "key", "found"),
    [
        ("1e200", "link[0].points.B[0]", "found 1e+200"),
        ('"1e200 m"', "link[0].points.B[0]", 'found "1e200 m" (1e+200)'),
        ('"1e203 mm"', "link[0].points.B[0]", 'found "1e203 mm" (1e+200)'),
        ("1" + "0" * 200, "link[0].points.B[0]", "found 1e+200"),
        ('"2e180*(1 + 1)"', "link[0].points.B[0]", 'found "2e180*(1 + 1)" (4e+180)'),
        ('"k"', "let.k", "found 1e+180"),
        ('"2*k"', "let.k", "found 1e+180"),
    ],
)
def test_a_length_without_a_square_is_named_as_it_is_written(
    length: str, key: str, found: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """Whatever it is written as, at its line, and before it is worked with: LAPACK has nothing to say, nor NumPy. A
    name that is not used for it is not blamed."""
    text = BARS.format(k=1e180, length=length) + '[[joint]]\nbetween = ["c.B", "ground.Q"]\n'
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        (fault,) = refused(written(tmp_path, text)).faults
    assert fault.key == key
    assert fault.message.startswith(f"{found}, expected a number of 7e-155 to 1e+154, so that its square is one too")
    line = "k = " if key == "let.k" else "points = { A = [0, 0], B = ["
    assert fault.line == next(n for n, one in enumerate(text.splitlines(), 1) if one.startswith(line))
    assert capfd.readouterr() == ("", "")


def test_a_large_number_that_makes_a_small_length_is_fine(tmp_path: Path) -> None:
    text = BARS.format(k=1e180, length='"k*1e-180"') + '[[joint]]\nbetween = ["c.B", "ground.Q"]\n'
    text += "[start]\nangles = { a = 1.2 }\n"
    assert load_scene(written(tmp_path, text)).mechanism.links[0].points["B"].x.value == 1.0


def test_a_division_by_zero_that_no_number_explains_is_not_blamed_on_the_scene(monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(*_: object) -> None:
        raise ZeroDivisionError

    monkeypatch.setattr("ccgen.generator.scene.read.check_energy", broken)
    with pytest.raises(ZeroDivisionError):
        load_scene({"chain": {"links": 1}})


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
