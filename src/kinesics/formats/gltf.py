"""glTF 2.0, binary (.glb) or as JSON with its data inside (.gltf): skeleton, animation and a human figure that wears it.

Written are one node for each joint, one animation with a key for every frame, and, where the skeleton is understood as a
human body, the skinned mesh of `kinesics.body.figure` with its helpers, which are leaf nodes beside the joints they stand at.
A skeleton that is none goes out as bare nodes, and a remark says so.
The specification is that of Khronos, "glTF 2.0 Specification" (2021). What it has no word for, the tips of leaf joints and the
exact frame rate, is kept in ``extras``, where the format has room for anything; joint limits are not kept.

Numbers in glTF are of single precision: positions within 10 m come back to less than a micrometre.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from kinesics.body import anatomy, contacts, figure
from kinesics.body.feet import Soles
from kinesics.body.figure import Figure
from kinesics.body.motion import Motion
from kinesics.errors import InputError, SkeletonError
from kinesics.formats import gltf_reading
from kinesics.formats.registry import Format, Written
from kinesics.geometry import quaternion

if TYPE_CHECKING:
    from pygltflib import GLTF2

Array = NDArray[np.float64]

EXTRAS: Final = gltf_reading.EXTRAS

_TONE: Final = (0.66, 0.60, 0.53, 1.0)
"""Of the figure: linear colour, near that of unpainted wood."""
_STILL: Final = 1e-7
"""Metres: a joint that stays this near to its offset in the skeleton needs no key."""


def sniff(head: bytes) -> bool:
    """Whether a file begins as glTF does."""
    if head.startswith(b"glTF"):
        return True
    start = head.lstrip(b"\xef\xbb\xbf \t\r\n")
    return start.startswith(b"{") and any(word in start for word in (b'"asset"', b'"accessors"', b'"bufferViews"'))


def write(motion: Motion, path: Path, soles: Soles | None = None) -> Written:
    """The motion as glTF, worn by a human figure where it has a human skeleton.

    Parameters
    ----------
    soles : that the figure stands on; found in the motion unless given.

    Raises
    ------
    InputError
        If times or places are beyond what single precision can tell apart.
    """
    remarks = []
    body: Figure | None = None
    try:
        motion = anatomy.understood(motion)
        body = figure.fit(motion.skeleton, _usual_offsets(motion), _soles_of(motion) if soles is None else soles)
    except SkeletonError:
        remarks.append(
            "the skeleton is not understood as a human body (--map names its joints): written as bare joints and their "
            "movement, without a figure"
        )
    with np.errstate(over="raise"):
        try:
            document = _document(motion, body, path.stem)
        except FloatingPointError:
            raise InputError(
                "glTF keeps numbers in single precision, and a length of this motion is beyond it."
            ) from None
    if path.suffix.lower() == ".gltf":
        from pygltflib import BufferFormat

        document.convert_buffers(BufferFormat.DATAURI)
        data = document.gltf_to_json().encode()
    else:
        data = b"".join(bytes(part) for part in document.save_to_bytes())
    return Written(((path, data),), tuple(remarks))


def _soles_of(motion: Motion) -> Soles | None:
    """Those of the body in a recording; None where one of its feet never stands."""
    try:
        found = contacts.contacts(motion)
    except SkeletonError:  # legs without ends still have flesh
        return None
    return found.soles_as_they_bear(motion) if found.points[:, :, :2].all(axis=-1).any(axis=0).all() else None


def _usual_offsets(motion: Motion) -> Array | None:
    """Bone lengths of the recording where joints shift, by the median over its frames."""
    if motion.joint_translations is None:
        return None
    out = np.median(motion.joint_translations, axis=0)
    out[0] = 0.0
    return np.asarray(out)


class _Data:
    """The one buffer of a document, growing."""

    def __init__(self, document: GLTF2) -> None:
        self.document = document
        self.parts: list[bytes] = []
        self.length = 0

    def add(self, values: NDArray[Any], kind: str, *, target: int | None = None, bounds: bool = False) -> int:
        """Append numbers of one kind, "SCALAR", "VEC3" …; the number of their accessor."""
        from pygltflib import Accessor, BufferView

        data = np.ascontiguousarray(values).tobytes()
        view = BufferView(buffer=0, byteOffset=self.length, byteLength=len(data), target=target)
        data += b"\0" * (-len(data) % 4)
        self.parts.append(data)
        self.length += len(data)
        table = values.reshape(len(values), -1)
        self.document.bufferViews.append(view)
        self.document.accessors.append(
            Accessor(
                bufferView=len(self.document.bufferViews) - 1,
                componentType=_COMPONENTS[values.dtype.str],
                count=len(values),
                # whole numbers with a sign are shares of 1
                normalized=values.dtype.kind == "i",
                type=kind,
                min=[float(v) for v in table.min(axis=0)] if bounds else [],
                max=[float(v) for v in table.max(axis=0)] if bounds else [],
            )
        )
        return len(self.document.accessors) - 1


_COMPONENTS: Final = {"|u1": 5121, "<i2": 5122, "<u2": 5123, "<u4": 5125, "<f4": 5126}
_VERTICES, _TRIANGLES = 34962, 34963  # buffer targets of the specification


def _document(motion: Motion, body: Figure | None, name: str) -> GLTF2:
    from pygltflib import GLTF2, Asset, Buffer, Scene

    document = GLTF2(asset=Asset(version="2.0", generator="kinesics"))
    data = _Data(document)
    document.nodes = _nodes(motion, body)
    document.scenes = [Scene(name=name or "motion", nodes=[0])]
    document.scene = 0
    if body is not None:
        _add_figure(document, data, body)
    document.animations = [_animation(motion, data, body, motion.name or name or "motion")]
    document.buffers = [Buffer(byteLength=data.length)]
    document.set_binary_blob(b"".join(data.parts))
    return document


def _nodes(motion: Motion, body: Figure | None) -> list[Any]:
    """One for each joint, in the binding pose where there is a figure, else at rest."""
    from pygltflib import Node

    skeleton = motion.skeleton
    rest = quaternion.identity((skeleton.joint_count,))
    places = skeleton.offsets.copy()
    places[0] = motion.root_positions[0]
    if body is not None:
        parents = list(skeleton.parents[1:])
        bound = body.bind_rotations[: skeleton.joint_count]
        rest[0] = bound[0]
        rest[1:] = quaternion.multiply(quaternion.conjugate(bound[parents]), bound[1:])
        places[0] = body.bind_positions[0]
    turns = _single(quaternion.as_scalar_last(quaternion.normalize(rest)))
    shifts = _single(places)
    helpers = () if body is None else body.helpers
    standing: list[list[int]] = [[] for _ in skeleton.joint_names]
    for k, helper in enumerate(helpers):
        standing[skeleton.parents[helper.joint]].append(skeleton.joint_count + k)
    nodes = []
    for j, joint in enumerate(skeleton.joint_names):
        tips = [list(s.offset) for s in skeleton.end_sites if s.parent == j]
        nodes.append(
            Node(
                name=joint,
                children=[*skeleton.children[j], *standing[j]],
                rotation=[float(v) for v in turns[j]],
                translation=[float(v) for v in shifts[j]],
                extras={EXTRAS: {"tips": tips}} if tips else {},
            )
        )
    for helper in helpers:
        place = [float(v) for v in shifts[helper.joint]]
        nodes.append(Node(name=helper.name, translation=place, extras={EXTRAS: {"helps": helper.joint}}))
    return nodes


def _add_figure(document: GLTF2, data: _Data, body: Figure) -> None:
    """Mesh, material and skin, on a node of their own beside the root."""
    from pygltflib import Attributes, Material, Mesh, Node, PbrMetallicRoughness, Primitive, Skin

    joints = len(body.bind_rotations)
    numbers = np.uint8 if joints <= 256 else np.uint16
    weights = _single(body.weights)
    weights /= weights.sum(axis=1, keepdims=True)
    normals = _single(body.normals)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    bind = np.zeros((joints, 4, 4))
    bind[:, 3, 3] = 1.0
    to_joint = quaternion.conjugate(body.bind_rotations)
    bind[:, :3, :3] = quaternion.as_matrix(to_joint)
    bind[:, :3, 3] = -quaternion.rotate(to_joint, body.bind_positions)
    primitive = Primitive(
        attributes=Attributes(
            POSITION=data.add(_single(body.vertices), "VEC3", target=_VERTICES, bounds=True),
            NORMAL=data.add(normals, "VEC3", target=_VERTICES),
            JOINTS_0=data.add(body.joints.astype(numbers), "VEC4", target=_VERTICES),
            WEIGHTS_0=data.add(weights, "VEC4", target=_VERTICES),
        ),
        indices=data.add(body.triangles.astype(np.uint16).ravel(), "SCALAR", target=_TRIANGLES),
        material=0,
    )
    document.materials = [
        Material(
            name="figure",
            pbrMetallicRoughness=PbrMetallicRoughness(
                baseColorFactor=list(_TONE), metallicFactor=0.0, roughnessFactor=0.75
            ),
            alphaMode=None,
            alphaCutoff=None,
        )
    ]
    document.meshes = [Mesh(name="figure", primitives=[primitive])]
    # matrices column by column
    document.skins = [
        Skin(
            name="figure",
            joints=list(range(joints)),
            skeleton=0,
            inverseBindMatrices=data.add(_single(bind.transpose(0, 2, 1).reshape(joints, 16)), "MAT4"),
        )
    ]
    document.nodes.append(Node(name="figure", mesh=0, skin=0))
    document.scenes[0].nodes.append(len(document.nodes) - 1)


def _animation(motion: Motion, data: _Data, body: Figure | None, name: str) -> Any:
    """A key for every frame, or a single one for what does not move: but for the root's place, which says how long it lasts."""
    from pygltflib import Animation, AnimationChannel, AnimationChannelTarget, AnimationSampler

    times = _single(np.arange(motion.frame_count) / motion.fps)
    if np.any(np.diff(times) <= 0.0):
        raise InputError(
            f"glTF keeps times in single precision, which cannot tell frames apart after {motion.duration:.0f} s at "
            f"{motion.fps:g} frames a second. Cut the motion, or resample it."
        )
    every = data.add(times, "SCALAR", bounds=True)
    once = -1  # made when it is wanted
    out = Animation(name=name, extras={EXTRAS: {"fps": motion.fps}})

    def channel(joint: int, path: str, values: NDArray[Any], kind: str) -> None:
        nonlocal once
        still = bool(np.all(values == values[0])) and (joint, path) != (0, "translation")
        if still and once < 0:
            once = data.add(times[:1], "SCALAR", bounds=True) if motion.frame_count > 1 else every
        keys = data.add(values[:1] if still else values, kind)
        out.samplers.append(AnimationSampler(input=once if still else every, output=keys, interpolation="LINEAR"))
        out.channels.append(
            AnimationChannel(sampler=len(out.samplers) - 1, target=AnimationChannelTarget(node=joint, path=path))
        )

    # neighbours in one half of the sphere, so that viewers that interpolate carelessly do it right too
    turns = _single(quaternion.as_scalar_last(quaternion.continuous(motion.rotations)))
    turns /= np.linalg.norm(turns, axis=-1, keepdims=True)
    channel(0, "translation", _single(motion.root_positions), "VEC3")
    for j in range(motion.skeleton.joint_count):
        channel(j, "rotation", turns[:, j], "VEC4")
    shifts = motion.joint_translations
    shifting: dict[int, int] = {}
    if shifts is not None:
        for j in range(1, motion.skeleton.joint_count):
            if np.abs(shifts[:, j] - motion.skeleton.offsets[j]).max() > _STILL:
                channel(j, "translation", _single(shifts[:, j]), "VEC3")
                shifting[j] = len(out.samplers) - 1
    if body is None:
        return out
    # half the length will do for what is only to be looked at
    helped = np.rint(quaternion.as_scalar_last(body.helper_rotations(motion.rotations)) * 32767.0).astype("<i2")
    for node, helper in enumerate(body.helpers, motion.skeleton.joint_count):
        channel(node, "rotation", helped[:, node - motion.skeleton.joint_count], "VEC4")
        if helper.joint in shifting:
            target = AnimationChannelTarget(node=node, path="translation")
            out.channels.append(AnimationChannel(sampler=shifting[helper.joint], target=target))
    return out


def _single(values: Array) -> NDArray[np.float32]:
    return np.asarray(values).astype("<f4")


FORMAT: Final = Format(
    name="gltf",
    title="glTF",
    suffixes=(".glb", ".gltf"),
    sniff=sniff,
    read=gltf_reading.read,
    write=write,
    on_soles=write,
)
