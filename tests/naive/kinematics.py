"""Forward kinematics by 4×4 matrices and loops: slow and obvious ([Schultz2012] §2.3, §2.6)."""

from __future__ import annotations

import numpy as np


def rotation_matrix(q):
    """3×3 of a unit quaternion (w, x, y, z)."""
    w, x, y, z = q
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def transform(q, shift):
    """The homogeneous matrix g: first turn, then shift."""
    g = np.eye(4)
    g[:3, :3] = rotation_matrix(q)
    g[:3, 3] = shift
    return g


def forward(parents, offsets, rotations, root_positions, joint_translations=None):
    """World transforms g(0, n) = g(0, 1) … g(n−1, n) of all joints, shape (frames, joints, 4, 4)."""
    frames = []
    for f in range(len(rotations)):
        world = []
        for joint, parent in enumerate(parents):
            if parent < 0:
                world.append(transform(rotations[f][joint], root_positions[f]))
            else:
                shift = offsets[joint] if joint_translations is None else joint_translations[f][joint]
                world.append(world[parent] @ transform(rotations[f][joint], shift))
        frames.append(world)
    return np.array(frames)
