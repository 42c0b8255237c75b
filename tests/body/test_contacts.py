"""Feet on the ground: performances whose truth is known, and real gaits whose figures are in every textbook."""

from __future__ import annotations

import zipfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kinesics as kx
from kinesics import compiled
from kinesics.body import contacts, touching
from kinesics.body.skeleton import EndSite, Skeleton
from kinesics.errors import SkeletonError
from kinesics.geometry import quaternion
from kinesics.performer.postures import joint_rotations
from naive import contacts as naive


def _truth(motion, body) -> np.ndarray:
    return naive.bearing(motion, body.foot_points, motion.skeleton, 0.004)


@pytest.mark.parametrize("fps", [30, 60, 120])
@pytest.mark.parametrize("name", ["walk", "run", "jumping_jacks", "kata", "squat", "stand"])
def test_bears_where_the_performer_does(name: str, fps: int) -> None:
    """In nine frames of ten and more a foot bears exactly where the performer put it on the ground."""
    body = kx.performer.Body(height=1.6)
    motion = kx.performer.perform(name, fps=fps, body=body).motion
    found = contacts.foot_contacts(motion)
    assert np.mean(found == _truth(motion, body)) >= (0.85 if name == "walk" else 0.9)


def test_walk_bears_three_fifths_and_never_flies() -> None:
    """A walk has one foot or both on the ground always; a run never both."""
    walk = contacts.foot_contacts(kx.performer.walk(seconds=8).motion[60:-60])
    run = contacts.foot_contacts(kx.performer.run(seconds=6).motion)
    assert 0.5 <= walk.mean() <= 0.7
    assert walk.any(axis=1).all()
    assert walk.all(axis=1).mean() > 0.08
    assert run.all(axis=1).mean() < 0.02
    assert (~run.any(axis=1)).mean() > 0.05


def test_floor_of_the_performer_is_near_zero() -> None:
    """The floor is found to 2 cm whatever the body, and a raised one is found as much higher."""
    for height in (1.2, 1.75, 2.0):
        motion = kx.performer.walk(seconds=4, body=height).motion
        level = contacts.floor_height(motion)
        assert abs(level) < 0.02
        up = motion.replace(root_positions=motion.root_positions + np.array([0.0, 0.7, 0.0]))
        assert contacts.floor_height(up) == pytest.approx(level + 0.7, abs=1e-9)


def test_tilted_floor_is_found_and_levelled() -> None:
    """A floor that rises by 2 cm a metre is found; `grounded` puts the feet back at one height."""
    motion = kx.performer.walk(seconds=8).motion
    roots = motion.root_positions.copy()
    roots[:, 1] += 0.02 * roots[:, 2]
    tilted = motion.replace(root_positions=roots)
    assert contacts.floor(tilted).slope_z == pytest.approx(0.02, abs=0.004)
    level = contacts.grounded(tilted)
    assert abs(contacts.floor(level).slope_z) < 0.004
    assert abs(contacts.floor_height(level)) < 0.003


def test_same_in_the_mirror_and_turned_about() -> None:
    """In the mirror left and right change places; turning and shifting the recording changes nothing."""
    motion = kx.performer.walk(seconds=4).motion
    found = contacts.foot_contacts(motion)
    image = contacts.foot_contacts(kx.mirror(motion))
    assert np.array_equal(image, found[:, ::-1])
    turn = quaternion.from_axis_angle([0.0, 1.0, 0.0], 1.1)
    rotations = motion.rotations.copy()
    rotations[:, 0] = quaternion.multiply(turn, rotations[:, 0])
    moved = motion.replace(rotations=rotations, root_positions=quaternion.rotate(turn, motion.root_positions + 2.0))
    assert np.mean(contacts.foot_contacts(moved) == found) > 0.995


def test_soles_lie_flat_when_standing() -> None:
    """Heel, ball and tip lie on the floor, in this order along the foot, while one stands."""
    motion = kx.performer.stand(seconds=2).motion
    found = contacts.contacts(motion)
    assert found.points.all()
    assert np.ptp(found.positions[..., 1]) < 0.005
    ahead = found.positions[0, :, :, 2]
    assert np.all(np.diff(ahead, axis=1) > 0.02)
    assert np.all(ahead[:, 2] - ahead[:, 0] < 0.3)


def test_soles_compiled_and_plain_are_at_one_place(monkeypatch: pytest.MonkeyPatch, rng: np.random.Generator) -> None:
    """The compiled module puts heel, ball and tip where turning their offsets puts them."""
    if compiled.native is None:
        pytest.skip("The compiled kernels were not built.")
    soles = contacts.Soles(np.array([[2, 2, 3], [5, 5, 6]]), rng.normal(size=(2, 3, 3)))
    positions, rotations = rng.normal(size=(9, 7, 3)), quaternion.normalize(rng.normal(size=(9, 7, 4)))
    monkeypatch.delenv("KINESICS_KERNEL", raising=False)
    monkeypatch.setenv("KINESICS_NO_NATIVE", "0")
    quick = soles.place(positions, rotations)
    monkeypatch.setenv("KINESICS_NO_NATIVE", "1")
    plain = soles.place(positions, rotations)
    assert quick.shape == plain.shape == (9, 2, 3, 3)
    np.testing.assert_allclose(quick, plain, atol=1e-13)


@given(st.lists(st.floats(-1.0, 1.0), min_size=1, max_size=30), st.floats(0.0, 1.0))
def test_quantiles_of_what_is_in_order_are_numpys(values: list[float], share: float) -> None:
    """Between two values they lie as far as NumPy's, and at the ends."""
    found = touching.sorted_quantile(np.sort(values), share)
    assert found == pytest.approx(np.quantile(values, share), abs=1e-12)


