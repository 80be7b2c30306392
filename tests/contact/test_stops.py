"""Joint stops: bounces, rest, reactions and locking against closed forms, and random impacts against a dense solve."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ccgen.generator import SceneError
from ccgen.runtime import simulate

from ..support.workshop import Workshop

G = 9.81


def rod(name: str, length: float = 1.0) -> str:
    """A uniform rod of 1 kg, its frame at A."""
    return (
        f'[[link]]\nname = "{name}"\nmass = 1.0\ninertia = {length**2 / 12}\ncom = [{length / 2}, 0]\n'
        f"points = {{ A = [0, 0], B = [{length}, 0] }}\n"
    )


def pendulum(stop: str, start: str = 'angles = ["30 deg"]') -> str:
    joint = '[[joint]]\nname = "pin"\nbetween = ["ground.O", "rod.A"]\n'
    return (
        f"[ground_link]\npoints = {{ O = [0, 0] }}\n{rod('rod')}{joint}[gravity]\ng = {G}\n[start]\n{start}\n"
        f'[[stop]]\njoint = "pin"\n{stop}\n'
    )


def double(stop: str, length: float = 1.0, start: str = 'angles = ["0 deg", "30 deg"]', gravity: bool = True) -> str:
    joints = '[[joint]]\nbetween = ["ground.O", "thigh.A"]\n[[joint]]\nname = "knee"\n'
    field = f"[gravity]\ng = {G}\n" if gravity else ""
    return (
        f"[ground_link]\npoints = {{ O = [0, 0] }}\n{rod('thigh', length)}{rod('shank', length)}{joints}"
        f'between = ["thigh.B", "shank.A"]\n{field}[start]\n{start}\n[[stop]]\njoint = "knee"\n{stop}\n'
    )


@pytest.mark.parametrize("e", [0.0, 0.4, 1.0])
def test_a_falling_pendulum_bounces_by_the_law(workshop: Workshop, e: float) -> None:
    """Falls from 30 to -30 degrees: speed, impulse and loss at the stop, and how high it comes back."""
    model = workshop.model(pendulum('lowest = "-30 deg"\nrestitution = 0.4'))
    model = model.with_parameters({"stop_0.restitution": e})
    run = simulate(model, until=0.7)
    first = run.impacts[0]
    speed = np.sqrt(3 * G)  # w^2 I / 2 = m g fall / 2, fall of the tip 2 sin 30 = 1, I = 1/3
    assert first.contacts == (("pin", "stop_0.lowest"),)
    assert first.u_minus == pytest.approx([-speed], rel=1e-9)
    assert first.u_plus == pytest.approx([e * speed], rel=1e-9, abs=1e-12)
    assert first.impulses == pytest.approx([(1 + e) * speed / 3], rel=1e-9)
    assert first.energy_loss == pytest.approx((1 - e**2) * speed**2 / 6, rel=1e-8, abs=1e-9)
    if e == 0.4:
        t = np.linspace(first.t, run.impacts[1].t if len(run.impacts) > 1 else 0.7, 2001)
        highest = max(float(np.sin(run.at(x)[0][0])) for x in t)
        assert highest == pytest.approx(-0.5 + e**2, abs=1e-5)  # (e w)^2 / 6 = g rise / 2


def test_it_comes_to_rest_on_the_stop(workshop: Workshop) -> None:
    """Infinitely many bounces, then contact to the end."""
    model = workshop.model(pendulum('lowest = "-30 deg"\nrestitution = 0.4'))
    run = simulate(model, until=2.0)
    assert run.success and run.phases[-1].kind == "contact"
    assert run.phases[-1].contacts == (("pin", "stop_0.lowest"),)
    assert run.q[-1] == pytest.approx([-np.pi / 6], abs=1e-15) and run.u[-1] == pytest.approx([0.0], abs=1e-12)
    assert np.min(model.gaps(run.q)) >= -1e-12
    assert run.energy_drift <= 1e-7


def test_both_limits_hold(workshop: Workshop) -> None:
    model = workshop.model(
        pendulum('lowest = "-100 deg"\nhighest = "-80 deg"\nrestitution = 1', 'angles = ["-85 deg"]')
    )
    run = simulate(model, u0=[3.0], until=2.0)
    assert {contact for impact in run.impacts for contact in impact.contacts} == set(model.contacts)
    assert model.contacts == (("pin", "stop_0.lowest"), ("pin", "stop_0.highest"))
    assert np.min(model.gaps(run.q)) >= -1e-12 and run.energy_drift <= 1e-7
    angles = np.degrees(run.q[:, 0])
    assert angles.min() == pytest.approx(-100, abs=1e-9) and angles.max() == pytest.approx(-80, abs=1e-9)


def _swing_of_one_body(angle: float, until: float) -> float:
    """Angle after ``until`` of a rod of 2 kg and 2 m that is let go at ``angle``, by SciPy."""
    from scipy.integrate import solve_ivp

    def rates(t: float, y: Any) -> list[float]:
        return [y[1], -2 * G * np.cos(y[0]) / (2 * 4 / 3)]

    found = solve_ivp(rates, (0, until), [angle, 0.0], method="DOP853", rtol=1e-12, atol=1e-12)
    return float(found.y[0, -1])


@pytest.mark.parametrize(("limit", "angle"), [("highest = 0", 0.4), ("lowest = 0", np.pi - 0.4)])
def test_a_double_pendulum_locks_as_one_body(workshop: Workshop, limit: str, angle: float) -> None:
    """Let go stretched: the thigh falls and the shank turns against it, until the stop makes one rod of both."""
    model = workshop.model(double(f"{limit}\nrestitution = 0.5", start=f"angles = [{angle}, {angle}]"))
    run = simulate(model, until=0.3)
    assert [phase.kind for phase in run.phases] == ["contact"]
    assert run.q[-1] == pytest.approx([_swing_of_one_body(angle, 0.3)] * 2, abs=1e-9)
    free = np.array([-9 / 7, 3 / 7]) * G * np.cos(angle)  # of two equal rods in line, without the stop
    assert model.acceleration(*model.start(), contacts=()) == pytest.approx(free, rel=1e-12)
    locked = -3 / 4 * G * np.cos(angle)  # of one rod twice as long
    assert model.acceleration(*model.start()) == pytest.approx([locked, locked], rel=1e-12)


def test_a_stop_on_the_other_side_does_nothing(workshop: Workshop) -> None:
    model = workshop.model(double("lowest = 0\nrestitution = 0.5", start="angles = [0.4, 0.4]"))
    run = simulate(model, until=0.3)
    assert [phase.kind for phase in run.phases] == ["flight"] and np.max(model.gaps(run.q)) > 0.1


def test_the_stop_lets_go_where_its_reaction_ends(workshop: Workshop) -> None:
    """A torque that grows lifts the rod off its stop when it carries the moment of the weight, m g cos 30 / 2."""
    torque = '[[torque]]\nlink = "rod"\ntorque = "2*t"\n'
    model = workshop.model(pendulum('lowest = "-30 deg"\nrestitution = 0.4\n' + torque, 'angles = ["-30 deg"]'))
    run = simulate(model, until=3.0)
    assert [phase.kind for phase in run.phases] == ["contact", "flight"]
    assert run.phases[0].end == pytest.approx(G / 4 * np.cos(np.pi / 6), rel=1e-9)


def test_a_stop_strikes_two_links_as_one(workshop: Workshop) -> None:
    """e = 0, no gravity: the angular momentum about the hip stays, and both links turn together."""
    model = workshop.model(double('highest = "40 deg"\nrestitution = 0', gravity=False))
    run = simulate(model, u0=[0.0, 2.0], until=0.5)
    impact = run.impacts[0]
    assert impact.u_plus[0] == pytest.approx(impact.u_plus[1], abs=1e-12)
    c = np.cos(np.radians(40))
    mass = np.array([[4 / 3, c / 2], [c / 2, 1 / 3]])  # of the textbook double pendulum
    assert np.sum(mass @ impact.u_plus) == pytest.approx(np.sum(mass @ impact.u_minus), rel=1e-12)
    # the couple alone on each link
    assert mass @ (impact.u_plus - impact.u_minus) == pytest.approx(impact.impulses * [1, -1], rel=1e-10)
    assert run.phases[-1].kind == "flight" and model.gaps(run.q[-1])[0] > 0.05  # spinning stretches the knee again


LOOP = """
[loop]
links = 5
[gravity]
[start]
angles = [0.1, 1.4, 2.5, 3.9, 5.0]
[[ground]]
normal = [0.3, 1]
point = [0, -9]
restitution = 0.2
friction = 0.4
contacts = ["link_4.B", "link_0.B", "joint_2", "link_2.B", "link_3.B"]
radius = [0.1, 0.2, 0, 0.3, 0.1]
"""


@pytest.fixture(scope="module")
def loop_with_stops(workshop: Workshop) -> Any:
    stops = "".join(
        f'[[stop]]\njoint = "joint_{j}"\nlowest = -6.1\nhighest = 6.2\nrestitution = {0.1 + 0.2 * j}\n'
        for j in range(5)
    )
    return workshop.model(LOOP + stops)


def test_rates_are_those_of_the_gaps(loop_with_stops: Any) -> None:
    """Central differences of the gaps along u, grounds and stops in one model; the bias of a stop is zero."""
    model, rng = loop_with_stops, np.random.default_rng(1)
    q, _ = model.start()
    u = rng.normal(size=q.size)
    step = 1e-5
    found = (model.gaps(q + step * u) - model.gaps(q - step * u)) / (2 * step)
    assert model.gap_rates(q, u) == pytest.approx(found, abs=1e-9)
    bias = model.kernels.of_state("gap_bias", q[None].copy(), u[None].copy())[0]
    slips = model.kernels.of_state("slips", q[None].copy(), u[None].copy())[0]
    stops = [k for k, (_, other) in enumerate(model.contacts) if other in model.stops]
    assert len(stops) == 10 and not bias[stops].any() and not slips[stops].any()


def test_random_impacts_of_stops_are_those_of_a_dense_solve(loop_with_stops: Any) -> None:
    """Mass matrix from the kinetic energy, rows from the rates, the saddle point by NumPy; one or two stops."""
    model, rng = loop_with_stops, np.random.default_rng(2)
    q, _ = model.start()
    n = q.size

    def kinetic(u: Any) -> float:
        return float(model.energy(q, u)[0])

    unit = np.eye(n)
    mass = np.array([[kinetic(a + b) - kinetic(a) - kinetic(b) for b in unit] for a in unit])
    closure = model.jacobian(q)
    normals = np.array([model.gap_rates(q, a) for a in unit]).T
    compared = 0
    for _ in range(60):
        _, u = model.project(q, rng.normal(size=n))
        # every joint has one limit that it approaches; two stops at most are independent of a five-bar's loop
        chosen = [int(k) for k in rng.choice(np.arange(5, 15), size=int(rng.integers(1, 3)), replace=False)]
        rates = normals[chosen] @ u
        if not np.all(rates < 0) or len({k // 2 for k in (c - 5 for c in chosen)}) < len(chosen):
            continue
        e = rng.uniform(0, 1, len(chosen))
        rows = np.vstack([closure, normals[chosen]])
        saddle = np.block([[mass, rows.T], [rows, np.zeros((len(rows), len(rows)))]])
        right = np.concatenate([mass @ u, np.zeros(len(closure)), -e * rates])
        if np.linalg.cond(saddle) > 1e6:
            continue
        solved = np.linalg.solve(saddle, right)
        impulses = -solved[n + len(closure) :]
        if np.any(impulses < 0):
            continue
        after, found = model.impact(q, u, [model.contacts[k] for k in chosen], e)
        assert after == pytest.approx(solved[:n], abs=1e-10)
        assert found == pytest.approx(impulses, abs=1e-10)
        compared += 1
    assert compared >= 8


def test_own_restitution_of_each_stop(loop_with_stops: Any) -> None:
    """Without values the impact takes those of the stops' parameters."""
    model = loop_with_stops
    q, _ = model.start()
    _, u = model.project(q, np.random.default_rng(3).normal(size=q.size))
    contact = next(
        c
        for c, rate in zip(model.contacts, model.gap_rates(q, u), strict=True)
        if c[0] == "joint_2" and rate < 0 and c[1] in model.stops
    )
    after, _ = model.impact(q, u, [contact])
    index = model.contacts.index(contact)
    assert model.gap_rates(q, after)[index] == pytest.approx(-0.5 * model.gap_rates(q, u)[index], rel=1e-10)


