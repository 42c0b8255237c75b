"""glTF: valid by Khronos's own validator, and the same movement when it is read again."""

from __future__ import annotations

import base64
import contextlib
import json
import shutil
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pygltflib
import pytest
from hypothesis import given
from hypothesis import strategies as st

import bodies
import kinesics as kx
import small_files
from kinesics.body.skeleton import EndSite, Skeleton
from kinesics.errors import FileError, InputError
from kinesics.geometry import quaternion
from naive import skinning

PROJECT = Path(__file__).resolve().parents[2]


def walk() -> kx.Motion:
    """Three seconds of the performer."""
    return kx.performer.walk(seconds=3, fps=30).motion


def hand() -> kx.Motion:
    """Four bones that are no body, and a shift of one of them."""
    rng = np.random.default_rng(3)
    skeleton = Skeleton(
        joint_names=("palm", "first", "second", "third"),
        parents=(-1, 0, 1, 0),
        offsets=rng.normal(size=(4, 3)) * 0.05,
        end_sites=(EndSite(2, (0.0, 0.02, 0.01)),),
    )
    shifts = np.tile(skeleton.offsets, (5, 1, 1))
    shifts[:, 3, 1] += np.linspace(0.0, 0.03, 5)
    rotations = quaternion.normalize(rng.normal(size=(5, 4, 4)))
    return kx.Motion(skeleton, rotations, rng.normal(size=(5, 3)), 25.0, joint_translations=shifts)


def same_movement(a: kx.Motion, b: kx.Motion) -> None:
    """Joints, tips, times, places and turns, within 1e-6."""
    assert a.fps == pytest.approx(b.fps, rel=1e-12)
    assert a.frame_count == b.frame_count
    assert a.skeleton.joint_names == b.skeleton.joint_names
    assert a.skeleton.parents == b.skeleton.parents
    assert np.abs(a.skeleton.offsets[1:] - b.skeleton.offsets[1:]).max(initial=0.0) < 1e-6
    assert np.abs(a.positions() - b.positions()).max() < 1e-6
    assert quaternion.angle(a.rotations, b.rotations).max() < 1e-6
    assert [s.parent for s in a.skeleton.end_sites] == sorted(s.parent for s in b.skeleton.end_sites)


# ---------------------------------------------------------------------------------------------------------- validator

VALIDATE = """
const validator = require(process.argv[1]);
const fs = require('fs');
const files = process.argv.slice(2);
Promise.all(files.map(f => validator.validateBytes(new Uint8Array(fs.readFileSync(f)), { maxIssues: 20 })))
  .then(reports => console.log(JSON.stringify(reports.map(r => r.issues))));
"""


@pytest.fixture(scope="session")
def validate():
    """A function from files to what Khronos's validator finds wrong with them."""
    package = PROJECT / ".venv" / "validator" / "node_modules" / "gltf-validator"
    node = shutil.which("node") or shutil.which("node", path=str(Path(sys.executable).parent))
    if node is None or not package.is_dir():
        pytest.skip("Needs Node.js and Khronos's glTF validator: `make validator` installs them.")

    def run(*files: Path) -> list[dict]:
        done = subprocess.run(
            [node, "-e", VALIDATE, str(package), *map(str, files)],
            capture_output=True,
            text=True,
            check=True,
            timeout=120,
        )
        return json.loads(done.stdout)

    return run


def assert_valid(reports: list[dict]) -> None:
    """Not an error, not a warning, not a hint; a bare bone's last node is empty, which is worth a notice and no more."""
    for report in reports:
        assert report["numErrors"] == report["numWarnings"] == report["numHints"] == 0, report["messages"]
        assert {m["code"] for m in report["messages"]} <= {"NODE_EMPTY"}, report["messages"]


def test_what_is_written_is_valid(tmp_path, validate) -> None:
    """A body, a body in JSON, one frame, bare bones that shift, and what was read again."""
    kx.write(walk(), tmp_path / "walk.glb")
    kx.write(walk()[:20], tmp_path / "walk.gltf")
    kx.write(walk()[0], tmp_path / "pose.glb")
    kx.write(hand(), tmp_path / "hand.glb")
    kx.write(kx.mirror(kx.read(tmp_path / "walk.glb")), tmp_path / "again.glb")
    assert_valid(validate(*sorted(tmp_path.iterdir())))