def test_a_foot_held_up_does_not_bear() -> None:
    """Standing on one leg, the other foot bears on nothing however still it is."""
    up = kx.performer.posture(kx.performer.STANDING, left_hip_flex=60, left_knee=80, left_plant=0)
    body = kx.performer.Body()
    rotations = joint_rotations(np.repeat(up[None], 90, axis=0))
    motion = kx.Motion(body.skeleton, rotations, np.tile([0.0, 0.93, 0.0], (90, 1)), 30.0)
    assert np.array_equal(contacts.foot_contacts(motion).mean(axis=0), [0.0, 1.0])


@given(st.lists(st.tuples(st.booleans(), st.booleans()), min_size=1, max_size=30))
def test_hysteresis_is_that_of_the_twin(frames: list[tuple[bool, bool]]) -> None:
    """Between the two thresholds a contact holds in both directions of time."""
    on = [a and b for a, b in frames]
    stay = [b for _, b in frames]
    got = touching.hysteresis(np.array(on)[:, None], np.array(stay)[:, None])[:, 0]
    assert got.tolist() == naive.hysteresis(on, stay)


def test_legs_without_ends_are_refused() -> None:
    """A skeleton whose legs end at the knee says so instead of guessing a foot."""
    body = kx.performer.Body().skeleton
    keep = [j for j, n in enumerate(body.joint_names) if not n.endswith(("Foot", "ToeBase"))]
    place = {j: k for k, j in enumerate(keep)}
    cut = Skeleton(
        tuple(body.joint_names[j] for j in keep),
        tuple(-1 if body.parents[j] < 0 else place[body.parents[j]] for j in keep),
        body.offsets[keep],
        tuple(EndSite(place[s.parent], s.offset) for s in body.end_sites if s.parent in place),
    )
    motion = kx.Motion(cut, quaternion.identity((5, len(keep))), np.zeros((5, 3)), 30.0)
    with pytest.raises(SkeletonError, match="no foot and no end site"):
        contacts.foot_contacts(motion)


@pytest.mark.parametrize("clip", ["91/91_01", "35/35_01", "07/07_01", "07/07_05", "02/02_01", "16/16_21"])
def test_real_walks_bear_three_fifths(shared_data: Path, clip: str) -> None:
    """Walks of five people, on floors that tilt: stance near 60 % of the time, double support, hardly any flight."""
    motion = kx.read(shared_data / "cmu" / f"{clip}.amc")
    found = contacts.foot_contacts(motion)
    assert 0.52 <= found.mean() <= 0.7
    assert 0.12 <= found.all(axis=1).mean() <= 0.4
    assert (~found.any(axis=1)).mean() <= 0.02


@pytest.mark.parametrize("clip", ["16/16_35", "09/09_06"])
def test_real_runs_fly(shared_data: Path, clip: str) -> None:
    """Runs have no double support, and fly a third of the time."""
    found = contacts.foot_contacts(kx.read(shared_data / "cmu" / f"{clip}.amc"))
    assert found.all(axis=1).mean() == 0.0
    assert 0.2 <= (~found.any(axis=1)).mean() <= 0.5


def test_thirty_frames_a_second(shared_data: Path, tmp_path: Path) -> None:
    """The same rule reads clips of 30 frames a second, of another naming."""
    with zipfile.ZipFile(shared_data / "bandai-namco" / "clips.zip") as archive:
        found = {}
        for kind in ("walk", "run"):
            name = next(n for n in sorted(archive.namelist()) if f"dataset-2_{kind}_normal" in n)
            path = tmp_path / f"{kind}.bvh"
            path.write_bytes(archive.read(name))
            found[kind] = contacts.foot_contacts(kx.read(path))
    assert 0.55 <= found["walk"].mean() <= 0.7
    assert found["walk"].any(axis=1).all()
    assert found["run"].all(axis=1).mean() == 0.0


@pytest.mark.parametrize("fps", [30.0, 120.0])
def test_speeds_are_as_true_at_either_end_as_between(fps: float) -> None:
    """A point thrown upwards: what is accelerated evenly has its own speed in the first and last frame, too."""
    seconds = np.arange(20) / fps
    points = np.zeros((20, 1, 3))
    points[:, 0, 1] = 3.0 * seconds - 0.5 * 9.81 * seconds**2
    points[:, 0, 2] = 0.7 * seconds
    speed = np.hypot(3.0 - 9.81 * seconds, 0.7)
    assert np.allclose(touching.speeds_of(points, fps)[:, 0], speed)


@pytest.mark.parametrize("fps", [24.0, 100.0, 240.0, 1000.0])
def test_speeds_are_told_of_any_number_of_frames(fps: float) -> None:
    """What moves evenly has its speed in each of them; there is no number of frames for which it cannot be told."""
    for frames in range(2, 60):
        points = np.zeros((frames, 1, 3))
        points[:, 0, 2] = 0.7 * np.arange(frames) / fps
        assert np.allclose(touching.speeds_of(points, fps), 0.7)


def test_speeds_of_a_moment_are_none() -> None:
    """One frame does not move; of two it is what lies between them."""
    point = np.zeros((2, 1, 3))
    point[1, 0, 0] = 0.01
    assert np.array_equal(touching.speeds_of(point[:1], 30.0), [[0.0]])
    assert np.allclose(touching.speeds_of(point, 30.0), 0.3)
