"""Journals in bearings and slots: rows against geometry, closed forms, the pin without clearance, a slider-crank's ten
turns, words and pictures."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.special import ellipk

from ccgen.generator import load_scene
from ccgen.runtime import simulate, static_equilibrium

from ..support.folders import SCENES
from ..support.player_page import data_of
from ..support.tiers import hard
from ..support.touching_scenes import free_body
from ..support.workshop import Workshop

G = 9.81
LINKS = """
[ground_link]
points = { O = [0.3, -0.2], Q = [1.4, 0.5] }
[[link]]
name = "a"
mass = 1.0
inertia = 0.2
com = [0.4, 0.1]
points = { A = [0.1, 0.2], B = [1.0, -0.1], M = [0.5, 0.3] }
[[link]]
name = "b"
mass = 1.5
inertia = 0.1
com = [0.3, 0]
points = { A = [0, 0], B = [0.8, 0] }
[[link]]
name = "c"
mass = 0.7
inertia = 0.3
com = [0.2, -0.1]
points = { A = [0.1, 0.1], B = [1.1, 0.4] }
"""
FLOATING = LINKS + '[[joint]]\nbetween = ["a.B", "b.A"]\n[[joint]]\nbetween = ["b.B", "c.A"]\n'
SLIDING = (
    LINKS + '[[joint]]\nbetween = ["ground.O", "a.A"]\n'
    '[[joint]]\ntype = "pin-in-slot"\nbetween = ["a.B", "b.A"]\naxis = [1, 2]\n'
    '[[joint]]\ntype = "prismatic"\nbetween = ["b.B", "c.A"]\naxis = "20 deg"\nangle = "40 deg"\n'
)
SIDES = (
    ("a.M", ("c.B",), 0.02),
    ("c.B", ("a.A", "a.B"), 0.0),
    ("c.B", ("ground.O", "ground.Q"), 0.03),
    ("b.B", ("ground.Q",), 0.01),
)
"""Pins, what they are in, and their radii; each has a clearance of 9 m, so that no state is outside."""
CLEARANCE = 9.0
JOURNALS = "".join(
    f'[[journal]]\nbetween = ["{pin}", {list(hole) if len(hole) > 1 else hole[0]!r}]\nradius = {radius}\n'
    f"clearance = {CLEARANCE}\nrestitution = 0.3\nfriction = 0.4\n".replace("'", '"')
    for pin, hole, radius in SIDES
)


def carried(model: Any, name: str, place: complex, q: Any, u: Any) -> complex:
    """Velocity of the material point of a link, or of the ground, that is at a place."""
    link = name.partition(".")[0]
    if link == "ground":
        return 0j
    k = model.links.index(link)
    pose, (x, y, w) = model.poses(q)[k], model.velocities(q, u)[k]
    return complex(x, y) + 1j * w * (place - complex(pose[0], pose[1]))


def offs(model: Any, q: Any) -> list[tuple[complex, complex, float]]:
    """Per journal the pin's centre, its way from the nearest point of the middle, and how far that is inside a slot."""
    found = []
    for pin, hole, _ in SIDES:
        centre, ends = complex(*model.point(pin, q)), [complex(*model.point(name, q)) for name in hole]
        share = ((centre - ends[0]) / (ends[-1] - ends[0])).real if len(hole) > 1 else 0.0
        foot = ends[0] + np.clip(share, 0.0, 1.0) * (ends[-1] - ends[0])
        found.append((centre, centre - foot, min(share, 1.0 - share) if len(hole) > 1 else -1.0))
    return found


def gaps(model: Any, q: Any) -> Any:
    return np.array([(CLEARANCE**2 - abs(off) ** 2) / (2 * CLEARANCE) for _, off, _ in offs(model, q)])


def along(function: Any, h: float = 2e-3) -> tuple[Any, Any]:
    """First and second derivatives at zero by central differences of order 8."""
    values = [function(k * h) for k in range(-4, 5)]
    first = [1 / 280, -4 / 105, 1 / 5, -4 / 5, 0, 4 / 5, -1 / 5, 4 / 105, -1 / 280]
    second = [-1 / 560, 8 / 315, -1 / 5, 8 / 5, -205 / 72, 8 / 5, -1 / 5, 8 / 315, -1 / 560]
    return (
        sum(c * v for c, v in zip(first, values, strict=True)) / h,
        sum(c * v for c, v in zip(second, values, strict=True)) / h**2,
    )


