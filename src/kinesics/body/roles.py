"""Which joint of a file is which part of the body: by its name where the naming is known, by its place in the tree else.

Only the limbs and the head need to be recognised. The pelvis is where the legs meet, the chest where the arms meet, the
spine the way between them, the neck the way from chest to head; so a skeleton may have any number of spine joints, joints
that only twist, hip joints that never turn, fingers and toes.

What the names tell is in `kinesics.body.joint_names`, what the shape tells in `kinesics.body.shape`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from kinesics.body.joint_names import by_name, naming_of, of_an_animal
from kinesics.body.shape import by_shape
from kinesics.body.skeleton import Skeleton
from kinesics.body.tree import ancestors, between, meet
from kinesics.errors import InputError, SkeletonError, some_of

Array = NDArray[np.float64]

LIMB_ROLES: Final = ("femur", "tibia", "foot", "humerus", "radius", "hand")
BOTH: Final = "names and shape"
"""The naming of a skeleton whose names tell most links and whose shape tells the others."""
REQUIRED: Final = (
    "left_femur",
    "left_tibia",
    "right_femur",
    "right_tibia",
    "left_humerus",
    "left_radius",
    "right_humerus",
    "right_radius",
    "head",
)
OPTIONAL: Final = (
    "left_foot",
    "right_foot",
    "left_hand",
    "right_hand",
    "left_toes",
    "right_toes",
    "pelvis",
    "chest",
)


@dataclass(frozen=True)
class Roles:
    """Joint indices of the parts of a human body."""

    naming: str
    """The naming recognised, such as "cmu-asf"; "shape" where names told nothing, `BOTH` where they did not tell all; "mapping"
    where the user said."""
    pelvis: int
    spine: tuple[int, ...]
    """From above the pelvis up to and including the chest."""
    neck: tuple[int, ...]
    """From above the chest up to below the head."""
    head: int
    left_femur: int
    left_tibia: int
    right_femur: int
    right_tibia: int
    left_humerus: int
    left_radius: int
    right_humerus: int
    right_radius: int
    left_foot: int | None = None
    right_foot: int | None = None
    left_hand: int | None = None
    right_hand: int | None = None
    left_toes: int | None = None
    right_toes: int | None = None
    left_clavicle: tuple[int, ...] = ()
    """Joints between chest and humerus."""
    right_clavicle: tuple[int, ...] = ()

    @property
    def chest(self) -> int:
        """The joint that the arms hang on: the last of the spine, or the pelvis where there is no spine."""
        return self.spine[-1] if self.spine else self.pelvis

    def named(self, skeleton: Skeleton) -> dict[str, str]:
        """Role to joint name, for people to read."""
        out: dict[str, str] = {"pelvis": skeleton.joint_names[self.pelvis]}
        for label, chain in (("spine", self.spine), ("neck", self.neck)):
            if chain:
                out[label] = ", ".join(skeleton.joint_names[j] for j in chain)
        out["head"] = skeleton.joint_names[self.head]
        for side in ("left", "right"):
            clavicle = getattr(self, f"{side}_clavicle")
            if clavicle:
                out[f"{side}_clavicle"] = ", ".join(skeleton.joint_names[j] for j in clavicle)
            for part in (*LIMB_ROLES, "toes"):
                j = getattr(self, f"{side}_{part}")
                if j is not None:
                    out[f"{side}_{part}"] = skeleton.joint_names[j]
        return out


def complete(skeleton: Skeleton, found: Mapping[str, int], naming: str) -> Roles:
    """Pelvis, spine, neck and clavicles from the tree, once the limbs and the head are known.

    Raises
    ------
    SkeletonError
        If a link is missing, or the limbs do not hang together as a body does.
    """
    missing = tuple(role for role in REQUIRED if role not in found)
    names = skeleton.joint_names
    told = {role: names[j] for role, j in found.items()}
    if missing:
        raise SkeletonError(_not_understood(skeleton, told, missing), found=told, missing=missing)

    faults: list[str] = []
    for side in ("left", "right"):
        for upper, lower in (
            ("femur", "tibia"),
            ("tibia", "foot"),
            ("humerus", "radius"),
            ("radius", "hand"),
        ):
            a, b = (
                found.get(f"{side}_{upper}", None),
                found.get(f"{side}_{lower}"),
            )
            if a is not None and b is not None and a not in ancestors(skeleton, b):
                faults.append(f"{side}_{lower} '{names[b]}' does not hang on {side}_{upper} '{names[a]}'")
    if faults:
        raise SkeletonError(
            f"The skeleton does not hang together as a human body: {'; '.join(faults)}. "
            "Name the joints in a mapping file (--map).",
            found=told,
        )
    pelvis = found.get("pelvis", meet(skeleton, found["left_femur"], found["right_femur"]))
    chest = found.get("chest", meet(skeleton, found["left_humerus"], found["right_humerus"]))
    head = found["head"]
    up_spine = between(skeleton, pelvis, chest)
    if up_spine is None:
        # legs and arms meet at one joint, or the legs hang on the spine (3ds Max Biped): the lower one is the pelvis
        pelvis = meet(skeleton, pelvis, chest)
        up_spine = between(skeleton, pelvis, chest)
    if up_spine is None:
        raise SkeletonError(
            f"No spine leads from the legs ('{names[pelvis]}') to the arms ('{names[chest]}').", found=told
        )
    spine = (*up_spine, chest) if chest != pelvis else ()
    neck = between(skeleton, chest, head)
    if neck is None:
        raise SkeletonError(
            f"The head '{names[head]}' does not hang on the chest '{names[chest]}', where the arms meet.",
            found=told,
        )
    clavicles = {s: between(skeleton, chest, found[f"{s}_humerus"]) or () for s in ("left", "right")}
    return Roles(
        naming=naming,
        pelvis=pelvis,
        spine=spine,
        neck=neck,
        left_clavicle=clavicles["left"],
        right_clavicle=clavicles["right"],
        **{role: found[role] for role in REQUIRED},
        **{
            role: found[role]
            for role in ("left_foot", "right_foot", "left_hand", "right_hand", "left_toes", "right_toes")
            if role in found
        },
    )


def identify(skeleton: Skeleton, positions: Array | None = None, mapping: Mapping[str, object] | None = None) -> Roles:
    """Find the body in a skeleton: what the user said, else what the names say, else what its shape says.

    Parameters
    ----------
    positions : world positions in a y-up world, shape (frames, joints, 3): needed only where names do not tell all.
    mapping : role to joint name (the table ``[joints]`` of a mapping file, or the file's whole table).

    Raises
    ------
    SkeletonError
        With the list of what was found and what is missing.
    """
    told = mapped_joints(skeleton, mapping)
    found = {**by_name(skeleton), **told}
    animal = of_an_animal(skeleton)
    if animal and not told:
        missing = tuple(role for role in REQUIRED if role not in found)
        raise SkeletonError(
            f"The skeleton is not a human body: it has {some_of(animal)}. Only humanoid skeletons have the 15 links; if this "
            "one is humanoid all the same, name its joints in a mapping file (--map).",
            found={role: skeleton.joint_names[j] for role, j in found.items()},
            missing=missing,
        )
    absent = [role for role in REQUIRED if role not in found]
    shape = by_shape(skeleton, positions) if absent and positions is not None else None
    if shape is not None:
        if len(absent) >= len(REQUIRED) - 3:
            # names tell (next to) nothing, as against a body of which a part is not there
            return complete(skeleton, {**shape, **told}, "shape")
        if all(shape[role] == found[role] for role in REQUIRED if role in found):
            # a joint or two are named otherwise, and the shape says of all the others what their names say
            return complete(skeleton, {**{role: shape[role] for role in absent}, **found}, BOTH)
    return complete(skeleton, found, "mapping" if told else naming_of(skeleton))


def mapped_joints(skeleton: Skeleton, mapping: Mapping[str, object] | None) -> dict[str, int]:
    """Roles that the user named, checked.

    Raises
    ------
    InputError
        If a role or a joint is unknown; the message lists those there are.
    """
    if not mapping:
        return {}
    table = mapping.get("joints", mapping)
    if not isinstance(table, Mapping):
        raise InputError('Expected a table [joints] of role = "joint name" in the mapping file.')
    known = (*REQUIRED, *OPTIONAL)
    out: dict[str, int] = {}
    for role, name in table.items():
        if role in ("root", "thorax"):
            role = {"root": "pelvis", "thorax": "chest"}[role]
        if role not in known:
            raise InputError(f"The mapping names a role '{role}'. Roles: {', '.join(known)}.")
        if not isinstance(name, str):
            raise InputError(f"The mapping of '{role}' must be a joint name, got {name!r}.")
        out[role] = skeleton.find(name)
    return out


def _not_understood(skeleton: Skeleton, found: Mapping[str, str], missing: tuple[str, ...]) -> str:
    found_text = ", ".join(f"{role} = {name}" for role, name in found.items()) or "none"
    names = ", ".join(skeleton.joint_names[:40]) + (" …" if skeleton.joint_count > 40 else "")
    return (
        f"The skeleton cannot be understood as a human body. Found: {found_text}. Missing: {', '.join(missing)}. "
        f"Joints in the file: {names}. If it is a human body, name its joints in a mapping file (--map): a table [joints] "
        'with lines such as left_femur = "name".'
    )
