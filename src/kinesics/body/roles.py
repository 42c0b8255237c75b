"""Which joint of a file is which part of the body: by its name where the naming is known, by its place in the tree else.

Only the limbs and the head need to be recognised. The pelvis is where the legs meet, the chest where the arms meet, the
spine the way between them, the neck the way from chest to head; so a skeleton may have any number of spine joints, joints
that only twist, hip joints that never turn, fingers and toes.

- `by_name`: CMU ASF, cgspeed and its kin, Mixamo, LaFAN1, Bandai-Namco, Xsens, Rokoko, SMPL, 3ds Max Biped, Rigify, and
  generic Left/Right, L/R, ``_L``/``.R`` affixes.
- `by_shape`: any names at all; needs a clip, to see which way is forward.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from kinesics.body.skeleton import Skeleton
from kinesics.errors import InputError, SkeletonError

Array = NDArray[np.float64]

LIMB_ROLES: Final = ("femur", "tibia", "foot", "humerus", "radius", "hand")
BOTH: Final = "names and shape"
"""The naming of a skeleton whose names tell most links and whose shape tells the others."""
_TOLD: Final = 0.01
"""Of a leg's length: toes and knees that point forward by less do not tell left from right."""
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


# What a bare name (side and numbers taken off) may mean, most telling first. A word in two rows is settled by what else
# the same side has: a "shoulder" is the clavicle where there is an "arm" too, the humerus where there is a "collar".
_WORDS: Final[dict[str, tuple[str, ...]]] = {
    "femur": ("femur", "upleg", "upperleg", "thigh", "upperlimb", "legupper", "uleg", "hip", "leg"),
    "tibia": ("tibia", "lowerleg", "lowleg", "shin", "calf", "shank", "leglower", "lleg", "knee", "leg"),
    "foot": ("ankle", "foot"),
    "toes": ("toes", "toe", "toebase", "ball", "forefoot", "foot"),
    "clavicle": ("clavicle", "collar", "clav", "collarbone", "scapula", "inshoulder", "shoulder"),
    "humerus": ("humerus", "upperarm", "uparm", "armupper", "uarm", "arm", "shoulder"),
    "radius": ("radius", "forearm", "lowerarm", "lowarm", "armlower", "larm", "elbow", "ulna"),
    "hand": ("wrist", "hand", "palm"),
}
_NOT_A_LINK: Final = re.compile(
    r"twist|roll|end$|nub|site|tip$|helper|ik$|^ik|pole|ctrl|finger|thumb|index|middle|ring|pinky|little|metacarp|eye|jaw|"
    r"hair|skirt|breast|weapon|prop|corrective|hipjoint|_dup|volume",
)
_QUADRUPED: Final = re.compile(r"(^|[^a-z])(tail|paw|hoof|hock|wing|snout|foreleg|hindleg|frontleg|backleg|rearleg)")


@dataclass(frozen=True)
class _Name:
    side: str
    """left, right or ""."""
    base: str
    """Lower case letters only."""


