"""Pictures of the scenes of mechanisms (docs/mechanisms.md)."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from ccgen.generator import generate, load_scene
from ccgen.runtime import Model, driving_torque, load_model, simulate
from ccgen.runtime.pictures.frames import placed

ROOT = Path(__file__).parents[2]
IMAGES = ROOT / "docs" / "images"
TRACES = {
    "n-four-bar": (("upright_0.B",), 2.4),
    "jansen-leg": (("shin.F",), 1.25),
    "parallelogram": (("crank.B", "rocker.B"), 0.6),
    "closed-pendulum": (("rod_3.B",), 1.6),
    "flyer": (("body.T", "left_hand.B", "right_hand.B"), 1.2),
    "four-bar": (("coupler.tip",), 0.7),
    "slider-crank": (("rod.middle",), 0.5),
    "equal-length-slider-crank": (("rod.A", "rod.B"), 0.8),
    "quick-return": (("lever.D", "ram.tool"), 0.6),
    "newtons-cradle": (("ball_0.centre", "ball_4.centre"), 0.46),
    "loose-slider-crank": (("crank.pin", "rod.small_end", "slider.pin"), 0.21),
    "cam-follower": (("rocker.P", "rocker.T"), 0.03),
    "massless-coupler": (("coupler.A", "coupler.B"), 0.6),
}
"""Points whose paths are drawn, and until when (s)."""


def picture(name: str, folder: Path) -> None:
    """Some poses of a run, later ones darker, and the paths of points."""
    from matplotlib.figure import Figure

    model = load_model(generate(load_scene(ROOT / "scenes" / f"{name}.toml"), folder))
    points, until = TRACES[name]
    run = simulate(model, until=until)
    states = np.array([run.at(t)[0] for t in np.linspace(0.0, until, 400)])
    figure = Figure(figsize=(4.2, 3.6), dpi=90, layout="constrained")
    axes = figure.subplots()
    for point in points:
        axes.plot(*model.point(point, states).T, color="#d55e00", linewidth=0.9)
    shown = states[np.linspace(0, 399, 6).astype(int)]
    for index, q in enumerate(shown):
        draw(axes, model, q, 0.15 + 0.75 * (index == len(shown) - 1))
    axes.set_aspect("equal")
    axes.set_title(f"{name}, 0 to {until:g} s", fontsize=9)
    axes.tick_params(labelsize=7)
    figure.savefig(IMAGES / f"{name}.png", metadata={"Software": None})


def walker(folder: Path) -> None:
    """The Strandbeest at its start, and the paths of its feet over a turn of the shaft as the body sees them."""
    from matplotlib.figure import Figure

    model = load_model(generate(load_scene(ROOT / "scenes" / "strandbeest.toml"), folder))
    run = simulate(model, until=1.2)
    states = np.array([run.at(t)[0] for t in np.linspace(0.0, 1.2, 400)])
    body = model.poses(states)[:, 0]
    figure = Figure(figsize=(6.4, 3.6), dpi=90, layout="constrained")
    axes = figure.subplots()
    for suffix in ("l0", "r0", "l1", "r1"):
        x, y = (model.point(f"shin_{suffix}.F", states) - body[:, :2]).T
        seen = (x + 1j * y) * np.exp(-1j * body[:, 2])
        axes.plot(seen.real, seen.imag, color="#d55e00", linewidth=0.9)
    draw(axes, model, states[0], 0.9)
    axes.set_aspect("equal")
    axes.set_title("strandbeest at 0 s; its feet as the body sees them", fontsize=9)
    axes.tick_params(labelsize=7)
    figure.savefig(IMAGES / "strandbeest.png", metadata={"Software": None})


def draw(axes: Any, model: Model, q: np.ndarray, strength: float) -> None:
    """The links at ``q``: the outline of their named points, and their discs."""
    for k, (x, y, angle) in enumerate(model.poses(q)):
        outline = model.outlines[k] @ np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
        corners = np.vstack([outline, outline[:1]]) + np.array([x, y])
        axes.plot(*corners.T, color="#4477aa", alpha=strength, linewidth=1.6, marker="o", markersize=2)
        for disc in model.discs:
            if disc.link == k:
                axes.plot(
                    *placed(disc.outline, np.array([x, y, angle])).T, color="#4477aa", alpha=strength, linewidth=1
                )


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        for name in TRACES:
            picture(name, Path(folder))
        walker(Path(folder))
        leg = load_model(generate(load_scene(ROOT / "scenes" / "jansen-leg.toml"), folder))
        driving_torque(leg, "axle", 1.0).plot(IMAGES / "jansen-leg-torque.png")


if __name__ == "__main__":
    main()
