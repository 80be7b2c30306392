"""What ccgen did not write is never removed or replaced; a refusal names the folder and what lies there."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from ccgen.generator import OutputError, generate, load_scene, loop
from ccgen.generator.cli.clean import clean
from ccgen.runtime import load_model

from ..support.command_line import ccgen
from ..support.folders import ROOT

SCENE = "[chain]\nlinks = 2\nhinged = true\n[run]\nuntil = 0.1\n"


def content(folder: Path) -> dict[str, bytes]:
    """All files below a folder, links not followed."""
    return {str(p.relative_to(folder)): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()}


def test_a_folder_named_like_the_scene_stays(tmp_path: Path) -> None:
    (tmp_path / "docs.toml").write_text(SCENE)
    (tmp_path / "docs").mkdir()
    (tmp_path / "docs" / "thesis.tex").write_text("years of work")
    before = content(tmp_path)
    done = ccgen("--scene", "docs.toml", "--out", ".", at=tmp_path)
    assert done.returncode == 2
    assert "docs: found a folder that ccgen did not write, with thesis.tex" in done.stderr
    assert content(tmp_path) == before


def a_file(place: Path) -> None:
    place.write_text("mine")


def a_link(place: Path) -> None:
    (place.parent / "elsewhere").mkdir()
    place.symlink_to(place.parent / "elsewhere")


def a_link_to_nothing(place: Path) -> None:
    place.symlink_to(place.parent / "nowhere")


def a_private_key(place: Path) -> None:
    place.mkdir()
    (place / ".key").write_text("0123456789abcdef" * 4)


def a_build_of_another_tool(place: Path) -> None:
    place.mkdir()
    (place / "build.json").write_text("{}")
    (place / "model.c").write_text("int main(void) { return 0; }")


def sources_of_the_same_name(place: Path) -> None:
    place.mkdir()
    (place / "__init__.py").write_text("import numpy")
    (place / "model.json").write_text("{}")


def a_folder_for_a_file(place: Path) -> None:
    a_build_of_another_tool(place)
    (place / "lanes.c").mkdir()


@pytest.mark.parametrize(
    ("lay", "named"),
    [
        (a_file, "found a file"),
        (a_link, "found a link"),
        (a_link_to_nothing, "found a link"),
        (a_private_key, "ccgen did not write, with .key"),
        (a_build_of_another_tool, "ccgen did not write, with build.json, model.c"),
        (sources_of_the_same_name, "ccgen did not write, with __init__.py, model.json"),
        (a_folder_for_a_file, "ccgen did not write, with lanes.c"),
    ],
)
def test_what_lies_at_the_place_of_a_package_stays(lay: object, named: str, tmp_path: Path) -> None:
    lay(tmp_path / "loop3")  # type: ignore[operator]
    before, told = content(tmp_path), list[str]()
    with pytest.raises(OutputError, match=f"{tmp_path / 'loop3'}: .*{named}"):
        generate(loop(3), tmp_path, told.append)
    assert "derive" not in told
    assert content(tmp_path) == before
    assert sorted(path.name for path in tmp_path.iterdir() if path.name != "elsewhere") == ["loop3"]


def test_files_added_to_a_package_stay(tmp_path: Path) -> None:
    scene = tmp_path / "bars.toml"
    scene.write_text(SCENE)
    package = generate(load_scene(scene), tmp_path)
    (package / "notes.txt").write_text("mine")
    assert generate(load_scene(scene), tmp_path) == package  # it is the current one: nothing to replace
    scene.write_text(SCENE + "[gravity]\n")
    with pytest.raises(OutputError, match=r"found notes\.txt in the package, which ccgen did not write"):
        generate(load_scene(scene), tmp_path)
    assert (package / "notes.txt").read_text() == "mine"
    (package / "notes.txt").unlink()
    (package / "__pycache__").mkdir()
    for name in ("__init__.cpython-311.pyc", "__init__.cpython-311.pyc.140234567890"):  # whole; just being written
        (package / "__pycache__" / name).write_bytes(b"")
    generate(load_scene(scene), tmp_path)
    assert "gravity" in (package / "equations.txt").read_text()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["bars", "bars.toml"]


@pytest.mark.parametrize("name", ["equations.txt", "__init__.py", "model.c"])
def test_a_text_of_a_package_that_was_edited_stays(name: str, tmp_path: Path) -> None:
    """What is loaded, and what is empty or gone, is damage and made anew."""
    scene = tmp_path / "bars.toml"
    scene.write_text(SCENE)
    package = generate(load_scene(scene), tmp_path)
    (package / name).write_text((package / name).read_text() + "mine\n")
    scene.write_text(SCENE + "[gravity]\n")
    before = content(package)
    with pytest.raises(OutputError, match=rf"bars: found {name} in the package changed since ccgen wrote it"):
        generate(load_scene(scene), tmp_path)
    assert content(package) == before
    assert clean(tmp_path / "bars") == [package / name]
    (package / name).unlink()
    package = generate(load_scene(scene), tmp_path)
    (package / "model.json").write_text("{")
    (package / "lanes.c").write_text("")
    (package / "equations.txt").unlink()
    generate(load_scene(scene), tmp_path)
    assert "gravity" in (package / "equations.txt").read_text() and (package / "lanes.c").read_text()


def test_a_record_of_nested_lists_is_damage(tmp_path: Path) -> None:
    package = generate(loop(3), tmp_path)
    (package / "build.json").write_text("[" * 100_000)
    with pytest.raises(ImportError, match=r"its build\.json cannot be read"):
        load_model(package)
    assert load_model(generate(loop(3), tmp_path)).links


def test_files_written_into_a_package_while_it_is_replaced_stay(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from ccgen.generator.package import replace

    scene = tmp_path / "bars.toml"
    scene.write_text(SCENE)
    package = generate(load_scene(scene), tmp_path)
    before = content(package)
    exchange, calls = replace._exchange, list[str]()

    def too_late(one: Path, other: Path) -> None:
        if not calls:
            (package / "late.txt").write_text("mine")
        calls.append("exchange")
        exchange(one, other)

    monkeypatch.setattr(replace, "_exchange", too_late)
    scene.write_text(SCENE + "[gravity]\n")
    with pytest.raises(OutputError, match=r"late\.txt"):
        generate(load_scene(scene), tmp_path)
    assert content(package) == before | {"late.txt": b"mine"}


def test_an_empty_folder_is_filled(tmp_path: Path) -> None:
    (tmp_path / "loop3").mkdir()
    assert (generate(loop(3), tmp_path) / "model.c").is_file()


@pytest.fixture(scope="module")
def ran(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a scene and its results."""
    folder = tmp_path_factory.mktemp("ran")
    (folder / "bars.toml").write_text(SCENE)
    assert ccgen("run", "bars.toml", at=folder).returncode == 0
    return folder


