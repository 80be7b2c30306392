"""Impacts: closed forms of falling polygons, and random simultaneous impacts against the dense reference."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from ..oracles import maximal, mechanisms, polygons
from ..oracles.maximal import Array, Contact, Jump
from ..oracles.mechanisms import Drawing
from ..oracles.polygons import LANDINGS, Landing
from ..support.tiers import all_hard_but
from ..support.workshop import Workshop

MATERIALS = [(1.0, 1.0, 0.5), (0.7, 1.3, 0.3), (1.0, 1.0, 1.0), (1.0, 1.0, 0.0)]
SPEED = 1.7


@pytest.fixture(scope="module", params=LANDINGS, ids=lambda landing: landing.name.replace(" ", "-"))
def landing(request: pytest.FixtureRequest) -> Landing:
    return request.param


@pytest.fixture(scope="module")
def falling(landing: Landing, workshop: Workshop) -> Any:
    """A free ring over a ground, with symbols for all that the materials change."""
    from ccgen.generator import loop

    ground = [{"restitution": 0.5}]
    return workshop.model(loop(landing.n, gravity=True, ground=ground, start={"height": 1.0}))


@pytest.mark.sample(8)
@pytest.mark.parametrize(("length", "mass", "e"), MATERIALS)
def test_landing_is_the_closed_form(
    landing: Landing, falling: Any, workshop: Workshop, length: float, mass: float, e: float
) -> None:
    """All rows of the table: W, impulse, velocity of the mass centre, angular velocities and energy lost."""
    from ccgen.generator import loop

    model = falling
    if (length, mass) != (1.0, 1.0):
        rods = {"length": length, "mass": mass}
        ground = [{"restitution": 0.5}]
        model = workshop.model(loop(landing.n, gravity=True, ground=ground, start={"height": 1.0}, loop=rods))
    system = polygons.ring(landing.n, length, mass, 9.81)
    poses = polygons.regular(landing.n, length, landing.tilt)
    q, u = model.state_from_poses(poses, np.tile([0.0, -SPEED, 0.0], (landing.n, 1)))
    contacts = [(f"joint_{j}", "ground_0") for j in landing.joints]
    after, impulses = model.impact(q, u, contacts, e)
    velocities = model.velocities(q, after)
    centre = maximal.centre_velocities(system, poses, velocities).mean(axis=0)

    jump = (1 + e) * SPEED
    assert impulses == pytest.approx(landing.impulse * jump * mass, rel=1e-12)
    assert np.array(landing.inverse) @ impulses / mass == pytest.approx(jump, rel=1e-12)
    assert centre[:2].astype(float) == pytest.approx([0.0, -SPEED + landing.lift * jump], abs=1e-12 * SPEED)
    spins = np.array(landing.spins) * jump / length
    assert velocities[:, 2] == pytest.approx(spins, abs=1e-12 * jump / length)
    lost = model.energy(q, u)[0] - model.energy(q, after)[0]
    scale = landing.loss * mass * SPEED**2 / 2
    assert lost == pytest.approx((1 - e**2) * scale, abs=1e-12 * scale)


@pytest.mark.parametrize(("length", "mass", "e"), MATERIALS)
def test_parameters_change_without_a_new_model(
    landing: Landing, falling: Any, length: float, mass: float, e: float
) -> None:
    """The same table when the unit rods' model is given other lengths, masses and restitution at run time."""
    values = {"ground_0.restitution": e}
    for k in range(landing.n):
        values |= {f"link_{k}.length": length, f"link_{k}.mass": mass, f"link_{k}.com.x": length / 2}
        values[f"link_{k}.inertia"] = mass * length**2 / 12
    model = falling.with_parameters(values)
    poses = polygons.regular(landing.n, length, landing.tilt)
    q, u = model.state_from_poses(poses, np.tile([0.0, -SPEED, 0.0], (landing.n, 1)))
    _, impulses = model.impact(q, u, [(f"joint_{j}", "ground_0") for j in landing.joints])
    assert impulses == pytest.approx(landing.impulse * (1 + e) * SPEED * mass, rel=1e-12)


