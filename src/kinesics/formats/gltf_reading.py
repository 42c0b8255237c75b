"""Skeleton and animation out of a glTF 2.0 file; meshes, materials and everything to be looked at are passed over.

Taken are the joints of the skins and what joins them into one tree (or, without a skin, the nodes that the animation moves),
and the first animation. Scaling is folded into the lengths of the bones.
"""

from __future__ import annotations

import base64
import binascii
import heapq
import struct
import urllib.parse
import warnings
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Any, Final, NoReturn

import numpy as np
from numpy.typing import NDArray

from kinesics.body.motion import Motion
from kinesics.body.skeleton import EndSite, Skeleton
from kinesics.errors import FileError, InputError
from kinesics.formats import load
from kinesics.formats.registry import ReadOptions, Recording
from kinesics.geometry import quaternion

if TYPE_CHECKING:
    from pygltflib import GLTF2

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

EXTRAS: Final = "kinesics"
"""The key of what is ours among the ``extras`` of a node or an animation."""

_TYPES: Final = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_WIDTHS: Final = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
_PATHS: Final = {"translation": 3, "rotation": 4, "scale": 3}
_PACKED: Final = ("EXT_meshopt_compression", "KHR_meshopt_compression")
_MOST_NUMBERS: Final = 400_000_000
_USUAL_RATES: Final = (24.0, 25.0, 30.0, 48.0, 50.0, 60.0, 90.0, 100.0, 120.0, 200.0, 240.0)
_GRID: Final = 0.02
"""Of a frame: keys this near to whole frames lie on them, for times are of single precision."""
_EVEN: Final = 1e-3
"""Scales that differ by less are the same, shifts in metres that do are none."""


def read(path: Path, raw: bytes, options: ReadOptions) -> Recording:
    """The movement in a glTF file.

    Raises
    ------
    FileError
        If it is damaged, holds no skeleton that moves, or moves it in a way that bones cannot.
    """
    try:
        # what the library warns of is checked here, or has to do with what is not read
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return _Reader(path, raw).recording(options)
    except InputError:
        raise
    except (
        ArithmeticError, AttributeError, LookupError, MemoryError, OSError, RecursionError, TypeError, ValueError,
        struct.error, AssertionError,
    ) as error:  # fmt: skip
        # the library takes a document as it comes: a field that is missing or of another kind is found where it is used
        said = str(error).split("\n")[0][:120] or type(error).__name__
        raise FileError(path, f"This glTF file is damaged: {said}.") from None


@dataclass(frozen=True)
class _Track:
    """What the animation says of one property of one node."""

    times: Array
    values: Array
    """Shape (keys, width), or (keys, 3, width) for cubic splines: tangent in, value, tangent out."""
    kind: str


