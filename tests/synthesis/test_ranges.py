"""Joints go no farther than in the recordings: neither the components of their rotation vectors nor the angles between bones."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import kinesics as kx
from kinesics.geometry import quaternion
from kinesics.synthesis.embodiment import blending
from kinesics.synthesis.embodiment.ranges import YIELD, Ranges, put_within_range
from kinesics.synthesis.embodiment.stage import Stage
from kinesics.synthesis.repertoire import repertoire
from naive import ranges as naive

Array = NDArray[np.float64]


@pytest.fixture(scope="module")
def stage() -> Stage:
    """Of a walk in a circle and its mirror image."""
    walk = kx.performer.walk(seconds=5, fps=60, noise_degrees=2.0, noise_kind="smooth", route="circle", seed=6).motion
    return Stage.of(repertoire(walk))


def corners(stage: Stage, joint: int) -> Array:
    """The corners of the box of a joint's components: as far as each goes, and all at once; shape (8, 3)."""
    ends = np.stack([stage.low[joint], stage.high[joint]])
    return np.array([[ends[i, 0], ends[j, 1], ends[k, 2]] for i in (0, 1) for j in (0, 1) for k in (0, 1)])


def most_bent(stage: Stage) -> tuple[int, Array]:
    """A joint of the legs, and the corner at which its bones are farthest beyond the angle that was recorded."""
    ranges = Ranges.of(stage)
    found = []
    for joint in (*stage.legs.femurs, *stage.legs.feet):
        over = np.abs(ranges.bends[joint].over(corners(stage, joint))).max(axis=1)
        found.append((float(over.max()), joint, corners(stage, joint)[over.argmax()]))
    over, joint, corner = max(found, key=lambda one: one[0])
    assert over > np.deg2rad(1.0)
    return joint, corner


def test_angles_are_measured_like_the_twin(stage: Stage) -> None:
    """Of every joint below the one that carries the body, between the bones that meet there, whatever its frame and its mean."""
    ranges = Ranges.of(stage)
    for joint in range(stage.repertoire.skeleton.joint_count):
        wanted = np.array(naive.limits(stage, joint)).reshape(-1, 2)
        assert np.abs(ranges.bends[joint].least - wanted[:, 0]).max(initial=0.0) < 1e-6
        assert np.abs(ranges.bends[joint].most - wanted[:, 1]).max(initial=0.0) < 1e-6
    assert sum(len(bends.own) for bends in ranges.bends) > 10


def test_what_was_recorded_is_within(stage: Stage) -> None:
    """Neither image is beyond at any moment, and nothing of it is put anywhere else."""
    own, ranges = stage.repertoire, Ranges.of(stage)
    for image in (0, 1):
        assert ranges.beyond(own.rotations[image]).max() < 1e-9
        put = own.rotations[image].copy()
        put_within_range(stage, put, np.arange(stage.carrier + 1, own.skeleton.joint_count))
        assert np.array_equal(put, own.rotations[image])


