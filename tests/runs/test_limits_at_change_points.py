"""What is told at change points of driven loops and beside them, against four-bars in eighty digits."""

from __future__ import annotations

import numpy as np
import pytest
from mpmath import mp, mpf

from ccgen.runtime import simulate
from ccgen.runtime.record.outputs import values_of

from ..support.wide_four_bar import DIGITS, FourBar
from ..support.workshop import Workshop

PARALLELOGRAM = FourBar(("0.3", "1.5", "0.3", "1.5"), ("10", "40", "10"), "6.28", "1.5", "-100")
IDLE = FourBar(("0.3", "1.5", "0.3", "1.5"), ("10", "40", "10"), "6.28", "1.5")
CROSSED = FourBar(("0.2", "0.5", "0.2", "0.5"), ("1", "1", "1"), "6", "-1")
KITE = FourBar(("0.3", "0.5", "0.5", "0.3"), ("1", "2", "3"), "3", "1")
CASES = {"parallelogram": PARALLELOGRAM, "idle": IDLE, "crossed": CROSSED, "kite": KITE}
EXPONENTS = (1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 12)


@pytest.mark.parametrize("case", CASES)
def test_forces_beside_and_at_change_points(case: str, workshop: Workshop) -> None:
    bar = CASES[case]
    with mp.workdps(DIGITS):
        place = mp.pi if case != "kite" else 2 * mp.pi
        close = [sign * mpf(10) ** -k for k in EXPONENTS for sign in (-1, 1)]
        nearest = [sign * mpf(10) ** -14 for sign in (-1, 1)]
        exact = bar.beside(place, close + nearest)
    angle, rate = float(bar.angle), float(bar.rate)
    at = (float(place) - angle) / rate
    run = simulate(workshop.model(bar.scene(at + 0.2)), rtol=1e-11)
    assert run.success
    names = list(exact[close[0]])
    t = np.array([at, *(at + float(x) / rate for x in close)])
    found = values_of(run, names, t)
    poles = {name: exact[nearest[1]][name] * 1e-14 for name in names}
    size = max(map(abs, exact[close[1]].values()))
    for name in names:
        if abs(poles[name]) > 1e-8 * size:
            assert abs(exact[nearest[0]][name] + exact[nearest[1]][name]) < 1e-9 * abs(exact[nearest[1]][name])
            assert np.isinf(found[name][0]), name
        else:
            mean = (exact[nearest[0]][name] + exact[nearest[1]][name]) / 2
            assert found[name][0] == pytest.approx(mean, rel=1e-8, abs=1e-8 * size), name
        for k, x in enumerate(close):
            right, bound = exact[x][name], 1e-8 * size
            if abs(poles[name]) > 1e-8 * size:  # its distance counts, which is known to the root of rounding
                if abs(x) < 1e-7:
                    continue
                bound += 2e-8 / float(abs(x)) * abs(right)
            assert abs(found[name][k + 1] - right) <= bound + 1e-8 * abs(right), (name, x)
