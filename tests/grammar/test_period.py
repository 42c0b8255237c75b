"""The shortest period, under noise and uneven tempo; stillness and one-way movement have none."""

from __future__ import annotations

import numpy as np
import pytest

import kinesics as kx
from kinesics.grammar import lags, moments, period


def _find(m: moments.Moments) -> lags.LagPath | None:
    by_lag = m.by_lag(period.longest_lag(m.count, m.fps))
    return period.find(by_lag[0], shortest=period.SHORTEST_S * m.fps)


@pytest.mark.parametrize("name", ["walk", "run", "jumping_jacks", "squat", "wave", "arm_circles", "butterfly", "twist"])
def test_the_shortest_period_is_found_under_noise(name: str):
    """Neither half a period (walking looks alike then, mirrored) nor two."""
    p = kx.performer.perform(name, seconds=9, fps=30, noise_degrees=2, seed=5)
    found = _find(moments.from_poses(kx.poses(p.motion)))
    assert found is not None
    assert p.truth.period_s is not None
    assert found.lag / 30.0 == pytest.approx(p.truth.period_s, rel=0.03)


def test_uneven_tempo_is_followed():
    """With cycles that differ by a tenth, the path is good everywhere and no wrong lag is taken."""
    p = kx.performer.walk(seconds=12, fps=60, tempo_jitter=0.1, seed=3)
    found = _find(moments.from_poses(kx.poses(p.motion)))
    assert found is not None
    assert p.truth.period_s is not None
    assert found.lag / 30.0 == pytest.approx(p.truth.period_s, rel=0.08)
    assert np.quantile(found.costs, 0.95) < 0.002
    assert np.ptp(found.lags) >= 3


def test_what_happens_once_has_no_period():
    """A throw does not come back."""
    assert _find(moments.from_poses(kx.poses(kx.performer.throw(fps=30, seed=1).motion))) is None


def test_the_period_does_not_depend_on_numpy_or_compiled(monkeypatch: pytest.MonkeyPatch):
    """Both code paths take the same trial."""
    m = moments.from_poses(kx.poses(kx.performer.run(seconds=5, fps=30, noise_degrees=1, seed=1).motion))
    seen = []
    for way in ("0", "1"):
        monkeypatch.setenv("KINESICS_NO_NATIVE", way)
        found = _find(m)
        assert found is not None
        seen.append(found.lags)
    assert np.array_equal(*seen)


def test_the_longest_lag_does_not_grow_with_an_hour():
    """Memory grows with the length of a recording, not with its square."""
    assert period.longest_lag(100, 30.0) == 70
    assert period.longest_lag(108_000, 30.0) == int(period.LONGEST_S * 30.0)