class _Reader:
    def __init__(self, path: Path, raw: bytes) -> None:
        from pygltflib import GLTF2

        self.path = path
        self.document: GLTF2
        if raw.startswith(b"glTF"):
            declared = struct.unpack("<I", raw[8:12])[0]
            if declared > len(raw):
                self.fail(f"The file says that it has {declared} bytes, and has {len(raw)}.", hint="It seems cut off.")
            version = struct.unpack("<I", raw[4:8])[0]
            if version != 2:
                self.fail(f"Expected glTF 2, got version {version}.")
            self.document = GLTF2.load_from_bytes(raw)
        else:
            self.document = GLTF2.gltf_from_json(raw.decode("utf-8-sig"))
        if not str(self.document.asset.version or "").startswith("2"):
            self.fail(f"Expected glTF 2, got version {str(self.document.asset.version)[:20]!r}.")
        packed = [e for e in self.document.extensionsRequired or () if e in _PACKED]
        if packed:
            self.fail(f"Its data are packed ({packed[0]}).", hint="Save it without compression.")
        self.buffers: dict[int, bytes] = {}
        nodes = self.document.nodes
        self.parents = [-1] * len(nodes)
        for i, node in enumerate(nodes):
            for child in node.children or ():
                if not 0 <= child < len(nodes):
                    self.fail(f"Node {i} has a child {child}, and there are {len(nodes)} nodes.")
                if self.parents[child] >= 0:
                    self.fail(f"Node {child} hangs on two others.")
                self.parents[child] = i
        for i in range(len(nodes)):
            self.above(i)

    def fail(self, problem: str, *, hint: str = "") -> NoReturn:
        raise FileError(self.path, problem, hint=hint)

    def above(self, node: int) -> list[int]:
        """A node and what it hangs on, up to the top."""
        out = []
        while node >= 0:
            out.append(node)
            node = self.parents[node]
            if len(out) > len(self.parents):
                self.fail("Nodes hang on each other in a circle.")
        return out

    # ------------------------------------------------------------------------------------------------------ numbers

    def buffer(self, index: int) -> bytes:
        if index not in self.buffers:
            declared = self.document.buffers[index]
            uri = declared.uri
            if uri is None:
                data = self.document.binary_blob()
                if data is None:
                    self.fail("The file has no data: its binary part is missing.", hint="It seems cut off.")
            elif uri.startswith("data:"):
                try:
                    data = base64.b64decode(uri.partition(",")[2], validate=True)
                except binascii.Error:
                    self.fail("Data inside the file are not in base 64.")
            else:
                name = urllib.parse.unquote(uri)
                if (
                    "://" in name
                    or "\\" in name
                    or PurePosixPath(name).is_absolute()
                    or ".." in PurePosixPath(name).parts
                ):
                    self.fail(f"Its data lie elsewhere ('{name[:60]}'), and only files beside it are read.")
                data = load(self.path.parent / name)
            if len(data) < (declared.byteLength or 0):
                self.fail(
                    f"Expected {declared.byteLength} bytes of data, got {len(data)}.", hint="The file seems cut off."
                )
            self.buffers[index] = bytes(data)
        return self.buffers[index]

    def accessor(self, index: int) -> Array:
        """Numbers as they are meant, shape (count, width)."""
        if not 0 <= index < len(self.document.accessors):
            self.fail(f"There is no accessor {index}.")
        a = self.document.accessors[index]
        if a.sparse is not None or a.bufferView is None:
            self.fail("Numbers of an animation are kept sparsely, which cannot be read.")
        view = self.document.bufferViews[a.bufferView]
        dtype = np.dtype(_TYPES[a.componentType])
        width = _WIDTHS[a.type]
        start = (view.byteOffset or 0) + (a.byteOffset or 0)
        stride = view.byteStride or dtype.itemsize * width
        data = self.buffer(view.buffer)
        end = start + stride * (a.count - 1) + dtype.itemsize * width
        if a.count < 1 or start < 0 or stride < dtype.itemsize * width or end > len(data):
            self.fail(f"Accessor {index} reaches beyond the data.", hint="The file seems cut off.")
        table = np.ndarray((a.count, width), dtype, data, start, (stride, dtype.itemsize))
        out = table.astype(np.float64)
        if not np.isfinite(out).all():
            self.fail(f"A number of accessor {index} is not finite.")
        if dtype.kind != "f" and a.normalized:
            out = np.maximum(out / np.iinfo(dtype).max, -1.0)
        return out

    # ------------------------------------------------------------------------------------------------------ animation

    def tracks(self, assumptions: list[str]) -> tuple[Any, dict[tuple[int, str], _Track]]:
        """The first animation: (node, property) → what it says."""
        animations = self.document.animations
        if not animations:
            self.fail("There is no animation in this file.", hint="Export it with its animation.")
        first = animations[0]
        if len(animations) > 1:
            assumptions.append(f"the first of {len(animations)} animations was read ('{first.name or 'unnamed'}')")
        out: dict[tuple[int, str], _Track] = {}
        for channel in first.channels:
            node, prop = channel.target.node, channel.target.path
            if node is None or prop not in _PATHS:
                continue
            if not 0 <= node < len(self.parents):
                self.fail(f"The animation moves a node {node}, and there are {len(self.parents)}.")
            sampler = first.samplers[channel.sampler]
            kind = sampler.interpolation or "LINEAR"
            if kind not in ("LINEAR", "STEP", "CUBICSPLINE"):
                self.fail(f"Expected keys that are LINEAR, STEP or CUBICSPLINE, got {str(kind)[:20]}.")
            times, values = self.accessor(sampler.input)[:, 0], self.accessor(sampler.output)
            keys = len(times)
            name = self.document.nodes[node].name or f"node {node}"
            if np.any(np.diff(times) <= 0.0) or times[0] < 0.0:
                self.fail(f"The times of the keys of '{name}' do not rise.")
            if values.shape != (keys * (3 if kind == "CUBICSPLINE" else 1), _PATHS[prop]):
                self.fail(f"'{name}' has {keys} keys and {len(values)} values for its {prop}.")
            if kind == "CUBICSPLINE":
                values = values.reshape(keys, 3, -1)
            out[node, prop] = _Track(times, values, kind)
        if not out:
            self.fail("The animation of this file moves no joints.")
        return first, out

    def rate(self, animation: Any, tracks: dict[tuple[int, str], _Track], assumptions: list[str]) -> float:
        """Frames a second."""
        own = (animation.extras or {}).get(EXTRAS)
        if isinstance(own, dict) and isinstance(own.get("fps"), (int, float)) and 0 < own["fps"] < 1e6:
            return float(own["fps"])
        times = max((t.times for t in tracks.values()), key=len)
        if len(times) == 1:
            assumptions.append("the animation has one key: 30 frames a second assumed")
            return 30.0
        steps = np.diff(times)
        mean = float((len(times) - 1) / (times[-1] - times[0]))
        rate = mean if np.ptp(steps) < 0.1 / mean else float(1.0 / np.median(steps))
        usual = min(_USUAL_RATES, key=lambda r: abs(np.log(r / rate)))
        rate = usual if abs(rate / usual - 1.0) < 2e-3 else rate
        assumptions.append(f"frame rate {rate:g}: that of the keys, for the format has none")
        return rate

    # ------------------------------------------------------------------------------------------------------ skeleton

    def joints(self, tracks: dict[tuple[int, str], _Track]) -> list[int]:
        """Nodes of the skeleton, parents first, else in the file's order."""
        wanted = {j for skin in self.document.skins for j in skin.joints or ()}
        if any(not 0 <= j < len(self.parents) for j in wanted):
            self.fail("A skin names a joint that is no node.")
        wanted = {j for j in wanted if not self.helps(j)}
        if not wanted:
            wanted = {node for node, _ in tracks}
            # without a skin nothing says where the skeleton ends: all that hangs on what moves is part of it
            wanted |= {
                i for i, node in enumerate(self.document.nodes) if node.mesh is None and wanted & set(self.above(i))
            }
        chains = {j: self.above(j)[::-1] for j in wanted}
        tops = {chain[0] for chain in chains.values()}
        if len(tops) > 1:
            self.fail(
                f"The joints of this file hang on {len(tops)} separate roots: one body at a time can be read.",
                hint="Export one character alone.",
            )
        moved = {node for node, _ in tracks}
        one = next(iter(chains.values()))
        depth = 0
        while all(depth < len(chain) and chain[depth] == one[depth] for chain in chains.values()):
            depth += 1
        # the lowest node that all hang on; what moves above it belongs to the movement
        root = next((k for k in range(depth) if one[k] in moved), depth - 1)
        members = {node for chain in chains.values() for node in chain[root:]}
        out, ready = [], [one[root]]
        while ready:
            node = heapq.heappop(ready)
            out.append(node)
            for child in self.document.nodes[node].children or ():
                if child in members:
                    heapq.heappush(ready, child)
        return out

    def helps(self, node: int) -> bool:
        """Whether a node is none of the skeleton's joints, but a helper of our own figure."""
        own = (self.document.nodes[node].extras or {}).get(EXTRAS)
        return isinstance(own, dict) and "helps" in own

    def rest(self, node: int) -> tuple[Array, Array, Array]:
        """Translation, rotation (scalar first) and scale of a node when nothing moves it."""
        n = self.document.nodes[node]
        if n.matrix:
            m = np.array(n.matrix, dtype=np.float64).reshape(4, 4).T
            if not np.isfinite(m).all():
                self.fail(f"The matrix of '{n.name or node}' is not finite.")
            scale = np.linalg.norm(m[:3, :3], axis=0)
            if scale.min() <= 0.0 or np.linalg.det(m[:3, :3]) <= 0.0:
                self.fail(f"The matrix of '{n.name or node}' is no turn and no scale.")
            return m[:3, 3], quaternion.from_matrix(m[:3, :3] / scale), scale
        shift = np.array(n.translation or (0.0, 0.0, 0.0), dtype=np.float64)
        turn = np.array(n.rotation or (0.0, 0.0, 0.0, 1.0), dtype=np.float64)
        scale = np.array(n.scale or (1.0, 1.0, 1.0), dtype=np.float64)
        if shift.shape != (3,) or turn.shape != (4,) or scale.shape != (3,):
            self.fail(f"The place of '{n.name or node}' has too many or too few numbers.")
        return shift, quaternion.normalize(quaternion.from_scalar_last(turn)), scale

    def even(self, node: int, scale: Array) -> float:
        """A scale that is the same along all axes."""
        if not np.ptp(scale) <= _EVEN * np.abs(scale).max() or scale.min() <= 0.0:
            self.fail(
                f"'{self.document.nodes[node].name or node}' is stretched along one axis; bones only turn.",
                hint="Apply scales before exporting.",
            )
        return float(scale.mean())

    def recording(self, options: ReadOptions) -> Recording:
        assumptions: list[str] = []
        animation, tracks = self.tracks(assumptions)
        joints = self.joints(tracks)
        tracks = {key: track for key, track in tracks.items() if key[0] in set(joints)}
        if not tracks:
            self.fail("The animation of this file moves no joint of the skeleton.")
        fps = self.rate(animation, tracks, assumptions) if options.fps is None else float(options.fps)
        start = min(t.times[0] for t in tracks.values())
        spans = [(t.times[-1] - start) * fps for t in tracks.values()]
        if max(spans) * len(joints) * 7 > _MOST_NUMBERS:
            self.fail(f"The animation lasts {max(spans) / fps:.3g} s: too long to be one of a body.")
        frames = int(np.floor(max(spans) + _GRID)) + 1
        count = len(joints)
        index = {node: j for j, node in enumerate(joints)}
        parents = tuple(index.get(self.parents[node], -1) for node in joints)

        rotations = np.empty((frames, count, 4))
        shifts = np.empty((frames, count, 3))
        offsets = np.empty((count, 3))
        size = np.empty(count)  # scale of all that hangs on the joint
        world_shift, world_turn, world_size = self.stage(self.parents[joints[0]])
        for j, node in enumerate(joints):
            shift, turn, scale = self.rest(node)
            track = tracks.get((node, "scale"))
            if track is not None:
                scaled = _sampled(track, start, fps, frames)
                if np.any(np.ptp(scaled, axis=0) > _EVEN * np.abs(scaled).max()):
                    self.fail(f"'{self.document.nodes[node].name or node}' changes its size; bones only turn.")
                scale = scaled[0]
            before = size[parents[j]] if j else world_size
            size[j] = before * self.even(node, scale)
            track = tracks.get((node, "rotation"))
            if track is None:
                rotations[:, j] = turn
            else:
                rotations[:, j] = _sampled_turns(track, start, fps, frames)
            track = tracks.get((node, "translation"))
            moved = shift if track is None else _sampled(track, start, fps, frames)
            shifts[:, j] = before * moved
            offsets[j] = before * shift
        roots = world_shift + quaternion.rotate(world_turn, shifts[:, 0])
        rotations[:, 0] = quaternion.multiply(world_turn, rotations[:, 0])
        offsets[0] = 0.0
        moving = bool(np.any(np.abs(shifts[:, 1:] - offsets[1:]) > 1e-6 * max(1.0, float(np.abs(offsets).max()))))
        try:
            # making a motion of it checks that all is finite and of a size that can be
            motion = Motion(
                Skeleton(self.names(joints), parents, offsets, self.tips(joints, size)),
                rotations,
                roots,
                fps,
                shifts if moving else None,
            )
        except InputError as error:
            self.fail(f"What this file holds is no motion: {error}")
        return Recording(
            skeleton=motion.skeleton,
            rotations=motion.rotations,
            root_positions=motion.root_positions,
            fps=fps,
            joint_translations=motion.joint_translations,
            metres_per_unit=1.0,
            up_axis="y",
            assumptions=tuple(assumptions),
        )

    def stage(self, node: int) -> tuple[Array, Array, float]:
        """What stands between the world and the root: translation, rotation and scale of all nodes above it."""
        shift, turn, size = np.zeros(3), quaternion.identity(), 1.0
        for above in self.above(node):
            own_shift, own_turn, own_scale = self.rest(above)
            s = self.even(above, own_scale)
            shift = own_shift + quaternion.rotate(own_turn, s * shift)
            turn = quaternion.multiply(own_turn, turn)
            size *= s
        return shift, turn, size

    def names(self, joints: list[int]) -> tuple[str, ...]:
        out: list[str] = []
        taken: set[str] = set()
        for node in joints:
            name = plain = str(self.document.nodes[node].name or f"node{node}")
            number = 1
            while name in taken:
                number += 1
                name = f"{plain}.{number}"
            taken.add(name)
            out.append(name)
        return tuple(out)

    def tips(self, joints: list[int], size: Array) -> tuple[EndSite, ...]:
        """Tips of leaf joints, which only our own files have."""
        out = []
        for j, node in enumerate(joints):
            own = (self.document.nodes[node].extras or {}).get(EXTRAS)
            for tip in own.get("tips", ()) if isinstance(own, dict) else ():
                x, y, z = (float(v) * float(size[j]) for v in tip)
                out.append(EndSite(j, (x, y, z)))
        return tuple(out)


