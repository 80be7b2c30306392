"""``make``'s environment: ccgen, editable, into the Python that runs this, with a line every few seconds.

The packages that it needs are fetched and installed while its core is compiled.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
import tomllib
from pathlib import Path
from typing import IO

ROOT = Path(__file__).resolve().parent.parent
SAID_EVERY = 5.0
PIP = (sys.executable, "-m", "pip", "--disable-pip-version-check", "install", "--quiet")


class Job:
    """A command that runs, and what it prints."""

    def __init__(self, name: str, *command: str) -> None:
        self.name = name
        self.printed: IO[bytes] = tempfile.TemporaryFile()  # noqa: SIM115 - open as long as the job is known
        self.process = subprocess.Popen(command, cwd=ROOT, stdout=self.printed, stderr=subprocess.STDOUT)

    def text(self) -> str:
        """What it has printed until now; where in the file it writes next is left alone, as that is one place for both
        processes."""
        file = self.printed.fileno()
        return os.pread(file, os.fstat(file).st_size, 0).decode(errors="replace")

    def state(self) -> str:
        """Its name, and the last that it said of how far it is."""
        said = [line for line in self.text().splitlines() if line.startswith("the core: ")]
        return said[-1] if said else self.name


def wait(began: float, *jobs: Job) -> None:
    """Until all have ended; the first that fails ends the program, with what it printed."""
    said = time.monotonic()
    running = list(jobs)
    try:
        while running:
            time.sleep(0.1)
            for job in [job for job in running if job.process.poll() is not None]:
                running.remove(job)
                if job.process.returncode:
                    raise SystemExit(f"{job.text().strip()}\n{job.name}: failed")
            if running and time.monotonic() - said > SAID_EVERY:
                said = time.monotonic()
                print(f"  {said - began:3.0f} s  {'; '.join(job.state() for job in running)}", flush=True)
    finally:
        for job in running:
            job.process.terminate()
            job.process.wait()


def main() -> None:
    """What building needs; then packages and core beside each other; then ccgen itself."""
    began = time.monotonic()
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    wait(began, Job("what building needs is installed", *PIP, *project["build-system"]["requires"]))
    wait(
        began,
        Job("packages are installed", *PIP, *project["project"]["dependencies"]),
        Job("the core is compiled", sys.executable, "setup.py", "-q", "build_ext", "--inplace"),
    )
    wait(began, Job("ccgen is installed", *PIP, "--no-deps", "--no-build-isolation", "-e", "."))
    print(f"installed in {time.monotonic() - began:.0f} s", flush=True)


if __name__ == "__main__":
    main()
