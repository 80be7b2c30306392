"""``until=0``: the row of the start, from which a run goes on as one that was not cut."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ccgen.generator import load_scene
from ccgen.runtime import ensemble, sensitivities, simulate

from ..support.folders import ROOT
from ..support.workshop import Workshop

EVENT = '[[event]]\nname = "fast"\nwhen = "rate(direction(crank))"\n'
SCENES = {
    "loop": (ROOT / "scenes" / "four-bar.toml").read_text(encoding="utf-8"),
    "contacts": (ROOT / "scenes" / "falling-hexagon.toml").read_text(encoding="utf-8"),
    "switching": (ROOT / "scenes" / "trebuchet.toml").read_text(encoding="utf-8"),
    "events": (ROOT / "scenes" / "four-bar.toml").read_text(encoding="utf-8") + EVENT,
}


@pytest.mark.parametrize("case", SCENES)
@pytest.mark.parametrize("method", ["gauss", "dop853", "dopri5", "radau", "moreau"])
def test_a_run_of_no_time_is_the_start(case: str, method: str, workshop: Workshop) -> None:
    model = workshop.model(SCENES[case])
    step = {"step": 0.001} if method == "moreau" else {}
    run = simulate(model, until=0, method=method, **step)
    longer = simulate(model, until=0.01, method=method, **step)
    assert run.success and run.message == "reached t = 0 s"
    assert run.t.tolist() == [0.0] and not len(run.impacts)
    assert np.array_equal(run.q[0], longer.q[0]) and np.array_equal(run.u[0], longer.u[0])
    on = simulate(model, state=run.state, until=0.01)
    assert np.array_equal(on.q[-1], longer.q[-1]) and np.array_equal(on.u[-1], longer.u[-1])


@pytest.mark.parametrize("case", SCENES)
def test_all_that_a_run_has_is_there(case: str, workshop: Workshop, tmp_path: Path) -> None:
    model = workshop.model(SCENES[case])
    run = simulate(model, until=0.0)
    q, u = run.at(0.0)
    assert np.array_equal(q, run.q[0]) and np.array_equal(u, run.u[0])
    assert run.reactions(0.0).shape == np.asarray(simulate(model, until=0.01).reactions(0.0)).shape
    assert len(run["kinetic_energy"]) == 1
    run.plot(tmp_path / "plot.png")
    run.save(tmp_path / "run.npz")
    assert (tmp_path / "plot.png").stat().st_size and (tmp_path / "run.npz").stat().st_size


def test_single_rows_are_dots(workshop: Workshop) -> None:
    """A line through one point is not seen; every curve of one row has a mark."""
    figure: Any = simulate(workshop.model(SCENES["loop"]), until=0.0).plot()
    lines = [line for axes in figure.axes for line in axes.lines if list(line.get_xdata()) == [0.0]]
    assert len(lines) >= 8 and all(line.get_marker() not in (None, "", "None") for line in lines)
    assert "constant" not in " ".join(text.get_text() for axes in figure.axes for text in axes.texts)


def test_many_runs_and_derivatives_of_no_time(workshop: Workshop) -> None:
    """The end is the start: of a chain its speeds are those given."""
    model = workshop.model(load_scene(ROOT / "scenes" / "open-chain.toml"), derivatives=True)
    q, u = model.start()
    many = ensemble(model, q0=np.array([q, q]), observe=["kinetic_energy"], until=0)
    assert many["kinetic_energy"] == pytest.approx([simulate(model, until=0)["kinetic_energy"][0]] * 2, rel=1e-15)
    assert sensitivities(model, ["u0"], ["u"], until=0).jacobian == pytest.approx(np.eye(len(u)), abs=1e-15)
    assert not sensitivities(model, ["u0"], ["q"], until=0).jacobian.any()


@pytest.mark.parametrize("case", ["loop", "switching", "events"])
@pytest.mark.parametrize("until", [-1.0, float("nan"), float("inf"), True, "0"])
def test_other_ends_are_refused(case: str, until: Any, workshop: Workshop) -> None:
    with pytest.raises((ValueError, TypeError), match=r"until: found .*, expected a positive number"):
        simulate(workshop.model(SCENES[case]), until=until)
