"""Outputs of runs by name, against closed forms, differences, and what the run says otherwise."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.special import ellipj, ellipk

from ccgen.generator import load_scene
from ccgen.runtime import simulate

from ..support.folders import SCENES
from ..support.tiers import hard
from ..support.workshop import Workshop
from .test_release_and_hold import TREBUCHET

G = 9.81
PENDULUM = """
name = "pendulum"
[ground_link]
points = { O = [0, 0] }
[[link]]
name = "rod"
mass = 1.0
inertia = 0.0
com = [2, 0]
points = { A = [0, 0], B = [2, 0] }
[[joint]]
name = "pin"
between = ["ground.O", "rod.A"]
[start]
angles = { rod = "0 deg" }
[gravity]
[run]
until = 4.0
"""
"""A point of 1 kg, 2 m from the pin, let go at the height of the pin."""


def test_a_pendulum_is_that_of_its_closed_form(workshop: Workshop) -> None:
    """sin(φ/2) = k sn(K - ω t) from the vertical, k = sin(π/4); the force, from energy, 3 m g cos φ along the rod."""
    run = simulate(workshop.model(PENDULUM), rtol=1e-12)
    omega, k = math.sqrt(G / 2), math.sin(math.pi / 4)
    sn, cn, _, _ = ellipj(ellipk(k**2) - omega * run.t, k**2)
    swing, rate = 2 * np.arcsin(k * sn), -2 * k * omega * cn
    assert run["rod.angle"] == pytest.approx(swing - math.pi / 2, abs=1e-9)
    assert run["pin.angle"] == pytest.approx(run["rod.angle"], abs=1e-14)
    assert run["rod.angular_velocity"] == pytest.approx(rate, abs=1e-9)
    assert run["rod.angular_acceleration"] == pytest.approx(-(omega**2) * np.sin(swing), abs=1e-9)
    assert run["rod.B.x"] == pytest.approx(2 * np.sin(swing), abs=1e-9)
    assert run["rod.B.vy"] == pytest.approx(2 * rate * np.sin(swing), abs=1e-8)
    assert run["rod.B.speed"] == pytest.approx(2 * np.abs(rate), abs=1e-8)
    assert run["rod.B.ay"] == pytest.approx(2 * (rate**2 * np.cos(swing) - omega**2 * np.sin(swing) ** 2), abs=1e-8)
    assert run["pin.force"] == pytest.approx(3 * G * np.cos(swing), abs=1e-8)
    assert run["pin.fy"] == pytest.approx(3 * G * np.cos(swing) ** 2, abs=1e-8)
    assert run["pin.moment"] == pytest.approx(0.0, abs=1e-12)
    assert run["energy"] == pytest.approx(0.0, abs=1e-9)
    assert run["kinetic_energy"] == pytest.approx(-run["potential_energy"], abs=1e-9)
    assert run["t"] is run.t or np.array_equal(run["t"], run.t)


def test_times_are_as_exact_as_rows(workshop: Workshop) -> None:
    run = simulate(workshop.model(PENDULUM), rtol=1e-12)
    t = np.linspace(0.0, 4.0, 57)
    sn = ellipj(ellipk(0.5) - math.sqrt(G / 2) * t, 0.5)[0]
    found = run.values("rod.angle", "pin.force", t=t)
    assert found["rod.angle"] == pytest.approx(2 * np.arcsin(sn / math.sqrt(2)) - math.pi / 2, abs=1e-9)
    assert found["pin.force"] == pytest.approx(3 * G * (1 - sn**2), abs=1e-8)
    one = run.values("rod.angle", t=1.5)["rod.angle"]
    assert np.shape(one) == () and one == pytest.approx(run.values("rod.angle", t=[1.5])["rod.angle"][0], abs=0)
    with pytest.raises(ValueError, match="expected times within the run"):
        run.values("rod.angle", t=[1.0, 5.0])


@pytest.mark.sample(2)
@pytest.mark.parametrize("scene", ["falling-hexagon", "quick-return", "planetary", hard("ratchet"), hard("escapement")])
def test_every_output_of_a_scene_is_what_the_run_says_otherwise(scene: str, workshop: Workshop) -> None:
    """Of all names: units, shapes; rates are derivatives of what they are rates of, at times without events."""
    run = simulate(workshop.model(load_scene(SCENES / f"{scene}.toml")), until=0.9)
    every = run.values(*run.outputs)
    assert all(value.shape == run.t.shape for value in every.values())
    t = np.linspace(0.11, 0.7, 5)
    events = np.array([phase.end for phase in run.phases])
    h = 1e-4
    t = t[[np.abs(events - one).min() > 10 * h for one in t]]
    assert len(t) >= 3
    pairs = {".vx": ".x", ".vy": ".y", ".ax": ".vx", ".ay": ".vy", ".angular_velocity": ".angle"}
    pairs |= {".angular_acceleration": ".angular_velocity", ".slide_rate": ".slide", ".gap_rate": ".gap"}
    checked = 0
    for name in run.outputs:
        owner, _, asked = name.rpartition(".")
        if f".{asked}" not in pairs:
            continue
        of = f"{owner}{pairs['.' + asked]}"
        low, high, now = (run.values(name, of, t=t + shift) for shift in (-h, h, 0.0))
        size = 1.0 + np.abs(now[name]).max()
        assert (high[of] - low[of]) / (2 * h) == pytest.approx(now[name], abs=1e-3 * size), name
        checked += 1
    assert checked > 10
    reactions, model = run.reactions(t), run.model
    for number, joint in enumerate(model.joints):
        if f"{joint}.fx" in run.outputs:
            assert run.values(f"{joint}.fx", t=t)[f"{joint}.fx"] == pytest.approx(reactions[:, number, 0], abs=0)
    pushes = run.contact_forces(t)
    for number, (point, ground) in enumerate(model.contacts):
        name = f"{ground}.{point}.normal"
        assert run.values(name, t=t)[name] == pytest.approx(pushes[:, number, 0], abs=0)


def test_an_impact_is_two_rows(workshop: Workshop) -> None:
    run = simulate(workshop.model(load_scene(SCENES / "falling-hexagon.toml")))
    row = int(np.flatnonzero(run.t == run.impacts[0].t)[0])
    speed = run["joint_0.vy"]
    point, ground = run.impacts[0].contacts[0]
    assert speed[row] < -1.0 and speed[row + 1] > speed[row]
    assert run[f"{ground}.{point}.gap"][row : row + 2] == pytest.approx(0.0, abs=1e-12)


def test_impulses_are_at_impacts(workshop: Workshop) -> None:
    """Of every contact, along and across, and of joints, those of the impacts; in the row after each, else zero."""
    run = simulate(workshop.model(load_scene(SCENES / "falling-hexagon.toml")))
    struck = np.array([impact.t for impact in run.impacts])
    after = np.searchsorted(run.t, struck, side="right") - 1
    total = np.zeros(len(run.t))
    for point, ground in run.model.contacts:
        name = f"{ground}.{point}.impulse"
        total += run[name]
        assert np.array_equal(run.values(name, t=struck)[name], run[name][after])
        assert not run.values(name, t=struck[0] - 1e-3)[name]
    assert total[after] == pytest.approx([impact.impulses.sum() for impact in run.impacts], rel=1e-15)
    assert np.flatnonzero(total).tolist() == after.tolist()
    assert run["joint_0.impulse"][after] == pytest.approx(
        [np.hypot(*impact.reactions[0, :2]) for impact in run.impacts], rel=1e-15
    )


def test_powers_of_drives_are_the_rate_of_the_energy(workshop: Workshop) -> None:
    """Of a crank that is driven against the ground, of one named from the ground's side, and along a line."""
    turning = (SCENES / "jansen-driven.toml").read_text(encoding="utf-8")
    sliding = STOPPED.partition("[[ground]]")[0] + "[gravity]\n[start]\nslides = { guide = 0.3 }\n[run]\nuntil = 1\n"
    sliding = sliding.replace("0.3 - 0.5*t", "0.3 + 0.1*sin(4*t)")
    backwards = sliding.replace('"ground.O", "ram.C"', '"ram.C", "ground.O"').replace("0.3 + 0.1", "-0.3 + 0.1")
    backwards = backwards.replace("guide = 0.3", "guide = -0.3")
    for text, name in ((turning, "axle.power"), (sliding, "guide.power"), (backwards, "guide.power")):
        run = simulate(workshop.model(text), until=0.8, rtol=1e-11)
        t, h = np.linspace(0.1, 0.7, 7), 1e-4
        early, late = (run.values("energy", t=t + shift)["energy"] for shift in (-h, h))
        power = run.values(name, t=t)[name]
        assert np.abs(power).max() > 1.0
        assert (late - early) / (2 * h) == pytest.approx(power, abs=1e-5 * np.abs(power).max())


