"""Any humanoid skeleton onto the 15 anatomical links (§2.7, §2.10, §2.16; CONVENTIONS.md, "The mirror").

The mirror operator W is only true in anatomical frames: frames in which the T-pose facing +z, palms down, is the
identity of every link, x to the subject's left on both sides. A file's frames are others. Each joint that carries a link
gets one constant rotation K, found once for the skeleton, so that (world orientation in the file) · K is the anatomical
orientation.

- `resolve` finds the `Anatomy` of a motion's skeleton (K in anatomical_frames.py), `understood` puts it on the skeleton
- `link_rotations`: the 15 links from the joints; `spread`: chains of other lengths
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray

from kinesics.body import anatomical_frames
from kinesics.body import roles as _roles
from kinesics.body.motion import Motion
from kinesics.body.roles import Roles
from kinesics.body.skeleton import Skeleton
from kinesics.errors import InputError
from kinesics.geometry import quaternion

Array = NDArray[np.float64]

_SAMPLES: Final = 500


@dataclass(frozen=True, eq=False)
class Anatomy:
    """Which joints carry the links, and the constant rotation from each joint's frame to its anatomical frame."""

    roles: Roles
    frames: Array
    """K for each joint, quaternions, shape (joints, 4). Joints that carry no link have one too: a foot stands flat in it, toes,
    fingers and joints that only twist go straight on from their parents."""
    clavicle: str = "compose"
    """"compose": the humerus is taken relative to the chest, clavicle included; "drop": relative to the clavicle (§2.16)."""
    profile: str = ""
    """Naming, spine rule and clavicle rule in one line: D between unlike rules means little."""
    assumptions: tuple[str, ...] = ()

    @property
    def pelvis(self) -> int:
        """Joint of the root link."""
        return self.roles.pelvis

    @property
    def chest(self) -> int:
        """Joint that the arms and the neck hang on."""
        return self.roles.chest

    @property
    def spine(self) -> tuple[int, ...]:
        """Joints from above the pelvis up to the chest."""
        return self.roles.spine

    @property
    def neck(self) -> tuple[int, ...]:
        """Joints between chest and head."""
        return self.roles.neck

    @property
    def head(self) -> int:
        """Joint of the head."""
        return self.roles.head

    def __getattr__(self, name: str) -> int | None:
        """``left_femur``, ``right_hand`` … : the joint in that role, or None."""
        if name.startswith(("left_", "right_")):
            value: int | None = getattr(self.roles, name)
            return value
        raise AttributeError(name)

    def mirror(self, partner: tuple[int, ...]) -> Anatomy:
        """For the skeleton seen in the mirror: joint j takes the reflected frame of its partner."""
        return dataclasses.replace(self, frames=quaternion.mirror(self.frames[list(partner)]))


