"""Performances stay where their recordings were, whatever is performed of them; and what does not is seen."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import kinesics as kx
from kinesics.body import kinematics
from kinesics.body.contacts import runs
from kinesics.geometry import quaternion
from kinesics.synthesis.embodiment import blending, checking, quality
from kinesics.synthesis.embodiment.arms import put_arms_clear
from kinesics.synthesis.embodiment.ranges import Ranges
from kinesics.synthesis.embodiment.rendering import Performance, render
from kinesics.synthesis.embodiment.stage import FLESH, Stage
from kinesics.synthesis.paths.network import Network, network
from kinesics.synthesis.repertoire import repertoire


def walked(seed: int, fps: float, route: str, noise: float) -> Network:
    """Of a performed walk and its mirror image."""
    walk = kx.performer.walk(
        seconds=8, fps=fps, noise_degrees=noise, noise_kind="smooth", route=route, seed=seed
    ).motion
    return network(repertoire(walk))


def drawn(made: Network, seed: int, count: int) -> list[int]:
    """Paths at random, with as many transitions as there are."""
    rng = np.random.default_rng(seed)
    paths = [int(rng.integers(len(made)))]
    while len(paths) < count:
        nexts = made.successors(paths[-1])
        jumps = nexts[made.first[nexts] != made.onward[paths[-1]]]
        paths.append(int(rng.choice(jumps if len(jumps) else nexts)))
    return paths


@pytest.fixture(scope="module")
def made() -> Network:
    """Of a walk in a circle."""
    return walked(3, 30.0, "circle", 0.5)


@pytest.fixture(scope="module")
def done(made: Network) -> Performance:
    """Half a minute, a transition wherever there is one."""
    return render(made, drawn(made, 1, 80))


@settings(max_examples=12, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(
    seed=st.integers(0, 2**16),
    fps=st.sampled_from([24.0, 30.0, 60.0]),
    route=st.sampled_from(["circle", "straight"]),
    noise=st.floats(0.2, 1.5),
)
def test_whatever_is_performed_stays_where_the_recordings_were(seed: int, fps: float, route: str, noise: float) -> None:
    """Of any walk, by any paths: joints in range to rounding, limbs, floor and D as they may be."""
    made = walked(seed % 50, fps, route, noise)
    found = checking.check(render(made, drawn(made, seed, 25)), made)
    assert found.beyond_range <= 1e-6
    assert found.deeper <= FLESH
    assert found.below_floor <= checking.SUNK
    assert found.distance <= made.threshold
    assert found.stays


def test_feet_stay_though_joints_are_at_the_end_of_their_range(made: Network, done: Performance) -> None:
    """Of 99 contacts in a hundred none slides more than a centimetre, with no joint beyond its range."""
    found = checking.check(done, made)
    assert found.contacts > 10
    assert found.slides <= 0.01 * found.contacts
    assert found.holds == (found.slides == 0)


def test_check_is_what_quality_measures(made: Network, done: Performance) -> None:
    """Slides, floor, range and depth are those of the longer measurement; D is nowhere less than to the nearest of all."""
    found, measured = checking.check(done, made), quality.measure(done, made.repertoire, threshold=made.threshold)
    assert found.slide == pytest.approx(measured.slide_worst.performance, abs=1e-9)
    assert found.contacts == measured.contacts
    assert found.below_floor == pytest.approx(measured.penetration.performance, abs=1e-9)
    assert found.beyond_range == pytest.approx(measured.joint_excess, abs=1e-9)
    assert found.deeper == pytest.approx(measured.collision, abs=1e-9)
    assert measured.distance.performance - 1e-9 <= found.distance <= found.accepted == made.threshold


def test_what_is_spoilt_is_seen(made: Network, done: Performance) -> None:
    """A body sunk, dragged, bent too far, an arm put through the trunk: each shows in its own figure, and nothing holds."""
    stage = Stage.of(made.repertoire)
    motion = done.motion

    def checked(**changed: np.ndarray) -> checking.Check:
        return checking.check(dataclasses.replace(done, motion=motion.replace(**changed)), made)

    assert checked(root_positions=motion.root_positions - [0.0, 0.03, 0.0]).below_floor > 0.02
    dragged = motion.root_positions + np.linspace(0.0, 3.0, len(motion))[:, None] * [1.0, 0.0, 0.0]
    assert checked(root_positions=dragged).slides > 0
    bent = motion.rotations.copy()
    knee = stage.legs.tibias[0]
    top = stage.high[knee] + np.deg2rad([30.0, 0.0, 0.0])
    bent[5, knee] = blending.add_rotation(stage.middle[knee], top)
    spoilt = checked(rotations=bent)
    # the angle between thigh and shank, too
    assert spoilt.beyond_range == pytest.approx(np.deg2rad(30.0), abs=1e-3)
    assert not spoilt.holds
    assert "30° beyond" in spoilt.sentence
    through = motion.rotations.copy()
    assert made.repertoire.skeleton.anatomy is not None
    shoulder = made.repertoire.skeleton.anatomy.roles.left_humerus
    through[:, shoulder] = quaternion.multiply(quaternion.from_axis_angle([0.0, 0.0, 1.0], -1.2), through[:, shoulder])
    assert checked(rotations=through).deeper > FLESH


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_arms_are_moved_out_of_the_body(
    made: Network, done: Performance, axis: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A bent arm, a little deeper in the body than ever, comes out of it by turning at the shoulder, and within its range."""
    stage, motion = Stage.of(made.repertoire), done.motion
    assert made.repertoire.skeleton.anatomy is not None
    roles = made.repertoire.skeleton.anatomy.roles
    shoulder, elbow = roles.left_humerus, roles.left_radius
    low, high = stage.low.copy(), stage.high.copy()
    low[[shoulder, elbow]] -= 1.5
    high[[shoulder, elbow]] += 1.5
    # a straight arm turned about its own length meets nothing
    bent = quaternion.multiply(motion.rotations[:90, elbow], quaternion.from_rotvec(np.array([0.0, 0.0, -1.2])))
    free, own = dataclasses.replace(stage, low=low, high=high), Ranges.of(stage)
    bends = list(own.bends)
    for joint in (shoulder, elbow):
        bends[joint] = bends[joint]._replace(least=bends[joint].least - np.pi, most=bends[joint].most + np.pi)
    freed = dataclasses.replace(own, low=low, high=high, bends=tuple(bends))
    monkeypatch.setattr(Ranges, "of", lambda _: freed)
    met = 0
    for angle in np.linspace(-1.4, 1.4, 57):
        rotations = motion.rotations[:90].copy()
        rotations[:, elbow] = bent
        turned = blending.rotation_offset(stage.middle[shoulder], rotations[:, shoulder]) + angle * np.eye(3)[axis]
        rotations[:, shoulder] = blending.add_rotation(
            stage.middle[shoulder], np.clip(turned, low[shoulder], high[shoulder])
        )
        roots = motion.root_positions[:90]
        deep = stage.capsules.depths(*kinematics.forward(motion.skeleton, rotations, roots)) - stage.deepest
        if not FLESH < deep.max() < 0.03:
            continue
        met += 1
        put_arms_clear(free, rotations, roots)
        left = stage.capsules.depths(*kinematics.forward(motion.skeleton, rotations, roots)) - stage.deepest
        assert left.max() <= FLESH
        assert (checking.beyond(motion[:90].replace(rotations=rotations), free) <= 1e-6).all()
    assert met


