"""What weighs next to nothing: right, or told."""

from __future__ import annotations

import re
from typing import Any

import mpmath
import numpy as np
import pytest

from ccgen.runtime import simulate

from ..support.light_spokes import spokes
from ..support.workshop import Workshop

G = 9.81


def pulley(mass: float) -> str:
    """A load of 3 kg, over a fixed pulley, on one of ``mass`` that hangs, about which 1 and 2 kg hang."""
    text = (
        'name = "pulley"\n[gravity]\n[ground_link]\npoints = { A = [0, 0], P = [0.5, 0], B = [0.4, -2], C = [0.6, -2], '
        "over = [0, 2], back = [0.5, 2] }\n"
    )
    for link, at, weight, more in (
        ("a", "A", 3.0, ""),
        ("b", "B", 1.0, ""),
        ("c", "C", 2.0, ""),
        ("p", "P", mass, "x"),
    ):
        points = ", L = [-0.1, 0], R = [0.1, 0]" if more else ""
        text += (
            f'[[link]]\nname = "{link}"\npoint_mass = {{ mass = {weight!r}, at = "C" }}\n'
            f"points = {{ C = [0, 0]{points} }}\n"
            f'[[joint]]\nname = "s_{link}"\ntype = "prismatic"\nbetween = ["ground.{at}", "{link}.C"]\naxis = [0, 1]\n'
        )
    return (
        text + '[[rope]]\nbetween = ["a.C", "p.C"]\nover = ["ground.over", "ground.back"]\nrestitution = 0\n'
        '[[rope]]\nbetween = ["b.C", "c.C"]\nover = ["p.L", "p.R"]\nrestitution = 0\n'
        "[start]\nslides = { s_a = 0.0, s_p = 0.0, s_b = 0.0, s_c = 0.0 }\n[run]\nuntil = 0.3\n"
    )


@pytest.mark.parametrize("mass", [1e-2, 1e-5])
def test_a_light_pulley(mass: float, workshop: Workshop) -> None:
    """With tension T about it: 3 kg against 2 T + mass g, as of 4 m1 m2 / (m1 + m2)."""
    run = simulate(workshop.model(pulley(mass)))
    assert run.success, run.message
    hanging = 4 * 1.0 * 2.0 / 3.0 + mass
    wanted = (hanging - 3.0) / (hanging + 3.0) * G  # of the load, upwards
    assert run.u[-1][0] == pytest.approx(0.3 * wanted, rel=1e-6)


def test_a_pulley_that_weighs_nothing_beside_its_loads_is_told(workshop: Workshop) -> None:
    """Nothing strikes: the digits of its forces are lost."""
    run = simulate(workshop.model(pulley(1e-11)))
    assert not run.success and not run.impacts
    assert re.fullmatch(r"stopped at t = 0 s: masses differ so much that .*make light links .*", run.message)


def test_light_spokes_lose_what_their_impacts_take(workshop: Workshop) -> None:
    """From spoke to spoke the speed of the middle falls by cos 45 degrees, if the rest weighs nothing."""
    energies: list[Any] = []
    for inertia in (1e-5, 1e-9):
        run = simulate(workshop.model(spokes(inertia)))
        assert run.success, run.message
        energies.append(sum(run.model.energy(run.q[-1], run.u[-1])))
    assert energies[1] == pytest.approx(energies[0], abs=5e-3)


def collapsed(inertia: float, spokes_passed: int) -> tuple[float, float]:
    """The energy of the wheel, and what its last impact took, when it has rolled over so many spokes.

    Between impacts it is a pendulum about the foot that sticks, and keeps its energy; an impact keeps its angular
    momentum about the new foot (T. McGeer, Passive dynamic walking, International Journal of Robotics Research 9,
    1990). Arms are of 1 m, 45 degrees apart, with 1 kg in their middle.
    """
    with mpmath.workdps(40):
        turned, about = mpmath.mpf(inertia), 1 + mpmath.mpf(inertia)
        half = mpmath.pi / 8
        speed = mpmath.mpf("0.372393594461681")
        down = (mpmath.mpf("0.0799146939691727"), mpmath.mpf("-0.9968017063026194"))
        step, height = 2 * mpmath.sin(half), mpmath.cos(half)
        lost = mpmath.mpf(0)
        for _ in range(spokes_passed):
            after = mpmath.sqrt(speed**2 + 2 * down[0] * step / about)
            speed = after * (turned + mpmath.cos(2 * half)) / about
            lost = about * (after**2 - speed**2) / 2
        energy = about * speed**2 / 2 - down[0] * step * spokes_passed - down[1] * height
        return float(energy), float(lost)


