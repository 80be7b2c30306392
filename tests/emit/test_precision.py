"""Models in floats, doubles and wide numbers: the same program, each as exact as its numbers are."""

from __future__ import annotations

import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sympy as sp
from typer.testing import CliRunner

from ccgen.generator import generate, load_scene, loop
from ccgen.generator.cli.app import app
from ccgen.generator.program.dialects import C
from ccgen.generator.program.terms import Sum
from ccgen.generator.write_c.precision import PRECISIONS
from ccgen.runtime import load_model, methods, simulate, static_equilibrium
from ccgen.runtime.cost.accuracy import compare, errors, refer
from ccgen.runtime.model.drives import drive_rows
from ccgen.runtime.pictures.instants import instants
from ccgen.runtime.precision import core_of, wider
from ccgen.runtime.simulation.arguments import LEAST

from ..oracles.maximal import Array
from ..support.folders import SCENES
from ..support.parallel_cranks import parallel_cranks
from ..support.tiers import all_hard_but, hard
from ..support.touching_scenes import G, disc_on_plank
from ..support.workshop import Workshop

NAMES = sorted(path.stem for path in SCENES.glob("*.toml") if path.stem not in ("strandbeest", "walker"))
"""All scenes but those of many Jansen legs, which take a compiler a quarter of a minute: one of them is here."""
WIDER = pytest.mark.skipif(not wider(), reason="long double is no wider than a double on this machine")

POINT = """
name = "drifter"
[[link]]
name = "body"
mass = 1.0
inertia = 1.0
com = [0.0, 0.0]
points = { C = [0.0, 0.0] }
[start]
position = [0.3, 0.7]
velocity = [0.1, -0.7]
"""
BALL = (
    POINT.replace("drifter", "precise-ball").replace("velocity = [0.1, -0.7]", "")
    + """
[gravity]
g = 9.81
[[ground]]
restitution = 0.5
contacts = ["body.C"]
"""
)
SWING = """
name = "precise-swing"
[chain]
links = 1
hinged = true
[start]
angles = [0.6]
[[torsion]]
joint = "joint_0"
stiffness = 3.0
"""


def eps(precision: str) -> float:
    return float(np.finfo(core_of(precision).REAL).eps)


# -- the text ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("precision", "text"),
    [
        ("double", "3.5*x - (1.0/3.0)*y + 2.0*sin(a_2) - 0.1*fabs(z)"),
        ("float", "3.5f*x - (1.0f/3.0f)*y + 2.0f*sinf(a_2) - 0.1f*fabsf(z)"),
        ("wide", "3.5*x - (1.0L/3.0L)*y + 2.0*sinl(a_2) - 0.1*fabsl(z)"),
    ],
)
def test_the_program_is_written_in_the_numbers_asked_for(precision: str, text: str) -> None:
    x, y, z, a = sp.symbols("x y z a_2")
    terms = (sp.Float(3.5) * x, -sp.Rational(1, 3) * y, 2 * sp.sin(a), sp.Float(-0.1) * sp.Abs(z))
    assert PRECISIONS[precision].dialect().text(Sum(tuple(map(C.term, terms)))) == text


