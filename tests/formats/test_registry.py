"""Which format a file has, where files go, and what stays whole when writing fails."""

from __future__ import annotations

import hashlib
import os
import sys
import types

import numpy as np
import pytest

import bodies
import kinesics as kx
import small_files
from kinesics import formats
from kinesics.errors import FileError, InputError
from kinesics.formats import registry
from kinesics.geometry import quaternion


@pytest.fixture
def walk():
    """A short motion."""
    return bodies.legs_striding(5)


def test_the_content_decides_and_not_the_suffix(tmp_path, rng) -> None:
    """A BVH called .amc is a BVH."""
    (tmp_path / "a.amc").write_text(small_files.bvh(rng))
    (tmp_path / "b.txt").write_text(small_files.amc(rng))
    (tmp_path / "b.asf").write_text(small_files.ASF)
    assert kx.read(tmp_path / "a.amc", unit="m").source.format == "bvh"
    assert kx.read(tmp_path / "b.txt", unit="m").source.format == "asf_amc"


def test_the_formats_are_known_by_name() -> None:
    """BVH and ASF/AMC are read and written."""
    assert {"bvh", "asf_amc"} <= {f.name for f in formats.readable()} & {f.name for f in formats.writable()}
    names = [f.name for f in formats.formats()]
    assert len(set(names)) == len(names)


def test_a_new_format_is_one_module(tmp_path, monkeypatch, walk) -> None:
    """A module of the folder that has a FORMAT is found, read and written; nothing else is edited."""

    def read(path, raw, options):
        frames = int(raw.split()[1])
        return registry.Recording(walk.skeleton, walk.rotations[:frames], walk.root_positions[:frames], 25.0)

    def write(motion, path):
        return registry.Written(((path, b"TOY %d" % motion.frame_count),), ("a toy holds only a number",))

    module = types.ModuleType("kinesics.formats.toy")
    module.FORMAT = registry.Format("toy", "Toy", (".toy",), lambda head: head.startswith(b"TOY"), read, write)
    monkeypatch.setitem(sys.modules, module.__name__, module)
    found = list(registry.pkgutil.iter_modules(formats.__path__))
    monkeypatch.setattr(registry.pkgutil, "iter_modules", lambda path: [*found, types.SimpleNamespace(name="toy")])
    registry.formats.cache_clear()
    try:
        assert kx.write(walk, tmp_path / "x.toy") == ("a toy holds only a number",)
        motion = kx.read(tmp_path / "x.toy", unit="m")
        assert (motion.frame_count, motion.fps, motion.source.format) == (5, 25.0, "toy")
    finally:
        registry.formats.cache_clear()


def test_where_a_motion_comes_from_is_kept(tmp_path, rng) -> None:
    """File name without folders, and the checksum of its bytes."""
    path = tmp_path / "a.bvh"
    path.write_text(small_files.bvh(rng))
    source = kx.read(path, unit="m").source
    assert source.file_name == "a.bvh"
    assert source.sha256 == hashlib.sha256(path.read_bytes()).hexdigest()


def test_nothing_is_overwritten_unless_asked(tmp_path, walk) -> None:
    """A file that is there stays as it is, the second of a pair as well as the first."""
    for name, other in (("a.bvh", "a.bvh"), ("b.amc", "b.asf"), ("c.amc", "c.amc")):
        (tmp_path / other).write_text("mine")
        with pytest.raises(InputError, match=r"\(--overwrite, overwrite=True\)"):
            kx.write(walk, tmp_path / name)
        assert (tmp_path / other).read_text() == "mine"
        kx.write(walk, tmp_path / name, overwrite=True)
        assert (tmp_path / other).read_text() != "mine"


@pytest.mark.parametrize("stop", [KeyboardInterrupt, OSError(28, "No space left on device")])
def test_a_write_that_is_stopped_leaves_nothing_behind(tmp_path, walk, monkeypatch, stop) -> None:
    """Ctrl-C or a full disk while the second file is written: the folder is as it was."""
    kx.write(walk, tmp_path / "a.amc")
    before = {p.name: p.read_bytes() for p in tmp_path.iterdir()}
    real = formats.Path.open
    opened = []

    def opening(self, *args, **kwargs):
        if self.suffix == ".part":
            opened.append(self)
            if len(opened) == 2:
                raise stop
        return real(self, *args, **kwargs)

    monkeypatch.setattr(formats.Path, "open", opening)
    with pytest.raises(KeyboardInterrupt if stop is KeyboardInterrupt else FileError):
        kx.write(walk[:2], tmp_path / "a.amc", overwrite=True)
    monkeypatch.undo()
    assert {p.name: p.read_bytes() for p in tmp_path.iterdir()} == before


def test_where_nothing_can_be_written_the_error_says_so(tmp_path, walk) -> None:
    """An unknown suffix, a folder that is not there, a folder in the way."""
    with pytest.raises(InputError, match=r"\.bvh"):
        kx.write(walk, tmp_path / "a.mp3")
    with pytest.raises(FileError, match="folder to write to"):
        kx.write(walk, tmp_path / "none" / "a.bvh")
    (tmp_path / "a.bvh").mkdir()
    with pytest.raises(FileError, match="cannot be written"):
        kx.write(walk, tmp_path / "a.bvh", overwrite=True)
    assert [p.name for p in tmp_path.iterdir()] == ["a.bvh"]


@pytest.mark.parametrize(
    "options",
    [{"unit": "parsec"}, {"unit": -1.0}, {"unit": float("nan")}, {"up": "w"}, {"fps": 0.0}, {"fps": float("inf")}],
)
def test_arguments_that_cannot_be_are_refused(tmp_path, rng, options) -> None:
    """Units, axes and rates that do not exist."""
    (tmp_path / "a.bvh").write_text(small_files.bvh(rng))
    with pytest.raises(InputError):
        kx.read(tmp_path / "a.bvh", **options)
    with pytest.raises(InputError, match="path of a file"):
        kx.read(7)


