"""The performer's body: human proportions on a skeleton whose joints are the 15 links, one to one.

Lengths are fractions of the body height H after Drillis & Contini (1966), as printed in Winter, *Biomechanics and Motor
Control of Human Movement* (4th ed. 2009), Fig. 4.1. The table measures to the skin and has no vertebrae; what it leaves
open is ours and marked so in `PROPORTIONS`.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType
from typing import Final

import numpy as np
from numpy.typing import NDArray

from kinesics.body.skeleton import EndSite, Skeleton
from kinesics.errors import InputError

Array = NDArray[np.float64]

PROPORTIONS: Final = MappingProxyType(
    {
        "ankle_height": 0.039,
        "shank": 0.246,
        "thigh": 0.245,
        "foot": 0.152,
        "shoulder_height": 0.818,
        "upper_arm": 0.186,
        "forearm": 0.146,
        "hand": 0.108,
        "chin_height": 0.870,
        # Ours: the table's .0955 and .129 reach to the trochanter and the acromion; the joints' centres lie further in.
        "hip_half_width": 0.052,
        "shoulder_half_width": 0.100,
        # Ours: the pelvis bone, and the trunk in three pieces of nearly equal length.
        "hip_drop": 0.020,
        "lumbar": 0.030,
        "spine": 0.080,
        "thorax": 0.080,
        "heel_behind_ankle": 0.036,
        "toe_length": 0.040,
    }
)
"""Segment lengths as fractions of body height."""

_SIDE_JOINTS: Final = ("Shoulder", "Arm", "ForeArm", "Hand", "UpLeg", "Leg", "Foot", "ToeBase")
_AXIAL_JOINTS: Final = ("Hips", "LowerBack", "Spine", "Spine1", "Neck", "Neck1", "Head")

JOINT_NAMES: Final[tuple[str, ...]] = _AXIAL_JOINTS + tuple(
    f"{side}{part}" for side in ("Left", "Right") for part in _SIDE_JOINTS
)
"""Joints of the performer's skeleton, parents before children."""

JOINT: Final = MappingProxyType({name: index for index, name in enumerate(JOINT_NAMES)})
"""Joint name to index."""

LINK_JOINTS: Final[tuple[int, ...]] = tuple(
    JOINT[name]
    for name in (
        *_AXIAL_JOINTS,
        "LeftUpLeg",
        "LeftLeg",
        "LeftArm",
        "LeftForeArm",
        "RightUpLeg",
        "RightLeg",
        "RightArm",
        "RightForeArm",
    )
)
"""Index of the joint that carries each of the 15 links of `kinesics.vocabulary.LINKS`."""


def _parent_of(name: str) -> int:
    """Index of a joint's parent; −1 for the root."""
    if name in _AXIAL_JOINTS:
        place = _AXIAL_JOINTS.index(name)
        return place - 1
    side = "Left" if name.startswith("Left") else "Right"
    part = name[len(side) :]
    if part == "Shoulder":
        return JOINT["Spine1"]
    if part == "UpLeg":
        return JOINT["Hips"]
    return JOINT[side + _SIDE_JOINTS[_SIDE_JOINTS.index(part) - 1]]


PARENTS: Final[tuple[int, ...]] = tuple(_parent_of(name) for name in JOINT_NAMES)
"""Index of each joint's parent; −1 for the root."""


@dataclass(frozen=True)
class ContactPoint:
    """A point of the body that may touch the ground."""

    joint: int
    """The joint whose bone carries it."""
    offset: tuple[float, float, float]
    """In the frame of that joint, metres."""
    radius: float
    """Metres of flesh between it and the skin."""


