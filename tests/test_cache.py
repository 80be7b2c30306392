"""Nothing is derived or compiled twice, two builds at once do no harm, and nothing is left half written."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from ccgen.generator import CompileError, OutputError, Scene, generate, load_scene, loop
from ccgen.runtime import load_model

TEXT = 'name = "bars"\n[chain]\nlinks = 2\nhinged = true\n[gravity]\ng = {g}\n'


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty cache of this test's own."""
    monkeypatch.setenv("CCGEN_CACHE_DIR", str(tmp_path / "cache"))
    return tmp_path / "cache"


def bars(folder: Path, g: float = 9.81) -> Scene:
    file = folder / "bars.toml"
    file.write_text(TEXT.format(g=g))
    return load_scene(file)


def stages(scene: Scene, out: Path) -> list[str]:
    """The stages that generating goes through."""
    found: list[str] = []
    generate(scene, out, found.append)
    return found


def entries(folder: Path) -> list[str]:
    """What lies in a folder, lock files aside."""
    return sorted(path.name for path in folder.iterdir() if path.suffix != ".lock") if folder.exists() else []


def test_the_second_build_derives_and_compiles_nothing(cache: Path, tmp_path: Path) -> None:
    first, scene = tmp_path / "first", bars(tmp_path)
    assert [stage for stage in stages(scene, first) if stage in ("derive", "compile")] == ["derive", "compile"]
    assert stages(scene, first) == []
    in_another_folder = stages(scene, tmp_path / "second")
    assert "derive" not in in_another_folder and "compile" not in in_another_folder
    for file in (first / "bars").iterdir():
        if file.is_file():
            assert (tmp_path / "second" / "bars" / file.name).read_bytes() == file.read_bytes()
    assert load_model(tmp_path / "second" / "bars").links == ("link_0", "link_1")


def test_a_changed_scene_is_built_anew(cache: Path, tmp_path: Path) -> None:
    listing = tmp_path / "build" / "bars" / "equations.txt"
    generate(bars(tmp_path, g=9.81), tmp_path / "build")
    assert "derive" in stages(bars(tmp_path, g=1.62), tmp_path / "build")
    assert "g = 1.62 " in listing.read_text()
    assert "derive" not in stages(bars(tmp_path, g=9.81), tmp_path / "build")
    assert "g = 9.81 " in listing.read_text()
    assert entries(tmp_path / "build") == ["bars"]


def test_a_model_built_anew_is_loaded_anew(cache: Path, tmp_path: Path) -> None:
    old = load_model(generate(bars(tmp_path, g=9.81), tmp_path / "build"))
    new = load_model(generate(bars(tmp_path, g=1.62), tmp_path / "build"))
    q, u = np.zeros(2), np.zeros(2)
    assert new.acceleration(q, u) * 9.81 == pytest.approx(old.acceleration(q, u) * 1.62)


def test_a_damaged_package_is_replaced(cache: Path, tmp_path: Path) -> None:
    package = generate(bars(tmp_path), tmp_path / "build")
    (package / ".key").write_text("of something else")
    (package / "model.json").write_text("{")
    assert load_model(generate(bars(tmp_path), tmp_path / "build")).name == "bars"


def test_two_builds_at_once(cache: Path, tmp_path: Path) -> None:
    bars(tmp_path)
    code = (
        "from ccgen.generator import generate, load_scene; from ccgen.runtime import load_model; "
        "print(load_model(generate(load_scene('bars.toml'))).dof)"
    )
    builds = [
        subprocess.Popen(
            [sys.executable, "-c", code], cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )
        for _ in range(2)
    ]
    results = [build.communicate(timeout=120) for build in builds]
    assert [(build.returncode, out) for build, (out, _) in zip(builds, results, strict=True)] == [(0, "2\n")] * 2, (
        results
    )
    assert entries(tmp_path / "build") == ["bars"]
    assert len(entries(cache / "models")) == 1


@pytest.mark.parametrize("compiler", ["false", "no-such-compiler"])
def test_a_build_that_fails_leaves_nothing(
    compiler: str, cache: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("CC", compiler)
    with pytest.raises(CompileError, match=compiler):
        generate(bars(tmp_path), tmp_path / "build")
    assert entries(tmp_path / "build") == []
    assert entries(cache / "models") == []
    monkeypatch.delenv("CC")
    assert load_model(generate(bars(tmp_path), tmp_path / "build")).name == "bars"


def test_a_build_that_is_interrupted_leaves_what_there_was(cache: Path, tmp_path: Path) -> None:
    package = generate(bars(tmp_path, g=1.0), tmp_path / "build")

    def interrupt(stage: str) -> None:
        if stage == "compile":
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        generate(bars(tmp_path, g=2.0), tmp_path / "build", interrupt)
    assert load_model(package).parameters["gravity.g"] == 1.0
    assert entries(tmp_path / "build") == ["bars"]
    assert len(entries(cache / "models")) == 1


def test_folders_that_cannot_be_written(cache: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError, match="file"):
        generate(bars(tmp_path), tmp_path / "file" / "build")
    monkeypatch.setenv("CCGEN_CACHE_DIR", str(tmp_path / "file" / "cache"))
    with pytest.raises(OutputError, match="file"):
        generate(loop(3), tmp_path / "build")
    assert entries(tmp_path / "build") == []