@pytest.mark.hard
@pytest.mark.parametrize("precision", ["float", "wide"])
def test_packages_lie_side_by_side_and_compile_without_warnings(precision: str, tmp_path: Path) -> None:
    scene = load_scene(SCENES / "jansen-driven.toml")
    folder = generate(scene, tmp_path, precision=precision)
    assert folder == tmp_path / f"jansen_driven_{precision}"
    assert generate(scene, tmp_path) == tmp_path / "jansen_driven"
    assert (folder / "equations.txt").read_bytes() == (tmp_path / "jansen_driven" / "equations.txt").read_bytes()
    for source in ("model.c", "lanes.c"):
        command = ["cc", "-std=c11", "-Wall", "-Wextra", "-Werror", "-pedantic", "-Wdouble-promotion", "-O1", "-c"]
        done = subprocess.run([*command, source], cwd=folder, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr


# -- the kernels ---------------------------------------------------------------------------------------------------


def states(model: Any, count: int) -> Iterator[tuple[Array, Array]]:
    """States about the start whose numbers are floats, so that they are the same ones in every precision."""
    rng = np.random.default_rng(7)
    q, u = model.start()
    for _ in range(count):
        yield tuple(
            x.astype(np.float32).astype(float) for x in (q + 0.2 * rng.normal(size=q.size), rng.normal(size=u.size))
        )


def bound(model: Any, q: Array, u: Array) -> float:
    """By how many parts accelerations may change, at most, when each number that enters their equations changes by one.

    The equations are the unreduced ones, K x = b for accelerations, multipliers and forces of driven joints; the bound
    is Skeel's, |K⁻¹| (|K| |x| + |b|). An entry is a sum, so it counts as large as its terms may be: in the mass matrix
    the geometric mean of the diagonal, in a row of the closure the row's largest, and in b, besides its own size, the
    same times the squares of velocities. Infinite where rows depend on each other.
    """
    n = q.size
    mass = model.kernels.of_state("momentum", np.tile(q, (n, 1)), np.eye(n)).T
    rest = model.kernels.inverse_dynamics(q[None], u[None], 0.0, np.zeros((1, n)))[0]
    drives = drive_rows(model)
    rows = np.vstack([model.jacobian(q).reshape(-1, n), drives])
    bias = np.append(model.kernels.of_state("closure_bias", q[None], u[None])[0], np.zeros(len(drives)))
    matrix = np.block([[mass, rows.T], [rows, np.zeros((len(rows), len(rows)))]])
    right = -np.append(rest, bias)
    if np.linalg.matrix_rank(matrix) < len(matrix):
        return np.inf
    diagonal = np.sqrt(np.abs(np.diag(mass)))
    terms = np.tile(np.max(np.abs(rows), axis=1, initial=0.0)[:, None], n)
    size = np.block([[np.outer(diagonal, diagonal), terms.T], [terms, np.zeros((len(rows), len(rows)))]])
    inverse = np.linalg.inv(matrix)
    squares = np.append(u**2, np.zeros(len(rows)))
    return float(np.max(np.abs(inverse) @ (size @ (np.abs(inverse @ right) + squares) + np.abs(right))))


@pytest.mark.sample(1)
@pytest.mark.large(6)
@WIDER
@pytest.mark.parametrize(
    "name",
    all_hard_but(
        *("four-bar", "slider-crank"),
        of=[name for name in NAMES if name != "cam-follower"],  # the bound does not know the polynomials of its lift
    ),
)
def test_accelerations_are_as_exact_as_their_numbers(name: str, workshop: Workshop) -> None:
    """Against wide numbers, within what rounding every number of the equations does to them."""
    scene = load_scene(SCENES / f"{name}.toml")
    models = {precision: workshop.model(scene, precision) for precision in PRECISIONS}
    told = 0
    q, u = models["wide"].start()
    assert q.dtype == u.dtype == core_of("wide").REAL
    assert (
        np.max(np.abs(models["wide"].closure(q)), initial=0.0)
        <= 1e-17 * len(models["wide"].links) * models["wide"].length
    )
    for q, u in states(models["double"], 8):
        wanted = models["wide"].acceleration(q, u, contacts=())
        change = bound(models["double"], q, u)
        terms = q.size + len(models["double"].rows)
        for precision in ("float", "double"):
            found = models[precision].acceleration(q, u, contacts=())
            assert found.dtype == core_of(precision).REAL
            allowed = terms * eps(precision) * change
            told += allowed < 1e-3 * np.max(np.abs(wanted))
            assert np.max(np.abs(found - wanted)) <= allowed
    assert told >= 8  # of 16: the bound says something


@pytest.mark.sample(2)
@WIDER
@pytest.mark.parametrize("name", ["slider-crank", "falling-hexagon", "jansen-leg", "flyer"])
def test_kernels_are_as_exact_as_their_numbers(name: str, workshop: Workshop) -> None:
    """Poses and rates are sums over a path of links, each term at most a length, for rates times a velocity."""
    scene = load_scene(SCENES / f"{name}.toml")
    models = {precision: workshop.model(scene, precision) for precision in PRECISIONS}
    wide, links = models["wide"], len(models["wide"].links)
    reach = links * wide.length
    for q, u in states(models["double"], 8):
        far = reach + float(np.max(np.abs(q)))
        sizes = {"poses": far, "closure": reach, "jacobian": reach}
        for precision in ("float", "double"):
            model, unit = models[precision], 4 * (links + 2) * eps(precision)
            for kernel, size in sizes.items():
                found, wanted = getattr(model, kernel)(q), getattr(wide, kernel)(q)
                assert np.max(np.abs(found - wanted), initial=0.0) <= unit * size
            fast = reach * float(np.max(np.abs(u)))
            assert np.max(np.abs(model.velocities(q, u) - wide.velocities(q, u))) <= unit * (fast + np.max(np.abs(u)))
            kinetic, potential = model.energy(q, u)
            exact = wide.energy(q, u)
            squares = sum(wide.parameters[f"{link}.mass"] for link in wide.links) * (fast + np.max(np.abs(u))) ** 2
            assert abs(kinetic - exact[0]) <= unit * squares
            weight = sum(wide.parameters[f"{link}.mass"] for link in wide.links) * 9.81
            assert abs(potential - exact[1]) <= unit * (weight * far + abs(exact[1]))


@WIDER
def test_places_far_from_the_origin_lose_no_digits(workshop: Workshop) -> None:
    """The ring after ten seconds: 490 m below its start, at 98 m/s."""
    scene = load_scene(SCENES / "falling-ring.toml")
    model, wide = workshop.model(scene), workshop.model(scene, "wide")
    run = simulate(model, until=10.0, rtol=1e-13)
    q, u = run.q[-1], run.u[-1]
    assert q[1] < -489.0
    assert u[1] < -97.0
    found, wanted = model.acceleration(q, u), wide.acceleration(q, u)
    assert np.max(np.abs(found - wanted)) <= 1e-14 * np.max(np.abs(wanted))
    near_q, near_u = q.copy(), u.copy()
    near_q[:2], near_u[:2] = 0.0, 0.0
    assert np.array_equal(model.acceleration(near_q, near_u), found)
    assert np.max(np.abs(model.multipliers(q, u) - wide.multipliers(q, u))) <= 1e-14 * np.max(np.abs(wanted))


# -- runs ----------------------------------------------------------------------------------------------------------


@WIDER
@pytest.mark.parametrize("method", ["gauss", "dop853"])
def test_wide_runs_follow_a_closed_form(method: str, workshop: Workshop) -> None:
    """A rod on a spring, θ = 0.6 cos(ω t): to the last digit of a wide number in every step."""
    wide = workshop.model(SWING, "wide")
    run = simulate(wide, until=20.0, rtol=1e-18, method=method)
    assert run.t.dtype == run.q.dtype == core_of("wide").REAL
    inertia = np.longdouble(wide.parameters["link_0.inertia"]) + wide.parameters["link_0.mass"] * np.longdouble(0.25)
    omega = np.sqrt(np.longdouble(wide.parameters["torsion_0.stiffness"]) / inertia)
    exact = run.q[0, 0] * np.cos(omega * run.t)
    turned = 0.6 * float(omega) * 20.0  # an error of ω t, and of the angle itself, in every step
    assert np.max(np.abs(run.q[:, 0] - exact)) <= eps("wide") * (turned + len(run.t))
    q, _ = run.at(np.longdouble(1) / 3)
    assert abs(q[0] - run.q[0, 0] * np.cos(omega / 3)) <= eps("wide") * (turned + len(run.t))


@WIDER
def test_wide_impacts_are_as_exact(workshop: Workshop) -> None:
    """Bounces of a ball: t_k = t_0 (1 + 2 (e + ... + e^k)), t_0 = sqrt(2 h / g), v_k = g t_0 e^k.

    Places are rounded to a part of h in every step; a place off by that is reached earlier or later by that over v_k.
    """
    wide = workshop.model(BALL, "wide")
    run = simulate(wide, until=1.1, rtol=1e-17)
    g, e = np.longdouble(wide.parameters["gravity.g"]), np.longdouble(wide.parameters["ground_0.restitution"])
    first = np.sqrt(2 * run.q[0, 1] / g)
    assert len(run.impacts) >= 4
    off = 0.0
    for k, impact in enumerate(run.impacts[:4]):
        exact = first * (1 + 2 * sum(e**j for j in range(1, k + 1)))
        off += len(run.t) * eps("wide") * float(run.q[0, 1] / (g * first * e**k))
        assert abs(impact.t - exact) <= off
        assert abs(impact.u_plus[1] - g * first * e ** (k + 1)) <= off * g


@pytest.mark.parametrize("precision", ["double", pytest.param("wide", marks=WIDER)])
@pytest.mark.parametrize(("mu", "how", "share"), [(0.5, "sticks", 2 / 3), (0.05, "slides forward", None)])
def test_friction_as_exact_as_its_numbers(
    precision: str, mu: float, how: str, share: float | None, workshop: Workshop
) -> None:
    """A disc down a plank at 0.3 rad: rolls with 2/3 g sin, or slides with g (sin - mu cos)."""
    model = workshop.model(disc_on_plank(0.3, 0.2, f"restitution = 0.0\nfriction = {mu}"), precision)
    run = simulate(model, until=0.4, rtol=LEAST[precision] * 10)
    assert run.success, run.message
    assert [phase.how for phase in run.phases] == [(how,)]
    speed = np.hypot(*model.velocities(run.q[-1], run.u[-1])[model.links.index("disc"), :2])
    wanted = 0.4 * G * (share * np.sin(0.3) if share else np.sin(0.3) - mu * np.cos(0.3))
    assert abs(speed / wanted - 1) <= 100 * eps("double")  # the plank's angle is a double


@WIDER
@pytest.mark.parametrize(("name", "until"), [("falling-ring", 10.0), ("falling-hexagon", 0.95), ("jansen-leg", 2.0)])
def test_the_wide_reference_is_better_than_anything_measured(name: str, until: float, workshop: Workshop) -> None:
    scene = load_scene(SCENES / f"{name}.toml")
    model, wide = workshop.model(scene), workshop.model(scene, "wide")
    reference = refer(wide, until)
    assert reference.wide
    itself = max(errors(simulate(wide, until=until, rtol=1e-17, method="gauss"), reference.run))
    best = min(one.worst for one in compare(model, reference.run, tolerances=(1e-12, 1e-13)))
    assert itself <= 1e-2 * best
    assert reference.doubt <= 0.2 * best


def test_sums_of_many_steps_are_compensated(workshop: Workshop) -> None:
    """A point drifts 100,000 equal steps: its place is off by the last digit; without compensation, by hundreds."""
    model = workshop.model(POINT)
    step, until = 0.01, 1000.0
    off = {}
    for method in ("gauss", "dop853"):
        run = simulate(model, until=until, step=step, method=method)
        exact = run.q[0].astype(np.longdouble) + run.u[0].astype(np.longdouble) * until
        assert len(run.t) >= 100_000
        off[method] = np.abs(run.q[-1] - exact)[:2] / np.spacing(np.abs(run.q[-1, :2]))
    assert np.max(off["gauss"]) <= 1.0
    assert np.max(off["dop853"]) > 100.0


@pytest.mark.parametrize("method", methods(estimating=True))
def test_runs_in_floats_follow_those_in_doubles(method: str, workshop: Workshop) -> None:
    """Rounding of 1e-7 of the motion's size, in every step and every evaluation."""
    single, model = (workshop.model(loop(6, gravity=True), precision) for precision in ("float", "double"))
    run, wanted = (simulate(m, until=0.5, rtol=1e-5, method=method) for m in (single, model))
    assert run.q.dtype == np.float32
    assert max(errors(run, wanted)) <= 100 * 1e-5


@WIDER
@pytest.mark.parametrize("cranks", [3, hard(5)])
def test_dependent_rows_are_left_out(cranks: int, workshop: Workshop) -> None:
    """Parallel cranks, all but two redundant: accelerations and least multipliers as in doubles, and the same run."""
    drawing = parallel_cranks(1.1, cranks)
    models = {precision: workshop.model(drawing.toml(), precision) for precision in PRECISIONS}
    still = np.zeros_like(drawing.poses)
    u = np.array([1.3] * cranks + [0.0])
    q, _ = models["double"].state_from_poses(drawing.poses, still)
    wanted, least = models["double"].acceleration(q, u), models["double"].multipliers(q, u)
    run = simulate(models["double"], q, u, until=1.0, rtol=1e-5)
    for precision in ("float", "wide"):
        model = models[precision]
        unit = 100.0 * max(eps(precision), eps("double"))
        assert model.dof == 1
        assert np.max(np.abs(model.acceleration(q, u) - wanted)) <= unit * np.max(np.abs(wanted))
        assert np.max(np.abs(model.multipliers(q, u) - least)) <= unit * np.max(np.abs(least))
        found = simulate(model, q, u, until=1.0, rtol=1e-5)
        assert found.success, found.message
        assert max(errors(found, run)) <= 100 * 1e-5


@WIDER
@pytest.mark.parametrize("name", ["jansen-leg", "slider-crank"])
def test_states_are_read_off_poses_in_the_models_numbers(name: str, workshop: Workshop) -> None:
    """What poses and velocities are made from comes back, to the last digits of those numbers."""
    scene = load_scene(SCENES / f"{name}.toml")
    for precision in PRECISIONS:
        model = workshop.model(scene, precision)
        q, u = model.start()
        poses, velocities = model.poses(q), model.velocities(q, u)
        found = model.state_from_poses(poses, velocities)
        unit = 100.0 * eps(precision)
        for one, wanted in zip(found, (q, u), strict=True):
            assert one.dtype == wanted.dtype == core_of(precision).REAL
            assert np.max(np.abs(one - wanted)) <= unit * max(1.0, float(np.max(np.abs(wanted))))
        batch = model.state_from_poses(np.array([poses] * 2), np.array([velocities] * 2))
        assert np.array_equal(batch[0], [found[0]] * 2)


@pytest.mark.sample(1)
@WIDER
@pytest.mark.parametrize("precision", PRECISIONS)
def test_runs_are_kept_and_shown(precision: str, workshop: Workshop, tmp_path: Path) -> None:
    scenes = [SWING] if precision == "float" else [SWING, BALL]
    for text in scenes:
        run = simulate(workshop.model(text, precision), until=0.5)
        with np.load(run.save(tmp_path / "run.npz")) as kept:
            assert np.array_equal(kept["q"], run.q)
            assert kept["q"].dtype == core_of(precision).REAL
        run.plot(tmp_path / "run.png")
        run.animate(tmp_path / "run.html")
        assert (tmp_path / "run.png").stat().st_size > 1000
        assert run.model.name in (tmp_path / "run.html").read_text()
        assert bool(run.impacts) == (text is BALL)
        if run.impacts:
            assert [title for _, title in instants(run) if title] == ["start", "impact 1", "end"]


def test_the_scenes_tolerance_is_taken_as_far_as_the_numbers_go(workshop: Workshop) -> None:
    """A scene asks for 1e-9 unless it says otherwise, which floats do not reach."""
    model = workshop.model(SWING, "float")
    assert model.data["run"]["rtol"] == 1e-9
    own, least = simulate(model, until=0.5), simulate(model, until=0.5, rtol=LEAST["float"])
    assert own.success
    assert np.array_equal(own.q, least.q)
    double = workshop.model(SWING)
    assert np.array_equal(simulate(double, until=0.5).q, simulate(double, until=0.5, rtol=1e-9).q)


# -- what is refused -----------------------------------------------------------------------------------------------


def test_refusals(workshop: Workshop, tmp_path: Path) -> None:
    scene = loop(4, gravity=True)
    with pytest.raises(ValueError, match=r"precision: found 'quad', expected one of float, double, wide"):
        generate(scene, tmp_path, precision="quad")
    with pytest.raises(ValueError, match=r"precision: found 'float' beside fold, expected 'double'"):
        generate(scene, tmp_path, precision="float", fold=True)
    assert not list(tmp_path.iterdir())
    with pytest.raises(ValueError, match=r"precise-ball: found a model in floats with contacts, expected none"):
        simulate(workshop.model(BALL, "float"))
    with pytest.raises(
        ValueError, match=r'loop4: found a model in precision="wide", expected "double" for an equilibrium'
    ):
        static_equilibrium(workshop.model(scene, "wide"))
    model = workshop.model(scene)
    with pytest.raises(TypeError, match="not the descriptor"):
        core_of("wide").Kernels(model._descriptor, np.zeros(0), 1.0)
    with pytest.raises(ValueError, match=r"rtol: found 1e-07, expected a number between 0 and 1"):
        simulate(workshop.model(scene, "float"), rtol=1e-7)


def test_the_command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    done = CliRunner().invoke(app, ["--links", "4", "--precision", "float"])
    assert done.exit_code == 0, done.output
    model = load_model(tmp_path / done.output.strip())
    assert model.precision == "float"
    assert done.output == "build/loop4_float\n"
    for options, sentence in (
        (["--links", "4", "--precision", "quad"], "--precision: found 'quad', expected one of float, double, wide"),
        (["--links", "4", "--precision", "wide", "--fold"], "--precision wide: found beside --fold"),
        (["--precision", "wide"], "--precision: found without --links or --scene"),
        (["cost", "x.toml", "--precision", "double,half"], "--precision: found 'half', expected one of"),
        (["cost", "x.toml", "--effects", "--precision", "float"], "--precision: found beside --effects"),
    ):
        done = CliRunner().invoke(app, options)
        assert done.exit_code == 2
        assert sentence in done.output


@pytest.mark.hard
@WIDER
def test_cost_in_several_precisions(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scene = tmp_path / "swing.toml"
    scene.write_text(SWING + "[run]\nuntil = 0.5\n")
    monkeypatch.chdir(tmp_path)
    done = CliRunner().invoke(app, ["cost", str(scene), "--precision", "float,double,wide,double"])
    assert done.exit_code == 0, done.output
    rows = (tmp_path / "results" / "precise-swing" / "cost.csv").read_text().splitlines()
    assert rows[0].startswith("precision,method,drift,rtol,error")
    measured = [row.split(",")[:4] for row in rows[1:]]
    assert len(measured) == len({tuple(row) for row in measured})
    least = {name: min(float(row.split(",")[4]) for row in rows if row.startswith(name)) for name in PRECISIONS}
    assert least["float"] > 100 * least["double"]
    assert least["double"] > 10 * least["wide"]


@WIDER
def test_wide_models_assemble_from_afar(workshop: Workshop) -> None:
    """From a few tenths of a radian away, to all of their digits: 14 of these 20 could not."""
    model = workshop.model(load_scene(SCENES / "four-bar.toml"), "wide")
    q, _ = model.start()
    rng = np.random.default_rng(1)
    for _ in range(20):
        found = model.assemble(np.asarray(q, dtype=float) + 0.2 * rng.normal(size=q.size))
        assert float(np.max(np.abs(model.closure(found)))) <= 1e-17