def split_name(name: str) -> _Name:
    """Side and bare word of a joint name: "mixamorig:LeftUpLeg" → left, "upleg"; "UpperArm_R" → right, "upperarm"."""
    bare = re.split(r"[:|/]", name)[-1]
    bare = re.sub(
        r"^(joint|jnt|bone|skeleton|rig|def|org|j|b|cc_base|m_avg|f_avg|avg|bip\d*)[\s_.\-]+",
        "",
        bare,
        flags=re.I,
    )
    side = ""
    affix = re.match(r"(?i)^(left|right)[\s_.\-]*(?=[a-z])", bare)
    if affix:
        side = affix.group(1).lower()
        bare = bare[affix.end() :]
    else:
        tail = re.search(r"(?i)[\s_.\-]*(left|right)(?=[\s_.\-]*\d*$)", bare)
        lone = re.search(r"[\s_.\-]([lLrR])(?=[\s_.\-]*\d*$)|[\s_.\-]([lLrR])[\s_.\-]", bare)
        head = re.match(r"^([lLrR])[\s_.\-]+|^([LR])(?=[A-Z][a-z])|^([lr])(?=[A-Z])", bare)
        if tail:
            side = tail.group(1).lower()
            bare = bare[: tail.start()] + bare[tail.end() :]
        elif head:
            letter = next(g for g in head.groups() if g)
            side = "left" if letter in "lL" else "right"
            bare = bare[head.end() :]
        elif lone:
            letter = next(g for g in lone.groups() if g)
            side = "left" if letter in "lL" else "right"
            bare = bare[: lone.start()] + " " + bare[lone.end() :]
    base = re.sub(r"[^a-z]", "", bare.lower())
    if not side and base[:1] in ("l", "r"):
        # CMU's ASF: lfemur, rradius; only where the rest is a limb's name, so that "lowerback" and "root" stay whole
        rest = base[1:]
        if any(rest in words for words in _WORDS.values()):
            side, base = ("left" if base[0] == "l" else "right"), rest
    return _Name(side, base)


def by_name(skeleton: Skeleton) -> dict[str, int]:
    """Role to joint index, for what the names tell: limbs with their sides, and the head."""
    found: dict[str, int] = {}
    names = [split_name(n) for n in skeleton.joint_names]
    lowered = [n.lower() for n in skeleton.joint_names]
    for side in ("left", "right"):
        words: dict[str, int] = {}
        for j, name in enumerate(names):
            if name.side == side and not _NOT_A_LINK.search(lowered[j]) and name.base not in words:
                words[name.base] = j
        found.update({f"{side}_{part}": j for part, j in _settle(words).items()})
    heads = [
        j for j, n in enumerate(names) if not n.side and n.base in ("head", "skull") and not lowered[j].endswith("end")
    ]
    if heads:
        found["head"] = heads[0]
    return found


