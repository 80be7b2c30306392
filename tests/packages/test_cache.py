"""Nothing is derived or compiled twice, two builds at once do no harm, and nothing is left half written."""

from __future__ import annotations

import dataclasses
import json
import platform
import re
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ccgen.generator import CompileError, OutputError, Scene, generate, load_scene, loop
from ccgen.generator.compile import compiler
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


def test_what_is_compiled_is_kept_by_its_bytes(cache: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A package that is made anew of the same C starts no compiler; one of other C does, and so does a damaged step."""
    started: list[tuple[str, ...]] = []
    run = compiler._run

    def told(command: tuple[str, ...], folder: Path, what: str) -> None:
        started.append(command)
        run(command, folder, what)

    monkeypatch.setattr(compiler, "_run", told)
    generate(bars(tmp_path), tmp_path / "first")
    assert len(started) == 5  # Cython, three sources, the linker
    shutil.rmtree(cache / "models")
    generate(bars(tmp_path), tmp_path / "second")
    assert (len(started) == 6 and "-shared" in started[-1]) or "-bundle" in started[-1]
    (kept, *_) = sorted((cache / "steps").iterdir())
    kept.write_bytes(kept.read_bytes()[:-1])
    shutil.rmtree(cache / "models")
    generate(bars(tmp_path), tmp_path / "third")
    assert len(started) == 8
    assert load_model(tmp_path / "third" / "bars").links == ("link_0", "link_1")
    before = len(started)
    generate(bars(tmp_path, g=1.0), tmp_path / "third")
    assert len(started) > before + 1


def test_cython_runs_once_for_all_scenes(cache: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Models of other names and other equations share one binding in C, and each hands over its own descriptor."""
    started: list[str] = []
    run = compiler._run

    def told(command: tuple[str, ...], folder: Path, what: str) -> None:
        started.append(what)
        run(command, folder, what)

    monkeypatch.setattr(compiler, "_run", told)
    scenes = [bars(tmp_path), loop(4)]
    models = [load_model(generate(scene, tmp_path / "build")) for scene in scenes]
    assert started.count("Cython") == 1
    assert [len(model.links) for model in models] == [2, 4]
    assert [model.acceleration(*model.start()).shape for model in models] == [(2,), (6,)]


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


def cut(file: Path) -> None:
    file.write_bytes(file.read_bytes()[: file.stat().st_size // 2])


def cut_to_a_page(file: Path) -> None:
    file.write_bytes(file.read_bytes()[:3000])


def empty(file: Path) -> None:
    file.write_bytes(b"")


def flip(file: Path) -> None:
    """Other bytes in the middle, where the code of an extension is; the size stays."""
    content = bytearray(file.read_bytes())
    middle = len(content) // 2
    content[middle : middle + 400] = bytes(byte ^ 0xFF for byte in content[middle : middle + 400])
    file.write_bytes(content)


def remove(file: Path) -> None:
    file.unlink()


DAMAGES = [
    *((damage, "_model_*.so") for damage in (cut, cut_to_a_page, empty, flip, remove)),
    *((damage, "model.json") for damage in (cut, empty, flip, remove)),
    *((damage, "build.json") for damage in (cut, empty, flip, remove)),
]


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a cache that holds one model, and ``build/bars``, a copy of that."""
    folder = tmp_path_factory.mktemp("whole")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("CCGEN_CACHE_DIR", str(folder / "cache"))
        generate(bars(folder), folder / "build")
    return folder


@pytest.fixture
def copied(whole: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A copy of ``whole``; its cache is the cache."""
    shutil.copytree(whole, tmp_path, dirs_exist_ok=True)
    (tmp_path / "cache").chmod(0o700)
    monkeypatch.setenv("CCGEN_CACHE_DIR", str(tmp_path / "cache"))
    return tmp_path


def contents(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir()}


@pytest.mark.parametrize(
    ("damage", "part"), [*DAMAGES, (empty, "model.c"), (remove, "equations.txt"), (remove, ".key")]
)
def test_a_damaged_package_is_fetched_again(damage: Callable[[Path], None], part: str, copied: Path) -> None:
    package = copied / "build" / "bars"
    before = contents(package)
    damage(next(package.glob(part)))
    assert "derive" not in stages(bars(copied), copied / "build")
    assert contents(package) == before


@pytest.mark.parametrize(("damage", "part"), [(flip, "model.c"), (cut, "equations.txt")])
def test_a_text_that_is_not_as_written_may_be_somebodys_work(
    damage: Callable[[Path], None], part: str, copied: Path
) -> None:
    damage(copied / "build" / "bars" / part)
    before = contents(copied / "build" / "bars")
    with pytest.raises(OutputError, match=f"bars: found {part} in the package changed since ccgen wrote it"):
        generate(bars(copied), copied / "build")
    assert contents(copied / "build" / "bars") == before


@pytest.mark.parametrize(("damage", "part"), [(flip, "_model_*.so"), (cut, "model.json"), (empty, "*")])
def test_a_damaged_cache_is_built_again(damage: Callable[[Path], None], part: str, copied: Path) -> None:
    (stored,) = (copied / "cache" / "models").iterdir()
    before = contents(stored)
    for file in stored.glob(part):
        damage(file)
    assert "derive" in stages(bars(copied), copied / "elsewhere")
    assert contents(stored) == before
    assert contents(copied / "elsewhere" / "bars") == before


@pytest.mark.parametrize(("damage", "part"), DAMAGES)
def test_a_damaged_package_is_not_loaded(damage: Callable[[Path], None], part: str, copied: Path) -> None:
    package = copied / "build" / "bars"
    damage(next(package.glob(part)))
    with pytest.raises(ImportError, match=f"{package}: the model cannot be loaded: its .*; generate it again"):
        load_model(package)
    code = f"import sys; sys.path.insert(0, {str(package.parent)!r}); import bars"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 1
    assert f"ImportError: {package}: the model cannot be loaded: its " in done.stderr.splitlines()[-1]


def rewritten(package: Path, change: Callable[[dict[str, Any]], None]) -> None:
    """The record of a package as another machine would have written it."""
    from ccgen.generator.package.parts import seal

    record = json.loads((package / "build.json").read_text())
    change(record)
    (package / "build.json").write_text(json.dumps(record | {"seal": seal(record)}))


def for_a_wider_processor(record: dict[str, Any]) -> None:
    record["processor"]["needs"].append("avx1024f")


def for_another_machine(record: dict[str, Any]) -> None:
    record["processor"]["machine"] = "pdp11"


def for_an_unknown_processor(record: dict[str, Any]) -> None:
    record["processor"] |= {"needs": None, "name": "Analytical Engine"}


def for_another_python(record: dict[str, Any]) -> None:
    record["extension"] = "_model_0123456789abcdef.cpython-27-vax-bsd.so"


def for_another_runtime(record: dict[str, Any]) -> None:
    record["contract"] = 0


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (for_a_wider_processor, "compiled for a processor with avx1024f, which this one has not"),
        (for_another_machine, "compiled for pdp11, and this machine is "),
        (for_an_unknown_processor, "compiled for 'Analytical Engine', and this processor is "),
        (for_another_python, "is one for another Python"),
        (for_another_runtime, "contract version 0, this runtime has "),
    ],
)
def test_a_foreign_package_is_not_loaded(change: Callable[[dict[str, Any]], None], told: str, copied: Path) -> None:
    package = copied / "build" / "bars"
    assert load_model(package).name == "bars"
    rewritten(package, change)
    with pytest.raises(ImportError, match=f"{package}: the model cannot be loaded: .*{told}.*generate it again"):
        load_model(package)


def test_a_package_without_hashes_is_not_loaded(copied: Path) -> None:
    package = copied / "build" / "bars"
    (package / "build.json").write_text('{"compiler": "cc", "flags": []}')
    with pytest.raises(ImportError, match="has no hashes of its parts"):
        load_model(package)
    stages(bars(copied), copied / "build")
    assert load_model(package).name == "bars"


def test_a_package_says_what_the_compiler_may_use(copied: Path) -> None:
    """What -march=native gives is here; what is asked for beyond that is told, by the names of the kernel."""
    from ccgen.generator.compile.compiler import find_compiler
    from ccgen.generator.compile.processor import processor
    from ccgen.runtime.loading.processor import unfit

    record = json.loads((copied / "build" / "bars" / "build.json").read_text())
    assert unfit(record["processor"]) == ""
    if platform.machine() != "x86_64" or not Path("/proc/cpuinfo").exists():
        pytest.skip("needs an x86-64 under Linux")
    command = find_compiler().command
    baseline, wide = (processor(command, [f"-march={name}"])["needs"] for name in ("x86-64", "x86-64-v4"))
    assert baseline == []
    assert isinstance(wide, list) and {"avx2", "fma", "bmi1", "abm", "pni", "avx512f", "avx512vl"} <= set(wide)
    flags = set(re.findall(r"^flags\s*: (.*)", Path("/proc/cpuinfo").read_text(), re.MULTILINE)[0].split())
    assert set(record["processor"]["needs"]) <= flags
    told = unfit({"machine": "x86_64", "name": "", "needs": wide})
    assert all((feature in told) == (feature not in flags) for feature in ("avx2", "avx512f", "avx512vl"))


def test_checking_a_package_costs_less_than_a_millisecond(copied: Path) -> None:
    from ccgen.runtime.loading.package import read_package

    def once() -> float:
        begin = time.perf_counter()
        read_package(copied / "build" / "bars")
        return time.perf_counter() - begin

    assert min(once() for _ in range(50)) < 1e-3


def test_a_reader_never_fails_while_others_replace_the_package(copied: Path) -> None:
    """Two models take turns at one place, put there by two processes; 150 readers get one or the other, whole."""
    scene, folded = bars(copied), copied / "folded"
    generate(scene, folded, fold=True)  # both are in the cache then
    write = (
        "import sys, pathlib; from ccgen.generator import generate, load_scene\n"
        "scene = load_scene('bars.toml')\n"
        "while not pathlib.Path('enough').exists():\n"
        "    for fold in (True, False): generate(scene, 'build', fold=fold)\n"
        "    pathlib.Path(f'writing{sys.argv[1]}').touch()\n"
    )
    read = (
        "import sys; sys.path.insert(0, 'build')\n"
        "from ccgen.runtime import load_model\n"
        "found = [load_model('build/bars') for _ in range(30)]\n"
        "import bars\n"
        "print(len(found), sorted({model.folded for model in found}), bars.model.name)\n"
    )

    def start(code: str, number: int) -> subprocess.Popen[str]:
        pipes: Any = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
        return subprocess.Popen([sys.executable, "-c", code, str(number)], cwd=copied, **pipes)

    writers = [start(write, number) for number in range(2)]
    while len(list(copied.glob("writing*"))) < 2:
        assert all(writer.poll() is None for writer in writers)
        time.sleep(0.05)
    readers = [start(read, number) for number in range(5)]
    results = [reader.communicate(timeout=240) for reader in readers]
    (copied / "enough").write_text("")
    ends = [writer.communicate(timeout=60) for writer in writers]
    assert [writer.returncode for writer in writers] == [0, 0], ends
    assert [reader.returncode for reader in readers] == [0] * 5, results
    assert {out.split()[0] + out.split()[-1] for out, _ in results} == {"30bars"}
    assert any("[False, True]" in out for out, _ in results), "no reader met a replacement"
    assert entries(copied / "build") == ["bars"]


def test_folders_change_places_without_the_system_s_help(copied: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from ccgen.generator.package import replace

    monkeypatch.setattr(replace, "_swapped", lambda one, other: False)
    before = contents(copied / "build" / "bars")
    generate(bars(copied), copied / "build", fold=True)
    assert contents(copied / "build" / "bars")["model.c"] != before["model.c"]
    generate(bars(copied), copied / "build")
    assert contents(copied / "build" / "bars") == before
    assert entries(copied / "build") == ["bars"]


def test_what_killed_builds_leave_is_cleaned_away(copied: Path) -> None:
    """Of a build that goes on nothing is."""
    from ccgen.generator.package.replace import staging

    code = (
        "import os, signal; from ccgen.generator import generate, load_scene\n"
        "end = lambda stage: stage == 'compile' and os.kill(os.getpid(), signal.SIGKILL)\n"
        "generate(load_scene('bars.toml'), progress=end)\n"
    )
    models = copied / "cache" / "models"
    bars(copied, g=2.0)
    done = subprocess.run([sys.executable, "-c", code], cwd=copied, timeout=120, check=False)
    assert done.returncode == -signal.SIGKILL
    assert len(entries(models)) == 2
    with staging(models, own=True) as alive, staging(copied / "build") as alive_too:
        (alive / "model.c").write_text("")
        (copied / "build" / ".ccgen-00000000").mkdir()
        (copied / "build" / ".ccgen-00000000" / "model.c").write_text("")
        (copied / "build" / ".ccgen-mine").mkdir()
        (copied / "build" / ".ccgen-mine" / "notes.txt").write_text("mine")
        generate(bars(copied, g=3.0), copied / "build")
        assert (alive / "model.c").exists() and alive_too.exists()
        assert len(entries(models)) == 3
        assert entries(copied / "build") == sorted([".ccgen-mine", alive_too.name, "bars"])


def test_a_new_cache_is_the_user_s_alone(cache: Path, tmp_path: Path) -> None:
    with pytest.raises(ZeroDivisionError):
        generate(bars(tmp_path), tmp_path / "build", lambda stage: stage == "derive" and 1 / 0)
    assert cache.stat().st_mode & 0o777 == 0o700


def test_a_cache_that_everybody_can_write_to_is_refused(copied: Path) -> None:
    (copied / "cache").chmod(0o777)
    with pytest.raises(OutputError, match=f"{copied / 'cache'}: found a cache that everybody can write to"):
        generate(bars(copied), copied / "elsewhere")
    assert not (copied / "elsewhere").exists()


def test_a_full_disk_is_told(copied: Path) -> None:
    """No file may grow beyond 10 kB: the system then says what it says, not None."""
    code = (
        "import resource; from ccgen.generator import generate, load_scene\n"
        "scene = load_scene('bars.toml')\n"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (10000, 10000))\n"
        "generate(scene, 'full')\n"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=copied, capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert re.search(r"OutputError: full: cannot be written \(File too large\)", done.stderr), done.stderr
    assert entries(copied / "full") == []


def test_a_name_too_long_for_the_file_system_is_refused_at_once(cache: Path, tmp_path: Path) -> None:
    scene, told = dataclasses.replace(loop(3), name="a" * 300), list[str]()
    with pytest.raises(OutputError, match="found a name of 300 characters for a folder in it, expected at most 255"):
        generate(scene, tmp_path / "build", told.append)
    assert "derive" not in told


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