@pytest.mark.parametrize("extra", ["", 'law = "poisson"\n'])
def test_stops_and_a_rough_ground_together(workshop: Workshop, extra: str) -> None:
    """A leg with a round foot falls on its knee stop and stands: both contacts hold at the end."""
    ground = (
        "[[ground]]\npoint = [0, -1.2]\nrestitution = 0.3\nfriction = 0.4\n"
        f'contacts = ["shank.B"]\nradius = 0.1\n{extra}'
    )
    model = workshop.model(double('lowest = "-10 deg"\nhighest = "40 deg"\nrestitution = 0.5\n' + ground))
    run = simulate(model, until=4.0)
    assert run.success and run.energy_drift <= 1e-7
    assert np.min(model.gaps(run.q)) >= -1e-11
    assert set(run.phases[-1].contacts) == {("shank.B", "ground_0"), ("knee", "stop_0.highest")}


@pytest.mark.sample(3)
@pytest.mark.parametrize("length", [1e-3, 1.0, 100.0])
@pytest.mark.parametrize("e", [0.0, 0.5])
def test_small_and_large_mechanisms(workshop: Workshop, length: float, e: float) -> None:
    """An angle has no length: what is a small angle does not depend on the size of the links."""
    model = workshop.model(double(f'lowest = "-10 deg"\nhighest = "40 deg"\nrestitution = {e}', length))
    run = simulate(model, until=3.0 * np.sqrt(length))
    assert run.success and len(run.impacts) > 3
    assert np.min(model.gaps(run.q)) >= -1e-11
    assert run.energy_drift <= 1e-7 * G * length