# --- random impacts ---------------------------------------------------------------------------------------------------

SLOPES = {"flat": ((0.0, 1.0), (0.2, -0.3)), "slope": ((-0.6, 0.8), (1.0, 0.5)), "wall": ((1.0, 0.05), (-2.0, 0.0))}
"""Normals and points of the grounds; normals as they are written, not yet of unit length."""


@dataclass(frozen=True)
class Stage:
    """A mechanism among grounds: its model, its arrays, and its contacts by name and as arrays."""

    model: Any
    drawing: Drawing
    contacts: dict[tuple[str, str], Contact]


def _stage(drawing: Drawing, workshop: Workshop) -> Stage:
    below = np.min(drawing.poses[:, :2]) - 30.0  # far off: where the grounds are does not enter an impact
    text = ""
    contacts: dict[tuple[str, str], Contact] = {}
    joints = [(f"joint_{k}", pin) for k, pin in enumerate(drawing.system.pins) if maximal.GROUND not in (pin.a, pin.b)]
    for name, (normal, _) in SLOPES.items():
        foot = tuple(float(below * x) for x in -np.array(normal) / np.hypot(*normal) * -1)
        text += f'[[ground]]\nname = "{name}"\nnormal = {list(normal)}\npoint = {list(foot)}\nrestitution = 0.4\n'
        contacts |= {(joint, name): Contact(pin.a, pin.on_a, normal) for joint, pin in joints}
        tip = drawing.points[-1]
        last = list(tip)[-1]
        owner = f"body_{drawing.system.size - 1}.{last}"
        if not any(end == owner for ends in drawing.ends for end in ends):
            contacts[owner, name] = Contact(drawing.system.size - 1, tip[last], normal)
        names = [point for point, ground in contacts if ground == name]
        text += f"contacts = {names}\n".replace("'", '"')
    return Stage(workshop.model(drawing.toml(extra=text)), drawing, contacts)


STAGES = [("floating", 3), ("floating", 6), ("pinned", 5), ("open", 4), ("hinged", 4), ("two_loops", 7), ("ladder", 2)]
FEW = [("floating", 3), ("open", 4), ("hinged", 4), ("two_loops", 7)]


@pytest.fixture(scope="module", params=all_hard_but(*FEW, of=STAGES), ids=lambda case: f"{case[0]}-{case[1]}")
def stage(request: pytest.FixtureRequest, workshop: Workshop) -> Stage:
    family, n = request.param
    return _stage(mechanisms.FAMILIES[family](n), workshop)


@dataclass(frozen=True)
class Strike:
    """A random state, contacts that approach in it, and what the reference makes of their impact."""

    q: Array
    u: Array
    names: list[tuple[str, str]]
    contacts: list[Contact]
    e: Array
    poses: Array
    wanted: Jump


def _strikes(stage: Stage, rng: np.random.Generator, count: int, unequal: bool) -> list[Strike]:
    """Random strikes of one to four contacts."""
    model, system = stage.model, stage.drawing.system
    q0, _ = model.state_from_poses(stage.drawing.poses, 0 * stage.drawing.poses)
    found: list[Strike] = []
    while len(found) < count:
        bent = q0 + rng.uniform(-0.3, 0.3, len(q0))
        q, u = model.project(model.assemble(bent), rng.normal(size=len(model.u_names)))
        poses, velocities = model.poses(q), model.velocities(q, u)
        if maximal.conditioning(system, poses) > 1e3:
            continue
        names = list(stage.contacts)
        rows = maximal.contact_rows(system, poses[:, 2], [stage.contacts[name] for name in names])
        speeds = rows @ maximal.centre_velocities(system, poses, velocities).ravel()
        approaching = [name for name, speed in zip(names, speeds, strict=True) if speed < 0]
        if not approaching:
            continue
        size = int(rng.integers(1, min(4, len(approaching)) + 1))
        chosen = [approaching[k] for k in rng.permutation(len(approaching))[:size]]
        contacts = [stage.contacts[name] for name in chosen]
        e = rng.uniform(0, 1, size) if unequal else np.full(size, rng.uniform(0, 1))
        wanted = maximal.impact(system, poses, velocities, contacts, e)
        found.append(Strike(q, u, chosen, contacts, e, poses, wanted))
    return found


