"""Draws the basins of the ball on a shaken table: ``python docs/scripts/basin.py``.

It writes docs/images/bouncing-table.png. The scene is the one of docs/howto/many-runs.md;
tests/ensemble/test_known_maps.py compares such a map with the exact one.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure

from ccgen.generator import generate, load_scene
from ccgen.runtime import ensemble, load_model

DOCS = Path(__file__).parents[1]
PAGE, PICTURE = DOCS / "howto" / "many-runs.md", DOCS / "images" / "bouncing-table.png"
NAME = "bouncing-table"
COUNT = 121


def main() -> None:
    """Make the runs and draw where each begins, in the colour of what it comes to."""
    scene = next(one for one in PAGE.read_text().split("```toml\n") if one.startswith(f'name = "{NAME}"'))
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / f"{NAME}.toml"
        file.write_text(scene.partition("```")[0])
        model = load_model(generate(load_scene(file), Path(folder) / "build"))
    gaps, speeds = np.linspace(0.002, 0.122, COUNT), np.linspace(-1.0, 1.0, COUNT)
    gap, speed = (grid.ravel() for grid in np.meshgrid(gaps, speeds, indexing="ij"))
    q0, u0 = np.zeros((2, gap.size, 2))
    q0[:, 1], u0[:, 0], u0[:, 1] = 0.01 + gap, 0.013 * 10.0 * np.pi, speed
    end = ensemble(model, q0=q0, u0=u0, observe=["q"])["q"][:, 1] - 0.01
    figure = Figure(figsize=(6.4, 4.2), dpi=110, layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    colours = ListedColormap(["#e8e2d4", "#35618f"])
    axes.pcolormesh(speeds, 100.0 * gaps, end.reshape(COUNT, COUNT) > 0.01, cmap=colours, shading="nearest")
    axes.set_xlabel("speed of the ball at the start, m/s")
    axes.set_ylabel("gap at the start, cm")
    axes.set_title("blue: it bounces once a period; grey: it rests, period after period", fontsize=10)
    figure.savefig(PICTURE, metadata={"Software": "ccgen"})


if __name__ == "__main__":
    main()