def kernel(model: Any, name: str, q: Any, u: Any) -> Any:
    return model.kernels.of_state(name, q[None].copy(), u[None].copy())[0]


@pytest.mark.parametrize("form", [hard("floating"), "sliding"])
def test_rows_are_derivatives_of_the_gap_everywhere(form: str, workshop: Workshop) -> None:
    """Rates and biases at random states on every branch, and in the middle, where a distance has no derivative."""
    text = {"floating": FLOATING, "sliding": SLIDING}[form]
    model = workshop.model(text + JOURNALS + "[start]\nangles = { a = 0.3, b = 1.2 }\n")
    rng, n, branches = np.random.default_rng(4), len(model.q_names), set()
    for _ in range(40):
        q, u = rng.normal(size=n), 0.3 * rng.normal(size=n)
        assert model.gaps(q) == pytest.approx(gaps(model, q), abs=1e-13)
        rate, bias = along(lambda s, q=q, u=u: gaps(model, q + s * u))
        turning, _ = along(lambda s, q=q, u=u: kernel(model, "slips", q + s * u, u))
        inside = np.array([share for _, _, share in offs(model, q)])
        smooth = np.abs(inside) > 0.02
        branches |= {(k, bool(inside[k] > 0)) for k in np.flatnonzero(smooth)}
        for name, wanted, accuracy in (
            ("gap_rates", rate, 1e-10),
            ("gap_bias", bias, 1e-7),
            ("slip_bias", turning, 1e-9),
        ):
            assert kernel(model, name, q, u)[smooth] == pytest.approx(wanted[smooth], abs=accuracy), name
        slips = kernel(model, "slips", q, u)
        for k, ((pin, hole, radius), (centre, off, _)) in enumerate(zip(SIDES, offs(model, q), strict=True)):
            tangent, outwards = 1j * off / CLEARANCE, off / abs(off)
            foot = centre - off
            drift = carried(model, pin, centre, q, u) - carried(model, hole[0], foot, q, u)
            spins = [
                (carried(model, name, 1 + 0j, q, u) - carried(model, name, 0j, q, u)).imag for name in (pin, hole[0])
            ]
            wanted = (drift * tangent.conjugate()).real + radius * spins[0] - (radius + CLEARANCE) * spins[1]
            assert slips[k] == pytest.approx(wanted, abs=1e-12), outwards
    assert {(1, True), (1, False), (2, True), (2, False)} <= branches


def test_the_middle_is_no_special_place(workshop: Workshop) -> None:
    """Where the pin is exactly in the middle its gap is half of the clearance, at rest to first order."""
    model = workshop.model(bowl(0.1, "restitution = 0.5"))
    q, u = np.zeros(3), np.array([0.3, -0.2, 1.0])
    assert model.gaps(q) == pytest.approx([0.05])
    assert model.gap_rates(q, u) == pytest.approx([0.0], abs=1e-16)
    assert kernel(model, "gap_bias", q, u) == pytest.approx([-(0.3**2 + 0.2**2) / 0.1], rel=1e-13)


def bowl(clearance: float, journal: str, start: str = "", radius: float = 0.05, inertia: float = 0.002) -> str:
    """A disc of 2 kg inside a fixed round hole about the origin, free otherwise."""
    return (
        "[ground_link]\npoints = { O = [0, 0] }\n"
        f'[[link]]\nname = "disc"\nmass = 2.0\ninertia = {inertia!r}\ncom = [0, 0]\npoints = {{ C = [0, 0] }}\n'
        f'[[journal]]\nbetween = ["disc.C", "ground.O"]\nradius = {radius!r}\nclearance = {clearance!r}\n{journal}\n'
        f"[gravity]\ng = {G}\n[start]\n{start}\n"
    )


