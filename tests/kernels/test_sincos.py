"""The runtime's sines and cosines against 40 digits."""

from __future__ import annotations

import ctypes
import math
import shutil
import subprocess
from collections.abc import Callable

import mpmath
import numpy as np
import pytest

from ..oracles.maximal import Array
from ..support.folders import RUNTIME

LIMIT = 65536.0
SOURCE = """
#include "sincos.h"
void both(size_t count, const double *x, double *c, double *s) { ccgen_sincos(count, x, c, s); }
"""
Both = Callable[[Array], tuple[Array, Array]]
pytestmark = pytest.mark.skipif(shutil.which("cc") is None, reason="there is no cc")


@pytest.fixture(scope="module", params=["-O2", "-O2 -march=native -fno-math-errno", "-O0 -ffp-contract=off"])
def both(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Both:
    folder = tmp_path_factory.mktemp("sincos")
    (folder / "both.c").write_text(SOURCE)
    command = ["cc", "-std=c11", *request.param.split(), "-fPIC", "-shared", f"-I{RUNTIME}", "both.c", "-lm"]
    subprocess.run([*command, "-o", "both.so"], cwd=folder, check=True)
    function = ctypes.CDLL(str(folder / "both.so")).both
    function.argtypes = [ctypes.c_size_t, *3 * [ctypes.c_void_p]]
    function.restype = None

    def call(x: Array) -> tuple[Array, Array]:
        x = np.ascontiguousarray(x, dtype=float)
        c, s = np.full(x.size + 1, np.nan), np.full(x.size + 1, np.nan)
        function(x.size, x.ctypes.data, c.ctypes.data, s.ctypes.data)
        assert np.isnan(c[-1])
        assert np.isnan(s[-1])
        return c[:-1], s[:-1]

    return call


def worst(found: Array, exact: Callable[[mpmath.mpf], mpmath.mpf], x: Array) -> float:
    """Largest error in units in the last place of the exact value."""
    errors = []
    with mpmath.workprec(160):
        for value, at in zip(found.tolist(), x.tolist(), strict=True):
            wanted = exact(mpmath.mpf(at))
            errors.append(abs(float(mpmath.mpf(value) - wanted)) / math.ulp(float(wanted)))
    return max(errors)


def check(both: Both, x: Array) -> None:
    c, s = both(x)
    assert worst(c, mpmath.cos, x) <= 2.0
    assert worst(s, mpmath.sin, x) <= 2.0


@pytest.mark.parametrize("size", [1e-9, 1.0, 7.0, 100.0, 6.5e4, LIMIT])
def test_anywhere(both: Both, size: float) -> None:
    x = np.random.default_rng(1).uniform(-size, size, 1200)
    check(both, np.append(x, [size, -size]))


def test_small_angles(both: Both) -> None:
    x = 10.0 ** np.random.default_rng(2).uniform(-300, 0, 500)
    check(both, np.concatenate([x, -x]))
    c, s = both(np.array([0.0, -0.0, 5e-324]))
    assert c.tolist() == [1.0, 1.0, 1.0]
    assert s.tolist() == [0.0, 0.0, 5e-324]


def test_near_multiples_of_a_right_angle(both: Both) -> None:
    """Where all but the last digits cancel: the nearest doubles and their neighbours, the nearest of all among them."""
    count = int(LIMIT / (np.pi / 2))
    with mpmath.workprec(160):
        right = mpmath.pi / 2
        misses = sorted((abs(k * right - mpmath.mpf(float(k * right))), k) for k in range(1, count, 5))
        chosen = [*range(1, 200), *(k for _, k in misses[:300])]
        chosen += np.random.default_rng(3).integers(200, count, 500).tolist()
        x = np.array([float(k * right) for k in chosen])
    check(both, np.concatenate([x, -x, np.nextafter(x, 0), np.nextafter(x, 1e9)]))


@pytest.mark.parametrize("count", range(20))
def test_any_number_of_angles(both: Both, count: int) -> None:
    """Whole blocks and what is left over give the values that each angle gives alone."""
    x = np.linspace(-3.0, 40.0, 19)[:count]
    c, s = both(x)
    for k, angle in enumerate(x):
        one_c, one_s = both(np.array([angle]))
        assert (c[k], s[k]) == (one_c[0], one_s[0])


BEYOND = [np.nextafter(LIMIT, 1e9), 65537.0, 1e6, 1e22, 1.7e308, -70000.3]


@pytest.mark.parametrize("angle", BEYOND)
@pytest.mark.parametrize("place", [0, 3, 8])
def test_beyond_the_limit_the_library_answers(both: Both, angle: float, place: int) -> None:
    x = np.linspace(0.1, 2.0, 9)
    x[place] = angle
    c, s = both(x)
    assert c.tolist() == [math.cos(a) for a in x]
    assert s.tolist() == [math.sin(a) for a in x]


@pytest.mark.parametrize("angle", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("place", range(9))
def test_what_is_no_angle_has_no_sine(both: Both, angle: float, place: int) -> None:
    """The others keep theirs."""
    x = np.linspace(0.1, 2.0, 9)
    x[place] = angle
    c, s = both(x)
    rest = np.arange(9) != place
    assert np.isnan(c[place])
    assert np.isnan(s[place])
    check_values = np.array([[math.cos(a), math.sin(a)] for a in x[rest]])
    assert np.max(np.abs(np.column_stack([c, s])[rest] - check_values)) <= 3e-16
