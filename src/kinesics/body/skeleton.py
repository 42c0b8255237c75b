"""The skeleton as a file has it: joints, parents, offsets, and what the file says of each joint's freedom (§2.6)."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from kinesics.errors import InputError
from kinesics.geometry import quaternion

if TYPE_CHECKING:
    from kinesics.body.anatomy import Anatomy

Array = NDArray[np.float64]

LONGEST = 1e12
"""Metres. What is longer is no length of a body or a place but a damaged number, and its squares would overflow."""


@dataclass(frozen=True)
class EndSite:
    """The tip of a leaf joint: a fingertip, the crown of the head."""

    parent: int
    """Index of the joint that it hangs on."""
    offset: tuple[float, float, float]
    """In the frame of that joint, metres."""


@dataclass(frozen=True)
class JointFreedom:
    """What a file says of one joint: which channels it has, in which order and frame, and their limits.

    It changes nothing in kinematics: a `Motion` holds quaternions. It is kept so that a file is written as it was read
    and so that limits can be checked.
    """

    order: str = "ZXY"
    """Axes of the file's Euler angles as an intrinsic sequence: "ZYX" is R = Rz·Ry·Rx (Fick angles, §2.1)."""
    channels: str = "xyz"
    """The axes that may turn, in the file's order of channels: "xyz", "x" (a hinge), "" (rigid)."""
    translation: str = ""
    """The axes that may shift, in the file's order: "" or such as "XYZ"."""
    axis: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)
    """Quaternion C of the frame in which the angles are given: local rotation = C·R·C⁻¹ (ASF ``axis``)."""
    limits: tuple[tuple[float, float], ...] = ()
    """(lowest, highest) in radians for each of ``channels``; empty where the file gives none."""


