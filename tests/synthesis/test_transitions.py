"""Transitions: near moments, and what must agree across them."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from bodies import about, legs_striding, moving
from kinesics.body import kinematics
from kinesics.body.mirroring import mirror
from kinesics.body.motion import Motion
from kinesics.errors import InputError
from kinesics.geometry import quaternion
from kinesics.similarity import chord
from kinesics.similarity.metric import paired_distance
from kinesics.synthesis.joining.limits import WINDOW
from kinesics.synthesis.joining.seams import BAND
from kinesics.synthesis.joining.transitions import SPACING, Transitions, transitions
from kinesics.synthesis.repertoire import repertoire
from naive import transitions as naive


def wandering(seconds: float = 20.0, fps: float = 30.0, seed: int = 0, name: str = "wandering") -> Motion:
    """Joints that swing at a few rates of their own: much is nearly repeated, nothing quite, and no side like the other."""
    rng = np.random.default_rng(seed)
    t = np.arange(round(seconds * fps)) / fps
    angles = {}
    for joint in ("LeftArm", "RightArm", "LeftForeArm", "RightForeArm", "LeftUpLeg", "RightUpLeg", "LeftLeg", "Neck"):
        swings = [
            0.35 * np.sin(2.0 * np.pi * rate * t + phase)
            for rate, phase in zip((0.5, 0.73), rng.uniform(0.0, 2.0 * np.pi, 2), strict=True)
        ]
        angles[joint] = about(0, swings[0]) + about(2, 0.5 * swings[1])
    return moving(angles, fps=fps, file_name=name)


def marching(seconds: float = 20.0, fps: float = 30.0) -> Motion:
    """Arms and legs that swing as one, now wider and now less: it recurs mirrored and backwards, though never quite."""
    t = np.arange(round(seconds * fps)) / fps
    swing = (1.0 + 0.15 * np.sin(2.0 * np.pi * 0.13 * t)) * np.sin(2.0 * np.pi * 0.9 * t)
    angles = {}
    for side, sign in (("Left", 1.0), ("Right", -1.0)):
        angles[f"{side}UpLeg"] = about(0, 0.5 * sign * swing)
        angles[f"{side}Leg"] = about(0, 0.4 + 0.3 * sign * swing)
        angles[f"{side}Arm"] = about(0, -0.4 * sign * swing)
    return moving(angles, fps=fps, file_name="marching")


@pytest.fixture(scope="module")
def found() -> Transitions:
    """Of a movement that nearly repeats, mirrored and backwards too."""
    return transitions(repertoire(marching(), backwards=True))


def _pairs(found: Transitions) -> set[tuple[int, int]]:
    return set(zip(found.source.tolist(), found.target.tolist(), strict=True))


def test_distance_is_mean_of_D_over_the_window(found: Transitions) -> None:
    """The distance of each transition is the mean of D over the window, by the definition, and within the threshold."""
    rep = found.repertoire
    half = round(0.5 * WINDOW * rep.fps)
    for k in np.linspace(0, len(found) - 1, 60).astype(int):
        expected = naive.window_distance(
            rep.poses.quaternions, int(found.source[k]), int(found.target[k]), rep.frame_count, half
        )
        assert found.distance[k] == pytest.approx(expected, abs=1e-9)
    assert found.distance.max() <= found.threshold
    assert (found.cost >= 0.0).all()
    assert (found.cost <= 1.0).all()


def test_every_relation_is_found(found: Transitions) -> None:
    """From each strand ways lead into each strand."""
    ways = np.zeros((4, 4), dtype=int)
    np.add.at(ways, (found.repertoire.strand_of(found.source), found.repertoire.strand_of(found.target)), 1)
    assert (ways > 0).all()


def test_mirror_images_of_transitions_are_transitions(found: Transitions) -> None:
    """What leads from one strand to another leads from its mirror image to the other's."""
    frames = found.repertoire.frame_count
    frame, strand = found.repertoire.split(np.stack([found.source, found.target]))
    image = frame + (strand ^ 1) * frames
    assert set(zip(*image.tolist(), strict=True)) == _pairs(found)


def test_reversed_transitions_are_transitions(found: Transitions) -> None:
    """Played backwards every transition leads back: from the frame at which one arrived to the one from which one left."""
    frames = found.repertoire.frame_count
    frame, strand = found.repertoire.split(np.stack([found.target, found.source]))
    back = frame + (strand ^ 2) * frames
    assert set(zip(*back.tolist(), strict=True)) == _pairs(found)


def test_mirrored_recordings_have_the_mirrored_transitions() -> None:
    """Of a mirrored recording one finds the same transitions, for both hold the same strands."""
    motion = wandering(12.0)
    own, image = (transitions(repertoire(m)) for m in (motion, mirror(motion)))
    assert len(own) > 25
    assert _pairs(own) == _pairs(image)
    np.testing.assert_allclose(own.distance, image.distance, atol=1e-9)


