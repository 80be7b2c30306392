"""Sticking, slipping, rocking, and where rigid bodies with friction have no motion."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import quad, solve_ivp

from ccgen.generator import chain
from ccgen.runtime import simulate

from ..support.bodies import G, block, penetration, rise, rod, speed
from ..support.reach import Reach
from ..support.workshop import Workshop

SLIDES = [(0.5, 0.3, 1.0), (0.5, 0.3, -1.0), (0.2, 0.3, 1.0), (0.2, 0.3, -1.0), (0.5, 0.3, 0.0), (0.2, 0.3, 0.0)]


def travelled(mu: float, slope: float, speed: float, time: float) -> tuple[float, float | None]:
    """Way up the slope, and when it stops sliding up or for good, in closed form."""
    down, brake = G * np.sin(slope), mu * G * np.cos(slope)
    if speed > 0.0:
        stop = speed / (down + brake)
        after = 0.0 if brake >= down else -0.5 * (down - brake) * (time - stop) ** 2
        return 0.5 * speed * stop + after, stop
    if speed < 0.0 and brake > down:
        stop = -speed / (brake - down)
        return 0.5 * speed * stop, stop
    fall = max(0.0, down - brake)
    return speed * time - 0.5 * fall * time**2, None


@pytest.mark.parametrize(("mu", "slope", "start"), SLIDES)
def test_a_block_on_a_slope(mu: float, slope: float, start: float, workshop: Workshop, reach: Reach) -> None:
    """Two contacts that are redundant sideways: sliding up, reversing or sticking, as Coulomb has it."""
    run = simulate(workshop.model(block(1.0, 0.4, mu, slope, speed=start)), until=2.0)
    assert run.success, run.message
    way, stop = travelled(mu, slope, start, 2.0)
    found = (run.q[-1, :2] - run.q[0, :2]) @ (np.cos(slope), np.sin(slope))
    name = f"block on a slope, mu = {mu}, v = {start:g}"
    reach(f"{name}: way, m", abs(found - way), 1e-12)
    reach(f"{name}: energy, J", run.energy_drift, 1e-12)
    if stop is not None:
        reach(f"{name}: time of stop, s", abs(run.phases[0].end - stop), 1e-12)
    stuck = (stop is not None or start == 0.0) and mu > np.tan(slope)
    assert (run.phases[-1].how[0] == "sticks") == stuck


@pytest.mark.parametrize("law", ["newton", "poisson"])
def test_a_rocking_block(law: str, workshop: Workshop, reach: Reach) -> None:
    """Rocks about one corner without sliding; each strike of the other leaves 1 - 3/2 sin^2 alpha of the spin."""
    width, height = 0.2, 1.0
    alpha = np.arctan2(width, height)
    text = block(width, height, 2.0, tilt=alpha / 2).replace("restitution", f'law = "{law}"\nrestitution')
    run = simulate(workshop.model(text), until=2.0, rtol=1e-12)
    assert run.success, run.message
    frequency = 1.5 * G / np.hypot(width, height)  # spin^2 = 2 frequency (cos(alpha - start) - cos(alpha - angle))
    first = quad(
        lambda s: 2 * s / np.sqrt(2 * frequency * (np.cos(alpha / 2) - np.cos(alpha / 2 + s * s))),
        0.0,
        np.sqrt(alpha / 2),
    )[0]
    assert first == pytest.approx(0.347093586788881, abs=1e-9)
    reach(f"rocking block, {law}: first strike, s", abs(run.impacts[0].t - 0.347093586788881), 1e-11)
    ratio = run.impacts[0].u_plus[2] / run.impacts[0].u_minus[2]
    reach(f"rocking block, {law}: spin left, relative", abs(ratio / (1 - 1.5 * np.sin(alpha) ** 2) - 1), 1e-12)
    reach(f"rocking block, {law}: rise of energy", rise(run), 1e-9)
    reach(f"rocking block, {law}: penetration, m", penetration(run), 1e-10)


def test_a_rod_that_jams(workshop: Workshop, reach: Reach) -> None:
    """p = 1 + 3 cos^2 - 3 mu sin cos < 0 while the rod is pushed along: no forces, or a choice of them.

    Pressed down it is stopped by an impact without collision: about the end that stops, its moment of momentum stays,
    m v l / 2 sin, and so it turns at 3/2 v sin / l. With a swing that lifts it, it could leave or stay, and leaves.
    """
    angle = np.arctan(2.0)
    run = simulate(workshop.model(rod(2.0, angle, (-1.0, 0.0), 0.0)), until=1.0)
    assert run.success, run.message
    impact = run.impacts[0]
    spin = 1.5 * np.sin(angle)
    reach("rod that jams: spin after, rad/s", abs(impact.u_plus[2] - spin), 1e-9)
    reach("rod that jams: impulse, N s", abs(impact.impulses[0] - 0.5 * np.cos(angle) * spin), 1e-9)
    reach("rod that jams: rise of energy", rise(run), 1e-9)
    assert impact.t == 0.0 and np.abs(impact.u_plus[:2]).max() <= 1e-9
    assert impact.friction[0] <= 2.0 * impact.impulses[0]
    lifted = simulate(workshop.model(rod(2.0, angle, (-1.0, 0.0), 6.0)), until=0.1)
    assert lifted.success, lifted.message
    assert [phase.kind for phase in lifted.phases] == ["flight"]
    dragged = simulate(workshop.model(rod(2.0, angle, (1.0, 0.0))), until=1.0)
    assert dragged.success, dragged.message
    less = simulate(workshop.model(rod(1.0, angle, (-1.0, 0.0))), until=1.0)
    assert less.success, less.message
    reach("rod dragged with mu = 2: penetration, m", penetration(dragged), 1e-10)
    reach("rod dragged with mu = 2: speed at rest, m/s", speed(dragged), 1e-8)


def compliant(stiffness: float, until: float) -> float:
    """Spin of the rod that jams, on a ground that gives way: a spring and a damper (half the critical one), pulls left
    out, and Coulomb's friction, rounded off at a speed that goes to zero with the compression.
    """
    length, mass, angle, mu = 1.0, 1.0, np.arctan(2.0), 2.0
    inertia, damping = mass * length**2 / 12, 2.0 * 0.5 * np.sqrt(stiffness * mass)
    slow = 1.0 / np.sqrt(stiffness)

    def rates(t: float, y: NDArray[np.float64]) -> NDArray[np.float64]:
        _, height, turn, vx, vy, spin = y
        arm = -0.5 * length * np.array([np.cos(turn), np.sin(turn)])
        depth, slide = -(height + arm[1]), vx - spin * arm[1]
        push = max(0.0, stiffness * depth - damping * (vy + spin * arm[0])) if depth > 0.0 else 0.0
        friction = -mu * push * np.tanh(slide / slow)
        return np.array([vx, vy, spin, friction / mass, push / mass - G, (arm[0] * push - arm[1] * friction) / inertia])

    start = [0.0, 0.5 * length * np.sin(angle), angle, -1.0, 0.0, 0.0]
    found = solve_ivp(rates, (0.0, until), start, method="LSODA", rtol=1e-8, atol=1e-11, max_step=1e-3)
    return float(found.y[5, -1])


def test_a_rod_that_jams_is_the_limit_of_stiff_grounds(workshop: Workshop) -> None:
    """Each ground a hundred times as stiff is nearer by three times or more."""
    run = simulate(workshop.model(rod(2.0, np.arctan(2.0), (-1.0, 0.0), 0.0)), until=0.1)
    off = [abs(compliant(stiffness, 0.1) - run.u[-1][2]) for stiffness in (1e4, 1e6, 1e8)]
    assert off[0] < 0.1
    assert off[1] <= off[0] / 3 and off[2] <= off[1] / 3, off


def test_one_rough_contact_strikes_as_routh_has_it(workshop: Workshop, reach: Reach) -> None:
    """With one contact that slides throughout, both laws agree, and friction is mu times the normal impulse."""
    found = {}
    for law in ("newton", "poisson"):
        text = rod(0.1, 1.0, (-3.0, -2.0)).replace("restitution = 0.0", f'restitution = 0.6\nlaw = "{law}"')
        run = simulate(workshop.model(text), until=0.001)
        found[law] = run.impacts[0]
    impact = found["newton"]
    model = workshop.model(rod(0.1, 1.0, (-3.0, -2.0)))
    mass, inertia = 1.0, 1 / 12
    arm = -0.5 * np.array([np.cos(1.0), np.sin(1.0)])
    push = impact.impulses[0] * np.array([0.1, 1.0])
    jump = np.array([*(push / mass), (arm[0] * push[1] - arm[1] * push[0]) / inertia])
    centre = jump[:2] + jump[2] * np.array([-arm[1], arm[0]])
    before, after = model.velocities(np.array([0.0, 0.0, 1.0]), impact.u_minus)[0], impact.u_plus
    reach("rough impact: jump from the impulse, m/s", np.max(np.abs(after[:2] - before[:2] - centre)), 1e-12)
    reach("rough impact: Newton's speed of rebound, m/s", abs(after[1] - 0.6 * 2.0), 1e-12)
    other = found["poisson"]
    reach("rough impact that slides: Newton less Poisson, N s", abs(other.impulses[0] - impact.impulses[0]), 1e-12)


def test_newtons_law_may_not_add_energy(workshop: Workshop, reach: Reach) -> None:
    """A double pendulum whose tip strikes rough ground: by Newton's law it would leave with more energy than it brought
    (T. R. Kane, Stanford Mechanics Alumni Club Newsletter 6, 1984). So it has the largest part of its restitution that
    gains none; or the run stops there, and that is said. Poisson's law goes on."""
    angles = np.radians([-70.0, -60.0])
    depth = float(np.sum(np.sin(angles)))
    found = {}
    models = {}
    for law in ("newton", "poisson"):
        ground = [{"point": [0.0, depth], "restitution": 0.7, "friction": 0.5, "law": law, "contacts": ["link_1.B"]}]
        models[law] = workshop.model(chain(2, hinged=True, gravity=True, ground=ground))
        found[law] = simulate(models[law], angles, [-0.1, -0.2], until=0.001)
    stopped = simulate(models["newton"], angles, [-0.1, -0.2], until=0.001, on_gain="stop")
    assert not stopped.success
    assert 'law = "poisson"' in stopped.message
    assert found["poisson"].success and found["newton"].success
    assert found["poisson"].impacts[0].restitution_share == 1.0
    impact = found["newton"].impacts[0]
    assert 0.0 < impact.restitution_share < 1.0
    q = found["newton"].q[0]
    energy, _ = models["newton"].energy(q, impact.u_minus)
    assert 0.0 <= impact.energy_loss <= 1e-8 * energy
    more = models["newton"].with_parameters({"ground_0.restitution": 0.7 * (impact.restitution_share + 1e-6)})
    with pytest.raises(ValueError, match="would add energy"):
        more.impact(q, impact.u_minus, impact.contacts)
    reach("Kane's double pendulum, Poisson: energy gained, J", -found["poisson"].impacts[0].energy_loss, 0.0)
