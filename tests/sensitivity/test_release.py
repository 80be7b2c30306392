"""Derivatives of runs in which joints let go and take hold: closed forms, and differences of runs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import asin, cos, pi, sin
from typing import Any

import numpy as np
import pytest

from ccgen.runtime import directional, find_orbit, run_function, sensitivities, simulate
from ccgen.runtime.model.model import Model

from ..runs.test_release_and_hold import COUPLING, DRIVEN, HOOK, PENDULUM, RAIL, TREBUCHET, WELDED
from ..support.derived_scenes import FOUR_BAR, HINGED
from ..support.folders import ROOT
from ..support.run_differences import RTOL, along, relative
from ..support.workshop import Workshop

TIGHT = 1e-10
"""Instants of double runs are known to about 1e-13 of them, and these derivatives are of the size of one."""

LIFTED = 10.0
"""Differences of runs are taken over so many values of each parameter, times a step of 2^-18: stretches of runs in wide
numbers begin at times that are doubles, known to 1e-16 alone, which shorter steps make more of."""

GROUND = '[[event]]\nname = "down"\nwhen = "y({}) + 3"\ndirection = "falling"\nstop = true\n'


def by_complex_steps(function: Callable[..., Any], at: Sequence[float]) -> np.ndarray:
    """The derivatives of an analytic function of several numbers by each of them."""
    steps = np.array(at) + 1e-30j * np.eye(len(at))
    return np.array([function(*one).imag / 1e-30 for one in steps])


def thrown(mass: Any, inertia: Any, arm: Any, g: Any, sine: Any) -> Any:
    """Where the mass centre of a pendulum comes down to y = -3 that fell from the horizontal and is let go at an angle
    of that sine below it: w^2 = 2 m g l sin a / J, J = I + m l^2."""
    cosine = np.sqrt(1 - sine**2)
    speed = arm * np.sqrt(2 * mass * g * arm * sine / (inertia + mass * arm**2))
    down = speed * cosine
    fall = (-down + np.sqrt(down**2 + 2 * g * (3 - arm * sine))) / g
    return arm * cosine - speed * sine * fall


def breaks(mass: Any, inertia: Any, arm: Any, g: Any) -> Any:
    """The same where the pin breaks at 40 N: it carries A sin a along the arm and B cos a across."""
    share = mass * arm**2 / (inertia + mass * arm**2)
    A, B = mass * g * (1 + 2 * share), mass * g * (1 - share)
    return thrown(mass, inertia, arm, g, np.sqrt((1600 - B**2) / (A**2 - B**2)))


@pytest.mark.parametrize(
    ("when", "place"),
    [
        ('when = { direction = "bob", below = "-0.7" }', lambda *of: thrown(*of, sin(0.7))),
        ('when = { height = "bob.E", below = -0.5 }', lambda m, J, arm, g: thrown(m, J, arm, g, 0.5 / arm)),
        ("force = 40", breaks),
    ],
)
def test_where_a_pendulum_lands_that_is_let_go(when: str, place: Callable[..., Any], workshop: Workshop) -> None:
    text = PENDULUM.format(when=when).replace("E = [1, 0]", "E = [0.8, 0]") + GROUND.format("bob.E")
    model = workshop.model(text, derivatives=True)
    alone = {"bob.mass": [1.0, 0, 0, 0], "bob.inertia": [0, 1.0, 0, 0], "gravity.g": [0, 0, 0, 1.0]}
    arm = {name: [0, 0, 1.0, 0] for name in ("bob.com.x", "bob.points.E.x")}
    found = sensitivities(model, alone | arm, until=5.0, rtol=1e-13)
    let_go, landed = found.passed
    assert (let_go.kind, let_go.joints, landed.events) == ("release", ("pin",), ("down",))
    q = found.values["q"]
    angle = q[model.q_of.index("bob.angle")]
    assert model.point("bob.E", q)[0] == pytest.approx(place(2.0, 0.3, 0.8, 9.81), abs=1e-11)
    by_q = (model.point("bob.E", q + np.eye(len(q))) - model.point("bob.E", q - np.eye(len(q))))[:, 0] / 2
    by_q[model.q_of.index("bob.angle")] = -0.8 * sin(angle)  # the others are lengths, and points linear in them
    moved = by_q @ landed.behind[: len(q)] + np.array([0, 0, cos(angle), 0])
    assert moved == pytest.approx(by_complex_steps(place, (2.0, 0.3, 0.8, 9.81)), abs=TIGHT)


def test_a_block_that_leaves_its_line_at_a_time(workshop: Workshop) -> None:
    """2 a = 4 - 0.3 v - 2 g sin 0.5 until 0.5 s, and then it flies for 0.5 s."""

    def place(mass: Any, viscous: Any, g: Any, start: Any) -> Any:
        pull = 4.0 - mass * g * np.sin(0.5)
        late = 1.0 - np.exp(-viscous / mass * 0.5)
        speed, way = pull / viscous * late, pull / viscous * (0.5 - late * mass / viscous)
        return (start + way + 0.5 * speed) * np.sin(0.5) - g / 8

    model = workshop.model(RAIL, derivatives=True)
    names = ["block.mass", "joint_friction_0.viscous", "gravity.g"]
    along_line = {"block_x.slide": cos(0.5), "block_y.slide": sin(0.5)}
    columns = dict(zip(names, np.eye(4)[:3], strict=True))
    columns["q0"] = np.outer([along_line.get(name, 0.0) for name in model.q_of], [0, 0, 0, 1])
    found = sensitivities(model, columns, "block.A.y", *model.start(), until=1.0, rtol=1e-13)
    assert found["block.A.y"] == pytest.approx(by_complex_steps(place, (2.0, 0.3, 9.81, 0.2)), abs=TIGHT)
    assert found.passed[0].dt == pytest.approx(np.zeros(4))


def test_a_rod_that_catches_a_ball(workshop: Workshop) -> None:
    """It turns at m v l / (I + M c^2 + m l^2) from when the ball is there on, x / v. A ball that comes by higher or
    lower is drawn to the rod's end, and turns it as much."""

    def angle(m: Any, M: Any, own: Any, place: Any, v: Any) -> Any:
        return m * v * 1.5 / (own + M * 0.25 + m * 2.25) * (1.0 + place / v)

    model = workshop.model(HOOK.format(more="", height=-1.5), derivatives=True)
    q0, u0 = model.start()
    names = ["ball.mass", "rod.mass", "rod.inertia", "q0", "u0"]
    found = sensitivities(model, names, ["rod.angle", "impact_times"], q0, u0, until=1.0, rtol=1e-13)
    n = len(q0)
    moved = found["rod.angle"]
    wanted = by_complex_steps(angle, (2.0, 3.0, 0.7, -2.0, 4.0))
    assert moved[:3] == pytest.approx(wanted[:3], abs=TIGHT)
    x, y = (3 + model.q_of.index(f"ball_{axis}.slide") for axis in "xy")
    assert [moved[x], moved[y]] == pytest.approx([wanted[3], 0.0], abs=TIGHT)
    assert [moved[n + x], moved[n + y]] == pytest.approx([wanted[4], 0.0], abs=TIGHT)
    times = found["impact_times"][0]
    assert [times[x], times[n + x], times[y], times[n + y]] == pytest.approx([-0.25, -0.125, 0, 0], abs=TIGHT)
    (caught,) = found.passed
    assert (caught.kind, caught.joints, caught.contacts) == ("impact", ("grip",), (("grip", "hold"),))