def test_nothing_is_carried_far_by_a_leap_of_its_velocity() -> None:
    """A loose joint that leaps by 40 rad/s goes .1 rad beyond at most, one that sets the length keeps its time."""
    window = blending.Window(0.4, 0.4, 0.5)
    velocities = np.array([[40.0, 0.0, 0.0], [0.5, 0.0, 0.0], [40.0, 0.0, 0.0]])
    loose = np.array([True, True, False])
    paced = blending.at_their_own_pace(np.zeros((3, 3)), velocities, window, loose, np.full(3, 100.0))
    added = blending.two_sided(np.zeros((3, 3)), paced.velocities, np.linspace(-0.5, 0.5, 1001), window, paced.pace)
    farthest = np.abs(added).max(axis=(0, 2))
    assert farthest[0] == pytest.approx(blending.CARRIED, rel=0.02)
    assert np.array_equal(paced.velocities[1:], velocities[1:])
    assert paced.pace[1:] == pytest.approx([1.0, 1.0])
    assert paced.pace[0] == pytest.approx(blending.SHORTEST / 0.4)
    assert farthest[2] > 1.0


def test_whatever_is_at_once_is_told_in_plain_values(made: Network, done: Performance) -> None:
    """The figures that the provenance holds are those of the check, and every contact is counted."""
    found = checking.check(done, made)
    told = found.to_dict()
    assert told["holds"] is found.holds
    assert told["slide_m"] == pytest.approx(found.slide, abs=1e-6)
    assert told["accepted"] == made.threshold
    assert found.contacts >= sum(len(runs(done.feet[:, k])) for k in (0, 1)) - 2


def test_an_ankle_thrown_off_its_way_is_seen(made: Network, done: Performance) -> None:
    """A shin turned by 45° for a frame: which foot, when, and how hard; once, though it comes back in the next."""
    assert checking.check(done, made).leaps == ()
    rotations = done.motion.rotations.copy()
    shin = Stage.of(made.repertoire).legs.tibias[1]
    turn = quaternion.from_rotvec(np.deg2rad([45.0, 0.0, 0.0]))
    rotations[200, shin] = quaternion.multiply(rotations[200, shin], turn)
    thrown = dataclasses.replace(done, motion=dataclasses.replace(done.motion, rotations=rotations))
    found = checking.check(thrown, made)
    assert [(leap.foot, leap.frame) for leap in found.leaps] == [("right", 200)]
    assert found.leaps[0].velocity > checking.LEAP
    assert not found.holds
    assert "once an ankle leaps for a frame" in found.sentence
    assert found.to_dict()["leaps"][0]["frame"] == 200


def test_a_joint_that_turns_in_a_frame_as_never_recorded_is_told() -> None:
    """A hand by 60°, once there and once back; the rest of it turns as it was recorded."""
    made = network(
        repertoire(kx.performer.walk(seconds=6, fps=60, noise_degrees=1.0, noise_kind="smooth", seed=3).motion)
    )
    done = render(made, [0, *made.successors(0)[:1].tolist()])
    assert checking.check(done, made).jerked == ()
    rotations = done.motion.rotations.copy()
    hand = done.motion.skeleton.joint_index["LeftHand"]
    turn = quaternion.from_rotvec(np.deg2rad([60.0, 0.0, 0.0]))
    rotations[7, hand] = quaternion.multiply(rotations[7, hand], turn)
    found = checking.check(dataclasses.replace(done, motion=done.motion.replace(rotations=rotations)), made)
    assert [(jerk.joint, jerk.frame) for jerk in found.jerked] == [("LeftHand", 7), ("LeftHand", 8)]
    assert found.jerked[0].turn == pytest.approx(np.deg2rad(60.0), abs=0.1)
    assert not found.holds
    assert "twice a joint turns in a frame as never recorded" in found.sentence
    assert found.to_dict()["jerked"][0]["joint"] == "LeftHand"