def test_results_replace_results_and_nothing_else(ran: Path, tmp_path: Path) -> None:
    shutil.copytree(ran, tmp_path, dirs_exist_ok=True)
    results = tmp_path / "results" / "bars"
    (results / "notes.txt").write_text("mine")
    assert ccgen("run", "bars.toml", "--until", "0.2", at=tmp_path).returncode == 0
    assert np.load(results / "result.npz")["t"][-1] == 0.2
    assert (results / "notes.txt").read_text() == "mine"
    (results / "plot.png").write_bytes(b"drawn anew")
    before = content(results)
    done = ccgen("run", "bars.toml", at=tmp_path)
    assert done.returncode == 2
    assert "results/bars: found the file plot.png, which ccgen did not write or which has changed" in done.stderr
    assert content(results) == before


@pytest.mark.hard
def test_files_of_older_results_go_with_them(ran: Path, tmp_path: Path) -> None:
    """A table that a run wrote does not stay beside the results of another; one that was changed does."""
    shutil.copytree(ran, tmp_path, dirs_exist_ok=True)
    results = tmp_path / "results" / "bars"
    for edited in (False, True):
        assert ccgen("run", "bars.toml", "--csv", at=tmp_path).returncode == 0
        if edited:
            (results / "forces.csv").write_text("mine")
        assert ccgen("run", "bars.toml", "--until", "0.2", at=tmp_path).returncode == 0
        assert (results / "forces.csv").exists() == edited
    assert ccgen("run", "bars.toml", at=tmp_path).returncode == 0


@pytest.mark.parametrize("name", ["result.npz", "plot.png", "player.html", "animation.gif"])
def test_a_file_of_the_users_with_the_name_of_a_result_stays(name: str, ran: Path, tmp_path: Path) -> None:
    (tmp_path / name).write_text("mine")
    done = ccgen("run", str(ran / "bars.toml"), "--gif", "--out", ".", at=tmp_path)
    assert done.returncode == 2 and f"found the file {name}, which ccgen did not write" in done.stderr
    assert content(tmp_path) == {name: b"mine"}


def test_a_link_in_the_place_of_a_result_stays(ran: Path, tmp_path: Path) -> None:
    (tmp_path / "thesis.png").write_text("mine")
    (tmp_path / "plot.png").symlink_to("thesis.png")
    done = ccgen("run", str(ran / "bars.toml"), "--out", ".", at=tmp_path)
    assert done.returncode == 2 and "plot.png" in done.stderr
    assert (tmp_path / "plot.png").is_symlink() and (tmp_path / "thesis.png").read_text() == "mine"


