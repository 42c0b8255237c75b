"""What the names of joints tell: the side, the part of the body, the convention that they follow.

Known are CMU ASF, cgspeed and its kin, Mixamo, LaFAN1, Bandai-Namco, Xsens, Rokoko, SMPL, 3ds Max Biped, Rigify, and generic
Left/Right, L/R, ``_L``/``.R`` affixes.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from kinesics.body.skeleton import Skeleton

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
class Name:
    """A joint's name, taken apart."""

    side: str
    """left, right or ""."""
    base: str
    """Lower case letters only."""


def split_name(name: str) -> Name:
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
    return Name(side, base)


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


def numbered(name: str, split: Name) -> str:
    """The bare word with its digits, so that Index1 pairs with Index1."""
    return split.base + "".join(re.findall(r"\d+", re.split(r"[:|/]", name)[-1]))


def of_an_animal(skeleton: Skeleton) -> list[str]:
    """Names that only a four-footed animal's joints have."""
    return [n for n in skeleton.joint_names if _QUADRUPED.search(_snake(n))]


def _snake(name: str) -> str:
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", name).lower()