def test_a_mapping_is_taken_from_a_table_or_a_file(tmp_path, walk) -> None:
    """Joints whose names say nothing can be named by the user."""
    kx.write(walk, tmp_path / "a.bvh")
    (tmp_path / "map.toml").write_text('clavicle = "drop"\n[joints]\nleft_foot = "LeftFoot"\n')
    (tmp_path / "bad.toml").write_text("[joints\n")
    motion = kx.read(tmp_path / "a.bvh", mapping=tmp_path / "map.toml")
    assert motion.skeleton.anatomy is not None
    assert motion.skeleton.anatomy.clavicle == "drop"
    table = kx.read(tmp_path / "a.bvh", mapping={"clavicle": "drop", "left_foot": "LeftFoot"})
    assert table.skeleton.anatomy is not None
    np.testing.assert_array_equal(kx.poses(table).quaternions, kx.poses(motion).quaternions)
    with pytest.raises(FileError, match="not TOML"):
        kx.read(tmp_path / "a.bvh", mapping=tmp_path / "bad.toml")


def test_paths_may_be_text(tmp_path, rng) -> None:
    """A string does as well as a Path."""
    (tmp_path / "a.bvh").write_text(small_files.bvh(rng))
    assert kx.read(os.fspath(tmp_path / "a.bvh"), unit="m").name == "a"


@pytest.fixture(scope="module")
def whole_walk():
    """A whole body that walks."""
    return kx.performer.walk(seconds=3, fps=20).motion


@pytest.mark.parametrize("suffix", ["bvh", "amc"])
@pytest.mark.parametrize(("up", "does"), [("z", "lies"), ("-x", "lies"), ("-y", "hangs head down")])
def test_a_body_that_never_stands_is_doubted(tmp_path, whole_walk, suffix, up, does) -> None:
    """Under a wrong up axis it lies or hangs all the time; which axis it should be is said, for every format alike."""
    path = tmp_path / f"walk.{suffix}"
    kx.write(whole_walk, path)
    (doubt,) = kx.read(path, up=up).warnings
    assert doubt.startswith(f"With {up} up the body never stands: it {does}, its head over its feet along y.")
    assert '--up y (up="y")' in doubt
    for right in ("y", None):
        assert kx.read(path, up=right).warnings == ()
    # a stored motion is not doubted twice
    kx.write(kx.read(path, up=up), tmp_path / "stored.npz")
    assert kx.read(tmp_path / "stored.npz").warnings == (doubt,)


def test_who_lies_but_stands_at_some_time_is_not_doubted(tmp_path, whole_walk) -> None:
    """A body that rests on the floor and gets up; one that only rests is doubted, but no axis can be named for one that rolls."""
    half = np.sqrt(0.5)
    frames = whole_walk.frame_count
    lying = np.array([half, -half, 0.0, 0.0])
    turns = np.broadcast_to(lying, (frames, 4)).copy()
    turns[-frames // 4 :] = [1.0, 0.0, 0.0, 0.0]
    up_again = _rolled(whole_walk, turns)
    kx.write(up_again, tmp_path / "up.bvh")
    assert kx.read(tmp_path / "up.bvh", up="y").warnings == ()
    about = np.linspace(0.0, 2.0 * np.pi, frames, endpoint=False) / 2.0
    rolling = np.stack([np.cos(about), 0 * about, np.sin(about), 0 * about], axis=1)
    kx.write(_rolled(whole_walk, quaternion.multiply(rolling, turns[0])), tmp_path / "roll.bvh")
    (doubt,) = kx.read(tmp_path / "roll.bvh", up="y").warnings
    assert doubt == (
        "With y up the body never stands: it lies. If it should stand, give the axis that points up (--up, up=)."
    )


def test_who_may_prop_itself_up_is_doubted(tmp_path, whole_walk) -> None:
    """Held as in a press-up, the head is over the feet along z: which of two floors it is none can tell, so it is said how to mend
    it. Who walks under z up is not doubted: there is no floor along y."""
    frames = whole_walk.frame_count
    half = np.sqrt(0.5)
    flat = np.broadcast_to([half, half, 0.0, 0.0], (frames, 4))
    lying = _rolled(whole_walk, flat)
    still = lying.replace(
        rotations=np.broadcast_to(lying.rotations[0], lying.rotations.shape),
        root_positions=np.broadcast_to(lying.root_positions[0], (frames, 3)),
    )
    kx.write(still, tmp_path / "prone.bvh")
    found = kx.read(tmp_path / "prone.bvh")
    assert found.source.up_axis == "z"
    (doubt,) = found.warnings
    assert doubt.startswith("z is taken for up")
    assert "--up y" in doubt
    assert not [w for w in kx.read(tmp_path / "prone.bvh", up="z").warnings if "taken for up" in w]
    # the same world with z up, walking on along y
    roots = np.stack([0.0 * np.arange(frames), 0.05 * np.arange(frames), np.full(frames, 0.9)], axis=1)
    kx.write(lying.replace(root_positions=roots), tmp_path / "walks.bvh")
    walks = kx.read(tmp_path / "walks.bvh")
    assert walks.source.up_axis == "z"
    assert walks.warnings == ()


def _rolled(motion, turns):
    """The whole body turned about its pelvis, another turn a frame, shape (frames, 4)."""
    rotations = motion.rotations.copy()
    rotations[:, 0] = quaternion.multiply(turns, rotations[:, 0])
    return motion.replace(rotations=rotations)