def _regular(strike: Strike) -> bool:
    """Whether the contacts are independent, so that the impulses are unique."""
    return bool(np.linalg.cond(strike.wanted.inverse.astype(float)) < 1e3)


@pytest.mark.sample(2)
@pytest.mark.parametrize("unequal", [False, True], ids=["common-e", "unequal-e"])
def test_random_impacts_are_those_of_the_dense_solve(stage: Stage, unequal: bool) -> None:
    """Velocities always, impulses where they are unique; the energy lost is that of the work of the impulses."""
    rng = np.random.default_rng([5, unequal])
    compared = 0
    for strike in _strikes(stage, rng, 30, unequal):
        e = strike.e if unequal else float(strike.e[0])
        after, impulses = stage.model.impact(strike.q, strike.u, strike.names, e)
        before = stage.model.velocities(strike.q, strike.u)
        velocities = stage.model.velocities(strike.q, after)
        if not _regular(strike):
            continue
        compared += len(impulses) > 1
        scale = np.abs(before).max()
        assert np.max(np.abs(velocities - strike.wanted.velocities.astype(float))) <= 1e-12 * scale
        wanted = strike.wanted.impulses.astype(float)
        assert np.max(np.abs(impulses - wanted)) <= 1e-12 * max(wanted.max(), scale)
    assert compared >= 5 or stage.drawing.system.size < 4


def test_no_impulse_pulls_and_no_contact_is_left_approaching(stage: Stage) -> None:
    """0 <= P perpendicular to N u+ + e N u- >= 0, joints stay shut, also where contacts depend on each other."""
    system = stage.drawing.system
    for strike in _strikes(stage, np.random.default_rng(6), 40, unequal=True):
        after, impulses = stage.model.impact(strike.q, strike.u, strike.names, strike.e)
        rows = maximal.contact_rows(system, strike.poses[:, 2], strike.contacts)
        v = [
            maximal.centre_velocities(system, strike.poses, stage.model.velocities(strike.q, x)).ravel()
            for x in (strike.u, after)
        ]
        speed = np.abs(v[0]).max()
        slack = (rows @ v[1] + strike.e * (rows @ v[0])).astype(float)
        assert np.all(impulses >= 0)
        assert np.all(slack >= -1e-12 * speed)
        assert np.all(rows @ v[1] >= -1e-12 * speed)
        assert np.all(impulses * slack <= 1e-12 * speed * max(impulses.max(), speed))
        opening = maximal.jacobian(system, strike.poses[:, 2]) @ v[1]
        assert np.max(np.abs(opening)) <= 1e-12 * speed


def test_common_restitution_loses_energy_by_the_formula(stage: Stage) -> None:
    """-dT = (1 - e^2) / 2 (N u-)^T W^-1 (N u-) when every contact takes part."""
    system = stage.drawing.system
    checked = 0
    for strike in _strikes(stage, np.random.default_rng(8), 40, unequal=False):
        if not _regular(strike) or not np.all(strike.wanted.impulses > 1e-9):
            continue
        rows = maximal.contact_rows(system, strike.poses[:, 2], strike.contacts)
        v = maximal.centre_velocities(system, strike.poses, stage.model.velocities(strike.q, strike.u)).ravel()
        speeds = rows @ v
        lost = (1 - strike.e[0] ** 2) / 2 * speeds @ maximal.solve(strike.wanted.inverse, speeds)
        after, _ = stage.model.impact(strike.q, strike.u, strike.names, float(strike.e[0]))
        before = stage.model.energy(strike.q, strike.u)[0]
        assert before - stage.model.energy(strike.q, after)[0] == pytest.approx(float(lost), abs=1e-12 * before)
        checked += 1
    assert checked > 5
