"""The record of a run: what it accepts, what it says between its rows, and what it keeps."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ccgen.runtime.record.impact import Impact
from ccgen.runtime.record.joint_change import JointChange
from ccgen.runtime.record.phase import Phase
from ccgen.runtime.run import Run

from ..support.folders import ROOT
from ..support.rigid_polygon import G, PolygonModel, bouncing


@pytest.fixture(scope="module")
def run() -> Run:
    return bouncing()


def test_first_impact_is_that_of_a_free_fall(run: Run) -> None:
    assert len(run.impacts) == 4
    assert run.impacts[0].t == pytest.approx(np.sqrt(2 * 1.0 / G), abs=1e-14)
    assert run.impacts[0].contacts == (("joint_0", "ground_0"),)


def test_at_agrees_with_free_fall_between_rows(run: Run) -> None:
    model: Any = run.model
    start = model.point("joint_0", run.q[0])
    for t in (0.0, 0.013, 0.05, 0.2999, 0.45):
        q, u = run.at(t)
        assert q.shape == (8,) and u.shape == (8,)
        assert model.point("joint_0", q) == pytest.approx(start - [0, 0.5 * G * t**2], abs=1e-13)
        assert u[:2] == pytest.approx([0, -G * t], abs=1e-13)


def test_at_gives_recorded_rows_as_they_are(run: Run) -> None:
    single = [k for k in range(len(run.t)) if np.count_nonzero(run.t == run.t[k]) == 1]
    q, u = run.at(run.t[single])
    assert np.array_equal(q, run.q[single]) and np.array_equal(u, run.u[single])


def test_at_an_impact_is_after_it_and_just_before_is_before(run: Run) -> None:
    assert run.impacts
    for impact in run.impacts:
        q, u = run.at(impact.t)
        before, slow = run.at(impact.t - 1e-9)
        assert np.array_equal(u, impact.u_plus) and not np.array_equal(u, impact.u_minus)
        assert slow == pytest.approx(impact.u_minus, abs=1e-7)
        assert before == pytest.approx(q, abs=1e-7)


def test_at_steps_from_the_last_row_that_is_not_later(run: Run) -> None:
    asked: list[tuple[float, float]] = []

    class Spy:
        def between(self, t: float, times: Any, q: Any, u: Any) -> Any:
            asked.append((times[0], t - times[0]))
            assert np.array_equal(times, run.t[[k := int(np.flatnonzero(run.t == times[0])[-1]), k + 1]])
            assert np.array_equal(q, run.q[k : k + 2]) and np.array_equal(u, run.u[k : k + 2])
            return q[0], u[0]

    spied, impact = replace(run, advance=Spy()), run.impacts[0]
    spied.at(np.array([0.07, impact.t, impact.t + 0.001, run.t[-1]]))
    assert asked == [(run.t[1], pytest.approx(0.02)), (impact.t, pytest.approx(0.001))]


def test_at_takes_rows_in_any_order_and_leaves_the_record_alone(run: Run) -> None:
    q, u = run.at([0.8, 0.1, 0.8])
    assert q.shape == (3, 8) and np.array_equal(q[0], q[2]) and np.array_equal(u[1], run.at(0.1)[1])
    q[:] = u[:] = np.nan
    assert np.isfinite(run.q).all() and np.isfinite(run.u).all()
    assert run.at([])[0].shape == (0, 8)


@pytest.mark.parametrize("t", [-1e-9, 1.2500001, np.nan, [0.1, 99.0]])
def test_at_refuses_times_outside(run: Run, t: Any) -> None:
    with pytest.raises(ValueError, match=r"goes from t = 0\.0 to 1\.25"):
        run.at(t)


def test_at_refuses_tables_of_times(run: Run) -> None:
    with pytest.raises(ValueError, match="a number or a row"):
        run.at([[0.1, 0.2]])


FAULTS: list[tuple[Callable[[Run], dict[str, Any]], str]] = [
    (lambda run: {"t": run.t[::-1]}, "never decreases"),
    (lambda run: {"t": run.t[:0], "q": run.q[:0], "u": run.u[:0]}, "at least one"),
    (lambda run: {"q": run.q[:-1]}, r"q of a run has shape \(31, 8\), expected \(32, 8\)"),
    (lambda run: {"u": run.u[:, 1:]}, r"u of a run has shape \(32, 7\)"),
    (lambda run: {"q": np.where(run.q > 3, np.nan, run.q)}, "q of the run holds a number that is not finite"),
    (lambda run: {"impacts": run.impacts[::-1]}, "order of time"),
    (lambda run: {"impacts": (replace(run.impacts[0], t=0.31),)}, "none of the recorded times"),
    (lambda run: {"impacts": (replace(run.impacts[0], u_minus=np.ones(3), u_plus=np.ones(3)),)}, r"shape \(3,\)"),
    (lambda run: {"phases": (Phase("flight", 0, 1), Phase("flight", 1.5, 2))}, "start where the one before it ends"),
    (lambda run: {"closure_max": np.nan}, "audits"),
]


@pytest.mark.parametrize(("change", "sentence"), FAULTS)
def test_run_checks_itself(run: Run, change: Callable[[Run], dict[str, Any]], sentence: str) -> None:
    with pytest.raises(ValueError, match=sentence):
        replace(run, **change(run))


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"u_plus": np.zeros(7)}, "expected"),
        ({"impulses": np.zeros(2)}, "1 contacts and impulses of shape"),
        ({"contacts": (), "impulses": np.zeros(0)}, "0 contacts"),
        ({"u_minus": np.full(8, np.inf)}, "not finite"),
        ({"energy_loss": np.nan}, "energy loss nan"),
    ],
)
def test_impact_checks_itself(run: Run, change: dict[str, Any], sentence: str) -> None:
    with pytest.raises(ValueError, match=sentence):
        replace(run.impacts[0], **change)


def test_phase_checks_itself() -> None:
    with pytest.raises(ValueError, match="'rest'"):
        Phase("rest", 0.0, 1.0)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match=r"from 1\.0 to 0\.5"):
        Phase("flight", 1.0, 0.5)


def test_records_are_frozen_down_to_their_numbers(run: Run) -> None:
    with pytest.raises(AttributeError):
        run.success = False  # type: ignore[misc]
    for array in (run.t, run.q, run.u, run.impacts[0].impulses):
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 0.0


def test_saved_file_holds_everything(run: Run, tmp_path: Path) -> None:
    two = replace(
        run.impacts[0], contacts=(("joint_0", "ground_0"), ("link_1.B", "wall")), impulses=np.array([1.0, 2.0])
    )
    run = replace(run, impacts=(two, *run.impacts[1:]), message="wörds")
    with np.load(run.save(tmp_path / "result.npz"), allow_pickle=False) as file:
        kept = dict(file)
    for name in ("t", "q", "u"):
        assert np.array_equal(kept[name], getattr(run, name))
    for k, impact in enumerate(run.impacts):
        own = slice(*kept["impact_offsets"][k : k + 2])
        assert tuple(zip(kept["impact_points"][own], kept["impact_grounds"][own], strict=True)) == impact.contacts
        assert np.array_equal(kept["impact_impulses"][own], impact.impulses)
        rebuilt = Impact(
            float(kept["impact_t"][k]),
            impact.contacts,
            kept["impact_u_minus"][k],
            kept["impact_u_plus"][k],
            kept["impact_impulses"][own],
            float(kept["impact_energy_loss"][k]),
        )
        assert rebuilt.t == impact.t and rebuilt.energy_loss == impact.energy_loss
        assert np.array_equal(rebuilt.u_minus, impact.u_minus) and np.array_equal(rebuilt.u_plus, impact.u_plus)
    phases = zip(kept["phase_kinds"], kept["phase_starts"], kept["phase_ends"], strict=True)
    assert tuple(Phase(str(kind), float(start), float(end)) for kind, start, end in phases) == run.phases  # type: ignore[arg-type]
    assert tuple(kept["q_names"]) == run.model.q_names and tuple(kept["u_names"]) == run.model.u_names
    assert dict(zip(kept["parameter_names"], kept["parameter_values"], strict=True)) == run.model.parameters
    facts = ("success", "message", "nfev", "method", "drift", "closure_max", "closure_rate_max")
    facts = (*facts, "energy_drift", "acceleration_error")
    assert [kept[name].item() for name in facts] == [getattr(run, name) for name in facts]
    assert (kept["format"].item(), kept["format_version"].item(), kept["model"].item()) == (
        "ccgen run",
        1,
        "stiff-hexagon",
    )


def test_run_without_impacts_is_saved_too(tmp_path: Path) -> None:
    run = bouncing(until=0.2)
    assert not run.impacts
    with np.load(run.save(tmp_path / "a.npz"), allow_pickle=False) as kept:
        assert kept["impact_u_minus"].shape == (0, 8) and list(kept["impact_offsets"]) == [0]


def test_saving_twice_gives_equal_bytes_and_leaves_nothing_else(run: Run, tmp_path: Path) -> None:
    first = run.save(tmp_path / "a.npz").read_bytes()
    again = bouncing().save(tmp_path / "a.npz").read_bytes()
    assert first == again and [path.name for path in tmp_path.iterdir()] == ["a.npz"]


def test_a_failed_save_keeps_the_old_file(run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    target = tmp_path / "a.npz"
    target.write_bytes(b"old")

    def fail(file: Any, **arrays: Any) -> None:
        file.write(b"half")
        raise OSError("disk full")

    monkeypatch.setattr(np, "savez_compressed", fail)
    with pytest.raises(OSError, match="disk full"):
        run.save(target)
    assert target.read_bytes() == b"old" and list(tmp_path.iterdir()) == [target]


def test_other_endings_are_refused(run: Run, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"\.npz"):
        run.save(tmp_path / "a.csv")
    with pytest.raises(ValueError, match=r"\.html.*\.gif"):
        run.animate(tmp_path / "a.mp4")
    with pytest.raises(ValueError, match=r"\.png"):
        run.plot(tmp_path / "a.pdf")
    assert not list(tmp_path.iterdir())


def test_dataset_has_dimensions_and_units(run: Run) -> None:
    pytest.importorskip("xarray")
    data = run.to_xarray()
    assert dict(data.sizes) == {
        "t": 32, "coordinate": 8, "velocity": 8, "impact": 4, "contact": 4, "parameter": 2, "joint": 6, "component": 3
    }  # fmt: skip
    assert np.array_equal(data.q.sel(coordinate="theta_3"), run.q[:, 5])
    assert data.t.units == "s" and data.kinetic_energy.units == "J" and data.impulse.units == "N s"
    assert list(data.q_units.values[[0, 2]]) == ["m", "rad"] and list(data.u_units.values[[1, 7]]) == ["m/s", "rad/s"]
    assert list(data.contact_point.values) == ["joint_0", "joint_5", "joint_5", "joint_5"]
    assert data.attrs["nfev"] == run.nfev and data.attrs["closure_max"] == run.closure_max
    total = (data.kinetic_energy + data.potential_energy).values
    assert total[0] - total[-1] == pytest.approx(data.energy_loss.sum().item(), abs=1e-11)


def test_every_saved_array_is_documented_with_its_shape(run: Run, tmp_path: Path) -> None:
    """The table in docs/model.md names each array once, and has its shape for a run with impacts and contact phases."""
    held = Phase("contact", run.phases[-1].start, run.phases[-1].end, (("joint_0", "ground_0"),) * 3, ("sticks",) * 3)
    struck = replace(run.impacts[0], contacts=(("joint_0", "ground_0"),) * 2, impulses=np.ones(2))
    changes = (JointChange(0.0, "joint_0", "release", "at 0 s"),) * 5
    run = replace(run, phases=(*run.phases[:-1], held), impacts=(struck, *run.impacts[1:]), changes=changes)
    text = (ROOT / "docs" / "model.md").read_text(encoding="utf-8").partition("### `result.npz`")[2]
    sizes = {"nt": run.t.size, "nq": run.q.shape[1], "nu": run.u.shape[1], "parameters": len(run.model.parameters)}
    sizes |= {"ni": len(run.impacts), "nc": len(run.impacts) + 1, "np": len(run.phases), "nh": 3, "3": 3}
    sizes |= {"joints": len(run.model.joints), "changes": len(changes)}
    sizes |= {"ni + 1": sizes["ni"] + 1, "np + 1": sizes["np"] + 1}
    documented = {}
    for line in text.partition("\n## ")[0].splitlines():
        if not line.startswith("| `"):
            continue
        names, shapes, _ = (cell.strip() for cell in line.strip("|").split("|"))
        found = re.findall(r"`(\w+)`", names)
        shape = [
            tuple(sizes[s.strip()] for s in one.split(",") if s.strip()) for one in re.findall(r"\((.*?)\)", shapes)
        ]
        assert len(shape) in (1, len(found)) and not documented.keys() & set(found)
        documented |= dict(zip(found, shape * len(found) if len(shape) == 1 else shape, strict=False))
    with np.load(run.save(tmp_path / "result.npz")) as file:
        readable = {name: array.shape for name, array in file.items() if not name.startswith("record")}
        assert readable | {"package": ()} == documented  # that of a model in a package


@pytest.mark.parametrize("until", [0.2, 1.25])
def test_tables_have_a_row_for_every_row(until: float) -> None:
    """With impacts and without: names, units, and numbers as in the run; nothing is lost."""
    pytest.importorskip("pandas")
    run = bouncing(until=until)
    frame = run.to_dataframe()
    assert frame.index.name == "t" and np.array_equal(frame.index, run.t) and len(frame) == len(run.t) > 2
    assert list(frame.columns) == [*run.model.q_names, *run.model.u_names, "kinetic_energy", "potential_energy"]
    assert np.array_equal(frame[list(run.model.q_names)], run.q) and np.array_equal(frame[[*run.model.u_names]], run.u)
    total = (frame.kinetic_energy + frame.potential_energy).to_numpy()
    assert total[0] - total[-1] == pytest.approx(sum(impact.energy_loss for impact in run.impacts), abs=1e-11)
    assert [frame.attrs["units"][name] for name in ("x_0", "theta_0", "vx_0", "w_0")] == ["m", "rad", "m/s", "rad/s"]
    assert frame.attrs["units"].keys() == set(frame.columns)


def test_a_dataset_without_impacts_has_no_dimension_for_them() -> None:
    """So that its table is not empty."""
    pytest.importorskip("xarray")
    run = bouncing(until=0.2)
    data = run.to_xarray()
    assert not run.impacts and dict(data.sizes) == {"t": len(run.t), "coordinate": 8, "velocity": 8, "parameter": 2}
    table = data.to_dataframe()
    assert len(table) == len(run.t) * 8 * 8 * 2
    assert np.array_equal(
        table.q.xs((run.t[1], "theta_3", "vx_0"), level=("t", "coordinate", "velocity"))[0:1], run.q[1:2, 5]
    )


@pytest.mark.parametrize(
    ("module", "package", "act"),
    [
        ("pandas", 'pandas.*ccgen\\[data\\]"', lambda run, folder: run.to_dataframe()),
        ("xarray", 'xarray.*ccgen\\[data\\]"', lambda run, folder: run.to_xarray()),
        ("matplotlib", "matplotlib.*pip install", lambda run, folder: run.plot()),
        ("matplotlib.figure", "matplotlib.*pip install", lambda run, folder: run.animate(folder / "a.gif")),
        ("PIL", "pillow.*pip install", lambda run, folder: run.animate(folder / "a.gif")),
    ],
)
def test_missing_packages_are_named(
    run: Run,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    module: str,
    package: str,
    act: Callable[[Run, Path], object],
) -> None:
    monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(ImportError, match=package):
        act(run, tmp_path)
    assert not list(tmp_path.iterdir())


def test_stand_in_model_is_consistent() -> None:
    model = PolygonModel()
    run = bouncing(until=0.4)
    kinetic, potential = model.energy(run.q, run.u)
    assert kinetic + potential == pytest.approx(np.full(len(run.t), kinetic[0] + potential[0]), abs=1e-11)
    assert np.abs(model.closure(run.q)).max() < 1e-14


def test_a_run_says_in_one_line_what_it_is(run: Run) -> None:
    assert repr(run) == f"<Run of {run.model.name} to t = 1.25 s: {run.t.size} rows, 4 impacts>"
