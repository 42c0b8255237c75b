"""Poses: the 15 quaternions of the anatomical model, their mirror image, their symmetric and antisymmetric parts.

[Schultz2012] §2.8-2.12. The pose is intrinsic: yaw about gravity and place on the ground are kept beside it.
"""

from __future__ import annotations

import dataclasses
import operator
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple, SupportsIndex, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinesics.body import anatomy as _anatomy
from kinesics.body.motion import Motion
from kinesics.errors import InputError
from kinesics.geometry import quaternion
from kinesics.vocabulary import MIRROR_LINKS

Array = NDArray[np.float64]


class SymmetryParts(NamedTuple):
    """Ψ = S + A with W S = S and W A = −A (§2.11)."""

    symmetric: Array
    """Shape (frames, 15, 4)."""
    antisymmetric: Array
    """Shape (frames, 15, 4)."""


@dataclass(frozen=True, eq=False)
class PoseSequence:
    """A motion path: one pose a frame, in anatomical frames.

    Raises
    ------
    InputError
        If shapes disagree or a value is not finite.
    """

    quaternions: Array
    """Unit quaternions (w, x, y, z) of the links in the order of `kinesics.vocabulary.LINKS`, shape (frames, 15, 4).

    The identity of every link is the T-pose facing +z, palms down. Link 0 is the tilt of the pelvis against gravity, yaw
    removed. Signs mean nothing.
    """
    yaw: Array
    """Heading of the pelvis about +y, radians, 0 facing +z, shape (frames,)."""
    ground: Array
    """Place of the pelvis on the ground: x, z in metres, shape (frames, 2)."""
    fps: float
    yaw_undefined: NDArray[np.bool_] | None = None
    """True where the body is so nearly upside down that yaw has no meaning; the last heading is carried. Shape (frames,)."""
    profile: str = ""
    """How the skeleton was mapped onto the 15 links; D between differently mapped bodies is less exact."""
    assumptions: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Check shapes once."""
        q = np.ascontiguousarray(self.quaternions, dtype=np.float64)
        if q.ndim != 3 or q.shape[1:] != (15, 4) or len(q) == 0:
            raise InputError(f"Expected `quaternions` of shape (frames, 15, 4), got {q.shape}.")
        if not np.isfinite(q).all():
            raise InputError("`quaternions` are not finite.")
        norm = np.einsum("fji,fji->fj", q, q)
        if not np.all(np.abs(norm - 1.0) < 1e-6):
            raise InputError("Expected unit `quaternions`.")
        object.__setattr__(self, "quaternions", q)
        frames = len(q)
        for label, width in (("yaw", ()), ("ground", (2,))):
            values = np.ascontiguousarray(getattr(self, label), dtype=np.float64)
            if values.shape != (frames, *width):
                raise InputError(f"Expected `{label}` of shape {(frames, *width)}, got {values.shape}.")
            if not np.isfinite(values).all():
                raise InputError(f"`{label}` is not finite.")
            object.__setattr__(self, label, values)
        if self.yaw_undefined is None:
            object.__setattr__(self, "yaw_undefined", np.zeros(frames, dtype=np.bool_))

    def __len__(self) -> int:
        """How many frames."""
        return len(self.quaternions)

    @property
    def frame_count(self) -> int:
        """How many frames."""
        return len(self.quaternions)

    @property
    def gravity(self) -> Array:
        """Direction of gravity in the frame of the pelvis, unit vectors, shape (frames, 3): (0, −1, 0) standing."""
        return gravity(self.quaternions)

    @overload
    def __getitem__(self, item: slice) -> PoseSequence: ...
    @overload
    def __getitem__(self, item: SupportsIndex) -> PoseSequence: ...
    def __getitem__(self, item: slice | SupportsIndex) -> PoseSequence:
        """Frames ``[start:end]``; a step divides the frame rate, a negative one plays backwards; one index gives one frame.

        Raises
        ------
        InputError
            If no frame is left.
        IndexError
            If there is no such frame.
        """
        if not isinstance(item, slice):
            wanted = operator.index(item)
            index = wanted + len(self) if wanted < 0 else wanted
            if not 0 <= index < len(self):
                raise IndexError(f"Frame {wanted} of a path of {len(self)} frames.")
            item = slice(index, index + 1)
        elif not range(len(self))[item]:
            raise InputError(f"No frame is left of {len(self)} by [{item.start}:{item.stop}].")
        step = abs(item.step) if item.step else 1
        assert self.yaw_undefined is not None
        return dataclasses.replace(
            self,
            quaternions=self.quaternions[item],
            yaw=self.yaw[item],
            ground=self.ground[item],
            yaw_undefined=self.yaw_undefined[item],
            fps=self.fps / step,
        )

    def mirror(self) -> PoseSequence:
        """The mirrored path WΨ(t): left and right change places, yaw and x change sign (§2.10)."""
        return dataclasses.replace(
            self,
            quaternions=mirror(self.quaternions),
            yaw=-self.yaw,
            ground=self.ground * np.array([-1.0, 1.0]),
        )

    def parts(self) -> SymmetryParts:
        """Symmetric and antisymmetric parts (§2.11)."""
        return symmetry_parts(self.quaternions)


def poses(motion: Motion, mapping: Mapping[str, object] | None = None) -> PoseSequence:
    """The poses of a motion in the anatomical frames of the 15 links.

    Parameters
    ----------
    motion : of any humanoid skeleton.
    mapping : joint names by the user, as read from a mapping file (see `kinesics.body.anatomy.resolve`).

    Raises
    ------
    SkeletonError
        If the skeleton cannot be understood as a human body; it lists what was found and what is missing.
    """
    body = _anatomy.resolve(motion, mapping)
    world = motion.global_rotations()
    links = _anatomy.link_rotations(body, world)
    split = quaternion.yaw_tilt(links[:, 0])
    links[:, 0] = split.tilt
    pelvis = motion.positions()[:, body.pelvis]
    return PoseSequence(
        quaternions=links,
        yaw=_carry(split.yaw, split.singular),
        ground=pelvis[:, [0, 2]],
        fps=motion.fps,
        yaw_undefined=split.singular,
        profile=body.profile,
        assumptions=body.assumptions,
    )


def check_alike(sequences: Sequence[PoseSequence], names: Sequence[str]) -> None:
    """Refuse to compare bodies whose upper arms are told relative to different bones.

    Longer and shorter spines are spread over the same links. But with the clavicle composed an upper arm is told from the chest,
    with it dropped from the clavicle (§2.16): the same pose would be far from itself, and nothing in the numbers shows why.

    Parameters
    ----------
    names : of the recordings, for the message.

    Raises
    ------
    InputError
        If one has the clavicle composed and another has it dropped. Poses whose ``profile`` does not say are let pass.
    """
    by_rule = {
        rule: next((name for p, name in zip(sequences, names, strict=True) if p.profile.endswith(rule)), None)
        for rule in ("clavicle compose", "clavicle drop")
    }
    composed, dropped = by_rule.values()
    if composed is not None and dropped is not None:
        raise InputError(
            f"'{composed}' has the clavicle composed with the upper arm, '{dropped}' has it dropped: their poses cannot be "
            'compared. Read both with the same clavicle = "compose" or "drop" in the mapping.'
        )


def mirror(quaternions: ArrayLike) -> Array:
    """The operator W of §2.10 on whole bodies: w on every link, left and right swapped. Shape (..., 15, 4)."""
    return quaternion.mirror(np.asarray(quaternions, dtype=np.float64)[..., list(MIRROR_LINKS), :])


def gravity(quaternions: ArrayLike) -> Array:
    """Direction of gravity in the frame of the pelvis. Shape (..., 15, 4) to (..., 3), unit vectors."""
    root = np.asarray(quaternions, dtype=np.float64)[..., 0, :]
    return quaternion.rotate(quaternion.conjugate(root), np.array([0.0, -1.0, 0.0]))


def symmetry_parts(quaternions: ArrayLike) -> SymmetryParts:
    """S = (Ψ + WΨ)/2 and A = (Ψ − WΨ)/2, signs chosen so that q·(Wq) ≥ 0 for each axial link and left-right pair.

    The root is first turned about gravity so that it is as near its own mirror image as it can be (D knows only its tilt).
    Then D*(a, a) = 2·mean|A|² exactly. Shape (..., 15, 4).
    """
    q = np.array(quaternions, dtype=np.float64)
    w, x, z = q[..., 0, 0], q[..., 0, 1], q[..., 0, 3]
    # q·(wq) for yaw ψ is cos ψ (w² + x² − z²) + sin ψ (2xz): greatest at this angle
    half = 0.5 * np.arctan2(2.0 * x * z, w * w + x * x - z * z)
    zero = np.zeros_like(half)
    q[..., 0, :] = quaternion.multiply(np.stack([np.cos(half), zero, np.sin(half), zero], axis=-1), q[..., 0, :])
    image = mirror(q)
    for link, partner in enumerate(MIRROR_LINKS):
        if partner > link:
            negative = np.sum(q[..., link, :] * image[..., link, :], axis=-1) < 0.0
            q[..., partner, :] = np.where(negative[..., None], -q[..., partner, :], q[..., partner, :])
    image = mirror(q)
    # an axial link's own sign cancels in q·(wq); beyond a half turn it is the image that takes the other sign
    negative = np.sum(q * image, axis=-1) < 0.0
    image = np.where(negative[..., None], -image, image)
    return SymmetryParts((q + image) / 2.0, (q - image) / 2.0)


def _carry(values: Array, undefined: NDArray[np.bool_]) -> Array:
    """Carry the last defined value over undefined ones (backwards at the start)."""
    if not undefined.any() or undefined.all():
        return values
    index = np.where(undefined, -1, np.arange(len(values)))
    index = np.maximum.accumulate(index)
    first = int(np.argmax(~undefined))
    return values[np.where(index < 0, first, index)]