STRUCK = PENDULUM.replace(
    "[gravity]", '[gravity]\n[[ground]]\npoint = [0, -0.6]\nrestitution = 0.4\ncontacts = ["bob.E"]'
)
HEAVY = '[[event]]\nname = "heavy"\nwhen = "direction(bob) + 0.9"\nset = {{ "bob.mass" = "4 + direction(bob)" }}\n'
FAST = (
    '[[event]]\nname = "fast"\nwhen = "direction(bob) + 0.7"\nset = {{ "bob.mass" = "2 + rate(direction(bob))**2" }}\n'
)
IN_TURN = (
    'name = "chain"\n' + HINGED + '[start]\nangles = ["0 deg", "-20 deg"]\n'
    '[[release]]\njoint = "knee"\nforce = 9\n[[release]]\njoint = "joint_0"\nat = 0.6\n'
)
AT_ONCE = TREBUCHET.replace(
    'when = { angle = "ring", below = "-2.4" }', 'at = 0.5\n[[release]]\njoint = "ring"\nat = 0.5'
)
CAUGHT = HOOK.replace("[start]", '[start]\nopen = ["grip"]')
RELEASED = (
    DRIVEN.replace('[[hold]]\njoint = "grip"\nat = 0.3\nwithin = "1 cm"\n', "")
    .replace('joint = "grip"\nat = 0.9', 'joint = "axle"\nat = 0.5\n[gravity]')
    .replace('open = ["grip"]\n', "")
    .replace("poses = { load = [0.847, 0.535, 0] }", "")
    .replace("mass = 1\ninertia = 0.1\ncom = [0, 0]", "mass = 1\ninertia = 0.1\ncom = [0.2, 0.1]")
)
GRIPS = '[[hold]]\njoint = "grip"\nwithin = "2 mm"\n[[release]]\njoint = "grip"\n'