@pytest.mark.parametrize("method", ["gauss", "dop853", "radau"])
@pytest.mark.parametrize("inertia", [1e-8, 1e-9, 1e-10, 1e-11])
def test_light_spokes_roll_event_by_event(inertia: float, method: str, workshop: Workshop) -> None:
    """What holds a foot acts along both its rows, far more than along one: impulses are known all the same."""
    run = simulate(workshop.model(spokes(1e-5)), params={"w.inertia": inertia}, method=method)
    assert run.success, run.message
    assert all(phase.kind != "steps" for phase in run.phases)
    assert len([impact for impact in run.impacts if impact.energy_loss > 1e-9]) == 2
    energy, lost = collapsed(inertia, 2)
    assert run.impacts[-1].energy_loss == pytest.approx(lost, rel=1e-7)
    assert sum(run.model.energy(run.q[-1], run.u[-1])) == pytest.approx(energy, abs=1e-8)


@pytest.mark.parametrize("restitution", [0.0, 0.4])
@pytest.mark.parametrize("inertia", [1e-12, 1e-13, 1e-14, 1e-16])
def test_spokes_that_weigh_nothing_are_told(inertia: float, restitution: float, workshop: Workshop) -> None:
    """Neither events nor steps know what such feet do."""
    model = workshop.model(spokes(1e-5))
    bouncing = {name: restitution for name in model.parameters if name.endswith("restitution")}
    run = simulate(model, params={"w.inertia": inertia} | bouncing)
    assert not run.success
    assert re.fullmatch(r"stopped at t = \S+ s: masses differ so much that .*make light links .*", run.message)
    assert all(phase.kind != "steps" for phase in run.phases)


@pytest.mark.parametrize("law", ["newton", "poisson", "stronge"])
def test_light_spokes_bounce_as_heavier_ones(law: str, workshop: Workshop) -> None:
    """What bounces of light feet come to goes with the inertia to a limit, or the run says that it cannot know."""
    model = workshop.model(spokes(1e-5).replace("[run]", f'[run]\nlaw = "{law}"'))
    bouncing = {name: 0.4 for name in model.parameters if name.endswith("restitution")}
    ends = {}
    for inertia in (1e-5, 1e-6, 1e-9, 1e-10, 1e-11):
        run = simulate(model, params={"w.inertia": inertia} | bouncing, until=3.0)
        if inertia < 1e-10 and not run.success:
            assert "masses differ so much" in run.message
            continue
        assert run.success, run.message
        assert all(phase.kind != "steps" for phase in run.phases)
        ends[inertia] = sum(model.energy(run.q[-1], run.u[-1]))
    limit = ends[1e-6] - (ends[1e-5] - ends[1e-6]) / 9.0  # it is linear in the inertia
    assert all(end == pytest.approx(limit, abs=1e-8) for inertia, end in ends.items() if inertia <= 1e-9)


def rod(inertia: float, more: str, law: str = "newton", restitution: float = 0.5) -> str:
    """A free rod of 1 kg that drops onto one of its ends, 0.5 m from its middle, as it moves along the ground."""
    return (
        f'name = "rod"\n[[link]]\nname = "r"\nmass = 1.0\ninertia = {inertia!r}\ncom = [0, 0]\n'
        f"points = {{ T = [0.5, 0] }}\n[gravity]\n[[ground]]\nrestitution = {restitution!r}\n{more}\n"
        'contacts = ["r.T"]\n[start]\nposition = [0.0, 0.6]\nangles = { r = -0.7 }\nvelocity = [0.2, 0.0]\n'
        f'[run]\nlaw = "{law}"\nuntil = 0.3\n'
    )


