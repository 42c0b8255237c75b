"""C_free: the poses a body can take, as far as a file tells ([Schultz2012] §2.9).

Not every configuration is physically possible: joints have limits and the body cannot pass through itself. `free_space`
counts both over a recording and says what it found; nothing is changed and nothing is refused.

- `kinesics.body.joint_limits`: joints beyond the limits that the file itself gives (ASF ``limits``)
- `kinesics.body.capsules`: limbs that pass through each other or through the trunk, as capsules round the bones

What either is asked for can be had from here, too.
"""

from __future__ import annotations

import re
from dataclasses import asdict, dataclass
from typing import Any, Final

from kinesics.body.capsules import (
    DEPTH_TOLERANCE,
    Capsules,
    Collision,
    Ends,
    SelfCollisions,
    capsule_radius,
    segment_distance,
    self_collisions,
)
from kinesics.body.joint_limits import JOINT_TOLERANCE, JointExcess, JointExcesses, joint_excesses
from kinesics.body.motion import Motion
from kinesics.errors import SkeletonError

__all__ = [
    "DEPTH_TOLERANCE",
    "JOINT_TOLERANCE",
    "Capsules",
    "Collision",
    "Ends",
    "FreeSpace",
    "JointExcess",
    "JointExcesses",
    "SelfCollisions",
    "capsule_radius",
    "free_space",
    "joint_excesses",
    "segment_distance",
    "self_collisions",
]

_EXTREMITY: Final = re.compile("wrist|hand|thumb|finger|toe")
"""Joints that sentences leave out: nearly every CMU recording takes some of them 10° to 60° beyond what its ASF allows, which
says nothing about the recording. `FreeSpace.excesses` has them all."""
_MOST_JOINTS: Final = 3


@dataclass(frozen=True)
class FreeSpace:
    """How far a recording stays within C_free (§2.9)."""

    frame_count: int
    joints_checked: int
    """Joints whose limits the file gives; 0 where it gives none."""
    excesses: tuple[JointExcess, ...]
    """Worst first."""
    excess_frames: int
    """Frames in which any joint is beyond a limit."""
    pairs_checked: int
    """Pairs of capsules that can collide; 0 where the skeleton is not understood as a human body."""
    collisions: tuple[Collision, ...]
    """Deepest first."""
    collision_frames: int
    """Frames in which any pair collides."""

    @property
    def sentences(self) -> tuple[str, ...]:
        """What was found, in at most three sentences."""
        out = []
        if self.joints_checked == 0:
            out.append("The file gives no joint limits.")
        elif not self.excesses:
            out.append(f"All {self.joints_checked} joints with limits stay within them.")
        else:
            out.append(self._beyond_limits())
        if self.pairs_checked == 0:
            out.append("Self-collision was not checked: the skeleton is not understood as a human body.")
        elif not self.collisions:
            out.append("No part of the body passes through another.")
        else:
            deepest = self.collisions[0]
            more = len(self.collisions) - 1
            others = f"; {more} more pair{'s' if more > 1 else ''}" if more else ""
            out.append(
                f"Parts of the body pass through each other in {self.collision_frames} of {self.frame_count} frames: most the "
                f"{deepest.first} and the {deepest.second}, {100 * deepest.worst_depth:.0f} cm deep at frame "
                f"{deepest.worst_frame}{others}."
            )
        return tuple(out)

    def _beyond_limits(self) -> str:
        """Which joints go beyond their limits, and how far; those that nearly every recording bends too far are left out."""
        worst: dict[str, JointExcess] = {}
        for excess in self.excesses:
            if not _EXTREMITY.search(excess.joint.lower()):
                worst.setdefault(excess.joint, excess)
        if not worst:
            return "Only wrists, hands, fingers or toes go beyond the file's own joint limits."
        told = [
            f"{e.joint} by up to {e.worst_degrees:.0f}° about {e.axis} (frame {e.worst_frame})" for e in worst.values()
        ]
        more = f" and {len(told) - _MOST_JOINTS} more" if len(told) > _MOST_JOINTS else ""
        return f"Beyond the file's own joint limits: {', '.join(told[:_MOST_JOINTS])}{more}."

    def to_dict(self) -> dict[str, Any]:
        """Plain values, for JSON."""
        return {**asdict(self), "sentences": list(self.sentences)} | {
            "excesses": [asdict(e) for e in self.excesses],
            "collisions": [asdict(c) for c in self.collisions],
        }


def free_space(
    motion: Motion, *, joint_tolerance: float = JOINT_TOLERANCE, depth_tolerance: float = DEPTH_TOLERANCE
) -> FreeSpace:
    """Joint limits and self-collision over a recording, counted (§2.9).

    Parameters
    ----------
    joint_tolerance : radians beyond a limit that are let pass.
    depth_tolerance : metres that two limbs may interpenetrate.

    A skeleton that is not understood as a human body is not checked for collisions; the result says so.
    """
    limited = [f for f in motion.skeleton.freedoms if f.limits]
    excesses, excess_frames = joint_excesses(motion, tolerance=joint_tolerance)
    try:
        hits = self_collisions(motion, tolerance=depth_tolerance)
    except SkeletonError:
        hits = SelfCollisions(0, (), 0)
    return FreeSpace(
        frame_count=motion.frame_count,
        joints_checked=len(limited),
        excesses=excesses,
        excess_frames=excess_frames,
        pairs_checked=hits.pairs,
        collisions=hits.collisions,
        collision_frames=hits.frames,
    )