def _welding() -> str:
    """A tip that an arm takes hold of, 1 cm and 0.005 rad from where it holds."""
    x, y = np.array([cos(1.1), sin(1.1)]) - 0.1 * np.array([cos(1.5), sin(1.5)])
    text = WELDED.format(change='[[hold]]\njoint = "seam"\nat = 0.3\nwithin = "2 cm"').replace("[gravity]", "")
    return text.replace("[start]", f"[start]\nposes = {{ tip = [{x - 0.01:.17g}, {y:.17g}, 1.505] }}")


BARS = (
    FOUR_BAR.replace('[[joint]]\nbetween = ["crank.B', '[[joint]]\nname = "elbow"\nbetween = ["crank.B')
    .replace('[[joint]]\nbetween = ["coupler.B', '[[joint]]\nname = "latch"\nbetween = ["coupler.B')
    .replace("angles = { crank = 1.0 }", 'open = ["latch"]\nangles = { crank = 1.0, coupler = 0.3, rocker = 1.6 }')
    .replace("{ crank = 2.0 }", "{ crank = 2.0, coupler = 0.5, rocker = -0.5 }")
)
CLOSED = (
    'name = "closing"\n'
    + BARS
    + ('[[hold]]\njoint = "latch"\nat = 0.05\nwithin = "40 cm"\n[[release]]\njoint = "elbow"\nforce = 6.5\n')
)
TOWED = """
name = "towed"
[ground_link]
points = {{ O = [0, 0] }}
[[link]]
name = "arm"
rod = {{ mass = 2 }}
points = {{ A = [0, 0], B = [1, 0] }}
[[link]]
name = "skid"
mass = 1
inertia = 0.05
com = [0.4, 0]
points = {{ A = [0, 0], C = [0.8, 0] }}
[[joint]]
name = "axle"
between = ["ground.O", "arm.A"]
[[joint]]
name = "tow"
between = ["arm.B", "skid.A"]
[[ground]]
point = [0, -0.5]
contacts = ["skid.C"]
restitution = 0
friction = 0.2
[[release]]
joint = "tow"
{}
[start]
angles = {{ arm = -0.1, skid = {:.17g} }}
angular_velocities = {{ arm = 0.5, skid = {:.17g} }}
[gravity]
[run]
until = 1
"""
TILT = -asin((0.5 - sin(0.1)) / 0.8)
"""Of the skid, whose end slides on the ground from the start on."""
SPIN = -cos(0.1) * 0.5 / (0.8 * cos(TILT))