def test_the_same_movement_in_two_recordings_is_joined_for_free() -> None:
    """From one copy to the other every transition between equal moments has distance and cost 0."""
    motion = wandering(6.0)
    found = transitions(repertoire([motion, motion.replace(name="again")], mirrored=False))
    frames = found.repertoire.frame_count // 2
    equal = np.abs(found.target - found.source - 1) == frames
    assert np.count_nonzero(equal) > 20
    np.testing.assert_allclose(found.distance[equal], 0.0, atol=1e-12)
    np.testing.assert_allclose(found.cost[equal], 0.0, atol=1e-12)


def test_seams_keep_their_distance_and_none_is_trivial(found: Transitions) -> None:
    """Moments at which one leaves or arrives lie apart, and none leads to where the recording nearly is anyway."""
    rep = found.repertoire
    strand = rep.strand_of(found.target)
    seams = np.unique(rep.frame_of(found.target) + (strand >= 2))
    assert np.diff(seams).min() >= SPACING * rep.fps
    onward = rep.advance(found.source, 1)
    alike = strand == rep.strand_of(found.source)
    assert np.abs(onward - found.target)[alike].min() >= BAND * rep.fps


def test_density_is_kept() -> None:
    """No more transitions leave a second than asked for, but the best; less than two asks for no fewer."""
    rep = repertoire(wandering(20.0), mirrored=False)
    few, many = transitions(rep, density=2.0), transitions(rep)
    assert 0 < len(few) <= 2.0 * 20.0
    assert len(few) < len(many) <= 30.0 * 20.0
    assert np.median(few.cost) <= np.median(many.cost)
    fewest = transitions(rep, density=0.1)
    assert _pairs(fewest) == _pairs(transitions(rep, density=1.9))
    assert len(fewest) >= 0.9 * len(few)


def test_full_rate_is_searched_on_a_grid_and_refined() -> None:
    """At 120 fps the nearest frame is found, though only every fourth is compared with every fourth."""
    fast = wandering(6.0, fps=120.0)
    shifted = fast.replace(rotations=fast.rotations[2:], root_positions=fast.root_positions[2:], name="shifted")
    found = transitions(repertoire([fast, shifted], mirrored=False))
    rep = found.repertoire
    across = (rep.recording_of(found.source) == 0) & (rep.recording_of(found.target) == 1)
    offset = rep.advance(found.source, 1)[across] - (found.target[across] - rep.starts[1])
    assert np.count_nonzero(offset == 2) > 5
    np.testing.assert_allclose(found.distance[across][offset == 2], 0.0, atol=1e-12)


def test_quiet_standing_has_few_seams(rng: np.random.Generator) -> None:
    """Where everything is near everything only about a seam a second is used."""
    t = np.arange(600) / 30.0
    lively = np.where(t < 5.0, np.sin(2.0 * np.pi * 0.8 * t), np.sin(2.0 * np.pi * 4.0))
    sway = np.cumsum(rng.normal(0.0, 0.002, (600, 3)), axis=0) * 0.2
    motion = moving({"LeftArm": about(0, lively) + sway, "RightArm": about(0, 0.5 * lively) + sway}, fps=30.0)
    found = transitions(repertoire(motion, mirrored=False))
    seams = np.unique(found.target) / 30.0
    assert np.count_nonzero(seams < 5.0) > 5
    assert 0 < np.count_nonzero(seams > 6.0) <= 16


def test_up_does_not_go_over_into_down() -> None:
    """An arm that swings passes each pose both ways; one goes over only into the same way, but for the turning points."""
    t = np.arange(600) / 30.0
    swing = 0.9 * np.sin(2.0 * np.pi * 0.7 * t)
    motion = moving({"LeftArm": about(2, swing), "LeftForeArm": about(2, 0.3 * swing)}, fps=30.0)
    found = transitions(repertoire(motion, mirrored=False))
    speed = np.gradient(swing)
    here, there = speed[found.source], speed[found.target]
    fast = np.minimum(np.abs(here), np.abs(there)) > 0.5 * speed.max()
    assert np.count_nonzero(fast) > 20
    assert (here[fast] * there[fast] > 0.0).all()


def test_lying_does_not_go_over_into_standing() -> None:
    """The same joint angles at another height are not the same."""
    stride = legs_striding(300, fps=30.0, period=1.1)
    lifted = stride.replace(root_positions=stride.root_positions + np.array([0.0, 1.0, 0.0]), name="on a table")
    rep = repertoire([stride, lifted], mirrored=False)
    # the ground of each recording was found by itself; put the second back on its table
    roots = rep.root_positions.copy()
    roots[:, rep.starts[1] :, 1] += 1.0
    found = transitions(dataclasses.replace(rep, root_positions=roots))
    assert len(found) > 20
    assert (rep.recording_of(found.source) == rep.recording_of(rep.frame_of(found.target))).all()
    assert found.refused["height of the pelvis"] > 0


