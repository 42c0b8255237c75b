"""Postures as anatomical angles, and from angles to joint rotations.

A posture is a vector of `ANGLES` (radians; ``plant`` is a weight). The mirror is linear there: left and right change
places and the angles out of the sagittal plane change sign (`mirror`). Every joint rotation of the right side is made by
the formula of the left and reflected, so a symmetry of the angles is the same symmetry of the quaternions to the last bit
that matters ([Schultz2012] §2.10).

Signs: ``bend`` and ``pitch`` forward, ``twist`` and ``yaw`` to the left, ``lean`` and ``roll`` to the right; ``hip_flex``
and ``shoulder_flex`` forward, ``abduct`` and ``elevate`` outward and upward, ``knee`` and ``elbow`` bend as they can,
``ankle`` lifts the toes, ``wrist`` lifts the back of the hand.
"""

from __future__ import annotations

from types import MappingProxyType
from typing import Final

import numpy as np
from numpy.typing import NDArray

from kinesics.errors import InputError
from kinesics.geometry import quaternion
from kinesics.performer.body import JOINT, JOINT_NAMES, LINK_JOINTS

Array = NDArray[np.float64]

_AXIAL_LINKS: Final = ("lowerback", "upperback", "thorax", "lowerneck", "upperneck", "head")
_LIMB_ANGLES: Final = (
    "hip_flex",
    "hip_abduct",
    "hip_rotate",
    "knee",
    "ankle",
    "plant",
    "shoulder_flex",
    "shoulder_horizontal",
    "shoulder_elevate",
    "shoulder_twist",
    "elbow",
    "pronate",
    "wrist",
)

ANGLES: Final[tuple[str, ...]] = (
    "pelvis_pitch",
    "pelvis_yaw",
    "pelvis_roll",
    *(f"{link}_{kind}" for link in _AXIAL_LINKS for kind in ("bend", "twist", "lean")),
    *(f"left_{name}" for name in _LIMB_ANGLES),
    *(f"right_{name}" for name in _LIMB_ANGLES),
)
"""Names of the entries of a posture.

``plant`` is no angle: at 1 ``ankle`` is the pitch of the sole against the floor (0: flat on it), at 0 that of the foot
against the shank."""

ANGLE: Final = MappingProxyType({name: index for index, name in enumerate(ANGLES)})
"""Name to index."""

_SPREAD: Final = {
    "trunk": ("lowerback", "upperback", "thorax"),
    "neck": ("lowerneck", "upperneck", "head"),
}

_AXIAL_COUNT: Final = 3 + 3 * len(_AXIAL_LINKS)
_LIMB_COUNT: Final = len(_LIMB_ANGLES)

