"""The falling hexagon against digits that two independent programs agree on to 3e-15 s."""

from __future__ import annotations

import tempfile
from pathlib import Path

from ccgen.generator import generate, load_scene
from ccgen.runtime import load_model, simulate

TIMES = (0.4515236409857, 0.5497839476458, 0.7701908095116, 0.9241375542824, 0.9461333789875, 0.9512380368467)
IMPULSES = (7.3085874148, 16.9704401049, 2.8748494802, 2.1441771281, 15.8650497918, 3.1062090704)
SCENE = Path(__file__).parents[2] / "scenes" / "falling-hexagon.toml"


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        model = load_model(generate(load_scene(SCENE), folder))
        for rtol in (1e-8, 1e-10, 1e-12):
            run = simulate(model, rtol=rtol)
            known = list(zip(run.impacts, TIMES, IMPULSES, strict=False))
            time = max(abs(impact.t - t) for impact, t, _ in known)
            impulse = max(abs(impact.impulses[0] / p - 1.0) for impact, _, p in known)
            print(
                f"rtol {rtol:.0e}: times to {time:.1e} s, impulses to {impulse:.1e} (relative), "
                f"energy drift {run.energy_drift:.1e} J of 117.72 J, closure {run.closure_max:.1e} m, "
                f"{run.nfev} evaluations"
            )


if __name__ == "__main__":
    main()
