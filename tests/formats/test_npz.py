"""NumPy archives: a motion to the last bit, arrays beside it, and one clear error for everything else."""

from __future__ import annotations

import contextlib
import dataclasses
import io
import json
import tempfile
import zipfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import bodies
import kinesics as kx
import small_files
from kinesics import formats
from kinesics.body.motion import Source
from kinesics.body.skeleton import EndSite, JointFreedom
from kinesics.errors import FileError, InputError


def same(a: kx.Motion, b: kx.Motion) -> None:
    """Everything is equal, to the last bit."""
    np.testing.assert_array_equal(a.rotations, b.rotations)
    np.testing.assert_array_equal(a.root_positions, b.root_positions)
    np.testing.assert_array_equal(a.skeleton.offsets, b.skeleton.offsets)
    for name in ("joint_names", "parents", "end_sites", "freedoms", "name"):
        assert getattr(a.skeleton, name) == getattr(b.skeleton, name)
    for name in ("fps", "name", "assumptions", "warnings"):
        assert getattr(a, name) == getattr(b, name)
    assert (a.joint_translations is None) == (b.joint_translations is None)
    if a.joint_translations is not None and b.joint_translations is not None:
        np.testing.assert_array_equal(a.joint_translations[:, 1:], b.joint_translations[:, 1:])


@given(seed=st.integers(0, 2**32), shifting=st.booleans(), fps=st.floats(0.1, 1000.0))
def test_a_motion_comes_back_to_the_last_bit(seed: int, shifting: bool, fps: float) -> None:
    """Rotations, places, lengths, tips, freedoms with limits, names, remarks, where it came from."""
    rng = np.random.default_rng(seed)
    motion = bodies.legs_striding(4)
    skeleton = motion.skeleton.replace(
        end_sites=(EndSite(3, (0.1, float(rng.normal()), -0.2)), *motion.skeleton.end_sites),
        freedoms=tuple(JointFreedom("XYZ", "zx", "Y", limits=((-float(v), 0.3), (-1.0, 1.0))) for v in rng.random(17)),
    )
    shifts = np.tile(skeleton.offsets, (4, 1, 1)) + rng.normal(size=(4, 17, 3))
    motion = motion.replace(
        skeleton=skeleton,
        fps=fps,
        joint_translations=shifts if shifting else None,
        name="Ünter den Linden",
        source=Source("bvh", "a.bvh", "f00", 0.01, "z", {"order": "ZXY"}),
        warnings=("shaky",),
    )
    with tempfile.TemporaryDirectory() as folder:
        assert kx.write(motion, Path(folder) / "a.npz") == ()
        once = kx.read(Path(folder) / "a.npz")
        kx.write(once, Path(folder) / "b.npz")
        twice = kx.read(Path(folder) / "b.npz")
    assert once.source == motion.source
    np.testing.assert_array_equal(once.rotations, motion.rotations)
    assert once.assumptions[: len(motion.assumptions)] == motion.assumptions
    same(once, motion.replace(assumptions=once.assumptions))
    same(twice, once)


def test_a_file_read_and_kept_is_still_that_file(tmp_path, rng) -> None:
    """What a BVH said goes through .npz and back into an equal BVH."""
    (tmp_path / "a.bvh").write_text(small_files.bvh(rng))
    motion = kx.read(tmp_path / "a.bvh", unit="cm")
    kx.write(motion, tmp_path / "a.npz")
    again = kx.read(tmp_path / "a.npz")
    same(again, motion)
    assert again.source == motion.source
    kx.write(motion, tmp_path / "b.bvh")
    kx.write(again, tmp_path / "c.bvh")
    assert (tmp_path / "b.bvh").read_bytes() == (tmp_path / "c.bvh").read_bytes()


def test_the_anatomy_is_kept_for_slices(tmp_path) -> None:
    """A slice is read in the frames that were found on the whole recording, and not found anew."""
    motion = kx.performer.walk(seconds=3, fps=30).motion
    path = tmp_path / "a.npz"
    kx.write(motion, path)
    whole = kx.read(path)
    assert whole.skeleton.anatomy is not None
    frames = whole.skeleton.anatomy.frames.copy()
    frames[5] = [0.6, 0.0, 0.8, 0.0]
    body = dataclasses.replace(whole.skeleton.anatomy, frames=frames, clavicle="drop")
    kx.write(whole[3:5].replace(skeleton=whole.skeleton.replace(anatomy=body)), tmp_path / "b.npz")
    part = kx.read(tmp_path / "b.npz").skeleton.anatomy
    assert part is not None
    np.testing.assert_array_equal(part.frames, frames)
    assert (part.roles, part.clavicle) == (body.roles, "drop")


def test_a_motion_made_by_a_program_comes_from_the_archive(tmp_path) -> None:
    """Without a file before it, the archive is where it came from."""
    kx.write(bodies.legs_striding(2).replace(source=Source()), tmp_path / "a.npz")
    source = kx.read(tmp_path / "a.npz").source
    assert (source.format, source.file_name) == ("npz", "a.npz")
    assert len(source.sha256) == 64


