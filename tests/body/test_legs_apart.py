"""Legs on a body with narrower hips."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import kinesics as kx
from kinesics.body import anatomy
from kinesics.body.legs_apart import legs_apart
from kinesics.body.motion import Motion
from kinesics.body.retargeting import leg_length, retarget
from kinesics.synthesis.repertoire import repertoire


def _with_hips(motion: Motion, times: float) -> Motion:
    """On the same body with hips wider or narrower."""
    motion = anatomy.understood(motion)
    skeleton = motion.skeleton
    assert skeleton.anatomy is not None
    offsets = skeleton.offsets.copy()
    for joint in (skeleton.anatomy.roles.left_femur, skeleton.anatomy.roles.right_femur):
        offsets[joint] *= [times, 1.0, 1.0]
    return motion.replace(skeleton=skeleton.replace(offsets=offsets))


def _apart(motion: Motion, part: str) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    """Metres between left and right, in every frame."""
    assert motion.skeleton.anatomy is not None
    roles, places = motion.skeleton.anatomy.roles, motion.positions()
    return np.linalg.norm(
        places[:, getattr(roles, f"left_{part}")] - places[:, getattr(roles, f"right_{part}")], axis=1
    )


@pytest.fixture(scope="module")
def walk() -> Motion:
    """Of a body with hips half as wide again."""
    return _with_hips(kx.performer.walk(seconds=3, fps=30).motion, 1.5)


def test_knees_and_feet_keep_their_distance(walk: Motion) -> None:
    """On hips two thirds as wide they are as far apart as before, to a centimetre; without, they are nearer by four."""
    narrow = retarget(walk, _with_hips(walk, 1.0 / 1.5).skeleton)
    made = legs_apart(narrow, walk)
    assert 2.0 < np.rad2deg(made.angle) < 12.0
    for part in ("tibia", "foot"):
        assert np.abs(_apart(made.motion, part) - _apart(walk, part)).max() < 0.01
        assert (_apart(walk, part) - _apart(narrow, part)).max() > 0.03


def test_shanks_and_feet_keep_their_directions(walk: Motion) -> None:
    """And everything but the thighs; the lowest point keeps its height to some millimetres."""
    narrow = retarget(walk, _with_hips(walk, 1.0 / 1.5).skeleton)
    made = legs_apart(narrow, walk).motion
    assert made.skeleton.anatomy is not None
    roles = made.skeleton.anatomy.roles
    before, after = narrow.global_rotations(), made.global_rotations()
    same = np.abs(np.sum(before * after, axis=-1)).min(axis=0)
    thighs = [roles.left_femur, roles.right_femur]
    assert np.delete(same, thighs).min() > 1.0 - 1e-9
    assert same[thighs].max() < 1.0 - 1e-4
    assert np.abs(made.positions()[..., 1].min(axis=1) - narrow.positions()[..., 1].min(axis=1)).max() < 0.004


def test_wider_hips_and_the_same_hips_are_left_as_they_are(walk: Motion) -> None:
    """To the last bit, in any size."""
    wider = retarget(walk, _with_hips(walk, 1.2).skeleton)
    assert legs_apart(wider, walk).motion is wider
    tall = walk.skeleton.replace(offsets=1.2 * walk.skeleton.offsets)
    larger = retarget(walk, tall)
    assert leg_length(tall, larger.skeleton.anatomy) > 1.1 * leg_length(walk.skeleton, walk.skeleton.anatomy)  # type: ignore[arg-type]
    assert legs_apart(larger, walk) == (larger, 0.0)


def test_who_performs_on_narrower_hips_says_so(walk: Motion) -> None:
    """And limbs that touched do not pass through each other."""
    made = repertoire([walk], skeleton=_with_hips(walk, 1.0 / 1.5))
    assert any("thighs turned outwards by" in said for said in made.assumptions)
    assert made.warnings == ()


@pytest.mark.parametrize(("moves", "on"), [("91_01", "86_01"), ("135_02", "86_01"), ("91_01", "35_01")])
def test_thighs_of_real_people_do_not_pass_through_each_other(shared_data: Path, moves: str, on: str) -> None:
    """Hips of unlike width, .19 to .27 of the legs: limbs are no deeper in each other than they were, by two centimetres."""
    first, second = (kx.read(shared_data / "cmu" / n.split("_")[0] / f"{n}.amc")[::8] for n in (moves, on))
    assert not any("thigh" in doubt or "shank" in doubt for doubt in repertoire([first], skeleton=second).warnings)