def _places(track: _Track, start: float, fps: float, frames: int) -> tuple[Indices, Indices, Array, Array]:
    """For each frame the keys before and after it, how far between them it lies, and the seconds from one to the other."""
    keys = (track.times - start) * fps
    whole = np.round(keys)
    keys = np.where(np.abs(keys - whole) < _GRID, whole, keys)
    at = np.arange(frames, dtype=np.float64)
    after = np.clip(np.searchsorted(keys, at, side="left"), 0, len(keys) - 1)
    before = np.maximum(after - 1, 0)
    gap = keys[after] - keys[before]
    t = np.clip(np.where(gap > 0.0, (at - keys[before]) / np.where(gap > 0.0, gap, 1.0), 1.0), 0.0, 1.0)
    return before, after, t, gap / fps


def _sampled(track: _Track, start: float, fps: float, frames: int) -> Array:
    """Values at the frames, shape (frames, width)."""
    before, after, t, gap = _places(track, start, fps, frames)
    t = t[:, None]
    if track.kind == "STEP":
        return np.asarray(np.where(t >= 1.0, track.values[after], track.values[before]))
    if track.kind == "LINEAR":
        # exact where a frame falls on a key
        return np.asarray((1.0 - t) * track.values[before] + t * track.values[after])
    gap = gap[:, None]
    v0, out0, in1, v1 = (
        track.values[before, 1], track.values[before, 2], track.values[after, 0], track.values[after, 1]
    )  # fmt: skip
    h = t * t * (3.0 - 2.0 * t)
    return np.asarray((1.0 - h) * v0 + h * v1 + gap * ((t**3 - 2 * t**2 + t) * out0 + (t**3 - t**2) * in1))


def _sampled_turns(track: _Track, start: float, fps: float, frames: int) -> Array:
    """Rotations at the frames, scalar first, shape (frames, 4)."""
    if track.kind != "LINEAR":
        return quaternion.normalize(quaternion.from_scalar_last(_sampled(track, start, fps, frames)))
    keys = quaternion.normalize(quaternion.from_scalar_last(track.values))
    before, after, t, _ = _places(track, start, fps, frames)
    out = keys[after]
    between = t < 1.0
    if between.any():
        out[between] = quaternion.slerp(keys[before[between]], keys[after[between]], t[between])
    return out