@dataclass(frozen=True, eq=False)
class Skeleton:
    """An immutable tree of joints, parents before children, shared by all motions made on it.

    Raises
    ------
    InputError
        If shapes disagree, a name is missing or doubled, a parent does not come before its child, or an offset is not
        finite.
    """

    joint_names: tuple[str, ...]
    """Unique names, root first."""
    parents: tuple[int, ...]
    """Index of each joint's parent; −1 for the root alone."""
    offsets: Array
    """From the parent's origin to the joint's, in the parent's frame, metres, shape (joints, 3)."""
    end_sites: tuple[EndSite, ...] = ()
    freedoms: tuple[JointFreedom, ...] = ()
    """One for each joint."""
    name: str = ""
    anatomy: Anatomy | None = field(default=None, repr=False)
    """Which joints are the 15 links, once known. `kinesics.body.anatomy.resolve` finds it; the mirror carries it."""

    def __post_init__(self) -> None:
        """Check what every loop over joints relies on."""
        count = len(self.joint_names)
        if count == 0:
            raise InputError("A skeleton needs at least one joint.")
        offsets = np.array(self.offsets, dtype=np.float64)
        if offsets.shape != (count, 3):
            raise InputError(f"Expected `offsets` of shape ({count}, 3), got {offsets.shape}.")
        if not np.all(np.isfinite(offsets)):
            bad = self.joint_names[int(np.argmax(~np.isfinite(offsets).all(axis=1)))]
            raise InputError(f"The offset of joint '{bad}' is not finite.")
        if np.abs(offsets).max() > LONGEST:
            bad = self.joint_names[int(np.argmax(np.abs(offsets).max(axis=1)))]
            raise InputError(f"The offset of joint '{bad}' is {np.abs(offsets).max():.3g} m, beyond any length.")
        offsets.setflags(write=False)
        object.__setattr__(self, "offsets", offsets)
        object.__setattr__(self, "parents", tuple(int(p) for p in self.parents))
        if len(self.parents) != count:
            raise InputError(f"Expected {count} parents, got {len(self.parents)}.")
        if self.parents[0] != -1:
            raise InputError("The first joint must be the root: its parent is −1.")
        for j, parent in enumerate(self.parents[1:], start=1):
            if not 0 <= parent < j:
                raise InputError(
                    f"Joint '{self.joint_names[j]}' (number {j}) has parent {parent}; parents must come before children."
                )
        if len(set(self.joint_names)) != count:
            doubled = sorted({n for n in self.joint_names if self.joint_names.count(n) > 1})
            raise InputError(f"Joint names must be unique; doubled: {', '.join(doubled)}.")
        if not self.freedoms:
            root = JointFreedom(translation="XYZ")
            object.__setattr__(self, "freedoms", (root,) + (JointFreedom(),) * (count - 1))
        if len(self.freedoms) != count:
            raise InputError(f"Expected {count} freedoms, got {len(self.freedoms)}.")
        for site in self.end_sites:
            if not 0 <= site.parent < count or not np.all(np.abs(site.offset) <= LONGEST):
                raise InputError(f"An end site hangs on joint {site.parent} with offset {site.offset}.")

    @property
    def joint_count(self) -> int:
        """How many joints."""
        return len(self.joint_names)

    @cached_property
    def children(self) -> tuple[tuple[int, ...], ...]:
        """Indices of each joint's children."""
        out: list[list[int]] = [[] for _ in self.joint_names]
        for j, parent in enumerate(self.parents):
            if parent >= 0:
                out[parent].append(j)
        return tuple(tuple(c) for c in out)

    @cached_property
    def joint_index(self) -> dict[str, int]:
        """Name to index."""
        return {name: j for j, name in enumerate(self.joint_names)}

    @cached_property
    def rest_positions(self) -> Array:
        """Joint positions with all rotations zero and the root at the origin, metres, shape (joints, 3).

        It need not be a human pose: many rigs rest with every bone along its own x.
        """
        out = np.zeros((self.joint_count, 3))
        for j, parent in enumerate(self.parents[1:], start=1):
            out[j] = out[parent] + self.offsets[j]
        return out

    def find(self, name: str) -> int:
        """Index of the joint called ``name``.

        Raises
        ------
        InputError
            If there is none; the message lists those there are.
        """
        try:
            return self.joint_index[name]
        except KeyError:
            raise InputError(f"No joint is called '{name}'. Joints: {', '.join(self.joint_names)}.") from None

    def replace(self, **changes: Any) -> Skeleton:
        """A copy with some fields changed."""
        return dataclasses.replace(self, **changes)

    def same_tree(self, other: Skeleton) -> bool:
        """Whether names and parents are the same (lengths may differ)."""
        return self.joint_names == other.joint_names and self.parents == other.parents

    def mirror(self, partner: tuple[int, ...]) -> Skeleton:
        """The skeleton seen in the mirror x = 0: joint j takes the reflected shape of joint ``partner[j]``.

        Parameters
        ----------
        partner : for each joint the one it changes places with (itself on the midline); an involution that keeps the tree.
        """
        flip = np.array([-1.0, 1.0, 1.0])
        sites_of: dict[int, list[EndSite]] = {}
        for site in self.end_sites:
            sites_of.setdefault(site.parent, []).append(site)
        sites = tuple(
            EndSite(j, (-site.offset[0], site.offset[1], site.offset[2]))
            for j in range(self.joint_count)
            for site in sites_of.get(partner[j], [])
        )
        freedoms = tuple(_mirror_freedom(self.freedoms[partner[j]]) for j in range(self.joint_count))
        return self.replace(
            offsets=self.offsets[list(partner)] * flip,
            end_sites=sites,
            freedoms=freedoms,
            anatomy=None if self.anatomy is None else self.anatomy.mirror(partner),
        )


def _mirror_freedom(freedom: JointFreedom) -> JointFreedom:
    """Reflected, angles about y and z change sign: their limits are negated and swapped."""
    axis = tuple(float(v) for v in quaternion.mirror(freedom.axis))
    limits = tuple(
        (low, high) if channel == "x" else (-high, -low)
        for channel, (low, high) in zip(freedom.channels, freedom.limits, strict=False)
    )
    return dataclasses.replace(freedom, axis=(axis[0], axis[1], axis[2], axis[3]), limits=limits)