STOP = pendulum('lowest = "-30 deg"\nhighest = "60 deg"\nrestitution = 0.3')
BAD: dict[str, tuple[str, str, str, tuple[str, ...]]] = {
    "lowest above highest": (
        'lowest = "-30 deg"',
        'lowest = "70 deg"',
        "stop[0].lowest",
        ('found "70 deg" (1.22173 rad)', 'the highest angle, "60 deg" (1.0472 rad)', "exchange"),
    ),
    "limits in rad": ('lowest = "-30 deg"', "lowest = 1.25", "stop[0].lowest", ("found 1.25 rad", '"60 deg"')),
    "equal limits": ('lowest = "-30 deg"', 'lowest = "60 deg"', "stop[0].lowest", ("less than the highest",)),
    "start beyond": (
        'lowest = "-30 deg"',
        'lowest = "40 deg"',
        "stop[0]",
        ("pin at 0.523599 rad", 'at least "40 deg" (0.698132 rad)'),
    ),
    "start above": (
        'highest = "60 deg"',
        'highest = "20 deg"',
        "stop[0]",
        ("pin at 0.523599 rad", 'at most "20 deg" (0.349066 rad)'),
    ),
    "no such joint": ('joint = "pin"', 'joint = "knee"', "stop[0].joint", ('"knee"', "the joints are pin")),
    "no angle": ('highest = "60 deg"', 'highest = "60 grad"', "stop[0].highest", ('"60 grad"', "highest angle in rad")),
    "restitution": ("restitution = 0.3", "restitution = -1.0", "stop[0].restitution", ("found -1", "from 0 to 1")),
    "no restitution": ("restitution = 0.3", "", "stop[0].restitution", ("missing",)),
    "neither limit": ('lowest = "-30 deg"\nhighest = "60 deg"', "", "stop[0]", ("neither lowest nor highest",)),
}