SCENES: dict[str, tuple[str, float, tuple[tuple[str, tuple[str, ...]], ...]]] = {
    "a trebuchet": (TREBUCHET, 1.2, (("release", ("pouch",)),)),
    "a stone that slides first": (
        (ROOT / "scenes" / "trebuchet.toml").read_text(encoding="utf-8"),
        1.2,
        (("impact", ()), ("release", ("pouch",))),
    ),
    "joints that let go in turn": (IN_TURN, 0.9, (("release", ("knee",)), ("release", ("joint_0",)))),
    "joints that let go at one time": (AT_ONCE, 0.8, (("release", ("pouch", "ring")),)),
    "a pin that an impact breaks": (STRUCK.format(when="impulse = 1.5"), 0.6, (("impact", ("pin",)), ("impact", ()))),
    "a pin that breaks as masses are set": (
        PENDULUM.format(when="force = 60") + HEAVY.format(),
        0.8,
        (("event", ("pin",)),),
    ),
    "an event at the angle of a release": (
        PENDULUM.format(when='when = { direction = "bob", below = "-0.7" }') + FAST.format(),
        0.8,
        (("event", ("pin",)),),
    ),
    "a weld that breaks": (
        WELDED.format(change='[[release]]\njoint = "seam"\nat = 0.3'),
        0.8,
        (("release", ("seam",)),),
    ),
    "a weld that takes hold": (_welding(), 0.6, (("impact", ("seam",)),)),
    "a ball that is drawn to a rod": (
        HOOK.format(more='within = "2 mm"', height=-1.501),
        1.0,
        (("impact", ("grip",)),),
    ),
    "a grip that its own impulse breaks": (
        CAUGHT.format(more='within = "2 mm"\n[[release]]\njoint = "grip"\nimpulse = 1.5', height=-1.5),
        0.8,
        (("impact", ("grip", "grip")),),
    ),
    "a grip that breaks at once": (
        CAUGHT.format(more='within = "2 mm"\n[[release]]\njoint = "grip"\nforce = 7', height=-1.5),
        0.8,
        (("impact", ("grip", "grip")),),
    ),
    "a hold at the start": (
        HOOK.format(more='at = 0\nwithin = "10 cm"', height=-1.5).replace("ball = [-2,", "ball = [-0.05,"),
        0.5,
        (("impact", ("grip",)),),
    ),
    "wagons that part and couple": (COUPLING, 3.0, (("release", ("hook",)), ("impact", ()), ("impact", ("hook",)))),
    "a loop that closes and breaks": (CLOSED, 0.3, (("impact", ("latch",)), ("release", ("elbow",)))),
    "a driven arm": (DRIVEN, 1.2, (("impact", ("grip",)), ("release", ("grip",)))),
    "a drive that lets go": (RELEASED, 1.0, (("release", ("axle",)),)),
    "a drive that its force breaks at the start": (
        RELEASED.replace("at = 0.5", "force = 20"),
        0.6,
        (("release", ("axle",)),),
    ),
}


@pytest.mark.parametrize("scene", SCENES)
def test_derivatives_are_those_of_differences(scene: str, workshop: Workshop) -> None:
    text, until, passed = SCENES[scene]
    model, wide = workshop.model(text, derivatives=True), workshop.model(text, "wide")
    names = [name for name in model.parameters if not name.endswith((".held", ".on"))]
    names = [name for name in names if name != "ground_0.friction" or model.parameters[name]]
    sizes = LIFTED * np.diag([abs(model.parameters[name]) or 0.1 for name in names])
    columns = dict(zip(names, sizes, strict=True))
    found = sensitivities(model, columns, ["q", "u", "impact_times"], until=until, rtol=RTOL)
    assert tuple((one.kind, one.joints) for one in found.passed) == passed
    assert relative(found.jacobian, along(wide, model, columns, until)) < 1e-9
    adjoint = sensitivities(model, columns, ["q", "u", "impact_times"], until=until, rtol=RTOL, mode="adjoint")
    assert relative(adjoint.jacobian, found.jacobian) < 1e-10


