"""The performer moves within what people do: compared link by link with recordings of the same action."""

from __future__ import annotations

import numpy as np
import pytest

import kinesics as kx
from kinesics import performer
from kinesics.body import quality
from kinesics.geometry import quaternion
from kinesics.performer.body import JOINT
from kinesics.performer.stage import GRAVITY
from kinesics.vocabulary import LINKS

RECORDED = {
    "walk": [("07", "07_01", None), ("35", "35_01", None), ("91", "91_01", (200, 900))],
    "run": [("09", "09_06", None), ("16", "16_35", None)],
    "jumping_jacks": [("13", "13_29", (0, 456)), ("13", "13_30", (0, 204)), ("14", "14_06", (0, 420))],
    "squat": [("13", "13_29", (3792, 4584)), ("13", "13_30", (1404, 1920)), ("14", "14_06", (1008, 1572))],
    "jog_in_place": [("13", "13_30", (1920, 2364)), ("14", "14_06", (420, 1008))],
    "twist": [("13", "13_29", (456, 1200)), ("14", "14_06", (3708, 4488))],
}
LIMBS = range(7, 15)


def ranges(q):
    """How far each link turns: twice the 95th percentile of its angle from its mean, degrees, shape (15,)."""
    return np.array(
        [2 * np.rad2deg(np.percentile(quaternion.angle(q[:, k], quaternion.mean(q[:, k])), 95)) for k in range(15)]
    )


@pytest.mark.parametrize("name", RECORDED)
def test_joint_ranges_are_those_of_people(name, shared_data):
    """No limb turns over half as far again as in any recording of the action (and 6° more), or under half as far."""
    recorded = []
    for folder, clip, frames in RECORDED[name]:
        q = kx.poses(kx.read(shared_data / "cmu" / folder / f"{clip}.amc")).quaternions
        recorded.append(ranges(q[slice(*frames)] if frames else q))
    ours = ranges(kx.poses(performer.perform(name, fps=60.0).motion).quaternions)
    low, high = np.min(recorded, axis=0), np.max(recorded, axis=0)
    for k in LIMBS:
        assert 0.5 * low[k] - 6 <= ours[k] <= 1.5 * high[k] + 6, (LINKS[k], low[k], ours[k], high[k])
    for k in range(7):
        assert ours[k] <= 1.5 * high[k] + 8, (LINKS[k], high[k], ours[k])


@pytest.mark.parametrize("name", performer.NAMES)
def test_hinges_bend_only_as_they_can(name):
    """Knees and elbows stay between 5° of hyperextension and 150° of flexion."""
    motion = performer.perform(name, fps=30.0).motion
    for joint, axis, sign in (("Leg", 0, 1.0), ("ForeArm", 1, -1.0)):
        for side, mirrored in (("Left", 1.0), ("Right", 1.0 if axis == 0 else -1.0)):
            q = motion.rotations[:, JOINT[side + joint]]
            bend = np.rad2deg(2 * np.arctan2(q[:, 1 + axis], q[:, 0])) * sign * mirrored
            bend = (bend + 180.0) % 360.0 - 180.0
            assert bend.min() > -5.0, (name, side, joint, bend.min())
            assert bend.max() < 150.0, (name, side, joint, bend.max())


@pytest.mark.parametrize("name", performer.NAMES)
def test_limbs_do_not_jerk(name):
    """Outside strikes no joint turns faster than 25 rad/s, as fast as people's limbs get."""
    performance = performer.perform(name, fps=240.0, **({"seconds": 5.0} if name == "walk" else {}))
    q = performance.motion.rotations
    speed = 240.0 * quaternion.angle(q[:-1], q[1:]).max(axis=1)
    for frame in performance.truth.strikes:
        speed[max(0, frame - 2) : frame + 2] = 0.0
    assert speed.max() < 25.0


def test_hands_keep_out_of_the_trunk():
    """Wrists never come within 8 cm of the spine."""
    for name in performer.NAMES:
        motion = performer.perform(name, fps=20.0).motion
        world = motion.positions()
        spine = [world[:, JOINT[a]] for a in ("Hips", "LowerBack", "Spine", "Spine1", "Neck")]
        for side in ("Left", "Right"):
            hand = world[:, JOINT[side + "Hand"]]
            near = min(np.linalg.norm(hand - s, axis=1).min() for s in spine)
            assert near > 0.08, (name, side, near)


@pytest.mark.parametrize("fps", [30.0, 60.0, 120.0])
@pytest.mark.parametrize("name", performer.NAMES)
def test_nothing_looks_wrong_but_that_holds_are_exact(name, fps):
    """As a recording, a performance has no leap, gap, tremor or wrong size; its holds alone are stiller than life."""
    found = quality.inspect(performer.perform(name, fps=fps).motion).findings
    assert {f.kind for f in found} <= {"frozen"}, [f.sentence for f in found]


@pytest.mark.parametrize("name", performer.NAMES)
def test_the_pelvis_moves_no_faster_than_in_people(name):
    """Below 5.5 m/s in a run, as joggers are, and 3 m/s in all else: a lunge or a walk is no faster."""
    motion = performer.perform(name, fps=120.0).motion
    speed = 120.0 * np.linalg.norm(np.diff(motion.root_positions, axis=0), axis=1)
    assert speed.max() < (5.5 if name == "run" else 3.0)


@pytest.mark.parametrize("name", ["kata", "side_kicks"])
def test_the_pelvis_is_not_jerked_over_the_floor(name):
    """In kicks, stamps and turns the ground pushes the pelvis sideways with no more than 3.5 times its weight."""
    floor = performer.perform(name, fps=120.0).motion.root_positions[:, [0, 2]]
    push = 120.0**2 * np.linalg.norm(np.diff(floor, 2, axis=0), axis=1)
    assert push.max() < 3.5 * GRAVITY


def test_a_living_body_is_never_exactly_still():
    """With a little smooth noise a kata has no frozen stretch, and it sways by no more than some millimetres."""
    exact = performer.kata(fps=60.0).motion
    alive = performer.kata(fps=60.0, noise_degrees=0.2, noise_kind="smooth").motion
    assert quality.inspect(alive).findings == ()
    sway = np.linalg.norm(alive.root_positions - exact.root_positions, axis=1)
    assert 0.001 < np.sqrt(np.mean(sway**2)) < 0.005