@pytest.mark.parametrize("case", BAD, ids=lambda case: case.replace(" ", "-"))
def test_faults_name_key_and_advice(case: str, tmp_path: Path, workshop: Workshop) -> None:
    from ccgen.generator.scene import SceneError

    old, new, key, words = BAD[case]
    assert old in STOP
    with pytest.raises(SceneError) as caught:
        workshop.scene(STOP.replace(old, new))
    (fault,) = caught.value.faults
    assert f" {key}: " in f" {fault}" and all(word in str(fault) for word in words), str(fault)


def test_a_run_from_beyond_the_stop_is_refused(workshop: Workshop) -> None:
    model = workshop.model(pendulum('lowest = "-30 deg"\nrestitution = 0.4'))
    with pytest.raises(ValueError, match=r"pin beyond stop_0\.lowest by 0\.476401 rad"):
        simulate(model, q0=[-1.0], until=1.0)


def test_limits_that_leave_no_room_are_refused(workshop: Workshop) -> None:
    """As a scene's are: what parameters make of them is said as that, not as a start beyond one of them."""
    model = workshop.model(pendulum('lowest = "-30 deg"\nhighest = "30 deg"\nrestitution = 0.4'))
    with pytest.raises(
        ValueError, match=r"stop_0\.lowest: found 1, expected less than stop_0\.highest, which is 0\.52"
    ):
        simulate(model, until=1.0, params={"stop_0.lowest": 1.0})


