"""Transitions without seams: curves that meet in value, velocity and acceleration."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from kinesics.geometry import quaternion
from kinesics.synthesis.embodiment import blending

VECTORS = arrays(np.float64, (3,), elements=st.floats(-2.0, 2.0))


@given(VECTORS, VECTORS, st.floats(0.05, 1.0))
def test_decay_starts_as_asked_and_ends_at_rest(offset: np.ndarray, velocity: np.ndarray, duration: float) -> None:
    """Value and velocity at the start are those given, the acceleration is 0; all three are 0 at the end and beyond."""
    h = 1e-4 * duration
    near = blending.decay(offset, velocity, np.array([0.0, h, 2 * h, 3 * h]), duration)
    size = np.abs(offset).max() + duration * np.abs(velocity).max() + 1e-9
    assert np.allclose(near[0], offset)
    assert np.abs((near[1] - near[0]) / h - velocity).max() < 1e-3 * size / duration
    # forward second differences see 1.5 steps ahead, so the jerk there is let pass
    assert np.abs((near[2] - 2 * near[1] + near[0]) / h**2).max() < 0.05 * size / duration**2
    end = blending.decay(offset, velocity, duration - np.array([2 * h, h, 0.0, -h]), duration)
    assert np.abs(end).max() < 1e-9 * size


@given(VECTORS, VECTORS, st.floats(0.05, 0.5), st.floats(0.05, 0.5))
def test_two_sides_make_up_the_whole_offset(
    offset: np.ndarray, velocity: np.ndarray, before: float, after: float
) -> None:
    """What is added before the cut less what is added after it is the offset, and likewise their velocities."""
    window = blending.window(np.ones(1), np.ones(1), np.ones(1), before=before, after=after)
    h = 1e-6
    early = blending.two_sided(offset, velocity, np.array([-2 * h, -h]), window)
    late = blending.two_sided(offset, velocity, np.array([0.0, h]), window)
    assert np.abs(2 * early[1] - early[0] - late[0] - offset).max() < 1e-6
    assert np.abs((early[1] - early[0] - late[1] + late[0]) / h - velocity).max() < 1e-2
    outside = blending.two_sided(offset, velocity, np.array([-window.before, window.after, 2.0, -2.0]), window)
    assert np.abs(outside).max() < 1e-9


def test_two_curves_become_one_of_continuous_acceleration() -> None:
    """Two sines joined at a cut have no leap in value, velocity or acceleration that the sines themselves would not have."""
    fps = 1000.0
    times = np.arange(-500, 500) / fps
    left, entered = np.sin(2.0 * times), 0.7 * np.sin(2.4 * times + 0.3) + 0.1
    offset = np.array([entered[500] - left[500], 0.0, 0.0])
    velocity = np.array([0.7 * 2.4 * np.cos(0.3) - 2.0, 0.0, 0.0])
    window = blending.Window(0.3, 0.3, 0.5)
    joined = np.where(times < 0.0, left, entered) + blending.two_sided(offset, velocity, times, window)[:, 0]
    assert np.abs(np.diff(joined)).max() < 4.0 / fps
    curve = np.diff(joined, n=2) * fps**2
    own = 0.5 * (4.0 + 0.7 * 2.4**2)
    assert (
        np.abs(curve).max() < own + 5.774 * 0.5 * abs(offset[0]) / 0.3**2 + 3.941 * 0.5 * abs(velocity[0]) / 0.3 + 0.1
    )
    # two sines have accelerations of their own: that is all that is left to leap
    assert np.abs(np.diff(curve)).max() < abs(-4.0 * 0.0 + 0.7 * 2.4**2 * np.sin(0.3)) + 1.0


@given(st.floats(0.0, 1.0), st.floats(0.0, 5.0), st.floats(0.5, 200.0))
def test_window_keeps_to_the_acceleration_allowed(offset: float, velocity: float, allowed: float) -> None:
    """Unless the longest window is too short, what is added never accelerates more than allowed."""
    window = blending.window(np.array([offset]), np.array([velocity]), np.array([allowed]))
    assert blending.SHORTEST <= window.before <= blending.LONGEST
    if window.before < blending.LONGEST:
        times = np.linspace(0.0, window.after, 400)
        added = blending.two_sided(np.array([offset, 0, 0]), np.array([velocity, 0, 0]), times, window)[:, 0]
        pushed = np.abs(np.diff(added, n=2)) / (times[1] - times[0]) ** 2
        assert pushed.max() <= 1.01 * allowed + 1e-6


def test_what_quintics_reach_at_most_is_exact() -> None:
    """Of unit offset and of unit velocity: as finely as they are sampled, nothing accelerates more or goes farther."""
    times, step = np.linspace(0.0, 1.0, 20_001, retstep=True)
    one, none = np.ones(1), np.zeros(1)
    for offset, velocity, peak in ((one, none, blending.PEAK), (none, one, blending.PEAK_OF_VELOCITY)):
        added = blending.decay(offset, velocity, times, 1.0)[:, 0]
        assert np.abs(np.diff(added, n=2)).max() / step**2 == pytest.approx(peak, rel=1e-5)
    assert blending.decay(none, one, times, 1.0).max() == pytest.approx(blending.FARTHEST, rel=1e-7)


def test_shorter_side_bears_less() -> None:
    """With a quarter of the time before the cut, that side bears a sixteenth as much as the other."""
    window = blending.window(np.array([1.0]), np.zeros(1), np.array([100.0]), before=0.04, after=0.16)
    assert window.share_before == pytest.approx(1.0 / 17.0)


def test_fingers_held_otherwise_take_their_time() -> None:
    """What hardly moves goes over more slowly than the body, within what it may be accelerated by."""
    window = blending.Window(0.2, 0.2, 0.5)
    offsets = np.radians([[20.0, 0.0, 0.0], [20.0, 0.0, 0.0], [170.0, 0.0, 0.0]])
    allowed = np.array([2.0, np.inf, 2.0])
    paced = blending.at_their_own_pace(offsets, np.zeros((3, 3)), window, np.ones(3, dtype=np.bool_), allowed)
    assert paced.pace[1] == 1.0
    assert paced.pace[2] == pytest.approx(blending.SLOWEST / 0.2)
    times = np.linspace(-1.0, 1.0, 2001)
    added = blending.Passing(offsets, paced, window).at(times)[:, 0, 0]
    pushed = np.abs(np.diff(added[times >= 0.0], n=2)) / (times[1] - times[0]) ** 2
    assert 1.9 < pushed.max() < 2.05


@given(arrays(np.float64, (3, 2, 3), elements=st.floats(-1.0, 1.0)), st.floats(0.02, 0.28))
def test_a_cut_before_the_last_is_over_makes_no_leap(vectors: np.ndarray, since: float) -> None:
    """Two cuts among three poses held still, the second while the first is not over: pose and velocity go on through it."""
    first, second, third = quaternion.from_rotvec(vectors)
    window, still = blending.Window(0.3, 0.3, 0.5), blending.Paced(np.zeros((3, 3)), np.ones(3))
    ground = np.array([[0.3, 0.0, 0.1]])
    passed = blending.Passing(np.concatenate([blending.rotation_offset(first, second), ground]), still, window)
    offset = np.concatenate([blending.rotation_offset(second, third), -2.0 * ground])
    offset, velocity = blending.absorbed(offset, np.zeros((3, 3)), passed, since)
    passing = blending.Passing(offset, blending.Paced(velocity, np.ones(3)), window)

    def performed(times: np.ndarray) -> np.ndarray:
        late = times >= 0.0
        earlier = passed.at(since + times)
        earlier[late] = 0.0
        pose = np.where(late[:, None, None], third, second)
        for added in (earlier, passing.at(times)):
            pose = blending.add_rotation(pose, added[:, :-1])
        return pose

    h = 1e-5
    turned = quaternion.angle(*(performed(np.array([-2 * h, -h, 0.0, h]))[k] for k in (slice(0, 3), slice(1, 4)))) / h
    assert turned.max() < 20.0  # it would be thousands over a leap
    assert np.ptp(turned, axis=0).max() < 0.1
    left = passed.at(np.array([since]))[0, -1, 0] + passing.at(np.array([-h]))[0, -1, 0]
    assert left == pytest.approx(-0.6 + passing.at(np.zeros(1))[0, -1, 0], abs=1e-3)


def test_one_sided_starts_at_the_offset() -> None:
    """Live, the first frame entered has the pose of what was left."""
    got = blending.one_sided(np.array([[0.3, 0.0, 0.1]]), np.zeros((1, 3)), np.array([0.0, 0.2, 0.5]), 0.4)
    assert np.allclose(got[0], [[0.3, 0.0, 0.1]])
    assert np.abs(got[1]).max() < 0.2
    assert np.allclose(got[2], 0.0)


@given(arrays(np.float64, (2, 3), elements=st.floats(-1.5, 1.5)))
def test_rotation_offset_is_undone_by_adding_it(vectors: np.ndarray) -> None:
    """left · exp(offset) is what is entered, whatever the signs of the quaternions."""
    left, entered = quaternion.from_rotvec(vectors)
    offset = blending.rotation_offset(left, -entered)
    assert quaternion.angle(blending.add_rotation(left, offset), entered) < 1e-7
