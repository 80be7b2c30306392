"""``ccgen run`` says where steps are as short as stability asks for, and radau needs fewer; else nothing."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from ccgen.generator.cli.remarks import STABLE, _fastest, _stiff
from ccgen.runtime import simulate

from ..support.command_line import ccgen
from ..support.folders import SCENES
from ..support.workshop import Workshop

PILE = """
name = "pile"
[ground_link]
points = { O = [0, 0] }
[[link]]
name = "pile"
mass = 300
inertia = 10
com = [0, 0]
points = { T = [0, 1], B = [0, -1], C = [0, 0] }
[[link]]
name = "ram"
mass = 500
inertia = 10
com = [0, 0]
points = { B = [0, 0] }
[[joint]]
name = "guide"
type = "prismatic"
between = ["ground.O", "pile.C"]
axis = [0, 1]
[[joint]]
name = "rail"
type = "prismatic"
between = ["ground.O", "ram.B"]
axis = [0, 1]
[[compliant_ground]]
load = 1e5
depth = 1e-4
damping = 0.5
contacts = ["pile.B"]
point = [0, -1]
exponent = 1
[[compliant_touch]]
between = ["ram.B", "pile.T"]
radius = 0.1
load = 2e8
depth = 1e-3
damping = 50
[[joint_friction]]
joints = ["guide"]
viscous = 1e7
[gravity]
[start]
slides = { guide = 0.0, rail = 1.5 }
[run]
until = 1
rtol = 1e-9
"""
"""A ram that falls on a pile in earth that resists as 1e7 N s/m: rates up to 1e7/300 per second, long died away."""


@pytest.mark.parametrize("method", ["gauss", "dop853", "dopri5"])
def test_a_pile_driver_is_told_of_radau(method: str, workshop: Workshop) -> None:
    """The fastest rate is viscous over mass, in closed form; radau needs less than a fifth of the rows."""
    model = workshop.model(PILE)
    run = simulate(model, method=method)
    (remark,) = _stiff(run)
    assert "--method radau" in remark and method in remark
    assert _fastest(run, 0) == pytest.approx(1e7 / 300.0, rel=1e-3)
    assert len(simulate(model, method="radau").t) < len(run.t) / 5
    assert np.median(np.diff(run.t)) * 1e7 / 300.0 > 0.75 * STABLE[method]


def test_what_is_not_stiff_or_no_better_by_radau_is_not(workshop: Workshop) -> None:
    """Smooth motions of many steps at loose and tight tolerances, the pile by radau, by steps that were asked for, and
    where its tolerance asks radau for more steps than others need."""
    pile = workshop.model(PILE)
    quiet = [simulate(pile, method="radau"), simulate(pile, method="dopri5", step=8e-5, until=0.2)]
    tight = simulate(pile, method="dop853", rtol=1e-12)
    assert len(simulate(pile, method="radau", rtol=1e-12).t) > len(tight.t)
    swings = workshop.model((SCENES / "open-chain.toml").read_text(encoding="utf-8"))
    for method in STABLE:
        for rtol in (1e-4, 1e-11):
            quiet.append(simulate(swings, method=method, rtol=rtol, until=60.0))
    assert sum(len(run.t) > 1000 for run in quiet) >= 6
    for run in (*quiet, tight):
        assert not list(_stiff(run)), (run.method, len(run.t))


SPRING = """
[ground_link]
points = { O = [0, 0] }
[[link]]
name = "block"
mass = 1.0
inertia = 0.01
com = [0, 0]
points = { A = [0, 0] }
[[joint]]
name = "guide"
type = "prismatic"
between = ["ground.O", "block.A"]
axis = [1, 0]
[[spring]]
between = ["ground.O", "block.A"]
stiffness = 1e4
length = 0.5
[[joint_friction]]
joints = ["guide"]
viscous = 0.0
[start]
slides = { guide = 0.51 }
[run]
until = 60.0
"""
"""A block on a spring: rates ± 100 i per second without friction."""


@pytest.mark.parametrize("method", STABLE)
def test_swings_are_not_stiff(method: str, workshop: Workshop) -> None:
    """Steps that follow 955 swings, also so loosely that they are as long as stability lets them."""
    model = workshop.model(SPRING)
    longest = 0.0
    for rtol in (1e-1, 1e-2, 1e-3, 1e-6):
        run = simulate(model, method=method, rtol=rtol)
        longest = max(longest, float(np.median(np.diff(run.t))) * 100.0)
        assert _fastest(run, 0) is None
        assert not list(_stiff(run)), (rtol, len(run.t))
    assert method != "dop853" or longest > 0.75 * STABLE[method]  # where the remark was once


@pytest.mark.parametrize(
    ("viscous", "fastest"), [(0.0, None), (100.0, None), (200.0, 100.0), (1000.0, 500.0 + 24e4**0.5)]
)
def test_the_fastest_rate_is_of_a_decay(viscous: float, fastest: float | None, workshop: Workshop) -> None:
    """λ² + c λ + 10⁴ = 0: rates 100 exp(± 2πi/3) at c = 100, which are swings, 100 where they meet, and two decays."""
    run = simulate(workshop.model(SPRING), until=0.1, params={"joint_friction_0.viscous": viscous})
    assert _fastest(run, 0) == (None if fastest is None else pytest.approx(fastest, rel=1e-3))


TURNING = """
[ground_link]
points = { O = [0, 0], P = [3, 0] }
[[link]]
name = "wheel"
mass = 1.0
inertia = 0.01
com = [0, 0]
points = { A = [0, 0], B = [1, 0], FAR = [SIZE, 0] }
[[joint]]
name = "axle"
between = ["ground.O", "wheel.A"]
[[spring]]
between = ["ground.P", "wheel.B"]
stiffness = 0.3333333333333333
[[torsion]]
joint = "axle"
damping = 1.0
[run]
until = 1e-3
"""


@pytest.mark.parametrize("size", [1.5, 1e9])
def test_the_fastest_rate_knows_no_length(size: float, workshop: Workshop) -> None:
    """An angle's differences are parts of a radian, however far its link reaches. The spring's energy is
    (10 − 6 cos φ)/6, so 0.01 λ² + λ + 1 = 0."""
    run = simulate(workshop.model(TURNING.replace("SIZE", repr(size))))
    assert _fastest(run, 0) == pytest.approx(50.0 + 2400.0**0.5, rel=1e-6)


def test_the_command_says_it(tmp_path: Path) -> None:
    (tmp_path / "pile.toml").write_text(PILE)
    done = ccgen("run", "pile.toml", at=tmp_path)
    assert done.returncode == 0 and "something is stiff" in done.stderr, done.stderr
    (tmp_path / "four-bar.toml").write_text((SCENES / "four-bar.toml").read_text(encoding="utf-8"))
    done = ccgen("run", "four-bar.toml", "--until", "60", at=tmp_path)
    assert done.returncode == 0 and "stiff" not in done.stderr
