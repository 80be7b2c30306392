"""Motors with an integral: closed forms, an independent integration where a limit cuts, and what the integral leaves
untouched."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from ccgen.generator import stages
from ccgen.generator.scene import SceneError
from ccgen.runtime import HybridState, driving_torque, inverse_dynamics, simulate, static_equilibrium
from ccgen.runtime.pictures.player import content

from ..oracles.maximal import Array
from ..runs.test_going_on import run_with_stop
from ..support.active import ROD, Wrong, check_refusal
from ..support.workshop import Workshop

MASS, STIFFNESS, DAMPING, INTEGRAL, LOAD = 2.0, 40.0, 12.0, 30.0, -7.0
CART = f"""
name = "cart"
[ground_link]
points = {{ O = [0, 0] }}
[[link]]
name = "cart"
mass = {MASS}
inertia = 0.1
com = [0, 0]
points = {{ A = [0, 0] }}
[[joint]]
name = "rail"
type = "prismatic"
axis = [1, 0]
between = ["ground.O", "cart.A"]
[[force]]
point = "cart.A"
vector = [{LOAD}, 0]
"""
GAINS = f"stiffness = {STIFFNESS}\ndamping = {DAMPING}\n"
SERVO = '[[motor]]\njoint = "rail"\nposition = 0.5\n' + GAINS
PID = f"{SERVO}integral = {INTEGRAL}\n"

FOUR_BAR = """
name = "held-crank"
[ground_link]
points = { O = [0, 0], Q = [0.6, 0] }
[[link]]
name = "crank"
rod = { mass = 0.4 }
points = { A = [0, 0], B = [0.2, 0] }
[[link]]
name = "coupler"
rod = { mass = 1.0 }
points = { A = [0, 0], B = [0.5, 0] }
[[link]]
name = "rocker"
rod = { mass = 1.0 }
points = { A = [0, 0], B = [0.5, 0] }
[[joint]]
name = "axle"
between = ["ground.O", "crank.A"]
[[joint]]
between = ["crank.B", "coupler.A"]
[[joint]]
between = ["coupler.B", "rocker.B"]
[[joint]]
between = ["ground.Q", "rocker.A"]
[start]
angles = { crank = "90 deg", coupler = "20 deg", rocker = "100 deg" }
[gravity]
"""
HOLD = '[[motor]]\nname = "hold"\njoint = "axle"\nangle = 1.2\nstiffness = 60\ndamping = 4\n'
HELD = FOUR_BAR + HOLD + 'integral = "90 N m/(rad s)"\n'


def _columns(run: Any) -> Array:
    """Place, speed and integral of the cart, (t, 3)."""
    q, u = run.model.q_names.index("slide_0"), run.model.u_names.index("sliding_0")
    return np.column_stack([run.q[:, q], run.u[:, u], run.u[:, run.model.u_names.index("w_1")]])


# -- closed forms ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("method", ["gauss", "dop853", "radau"])
def test_cart_is_the_third_order_linear_equation(method: str, workshop: Workshop) -> None:
    """m x'' = k e - d x' + i z + F, z' = e: the exponential of its matrix, bordered by what is constant."""
    run = simulate(workshop.model(CART + PID), until=4.0, rtol=1e-12, method=method)
    constant = STIFFNESS * 0.5 + LOAD
    rows = [
        [0.0, 1.0, 0.0, 0.0],
        [-STIFFNESS / MASS, -DAMPING / MASS, INTEGRAL / MASS, constant / MASS],
        [-1.0, 0.0, 0.0, 0.5],
        [0.0] * 4,
    ]
    wanted = np.array([expm(np.array(rows) * t)[:3, 3] for t in run.t])
    assert np.max(np.abs(_columns(run) - wanted)) <= 1e-10
    assert run.energy_drift <= 1e-10


def test_only_with_integral_nothing_is_left_of_a_load(workshop: Workshop) -> None:
    left = {}
    for name, motor in (("with", PID), ("without", SERVO)):
        run = simulate(workshop.model(CART + motor), until=40.0)
        left[name] = 0.5 - run.q[-1, run.model.q_names.index("slide_0")]
    assert abs(left["with"]) <= 1e-9
    assert left["without"] == pytest.approx(-LOAD / STIFFNESS, rel=1e-9)


def test_turning_pendulum(workshop: Workshop) -> None:
    """A rod with an integral of the angle that is an expression of time, against SciPy; in wide numbers too."""
    motor = '[[motor]]\njoint = "joint_0"\nangle = "0.3*sin(2*t)"\nstiffness = 80\ndamping = 9\nintegral = 50\n'
    text, inertia = ROD + "[gravity]\n" + motor, 3.0 * 2.0**2 / 3

    def rates(t: float, y: Array) -> list[float]:
        error, slow = 0.3 * math.sin(2 * t) - y[0], 0.6 * math.cos(2 * t) - y[1]
        torque = 80 * error + 9 * slow + 50 * y[2] - 3.0 * 9.81 * math.cos(y[0])
        return [y[1], torque / inertia, error]

    wanted = solve_ivp(rates, (0, 3), [-0.2, 0.0, 0.0], method="DOP853", rtol=1e-13, atol=1e-13).y[:, -1]
    for precision in ("double", "wide"):
        model = workshop.model(text, precision)
        run = simulate(model, [-0.2, 0.0], [0.0, 0.0], until=3.0, rtol=1e-12)
        assert np.max(np.abs([run.q[-1, 0], *run.u[-1]] - wanted)) <= 1e-10


# -- limits ------------------------------------------------------------------------------------------------------------

LIMIT, AIM, PUSH = 9.0, 2.0, -4.0
STEP = CART.replace(f"[{LOAD}, 0]", f"[{PUSH}, 0]") + PID.replace("position = 0.5", f"position = {AIM}")


def _clamped(t: float, y: Array, fades: float | None) -> list[float]:
    """The law with its limit, the integral fading over this part of it; never where that is None."""
    error = AIM - y[0]
    asked = STIFFNESS * error - DAMPING * y[1] + INTEGRAL * y[2]
    grows = 1.0
    if fades is not None:
        beyond = math.copysign(1.0, error) * asked - LIMIT
        grows = 1.0 - min(max(beyond / (fades * LIMIT), 0.0), 1.0)
    return [y[1], (min(max(asked, -LIMIT), LIMIT) + PUSH) / MASS, error * grows]


def _integrated(fades: float | None) -> Any:
    return solve_ivp(
        _clamped, (0, 10), [0, 0, 0], "DOP853", args=(fades,), rtol=1e-12, atol=1e-12, max_step=2e-3, dense_output=True
    )


@pytest.mark.sample(1)
@pytest.mark.parametrize("method", ["gauss", "dop853", "radau"])
def test_limit_stops_the_integral(method: str, workshop: Workshop) -> None:
    """A step far beyond the limit: SciPy with short steps, and an overshoot far below that with windup."""
    model = workshop.model(STEP + f"limit = {LIMIT}\n")
    run = simulate(model, until=10.0, rtol=1e-11, method=method)
    clamped, wound = _integrated(0.1), _integrated(None)
    assert np.max(np.abs(_columns(run) - clamped.sol(run.t).T)) <= 1e-7
    assert run.energy_drift <= 1e-8
    overshoot = np.max(_columns(run)[:, 0]) - AIM
    assert 0.05 < overshoot < 0.2 * (np.max(wound.y[0]) - AIM)


def test_limit_backward(workshop: Workshop) -> None:
    """Mirrored wishes and loads give the mirrored motion to the last bit."""
    model = workshop.model(STEP + f"limit = {LIMIT}\n")
    run = simulate(model, until=6.0)
    model.parameters["motor_0.position"], model.parameters["force_0.vector.x"] = -AIM, -PUSH
    back = simulate(model, until=6.0)
    model.parameters["motor_0.position"], model.parameters["force_0.vector.x"] = AIM, PUSH
    assert np.array_equal(run.t, back.t)
    assert np.array_equal(_columns(run), -_columns(back))


@pytest.mark.parametrize("method", ["gauss", "dop853", "radau"])
def test_blocked_motor_asks_for_a_little_more_than_its_limit(method: str, workshop: Workshop) -> None:
    """Against a wall, short of where it is to be, the integral comes to where 1.1 of the limit is asked for. Then the
    wanted place comes back slowly, and the integral grows as much as is given way: stopped at the limit itself it would
    have to grow there and to stand there in turn, for with it more than the limit would be asked for, and without it
    less."""
    back, limit = 0.02, 5.0
    text = STEP.replace(f"position = {AIM}", f'position = "{AIM} - {back}*t"').replace(f"[{PUSH}, 0]", "[1, 0]")
    text = (
        text.replace("A = [0, 0]", "A = [0, 0], T = [0, 0]") + f"limit = {limit}\n[start]\nslides = {{ rail = 1.9 }}\n"
    )
    text += '[[ground]]\npoint = [1.9, 0]\nnormal = [-1, 0]\nrestitution = 0\ncontacts = ["cart.T"]\n'
    run = simulate(workshop.model(text), until=4.0, method=method)
    assert run.success, run.message
    found = _columns(run)
    assert np.max(np.abs(found[:, 0] - 1.9)) <= 1e-12

    def asked(t: Any, z: Any) -> Any:
        return STIFFNESS * (AIM - back * t - 1.9) - DAMPING * back + INTEGRAL * z

    def rate(t: float, z: Array) -> Array:
        return (AIM - back * t - 1.9) * (1.0 - np.clip((asked(t, z) - limit) / (0.1 * limit), 0.0, 1.0))

    wanted = solve_ivp(rate, (0, 4), [0.0], "DOP853", rtol=1e-12, atol=1e-13, max_step=1e-2, dense_output=True)
    assert np.max(np.abs(found[:, 2] - wanted.sol(run.t)[0])) <= 1e-9
    between = (asked(run.t, found[:, 2]) > limit) & (asked(run.t, found[:, 2]) < 1.1 * limit)
    grows = INTEGRAL * (AIM - back * run.t[between] - 1.9)
    assert np.ptp(run.t[between]) > 1.0 and np.any(grows > STIFFNESS * back)


# -- loops, structures, what is asked of a model -----------------------------------------------------------------------


@pytest.mark.parametrize("method", ["gauss", "dop853"])
def test_crank_of_a_loop_is_held_where_it_is_to_be(method: str, workshop: Workshop) -> None:
    """The integral at rest gives the torque that statics asks for there."""
    run = simulate(workshop.model(HELD), until=20.0, method=method)
    torque = 90.0 * run.u[-1, run.model.u_names.index("w_3")]
    assert abs(run.q[-1, 0] - 1.2) <= 1e-9 and np.max(np.abs(run.u[-1, :3])) <= 1e-8
    plain = workshop.model(FOUR_BAR)
    at_rest = inverse_dynamics(plain, run.q[-1, :3], np.zeros(3), np.zeros(3), ["axle"])
    assert torque == pytest.approx(at_rest[0], rel=1e-8)
    assert run.energy_drift <= 1e-8 and run.closure_max <= 1e-12
    without = simulate(workshop.model(FOUR_BAR + HOLD), until=20.0)
    assert abs(without.q[-1, 0] - 1.2) > 1e-3


def test_floating_arms_keep_their_momentum(workshop: Workshop) -> None:
    """Nothing holds them, and what integrates hangs on one of them: it pushes on nothing."""
    links = "".join(
        f'[[link]]\nname = "{name}"\nrod = {{ mass = 1 }}\npoints = {{ A = [0, 0], B = [1, 0] }}\n' for name in "ab"
    )
    motor = '[[motor]]\njoint = "elbow"\nangle = 1\nstiffness = 30\ndamping = 5\nintegral = 20\nlimit = 6\n'
    text = f'name = "arms"\n{links}[[joint]]\nname = "elbow"\nbetween = ["a.B", "b.A"]\n{motor}'
    run = simulate(workshop.model(text), until=8.0)
    assert run.model.q_names == ("x_0", "y_0", "theta_0", "theta_1", "theta_2")
    assert abs(run.q[-1, 3] - run.q[-1, 2] - 1.0) <= 1e-3
    assert np.max(np.abs(run.q[:, 2] + run.q[:, 3])) <= 1e-9  # equal arms turn against each other
    centre = np.mean([run.point(f"{link}.{end}").position for link in "ab" for end in "AB"], axis=0)
    assert np.max(np.abs(centre - centre[0])) <= 1e-9


def test_beside_bodies_that_nothing_holds(workshop: Workshop) -> None:
    """A free body beside the cart changes nothing of its motion, nor the cart anything of its fall."""
    body = '[[link]]\nname = "body"\nfree = true\nrod = { mass = 1 }\npoints = { A = [0, 0], B = [1, 0] }\n'
    run = simulate(workshop.model(CART.replace("[[joint]]", body + "[[joint]]", 1) + PID), until=2.0, rtol=1e-11)
    alone = simulate(workshop.model(CART + PID), until=2.0, rtol=1e-11)
    names = run.model.q_names, run.model.u_names
    assert run.model.drawn_joints == ("rail",) and len(run.model.outlines) == 3
    found = [run.q[-1, names[0].index("slide_0")], run.u[-1, names[1].index("w_3")]]
    assert found == pytest.approx([alone.q[-1, 1], alone.u[-1, 0]], abs=1e-10)


def test_integral_stays_while_its_motor_is_off(workshop: Workshop) -> None:
    events = '[[event]]\nname = "lets_go"\nwhen = "t - 2"\noff = ["motor_0"]\n'
    events += '[[event]]\nname = "takes"\nwhen = "t - 3"\non = ["motor_0"]\n'
    run = simulate(workshop.model(CART + PID + events), until=5.0, rtol=1e-11)
    off = (run.t > 2.0) & (run.t < 3.0)
    gathered = _columns(run)[:, 2]
    assert off.any() and np.ptp(gathered[off]) == 0.0 and gathered[off][0] != 0.0
    speed = run.u[:, run.model.u_names.index("sliding_0")]
    before, after = (int(np.flatnonzero(run.t == t)[0]) for t in (2.0, 3.0))
    assert speed[after] - speed[before] == pytest.approx(LOAD / MASS, rel=1e-9)
    assert gathered[-1] != gathered[off][0]


def test_state_goes_on_to_the_bit(workshop: Workshop, tmp_path: Path) -> None:
    model = workshop.model(STEP + f"limit = {LIMIT}\n")
    for method in ("gauss", "dop853"):
        for stop in (0.4, 1.7):  # while the integral stands, and later
            whole = run_with_stop(model, 4.0, stop, method)
            first = simulate(model, until=stop, rtol=1e-9, method=method)
            kept = HybridState.load(first.state.save(tmp_path / "state.npz"))
            second = simulate(model, until=4.0, state=kept)
            rows = len(second.t)
            for name, found in zip("tqu", (second.t, second.q, second.u), strict=True):
                assert np.array_equal(found, whole[name][-rows:]), (method, stop, name)


def test_inverse_dynamics_and_driving_torque_leave_the_integral_out(workshop: Workshop) -> None:
    """On its own motion nothing is missing, whatever is said of the integral's rate; a turn of the crank costs what it
    costs with a motor that is proportional alone, the integral being zero."""
    model = workshop.model(HELD)
    run = simulate(model, until=1.0)
    q, u = run.at(run.t[3:8])
    accelerations = run.accelerations(run.t[3:8])
    assert np.max(np.abs(inverse_dynamics(model, q, u, accelerations, ["axle"]))) <= 1e-11
    accelerations[:, 3] = 7.0
    assert np.max(np.abs(inverse_dynamics(model, q, u, accelerations, ["axle"]))) <= 1e-11
    assert model.dof == 1
    ways, known = model.motions(q[0]), workshop.model(FOUR_BAR).motions(q[0, :3])
    assert ways[:3] == pytest.approx(known, rel=1e-12) and not np.any(ways[3])
    found, plain = (driving_torque(workshop.model(text), "axle", 3.0, 24) for text in (HELD, FOUR_BAR + HOLD))
    assert found.torque == pytest.approx(plain.torque, abs=1e-9)


def test_equilibrium_is_refused(workshop: Workshop) -> None:
    with pytest.raises(ValueError, match=r"found hold_integral, expected a model without integrals over time"):
        static_equilibrium(workshop.model(HELD))


# -- what it leaves no trace in ----------------------------------------------------------------------------------------


def test_an_integral_of_zero_is_absent(workshop: Workshop) -> None:
    assert workshop.scene(CART + SERVO + "integral = 0\n").canonical() == workshop.scene(CART + SERVO).canonical()


def test_energy_is_the_mechanisms_own(workshop: Workshop) -> None:
    """However large the integral is; so are what its joint carries and the extent of the mechanism."""
    model, plain = workshop.model(HELD), workshop.model(FOUR_BAR + HOLD)
    q, u = plain.start()
    mine, more = np.append(q, 4.0), np.append(u, 1e6)
    assert model.energy(mine, more) == plain.energy(q, u)
    assert model.length == plain.length
    run = simulate(model, until=1.0)
    assert np.max(np.abs(run.reactions(run.t)[:, model.joints.index("hold_integral_hinge")])) <= 1e-12


def test_pictures_do_not_show_it(workshop: Workshop) -> None:
    run = simulate(workshop.model(HELD), until=1.0)
    shown = content(run)
    assert [link["name"] for link in shown["links"]] == ["crank", "coupler", "rocker"]
    assert shown["jointNames"] == ["axle", "joint_1", "joint_2", "joint_3"]
    assert "integral" not in str(shown)
    plain = content(simulate(workshop.model(FOUR_BAR + HOLD), until=1.0))
    assert len(shown["poses"][0]) == len(plain["poses"][0]) and shown["groundPoints"] == plain["groundPoints"]


def test_what_it_costs_is_counted(workshop: Workshop) -> None:
    """The price of the motor holds what integrates, and the scene without it is the one that never named it."""
    scene = workshop.scene(HELD)
    (gravity, hold), (_, plain) = stages.prices(scene), stages.prices(workshop.scene(FOUR_BAR + HOLD))
    assert (gravity.title, hold.title) == ("gravity", "hold")
    with_, without = (price.added["acceleration"].total for price in (hold, plain))
    assert 0 < with_ - without <= 8
    bare = scene.without(1)
    assert bare.mechanism == workshop.scene(FOUR_BAR).mechanism and not bare.mechanism.integrators


def test_names_that_are_taken(workshop: Workshop) -> None:
    """A link of the scene that is called as the integral keeps its name; angles are those of the scene's links."""
    text = HELD.replace("rocker", "hold_integral")
    assert workshop.model(text).links == ("crank", "coupler", "hold_integral", "hold_integral_")
    listed = workshop.scene(
        HELD.replace('{ crank = "90 deg", coupler = "20 deg", rocker = "100 deg" }', "[1.6, 0.3, 1.7]")
    )
    assert len(listed.start.poses) == 4
    with pytest.raises(SceneError, match="expected one of crank, coupler, rocker; correct the name"):
        workshop.scene(HELD.replace("rocker =", "hold_integral ="))


