"""What commands print: figures with their scale, lists that say what they leave out, no minus before a zero."""

from __future__ import annotations

import dataclasses
import re
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from ccgen.generator import chain
from ccgen.generator.cli.report import (
    drift_of_energy,
    energy_moved,
    energy_scale,
    print_audit,
    print_contacts,
    print_impacts,
    print_warnings,
    row,
)
from ccgen.generator.program.program import Counts
from ccgen.runtime import Phase, simulate
from ccgen.runtime.model.thresholds import characteristic_time

from ..support.command_line import PENDULUM, ccgen
from ..support.folders import SCENES
from ..support.sliding_rod import ROD
from ..support.tiers import hard
from ..support.workshop import Workshop

DRIVEN = """\
name = "driven"
[chain]
links = 1
hinged = true
[gravity]
g = 9.81
[[drive]]
joint = "joint_0"
speed = 3.0
[run]
until = 0.5
rtol = 1e-7
"""


def test_the_energy_that_moves_is_that_of_the_fall(workshop: Workshop) -> None:
    """A rod of 1 kg and 1 m falls from level and passes the lowest point, half a metre down, between two rows."""
    moved = energy_moved(simulate(workshop.model(PENDULUM), until=20.0))
    assert 0.99 * 9.81 * 0.5 < moved <= (1.0 + 1e-9) * 9.81 * 0.5


def test_the_scale_of_energy_is_that_of_a_radian_in_the_characteristic_time(workshop: Workshop) -> None:
    """The rod's moment of inertia about its hinge is a third of 1 kg m2."""
    run = simulate(workshop.model(PENDULUM), until=0.5)
    assert energy_scale(run) == pytest.approx(0.5 / 3.0 / characteristic_time(run.model) ** 2, rel=1e-14)


def test_the_audit_has_its_scale(tmp_path: Path) -> None:
    (tmp_path / "pendulum.toml").write_text(PENDULUM.replace("until = 0.5", "until = 1.0"))
    done = ccgen("run", "pendulum.toml", at=tmp_path)
    assert done.returncode == 0
    assert re.search(r"energy kept to [\d.e+-]+ J of 4\.\d+ J above its lowest; method gauss", done.stdout)


CHALK = """\
name = "chalk"
[ground_link]
points = { O = [0, 1.0] }
[[link]]
name = "cart"
mass = 1.0
inertia = 0.01
com = [0, 0]
points = { C = [0, 0] }
[[link]]
name = "rod"
mass = 1.0
inertia = 0.1
com = [0.6, 0]
points = { H = [0, 0], T = [1.2, 0] }
[[joint]]
name = "rail"
type = "prismatic"
between = ["ground.O", "cart.C"]
axis = [1, 0]
[[joint]]
name = "hinge"
between = ["cart.C", "rod.H"]
[start]
angles = { rod = "-56.4426902380793 deg" }
[gravity]
[[ground]]
restitution = 0.2
friction = 1.5
contacts = ["rod.T"]
[[motor]]
joint = "rail"
force = 60
[run]
until = 2.0
"""
"""A rod that a cart pushes over the floor as chalk over a board, and that friction holds: nothing ever moves."""