def test_the_range_of_a_trebuchet(workshop: Workshop) -> None:
    """By all its parameters and its start, against differences of whole throws, extrapolated."""
    model = workshop.model(TREBUCHET + GROUND.format("stone.C"), derivatives=True)
    names = [name for name in model.parameters if not name.endswith(".held")]

    def reach(name: str, change: float) -> float:
        params = {name: model.parameters[name] * (1.0 + change)}
        run: Any = simulate(model, params=params, until=9.0, rtol=1e-13)
        return float(run.model.point("stone.C", run.q[-1])[0])

    moved = [name for name in names if model.parameters[name]]
    found = sensitivities(model, moved, ["q"], until=9.0, rtol=1e-13)
    assert found.passed[-1].events == ("down",) and found.run.message.startswith("ended")
    n, q = len(model.q_names), found.values["q"]
    by_q = model.derivatives("points", q, np.zeros(n), wrt="q")[model.points.index("stone.C")][0]
    by_shape = model.derivatives("points", q, np.zeros(n), wrt=moved)[model.points.index("stone.C")][0]
    wanted = by_q @ found.passed[-1].behind[:n] + by_shape
    wanted *= [model.parameters[name] for name in moved]
    for name, exact in zip(moved, wanted, strict=True):
        near, far = ((reach(name, h) - reach(name, -h)) / (2 * h) for h in (1e-3, 2e-3))
        nearest = (reach(name, 5e-4) - reach(name, -5e-4)) / 1e-3
        once = (4 * near - far) / 3, (4 * nearest - near) / 3
        assert (16 * once[1] - once[0]) / 15 == pytest.approx(exact, rel=1e-6, abs=1e-7), name


def test_a_release_while_a_contact_slides(workshop: Workshop) -> None:
    """The skid slides backward, turns round, and slides on by itself. By a force nothing is known there."""
    text = TOWED.format("at = 0.1", TILT, SPIN)
    model, wide = workshop.model(text, derivatives=True), workshop.model(text, "wide")
    names = ["arm.mass", "skid.mass", "skid.inertia", "gravity.g", "ground_0.friction"]
    columns = dict(zip(names, np.eye(5), strict=True))
    found = sensitivities(model, columns, ["q", "u"], until=0.2, rtol=RTOL)
    assert [(one.kind, one.joints) for one in found.passed] == [("sliding ends", ()), ("release", ("tow",))]
    assert relative(found.jacobian, along(wide, model, columns, 0.2)) < 1e-9
    forced = workshop.model(TOWED.format("force = 5.6", TILT, SPIN), derivatives=True)
    refused(forced, "arm.mass", "where contacts are held, expected tow to let go in flight: forces have", until=0.2)


def test_inputs_go_on_behind_a_release(workshop: Workshop) -> None:
    text = PENDULUM.format(when="force = 40") + '[[input]]\nname = "push"\nlink = "bob"\n'
    model = workshop.model(text, derivatives=True)
    found = sensitivities(model, "push", ["q", "u"], until=0.8, rtol=1e-13, inputs=-1.5)

    def end(push: float) -> np.ndarray:
        run: Any = simulate(model, until=0.8, rtol=1e-13, inputs=push)
        return np.concatenate([run.q[-1], run.u[-1]])

    near, far = ((end(-1.5 + h) - end(-1.5 - h)) / (2 * h) for h in (1e-3, 2e-3))
    assert found.jacobian[:, 0] == pytest.approx((4 * near - far) / 3, rel=1e-8, abs=1e-8)
    assert found.passed[0].joints == ("pin",)


def test_gradients_and_single_directions(workshop: Workshop) -> None:
    model = workshop.model(TREBUCHET, derivatives=True)
    wrt, outputs = ["weight.mass", "stone.mass", "sling.points.B.x"], ["stone.C.x", "kinetic_energy"]
    both = sensitivities(model, wrt, outputs, at=[0.5, 1.1], until=1.1, rtol=1e-12)
    function = run_function(model, wrt, outputs, at=[0.5, 1.1], until=1.1, rtol=1e-12)
    weights = np.array([1.0, -2.0, 1e-3, 2e-3])
    assert function.vjp(function.x0, weights) == pytest.approx(weights @ both.jacobian, rel=1e-9)
    one = directional(
        model, dict(zip(wrt, (3.0, 0.1, -0.02), strict=True)), outputs, at=[0.5, 1.1], until=1.1, rtol=1e-12
    )
    assert one.jacobian[:, 0] == pytest.approx(both.jacobian @ [3.0, 0.1, -0.02], rel=1e-9)