@pytest.mark.parametrize("rolls", [False, True])
def test_a_disc_swings_in_a_bowl(rolls: bool, workshop: Workshop) -> None:
    """As a pendulum as long as the clearance; the longer by √(1 + I/mr²) if it rolls, with the reaction of that."""
    clearance, angle = 0.12, 1.1
    place = clearance * np.array([math.sin(angle), -math.cos(angle)])
    friction = "friction = 5.0" if rolls else ""
    text = bowl(clearance, f"restitution = 0.0\n{friction}", f"position = {place.tolist()}")
    longer = 1.0 + (0.002 / (2.0 * 0.05**2) if rolls else 0.0)
    period = 4 * math.sqrt(clearance * longer / G) * float(ellipk(math.sin(angle / 2) ** 2))
    run = simulate(workshop.model(text), until=period, rtol=1e-12)
    q, u = run.q[-1], run.u[-1]
    assert q[:2] == pytest.approx(place, abs=1e-9) and np.max(np.abs(u)) <= 1e-7
    turned = run.at(period / 2)[0][2] - run.q[0][2]
    assert turned == pytest.approx(2 * angle * clearance / 0.05 if rolls else 0.0, abs=1e-9)
    q, u = run.at(period / 4)
    speed = clearance / 0.05 * abs(u[0]) / clearance if rolls else 0.0
    square = 2 * G * clearance * (1 - math.cos(angle)) / longer
    assert u[0] ** 2 == pytest.approx(square, rel=1e-9) and abs(u[2]) == pytest.approx(speed, abs=1e-9)
    assert run.contact_forces(period / 4)[0, 0] == pytest.approx(2.0 * (G + square / clearance), rel=1e-9)
    assert {how for phase in run.phases for how in (phase.how or ())} == {"sticks" if rolls else "smooth"}


def test_a_disc_that_slides_comes_to_roll(workshop: Workshop) -> None:
    """Spun at the bottom of a bowl, without gravity's help: friction brings it to rolling, and takes no more energy
    than the sliding had."""
    text = bowl(0.1, "restitution = 0.0\nfriction = 0.2", "position = [0, -0.1]\nangular_velocities = { disc = 40.0 }")
    run = simulate(workshop.model(text), until=1.5)
    ways = [how for phase in run.phases for how in (phase.how or ())]
    assert any("slides" in way for way in ways) and "sticks" in ways
    energies = np.array([sum(run.model.energy(q, u)) for q, u in zip(run.q, run.u, strict=True)])
    assert np.max(np.diff(energies)) <= 1e-10 and run.energy_drift <= 1e-8
    assert np.max(np.abs(run.model.gaps(run.q))) <= 1e-12


def hung(pin: str, extra: str) -> str:
    """A rod of 1.3 kg at the origin, under gravity, its hole H 0.4 m from its centre of mass."""
    return f"[ground_link]\npoints = {{ O = [0, 0] }}\n{pin}[gravity]\ng = {G}\n{extra}"


@pytest.mark.sample(2)
@pytest.mark.parametrize(("angle", "spin"), [(-0.3, 0.0), (0.8, 2.0), (2.9, 7.0)])
@pytest.mark.parametrize("clearance", [0.02, 1e-6])
def test_the_reaction_of_a_pin_without_clearance(
    angle: float, spin: float, clearance: float, workshop: Workshop
) -> None:
    """A hole that turns about its own centre, where that is in the direction of the pin's reaction: the journal pushes
    as a pin pushes, and the rod moves as on a pin."""
    rod = '[[link]]\nname = "rod"\nmass = 1.3\ninertia = 0.05\ncom = [0.4, 0]\npoints = { H = [0, 0] }\n'
    ideal = workshop.model(hung(rod + '[[joint]]\nbetween = ["ground.O", "rod.H"]\n', ""))
    state = np.array([angle]), np.array([spin])
    force = ideal.reactions(*state)[0, :2]
    size = float(np.hypot(*force))
    journal = (
        f'[[journal]]\nbetween = ["ground.O", "rod.H"]\nradius = 0.01\nclearance = {clearance!r}\nrestitution = 0.0\n'
    )
    model = workshop.model(hung(rod + journal, ""))
    q = np.array([*(-clearance * force / size), angle])  # the rod's hole is below its pin where it is held up
    q[:2] *= -1.0 if model.gap_rates(q, np.array([*force, 0.0]))[0] < 0.0 else 1.0
    u = np.array([0.0, 0.0, spin])
    assert model.contact_forces(q, u)[0, 0] == pytest.approx(size, rel=1e-9)
    found = model.acceleration(q, u)
    assert found[2] == pytest.approx(float(ideal.acceleration(*state)[0]), rel=1e-9)
    assert found[:2] == pytest.approx([0.0, 0.0], abs=1e-9 * size)