_MIRROR_ORDER: Final = np.concatenate(
    [
        np.arange(_AXIAL_COUNT),
        np.arange(_AXIAL_COUNT + _LIMB_COUNT, _AXIAL_COUNT + 2 * _LIMB_COUNT),
        np.arange(_AXIAL_COUNT, _AXIAL_COUNT + _LIMB_COUNT),
    ]
)
_MIRROR_SIGN: Final = np.concatenate([np.tile([1.0, -1.0, -1.0], _AXIAL_COUNT // 3), np.ones(2 * _LIMB_COUNT)])


def posture(base: Array | None = None, **degrees: float) -> Array:
    """A posture from angles in degrees, shape (angles,), radians.

    ``left_knee=30`` sets one angle, ``knee=30`` both sides, ``trunk_bend=30`` spreads over the three links of the trunk,
    ``neck_twist=30`` over those of the neck and head, ``plant`` is a weight in [0, 1]. What is not
    named is as in ``base`` (the T-pose with planted feet).

    Raises
    ------
    InputError
        If a name is not an angle of the body; the message lists those there are.
    """
    out = T_POSE.copy() if base is None else np.array(base, dtype=np.float64)
    for name, value in degrees.items():
        amount = float(value) if name.endswith("plant") else np.deg2rad(float(value))
        entries, share = entries_of(name)
        out[entries] = amount * share
    return out


def entries_of(name: str) -> tuple[list[int], float]:
    """Which entries a name means, and what share of its value each takes. Names as in `posture`.

    Raises
    ------
    InputError
        If the name is unknown.
    """
    part, _, kind = name.partition("_")
    if name in ANGLE:
        return [ANGLE[name]], 1.0
    if name in _LIMB_ANGLES:
        return [ANGLE[f"left_{name}"], ANGLE[f"right_{name}"]], 1.0
    if part in _SPREAD and kind in ("bend", "twist", "lean"):
        return [ANGLE[f"{link}_{kind}"] for link in _SPREAD[part]], 1.0 / len(_SPREAD[part])
    raise InputError(f"The body has no angle '{name}'. Angles: {', '.join(ANGLES)}.")


def mirror(angles: Array) -> Array:
    """The mirror image of postures, shape (..., angles)."""
    return np.asarray(angles[..., _MIRROR_ORDER] * _MIRROR_SIGN)


def _turn(axis: int, angle: Array) -> Array:
    """Quaternions about a coordinate axis, shape (n,) to (n, 4)."""
    q = np.zeros((*angle.shape, 4))
    q[..., 0] = np.cos(angle / 2.0)
    q[..., 1 + axis] = np.sin(angle / 2.0)
    return q


def _product(*factors: Array) -> Array:
    out = factors[0]
    for factor in factors[1:]:
        out = quaternion.multiply(out, factor)
    return out


def _foot(shank_world: Array, ankle: Array, plant: Array) -> tuple[Array, Array]:
    """Rotations of foot and toes relative to their parents, given the shank's orientation without the heading."""
    split = quaternion.swing_twist(shank_world, np.array([0.0, 1.0, 0.0]))
    # the sole keeps the shank's direction over the ground and takes its pitch from `ankle`
    level = _product(quaternion.conjugate(shank_world), split.twist, _turn(0, -ankle))
    hanging = _turn(0, -ankle)
    foot = quaternion.slerp(hanging, level, plant)
    raised = -ankle * plant
    # the toes stay on the floor while the heel is up: a smooth max(0, raised), up to what toes can do
    softness = np.deg2rad(3.0)
    lifted = np.where(raised > 0.0, raised, 0.0) + softness * np.log1p(np.exp(-np.abs(raised) / softness))
    lifted -= softness * np.log(2.0)
    limit = np.deg2rad(55.0)
    return foot, _turn(0, -limit * np.tanh(np.maximum(lifted, 0.0) / limit))


def joint_rotations(angles: Array) -> Array:
    """Rotations of all joints relative to their parents, the body facing +z. Shape (n, angles) to (n, joints, 4)."""
    count = len(angles)
    out = quaternion.identity((count, len(JOINT_NAMES)))

    def axial(first: int, joint: int) -> None:
        pitch, yaw, roll = angles[:, first], angles[:, first + 1], angles[:, first + 2]
        out[:, joint] = quaternion.from_rotvec(np.stack([pitch, yaw, roll], axis=-1))

    out[:, 0] = _product(_turn(1, angles[:, 1]), _turn(0, angles[:, 0]), _turn(2, angles[:, 2]))
    for k in range(len(_AXIAL_LINKS)):
        axial(3 + 3 * k, k + 1)

    for side, first in (("Left", _AXIAL_COUNT), ("Right", _AXIAL_COUNT + _LIMB_COUNT)):
        a = dict(zip(_LIMB_ANGLES, angles[:, first : first + _LIMB_COUNT].T, strict=True))
        thigh = _product(_turn(0, -a["hip_flex"]), _turn(2, a["hip_abduct"]), _turn(1, a["hip_rotate"]))
        shank = _turn(0, a["knee"])
        pelvis = out[:, 0] if side == "Left" else quaternion.mirror(out[:, 0])
        foot, toe = _foot(_product(pelvis, thigh, shank), a["ankle"], a["plant"])
        arm = _product(
            _turn(0, -a["shoulder_flex"]),
            _turn(1, -a["shoulder_horizontal"]),
            _turn(2, a["shoulder_elevate"]),
            _turn(0, a["shoulder_twist"]),
        )
        forearm = _product(_turn(1, -a["elbow"]), _turn(0, a["pronate"]))
        hand = _turn(2, a["wrist"])
        parts = {
            "UpLeg": thigh,
            "Leg": shank,
            "Foot": foot,
            "ToeBase": toe,
            "Arm": arm,
            "ForeArm": forearm,
            "Hand": hand,
        }
        for part, q in parts.items():
            out[:, JOINT[side + part]] = q if side == "Left" else quaternion.mirror(q)
    return out


def link_quaternions(rotations: Array) -> Array:
    """The 15 links' quaternions, the pelvis's yaw removed. Shape (n, joints, 4) to (n, 15, 4).

    Knee and elbow are hinges (§2.7): what they turn about the bone below them is no part of the pose.
    """
    out = rotations[:, list(LINK_JOINTS)].copy()
    out[:, 0] = quaternion.yaw_tilt(out[:, 0]).tilt
    for link, bone in ((8, (0.0, 1.0, 0.0)), (10, (1.0, 0.0, 0.0)), (12, (0.0, 1.0, 0.0)), (14, (1.0, 0.0, 0.0))):
        out[:, link] = quaternion.swing_twist(out[:, link], np.array(bone)).swing
    return out


def pose(angles: Array) -> Array:
    """The pose of postures: unit quaternions in the order of `kinesics.vocabulary.LINKS`. (..., angles) to (..., 15, 4)."""
    flat = np.asarray(angles, dtype=np.float64).reshape(-1, len(ANGLES))
    return link_quaternions(joint_rotations(flat)).reshape(*np.shape(angles)[:-1], 15, 4)


T_POSE: Final[Array] = np.zeros(len(ANGLES))
T_POSE[[ANGLE["left_plant"], ANGLE["right_plant"]]] = 1.0
T_POSE.setflags(write=False)

STANDING: Final[Array] = posture(
    shoulder_elevate=-79.0,
    elbow=14.0,
    shoulder_flex=2.0,
    pronate=-10.0,
    knee=4.0,
    hip_flex=3.0,
    hip_abduct=2.0,
    hip_rotate=5.0,
)
"""At ease, arms hanging."""
STANDING.setflags(write=False)
