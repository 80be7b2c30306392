"""What folding saves: operations of all functions and of the acceleration, and its time (docs/counts.md).

Everything is solved from tip to root, which is the plan of all scenes here but the walking machine and the long ring.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import numpy as np

from ccgen.generator import Scene, generate, load_scene, loop
from ccgen.generator.pipeline import derive_scene
from ccgen.generator.planning.choose import TIP_TO_ROOT
from ccgen.generator.program.program import lower
from ccgen.runtime import load_model, simulate
from ccgen.runtime.cost.timing import evaluation_times, price

SCENES = Path(__file__).resolve().parents[2] / "scenes"


def operations(scene: Scene, fold: bool) -> tuple[int, int]:
    """Those of all functions together, and of the acceleration."""
    program = lower(derive_scene(scene, fold, TIP_TO_ROOT)[1])
    return sum(f.counts().total for f in program.functions), program.function("acceleration").counts().total


def main() -> None:
    print("| scene | all operations | folded | acceleration | folded | ns | folded | change |")
    print("|---|---:|---:|---:|---:|---:|---:|---:|")
    files = [SCENES / f"{name}.toml" for name in sys.argv[1:]]
    scenes = [load_scene(file) for file in files or sorted(SCENES.glob("*.toml"))]
    for scene in scenes if files else [*scenes, loop(24, gravity=True)]:
        plain, folded = operations(scene, False), operations(scene, True)
        with tempfile.TemporaryDirectory() as folder:
            models = [
                load_model(generate(scene, Path(folder) / str(fold), fold=fold, plan=TIP_TO_ROOT))
                for fold in (False, True)
            ]
        times = 1e9 * evaluation_times(models, simulate(models[0], until=min(1.0, scene.run.until)), 1000)
        found = price(*times)
        cells = (plain[0], folded[0], plain[1], folded[1], f"{found.without:.1f}", f"{found.with_:.1f}")
        change = f"{100 * found.added / np.median(times[0]):+.1f} ± {100 * found.spread / np.median(times[0]):.1f} %"
        print("| " + " | ".join(map(str, (scene.name, *cells, change))) + " |", flush=True)


if __name__ == "__main__":
    main()
