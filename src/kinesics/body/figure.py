"""A human figure on any humanoid skeleton: one closed surface and how it hangs on the joints.

The template (figure_template.py) is fitted to a skeleton's own bone lengths, left and right apart, in the *binding pose*
(figure_fitting.py): the T-pose with the arms let down by 45°, from which shoulders have the least way to go in ordinary
movement. Vertices then follow the joints, and helpers that stand at them (figure_skin.py), by linear blend skinning
(Magnenat-Thalmann, Laperrière, Thalmann 1988), as glTF prescribes it.

Fingers are part of the hand, and each hand is one rigid piece. Feet are bound as they stand flat, where their soles are known: how
a skeleton rests says little of that.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinesics.body import kinematics
from kinesics.body.feet import Soles
from kinesics.body.figure_fitting import ARMS_DOWN, ankle_height, binding_pose, body_size, fitted, landmarks
from kinesics.body.figure_skin import (
    MOST_JOINTS,
    Helper,
    heaviest,
    helpers_of,
    joint_weights,
    share_of,
    swing_and_twist,
)
from kinesics.body.figure_template import SIDES, mannequin
from kinesics.body.motion import Motion
from kinesics.body.skeleton import Skeleton
from kinesics.errors import SkeletonError
from kinesics.geometry import quaternion

__all__ = ["ARMS_DOWN", "MOST_JOINTS", "Figure", "Helper", "fit"]

Array = NDArray[np.float64]
Indices = NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class Figure:
    """A surface bound to the joints of a skeleton, and to helpers that stand at them."""

    vertices: Array
    """In the binding pose, standing on y = 0 and facing +z, metres, shape (vertices, 3)."""
    normals: Array
    """Outward, of length 1, shape (vertices, 3)."""
    triangles: Indices
    """Counter-clockwise seen from outside, shape (triangles, 3)."""
    joints: Indices
    """That a vertex follows, shape (vertices, 4); numbers from the skeleton's joint count on are helpers."""
    weights: Array
    """Of these joints, falling, with sum 1; 0 where a vertex follows fewer than four. Shape (vertices, 4)."""
    joint_parents: tuple[int, ...]
    """Of the skeleton."""
    partner: Indices
    """Of each vertex, on the other side of the body; itself on the midline. Shape (vertices,)."""
    bind_rotations: Array
    """World orientations of the joints in the binding pose, then of the helpers, shape (joints + helpers, 4)."""
    bind_positions: Array
    """World positions of the joints in the binding pose, then of the helpers, metres, shape (joints + helpers, 3)."""
    helpers: tuple[Helper, ...]

    def helper_rotations(self, rotations: Array) -> Array:
        """Of the helpers from the parents of their joints.

        Parameters
        ----------
        rotations : of the joints from their parents, shape (frames, joints, 4).

        Returns
        -------
        Of shape (frames, helpers, 4). Twists are followed from frame to frame, beyond half a turn, too, so that nothing jumps. A
        share of a swing is undefined only where a bone points the opposite way of the binding pose.
        """
        out = np.empty((len(rotations), len(self.helpers), 4))
        parts: dict[int, tuple[Array, Array]] = {}
        for k, helper in enumerate(self.helpers):
            j = helper.joint
            if j not in parts:
                parent = self.bind_rotations[self.joint_parents[j]]
                bound = quaternion.multiply(quaternion.conjugate(self.bind_rotations[j]), parent)
                parts[j] = swing_and_twist(quaternion.multiply(rotations[:, j], bound), helper.axis)
            swing, twist = parts[j]
            out[:, k] = quaternion.multiply(
                share_of(swing, helper.swing), quaternion.from_axis_angle(helper.axis, helper.twist * twist)
            )
        return out

    def posed(self, motion: Motion) -> Array:
        """Where the vertices are in every frame, metres, shape (frames, vertices, 3)."""
        pose = kinematics.forward(motion.skeleton, motion.rotations, motion.root_positions, motion.joint_translations)
        at = [h.joint for h in self.helpers]
        above = [self.joint_parents[j] for j in at]
        helped = quaternion.multiply(pose.rotations[:, above], self.helper_rotations(motion.rotations))
        turn = quaternion.multiply(
            np.concatenate([pose.rotations, helped], axis=1), quaternion.conjugate(self.bind_rotations)
        )
        matrices = quaternion.as_matrix(turn)
        places = np.concatenate([pose.positions, pose.positions[:, at]], axis=1)
        shifts = places - np.einsum("fjab,jb->fja", matrices, self.bind_positions)
        out = np.zeros((motion.frame_count, len(self.vertices), 3))
        for k in range(MOST_JOINTS):
            j, w = self.joints[:, k], self.weights[:, k]
            for frame, (m, s) in enumerate(zip(matrices, shifts, strict=True)):
                out[frame] += w[:, None] * (np.einsum("vab,vb->va", m[j], self.vertices) + s[j])
        return out


def fit(skeleton: Skeleton, offsets: Array | None = None, soles: Soles | None = None) -> Figure:
    """The figure on a skeleton.

    Parameters
    ----------
    skeleton : one that carries its anatomy (`kinesics.body.anatomy.understood`).
    offsets : of the joints from their parents, metres, shape (joints, 3), where they are not the skeleton's.
    soles : of the body (`kinesics.body.contacts`): the figure's own lie where these do as the feet stand flat. Without them
        feet are taken to stand as they rest.

    Raises
    ------
    SkeletonError
        If the skeleton is not understood as a human body, or its bones have no length.
    """
    body = skeleton.anatomy
    if body is None:
        raise SkeletonError("A figure needs a human body, and this skeleton is not understood as one.")
    offsets = skeleton.offsets if offsets is None else offsets
    template = mannequin()
    rotations, positions = binding_pose(skeleton, body, offsets, soles)
    marks = landmarks(skeleton, body, rotations, positions, soles)
    size = body_size(marks)
    sole = min(marks[f"{side}_ankle"][1] - ankle_height(marks, side, size) for side in SIDES)
    middle = marks["hips"]
    shift = -np.array([middle[0], sole, middle[2]])
    positions = positions + shift
    marks = {name: point + shift for name, point in marks.items()}

    vertices = fitted(template, marks, size)
    helpers = helpers_of(skeleton, body, rotations, marks)
    joints, weights = heaviest(joint_weights(template, skeleton, body, helpers, vertices, positions, marks, size))
    return Figure(
        vertices=vertices,
        normals=_normals(vertices, template.triangles),
        triangles=template.triangles,
        joints=joints,
        weights=weights,
        joint_parents=tuple(skeleton.parents),
        partner=template.partner,
        bind_rotations=np.concatenate([rotations, rotations[[skeleton.parents[h.joint] for h in helpers]]]),
        bind_positions=np.concatenate([positions, positions[[h.joint for h in helpers]]]),
        helpers=helpers,
    )


def _normals(vertices: Array, triangles: Indices) -> Array:
    """Means of the triangles' normals, by area."""
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    flat = np.repeat(np.cross(b - a, c - a), 3, axis=0)
    corners = triangles.ravel()
    out = np.stack([np.bincount(corners, flat[:, k], len(vertices)) for k in range(3)], axis=1)
    length = np.linalg.norm(out, axis=1, keepdims=True)
    return np.asarray(out / np.where(length > 0.0, length, 1.0))
