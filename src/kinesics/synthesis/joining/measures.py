"""What of a moment is compared across a transition: how fast the pose changes, where one goes and where the feet are."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from kinesics.body import kinematics, pose
from kinesics.body.skeleton import Skeleton
from kinesics.geometry import quaternion
from kinesics.synthesis.repertoire import Repertoire

Array = NDArray[np.float64]
Floats = NDArray[np.float32]


def pose_velocity(before: Array, after: Array, weights: Array, seconds: Array) -> Floats:
    """Velocity of the pose whose length is √(2D)/s: half the angular velocities and that of gravity, shape (frames, 45).

    Parameters
    ----------
    before, after : the 15 links at the two ends of a window, shape (frames, 15, 4).
    weights : of the links, shape (15,).
    seconds : between the two, shape (frames,).
    """
    turned = 0.5 * quaternion.as_rotvec(quaternion.multiply(quaternion.conjugate(before), after))
    turned[:, 0] = 0.5 * (pose.gravity(after) - pose.gravity(before))
    share = np.sqrt(weights / weights.sum())
    return np.asarray((turned * share[:, None] / seconds[:, None, None]).reshape(len(before), -1), dtype=np.float32)


def from_heading(vectors: Array, yaw: Array) -> Array:
    """Vectors (x, z) of the world as seen by one who faces ``yaw``: to the left, ahead."""
    sine, cosine = np.sin(yaw), np.cos(yaw)
    x, z = vectors[:, 0], vectors[:, 1]
    return np.stack([cosine * x - sine * z, sine * x + cosine * z], axis=1)


def feet_beneath(repertoire: Repertoire) -> Array:
    """Ankles and toes from the root, to the left, up, ahead as seen from the heading, metres, as recorded and mirrored.

    Shape (2, frames, 4, 3): left ankle, right ankle, left toes, right toes.
    """
    skeleton = repertoire.skeleton
    index = np.arange(repertoire.frame_count)
    out = np.zeros((2, repertoire.frame_count, 4, 3))
    points = [_foot_points(skeleton, side) for side in ("left", "right")]
    for strand in (0, 1) if repertoire.mirrored else (0,):
        roots = repertoire.root_positions[strand]
        where, world = kinematics.forward(skeleton, repertoire.rotations[strand], roots)
        yaw = repertoire.yaw_of(repertoire.moments(index, strand))
        for k, (ankle, offset) in enumerate(points):
            tip = where[:, ankle] + quaternion.rotate(world[:, ankle], offset)
            for row, place in ((k, where[:, ankle]), (k + 2, tip)):
                away = place - roots
                out[strand, :, row, [0, 2]] = from_heading(away[:, [0, 2]], yaw).T
                out[strand, :, row, 1] = away[:, 1]
    return out


def _foot_points(skeleton: Skeleton, side: str) -> tuple[int, Array]:
    """The ankle, or the knee of a leg without one, and from there to what hangs on it farthest, in its own frame."""
    assert skeleton.anatomy is not None
    ankle = getattr(skeleton.anatomy.roles, f"{side}_foot")
    if ankle is None:
        ankle = getattr(skeleton.anatomy.roles, f"{side}_tibia")
    ends = [skeleton.offsets[c] for c in skeleton.children[ankle]]
    ends += [np.asarray(site.offset) for site in skeleton.end_sites if site.parent == ankle]
    return ankle, max(ends, key=lambda v: float(np.linalg.norm(v)), default=np.zeros(3))
