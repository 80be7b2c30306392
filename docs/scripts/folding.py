"""What folding saves: operations of all functions and of the acceleration, and its time (docs/counts.md)."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np

from ccgen.generator import Scene, generate, load_scene, loop
from ccgen.generator.pipeline import derive_scene
from ccgen.generator.program.program import lower
from ccgen.runtime import load_model, simulate
from ccgen.runtime.cost.timing import evaluation_times, price

SCENES = Path(__file__).resolve().parents[2] / "scenes"


def operations(scene: Scene, fold: bool) -> tuple[int, int]:
    """Those of all functions together, and of the acceleration."""
    program = lower(derive_scene(scene, fold)[1])
    return sum(f.counts().total for f in program.functions), program.function("acceleration").counts().total


def main() -> None:
    print("| scene | all operations | folded | acceleration | folded | ns | folded | change |")
    print("|---|---:|---:|---:|---:|---:|---:|---:|")
    scenes = [load_scene(file) for file in sorted(SCENES.glob("*.toml"))] + [loop(24, gravity=True)]
    for scene in scenes:
        plain, folded = operations(scene, False), operations(scene, True)
        with tempfile.TemporaryDirectory() as folder:
            models = [load_model(generate(scene, Path(folder) / str(fold), fold=fold)) for fold in (False, True)]
        times = 1e9 * evaluation_times(models, simulate(models[0], until=min(1.0, scene.run.until)), 1000)
        found = price(*times)
        cells = (plain[0], folded[0], plain[1], folded[1], f"{found.without:.1f}", f"{found.with_:.1f}")
        change = f"{100 * found.added / np.median(times[0]):+.1f} ± {100 * found.spread / np.median(times[0]):.1f} %"
        print("| " + " | ".join(map(str, (scene.name, *cells, change))) + " |", flush=True)


if __name__ == "__main__":
    main()