def sliding_bounce(inertia: float, friction: float) -> tuple[float, float, float]:
    """The normal impulse, the change of the speed along the ground and the loss of the rod, which slides all along:
    then all laws are one. Friction stays in proportion to the normal impulse, whose row alone has to be divided by."""
    with mpmath.workdps(60):
        g, x, y = mpmath.mpf(G), mpmath.cos(mpmath.mpf(-0.7)) / 2, mpmath.sin(mpmath.mpf(-0.7)) / 2
        normal, mixed, along = 1 + x * x / inertia, -x * y / inertia, 1 + y * y / inertia
        speed, slip = mpmath.sqrt(2 * g * (mpmath.mpf(0.6) + y)), mpmath.mpf(0.2)
        P = mpmath.mpf(1.5) * speed / (normal - friction * mixed)
        F = -friction * P
        assert slip + mixed * P + along * F > 0
        gained = -speed * P + slip * F + (normal * P * P + 2 * mixed * P * F + along * F * F) / 2
        return float(P), float(F), float(-gained)


@pytest.mark.parametrize("law", ["newton", "poisson", "stronge"])
@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_a_light_rod_that_slides_bounces_however_light(law: str, friction: float, workshop: Workshop) -> None:
    """Nothing cancels where its friction is in proportion to the normal impulse, and so no digit is lost."""
    model = workshop.model(rod(1e-5, f"friction = {friction!r}", law))
    for inertia in (1e-9, 1e-11, 1e-12, 1e-13, 1e-14, 1e-16):
        run = simulate(model, params={"r.inertia": inertia})
        assert run.success, run.message
        (impact,) = run.impacts
        impulse, change, loss = sliding_bounce(inertia, friction)
        assert impact.impulses[0] == pytest.approx(impulse, rel=1e-11)
        assert impact.energy_loss == pytest.approx(loss, rel=1e-9)
        assert impact.u_plus[0] == pytest.approx(0.2 + change, abs=1e-15)


def test_no_friction_and_none_written_are_one(workshop: Workshop) -> None:
    """Rows of sliding that nothing acts along hide nothing, also beside ones that something acts along."""
    beside = 'friction = 0.0\ncontacts = ["r.T"]\n[[ground]]\npoint = [0, -9]\nrestitution = 0.5\nfriction = 0.5'
    ends = []
    for more in ("", "friction = 0.0", beside):
        run = simulate(workshop.model(rod(1e-13, more)))
        assert run.success, run.message
        ends.append([*run.q[-1], *run.u[-1]])
    assert ends[1] == pytest.approx(ends[0], rel=1e-13)
    assert ends[2] == pytest.approx(ends[0], rel=1e-13)


@pytest.mark.parametrize("law", ["newton", "poisson", "stronge"])
def test_a_light_rod_that_sticks_is_known_or_told(law: str, workshop: Workshop) -> None:
    """Both rows hold its end, and almost cancel: what bounces is known, or it is told that it is not."""
    model = workshop.model(rod(1e-5, "friction = 5.0", law))
    losses = {}
    for inertia in (1e-6, 1e-7, 1e-9, 1e-10, 3e-11, 2e-11, 3e-12, 1e-12, 1e-14):
        run = simulate(model, params={"r.inertia": inertia})
        if inertia < 1e-11:
            assert not run.success and "no digit of the force or impulse at r.T on ground_0 is sure" in run.message
            continue
        assert run.success, run.message
        assert run.impacts[0].restitution_share == 1.0
        losses[inertia] = run.impacts[0].energy_loss
    limit = losses[1e-7] - (losses[1e-6] - losses[1e-7]) / 9.0  # it is linear in the inertia
    for inertia, loss in losses.items():
        assert inertia > 1e-9 or loss == pytest.approx(limit, rel=1e-6)


def test_time_stepping_tells_it_too(workshop: Workshop) -> None:
    """It takes no restitution away in silence."""
    model = workshop.model(rod(1e-5, "friction = 5.0"))
    known = simulate(model, params={"r.inertia": 1e-9}, method="moreau", step=1e-4)
    assert known.success and sum(phase.taken for phase in known.phases) == pytest.approx(1.0903, abs=2e-4)
    run = simulate(model, params={"r.inertia": 1e-12}, method="moreau", step=1e-4)
    assert not run.success and "masses differ so much" in run.message


