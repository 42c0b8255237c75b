"""Whatever the skeleton and whatever its joints do: written and read again it is the same movement."""

from __future__ import annotations

import dataclasses
import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kinesics as kx
from kinesics.body.motion import Source
from kinesics.body.skeleton import EndSite, JointFreedom, Skeleton
from kinesics.geometry import quaternion

ORDERS = ("XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX")


@st.composite
def motions(draw: st.DrawFn) -> kx.Motion:
    """Trees of a few joints, free or hinged, shifting or not, with limits and tips, turned at random or by right angles."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    count = draw(st.integers(2, 7))
    parents = (-1, *(draw(st.integers(0, j - 1)) for j in range(1, count)))
    freedoms = []
    for j in range(count):
        order = draw(st.sampled_from(ORDERS))
        channels = "".join(a for a in order if j == 0 or draw(st.booleans())).lower()
        axis = quaternion.from_rotvec(rng.normal(size=3) * draw(st.sampled_from([0.0, 1.0])))
        limited = draw(st.booleans())
        freedoms.append(
            JointFreedom(
                order=order,
                channels=channels[:: draw(st.sampled_from([1, -1]))],
                translation="XYZ" if j == 0 else draw(st.sampled_from(["", "Y", "XYZ"])),
                axis=tuple(float(v) for v in axis),
                limits=tuple((-1.0, 2.0) for _ in channels) if limited else (),
            )
        )
    offsets = rng.normal(size=(count, 3)) * (rng.random((count, 1)) < 0.8)
    frames = draw(st.integers(1, 4))
    if draw(st.booleans()):
        rotations = quaternion.normalize(rng.normal(size=(frames, count, 4)))
    else:
        quarter = rng.integers(-2, 3, size=(frames, count, 3)) * (np.pi / 2)
        rotations = quaternion.multiply(
            quaternion.from_rotvec(quarter * [1, 0, 0]),
            quaternion.multiply(
                quaternion.from_rotvec(quarter * [0, 1, 0]), quaternion.from_rotvec(quarter * [0, 0, 1])
            ),
        )
    shifts = None
    if draw(st.booleans()):
        shifts = np.tile(offsets, (frames, 1, 1)) + rng.normal(size=(frames, count, 3)) * (
            rng.random((1, count, 1)) < 0.5
        )
    source = Source(
        format=draw(st.sampled_from(["", "bvh", "asf_amc"])),
        metres_per_unit=draw(st.sampled_from([1.0, 0.01, 0.001, 0.0254, 0.0254 / 0.45])),
        up_axis=draw(st.sampled_from(["y", "z", "-x"])),
    )
    return kx.Motion(
        skeleton=Skeleton(
            joint_names=("root", *(f"joint{j}" for j in range(1, count))),
            parents=parents,
            offsets=offsets,
            end_sites=tuple(EndSite(int(j), tuple(rng.normal(size=3).tolist())) for j in rng.integers(0, count, 3)),
            freedoms=tuple(freedoms),
        ),
        rotations=rotations,
        root_positions=rng.normal(size=(frames, 3)) * 3.0,
        fps=draw(st.sampled_from([24.0, 30.0, 59.94, 120.0, 1000.0 / 7.0])),
        joint_translations=shifts,
        source=source,
    )


@pytest.mark.parametrize("suffix", [".bvh", ".amc"])
@given(motion=motions())
def test_any_motion_comes_back(suffix: str, motion: kx.Motion) -> None:
    """World positions within 1e-6 m, rotations within 1e-6 rad, tips, frame rate: in the file's own unit and axes or not."""
    own = motion.source.format == {".bvh": "bvh", ".amc": "asf_amc"}[suffix]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"a{suffix}"
        kx.write(motion, path)
        unit = (motion.source.metres_per_unit if own else 0.01) if suffix == ".bvh" else None
        again = kx.read(path, unit=unit, up=motion.source.up_axis if own else "y")
    assert again.fps == pytest.approx(motion.fps, rel=1e-15)
    names = motion.skeleton.joint_names
    assert set(again.skeleton.joint_names) == set(names)
    index = [again.skeleton.find(n) for n in names]
    assert np.abs(again.positions()[:, index] - motion.positions()).max() < 1e-6
    assert quaternion.angle(again.global_rotations()[:, index], motion.global_rotations()).max() < 1e-6
    assert tips(again) == tips(motion)


@given(motion=motions())
def test_writing_what_was_read_changes_nothing_more(motion: kx.Motion) -> None:
    """From the second time on the channels and limits of a file are those it was read with."""
    motion = motion.replace(source=dataclasses.replace(motion.source, format="asf_amc", up_axis="y"))
    with tempfile.TemporaryDirectory() as folder:
        for suffix in (".bvh", ".amc"):
            first, second = Path(folder) / f"a{suffix}", Path(folder) / f"b{suffix}"
            unit = 0.01 if suffix == ".bvh" else None
            kx.write(motion, first)
            once = kx.read(first, unit=unit, up="y")
            kx.write(once, second)
            twice = kx.read(second, unit=unit, up="y")
            assert twice.skeleton.joint_names == once.skeleton.joint_names
            for a, b in zip(once.skeleton.freedoms, twice.skeleton.freedoms, strict=True):
                assert (a.channels, a.translation, len(a.limits)) == (b.channels, b.translation, len(b.limits))
                np.testing.assert_allclose(a.limits, b.limits, atol=1e-9)
            assert np.abs(once.positions() - twice.positions()).max() < 1e-6


def tips(motion: kx.Motion) -> set[tuple[str, float, float, float]]:
    """Which joints have tips, and where, to a micrometre."""
    names = motion.skeleton.joint_names
    return {(names[s.parent], *(round(v, 6) + 0.0 for v in s.offset)) for s in motion.skeleton.end_sites}


@pytest.mark.parametrize("suffix", [".bvh", ".amc"])
def test_a_body_that_lies_is_told_where_the_file_cannot_say_which_way_is_up(tmp_path: Path, suffix: str) -> None:
    """By word of the user it comes back as it was; of one that stands nothing is said."""
    whole = kx.performer.sun_salutation(fps=30).motion
    plank = whole[1664:1694]
    path = tmp_path / f"plank{suffix}"
    told = kx.write(plank, path)[-1]
    assert "as if z were" in told
    assert "--up y" in told
    assert kx.read(path).source.up_axis == "z"
    again = kx.read(path, up="y")
    np.testing.assert_allclose(again.positions()[..., 1].max(axis=1), plank.positions()[..., 1].max(axis=1), atol=1e-6)
    assert not any("up" in remark for remark in kx.write(whole, tmp_path / f"whole{suffix}"))
    assert kx.write(plank, tmp_path / "plank.npz") == ()