def test_a_foot_that_stands_does_not_swing_across_a_transition() -> None:
    """If the feet of one recording never touch the ground when the other's do, nothing joins them."""
    stride = legs_striding(300, fps=30.0, period=1.1)
    rep = repertoire([stride, stride.replace(name="swimming")], mirrored=False)
    contacts = rep.contacts.copy()
    contacts[:, : rep.starts[1]] = True
    contacts[:, rep.starts[1] :] = False
    found = transitions(dataclasses.replace(rep, contacts=contacts))
    assert len(found) > 20
    assert (rep.recording_of(found.source) == rep.recording_of(found.target)).all()
    assert found.refused["feet on the ground"] > 0


def test_feet_are_not_moved_far_beneath_the_body() -> None:
    """Ankles as seen from the heading differ by no more than the limit across any transition, mirrored ones too."""
    rep = repertoire(wandering(12.0))
    found = transitions(rep)
    body = rep.skeleton.anatomy
    assert body is not None
    ankles = [body.roles.left_foot, body.roles.right_foot]
    onward = rep.advance(found.source, 1)
    for a, b in zip(onward[::7].tolist(), found.target[::7].tolist(), strict=True):
        # the seam lies between two frames
        places = []
        for moment in (a, b):
            pair = np.array([moment, int(rep.advance(moment, -1))])
            known = kinematics.positions(rep.skeleton, rep.rotations_of(pair), rep.roots_of(pair))[:, ankles]
            away = known - rep.roots_of(pair)[:, None]
            turn = quaternion.from_rotvec(np.array([0.0, -1.0, 0.0]) * rep.yaw_of(pair)[:, None])
            places.append(quaternion.rotate(turn[:, None], away).mean(axis=0))
        assert np.linalg.norm(places[0] - places[1], axis=-1).max() <= found.limits.place + 1e-9


def test_running_does_not_go_over_into_walking_on_the_spot() -> None:
    """The same joint angles at another speed over the ground are not the same."""
    stride = legs_striding(300, fps=30.0, period=1.1)
    ahead = np.zeros((300, 3))
    ahead[:, 2] = 3.0 * np.arange(300) / 30.0
    rep = repertoire([stride, stride.replace(root_positions=stride.root_positions + ahead)], mirrored=False)
    found = transitions(rep)
    assert len(found) > 20
    assert (rep.recording_of(found.source) == rep.recording_of(found.target)).all()


def test_alike_groups_are_joined_by_the_few_pairs_that_can() -> None:
    """Two movements that are nearer to their own copies than to each other are joined all the same."""
    calm = wandering(8.0, seed=3)
    groups = [calm.replace(name=f"calm {k}") for k in range(12)]
    groups += [_leaning(calm, 0.2).replace(name=f"leaning {k}") for k in range(12)]
    found = transitions(repertoire(groups, mirrored=False), density=4.0)
    rep = found.repertoire
    kinds = rep.recording_of(found.source) // 12, rep.recording_of(found.target) // 12
    assert np.count_nonzero(kinds[0] != kinds[1]) > 0


def _leaning(motion: Motion, angle: float) -> Motion:
    rotations = motion.rotations.copy()
    spine = motion.skeleton.find("Spine")
    rotations[:, spine] = quaternion.multiply(quaternion.from_rotvec([angle, 0.0, 0.0]), rotations[:, spine])
    return motion.replace(rotations=rotations)


def test_the_threshold_is_what_the_movement_covers_in_a_blend() -> None:
    """Found in the recordings: the median distance between moments a quarter of a second apart, or half of all pairs."""
    rep = repertoire(wandering(30.0), mirrored=False)
    q = rep.poses.quaternions
    covered = float(np.median(chord(paired_distance(q[8:], q[:-8]))))
    found = transitions(rep)
    assert chord(found.threshold) == pytest.approx(covered, rel=0.02)
    assert "0.25 s" in found.limits.rule


def test_threshold_given_is_kept() -> None:
    """A threshold of one's own replaces that of the recordings."""
    rep = repertoire(wandering(), mirrored=False)
    found = transitions(rep, threshold=0.0005)
    assert found.threshold == 0.0005
    assert len(found) > 0
    assert found.distance.max() <= 0.0005


def test_stillness_alone_asks_for_a_threshold() -> None:
    """Who never moves has no measure of nearness: that is said, and what to do."""
    motion = moving({"LeftArm": about(0, np.zeros(120))}, fps=30.0, file_name="statue.bvh")
    with pytest.raises(InputError, match=r"statue\.bvh.*holds one pose.*threshold"):
        transitions(repertoire(motion))
    assert len(transitions(repertoire(motion, mirrored=False), threshold=0.001)) > 0


@pytest.mark.parametrize("wrong", [{"threshold": 0.0}, {"density": -1.0}, {"spacing": float("nan")}])
def test_parameters_are_checked(wrong: dict[str, float]) -> None:
    """What is not a positive number is refused by its name."""
    with pytest.raises(InputError, match=next(iter(wrong))):
        transitions(repertoire(wandering(3.0)), **wrong)


def test_too_short_has_none() -> None:
    """Recordings shorter than a window have no transitions."""
    found = transitions(repertoire(wandering(0.5, fps=8.0), mirrored=False))
    assert len(found) == 0
    assert found.nearest.distance == np.inf
