"""Curves of more points than a picture shows are drawn by the extremes of groups of them."""

from __future__ import annotations

import numpy as np

from ccgen.runtime.pictures.plot import thinned


def test_long_curves_keep_their_extremes_and_ends() -> None:
    """A sine of a million points with one spike up and one down, each a single point."""
    t = np.linspace(0.0, 10.0, 1_000_003)
    curve = np.sin(t)
    curve[123_457], curve[765_431] = 5.0, -7.0
    few_t, few = thinned(t, curve)
    assert len(few) < 20_000 and np.all(np.diff(few_t) > 0.0)
    assert np.isin([0.0, t[123_457], t[765_431], 10.0], few_t).all()
    assert few.max() == 5.0 and few.min() == -7.0
    plain = np.abs(few) <= 1.0
    assert np.array_equal(few[plain], np.sin(few_t[plain]))


def test_short_curves_are_drawn_as_they_are() -> None:
    t = np.linspace(0.0, 1.0, 10_000)
    curve = np.cos(40.0 * t)
    few_t, few = thinned(t, curve)
    assert np.array_equal(few_t, t) and np.array_equal(few, curve)


def test_gaps_stay_where_they_are() -> None:
    curve = np.sin(np.linspace(0.0, 1.0, 100_000))
    curve[500:600] = np.nan
    assert np.array_equal(thinned(curve, curve)[1], curve, equal_nan=True)