@dataclass(frozen=True)
class Body:
    """A body of human proportions, the same for all sexes.

    Parameters
    ----------
    height : metres, .5 to 2.5.
    arms, legs : factors on the length of the arms and legs, .5 to 1.5 (the body's height then changes with the legs).

    Raises
    ------
    InputError
        If a value is out of range.
    """

    height: float = 1.75
    arms: float = 1.0
    legs: float = 1.0

    def __post_init__(self) -> None:
        """Check the ranges."""
        for label, value, low, high in (
            ("height", self.height, 0.5, 2.5),
            ("arms", self.arms, 0.5, 1.5),
            ("legs", self.legs, 0.5, 1.5),
        ):
            if not (np.isfinite(value) and low <= value <= high):
                raise InputError(f"Expected `{label}` of a body between {low} and {high}, got {value}.")

    @cached_property
    def leg_length(self) -> float:
        """Hip to sole, metres."""
        p = PROPORTIONS
        return self.height * (self.legs * (p["thigh"] + p["shank"]) + p["ankle_height"])

    @cached_property
    def skeleton(self) -> Skeleton:
        """The skeleton; all rotations zero is the T-pose facing +z, palms down, left along +x."""
        p = PROPORTIONS
        h = self.height
        arm, leg = h * self.arms, h * self.legs
        hip_height = p["ankle_height"] + p["shank"] + p["thigh"]
        thorax_height = hip_height + p["hip_drop"] + p["lumbar"] + p["spine"] + p["thorax"]
        shoulder_rise = p["shoulder_height"] - thorax_height
        neck_rise = shoulder_rise + 0.007
        neck = (p["chin_height"] - thorax_height - neck_rise) / 2.0
        offsets: dict[str, tuple[float, float, float]] = {
            "Hips": (0.0, 0.0, 0.0),
            "LowerBack": (0.0, h * p["lumbar"], 0.0),
            "Spine": (0.0, h * p["spine"], 0.0),
            "Spine1": (0.0, h * p["thorax"], 0.0),
            "Neck": (0.0, h * neck_rise, 0.0),
            "Neck1": (0.0, h * neck, 0.0),
            "Head": (0.0, h * neck, 0.0),
            "LeftShoulder": (h * 0.015, h * shoulder_rise, 0.0),
            "LeftArm": (h * (p["shoulder_half_width"] - 0.015), 0.0, 0.0),
            "LeftForeArm": (arm * p["upper_arm"], 0.0, 0.0),
            "LeftHand": (arm * p["forearm"], 0.0, 0.0),
            "LeftUpLeg": (h * p["hip_half_width"], -h * p["hip_drop"], 0.0),
            "LeftLeg": (0.0, -leg * p["thigh"], 0.0),
            "LeftFoot": (0.0, -leg * p["shank"], 0.0),
            "LeftToeBase": (0.0, -h * p["ankle_height"], h * self._ball_reach),
        }
        for name in JOINT_NAMES:
            if name.startswith("Right"):
                x, y, z = offsets["Left" + name[5:]]
                offsets[name] = (-x, y, z)
        hand = arm * p["hand"]
        sites = (
            EndSite(JOINT["Head"], (0.0, h * (1.0 - p["chin_height"]), 0.0)),
            EndSite(JOINT["LeftHand"], (hand, 0.0, 0.0)),
            EndSite(JOINT["RightHand"], (-hand, 0.0, 0.0)),
            EndSite(JOINT["LeftToeBase"], (0.0, 0.0, h * p["toe_length"])),
            EndSite(JOINT["RightToeBase"], (0.0, 0.0, h * p["toe_length"])),
        )
        return Skeleton(
            joint_names=JOINT_NAMES,
            parents=PARENTS,
            offsets=np.array([offsets[name] for name in JOINT_NAMES]),
            end_sites=sites,
            name="kinesics performer",
        )

    @property
    def _ball_reach(self) -> float:
        p = PROPORTIONS
        return p["foot"] - p["heel_behind_ankle"] - p["toe_length"]

    @cached_property
    def foot_points(self) -> tuple[ContactPoint, ...]:
        """Heel, ball and toe of both feet: left three, then right three."""
        p = PROPORTIONS
        h = self.height
        points: list[ContactPoint] = []
        for side in ("Left", "Right"):
            foot, toe = JOINT[side + "Foot"], JOINT[side + "ToeBase"]
            points.append(ContactPoint(foot, (0.0, -h * p["ankle_height"], -h * p["heel_behind_ankle"]), 0.0))
            points.append(ContactPoint(toe, (0.0, 0.0, 0.0), 0.0))
            points.append(ContactPoint(toe, (0.0, 0.0, h * p["toe_length"]), 0.0))
        return tuple(points)

    @cached_property
    def contact_points(self) -> tuple[ContactPoint, ...]:
        """All points that may touch the ground: the feet first, then wrists, fingertips, knees, elbows and pelvis."""
        h = self.height
        points = list(self.foot_points)
        for side, sign in (("Left", 1.0), ("Right", -1.0)):
            hand = sign * h * self.arms * PROPORTIONS["hand"]
            points.append(ContactPoint(JOINT[side + "Hand"], (0.0, 0.0, 0.0), 0.015 * h))
            points.append(ContactPoint(JOINT[side + "Hand"], (hand, 0.0, 0.0), 0.006 * h))
            points.append(ContactPoint(JOINT[side + "Leg"], (0.0, 0.0, 0.0), 0.025 * h))
            points.append(ContactPoint(JOINT[side + "ForeArm"], (0.0, 0.0, 0.0), 0.02 * h))
        points.append(ContactPoint(JOINT["Hips"], (0.0, 0.0, 0.0), 0.05 * h))
        return tuple(points)
