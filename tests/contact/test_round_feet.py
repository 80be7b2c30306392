"""Round feet: discs that roll, slide and bounce on half-planes, against closed forms."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from ccgen.generator.documents.discs import disc_lines
from ccgen.generator.scene import SceneError
from ccgen.runtime import simulate

from ..support.wheel import INERTIA, MASS, NORMAL, RADIUS, SLOPE, TANGENT, G, wheel
from ..support.workshop import Workshop

CRITICAL = np.tan(SLOPE) / (1 + MASS * RADIUS**2 / INERTIA)
"""Friction below which the wheel slides down."""


@pytest.fixture(scope="module")
def rolling(workshop: Workshop) -> Any:
    return workshop.model(wheel("friction = 0.5"))


def test_a_wheel_rolls_down_without_slipping(rolling: Any) -> None:
    """a = g sin / (1 + I / (m r^2)), the turning to match, and no energy lost."""
    run = simulate(rolling, until=2.0)
    a = G * np.sin(SLOPE) / (1 + INERTIA / (MASS * RADIUS**2))
    assert [(phase.kind, phase.how) for phase in run.phases] == [("contact", ("sticks",))]
    assert run.u[-1, :2] == pytest.approx(2 * a * TANGENT, rel=1e-10)
    assert run.u[-1, 2] == pytest.approx(-2 * a / RADIUS, rel=1e-10)
    assert run.q[-1, :2] == pytest.approx(RADIUS * NORMAL + 2 * a * TANGENT, rel=1e-9)
    assert run.energy_drift <= 1e-9 and np.max(np.abs(rolling.gaps(run.q))) <= 1e-11


@pytest.mark.parametrize("ratio", [0.5, 0.99, 1.01])
def test_the_critical_friction_divides_sliding_from_rolling(rolling: Any, ratio: float) -> None:
    """Below tan / (1 + m r^2 / I) it slides: a = g (sin - mu cos), alpha = mu m g cos r / I."""
    mu = ratio * CRITICAL
    model = rolling.with_parameters({"ground_0.friction": mu})
    run = simulate(model, until=1.0)
    a, alpha = G * (np.sin(SLOPE) - mu * np.cos(SLOPE)), mu * MASS * G * np.cos(SLOPE) * RADIUS / INERTIA
    if ratio > 1:
        a = G * np.sin(SLOPE) / (1 + INERTIA / (MASS * RADIUS**2))
        alpha = a / RADIUS
    assert [phase.how for phase in run.phases] == [("sticks" if ratio > 1 else "slides forward",)]
    assert run.u[-1, :2] @ TANGENT == pytest.approx(a, rel=1e-9)
    assert run.u[-1, 2] == pytest.approx(-alpha, rel=1e-9)


def test_a_sliding_ball_begins_to_roll(workshop: Workshop) -> None:
    """Level ground, thrown without spin at v: rolls from t = v / (mu g (1 + m r^2 / I)) on, at what is left of v."""
    text = wheel("friction = 0.3", place=f"position = [0, {RADIUS}]\nvelocity = [3, 0]")
    model = workshop.model(text.replace(f"normal = {NORMAL.tolist()}", "normal = [0, 1]"))
    run = simulate(model, until=1.0)
    ratio = MASS * RADIUS**2 / INERTIA
    assert [phase.how for phase in run.phases if phase.kind == "contact"] == [("slides forward",), ("sticks",)]
    assert run.phases[-1].start == pytest.approx(3 / (0.3 * G * (1 + ratio)), rel=1e-9)
    left = 3 * ratio / (1 + ratio)
    assert run.u[-1] == pytest.approx([left, 0.0, -left / RADIUS], rel=1e-9, abs=1e-12)


@pytest.mark.parametrize("spin", [-4.0, 30.0])
def test_a_spinning_ball_bounces_off_rough_ground(workshop: Workshop, spin: float) -> None:
    """Sticks in impact where mu (1 + e) v suffices to stop the slip w r; otherwise slides through, at the limit."""
    e, v, mu = 0.5, 2.0, 0.3
    text = wheel(f"friction = {mu}", place="position = [0, 1]", restitution=e)
    model = workshop.model(text.replace(f"normal = {NORMAL.tolist()}", "normal = [0, 1]"))
    q, _ = model.start()
    q[1] = RADIUS
    after, impulses = model.impact(q, np.array([0.0, -v, spin]), model.contacts)
    stops = abs(spin * RADIUS) / (1 / MASS + RADIUS**2 / INERTIA)
    pull = -np.sign(spin) * min(stops, mu * MASS * (1 + e) * v)
    assert impulses == pytest.approx([MASS * (1 + e) * v], rel=1e-12)
    assert after == pytest.approx([pull / MASS, e * v, spin + RADIUS * pull / INERTIA], rel=1e-12)
    assert (after[0] + RADIUS * after[2] == pytest.approx(0.0, abs=1e-12)) == (stops < mu * MASS * (1 + e) * v)


def test_a_smooth_ball_strikes_where_its_surface_is(workshop: Workshop) -> None:
    """Falls by its height less the radius, and keeps its spin."""
    text = wheel("", place="position = [0, 1]", restitution=0.5)
    model = workshop.model(text.replace(f"normal = {NORMAL.tolist()}", "normal = [0, 1]"))
    run = simulate(model, u0=[0.0, 0.0, 5.0], until=0.6)
    assert run.impacts[0].t == pytest.approx(np.sqrt(2 * (1 - RADIUS) / G), rel=1e-9)
    assert run.impacts[0].u_plus == pytest.approx([0.0, 0.5 * np.sqrt(2 * G * (1 - RADIUS)), 5.0], rel=1e-9)


FEET = """
[chain]
links = 3
[gravity]
[start]
height = 2.0
angles = [0.3, -0.2, 0.5]
[[ground]]
normal = [0.3, 1.0]
restitution = 0.4
friction = 0.6
contacts = ["link_0.A", "joint_1", "link_2.B"]
radius = [0.1, 0, 0.25]
"""


@pytest.fixture(scope="module")
def feet(workshop: Workshop) -> Any:
    return workshop.model(FEET)


def test_each_contact_has_its_own_radius(feet: Any) -> None:
    """Gaps and sliding from positions and velocities of the points, for random states."""
    rng = np.random.default_rng(8)
    normal = np.array([0.3, 1.0]) / np.hypot(0.3, 1.0)
    tangent = np.array([normal[1], -normal[0]])
    q, _ = feet.start()
    q, u = q + rng.normal(size=q.size), rng.normal(size=q.size)
    radii = np.array([0.1, 0.0, 0.25])
    names = [point for point, _ in feet.contacts]
    places = np.array([feet.point(name, q) for name in names])
    assert feet.gaps(q) == pytest.approx(places @ normal - radii, abs=1e-12)
    step = 1e-6
    moved = [np.array([feet.point(name, q + s * u) for name in names]) for s in (step, -step)]
    velocities = (moved[0] - moved[1]) / (2 * step)
    spins = np.array([u[feet.u_names.index(f"w_{k}")] for k in (0, 0, 2)])
    slips = feet.kernels.of_state("slips", q[None].copy(), u[None].copy())[0]
    assert slips == pytest.approx(velocities @ tangent + radii * spins, abs=1e-8)
    assert feet.gap_rates(q, u) == pytest.approx(velocities @ normal, abs=1e-8)


def test_friction_acts_where_the_feet_touch(feet: Any) -> None:
    """What an impact leaves beside its normal impulse is along the sliding of the touching point, and obeys Coulomb."""
    rng = np.random.default_rng(9)
    q, _ = feet.start()
    unit = np.eye(q.size)

    def kinetic(u: Any) -> float:
        return float(feet.energy(q, u)[0])

    mass = np.array([[kinetic(a + b) - kinetic(a) - kinetic(b) for b in unit] for a in unit])
    normals = np.array([feet.gap_rates(q, a) for a in unit]).T
    tangents = np.array([feet.kernels.of_state("slips", q[None].copy(), a[None].copy())[0] for a in unit]).T
    compared = 0
    for _ in range(20):
        u = rng.normal(size=q.size)
        for k in np.flatnonzero(normals @ u < 0):
            after, impulses = feet.impact(q, u, [feet.contacts[k]])
            left = mass @ (after - u) - impulses[0] * normals[k]
            pull = left @ tangents[k] / (tangents[k] @ tangents[k])
            assert left == pytest.approx(pull * tangents[k], abs=1e-10)
            assert abs(pull) <= 0.6 * impulses[0] * (1 + 1e-10)
            slip = tangents[k] @ after
            sticks = abs(slip) <= 1e-10
            assert sticks or pull == pytest.approx(-0.6 * impulses[0] * np.sign(slip), rel=1e-9)
            compared += 1
    assert compared >= 20


def test_parameters(workshop: Workshop, feet: Any, rolling: Any) -> None:
    """One radius for all is one parameter; a list has one per contact, zeros are structural."""
    assert rolling.parameters["ground_0.radius"] == RADIUS
    assert [name for name in feet.parameters if "radius" in name] == [
        "ground_0.radius.link_0.A",
        "ground_0.radius.link_2.B",
    ]
    thicker = rolling.with_parameters({"ground_0.radius": 0.3})
    q, _ = rolling.start()
    assert thicker.gaps(q) == pytest.approx(rolling.gaps(q) - 0.1, abs=1e-15)


BAD: dict[str, tuple[str, str, str, tuple[str, ...]]] = {
    "negative radius": ("radius = [0.1, 0, 0.25]", "radius = -0.1", "ground[0].radius", ("found -0.1", "not negative")),
    "negative in a list": ("[0.1, 0, 0.25]", "[0.1, 0, -2]", "ground[0].radius[2]", ("found -2", "not negative")),
    "too few": (
        "[0.1, 0, 0.25]",
        "[0.1, 0]",
        "ground[0].radius",
        ("found 2 values", "expected 3", "one number for all"),
    ),
    "text": ("[0.1, 0, 0.25]", '"far"', "ground[0].radius", ('found "far"', "without quotes")),
    "start inside": (
        "height = 2.0",
        "height = 0.05",
        "start.height",
        ("inside ground_0 by", "raise or move the start"),
    ),
}


@pytest.mark.parametrize("case", BAD, ids=lambda case: case.replace(" ", "-"))
def test_faults_name_key_and_advice(case: str, workshop: Workshop) -> None:
    from ccgen.generator.scene import SceneError

    old, new, key, words = BAD[case]
    assert old in FEET
    with pytest.raises(SceneError) as caught:
        workshop.scene(FEET.replace(old, new))
    assert all(f" {key}: " in f" {fault}" for fault in caught.value.faults)
    assert all(word in str(caught.value.faults[0]) for word in words), caught.value.faults


CART = """
[[link]]
name = "frame"
mass = 2.0
inertia = 0.1
com = [0, 0.1]
points = { rear = [-0.3, 0], front = [0.3, 0] }
[[link]]
name = "wheel"
mass = 0.5
inertia = 0.002
com = [0, 0]
points = { hub = [0, 0] }
[[joint]]
name = "axle"
between = ["frame.rear", "wheel.hub"]
[gravity]
[start]
position = [0, 0.1]
"""


@pytest.mark.parametrize("friction", ["", "friction = 0.7\n"])
def test_a_disc_about_a_pin_of_two_moving_links_needs_its_link(workshop: Workshop, friction: str) -> None:
    """An axle is on the frame and on the wheel: which one the disc turns with has to be said; a point has no turn."""

    def ground(contact: str, radius: float) -> str:
        listed = f'contacts = ["frame.front", "{contact}"]\nradius = [0, {radius}]\n'
        return f"{CART}[[ground]]\nrestitution = 0.2\n{friction}{listed}"

    with pytest.raises(SceneError) as caught:
        workshop.scene(ground("axle", 0.1))
    (fault,) = caught.value.faults
    assert fault.key == "ground[0].contacts[1]"
    for words in ('a disc about "axle", a pin of frame and wheel', 'write "frame.rear" or "wheel.hub"'):
        assert words in fault.message
    workshop.scene(ground("axle", 0.0))
    scene = workshop.scene(ground("wheel.hub", 0.1))
    assert list(disc_lines(scene)) == [
        "wheel.hub on ground_0: a disc of 0.1 m (ground_0.radius.wheel.hub), turns with wheel"
    ]


def test_discs_about_all_joints_need_their_links(workshop: Workshop) -> None:
    """Where no contacts are listed, pins are meant, and the fault stands at the radius."""
    with pytest.raises(SceneError) as caught:
        workshop.scene("[loop]\nlinks = 4\n[start]\nheight = 1\n[[ground]]\nrestitution = 0.5\nradius = 0.1\n")
    assert {fault.key for fault in caught.value.faults} == {"ground[0].radius"}
    assert 'write "link_3.B" or "link_0.A" in contacts = [...]' in caught.value.faults[0].message


def test_a_disc_about_a_pin_on_the_ground_has_one_link(workshop: Workshop) -> None:
    """Only one of its links moves, so the disc is that one's, as by the name of the link's own point."""
    hooks = {"O": "one", "Q": "other"}
    swings = "".join(
        f'[[link]]\nname = "{name}"\nmass = 1\ninertia = 0.1\ncom = [0, -0.5]\n'
        "points = { hook = [0, 0], tip = [0, -1] }\n"
        f'[[joint]]\nname = "pivot_{name}"\nbetween = ["ground.{point}", "{name}.hook"]\n'
        for point, name in hooks.items()
    )
    touch = '[[touch]]\nbetween = ["pivot_one", "other.tip"]\nradius = [0.1, 0.2]\nrestitution = 0\n'
    scene = workshop.scene(f"[ground_link]\npoints = {{ O = [0, 0], Q = [3, 1] }}\n{swings}{touch}")
    assert list(disc_lines(scene)) == [
        "pivot_one on touch_0: a disc of 0.1 m (touch_0.radius.pivot_one), about one.hook, turns with one",
        "other.tip on touch_0: a disc of 0.2 m (touch_0.radius.other.tip), turns with other",
    ]


def test_a_touch_about_a_pin_of_two_moving_links_needs_its_link(workshop: Workshop) -> None:
    touching = '[[touch]]\nbetween = ["axle", "ground.O"]\nradius = 0.1\nrestitution = 0\n'
    with pytest.raises(
        SceneError, match=r"touch\[0\].between\[0\]: found a disc about \"axle\", a pin of frame and wheel"
    ):
        workshop.scene(f"{CART.replace('[0, 0.1]', '[0, 5]')}[ground_link]\npoints = {{ O = [0, 0] }}\n{touching}")