def _settle(words: Mapping[str, int]) -> dict[str, int]:
    """Give each part of one side its joint: a word with two meanings takes the one that is left over."""
    has = {part: [w for w in vocabulary if w in words] for part, vocabulary in _WORDS.items()}
    out: dict[str, int] = {}

    def take(part: str, *unless: str) -> None:
        for word in has[part]:
            if word not in unless:
                out[part] = words[word]
                return

    sure_femur = any(w not in ("hip", "leg") for w in has["femur"])
    sure_tibia = any(w != "leg" for w in has["tibia"])
    # "leg" alone is the shank beside an "upleg" or a "hip", the thigh beside a "shin"
    leg_is_thigh = "leg" in words and sure_tibia and not sure_femur and "hip" not in words
    take("femur", *(() if leg_is_thigh else ("leg",)))
    take("tibia", *(("leg",) if sure_tibia else ()))
    take("foot")
    take("toes", *(() if "ankle" in words else ("foot",)))
    sure_humerus = any(w != "shoulder" for w in has["humerus"])
    take("humerus", *(("shoulder",) if sure_humerus else ()))
    take("clavicle", *(() if sure_humerus else ("shoulder",)))
    take("radius")
    take("hand")
    out.pop("clavicle", None)  # the tree tells it
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
            if a is not None and b is not None and a not in _ancestors(skeleton, b):
                faults.append(f"{side}_{lower} '{names[b]}' does not hang on {side}_{upper} '{names[a]}'")
    if faults:
        raise SkeletonError(
            f"The skeleton does not hang together as a human body: {'; '.join(faults)}. "
            "Name the joints in a mapping file (--map).",
            found=told,
        )
    pelvis = found.get("pelvis", _meet(skeleton, found["left_femur"], found["right_femur"]))
    chest = found.get("chest", _meet(skeleton, found["left_humerus"], found["right_humerus"]))
    head = found["head"]
    up_spine = _between(skeleton, pelvis, chest)
    if up_spine is None:
        # legs and arms meet at one joint, or the legs hang on the spine (3ds Max Biped): the lower one is the pelvis
        pelvis = _meet(skeleton, pelvis, chest)
        up_spine = _between(skeleton, pelvis, chest)
    if up_spine is None:
        raise SkeletonError(
            f"No spine leads from the legs ('{names[pelvis]}') to the arms ('{names[chest]}').", found=told
        )
    spine = (*up_spine, chest) if chest != pelvis else ()
    neck = _between(skeleton, chest, head)
    if neck is None:
        raise SkeletonError(
            f"The head '{names[head]}' does not hang on the chest '{names[chest]}', where the arms meet.",
            found=told,
        )
    clavicles = {s: _between(skeleton, chest, found[f"{s}_humerus"]) or () for s in ("left", "right")}
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
    animal = [n for n in skeleton.joint_names if _QUADRUPED.search(_snake(n))]
    if animal and not told:
        missing = tuple(role for role in REQUIRED if role not in found)
        raise SkeletonError(
            f"The skeleton is not a human body: it has {_some(animal)}. Only humanoid skeletons have the 15 links; if this "
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


def naming_of(skeleton: Skeleton) -> str:
    """The convention that the joint names follow, for the record."""
    names = set(skeleton.joint_names)
    lowered = {n.lower() for n in names}
    if {"lfemur", "rfemur", "lhumerus"} <= names:
        return "cmu-asf"
    if any(n.startswith("mixamorig") for n in names):
        return "mixamo"
    if {"LHipJoint", "LowerBack", "LeftUpLeg"} <= names:
        return "cgspeed"
    if {"UpperLeg_L", "LowerLeg_L", "UpperArm_L"} <= names:
        return "bandai-namco"
    if {"LeftUpLeg", "LeftToe", "Spine2"} <= names:
        return "lafan1"
    if {"left_hip", "left_collar", "left_elbow"} <= lowered or {"l_hip", "l_collar", "l_elbow"} <= {
        re.sub(r"^[mf]_avg_", "", n) for n in lowered
    }:
        return "smpl"
    if {"LeftHip", "LeftKnee", "LeftCollar"} <= names:
        return "xsens"
    if {"LeftThigh", "LeftShin"} <= names:
        return "rokoko"
    if any(re.match(r"bip\d*", n) for n in lowered):
        return "biped"
    return "left-right"


def by_shape(skeleton: Skeleton, positions: Array) -> dict[str, int] | None:
    """Find a human body by its shape alone, whatever the names; None where there is none.

    Two pairs of equal branches: the longer, lower pair are legs, the other arms; what goes on upwards past the arms is the
    head. Which side is left follows from which way the feet (else the knees) point.
    """
    paths = _branch_pairs(skeleton)
    best: tuple[float, dict[str, int]] | None = None
    for at_legs, legs in paths:
        for at_arms, arms in paths:
            above = _ancestors(skeleton, at_arms)
            if at_legs not in above or any(leg in (at_arms, *above) for leg in legs):
                continue
            leg_reach, arm_reach = _reach(skeleton, legs[0]), _reach(skeleton, arms[0])
            if not 0.35 < arm_reach / max(leg_reach, 1e-9) < 1.6:
                continue
            head = _head_above(skeleton, at_arms, arms)
            if head is None:
                continue
            limbs = [_limb_joints(skeleton, branch) for branch in (*legs, *arms)]
            if any(limb is None for limb in limbs):
                continue
            leg_p, leg_q, arm_p, arm_q = (limb for limb in limbs if limb is not None)
            if not (_equal_bones(skeleton, leg_p, leg_q) and _equal_bones(skeleton, arm_p, arm_q)):
                continue
            if not _upright(positions, leg_p, leg_q, at_legs, at_arms):
                continue
            first_is_left = _first_is_left(skeleton, positions, leg_p, leg_q, at_legs, at_arms)
            arm_first_left = _same_side(positions, leg_p, leg_q, arm_p, arm_q)
            if first_is_left is None or arm_first_left is None:
                continue
            if not first_is_left:
                leg_p, leg_q = leg_q, leg_p
                arm_first_left = not arm_first_left
            if not arm_first_left:
                arm_p, arm_q = arm_q, arm_p
            found = {"head": head, "pelvis": at_legs, "chest": at_arms}
            for side, leg, arm in (("left", leg_p, arm_p), ("right", leg_q, arm_q)):
                found[f"{side}_femur"], found[f"{side}_tibia"] = leg[0], leg[1]
                found[f"{side}_humerus"], found[f"{side}_radius"] = arm[0], arm[1]
                if leg[2] is not None:
                    found[f"{side}_foot"] = leg[2]
                if arm[2] is not None:
                    found[f"{side}_hand"] = arm[2]
            score = leg_reach + arm_reach
            if best is None or score > best[0]:
                best = (score, found)
    return None if best is None else best[1]


def partners(skeleton: Skeleton, roles: Roles | None = None) -> tuple[int, ...]:
    """For each joint the one it changes places with in the mirror; itself on the midline.

    Names decide where they tell a side; below the limbs whose roles are known, the tree does. The result keeps the tree:
    the partner of a joint's parent is its partner's parent. A joint without a counterpart stays itself.
    """
    split = [split_name(n) for n in skeleton.joint_names]
    out = [-1] * skeleton.joint_count
    out[0] = 0
    forced: dict[int, int] = {}
    if roles is not None:
        for part in LIMB_ROLES:
            a, b = getattr(roles, f"left_{part}"), getattr(roles, f"right_{part}")
            if a is not None and b is not None:
                forced[a], forced[b] = b, a
                # the way up from a limb to the midline changes sides with it
                chain_a, chain_b = _ancestors(skeleton, a), _ancestors(skeleton, b)
                for x, y in zip(chain_a, chain_b, strict=False):
                    if x == y:
                        break
                    forced.setdefault(x, y)
                    forced.setdefault(y, x)
    tagged = {(s.side, _numbered(skeleton.joint_names[j], s)): j for j, s in enumerate(split) if s.side}
    for j in range(1, skeleton.joint_count):
        parent_partner = out[skeleton.parents[j]]
        candidates = skeleton.children[parent_partner] if parent_partner >= 0 else ()
        other = {"left": "right", "right": "left"}.get(split[j].side, "")
        by_tag = tagged.get((other, _numbered(skeleton.joint_names[j], split[j]))) if other else None
        if j in forced and forced[j] in candidates:
            out[j] = forced[j]
        elif by_tag is not None and by_tag in candidates:
            out[j] = by_tag
        elif parent_partner != skeleton.parents[j]:
            # inside a limb: the child that stands in the same place
            siblings = skeleton.children[skeleton.parents[j]]
            if len(siblings) == len(candidates):
                out[j] = candidates[siblings.index(j)]
        elif not split[j].side and j not in forced:
            out[j] = j
    # whatever has no counterpart keeps its place only if its parent does; else the whole branch is left unpaired
    for j in range(1, skeleton.joint_count):
        k = out[j]
        if k < 0 or out[k] != j:
            out[j] = j if out[skeleton.parents[j]] == skeleton.parents[j] else -1
    if any(k < 0 for k in out):
        raise SkeletonError(
            "Left and right of the skeleton do not match, so it has no mirror image: "
            + ", ".join(skeleton.joint_names[j] for j, k in enumerate(out) if k < 0)
            + " have no counterpart."
        )
    return tuple(out)


def _numbered(name: str, split: _Name) -> str:
    """The bare word with its digits, so that Index1 pairs with Index1."""
    return split.base + "".join(re.findall(r"\d+", re.split(r"[:|/]", name)[-1]))


def _snake(name: str) -> str:
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", name).lower()


def _some(names: list[str], most: int = 4) -> str:
    quoted = [f"'{n}'" for n in names[:most]]
    return ", ".join(quoted) + (f" and {len(names) - most} more" if len(names) > most else "")


def _not_understood(skeleton: Skeleton, found: Mapping[str, str], missing: tuple[str, ...]) -> str:
    found_text = ", ".join(f"{role} = {name}" for role, name in found.items()) or "none"
    names = ", ".join(skeleton.joint_names[:40]) + (" …" if skeleton.joint_count > 40 else "")
    return (
        f"The skeleton cannot be understood as a human body. Found: {found_text}. Missing: {', '.join(missing)}. "
        f"Joints in the file: {names}. If it is a human body, name its joints in a mapping file (--map): a table [joints] "
        'with lines such as left_femur = "name".'
    )


def _ancestors(skeleton: Skeleton, j: int) -> list[int]:
    out = []
    while (j := skeleton.parents[j]) >= 0:
        out.append(j)
    return out


def _meet(skeleton: Skeleton, a: int, b: int) -> int:
    """The lowest joint that both hang on (or are)."""
    line = [a, *_ancestors(skeleton, a)]
    other = {b, *_ancestors(skeleton, b)}
    return next(j for j in line if j in other)


def _between(skeleton: Skeleton, top: int, bottom: int) -> tuple[int, ...] | None:
    """Joints strictly between ``top`` and its descendant ``bottom``, from the top; None if it is not one."""
    if top == bottom:
        return ()
    line = _ancestors(skeleton, bottom)
    if top not in line:
        return None
    return tuple(reversed(line[: line.index(top)]))


def _reach(skeleton: Skeleton, j: int) -> float:
    """Length of the longest way down from joint j, its own offset left out."""
    tips = [float(np.linalg.norm(s.offset)) for s in skeleton.end_sites if s.parent == j]
    ways = [float(np.linalg.norm(skeleton.offsets[c])) + _reach(skeleton, c) for c in skeleton.children[j]]
    return max([0.0, *tips, *ways])


def _branch_pairs(skeleton: Skeleton) -> list[tuple[int, tuple[int, int]]]:
    """Pairs of branches of (nearly) equal reach that leave the same joint."""
    out = []
    for j, children in enumerate(skeleton.children):
        for i, a in enumerate(children):
            for b in children[i + 1 :]:
                reach_a, reach_b = _reach(skeleton, a), _reach(skeleton, b)
                if min(reach_a, reach_b) > 0 and abs(reach_a - reach_b) < 0.12 * max(reach_a, reach_b):
                    out.append((j, (a, b)))
    return out


def _limb_joints(skeleton: Skeleton, branch: int) -> tuple[int, int, int | None] | None:
    """Upper, lower and end joint of a limb: the two longest bones one after the other along its longest way."""
    way = [branch]
    while skeleton.children[way[-1]]:
        way.append(
            max(
                skeleton.children[way[-1]],
                key=lambda c: float(np.linalg.norm(skeleton.offsets[c])) + _reach(skeleton, c),
            )
        )
    lengths = [float(np.linalg.norm(skeleton.offsets[c])) for c in way[1:]]
    # the last two long bones that end in joints: collar bones and hip joints come before them, hands and feet after
    long = 0.18 * sum(lengths)
    pairs = [k for k in range(len(way) - 2) if min(lengths[k], lengths[k + 1]) >= long]
    if pairs:
        upper = pairs[-1]
        return way[upper], way[upper + 1], way[upper + 2]
    tip = [float(np.linalg.norm(s.offset)) for s in skeleton.end_sites if s.parent == way[-1]]
    lengths.append(max(tip, default=0.0))
    if len(way) < 2:
        return None
    upper = max(range(len(way) - 1), key=lambda k: lengths[k] + lengths[k + 1])
    if lengths[upper] <= 0 or lengths[upper + 1] <= 0:
        return None
    end = way[upper + 2] if upper + 2 < len(way) else None
    return way[upper], way[upper + 1], end


def _equal_bones(skeleton: Skeleton, p: tuple[int, int, int | None], q: tuple[int, int, int | None]) -> bool:
    """Whether the upper bones of two limbs are as long as each other, to a seventh: bodies are no more exact."""
    a, b = (float(np.linalg.norm(skeleton.offsets[limb[1]])) for limb in (p, q))
    return abs(a - b) < max(a, b) / 7


def _head_above(skeleton: Skeleton, chest: int, arms: tuple[int, int]) -> int | None:
    others = [c for c in skeleton.children[chest] if c not in arms]
    if not others:
        return None
    way = [max(others, key=lambda c: _reach(skeleton, c))]
    while skeleton.children[way[-1]]:
        way.append(skeleton.children[way[-1]][0])
    # a lone leaf without a tip is the crown; the head is the joint that carries it
    has_tip = any(s.parent == way[-1] for s in skeleton.end_sites)
    return way[-1] if has_tip or len(way) == 1 else way[-2]


def _upright(
    positions: Array, p: tuple[int, int, int | None], q: tuple[int, int, int | None], hip: int, chest: int
) -> bool:
    """Whether trunk and legs point opposite ways most of the time, as in people and not in four-footed animals."""
    trunk = positions[:, chest] - positions[:, hip]
    cosines = []
    for limb in (p, q):
        end = limb[2] if limb[2] is not None else limb[1]
        leg = positions[:, end] - positions[:, limb[0]]
        norm = np.linalg.norm(leg, axis=1) * np.linalg.norm(trunk, axis=1)
        cosines.append(np.sum(leg * trunk, axis=1) / np.maximum(norm, 1e-12))
    return bool(np.median(np.mean(cosines, axis=0)) < -0.5)


def _first_is_left(
    skeleton: Skeleton,
    positions: Array,
    p: tuple[int, int, int | None],
    q: tuple[int, int, int | None],
    hip: int,
    chest: int,
) -> bool | None:
    """Whether the first leg is the left one, by which way toes point and knees bend; None where neither tells."""
    up = positions[:, chest] - positions[:, hip]
    lateral = positions[:, p[0]] - positions[:, q[0]]
    forward_if_left = np.cross(lateral, up)
    forward_if_left /= np.maximum(np.linalg.norm(forward_if_left, axis=1, keepdims=True), 1e-12)
    told = 0.0
    for limb in (p, q):
        if limb[2] is None:
            continue
        leg = np.linalg.norm(positions[:, limb[0]] - positions[:, limb[2]], axis=1).max() + 1e-12
        # knees bend backwards: the knee lies ahead of the line from hip to ankle
        middle = (positions[:, limb[0]] + positions[:, limb[2]]) / 2
        told += float(np.mean(np.sum((positions[:, limb[1]] - middle) * forward_if_left, axis=1)) / leg)
        toes = skeleton.children[limb[2]]
        if toes:
            toe = positions[:, toes[0]] - positions[:, limb[2]]
            told += float(np.mean(np.sum(toe * forward_if_left, axis=1)) / leg)
    return None if abs(told) < _TOLD else told > 0


def _same_side(
    positions: Array,
    leg_p: tuple[int, int, int | None],
    leg_q: tuple[int, int, int | None],
    arm_p: tuple[int, int, int | None],
    arm_q: tuple[int, int, int | None],
) -> bool | None:
    """Whether the first arm is on the side of the first leg; None where shoulders and elbows do not tell."""
    hips = positions[:, leg_p[0]] - positions[:, leg_q[0]]
    across = sum(positions[:, arm_p[k]] - positions[:, arm_q[k]] for k in (0, 1))
    size = np.linalg.norm(hips, axis=1) * np.linalg.norm(across, axis=1)
    cosine = float(np.mean(np.sum(hips * across, axis=1) / np.maximum(size, 1e-12)))
    return None if abs(cosine) < 0.3 else cosine > 0
