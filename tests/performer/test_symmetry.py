"""Before noise, every movement has exactly the symmetries of its class and lacks the others."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

import kinesics as kx
from kinesics import performer
from kinesics.vocabulary import MovementClass
from naive import symmetry as naive

C = MovementClass
EXACT = 1e-9
LACKING = 0.04

# name: class, then whether it has M at once, M after half a period, T, MT
CYCLIC = {
    "walk": (C.CYCLIC_ANTIPHASE, False, True, False, False),
    "run": (C.CYCLIC_ANTIPHASE, False, True, False, False),
    "limp": (C.CYCLIC_ASYMMETRIC, False, False, False, False),
    "jog_in_place": (C.CYCLIC_ANTIPHASE_PALINDROMIC, False, True, True, True),
    "twist": (C.CYCLIC_ANTIPHASE_PALINDROMIC, False, True, True, True),
    "jumping_jacks": (C.CYCLIC_SYMMETRIC_PALINDROMIC, True, False, True, True),
    "squat": (C.CYCLIC_SYMMETRIC_PALINDROMIC, True, False, True, True),
    "wave_both": (C.CYCLIC_SYMMETRIC_PALINDROMIC, True, False, True, True),
    "wave": (C.CYCLIC_PALINDROMIC, False, False, True, False),
    "butterfly": (C.CYCLIC_SYMMETRIC, True, False, False, False),
    "arm_circles": (C.CYCLIC_ANTIPALINDROMIC, False, False, False, True),
}
SINGLE = {
    "throw": (C.ASYMMETRIC, False, False, False),
    "raise_arms": (C.SYMMETRIC, True, False, False),
    "reach": (C.PALINDROMIC, False, True, False),
    "sway": (C.ANTIPALINDROMIC, False, False, True),
    "bow": (C.SYMMETRIC_PALINDROMIC, True, True, True),
}
FRAMES_A_CYCLE = 24


def cycle_of(name):
    """Two and a half cycles of 24 frames, as the library reads them."""
    performance = performer.perform(name, seconds=5.0, period=2.0, fps=FRAMES_A_CYCLE / 2.0)
    assert performance.motion.frame_count == 60
    return kx.poses(performance.motion).quaternions


def holds(residual, wanted):
    """Whether a residual is exactly 0 or clearly not."""
    return residual < EXACT if wanted else residual > LACKING


@pytest.mark.parametrize("name", CYCLIC)
def test_cyclic_movements_have_exactly_their_symmetries(name):
    """Residuals of the period and of M, glide, T and MT, about every possible centre, are 0 or far from 0 as claimed."""
    class_, at_once, glide, reverse, mirror_reverse = CYCLIC[name]
    assert performer.perform(name, fps=20.0).truth.class_ is class_
    q = cycle_of(name)
    assert naive.parallel(q, FRAMES_A_CYCLE, mirror=False) < EXACT
    assert naive.parallel(q, FRAMES_A_CYCLE // 2, mirror=False) > 0.5
    assert holds(naive.parallel(q, 0, mirror=True), at_once)
    glides = [naive.parallel(q, lag, mirror=True) for lag in range(10, 15)]
    assert holds(min(glides), glide)
    centres = range(48, 72, 2)
    assert holds(min(naive.perpendicular(q, c, mirror=False) for c in centres), reverse)
    assert holds(min(naive.perpendicular(q, c, mirror=True) for c in centres), mirror_reverse)


@pytest.mark.parametrize("name", SINGLE)
def test_single_movements_have_exactly_their_symmetries(name):
    """M at once, T and MT about the middle are 0 or far from 0 as the class claims."""
    class_, at_once, reverse, mirror_reverse = SINGLE[name]
    performance = performer.perform(name, seconds=2.0, period=2.0, fps=40.5)
    assert performance.truth.class_ is class_
    q = kx.poses(performance.motion).quaternions
    # the first frame is at 0 s; the mirror image of frame i about the middle of [0, 2] s is at 81 − i
    assert holds(naive.parallel(q, 0, mirror=True), at_once)
    assert holds(naive.perpendicular(q[1:], len(q) - 2, mirror=False), reverse)
    assert holds(naive.perpendicular(q[1:], len(q) - 2, mirror=True), mirror_reverse)


def test_a_limp_breaks_the_glide_by_degrees():
    """The residual of the half-period glide grows with the degree of the limp, from exactly none."""
    residuals = []
    for degree in (0.0, 0.1, 0.3, 0.6, 1.0):
        motion = performer.walk(seconds=5.0, period=2.0, fps=20.0, limp=degree).motion
        residuals.append(naive.parallel(kx.poses(motion).quaternions, 20, mirror=True))
    assert residuals[0] < EXACT
    assert all(b > 1.3 * a + 1e-4 for a, b in pairwise(residuals))


def test_standing_still_is_still():
    """Nothing moves and the pose is symmetric."""
    q = kx.poses(performer.stand(seconds=1.0).motion).quaternions
    np.testing.assert_array_equal(q, np.tile(q[:1], (len(q), 1, 1)))
    assert naive.distance(q[0], naive.mirrored(q[0])) < EXACT


def test_all_thirteen_classes_are_performed():
    """Between them the movements and their phrases show every class there is."""
    seen = set()
    for name in performer.NAMES:
        truth = performer.perform(name, fps=20.0).truth
        seen |= {truth.class_, *(p.class_ for p in truth.phrases)}
    assert seen == set(MovementClass)


def test_mirror_symmetry_survives_an_uneven_tempo():
    """With jitter a symmetric movement stays exactly symmetric, and the truth says that the clock wavers."""
    performance = performer.jumping_jacks(tempo_jitter=0.15, seed=3, fps=20.0)
    assert naive.parallel(kx.poses(performance.motion).quaternions, 0, mirror=True) < EXACT
    assert not performance.truth.phrases[0].tempo_exact
    lengths = np.diff(performance.truth.cycles)
    assert lengths.max() > lengths.min()


def test_states_claimed_symmetric_are():
    """A state is its own mirror image exactly where the truth says so, and mirror states are images of each other."""
    for name in performer.NAMES:
        truth = performer.perform(name, fps=10.0).truth
        for state in truth.states:
            own = naive.distance(state.pose, naive.mirrored(state.pose))
            assert (own < EXACT) == state.symmetric, (name, state.label)
            if state.mirror_of is not None:
                image = truth.state(state.mirror_of)
                assert naive.distance(state.pose, naive.mirrored(image.pose)) < EXACT, (name, state.label)