def test_pictures_and_tables_of_a_run(workshop: Workshop, tmp_path: Path) -> None:
    """The plot has no height of a stop, and the printed table says rad/s."""
    model = workshop.model(pendulum('lowest = "-30 deg"\nrestitution = 0.4'))
    run = simulate(model, until=1.0)
    run.plot(tmp_path / "run.png")
    run.save(tmp_path / "run.npz")
    assert (tmp_path / "run.png").stat().st_size > 1000
    assert set(np.load(tmp_path / "run.npz")["impact_grounds"]) == {"stop_0.lowest"}


def test_printed_units_are_those_of_angles(workshop: Workshop, capsys: pytest.CaptureFixture[str]) -> None:
    """rad/s and N m s where all contacts are stops, both kinds of units beside a ground."""
    from ccgen.generator.cli.report import print_contacts, print_impacts

    model = workshop.model(pendulum('lowest = "-30 deg"\nrestitution = 0.4'))
    run = simulate(model, until=2.0)
    print_impacts(model, run)
    print_contacts(model, run)
    printed = capsys.readouterr().out
    assert "speed before, rad/s  impulse, N m s" in printed
    assert "pin on stop_0.lowest" in printed.splitlines()[1]
    assert printed.splitlines()[-1].endswith("s: pin on stop_0.lowest")
    mixed = workshop.model(
        pendulum(
            'lowest = "-30 deg"\nrestitution = 0.4\n[[ground]]\npoint = [0, -2]\nrestitution = 0\ncontacts = ["rod.B"]'
        )
    )
    print_impacts(mixed, simulate(mixed, until=0.5))
    assert "speed before, m/s, rad/s  impulse, N s, N m s" in capsys.readouterr().out


def test_expanded_form_has_the_rows_of_stops(workshop: Workshop) -> None:
    from ccgen.generator.derive.expanded import expand
    from ccgen.generator.mechanism.topology import span

    scene = workshop.scene(double("lowest = -1\nhighest = 1\nrestitution = 0.5"))
    form = expand(scene.mechanism, span(scene.mechanism), scene.effects)
    assert form.contacts == (("knee", "stop_0.lowest"), ("knee", "stop_0.highest"))
    assert form.N.tolist() == [[-1, 1], [1, -1]] and form.definitions == ()


