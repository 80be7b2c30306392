"""The charts of docs/accuracy.md: `ccgen cost` on five scenes, the charts into docs/images.

Prints what `ccgen cost` recommends for each; `python docs/scripts/cost.py NAME` does one scene alone.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).parents[2]
ENDS = {"falling-hexagon": 0.95, "falling-ring": 10.0, "n-four-bar": 10.0, "jansen-leg": 5.0, "stiff-rocker": 2.0}
"""Scenes and the seconds of motion that are compared: the hexagon to its fifth impact."""
RUN = "from ccgen.generator.cli import main; main()"


def main() -> None:
    for name in sys.argv[1:] or ENDS:
        with tempfile.TemporaryDirectory() as folder:
            command = [sys.executable, "-c", RUN, "cost", str(ROOT / "scenes" / f"{name}.toml")]
            command += ["--until", str(ENDS[name]), "--out", folder]
            text = subprocess.run(command, cwd=folder, check=True, stdout=subprocess.PIPE, text=True).stdout
            shutil.copy(Path(folder) / "cost.png", ROOT / "docs" / "images" / f"cost-{name}.png")
        kept = [line for line in text.splitlines() if line.startswith(("reference", "growth", "horizon", "for "))]
        print("\n".join([f"{name}:", *kept, ""]), flush=True)


if __name__ == "__main__":
    main()
