"""Linear blend skinning as the definition says it: one vertex, one joint, one matrix at a time."""

from __future__ import annotations

import numpy as np

from kinesics.geometry import quaternion


def placed(rotation, position):
    """The 4 × 4 matrix of a turn and a place."""
    out = np.eye(4)
    out[:3, :3] = quaternion.as_matrix(rotation)
    out[:3, 3] = position
    return out


def world_matrices(skeleton, rotations, root, shifts=None):
    """Of all joints in one frame, by going down the tree."""
    out = []
    for j, parent in enumerate(skeleton.parents):
        place = root if parent < 0 else (skeleton.offsets[j] if shifts is None else shifts[j])
        own = placed(rotations[j], place)
        out.append(own if parent < 0 else out[parent] @ own)
    return out


def skinned(vertex, joints, weights, inverse_binds, matrices):
    """Where one vertex is: Σ w · world · bind⁻¹ · v."""
    v = np.append(vertex, 1.0)
    out = np.zeros(4)
    for joint, weight in zip(joints, weights, strict=True):
        out += weight * (matrices[joint] @ (inverse_binds[joint] @ v))
    return out[:3]