def test_of_results_without_a_record_runs_alone_are_known(ran: Path, tmp_path: Path) -> None:
    """As earlier versions left them: a run says that it is one, a picture does not say whose it is."""
    shutil.copytree(ran, tmp_path, dirs_exist_ok=True)
    results = tmp_path / "results" / "bars"
    (results / ".ccgen.json").unlink()
    before = content(results)
    done = ccgen("run", "bars.toml", at=tmp_path)
    assert done.returncode == 2 and "plot.png beside a run of an earlier version" in done.stderr
    assert content(results) == before
    for name in before:
        if name != "result.npz":
            (results / name).unlink()
    assert ccgen("run", "bars.toml", at=tmp_path).returncode == 0


@pytest.mark.parametrize("place", ["build", "build/bars", "build/other", "build/bars/results"])
def test_results_do_not_take_the_places_of_models(place: str, ran: Path, tmp_path: Path) -> None:
    shutil.copytree(ran, tmp_path, dirs_exist_ok=True)
    before = content(tmp_path)
    done = ccgen("run", "bars.toml", "--out", place, at=tmp_path)
    assert done.returncode == 2 and f"--out {place}: found a place of a generated model" in done.stderr
    assert content(tmp_path) == before


@pytest.mark.skipif(not Path("/proc/self").is_dir(), reason="no file system here that takes no files")
def test_a_folder_that_takes_no_files_is_refused_before_anything_is_done(tmp_path: Path) -> None:
    (tmp_path / "bars.toml").write_text(SCENE)
    done = ccgen("run", "bars.toml", "--out", "/proc/results", at=tmp_path)
    assert done.returncode == 2 and "--out /proc/results: found " in done.stderr and "in /proc" in done.stderr
    assert "Errno" not in done.stderr and list(content(tmp_path)) == ["bars.toml"]


@pytest.mark.hard
def test_a_picture_of_a_torque_replaces_such_pictures_alone(tmp_path: Path) -> None:
    (tmp_path / "bars.toml").write_text(SCENE.replace("links = 2", "links = 1") + "[gravity]\n")
    command = ("torque", "bars.toml", "joint_0", "--plot", "torque.png")
    for _ in range(2):
        done = ccgen(*command, at=tmp_path)
        assert done.returncode == 0, done.stderr
    (tmp_path / "torque.png").write_bytes(b"\x89PNG mine")
    before = content(tmp_path)
    done = ccgen(*command, at=tmp_path)
    assert done.returncode == 2 and "--plot torque.png: found a file that ccgen did not write" in done.stderr
    assert content(tmp_path) == before


@pytest.mark.parametrize("name", ["cost.csv", "cost.png"])
def test_measurements_replace_nothing_of_others(name: str, ran: Path, tmp_path: Path) -> None:
    (tmp_path / name).write_text("mine")
    done = ccgen("cost", str(ran / "bars.toml"), "--out", ".", at=tmp_path)
    assert done.returncode == 2 and f"found the file {name}, which ccgen did not write" in done.stderr
    assert content(tmp_path) == {name: b"mine"}


def test_prices_replace_nothing_of_others(ran: Path, tmp_path: Path) -> None:
    (tmp_path / "effects.csv").write_text("mine")
    done = ccgen("cost", str(ran / "bars.toml"), "--effects", "--out", ".", at=tmp_path)
    assert done.returncode == 2 and "found the file effects.csv, which ccgen did not write" in done.stderr
    assert content(tmp_path) == {"effects.csv": b"mine"}


def test_make_clean_removes_what_was_made_alone(ran: Path, tmp_path: Path) -> None:
    shutil.copytree(ran, tmp_path, dirs_exist_ok=True)
    shutil.copy(ROOT / "Makefile", tmp_path)
    generate(loop(3), tmp_path / "build" / "listings")
    for sources in ("front", "generator", "templates", "runtime", "tests", "benchmarks"):
        (tmp_path / sources / "__pycache__").mkdir(parents=True)
    for place in ("build", "build/loop3-of-mine", "results", "results/bars", ".venv"):
        (tmp_path / place).mkdir(exist_ok=True)
        (tmp_path / place / "notes.txt").write_text("mine")
    command = ["make", "clean", f"BIN={Path(sys.executable).parent}"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 0, done.stderr
    left = sorted(path for path in content(tmp_path) if path not in ("Makefile", "bars.toml"))
    mine = [f"{place}/notes.txt" for place in (".venv", "build/loop3-of-mine", "build", "results/bars", "results")]
    assert left == mine
    for path in (".venv", *mine[1:]):
        assert f"left: {path}, which " in done.stdout
    assert not (tmp_path / "build" / "bars").exists() and not (tmp_path / "build" / "listings").exists()
