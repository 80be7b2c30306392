"""What the regular path costs now against an earlier commit: accelerations, flights, a drop and a walk, in one run.

Both are installed from their commits and measured in turn, each in processes of its own. Prints a markdown table;
`python benchmarks/since.py --help` lists the options, README.md explains the rest.
"""

import argparse
import json
import os
import subprocess
import sys
from pathlib import Path

from driver import ROOT, WORK
from machine import machine

BEFORE = "92d0e1d"
"""The last commit without sustained contact, friction, singular configurations or repaired digits."""
LINKS = ("6", "24", "96")


def install(commit: str) -> tuple[Path, Path]:
    """A checkout of the commit, and a folder to import it from."""
    full = subprocess.run(
        ["git", "-C", str(ROOT), "rev-parse", "--verify", f"{commit}^{{commit}}"],
        capture_output=True,
        text=True,
        check=True,
    ).stdout.strip()
    place = WORK / "since" / full[:12]
    checkout, package = place / "checkout", place / "package"
    if not (package / "ccgen").exists():
        place.mkdir(parents=True, exist_ok=True)
        subprocess.run(["git", "clone", "--quiet", "--no-checkout", str(ROOT), str(checkout)], check=True)
        subprocess.run(["git", "-C", str(checkout), "checkout", "--quiet", full], check=True)
        pip = [sys.executable, "-m", "pip", "install", "--quiet", "--no-deps", "--target", str(package), str(checkout)]
        subprocess.run(pip, check=True)
    return checkout, package


def accelerations(checkout: Path, package: Path, rounds: int) -> dict[str, float]:
    """ns per acceleration of W(n), the least, by the commit's own forward_dynamics.py."""
    script = checkout / "benchmarks" / "forward_dynamics.py"
    output = python(package, str(script), "--links", *LINKS, "--rounds", str(rounds))
    rows = [[cell.strip() for cell in line.split("|")] for line in output.splitlines()]
    return {f"acceleration, n = {row[1]}, ns": float(row[2]) for row in rows if len(row) > 2 and row[1] in LINKS}


def runs(package: Path, rounds: int) -> dict[str, float]:
    """µs per run, the least, by since_runs.py."""
    script = ROOT / "benchmarks" / "since_runs.py"
    found: dict[str, float] = json.loads(python(package, str(script), str(package.parent / "models"), str(rounds)))
    return found


def python(package: Path, *arguments: str) -> str:
    """Output of a Python that imports ccgen from `package`."""
    environment = os.environ | {"PYTHONPATH": str(package)}
    command = [sys.executable, *arguments]
    return subprocess.run(command, env=environment, capture_output=True, text=True, check=True).stdout


def main() -> None:
    """Install both, measure them in turn, print the least of each and the ratios."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("before", nargs="?", default=BEFORE, metavar="COMMIT", help=f"before; {BEFORE} unless given")
    parser.add_argument("--now", default="HEAD", metavar="COMMIT", help="now; what is committed last unless given")
    parser.add_argument("--repeats", type=int, default=3, help="processes of each kind and commit")
    parser.add_argument("--rounds", type=int, default=200, help="runs or batches in each process")
    options = parser.parse_args()
    print(f"{machine()}, before: {options.before}\n")
    sides = [install(options.before), install(options.now)]
    least: list[dict[str, float]] = [{}, {}]
    for _ in range(options.repeats):
        for side, (checkout, package) in zip(least, sides, strict=True):
            found = accelerations(checkout, package, options.rounds) | runs(package, options.rounds)
            side.update({name: min(value, side.get(name, value)) for name, value in found.items()})
    print("| | before | now | ratio |\n|---|---|---|---|")
    for name, now in least[1].items():
        before = least[0].get(name)
        told = f"– | {now:.0f} | –" if before is None else f"{before:.0f} | {now:.0f} | {now / before:.2f}"
        print(f"| {name} | {told} |")


if __name__ == "__main__":
    main()