def test_what_jams_beside_a_light_rod_at_rest_goes_on(workshop: Workshop) -> None:
    """Painleve's rod has an impact without collision; a light rod that stands 8 m away has no part in it."""
    text = (
        'name = "two"\n[[link]]\nname = "rod"\nfree = true\nmass = 1.0\ninertia = 0.08333333333333333\n'
        "com = [0.5, 0]\npoints = { A = [0, 0], T = [1.0, 0] }\n"
        '[[link]]\nname = "r"\nfree = true\nmass = 1.0\ninertia = 1e-12\ncom = [0, 0]\n'
        "points = { L = [-0.2, 0], R = [0.2, 0] }\n[gravity]\n"
        '[[ground]]\nrestitution = 0.0\nfriction = 1.5\ncontacts = ["rod.A", "rod.T"]\n'
        '[[ground]]\nrestitution = 0.0\nfriction = 0.3\ncontacts = ["r.L", "r.R"]\n'
        '[start]\nposes = { rod = [0.0, 0.0, "58 deg"], r = [8.0, 0, 0] }\n[run]\nuntil = 0.5\n'
    )
    model = workshop.model(text)
    q, u = model.start()
    u = np.array(u)
    u[list(model.q_names).index("slide_0")] = -2.0
    run = simulate(model, q, u)
    assert run.success, run.message
    assert any(contact[0] == "rod.A" for impact in run.impacts for contact in impact.contacts)


@pytest.mark.parametrize("friction", ["", "friction = 0.0", "friction = 0.3"])
@pytest.mark.parametrize("arm", [0.2, 0.25])
def test_a_light_rod_at_rest_hides_no_bounce_of_a_ball_beside_it(arm: float, friction: str, workshop: Workshop) -> None:
    """What does not move what strikes is no part of the impact."""
    text = (
        'name = "beside"\n[[link]]\nname = "b"\nfree = true\nmass = 1.0\ninertia = 0.1\ncom = [0, 0]\n'
        'points = { C = [0, 0] }\n[[link]]\nname = "r"\nfree = true\nmass = 1.0\ninertia = 1e-12\ncom = [0, 0]\n'
        f"points = {{ L = [{-arm!r}, 0], R = [{arm!r}, 0] }}\n[gravity]\n"
        f'[[ground]]\nrestitution = 0.7\n{friction}\ncontacts = ["b.C"]\n'
        '[[ground]]\nrestitution = 0.7\ncontacts = ["r.L", "r.R"]\n'
        "[start]\nposes = { b = [5.0, 0.3, 0], r = [0, 0, 0] }\n[run]\nuntil = 0.5\n"
    )
    run = simulate(workshop.model(text))
    assert run.success, run.message
    (impact,) = run.impacts
    speed = (2 * G * 0.3) ** 0.5
    assert sorted(impact.u_plus)[-1] == pytest.approx(0.7 * speed, rel=1e-9)
    assert impact.energy_loss == pytest.approx(0.5 * speed**2 * (1 - 0.49), rel=1e-9)


@pytest.mark.parametrize("law", ["newton", "poisson", "stronge"])
@pytest.mark.parametrize("apart", [2e-6, 1e-6, 5e-7])
def test_rows_that_places_make_alike_are_no_matter_of_masses(law: str, apart: float, workshop: Workshop) -> None:
    """Two points beside each other under the middle of a beam strike as one would, and bounce straight up."""
    text = (
        'name = "beam"\n[[link]]\nname = "r"\nmass = 2.0\ninertia = 0.5\ncom = [0, 0]\n'
        f"points = {{ A = [{-apart!r}, 0], B = [{apart!r}, 0], E = [0, 1.0] }}\n[gravity]\n"
        '[[ground]]\nrestitution = 0.5\ncontacts = ["r.A", "r.B", "r.E"]\n'
        f'[start]\nposition = [0.0, 0.3]\nangles = {{ r = 0 }}\n[run]\nlaw = "{law}"\nuntil = 0.3\n'
    )
    run = simulate(workshop.model(text))
    assert run.success, run.message
    (impact,) = run.impacts
    assert min(impact.impulses) > 0.0
    assert impact.u_plus == pytest.approx([0.0, 0.5 * (2 * G * 0.3) ** 0.5, 0.0], rel=1e-12, abs=1e-9)