SLIDER = """
[ground_link]
points = { O = [0, 0], P = [0, 1] }
[[link]]
name = "slider"
mass = 1.0
inertia = 0.01
com = [0, 0]
points = { C = [0, 0] }
[[joint]]
name = "guide"
type = "prismatic"
between = ["ground.O", "slider.C"]
axis = [3, 4]
angle = 0
"""
SLIDE = f"{SLIDER}[start]\nsliding_velocities = {{ guide = 2.0 }}\n"
LEVER = """
[[link]]
name = "ram"
mass = 1.0
inertia = 0.01
com = [0, 0]
points = { R = [0, 0] }
[[joint]]
name = "rail"
type = "prismatic"
between = ["slider.C", "ram.R"]
axis = [1, 0]
angle = 0
"""


def test_a_ram_strikes_the_end_of_its_rail(workshop: Workshop) -> None:
    """On a slider that is free to move along another line: the ram bounces against the slider, which is pushed along
    by what of the impulse lies in its line, 0.6 of it."""
    stop = '[[stop]]\njoint = "rail"\nhighest = 0.5\nrestitution = 0.5\n'
    start = SLIDE.replace("{ guide = 2.0 }", "{ guide = 2.0, rail = 4.0 }")
    (impact,) = simulate(workshop.model(start + LEVER + stop), until=0.5).impacts
    assert impact.t == pytest.approx(0.125, rel=1e-14)
    pushed = 0.6 / 2 * (1 + 0.5) * 4.0  # both have 1 kg: (2, 0.6; 0.6, 1) (ds, -6) = (0, -P)
    assert impact.u_plus == pytest.approx([2.0 + pushed, -2.0], rel=1e-14)
    assert impact.impulses == pytest.approx([6.0 - 0.6 * pushed], rel=1e-14)


def test_a_ground_ends_a_slide(workshop: Workshop) -> None:
    """0.5 m from the start at 2 m/s, and back at 0.3 times as much."""
    end = '[[ground]]\npoint = [0.3, 0.4]\nnormal = [-3, -4]\ncontacts = ["slider.C"]\nrestitution = 0.3\n'
    run = simulate(workshop.model(SLIDE + end), until=1.0)
    (impact,) = run.impacts
    assert impact.t == pytest.approx(0.25, abs=1e-12)
    assert impact.impulses == pytest.approx([2.6], rel=1e-12)
    assert run.q[-1, 0] == pytest.approx(0.5 - 0.75 * 0.6, abs=1e-12)


# -- ends of slides --------------------------------------------------------------------------------------------------

YOKE = """
[ground_link]
points = { O = [0, 0] }
[[link]]
name = "crank"
points = { A = [0, 0], B = [0.5, 0] }
mass = 1.0
inertia = 0.2
com = [0, 0]
[[link]]
name = "yoke"
mass = 3.0
inertia = 0.1
com = [0, 0]
points = { C = [0, 0] }
[[joint]]
name = "pin"
between = ["ground.O", "crank.A"]
[[joint]]
name = "rail"
type = "prismatic"
between = ["ground.O", "yoke.C"]
axis = 0
angle = 0
[[joint]]
name = "slot"
type = "pin-in-slot"
between = ["yoke.C", "crank.B"]
axis = [0, 1]
"""


def test_a_slider_bounces_between_its_ends(workshop: Workshop) -> None:
    """Times, speeds and impulses (N s) of a free slider; units and zero as limits of angles have them."""
    ends = '[[stop]]\njoint = "guide"\nlowest = "-50 cm"\nhighest = 0.5\nrestitution = 0.5\n'
    run = simulate(workshop.model(f"{SLIDER}{ends}[start]\nsliding_velocities = {{ guide = 2.0 }}\n"), until=8.0)
    assert [impact.t for impact in run.impacts] == pytest.approx([0.25, 1.25, 3.25, 7.25], rel=1e-14)
    assert [impact.contacts[0] for impact in run.impacts] == 2 * [
        ("guide", "stop_0.highest"),
        ("guide", "stop_0.lowest"),
    ]
    assert [impact.impulses[0] for impact in run.impacts] == pytest.approx([3.0, 1.5, 0.75, 0.375], rel=1e-14)


