"""What weighs next to nothing: right, or told."""

from __future__ import annotations

import re
from typing import Any

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