def test_through_joints_that_let_go(workshop: Workshop) -> None:
    """A thrown stone flies as one: ẍ = 0, ÿ = -g; the joint that has let go carries nothing."""
    run = simulate(workshop.model(TREBUCHET), rtol=1e-10)
    t = np.linspace(run.changes[0].t + 1e-3, run.t[-1], 9)
    found = run.values("stone.C.ax", "stone.C.ay", f"{run.changes[0].joint}.force", t=t)
    assert found["stone.C.ax"] == pytest.approx(0.0, abs=1e-9)
    assert found["stone.C.ay"] == pytest.approx(-G, abs=1e-9)
    assert not found[f"{run.changes[0].joint}.force"].any()


def test_what_is_not_known_is_no_number(workshop: Workshop) -> None:
    """The last row of a run that stopped early has places, and no forces."""
    stopped = simulate(workshop.model(STOPPED))
    assert not stopped.success and np.isfinite(stopped["ram.P.y"]).all()
    assert np.isnan(stopped["guide.force"][-1]) and np.isfinite(stopped["guide.force"][:-1]).all()
    assert np.isnan(stopped["ram.P.ay"][-1]) and np.isnan(stopped["ram.angular_acceleration"][-1])


STOPPED = """
name = "press"
[ground_link]
points = { O = [0, 0] }
[[link]]
name = "ram"
mass = 2
inertia = 0.1
com = [0, 0]
points = { C = [0, 0], P = [-0.1, 0] }
[[joint]]
name = "guide"
type = "prismatic"
between = ["ground.O", "ram.C"]
axis = [0, 1]
[[drive]]
joint = "guide"
position = "0.3 - 0.5*t"
[[ground]]
contacts = ["ram.P"]
restitution = 0.3
[gravity]
[start]
slides = { guide = 0.3 }
[run]
until = 3
"""