@pytest.mark.parametrize("plain", ["0", "1"])
def test_comes_back_like_the_twin(
    stage: Stage, rng: np.random.Generator, plain: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Compiled and in NumPy: components cut off, then the angle farthest beyond changed along its slope."""
    monkeypatch.setenv("KINESICS_NO_NATIVE", plain)
    ranges, bent = Ranges.of(stage), 0
    for joint in (*stage.legs.femurs, *stage.legs.feet):
        known = naive.limits(stage, joint)
        vectors = np.concatenate([1.2 * corners(stage, joint), rng.normal(0.0, 0.2, (12, 3))])
        found = ranges.within(joint, vectors)
        for vector, there in zip(vectors, found, strict=True):
            try:
                wanted = naive.within(stage, joint, vector, known)
            except NotImplementedError:
                continue
            assert np.abs(there - wanted).max() < 1e-6
            bent += bool(np.abs(there - np.clip(vector, stage.low[joint], stage.high[joint])).max() > 1e-3)
    assert bent > 10


@pytest.mark.parametrize("plain", ["0", "1"])
def test_all_come_back(stage: Stage, rng: np.random.Generator, plain: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """From anywhere, half a turn away too, and at once as one by one; whoever is within stays where he is."""
    monkeypatch.setenv("KINESICS_NO_NATIVE", plain)
    ranges = Ranges.of(stage)
    wild = quaternion.from_rotvec(rng.normal(0.0, 1.0, (60, len(stage.middle), 3)))
    vectors = blending.rotation_offset(stage.middle, wild)
    put = wild.copy()
    for joint in range(ranges.first, len(stage.middle)):
        held = ranges.within(joint, vectors[:, joint])
        again = ranges.within(joint, held)
        assert np.abs(again - held).max() < 1e-8
        put[:, joint] = blending.add_rotation(stage.middle[joint], held)
    assert ranges.beyond(wild).max() > 1.0
    assert ranges.beyond(put).max() < 1e-8
    for one, wanted in zip(wild[:10], put, strict=False):
        held = one.copy()
        ranges.hold(held)
        assert quaternion.angle(held, wanted).max() < 1e-7
        assert np.array_equal(held[: ranges.first], one[: ranges.first])


def test_comes_back_by_about_the_shortest_way(stage: Stage, rng: np.random.Generator) -> None:
    """Hardly farther than to the nearest of a thousand rotations within, wherever it comes from nearby."""
    ranges = Ranges.of(stage)
    joint, _ = most_bent(stage)
    low, high = stage.low[joint], stage.high[joint]
    within = rng.uniform(low, high, (4000, 3))
    within = within[np.abs(ranges.bends[joint].over(within)).max(axis=1) == 0.0]
    vectors = rng.uniform(low - 0.05, high + 0.05, (300, 3))
    far = np.linalg.norm(ranges.within(joint, vectors) - vectors, axis=1)
    nearest = np.linalg.norm(vectors[:, None] - within, axis=-1).min(axis=1)
    assert (far > 0.02).sum() > 50
    assert (far <= 1.1 * nearest + 1e-9).all()


def test_a_little_farther_out_comes_back_beside_it(stage: Stage, rng: np.random.Generator) -> None:
    """What is beyond by a little more is put by as little elsewhere: nothing leaps that goes on smoothly."""
    ranges = Ranges.of(stage)
    for joint in (*stage.legs.femurs, *stage.legs.feet):
        vectors = rng.uniform(stage.low[joint] - 0.1, stage.high[joint] + 0.1, (2000, 3))
        beside = vectors + rng.normal(0.0, 1e-5, vectors.shape)
        moved = np.linalg.norm(ranges.within(joint, beside) - ranges.within(joint, vectors), axis=1)
        assert (moved / np.linalg.norm(beside - vectors, axis=1)).max() < 5.0


def test_a_joint_bent_both_ways_at_once_is_put_back_in_time(stage: Stage) -> None:
    """Each component within its range, and yet its bones are bent farther than ever: that is counted, and comes back smoothly
    from moments before to moments after, when nothing is changed.
    """
    own, ranges = stage.repertoire, Ranges.of(stage)
    joint, corner = most_bent(stage)
    share = np.zeros(own.frame_count)
    share[100:160] = np.hanning(60)
    rotations = own.rotations[0].copy()
    at = blending.rotation_offset(stage.middle[joint], rotations[:, joint])
    bent = at + share[:, None] * (corner - at)
    rotations[:, joint] = blending.add_rotation(stage.middle[joint], bent)
    assert (bent >= stage.low[joint] - 1e-9).all()
    assert (bent <= stage.high[joint] + 1e-9).all()
    assert ranges.beyond(rotations)[:, joint].max() > np.deg2rad(1.0)
    put = rotations.copy()
    put_within_range(stage, put, np.array([joint]))
    assert ranges.beyond(put).max() < 1e-8
    reach = 2 * round(YIELD * own.fps) + 1
    assert np.array_equal(put[: 100 - reach], rotations[: 100 - reach])
    assert np.array_equal(put[160 + reach :], rotations[160 + reach :])
    leaps = [
        np.linalg.norm(np.diff(blending.rotation_offset(q[:-1, joint], q[1:, joint]), axis=0), axis=1)
        for q in (rotations, put)
    ]
    assert leaps[1].max() < 1.5 * leaps[0].max()


def test_a_hand_goes_from_one_side_to_the_other_without_a_leap(shared_data: Path) -> None:
    """Bent to all sides in the recording and its mirror image, it is straighter between two postures than ever recorded."""
    stage = Stage.of(repertoire([kx.read(shared_data / "cmu" / "91" / "91_01.amc").resample(30.0)]))
    ranges, own = Ranges.of(stage), stage.repertoire
    share = np.linspace(0.0, 1.0, 200)[:, None]
    for name in ("lhand", "rhand"):
        hand = own.skeleton.joint_index[name]
        assert (ranges.bends[hand].least == 0.0).all()
        vectors = blending.rotation_offset(stage.middle[hand], own.rotations[:, :, hand]).reshape(-1, 3)[::37]
        for one, other in zip(vectors, vectors[::-1], strict=True):
            between = one + share * (other - one)
            steps = np.linalg.norm(np.diff(ranges.within(hand, between), axis=0), axis=1)
            assert steps.max() <= 3.0 * np.linalg.norm(other - one) / 199 + 1e-9


def test_a_knee_that_was_never_straight_is_not_straightened(stage: Stage) -> None:
    """Bent to one side alone, it keeps at least the angle it had."""
    ranges = Ranges.of(stage)
    for knee in stage.legs.tibias:
        bends = ranges.bends[knee]
        known = naive.bones(stage, knee)
        assert len(known) == len(bends.own) == 1
        angles = [
            naive.bend(stage, knee, q, known[0]) for image in (0, 1) for q in stage.repertoire.rotations[image, :, knee]
        ]
        if min(angles) > np.deg2rad(1.0):
            assert bends.least[0] == pytest.approx(min(angles), abs=1e-6)


@pytest.mark.parametrize("seed", [0, 17])
def test_no_joint_of_a_real_walk_turns_quicker_than_it_was_recorded(seed: int, shared_data: Path) -> None:
    """From frame to frame, whatever is blended: hands of this walk are bent to either side."""
    piece = kx.performance([kx.read(shared_data / "cmu" / "91" / "91_01.amc")], seconds=30, seed=seed)
    own, made = piece.network.repertoire.rotations, piece.motion.rotations
    recorded = quaternion.angle(own[:, 1:], own[:, :-1]).max(axis=(0, 1))
    assert (quaternion.angle(made[1:], made[:-1]).max(axis=0) < 1.5 * recorded + np.deg2rad(5.0)).all()
    assert not piece.check.jerked


@pytest.mark.parametrize("clip", ["07/07_01", "16/16_35"])
def test_necks_bend_no_farther_than_recorded_where_their_bones_lean(shared_data: Path, clip: str) -> None:
    """The recording alone is asked, not its mirror image as it is performed: spine and neck are within a degree of it."""
    recorded = kx.read(shared_data / f"cmu/{clip}.amc").resample(30.0)
    made = kx.performance(recorded, seconds=20, seed=3)
    assert 0.2 < made.mirrored_share < 0.8
    for joint in ("upperback", "thorax", "lowerneck", "upperneck"):
        ours, theirs = (neck_bend(motion, joint) for motion in (made.motion, recorded))
        assert ours.max() < theirs.max() + 1.0
        assert ours.min() > theirs.min() - 1.0


def neck_bend(motion: kx.Motion, joint: str) -> Array:
    """Degrees between the bones that meet in a joint, in every frame."""
    skeleton, places = motion.skeleton, motion.positions()
    j = skeleton.find(joint)
    before, after = places[:, j] - places[:, skeleton.parents[j]], places[:, skeleton.children[j][0]] - places[:, j]
    size = np.linalg.norm(before, axis=1) * np.linalg.norm(after, axis=1)
    return np.degrees(np.arccos(np.clip(np.sum(before * after, axis=1) / size, -1.0, 1.0)))
