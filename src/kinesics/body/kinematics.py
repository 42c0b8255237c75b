"""Forward kinematics: from joint rotations to orientations and positions in the world ([Schultz2012] §2.6).

The compiled kernel does it where it was built, NumPy elsewhere (or with ``KINESICS_NO_NATIVE=1``).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinesics import compiled
from kinesics.errors import InputError
from kinesics.geometry import quaternion

if TYPE_CHECKING:
    from kinesics.body.skeleton import Skeleton

Array = NDArray[np.float64]
Indices = NDArray[np.intp]


class Kinematics(NamedTuple):
    """Where every joint is."""

    positions: Array
    """World, metres, shape (frames, joints, 3)."""
    rotations: Array
    """World orientations, quaternions, shape (frames, joints, 4)."""


def forward(
    skeleton: Skeleton,
    rotations: Array,
    root_positions: Array,
    joint_translations: Array | None = None,
    *,
    joints: Indices | None = None,
) -> Kinematics:
    """Positions and orientations of all joints: g(0,n) = g(0,1) g(1,2) … g(n−1,n).

    Parameters
    ----------
    rotations : relative to the parents, unit quaternions (w, x, y, z), shape (frames, joints, 4).
    root_positions : metres, shape (frames, 3).
    joint_translations : metres, shape (frames, joints, 3), in place of the skeleton's offsets; entry 0 is not read.
    joints : numbers of those that are wanted, where not all are: of those that none of them hangs on nothing is computed, and
        what is returned is NaN.

    Raises
    ------
    InputError
        If shapes disagree or a number is none of a joint.

    References
    ----------
    [Schultz2012] §2.6.
    """
    q, roots, shifts = _check(skeleton, rotations, root_positions, joint_translations)
    where, world = _room(skeleton, len(q), 3, joints), _room(skeleton, len(q), 4, joints)
    _solve(skeleton, q, roots, shifts, world, where, joints)
    return Kinematics(where, world)


def positions(
    skeleton: Skeleton,
    rotations: Array,
    root_positions: Array,
    joint_translations: Array | None = None,
    *,
    joints: Indices | None = None,
) -> Array:
    """Positions alone, metres, shape (frames, joints, 3). Parameters and errors are those of `forward`."""
    q, roots, shifts = _check(skeleton, rotations, root_positions, joint_translations)
    where = _room(skeleton, len(q), 3, joints)
    _solve(skeleton, q, roots, shifts, None, where, joints)
    return where


def global_rotations(skeleton: Skeleton, rotations: Array, *, joints: Indices | None = None) -> Array:
    """World orientations of all joints from rotations relative to the parents. Shape (frames, joints, 4) to the same.

    Parameters
    ----------
    joints : as for `forward`.

    Raises
    ------
    InputError
        If the shape is not that of the skeleton, or a number is none of a joint.
    """
    q, _, _ = _check(skeleton, rotations, None, None)
    world = _room(skeleton, len(q), 4, joints)
    _solve(skeleton, q, None, None, world, None, joints)
    return world


def _check(
    skeleton: Skeleton, rotations: Array, root_positions: Array | None, joint_translations: Array | None
) -> tuple[Array, Array | None, Array | None]:
    joints = skeleton.joint_count
    q = np.ascontiguousarray(rotations, dtype=np.float64)
    if q.ndim != 3 or q.shape[1:] != (joints, 4):
        raise InputError(f"Expected `rotations` of shape (frames, {joints}, 4), got {q.shape}.")
    roots = None if root_positions is None else np.ascontiguousarray(root_positions, dtype=np.float64)
    if roots is not None and roots.shape != (len(q), 3):
        raise InputError(f"Expected `root_positions` of shape ({len(q)}, 3), got {roots.shape}.")
    shifts = None if joint_translations is None else np.ascontiguousarray(joint_translations, dtype=np.float64)
    if shifts is not None and shifts.shape != (len(q), joints, 3):
        raise InputError(f"Expected `joint_translations` of shape ({len(q)}, {joints}, 3), got {shifts.shape}.")
    return q, roots, shifts


def _room(skeleton: Skeleton, frames: int, width: int, joints: Indices | None) -> Array:
    """What results are written into."""
    shape = (frames, skeleton.joint_count, width)
    if joints is not None and len(joints) and not 0 <= np.min(joints) <= np.max(joints) < skeleton.joint_count:
        raise InputError(f"Expected `joints` below {skeleton.joint_count}, got {joints.tolist()}.")
    return np.empty(shape)


def _solve(
    skeleton: Skeleton,
    q: Array,
    roots: Array | None,
    shifts: Array | None,
    world: Array | None,
    where: Array | None,
    joints: Indices | None = None,
) -> None:
    """Write into ``world`` (orientations) and ``where`` (positions; needs ``roots``), whichever are given."""
    if compiled.wanted():
        parents = np.array(skeleton.parents, dtype=np.int32)
        wanted = None if joints is None else np.asarray(joints, dtype=np.int32)
        compiled.native.forward_kinematics(parents, skeleton.offsets, q, roots, shifts, world, where, wanted)
        return
    world = np.empty_like(q) if world is None else world
    if joints is not None:
        world.fill(np.nan)
        if where is not None:
            where.fill(np.nan)
    world[:, 0] = q[:, 0]
    if where is not None:
        where[:, 0] = roots
    needed = set(range(skeleton.joint_count)) if joints is None else _with_what_they_hang_on(skeleton, joints)
    for j, parent in enumerate(skeleton.parents[1:], start=1):
        if j not in needed:
            continue
        world[:, j] = quaternion.multiply(world[:, parent], q[:, j])
        if where is not None:
            offset = skeleton.offsets[j] if shifts is None else shifts[:, j]
            where[:, j] = where[:, parent] + quaternion.rotate(world[:, parent], offset)


def _with_what_they_hang_on(skeleton: Skeleton, joints: Indices) -> set[int]:
    out = {0}
    for joint in joints.tolist():
        while joint not in out:
            out.add(joint)
            joint = skeleton.parents[joint]
    return out