def test_arrays_that_belong_to_a_motion_go_along(tmp_path, rng) -> None:
    """Numbers, truths and texts come back; other formats say that they have no room."""
    motion = bodies.legs_striding(3)
    extras = {
        "recording": np.array([0, 0, 1]),
        "weight": rng.random(3),
        "mirrored": np.array([True, False, True]),
        "names": np.array(["walk", "kata"]),
    }
    formats.write(motion, tmp_path / "a.npz", extras=extras)
    back = formats.read_extras(tmp_path / "a.npz")
    assert back.keys() == extras.keys()
    for name, values in extras.items():
        np.testing.assert_array_equal(back[name], values)
    same(kx.read(tmp_path / "a.npz"), kx.read(tmp_path / "a.npz").replace(name=motion.name))
    (remark,) = formats.write(motion, tmp_path / "a.bvh", extras=extras)
    assert "recording, weight, mirrored, names" in remark
    for bad in ({"a b": np.zeros(1)}, {"a": np.array([object()])}):
        with pytest.raises(InputError, match="extra"):
            formats.write(motion, tmp_path / "b.npz", extras=bad)
    assert not (tmp_path / "b.npz").exists()


def entries(path: Path) -> dict[str, np.ndarray]:
    """All arrays of an archive."""
    with np.load(path, allow_pickle=False) as archive:
        return {name: archive[name] for name in archive.files}


def header(arrays, **changes):
    """The header with some fields changed."""
    return np.array(json.dumps({**json.loads(str(arrays["kinesics_motion"])), **changes}))


DAMAGE = {
    "no rotations": lambda a: {k: v for k, v in a.items() if k != "rotations"},
    "rotations of another shape": lambda a: {**a, "rotations": a["rotations"][:, :3]},
    "not finite": lambda a: {**a, "root_positions": a["root_positions"] * np.nan},
    "texts": lambda a: {**a, "rotations": a["rotations"].astype(str)},
    "a parent that is none": lambda a: {**a, "parents": a["parents"] + 40},
    "a tip on no joint": lambda a: {**a, "tip_parents": a["tip_parents"] + 400},
    "tips too many": lambda a: {**a, "tip_parents": np.tile(a["tip_parents"], 2)},
    "no json": lambda a: {**a, "kinesics_motion": np.array("{")},
    "json of something else": lambda a: {**a, "kinesics_motion": np.array("[1]")},
    "names doubled": lambda a: {**a, "kinesics_motion": header(a, joint_names=["a"] * 17)},
    "no rate": lambda a: {**a, "kinesics_motion": header(a, fps=0)},
    "a rate beyond numbers": lambda a: {**a, "kinesics_motion": header(a, fps=10**400)},
    "a rate that is none": lambda a: {**a, "kinesics_motion": header(a, fps="fast")},
    "a later layout": lambda a: {**a, "kinesics_motion": header(a, version=99)},
    "roles beyond the joints": lambda a: {
        **a,
        "kinesics_motion": header(
            a,
            anatomy={
                **json.loads(str(a["kinesics_motion"]))["anatomy"],
                "roles": {**json.loads(str(a["kinesics_motion"]))["anatomy"]["roles"], "head": 99},
            },
        ),
    },
    "frames of nothing": lambda a: {**a, "anatomy_frames": a["anatomy_frames"][:2]},
}


@pytest.mark.parametrize("damage", DAMAGE.values(), ids=DAMAGE)
def test_damage_is_one_clear_error(tmp_path, damage) -> None:
    """A FileError that names the file, whatever is wrong inside."""
    path = tmp_path / "a.npz"
    from kinesics.body.anatomy import understood

    kx.write(understood(bodies.legs_striding(3)), path)
    arrays = entries(path)
    kx.read(path)
    np.savez_compressed(path, **damage(arrays))
    with pytest.raises(FileError, match=r"a\.npz"):
        kx.read(path)


def test_strangers_are_named(tmp_path) -> None:
    """Other archives of arrays, pickles, archives that are cut off and plain zips are refused in words."""
    np.savez(tmp_path / "other.npz", a=np.zeros(3))
    with pytest.raises(FileError, match=r"holds no motion.*kinesics_motion"):
        kx.read(tmp_path / "other.npz")
    pickled = io.BytesIO()
    np.savez(pickled, kinesics_motion=np.array([{}], dtype=object))
    (tmp_path / "pickle.npz").write_bytes(pickled.getvalue())
    with pytest.raises(FileError, match="damaged"):
        kx.read(tmp_path / "pickle.npz")
    with zipfile.ZipFile(tmp_path / "plain.zip", "w") as archive:
        archive.writestr("walk.bvh", "HIERARCHY")
    with pytest.raises(FileError, match="zip archive"):
        kx.read(tmp_path / "plain.zip")


def test_a_spoilt_entry_in_a_sound_archive_is_damage(tmp_path) -> None:
    """NumPy reads an entry's header by Python's tokenizer, whose error is none of NumPy's own."""
    header = b"{'descr': '<f8', 'fortran_order': False, 'shape': (1,\n"
    kx.write(bodies.legs_striding(2), tmp_path / "a.npz")
    with zipfile.ZipFile(tmp_path / "a.npz", "a") as archive:
        archive.writestr("extra_b.npy", b"\x93NUMPY\x01\x00" + len(header).to_bytes(2, "little") + header)
    with pytest.raises(FileError, match="damaged"):
        kx.read(tmp_path / "a.npz")


@given(st.data())
def test_cut_and_changed_bytes_are_an_error_or_the_motion(data: st.DataObject) -> None:
    """Anything but a FileError or a motion is a defect."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "a.npz"
        kx.write(bodies.legs_striding(2), path)
        path.write_bytes(data.draw(small_files.spoilt(path.read_bytes())))
        with contextlib.suppress(FileError):
            assert kx.read(path).frame_count == 2
