"""Three equal bodies in a row, the first striking the others with e = 1: discs about one axle, stops between them."""

from __future__ import annotations

import numpy as np
import pytest

from ccgen.runtime import simulate

from ..support.bodies import rise
from ..support.reach import Reach
from ..support.workshop import Workshop


def cradle(gap: float) -> str:
    """The first disc starts half a radian behind the second, which the third leads by ``gap``."""
    links = "".join(
        f'[[link]]\nname = "disc_{k}"\nmass = 1.0\ninertia = 0.5\ncom = [0, 0]\npoints = {{ axle = [0, 0] }}\n'
        for k in range(3)
    )
    joints = '[[joint]]\nbetween = ["ground.axle", "disc_0.axle"]\n' + "".join(
        f'[[joint]]\nname = "touch_{k}"\nbetween = ["disc_{k}.axle", "disc_{k + 1}.axle"]\n' for k in (0, 1)
    )
    stops = "".join(f'[[stop]]\njoint = "touch_{k}"\nlowest = 0.0\nrestitution = 1.0\n' for k in (0, 1))
    return (
        f'name = "cradle"\n[ground_link]\npoints = {{ axle = [0, 0] }}\n{links}{joints}{stops}'
        f"[start]\nangles = {{ disc_0 = -0.5, disc_1 = 0.0, disc_2 = {gap!r} }}\n"
        "angular_velocities = { disc_0 = 1.0, disc_1 = 0.0, disc_2 = 0.0 }\n"
    )


@pytest.mark.parametrize(
    ("gap", "meant", "wanted"), [(0.0, "touching", (-1 / 3, 2 / 3, 2 / 3)), (1e-6, "a gap apart", (0.0, 0.0, 1.0))]
)
def test_three_bodies_in_a_row(
    gap: float, meant: str, wanted: tuple[float, float, float], workshop: Workshop, reach: Reach
) -> None:
    """Contacts that are closed strike together, by the simultaneous law; a gap of a micrometre makes them two impacts,
    one after another."""
    run = simulate(workshop.model(cradle(gap)), until=1.0)
    assert run.success, run.message
    assert [len(impact.contacts) for impact in run.impacts] == ([1, 1] if gap else [2])
    speeds = run.model.velocities(run.q[-1], run.u[-1])[:, 2]
    reach(f"three bodies, {meant}: speeds, of the first's", np.max(np.abs(speeds - wanted)), 1e-12)
    reach(f"three bodies, {meant}: time of the strike, s", abs(run.impacts[0].t - 0.5), 1e-12)
    reach(f"three bodies, {meant}: rise of energy", rise(run), 1e-12)