def test_real_recordings_are_valid(tmp_path, validate, shared_data) -> None:
    """A CMU walk and two Bandai-Namco clips: no error, no warning, and back within 1e-6."""
    recordings = [kx.read(shared_data / "cmu" / "07" / "07_01.amc")]
    (archive,) = sorted((shared_data / "bandai-namco").rglob("*.zip"))[:1]
    with zipfile.ZipFile(archive) as packed:
        clips = sorted(n for n in packed.namelist() if n.endswith(".bvh"))
        for name in clips[:: max(1, len(clips) // 2)][:2]:
            (tmp_path / "clip.bvh").write_bytes(packed.read(name))
            recordings.append(kx.read(tmp_path / "clip.bvh"))
    files = []
    for k, motion in enumerate(recordings):
        assert motion.skeleton.anatomy is not None
        files.append(tmp_path / f"{k}.glb")
        kx.write(motion, files[-1])
        again = kx.read(files[-1])
        index = [again.skeleton.find(n) for n in motion.skeleton.joint_names]
        assert np.abs(again.positions()[:, index] - motion.positions()).max() < 1e-6
        cosine = np.abs(np.einsum("fjk,fjk->fj", kx.poses(again).quaternions, kx.poses(motion).quaternions))
        assert 2.0 * np.arccos(np.clip(cosine, 0.0, 1.0)).max() < 2e-3
    assert_valid(validate(*files))


# --------------------------------------------------------------------------------------------------------- round trip


@pytest.mark.parametrize("suffix", [".glb", ".gltf"])
@given(seed=st.integers(0, 2**32))
def test_any_tree_comes_back(suffix: str, seed: int) -> None:
    """Trees of any kind, turned at random, shifting or not."""
    rng = np.random.default_rng(seed)
    count, frames = int(rng.integers(1, 7)), int(rng.integers(1, 6))
    parents = (-1, *(int(rng.integers(0, j)) for j in range(1, count)))
    skeleton = Skeleton(
        joint_names=tuple(f"joint {j}" for j in range(count)),
        parents=parents,
        offsets=rng.normal(size=(count, 3)) * (np.arange(count) > 0)[:, None],
        end_sites=tuple(EndSite(j, tuple(rng.normal(size=3).tolist())) for j in range(count) if rng.random() < 0.4),
    )
    shifts = np.tile(skeleton.offsets, (frames, 1, 1)) + rng.normal(size=(frames, count, 3))
    motion = kx.Motion(
        skeleton,
        quaternion.normalize(rng.normal(size=(frames, count, 4))),
        rng.normal(size=(frames, 3)) * 2.0,
        float(rng.choice([24.0, 59.94, 120.0, 1000.0 / 7.0])),
        joint_translations=shifts if rng.random() < 0.5 else None,
    )
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"a{suffix}"
        remarks = kx.write(motion, path)
        again = kx.read(path)
    assert "without a figure" in remarks[0]
    same_movement(again, motion)
    tips = {(s.parent, *np.round(s.offset, 5)) for s in motion.skeleton.end_sites}
    assert {(s.parent, *np.round(s.offset, 5)) for s in again.skeleton.end_sites} == tips
    assert again.source.format == "gltf"


@pytest.mark.parametrize("motion", [walk(), bodies.legs_striding(40), hand()], ids=["performer", "small", "hand"])
def test_bodies_come_back(tmp_path, motion) -> None:
    """The mesh is passed over, the movement is the same, poses and all."""
    kx.write(motion, tmp_path / "a.glb")
    again = kx.read(tmp_path / "a.glb")
    same_movement(again, motion)
    if motion.skeleton.joint_count > 4:
        dots = np.abs(np.einsum("fjk,fjk->fj", kx.poses(again).quaternions, kx.poses(motion).quaternions))
        assert dots.min() > 1.0 - 1e-6


def test_an_hour_does_not_slip(tmp_path) -> None:
    """Times are of single precision; frames late in a long file are still the frames themselves."""
    one = bodies.legs_striding(2)
    frames = 200_000
    turns = quaternion.identity((frames, one.skeleton.joint_count))
    turns[:, 3] = quaternion.from_axis_angle([1.0, 0.0, 0.0], np.arange(frames) * 0.7)
    motion = kx.Motion(one.skeleton, turns, np.zeros((frames, 3)), 60.0)
    kx.write(motion, tmp_path / "a.glb")
    again = kx.read(tmp_path / "a.glb")
    assert again.frame_count == frames
    assert quaternion.angle(again.rotations[:, 3], motion.rotations[:, 3]).max() < 1e-6


# ------------------------------------------------------------------------------------------------------------- figure


def loaded(path: Path):
    """The document and a function from the number of an accessor to its numbers."""
    document = pygltflib.GLTF2.load_from_bytes(path.read_bytes())
    blob = document.binary_blob()
    types = {5121: np.uint8, 5122: np.int16, 5123: np.uint16, 5126: np.float32}
    widths = {"SCALAR": 1, "VEC3": 3, "VEC4": 4, "MAT4": 16}

    def numbers(index: int):
        a = document.accessors[index]
        view = document.bufferViews[a.bufferView]
        data = np.frombuffer(blob, types[a.componentType], a.count * widths[a.type], view.byteOffset)
        data = data.reshape(a.count, -1)
        return data / np.float32(32767) if a.normalized else data

    return document, numbers


def test_the_file_holds_the_figure_as_a_viewer_sees_it(tmp_path, rng) -> None:
    """Skinned by the definition, from the file's own nodes, keys and matrices: where `Figure.posed` has it, in 5e-5 m."""
    from kinesics.body import anatomy, contacts, figure

    motion = anatomy.understood(walk())
    kx.write(motion, tmp_path / "a.glb")
    document, numbers = loaded(tmp_path / "a.glb")
    (primitive,) = document.meshes[0].primitives
    places = numbers(primitive.attributes.POSITION)
    joints, weights = numbers(primitive.attributes.JOINTS_0), numbers(primitive.attributes.WEIGHTS_0)
    binds = numbers(document.skins[0].inverseBindMatrices).reshape(-1, 4, 4).transpose(0, 2, 1)
    frame = 40
    nodes = [n for n in document.nodes if n.skin is None]
    turns = np.array([n.rotation or [0.0, 0.0, 0.0, 1.0] for n in nodes])
    roots = np.zeros(3)
    shifts = np.array([n.translation for n in nodes])
    for channel in document.animations[0].channels:
        keys = numbers(document.animations[0].samplers[channel.sampler].output)
        value = keys[min(frame, len(keys) - 1)]
        if channel.target.path == "rotation":
            turns[channel.target.node] = value
        else:
            roots = value
    parents = [next((i for i, n in enumerate(nodes) if k in (n.children or ())), -1) for k in range(len(nodes))]
    tree = SimpleNamespace(parents=parents, offsets=shifts)
    matrices = skinning.world_matrices(tree, quaternion.normalize(quaternion.from_scalar_last(turns)), roots)
    skin = figure.fit(motion.skeleton, soles=contacts.contacts(motion).soles_as_they_bear(motion)).posed(motion[frame])[
        0
    ]
    for v in rng.integers(0, len(places), 60):
        twin = skinning.skinned(places[v], joints[v], weights[v], binds, matrices)
        # turns of helpers have 16 bits
        assert np.abs(twin - skin[v]).max() < 5e-5
    assert abs(weights.sum(axis=1) - 1.0).max() < 1e-6


def vertices(path: Path) -> np.ndarray:
    """Of the figure in a file, in the binding pose."""
    document, numbers = loaded(path)
    return numbers(document.meshes[0].primitives[0].attributes.POSITION)


def test_the_figure_stands_on_the_soles_that_are_given(tmp_path) -> None:
    """Those of the caller; else those of the motion; else, where legs have no ends and nothing is found, as it rests."""
    from kinesics.body import anatomy, contacts, figure

    motion = anatomy.understood(walk())
    found = contacts.contacts(motion).soles_as_they_bear(motion)
    # the same feet in higher heels
    places = found.offsets.copy()
    places[:, 0, 1] -= 0.03
    other = contacts.Soles(found.joints, places)
    for name, soles in (("found.glb", None), ("given.glb", other)):
        kx.formats.write(motion, tmp_path / name, soles=soles)
        expected = figure.fit(motion.skeleton, soles=found if soles is None else soles).vertices
        np.testing.assert_allclose(vertices(tmp_path / name), expected, atol=1e-6)
    assert np.abs(vertices(tmp_path / "found.glb") - vertices(tmp_path / "given.glb")).max() > 0.01
    assert kx.formats.write(motion, tmp_path / "a.bvh", soles=other) == ()

    legs = bodies.legs_striding(5)
    keep = [j for j, name in enumerate(legs.skeleton.joint_names) if not name.endswith("Foot")]
    footless = kx.Motion(
        kx.Skeleton(
            tuple(legs.skeleton.joint_names[j] for j in keep),
            tuple(keep.index(p) if p >= 0 else -1 for p in (legs.skeleton.parents[j] for j in keep)),
            legs.skeleton.offsets[keep],
        ),
        legs.rotations[:, keep],
        legs.root_positions,
        legs.fps,
    )
    kx.write(footless, tmp_path / "footless.glb")
    rests = figure.fit(anatomy.understood(footless).skeleton).vertices
    np.testing.assert_allclose(vertices(tmp_path / "footless.glb"), rests, atol=1e-6)


def test_helpers_are_no_joints(tmp_path) -> None:
    """They stand beside joints, hold nothing, are said to be helpers, and are not read as joints, even by who overlooks that."""
    motion = walk()
    kx.write(motion, tmp_path / "a.glb")
    document, _ = loaded(tmp_path / "a.glb")
    count = motion.skeleton.joint_count
    helpers = [k for k in document.skins[0].joints if k >= count]
    assert helpers
    for k in helpers:
        node = document.nodes[k]
        beside = document.nodes[node.extras["kinesics"]["helps"]]
        assert not node.children
        assert node.translation == beside.translation
        assert node.name.startswith(beside.name)
        node.extras = {}
    document.save(tmp_path / "b.glb")
    again = kx.read(tmp_path / "b.glb")
    assert again.skeleton.joint_count == count + len(helpers)
    poses = [kx.poses(m).quaternions for m in (again, motion)]
    assert np.abs(np.einsum("fjk,fjk->fj", *poses)).min() > 1.0 - 1e-6


def test_the_figure_is_small(tmp_path) -> None:
    """At most a megabyte without the movement."""
    kx.write(walk()[0], tmp_path / "a.glb")
    assert (tmp_path / "a.glb").stat().st_size < 1_000_000


def test_what_is_no_body_goes_out_bare(tmp_path) -> None:
    """Nodes and movement without a mesh, and a remark that says so."""
    (remark,) = kx.write(hand(), tmp_path / "a.glb")
    assert "without a figure" in remark
    document, _ = loaded(tmp_path / "a.glb")
    assert not document.meshes
    assert not document.skins
    assert len(document.nodes) == 4


def test_what_single_precision_cannot_hold_is_refused(tmp_path) -> None:
    """Frames too near each other in time are an error, and no file is left."""
    motion = kx.Motion(hand().skeleton, quaternion.identity((40, 4)), np.zeros((40, 3)), 1e-40)
    with pytest.raises(InputError, match="single precision"):
        kx.write(motion, tmp_path / "a.glb")
    assert not list(tmp_path.iterdir())


# ------------------------------------------------------------------------------------------------------ others' files


class Built:
    """A small glTF file by hand: a root, an arm and a forearm, and what a test adds."""

    def __init__(self) -> None:
        self.data = b""
        self.json: dict = {
            "asset": {"version": "2.0"},
            "scene": 0,
            "scenes": [{"nodes": [0]}],
            "nodes": [
                {"name": "Armature", "children": [1], "scale": [0.01, 0.01, 0.01]},
                {"name": "Root", "children": [2], "translation": [0, 90, 0]},
                {"name": "Arm", "children": [3], "translation": [0, 20, 0]},
                {"name": "Forearm", "translation": [30, 0, 0]},
            ],
            "skins": [{"joints": [1, 2, 3]}],
            "animations": [{"name": "one", "channels": [], "samplers": []}],
            "accessors": [],
            "bufferViews": [],
        }

    def add(self, values, kind) -> int:
        data = np.asarray(values, dtype="<f4").tobytes()
        self.json["bufferViews"].append({"buffer": 0, "byteOffset": len(self.data), "byteLength": len(data)})
        self.data += data
        view = len(self.json["bufferViews"]) - 1
        self.json["accessors"].append({"bufferView": view, "componentType": 5126, "count": len(values), "type": kind})
        return view

    def key(self, node, path, times, values, interpolation="LINEAR") -> None:
        animation = self.json["animations"][0]
        animation["samplers"].append(
            {
                "input": self.add(times, "SCALAR"),
                "output": self.add(values, "VEC4" if path == "rotation" else "VEC3"),
                "interpolation": interpolation,
            }
        )
        animation["channels"].append(
            {"sampler": len(animation["samplers"]) - 1, "target": {"node": node, "path": path}}
        )

    def put(self, folder: Path) -> Path:
        uri = "data:application/octet-stream;base64," + base64.b64encode(self.data).decode()
        self.json.setdefault("buffers", [{"byteLength": len(self.data), "uri": uri}])
        path = folder / "other.gltf"
        path.write_text(json.dumps(self.json))
        return path


def turning(interpolation="LINEAR", times=(0.0, 0.5, 1.0)) -> Built:
    """The arm turns a right angle about z and back."""
    half = float(np.sqrt(0.5))
    built = Built()
    values = [[0, 0, 0, 1], [0, 0, half, half], [0, 0, 0, 1]]
    if interpolation == "CUBICSPLINE":
        values = [row for v in values for row in ([0, 0, 0, 0], v, [0, 0, 0, 0])]
    built.key(2, "rotation", list(times), values, interpolation)
    return built


def test_an_armature_in_centimetres_is_read_in_metres(tmp_path) -> None:
    """What stands above the skeleton is folded into it: scale, place and turn."""
    built = turning()
    built.json["nodes"][0] |= {"translation": [1, 0, 0], "rotation": [0, float(np.sqrt(0.5)), 0, float(np.sqrt(0.5))]}
    motion = kx.read(built.put(tmp_path), fps=10.0)
    assert motion.skeleton.joint_names == ("Root", "Arm", "Forearm")
    assert motion.frame_count == 11
    np.testing.assert_allclose(
        motion.positions()[[0, 5]],
        [[[1, 0.9, 0], [1, 1.1, 0], [1, 1.1, -0.3]], [[1, 0.9, 0], [1, 1.1, 0], [1, 1.4, 0]]],
        atol=1e-6,
    )


@pytest.mark.parametrize(
    ("interpolation", "quarter"), [("LINEAR", np.pi / 4), ("STEP", 0.0), ("CUBICSPLINE", np.pi / 4)]
)
def test_keys_are_filled_in(tmp_path, interpolation, quarter) -> None:
    """Halfway between two keys: half the angle, or the key before."""
    motion = kx.read(turning(interpolation).put(tmp_path), fps=4.0)
    assert motion.frame_count == 5
    angles = quaternion.angle(motion.rotations[:, 1])
    np.testing.assert_allclose(angles, [0.0, quarter, np.pi / 2, quarter if quarter else np.pi / 2, 0.0], atol=1e-6)


def test_the_rate_is_that_of_the_keys_and_said(tmp_path) -> None:
    """Three keys in a second are two frames a second, unless the user says otherwise."""
    motion = kx.read(turning().put(tmp_path))
    assert motion.fps == 2.0
    assert any("frame rate 2" in text for text in motion.assumptions)


def with_json(change):
    """A file of a turning arm with something changed."""
    built = turning()
    change(built.json)
    return built


BAD = {
    "no animation": (lambda j: j.update(animations=[]), "no animation"),
    "nothing moves": (lambda j: j["animations"][0].update(channels=[]), "moves no joint"),
    "a child that is none": (lambda j: j["nodes"][3].update(children=[9]), "child 9"),
    "a circle": (lambda j: j["nodes"][3].update(children=[0]), "circle"),
    "two parents": (lambda j: j["nodes"][3].update(children=[2]), "hangs on two"),
    "two bodies": (
        lambda j: (j["nodes"].append({"name": "other"}), j["skins"][0]["joints"].append(4)),
        "separate roots",
    ),
    "a joint that is none": (lambda j: j["skins"][0]["joints"].append(7), "no node"),
    "stretched": (lambda j: j["nodes"][2].update(scale=[1, 2, 1]), "stretched"),
    "mirrored": (lambda j: j["nodes"][2].update(scale=[-1, -1, -1]), "stretched"),
    "old": (lambda j: j["asset"].update(version="1.0"), "Expected glTF 2"),
    "packed": (lambda j: j.update(extensionsRequired=["EXT_meshopt_compression"]), "packed"),
    "data beyond the end": (lambda j: j["accessors"][1].update(count=4000), "beyond the data"),
    "data elsewhere": (lambda j: j.update(buffers=[{"byteLength": 1, "uri": "../secret.bin"}]), "beside it"),
    "data on the net": (lambda j: j.update(buffers=[{"byteLength": 1, "uri": "https://a.b/c.bin"}]), "beside it"),
    "data that are not there": (lambda j: j.update(buffers=[{"byteLength": 1, "uri": "c.bin"}]), "no such file"),
    "data not in base 64": (lambda j: j.update(buffers=[{"byteLength": 1, "uri": "data:,$$"}]), "base 64"),
    "sparse": (lambda j: j["accessors"][1].pop("bufferView"), "sparsely"),
    "an unknown kind of number": (lambda j: j["accessors"][1].update(componentType=7), "damaged"),
    "texts for numbers": (lambda j: j["nodes"][1].update(translation=["a", "b", "c"]), "damaged"),
    "lists for objects": (lambda j: j.update(nodes=[[1]]), "damaged"),
    "nodes missing": (lambda j: j.pop("nodes"), "moves a node"),
}


@pytest.mark.parametrize(("change", "said"), BAD.values(), ids=BAD)
def test_what_cannot_be_read_is_said(tmp_path, change, said) -> None:
    """One FileError, in words."""
    with pytest.raises(FileError, match=said):
        kx.read(with_json(change).put(tmp_path))


def test_times_that_do_not_rise_are_refused(tmp_path) -> None:
    """Keys out of order, and an animation that lasts for ages."""
    with pytest.raises(FileError, match="do not rise"):
        kx.read(turning(times=(0.0, 0.5, 0.5)).put(tmp_path))
    with pytest.raises(FileError, match="too long"):
        kx.read(turning(times=(0.0, 0.01, 1e30)).put(tmp_path), fps=100.0)


@given(st.data())
def test_cut_and_changed_bytes_are_an_error_or_a_motion(data: st.DataObject) -> None:
    """Anything but a FileError or a motion is a defect."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "a.glb"
        kx.write(hand(), path)
        path.write_bytes(data.draw(small_files.spoilt(path.read_bytes())))
        with contextlib.suppress(FileError):
            assert kx.read(path).frame_count >= 1


def test_who_stands_still_stands_as_long_as_before(tmp_path: Path) -> None:
    """Nothing moves in ninety frames: they come back as ninety."""
    stand = kx.performer.stand(seconds=1.0, fps=30).motion
    still = stand.replace(
        rotations=np.repeat(stand.rotations[:1], 90, axis=0),
        root_positions=np.repeat(stand.root_positions[:1], 90, axis=0),
    )
    path = tmp_path / "still.glb"
    kx.write(still, path)
    again = kx.read(path)
    assert again.frame_count == 90
    assert again.fps == pytest.approx(30.0)