def test_rest_in_a_slot(workshop: Workshop) -> None:
    """A pin rests on the lower side of a slot that falls, held by friction, or at its end without."""
    slope, reach = 0.2, 0.01
    ends = [[0.0, 0.0], [math.cos(slope), -math.sin(slope)]]

    def text(friction: str, along_: float) -> str:
        place = along_ * complex(*ends[1]) - reach * complex(math.sin(slope), math.cos(slope))
        return (
            f"[ground_link]\npoints = {{ A = {ends[0]}, B = {ends[1]} }}\n"
            '[[link]]\nname = "car"\nmass = 2.0\ninertia = 0.1\ncom = [0, 0]\npoints = { C = [0, 0] }\n'
            '[[journal]]\nbetween = ["car.C", ["ground.A", "ground.B"]]\nradius = 0.0\n'
            f"clearance = {reach}\nrestitution = 0.0\n{friction}\n[gravity]\ng = {G}\n"
            f"[start]\nposition = [{place.real!r}, {place.imag!r}]\n"
        )

    held = workshop.model(text("friction = 0.5", 0.4))
    q, u = held.start()
    push = 2.0 * G * np.array([math.cos(slope), math.sin(slope)])
    assert np.abs(held.contact_forces(q, u)[0]) == pytest.approx(push, rel=1e-12)
    assert held.acceleration(q, u) == pytest.approx([0.0] * 3, abs=1e-12)
    run = simulate(workshop.model(text("", 0.4)), until=3.0)
    slid = math.sqrt(2 * 0.6 / (G * math.sin(slope)))
    assert run.at(0.5 * slid)[0][:2] == pytest.approx(
        np.array(ends[1]) * (0.4 + 0.15) + reach * np.array([-math.sin(slope), -math.cos(slope)]), abs=1e-9
    )
    assert np.min(run.model.gaps(run.q)) >= -1e-13
    found = static_equilibrium(run.model, run.q[-1])
    assert found.q[:2] == pytest.approx([ends[1][0], ends[1][1] - reach], abs=1e-7)
    assert found.contact_forces[0] == pytest.approx([2.0 * G, 0.0], abs=1e-9)


def test_momenta_stay_in_a_bearing_that_moves(workshop: Workshop) -> None:
    """Two free bodies, rough: what the journal has, its bearing loses, whether it strikes, rolls or slides."""
    masses = {"a": 1.0, "b": 0.7}
    bodies = "".join(free_body(name, mass, 0.003, "C = [0, 0], E = [0.1, 0.05]") for name, mass in masses.items())
    text = (
        f"[ground_link]\npoints = {{ O = [0, 0] }}\n{bodies}"
        '[[journal]]\nbetween = ["a.E", "b.C"]\nradius = 0.1\nclearance = 0.05\nrestitution = 0.6\nfriction = 0.4\n'
        "[start]\nslides = { x_a = -0.1, y_a = -0.05, x_b = 0.0, y_b = 0.0 }\n"
        "sliding_velocities = { x_a = -1.0, y_a = 0.3, x_b = 0.1, y_b = 0.9 }\n"
        "angular_velocities = { a = 6.0, b = -3.0 }\n"
    )
    run = simulate(workshop.model(text), until=2.0)
    model, mass = run.model, np.array([*masses.values()])
    links = [model.links.index(name) for name in masses]

    def momenta(q: Any, u: Any) -> list[float]:
        poses, velocities = model.poses(q)[links], model.velocities(q, u)[links]
        turning = poses[:, 0] * velocities[:, 1] - poses[:, 1] * velocities[:, 0]
        return [*(mass @ velocities[:, :2]), float(mass @ turning + 0.003 * velocities[:, 2].sum())]

    found = np.array([momenta(q, u) for q, u in zip(run.q, run.u, strict=True)])
    assert len(run.impacts) >= 5 and np.max(np.abs(found - found[0])) <= 1e-9
    energies = np.array([sum(model.energy(q, u)) for q, u in zip(run.q, run.u, strict=True)])
    assert np.max(np.diff(energies)) <= 1e-10


# -- slider-cranks and a four-bar --------------------------------------------------------------------------------------