# -- wrong use ---------------------------------------------------------------------------------------------------------

BAD: dict[str, Wrong] = {
    "without an angle": (
        '[[motor]]\njoint = "joint_0"\ntorque = 1\nintegral = 2',
        4,
        "motor[0].integral",
        "found integral without angle, expected it with an angle only; remove it",
    ),
    "alone": (
        '[[motor]]\njoint = "joint_0"\nangle = 1\nintegral = 2',
        1,
        "motor[0]",
        "found an angle without stiffness and damping",
    ),
    "negative": (
        '[[motor]]\njoint = "joint_0"\nangle = 1\nstiffness = 1\nintegral = -2',
        5,
        "motor[0].integral",
        "found -2, expected the gain of the error's integral in N m/(rad s), zero or a positive number",
    ),
    "another unit": (
        '[[motor]]\njoint = "joint_0"\nangle = 1\nstiffness = 1\nintegral = "2 N m/rad"',
        5,
        "motor[0].integral",
        "that is a stiffness against turning, not an integral gain against turning in N m/(rad s)",
    ),
    "the unit of a slide": (
        '[[motor]]\njoint = "joint_0"\nangle = 1\nstiffness = 1\nintegral = "2 N/(m s)"',
        5,
        "motor[0].integral",
        "an integral gain, expected an integral gain against turning in N m/(rad s)",
    ),
}


@pytest.mark.parametrize("case", BAD)
def test_wrong_table(case: str, workshop: Workshop) -> None:
    check_refusal(BAD[case], workshop)