def resolve(motion: Motion, mapping: Mapping[str, object] | None = None) -> Anatomy:
    """The anatomy of a motion's skeleton: the one it carries, else found now.

    Parameters
    ----------
    mapping : what the user says, as read from a TOML file: a table ``[joints]`` of role = "joint name" (roles: those of
        `kinesics.body.roles.REQUIRED` and ``OPTIONAL``; any subset, the rest is found), ``clavicle = "compose" | "drop"``, and
        ``facing``: where the rest pose looks, in the file's axes ("+z", "-x", …), if not where its left and right say.

    Raises
    ------
    SkeletonError
        If the skeleton cannot be understood as a human body; it lists what was found and what is missing.
    InputError
        If the mapping names unknown roles or joints.
    """
    if motion.skeleton.anatomy is not None and not mapping:
        return motion.skeleton.anatomy
    clavicle = str((mapping or {}).get("clavicle", "compose"))
    if clavicle not in ("compose", "drop"):
        raise InputError(f'Expected clavicle = "compose" or "drop" in the mapping, got "{clavicle}".')
    facing = (mapping or {}).get("facing")
    if facing is not None and facing not in anatomical_frames.DIRECTIONS:
        raise InputError(
            f"Expected facing = one of {', '.join(anatomical_frames.DIRECTIONS)} in the mapping, got {facing!r}."
        )
    joints = {k: v for k, v in (mapping or {}).items() if k not in ("clavicle", "facing")}
    sample = motion[:: max(1, motion.frame_count // _SAMPLES)]
    positions = sample.positions()
    roles = _roles.identify(motion.skeleton, positions, joints)
    return _attach_frames(
        motion.skeleton, roles, positions, sample.global_rotations(), clavicle, None if facing is None else str(facing)
    )


def understood(motion: Motion, mapping: Mapping[str, object] | None = None) -> Motion:
    """The same motion on a skeleton that carries its anatomy, so that slices and mirror images agree on it.

    Raises
    ------
    SkeletonError
        As `resolve`.
    """
    if motion.skeleton.anatomy is not None and not mapping:
        return motion
    return motion.replace(skeleton=motion.skeleton.replace(anatomy=resolve(motion, mapping)))


def link_rotations(anatomy: Anatomy, world: Array) -> Array:
    """Rotations of the 15 links relative to their parent links in anatomical frames.

    Parameters
    ----------
    world : world orientations of all joints, shape (frames, joints, 4).

    Returns
    -------
    Array
        Shape (frames, 15, 4). Entry 0 is the pelvis in the world, yaw included. Spines and necks of other lengths are
        spread over their links along the way they go; the twist of forearm and shank about their own bone is left out, for
        elbow and knee are hinges (§2.7).
    """
    roles = anatomy.roles

    def turned(j: int) -> Array:
        return quaternion.multiply(world[:, j], anatomy.frames[j])

    pelvis, chest, head = turned(roles.pelvis), turned(roles.chest), turned(roles.head)
    out = np.empty((len(world), 15, 4))
    out[:, 0] = pelvis
    out[:, 1:4] = spread(_steps(pelvis, [turned(j) for j in roles.spine]), 3)
    if roles.neck:
        neck = [turned(j) for j in roles.neck]
        out[:, 4:6] = spread(_steps(chest, neck), 2)
        out[:, 6] = quaternion.multiply(quaternion.conjugate(neck[-1]), head)
    else:
        out[:, 4:7] = spread(_steps(chest, [head]), 3)
    for start, side in ((7, "left"), (11, "right")):
        femur, tibia = turned(getattr(roles, f"{side}_femur")), turned(getattr(roles, f"{side}_tibia"))
        humerus, radius = turned(getattr(roles, f"{side}_humerus")), turned(getattr(roles, f"{side}_radius"))
        clavicles = getattr(roles, f"{side}_clavicle")
        girdle = turned(clavicles[-1]) if anatomy.clavicle == "drop" and clavicles else chest
        out[:, start] = quaternion.multiply(quaternion.conjugate(pelvis), femur)
        out[:, start + 1] = _hinge(femur, tibia, np.array([0.0, 1.0, 0.0]))
        out[:, start + 2] = quaternion.multiply(quaternion.conjugate(girdle), humerus)
        out[:, start + 3] = _hinge(humerus, radius, np.array([1.0, 0.0, 0.0]))
    return out


def spread(steps: list[Array], links: int) -> Array:
    """Rotations of a chain of joints as those of a chain of ``links`` links whose product is the same.

    Joint k of n covers the stretch [k/n, (k+1)/n] of the way; each link takes, in order, the share of the joints that lies
    in its own stretch, as a power of their rotation. A chain of equal length is left as it is; an empty one is straight.

    Parameters
    ----------
    steps : rotations along the chain, each of shape (frames, 4).

    Returns
    -------
    Array
        Shape (frames, links, 4).
    """
    count = len(steps)
    if count == 0:
        return quaternion.identity((1, links))
    out = quaternion.identity((len(steps[0]), links))
    for link in range(links):
        for k, step in enumerate(steps):
            # stretches in units of 1/(count·links), so that equal ends compare as whole numbers
            share = min((k + 1) * links, (link + 1) * count) - max(k * links, link * count)
            if share == links:
                out[:, link] = quaternion.multiply(out[:, link], step)
            elif share > 0:
                out[:, link] = quaternion.multiply(out[:, link], quaternion.power(step, share / links))
    return out


def _steps(base: Array, chain: list[Array]) -> list[Array]:
    """Rotations from one world orientation to the next."""
    return [quaternion.multiply(quaternion.conjugate(a), b) for a, b in pairwise([base, *chain])]


def _hinge(upper: Array, lower: Array, bone: Array) -> Array:
    return quaternion.swing_twist(quaternion.multiply(quaternion.conjugate(upper), lower), bone).swing


def _attach_frames(
    skeleton: Skeleton, roles: Roles, positions: Array, world: Array, clavicle: str, facing: str | None
) -> Anatomy:
    spine_text = {0: "no spine joint: the three spine links stay straight", 3: ""}.get(
        len(roles.spine), f"spine of {len(roles.spine)} joints spread over three links"
    )
    neck_text = {0: "no neck joint: the head's rotation spread over neck and head", 2: ""}.get(
        len(roles.neck), f"neck of {len(roles.neck)} joint(s) spread over two links"
    )
    rested = anatomical_frames.from_rest(skeleton, roles, facing)
    if rested is not None:
        frames = rested
        forward = quaternion.rotate(frames[roles.pelvis], np.array([0.0, 0.0, 1.0]))
        said = "as the mapping says" if facing is not None else "by its left and right"
        how = f"anatomical frames from the rest pose, which faces {anatomical_frames.axis_named(forward)} ({said})"
    elif facing is not None:
        raise InputError(
            "The mapping gives a facing, but the rest pose of this skeleton is no human pose and faces nowhere."
        )
    else:
        frames = anatomical_frames.from_bones(skeleton, roles, positions, world)
        how = "the rest pose is no human pose: anatomical frames from bones, hip and shoulder line and the bend of knees and elbows"
    naming = {
        "shape": "joint names tell nothing: links found by the skeleton's shape, left and right by the way the knees bend",
        _roles.BOTH: "links by joint names; those without a telling name by the skeleton's shape, which agrees with the names",
        "mapping": "links as the mapping says",
    }.get(roles.naming, f"links by joint names ({roles.naming})")
    frames = anatomical_frames.beyond_links(skeleton, roles, frames, positions, world, rests=rested is not None)
    rule = "clavicle composed with the humerus" if clavicle == "compose" else "clavicle dropped"
    return Anatomy(
        roles=roles,
        frames=frames,
        clavicle=clavicle,
        profile=f"{roles.naming}; spine {len(roles.spine)}, neck {len(roles.neck)}; clavicle {clavicle}",
        assumptions=tuple(t for t in (naming, spine_text, neck_text, rule, how) if t),
    )