def loose(clearance: str = "0.2 mm", restitution: float = 0.6, friction: float = 0.05, free: bool = False) -> str:
    """The slider-crank with three loose bearings; ``free``: nothing drives it, nothing falls, it runs on."""
    text = (SCENES / "loose-slider-crank.toml").read_text(encoding="utf-8").replace('"0.2 mm"', f'"{clearance}"')
    text = text.replace("restitution = 0.6", f"restitution = {restitution}")
    text = text.replace("friction = 0.05\n", f"friction = {friction}\n" if friction else "")
    if free:
        text = text[: text.index("[[drive]]")] + text[text.index("[start]") :]
        text = text.replace("angular_velocities = { rod", 'angular_velocities = { crank = "speed", rod')
    return text


@pytest.mark.parametrize("friction", [0.0, 0.05])
def test_ten_turns_of_a_slider_crank_with_three_clearances(friction: float, workshop: Workshop) -> None:
    """Energy is lost at impacts, and to friction, alone; no pin is outside its bearing; the parts never come apart."""
    run = simulate(workshop.model(loose(friction=friction, free=True)))
    assert run.success and len(run.impacts) > 50
    model = run.model
    assert np.min(model.gaps(run.q)) >= -1e-14
    energies = np.array([sum(model.energy(q, u)) for q, u in zip(run.q, run.u, strict=True)])
    assert np.max(np.diff(energies)) <= 1e-11 * energies[0]
    assert all(impact.energy_loss >= 0.0 for impact in run.impacts)
    lost = math.fsum(impact.energy_loss for impact in run.impacts)
    if not friction:
        assert energies[0] - energies[-1] == pytest.approx(lost, abs=1e-9 * energies[0])
        turned = run.q[-1][model.q_names.index("theta_2")] - run.q[0][model.q_names.index("theta_2")]
        assert turned == pytest.approx(20 * math.pi, rel=0.1)
    assert lost <= energies[0] - energies[-1] + 1e-9 * energies[0]
    assert run.energy_drift <= 1e-8 * energies[0]


def test_a_slider_crank_comes_near_the_ideal_one(workshop: Workshop) -> None:
    """The slider is never farther from where pins without clearance have it than what three clearances allow; and
    with bearings that damp, their forces become those of pins in proportion to nothing but the clearance."""
    throw, length = 0.05, 0.12
    for clearance in ("0.1 mm", "0.01 mm"):
        text = loose(clearance, restitution=0.0, friction=0.1).replace('until = "20*pi/speed"', 'until = "2*pi/speed"')
        run = simulate(workshop.model(text))
        size = float(clearance.split()[0]) * 1e-3
        angles = np.array([model_angle(run.model, q) for q in run.q])
        ideal = throw * np.cos(angles) + np.sqrt(length**2 - (throw * np.sin(angles)) ** 2)
        slid = np.array([run.model.point("slider.pin", q)[0] for q in run.q])
        lean = 1.0 / np.sqrt(1.0 - (throw * np.sin(angles) / length) ** 2)
        assert np.max(np.abs(slid - ideal) / lean) <= 3.01 * size
        assert np.max(np.abs(slid - ideal)) >= 0.1 * size


def model_angle(model: Any, q: Any) -> float:
    return float(model.poses(q)[model.links.index("crank"), 2])