def test_a_run_in_which_nothing_moves(tmp_path: Path) -> None:
    (tmp_path / "chalk.toml").write_text(CHALK)
    done = ccgen("run", "chalk.toml", at=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert "contact from 0 s to 2 s: rod.T sticks\n" in done.stdout
    assert re.search(r"energy kept to [\d.e+-]+ J, nothing moves; method gauss\n", done.stdout)


def test_a_drift_where_nothing_moves_is_part_of_the_scale_of_energy(
    workshop: Workshop, capsys: pytest.CaptureFixture[str]
) -> None:
    """Rounding of the work of loads that hold each other is no drift, however large they are and however long."""
    model = workshop.model(CHALK)
    run = simulate(model, until=20.0, params={"motor_0.force": 6e4})
    scale = energy_scale(run)
    weight = 2.0 * 9.81
    assert 0.01 < scale / (weight * model.length) < 1.0
    print_warnings(run)
    assert run.energy_drift > 0.0 == energy_moved(run)  # which no share can be said of
    assert capsys.readouterr().err == ""

    def drifting(energy_drift: float) -> Any:
        return dataclasses.replace(run, energy_drift=energy_drift)

    assert drift_of_energy(drifting(0.9e-4 * scale)) == ""
    assert drift_of_energy(drifting(1.1e-4 * scale)) == f"{1.1e-4 * scale:.2g} J although nothing moves"


def test_a_drift_is_part_of_what_moves_however_little_that_is(workshop: Workshop) -> None:
    """A pendulum that swings by a thousandth of a degree."""
    model = workshop.model(PENDULUM)
    run = simulate(model, [-np.pi / 2 + 2e-5], [0.0], until=2.0)
    moved = energy_moved(run)
    assert 0.9 < moved / (0.25 * 9.81 * 4e-10) < 1.0 + 1e-6
    drifts = [dataclasses.replace(run, energy_drift=part * moved) for part in (0.5, 0.9e-4)]
    assert [drift_of_energy(one) for one in drifts] == ["50 % of the energy that moves", ""]


def test_a_mechanism_at_rest_without_loads_is_at_rest(workshop: Workshop, capsys: pytest.CaptureFixture[str]) -> None:
    """No weight, no motion, no energy at all."""
    run = simulate(workshop.model(chain(2, gravity=False)), until=1.0)
    assert energy_moved(run) == run.energy_drift == 0.0
    print_audit(run)
    print_warnings(run)
    printed = capsys.readouterr()
    assert "energy kept to 0.0e+00 J, nothing moves; " in printed.out and not printed.err


def test_an_impact_without_collision_is_called_so(workshop: Workshop, capsys: pytest.CaptureFixture[str]) -> None:
    """Nothing approaches in the first impact; in the second one end does, and the other, which does not, is struck."""
    model = workshop.model(ROD)
    run = simulate(model)
    print_impacts(model, run)
    heading, first, *second, note = capsys.readouterr().out.splitlines()
    assert heading.startswith("#") and first.split()[1:6] == [
        "0.000000000000",
        "link_0.A",
        "(friction",
        "jams)",
        "0.000000000",
    ]
    assert len(second) == 2 and not any("jams" in line for line in second)
    assert note == "friction jams: an impact without collision, where a contact that slides has no forces (Painleve)"
    print_contacts(model, run)
    kinds = [line.split(": ")[1] for line in capsys.readouterr().out.splitlines()]
    assert kinds == ["link_0.A sticks", "link_0.A slides", "link_0.A, link_0.B stick"]


A, B = ("rod.A", "floor"), ("rod.B", "floor")


def contacts_of(*phases: Phase, capsys: pytest.CaptureFixture[str]) -> list[str]:
    """What is printed of these phases of a model with one ground."""
    model: Any = SimpleNamespace(contacts=[A, B], stops=[])
    run: Any = SimpleNamespace(phases=phases)
    print_contacts(model, run)
    return capsys.readouterr().out.splitlines()


def test_stretches_say_how_contacts_stay_closed(capsys: pytest.CaptureFixture[str]) -> None:
    """Phases that read alike are one stretch, whichever way a contact slides, and through impacts of others."""
    printed = contacts_of(
        Phase("flight", 0.0, 0.5),
        Phase("impact", 0.5, 0.5),
        Phase("contact", 0.5, 1.0, (A,), ("slides forward",)),
        Phase("contact", 1.0, 1.25, (A,), ("slides backward",)),
        Phase("impact", 1.25, 1.25),
        Phase("contact", 1.25, 1.5, (A,), ("slides backward",)),
        Phase("contact", 1.5, 2.0, (A, B), ("sticks", "at the limit, forward")),
        Phase("steps", 2.0, 2.25, step=1e-3),
        Phase("steps", 2.25, 2.5, step=1e-3),
        Phase("contact", 2.5, 3.0, (A, B), ("sticks", "sticks")),
        Phase("contact", 3.0, 3.5, (A, B), ("smooth", "smooth")),
        Phase("contact", 3.5, 4.0, (A, B), ("carried", "touches")),
        capsys=capsys,
    )
    assert printed == [
        "contact from 0.5 s to 1.5 s: rod.A slides",
        "contact from 1.5 s to 2 s: rod.A sticks; rod.B is at the limit",
        "time stepping from 2 s to 2.5 s",
        "contact from 2.5 s to 3 s: rod.A, rod.B stick",
        "contact from 3 s to 3.5 s: rod.A, rod.B",
        "contact from 3.5 s to 4 s: rod.A is carried; rod.B touches",
    ]


def test_a_stretch_shorter_than_its_digits_is_no_interval(capsys: pytest.CaptureFixture[str]) -> None:
    short = Phase("contact", 1.727, 1.727 + 2e-13, (A,), ("slides forward",))
    assert contacts_of(short, capsys=capsys) == ["contact at 1.727 s for 2e-13 s: rod.A slides"]
    short = Phase("steps", 1.727, 1.727 + 2e-13, step=1e-14)
    assert contacts_of(short, capsys=capsys) == ["time stepping at 1.727 s for 2e-13 s"]


def test_one_stretch_that_is_left_out_is_one(capsys: pytest.CaptureFixture[str]) -> None:
    apart = [Phase("contact", k, k + 0.5, (A,), ("sticks",)) for k in range(10)]
    assert len(contacts_of(*apart[:8], capsys=capsys)) == 8
    for count, told in (
        (9, "and 1 such stretch before, in result.npz"),
        (10, "and 2 such stretches before, in result.npz"),
    ):
        *_, last = printed = contacts_of(*apart[:count], capsys=capsys)
        assert last == told and len(printed) == 9 and printed[0].startswith(f"contact from {count - 8} s")


@pytest.mark.hard
def test_one_line_on_loops_unless_more_is_asked_for(tmp_path: Path) -> None:
    """The beach animal has 14 loops."""
    scene = str(SCENES / "strandbeest.toml")
    (line,) = ccgen("show", scene, at=tmp_path).stderr.splitlines()
    assert line.startswith("strandbeest: 14 loops closed, angles changed by ")
    told, _, hint = line.partition("; ")
    assert hint == "-v for the others and their branches"
    first, *branches = ccgen("show", scene, "-v", at=tmp_path).stderr.splitlines()
    assert first.startswith(told.partition(" and ")[0])
    assert len(branches) == 14 and all(line.startswith("strandbeest: branch ") for line in branches)
    assert ccgen("show", scene, "--quiet", at=tmp_path).stderr == ""


SKETCH = """
[pinned]
links = 3
[start]
angles = [1.2, 0.1, -1.3]
[gravity]
[run]
until = 0.1
"""


@pytest.mark.parametrize(
    ("command", "results"),
    [
        hard(("run", "sketch.toml"), ""),
        hard(("run", "sketch.toml", "--rtol", "1e-3", "--method", "dopri5"), ""),
        hard(("--scene", "sketch.toml"), "build/sketch\n"),
        (("show", "sketch.toml"), None),
        hard(("equilibrium", "sketch.toml"), None),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, tuple) else "",
)
def test_quiet_is_quiet(command: tuple[str, ...], results: str | None, tmp_path: Path) -> None:
    """One remark as usual, all with -v, none with --quiet; beside its results a run prints nothing then."""
    (tmp_path / "sketch.toml").write_text(SKETCH)
    usual, all_, none = (ccgen(*command, *more, at=tmp_path) for more in ((), ("-v",), ("-q",)))
    assert (usual.returncode, all_.returncode, none.returncode) == (0, 0, 0)
    (line,) = usual.stderr.splitlines()
    assert line.startswith("sketch: 1 loop closed, angles changed by ") and line.endswith("; -v for its branch")
    assert all_.stderr.count("\n") == 2 and "sketch: branch " in all_.stderr
    assert none.stderr == ""
    assert none.stdout == (usual.stdout if results is None else results)


@pytest.mark.hard
def test_quiet_says_what_goes_wrong(tmp_path: Path) -> None:
    """Wrong input and early stops, with their exit codes; warnings of doubtful figures."""
    (tmp_path / "sketch.toml").write_text(SKETCH)
    wrong = ccgen("run", "sketch.toml", "--until", "-1", "--quiet", at=tmp_path)
    assert (wrong.returncode, wrong.stdout) == (2, "") and wrong.stderr.startswith("--until: found -1")
    (tmp_path / "sketch.toml").write_text(SKETCH.replace("[gravity]", "[gravity]\ng = 1e300"))
    stopped = ccgen("run", "sketch.toml", "--quiet", "--method", "radau", at=tmp_path)  # half a million steps are short
    assert (stopped.returncode, stopped.stdout) == (3, "")
    assert re.fullmatch(r"sketch: stopped at t = .*\n", stopped.stderr)
    refused = ccgen("run", "sketch.toml", "-q", "-v", at=tmp_path)
    assert (refused.returncode, refused.stderr) == (
        2,
        "--quiet: found beside --verbose, expected one of them; leave one out\n",
    )
    before = ccgen("-q", "run", "sketch.toml", at=tmp_path)
    assert before.returncode == 2 and "--quiet: found before the command run, expected behind it" in before.stderr


def test_show_prints_the_equations_only_where_asked(tmp_path: Path) -> None:
    """The summary is the beginning of what --equations prints, and has every heading."""
    (tmp_path / "sketch.toml").write_text(SKETCH)
    summary = ccgen("show", "sketch.toml", at=tmp_path).stdout
    whole = ccgen("show", "sketch.toml", "--equations", at=tmp_path).stdout
    assert whole.startswith(summary) and "u_dot" not in summary and "u_dot" in whole
    assert summary.count("\n") < 40 < whole.count("\n")
    for heading in ("links", "joints", "loops", "branch", "degrees of freedom", "effects", "operations"):
        assert f"\n{heading}  " in summary


def test_no_zero_has_a_minus() -> None:
    """An impact whose figures are zero but for rounding below."""
    model: Any = SimpleNamespace(
        contacts=[("joint_0", "ground_0")], stops=[], gap_rates=lambda q, u: [-1e-13], energy=lambda q, u: (-1e-13, 0.0)
    )
    impact: Any = SimpleNamespace(
        t=1.0,
        contacts=[("joint_0", "ground_0")],
        impulses=[-0.0],
        energy_loss=-1e-12,
        u_minus=None,
        u_plus=None,
        restitution_share=1.0,
    )
    in_force = SimpleNamespace(at_impact=lambda number: model)
    run: Any = SimpleNamespace(q=np.zeros((1, 1)), t=np.ones(1), impacts=[impact], in_force=in_force, advance=None)
    assert row(model, run, 0, model) == ("1.000000000000", "joint_0", *["0.000000000"] * 4)


def test_one_is_not_many() -> None:
    assert str(Counts(1, 1, 1, 1, 1)) == (
        "3 operations (1 sum, 1 product, 1 quotient) and 1 sine with its cosine and 1 other function"
    )
    assert str(Counts(2, 0, 2, 2)) == "4 operations (2 sums, 0 products, 2 quotients) and 2 sines with their cosines"


def test_a_torque_needs_a_joint(tmp_path: Path) -> None:
    done = ccgen("torque", str(SCENES / "slider-crank.toml"), at=tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == (
        "JOINT: found none, expected the joint that drives, one of: motor (ground - crank), crank_pin (crank - rod), "
        "wrist_pin (rod - slider); "
        "name it behind the scene file\n"
    )


def test_a_torque_needs_a_joint_that_turns(tmp_path: Path) -> None:
    scene = str(SCENES / "slider-crank.toml")
    done = ccgen("torque", scene, "nope", at=tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == (
        f"JOINT: found 'nope', which does not turn in {scene}, "
        "expected the joint that drives, one of: motor (ground - crank), crank_pin (crank - rod), "
        "wrist_pin (rod - slider); name one of them\n"
    )


def test_a_torque_turns_the_only_driven_joint(tmp_path: Path) -> None:
    done = ccgen("torque", str(SCENES / "jansen-driven.toml"), at=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "axle turned once at 6.28319 rad/s, as its [[drive]] has it: " in done.stdout
    assert " against ground\n" in done.stdout


@pytest.mark.hard
def test_a_motion_that_drives_give_has_no_price_of_accuracy(tmp_path: Path) -> None:
    (tmp_path / "driven.toml").write_text(DRIVEN)
    done = ccgen("cost", "driven.toml", at=tmp_path)
    assert done.returncode == 0
    last = done.stdout.splitlines()[-1]
    assert last.startswith("drives and loops give the whole motion: errors are up to ")
    assert "keep the scene's: gauss at rtol 1e-07" in last
    assert "for 1e-" not in done.stdout
    (tmp_path / "rough.toml").write_text(DRIVEN.replace("speed = 3.0", 'speed = "3 + 20*sin(40*t)"'))
    rough = ccgen("cost", "rough.toml", "--error", "1e-9", at=tmp_path)
    assert rough.stdout.splitlines()[-1].startswith("for 1e-09: ")


GEARED = """
name = "geared"
[ground_link]
points = { O = [0, 0], P = [0.3, 0] }
[[link]]
name = "arm"
mass = 1.0
inertia = 0.1
com = [0.5, 0]
points = { A = [0, 0], B = [1, 0] }
[[link]]
name = "wheel"
mass = 1.0
inertia = 0.1
com = [0, 0]
points = { C = [0, 0] }
[[link]]
name = "bob"
mass = 0.1
inertia = 0.01
com = [0, 0]
points = { D = [0, 0] }
[[joint]]
name = "hip"
between = ["ground.O", "arm.A"]
[[joint]]
name = "axle"
between = ["ground.P", "wheel.C"]
[[joint]]
name = "grip"
between = ["arm.B", "bob.D"]
[[gear]]
joints = ["hip", "axle"]
radii = [0.2, 0.1]
[gravity]
"""


def test_forces_of_teeth_are_told_where_nothing_touches(tmp_path: Path) -> None:
    """At the start (I + m l²) α = M with the wheel's 4 I_w: the tooth force is I_w 2 α / r."""
    (tmp_path / "geared.toml").write_text(f"{GEARED}[run]\nuntil = 0.1\n")
    done = ccgen("run", "geared.toml", at=tmp_path)
    assert done.returncode == 0, done.stderr
    alpha = 9.81 * (0.5 + 0.1) / (0.1 + 0.25 + 0.1 + 4 * 0.1)
    found = re.search(r"gear_0 +(\S+) N  at t = 0 s", done.stdout)
    assert found, done.stdout
    assert float(found[1]) == pytest.approx(0.1 * 2 * alpha / 0.1, rel=1e-5)


def test_what_never_comes_is_told(tmp_path: Path) -> None:
    late = '[[release]]\njoint = "grip"\nwhen = { angle = "hip", above = "500 deg" }\n'
    late += '[[event]]\nname = "round"\nwhen = "angle(hip) - 7"\n[[event]]\nname = "soon"\nwhen = "t - 0.05"\n'
    (tmp_path / "geared.toml").write_text(f"{GEARED}{late}[run]\nuntil = 0.1\n")
    done = ccgen("run", "geared.toml", at=tmp_path)
    assert done.returncode == 0, done.stderr
    told = [line for line in done.stdout.splitlines() if line.endswith("never came")]
    assert told == ["release of grip: never came", "event round: never came"]


def test_how_often_an_event_came_that_was_to_end_the_run_is_told(tmp_path: Path) -> None:
    event = '[[event]]\nname = "wave"\nwhen = "sin(100*t)"\ndirection = "rising"\nstop = true\ntimes = 3\n'
    (tmp_path / "geared.toml").write_text(f"{GEARED}{event}[run]\nuntil = 0.1\n")
    done = ccgen("run", "geared.toml", at=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "event wave: came 1 of the 3 times at which the run ends\n" in done.stdout


def test_joints_that_change_and_events_are_told_in_the_order_of_time(tmp_path: Path) -> None:
    more = '[[release]]\njoint = "grip"\nat = 0.05\n'
    for name, when in (("late", 0.08), ("early", 0.02), ("meanwhile", 0.05)):
        more += f'[[event]]\nname = "{name}"\nwhen = "t - {when}"\n'
    (tmp_path / "geared.toml").write_text(f"{GEARED}{more}[run]\nuntil = 0.1\n")
    done = ccgen("run", "geared.toml", at=tmp_path)
    assert done.returncode == 0, done.stderr
    told = [line.split(" at t =")[0] for line in done.stdout.splitlines() if " at t =" in line]
    wanted = ["event early, rising,", "grip lets go", "event meanwhile, rising,", "event late, rising,"]
    assert [line for line in told if line in wanted] == wanted


def test_a_parameter_that_is_set_to_what_it_was_stays(tmp_path: Path) -> None:
    """Which is told, for it has been asked for; a change in the last digits is told by all of them."""
    values = '"bob.mass" = 0.1, "arm.mass" = 0.6, "wheel.inertia" = 0.10000000000000002'
    text = f'{GEARED}[[event]]\nname = "now"\nwhen = "t - 0.05"\nset = {{ {values} }}\n[run]\nuntil = 0.1\n'
    (tmp_path / "geared.toml").write_text(text)
    done = ccgen("run", "geared.toml", at=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "event now, rising, at t = 0.05 s: bob.mass stays 0.1, arm.mass from 1 to 0.6, " in done.stdout
    assert "wheel.inertia from 0.1 to 0.10000000000000002" in done.stdout
