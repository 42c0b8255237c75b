"""Quaternions to and from the angles of a file: joints with one, two or three axes, in any order, many at once."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import permutations
from typing import Final

import numpy as np
from numpy.typing import NDArray

from kinesics.geometry import euler, quaternion

Array = NDArray[np.float64]

DEGREE: Final = np.pi / 180.0
"""Radians."""

_BLOCK: Final = 1024
"""Frames at a time: what is in work then stays in the processor's cache, however long the recording."""


def rotations_of_columns(table: Array, columns: Sequence[Sequence[int]], orders: Sequence[str], unit: float) -> Array:
    """Quaternions (rows, joints, 4) of angles that stand in the columns of a table.

    Parameters
    ----------
    table : shape (rows, columns).
    columns : for each joint the columns of its angles, in the order of the letters.
    orders : for each joint the axes of its angles, an intrinsic sequence such as "ZXY", "X" or "".
    unit : radians in one unit of the table.
    """
    shape = (len(table), len(orders))
    # every joint's rotation is filled in below, unless one has no angle
    out = np.empty((*shape, 4)) if all(orders) else quaternion.identity(shape)
    alike: dict[str, list[int]] = {}
    for joint, order in enumerate(orders):
        if order:
            alike.setdefault(order.upper(), []).append(joint)
    for order, joints in alike.items():
        # axes first: long rows of one axis are what the trigonometry is fastest on
        where = np.array([columns[j] for j in joints]).T
        target = slice(None) if len(joints) == len(orders) else np.array(joints)
        for start in range(0, len(table), _BLOCK):
            block = table[start : start + _BLOCK][:, where] * unit
            out[start : start + _BLOCK, target] = euler.from_euler(np.moveaxis(block, 1, -1), order)
    return out


def angles_of_rotations(rotations: Array, order: str, axes: str) -> tuple[Array, float]:
    """Angles about fewer axes than three may not be able to say a rotation; this tells how nearly they can.

    Parameters
    ----------
    rotations : quaternions, shape (frames, 4).
    order : three axes, intrinsic, such as "ZXY".
    axes : those of them that may turn.

    Returns
    -------
    Angles, radians, shape (frames, len(axes)), in the order of ``order``; and the largest angle in radians by which a
    rotation is missed.
    """
    letters = "".join(a for a in order.upper() if a in axes.upper())
    if len(letters) == 3:
        angles = euler.as_euler(rotations, letters).angles
    elif len(letters) == 2:
        angles = _two_angles(rotations, letters)
    elif len(letters) == 1:
        angles = 2.0 * np.arctan2(rotations[:, 1 + "XYZ".index(letters)], rotations[:, 0])[:, None]
    else:
        return np.zeros((len(rotations), 0)), float(quaternion.angle(rotations).max())
    angles = np.arctan2(np.sin(angles), np.cos(angles))
    return angles, float(quaternion.angle(rotations, euler.from_euler(angles, letters)).max())


def complete_order(letters: str, preferred: str) -> str:
    """Three axes in an order that has the given ones in theirs: the preferred order if it does, else the first that does.

    Raises
    ------
    ValueError
        If the letters are no axes, or one is there twice: a caller's mistake, for files are checked before.
    """
    letters = letters.upper()
    for candidate in (preferred, *map("".join, permutations("XYZ"))):
        if "".join(a for a in candidate if a in letters) == letters:
            return candidate
    raise ValueError(letters)


def _two_angles(q: Array, letters: str) -> Array:
    """Angles (frames, 2) of q = A(α)·B(β).

    With half angles: w = cα·cβ, q_A = sα·cβ, q_B = cα·sβ, ±q_C = sα·sβ: two parallel vectors along (cα, sα), cβ and sβ long.
    """
    i, j = "XYZ".index(letters[0]), "XYZ".index(letters[1])
    parity = 1.0 if (j - i) % 3 == 1 else -1.0
    along_cos = q[:, [0, 1 + i]]
    along_sin = np.stack([q[:, 1 + j], parity * q[:, 4 - i - j]], axis=-1)
    longer = np.linalg.norm(along_cos, axis=-1) >= np.linalg.norm(along_sin, axis=-1)
    direction = np.where(longer[:, None], along_cos, along_sin)
    direction = direction / np.linalg.norm(direction, axis=-1, keepdims=True)
    cos_half, sin_half = np.sum(along_cos * direction, axis=-1), np.sum(along_sin * direction, axis=-1)
    return 2.0 * np.stack([np.arctan2(direction[:, 1], direction[:, 0]), np.arctan2(sin_half, cos_half)], axis=-1)