def test_the_four_bar_with_clearances_of_siconos(workshop: Workshop) -> None:
    """Lengths, masses and the start of Siconos' FourBarLinkageWith3clearance: its three distances from the middle at
    the start are those that its reference file has. Driven once round, the rocker stays near where pins have it."""
    l0, l1, l2, l3, clearance = 3.0, 1.0, 4.0, 2.5, 0.005
    start = (1.570823772407980, 0.3532842020624460, 1.264872058968431)
    coupler, rocker = 1.876454585097650 + 1.691962091335582j, 0.3764686197082958 + 1.191962183453451j
    bearings = (("crank.B", "coupler.A"), ("coupler.B", "rocker.B"), ("ground.E", "rocker.A"))
    journal = "radius = 0.055\nclearance = 0.005\nrestitution = 0.0\nfriction = 0.1\n"
    text = (
        f"[ground_link]\npoints = {{ O = [0, 0], E = [{l0}, 0] }}\n"
        f'[[link]]\nname = "crank"\nmass = 1.0\ninertia = {l1**2 / 12!r}\ncom = [{l1 / 2}, 0]\n'
        f"points = {{ A = [0, 0], B = [{l1}, 0] }}\n"
        + free_body("coupler", 1.0, l2**2 / 12, f"C = [0, 0], A = [{-l2 / 2}, 0], B = [{l2 / 2}, 0]")
        + free_body("rocker", 1.0, l3**2 / 12, f"C = [0, 0], A = [{-l3 / 2}, 0], B = [{l3 / 2}, 0]")
        + '[[joint]]\nname = "motor"\nbetween = ["ground.O", "crank.A"]\n'
        + "".join(f'[[journal]]\nbetween = ["{a}", "{b}"]\n{journal}' for a, b in bearings)
        + f'[gravity]\ng = {G}\n[[drive]]\njoint = "motor"\nspeed = "4*t"\n'
        + f"[start]\nangles = {{ crank = {start[0]!r}, coupler = {start[1]!r}, rocker = {start[2]!r} }}\n"
        + f"slides = {{ x_coupler = {coupler.real!r}, y_coupler = {coupler.imag!r}, x_rocker = {l0 + rocker.real!r}, "
        + f"y_rocker = {rocker.imag!r} }}\n"
    )
    model = workshop.model(text)
    q, _ = model.start()
    off = [float(np.hypot(*(model.point(a, q) - model.point(b, q)))) for a, b in bearings]
    assert off == pytest.approx([9.756343462327728e-07, 9.932485594798714e-07, 9.873637627117759e-07], abs=2e-15)
    run = simulate(model, until=1.75)
    assert run.success and np.min(model.gaps(run.q)) >= -1e-13
    poses = np.array([model.poses(q) for q in run.q])
    crank, rocker_at = (poses[:, model.links.index(name), 2] for name in ("crank", "rocker"))
    assert crank[-1] - crank[0] == pytest.approx(2 * 1.75**2, rel=1e-9)
    tip = l1 * np.exp(1j * crank) - l0
    ideal = np.angle(tip) - np.arccos((np.abs(tip) ** 2 + l3**2 - l2**2) / (2 * np.abs(tip) * l3))
    transmission = np.abs(np.sin(np.arccos((l2**2 + l3**2 - np.abs(tip) ** 2) / (2 * l2 * l3))))
    miss = np.abs(np.angle(np.exp(1j * (rocker_at - ideal))))
    assert np.max(miss * l3 * transmission) <= 3.05 * clearance and np.max(miss) > 0.1 * clearance


# -- words and pictures ------------------------------------------------------------------------------------------------


def test_what_is_said_and_drawn_of_journals(workshop: Workshop, tmp_path: Path) -> None:
    from ccgen.generator.documents.show import show_text

    scene = load_scene(SCENES / "loose-slider-crank.toml")
    shown = show_text(scene, False, False)
    assert "big_end: crank.pin in rod.big_end, big_end.radius = 0.008, big_end.clearance = 0.0002" in shown
    assert "crank.pin on big_end: a disc of 0.008 m (big_end.radius), turns with crank" in shown
    model = workshop.model(scene)
    assert [(disc.link, disc.radius) for disc in model.discs[:4]] == [
        (model.links.index("crank"), 0.01),
        (-1, 0.0102),
        (model.links.index("crank"), 0.008),
        (model.links.index("rod"), pytest.approx(0.0082)),
    ]
    drawn = {name for name, outline in zip(model.links, model.outlines, strict=True) if len(outline)}
    assert drawn == {"crank", "rod", "slider"}  # links of one point without mass only carry others
    wider = model.with_parameters({"main_bearing.clearance": 0.005})
    assert wider.discs[1].radius == pytest.approx(0.015)
    run = simulate(model, until=0.01)
    run.plot(tmp_path / "run.png")
    content = data_of(run.animate(tmp_path / "run.html").read_text(encoding="utf-8"))
    assert len(content["fixed"]["discs"]) == 1 and content["ropes"] == []
    with pytest.raises(ValueError, match=r"main_bearing\.clearance: found 0.0, expected a positive number"):
        model.with_parameters({"main_bearing.clearance": 0.0})
    far = model.start()[0].copy()
    far[model.q_names.index("slide_0")] += 0.001
    with pytest.raises(ValueError, match=r"inside big_end by .* m; change the start"):
        simulate(model, q0=far, u0=model.start()[1], until=0.01)