COUPLED = """
name = "coupled"
[ground_link]
points = { O = [0, 0], S = [-1, 0], E = [1.2, 0] }
[[link]]
name = "engine"
mass = 2
inertia = 1
com = [0, 0]
points = { C = [0, 0] }
[[link]]
name = "wagon"
mass = 1
inertia = 1
com = [0, 0]
points = { C = [0, 0] }
[[joint]]
name = "rail"
type = "prismatic"
between = ["ground.O", "engine.C"]
axis = [1, 0]
[[joint]]
name = "track"
type = "prismatic"
between = ["ground.O", "wagon.C"]
axis = [1, 0]
[[joint]]
name = "hook"
between = ["engine.C", "wagon.C"]
[[release]]
joint = "hook"
when = { slide = "rail", above = "10 cm" }
[[hold]]
joint = "hook"
[[spring]]
between = ["ground.S", "engine.C"]
stiffness = 10
length = 1
[[damper]]
between = ["ground.S", "engine.C"]
damping = 1
[[spring]]
between = ["ground.E", "wagon.C"]
stiffness = 6
length = 1
[[damper]]
between = ["ground.E", "wagon.C"]
damping = 0.5
[[motor]]
joint = "rail"
force = "10*sin(4*t)"
[start]
open = ["hook"]
slides = { rail = 0, track = 0.2 }
sliding_velocities = { rail = 1 }
[run]
until = 60
"""


def test_a_periodic_motion_that_couples_and_parts(workshop: Workshop) -> None:
    """Two of four multipliers are zero: where two masses take hold of each other, two differences are lost."""
    model, wide = workshop.model(COUPLED, derivatives=True), workshop.model(COUPLED, "wide")
    period = pi / 2
    settled: Any = simulate(model, until=20 * period, rtol=1e-9)
    orbit = find_orbit(model, *settled.at(20 * period), section=period, rtol=1e-12)
    assert [change.kind for change in orbit.run.changes] == ["hold", "release"]
    n = len(orbit.q)
    columns = {"q0": np.eye(2 * n)[:n], "u0": np.eye(2 * n)[n:]}
    wanted = np.linalg.eigvals(along(wide, model, columns, period, orbit.q, orbit.u)[: 2 * n])
    assert np.sort_complex(orbit.multipliers) == pytest.approx(np.sort_complex(wanted), abs=1e-8)
    assert np.sum(np.abs(orbit.multipliers) < 1e-10) == 2 and orbit.stable


def test_motions_that_do_not_come_back_to_what_is_held(workshop: Workshop) -> None:
    model = workshop.model(COUPLED, derivatives=True)
    held: Any = model.with_parameters({"spring_0.stiffness": 14, "damper_0.damping": 3, "damper_1.damping": 1.5})
    with pytest.raises(ValueError, match="found hook held at the end of a way from the section back to it"):
        find_orbit(held, *simulate(held, until=20 * pi / 2).at(20 * pi / 2), section=pi / 2)
    timed = workshop.model(PENDULUM.format(when="at = 0.4"), derivatives=True)
    with pytest.raises(ValueError, match="found pin, a joint that lets go or takes hold at a given time, once"):
        find_orbit(timed, *timed.start(), section=1.0)


def refused(model: Model, wrt: str, said: str, **more: Any) -> None:
    with pytest.raises(ValueError, match=said):
        sensitivities(model, wrt, **more)


def test_what_has_no_derivative_is_refused(workshop: Workshop) -> None:
    pin = workshop.model(PENDULUM.format(when="at = 0.4"), derivatives=True)
    refused(pin, "pin.held", r"pin\.held: found what says whether a joint holds", until=0.6)
    refused(pin, "bob.mass", r"at: found 0\.4 s, the time at which pin lets go, so that derivatives jump", until=0.4)
    run: Any = simulate(workshop.model(PENDULUM.format(when='when = { direction = "bob", below = "-0.7" }')))
    both = PENDULUM.format(when=f'at = {run.changes[0].t!r}\n[[release]]\njoint = "pin"\nforce = 1e6') + FAST.format()
    parted = workshop.model(both, derivatives=True)
    refused(parted, "bob.inertia", "found fast and pin to let go at t = .* s, which bob.inertia parts", until=0.6)
    level = PENDULUM.format(when="force = 1")
    at_start = simulate(workshop.model(PENDULUM.format(when="at = 9"))).reactions([0.0])[0, 0, :2]
    limit = level.replace("force = 1", f"force = {float(np.hypot(*at_start))!r}")
    refused(
        workshop.model(limit, derivatives=True), "bob.mass", "where the force in pin is its limit to round", until=0.3
    )