def test_names_of_two_things_say_which(workshop: Workshop) -> None:
    """The rod against the ground, and the joint's second link, the ground, against the rod."""
    text = PENDULUM.replace(
        'name = "pin"\nbetween = ["ground.O", "rod.A"]', 'name = "rod"\nbetween = ["rod.A", "ground.O"]'
    )
    run = simulate(workshop.model(text), until=0.5)
    assert "rod.angle" not in run.outputs
    assert run["joint rod.angle"] == pytest.approx(-run["link rod.angle"], abs=1e-14)
    assert run["rod.force"].shape == run.t.shape  # a joint's alone
    with pytest.raises(
        ValueError, match=r"'rod.angle', which is of two things, expected 'link rod.angle' or 'joint rod"
    ):
        run["rod.angle"]


def test_names_that_are_none_are_told_with_what_is_near(workshop: Workshop) -> None:
    run = simulate(workshop.model(PENDULUM), until=0.5)
    with pytest.raises(
        ValueError, match=r"found 'rod.angel', .* such as rod.angle, .*; output: found 'x', which nothing"
    ):
        run.values("rod.angel", "rod.angle", "x")
    with pytest.raises(ValueError, match=r"found 'rod.wobble', .* such as rod\."):
        run["rod.wobble"]
    with pytest.raises(TypeError, match="found 0, expected a name such as 't'"):
        run[0]  # type: ignore[index]


def test_a_table_has_units_and_even_times(workshop: Workshop) -> None:
    pytest.importorskip("pandas")
    run = simulate(workshop.model(PENDULUM))
    frame = run.to_dataframe(["rod.angle", "pin.force"], t=np.linspace(0, 4, 11))
    assert [*frame.columns] == ["rod.angle", "pin.force"] and frame.index.name == "t" and len(frame) == 11
    assert frame.attrs["units"] == {"rod.angle": "rad", "pin.force": "N"}
    assert frame["rod.angle"].iloc[-1] == pytest.approx(run["rod.angle"][-1], abs=1e-12)
    states = run.to_dataframe(t=[0.5, 1.0])
    assert states["theta_0"].tolist() == pytest.approx(
        run.values("rod.angle", t=[0.5, 1.0])["rod.angle"].tolist(), abs=0
    )


def test_the_moment_of_a_driven_joint_is_its_torque(workshop: Workshop) -> None:
    """Of a rod that a drive turns evenly: m g l cos φ, and what the shaft carries besides."""
    run = simulate(workshop.model(f'{PENDULUM}[[drive]]\njoint = "pin"\nspeed = 3\n'))
    assert run["pin.moment"] == pytest.approx(2 * G * np.cos(3 * run.t), abs=1e-9)
    assert run["pin.fx"] == pytest.approx(-2 * 9 * np.cos(3 * run.t), abs=1e-9)
    assert run["pin.fy"] == pytest.approx(G - 2 * 9 * np.sin(3 * run.t), abs=1e-9)


def test_a_dataset_has_outputs_by_name_and_their_units(workshop: Workshop) -> None:
    pytest.importorskip("xarray")
    run = simulate(workshop.model(PENDULUM))
    t = np.linspace(0, 4, 11)
    data = run.to_xarray(["rod.angle", "pin.force"], t=t)
    assert [*data.data_vars] == ["rod.angle", "pin.force"] and dict(data.sizes) == {"t": 11}
    assert data["pin.force"].attrs["units"] == "N" and data["t"].attrs["units"] == "s"
    assert np.array_equal(data["pin.force"].values, run.values("pin.force", t=t)["pin.force"])
    whole = run.to_xarray()
    assert whole["q_of"].values.tolist() == ["rod.angle"]