def test_a_slider_rests_on_its_end(workshop: Workshop) -> None:
    """Down a line of 3 : 4 under gravity, with an end at zero: it presses with its weight along the line."""
    model = workshop.model(
        f'{SLIDER}[gravity]\ng = {G}\n[[stop]]\njoint = "guide"\nlowest = 0\nrestitution = 0.3\n'
        "[start]\nslides = { guide = 0.2 }\n"
    )
    run = simulate(model, until=2.0)
    first = np.sqrt(2 * 0.2 / (0.8 * G))
    assert run.impacts[0].t == pytest.approx(first, rel=1e-12)
    assert run.success and run.phases[-1].contacts == (("guide", "stop_0.lowest"),)
    assert run.phases[-1].start == pytest.approx(first * (1 + 0.3) / (1 - 0.3), rel=1e-9)
    assert model.contact_forces(run.q[-1], run.u[-1])[0] == pytest.approx([G * 0.8, 0.0], abs=1e-9)


def test_the_pin_of_a_yoke_strikes_the_end_of_its_slot(workshop: Workshop) -> None:
    """The way along the slot, r sin φ, is no coordinate: its rate, its second rate and its impulse are those of the one
    freedom, whose inertia is I + M r² sin² φ."""
    limit, spin, e, r = 0.4, 3.0, 0.6, 0.5
    text = f'{YOKE}[[stop]]\njoint = "slot"\nhighest = {limit}\nrestitution = {e}\n'
    model = workshop.model(f"{text}[start]\nangles = {{ crank = 0.2 }}\nangular_velocities = {{ crank = {spin} }}\n")
    assert "slot" in model.cuts
    impact = simulate(model, until=0.5).impacts[0]
    angle = np.arcsin(limit / r)
    inertia, before = 0.2 + 3 * (r * np.sin(0.2)) ** 2, 0.2 + 3 * limit**2
    speed = spin * np.sqrt(inertia / before)  # what turns keeps its energy
    (k,) = [k for k, name in enumerate(model.q_of) if name == "crank.angle"]
    assert impact.u_minus[k] == pytest.approx(speed, rel=1e-9)
    assert impact.u_plus[k] == pytest.approx(-e * speed, rel=1e-9)
    way = r * np.cos(angle)
    assert impact.impulses == pytest.approx([(1 + e) * speed * before / way], rel=1e-9)
    q, u = model.project(impact_place(model, k, angle), impact.u_minus)
    assert model.gaps(q) == pytest.approx([0.0], abs=1e-12)
    assert model.gap_rates(q, u) == pytest.approx([-way * u[k]], rel=1e-12)
    held = model.acceleration(q, u, contacts={("slot", "stop_0.highest"): "smooth"})
    assert held[k] == pytest.approx(np.tan(angle) * u[k] ** 2, rel=1e-12)  # r (φ'' cos φ - φ'² sin φ) = 0


def impact_place(model: Any, k: int, angle: float) -> Any:
    """Coordinates with the crank at an angle and the loop shut."""
    q, _ = model.start()
    q[k] = angle
    for i, name in enumerate(model.q_of):
        if name == "rail.slide":
            q[i] = 0.5 * np.cos(angle)
    return q


@pytest.mark.parametrize(
    ("limits", "said"),
    [
        ('lowest = "10 deg"', 'found "10 deg", an angle, expected a length in m'),
        ("lowest = 0.6", "the start has guide at 0 m, expected at least 0.6 m; move the start or the stop"),
        ("lowest = 0.2\nhighest = 0.1", "found 0.2 m, expected less than the highest place, 0.1 m; exchange them"),
    ],
)
def test_wrong_ends_of_slides_are_told(workshop: Workshop, limits: str, said: str) -> None:
    with pytest.raises(SceneError, match=re.escape(said)):
        workshop.scene(f'{SLIDER}[[stop]]\njoint = "guide"\n{limits}\nrestitution = 0.5\n')
