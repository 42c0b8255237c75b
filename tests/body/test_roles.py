"""Which joint is which part of the body, for every naming in use, and who is refused."""

from __future__ import annotations

import numpy as np
import pytest

from kinesics.body import joint_names, mirroring, roles
from kinesics.body import tree as tree_of_joints
from kinesics.body.skeleton import EndSite, Skeleton
from kinesics.errors import InputError, SkeletonError

# joint: parent, in the order of the file; only the tree matters here
NAMINGS: dict[str, tuple[str, dict[str, str]]] = {
    "cmu-asf": (
        "root:- lhipjoint:root lfemur:lhipjoint ltibia:lfemur lfoot:ltibia ltoes:lfoot rhipjoint:root rfemur:rhipjoint "
        "rtibia:rfemur rfoot:rtibia rtoes:rfoot lowerback:root upperback:lowerback thorax:upperback lowerneck:thorax "
        "upperneck:lowerneck head:upperneck lclavicle:thorax lhumerus:lclavicle lradius:lhumerus lwrist:lradius "
        "lhand:lwrist lfingers:lhand lthumb:lwrist rclavicle:thorax rhumerus:rclavicle rradius:rhumerus rwrist:rradius "
        "rhand:rwrist rfingers:rhand rthumb:rwrist",
        {
            "left_femur": "lfemur",
            "right_radius": "rradius",
            "left_hand": "lwrist",
            "pelvis": "root",
            "left_toes": "ltoes",
        },
    ),
    "cgspeed": (
        "Hips:- LHipJoint:Hips LeftUpLeg:LHipJoint LeftLeg:LeftUpLeg LeftFoot:LeftLeg LeftToeBase:LeftFoot RHipJoint:Hips "
        "RightUpLeg:RHipJoint RightLeg:RightUpLeg RightFoot:RightLeg RightToeBase:RightFoot LowerBack:Hips Spine:LowerBack "
        "Spine1:Spine Neck:Spine1 Neck1:Neck Head:Neck1 LeftShoulder:Spine1 LeftArm:LeftShoulder LeftForeArm:LeftArm "
        "LeftHand:LeftForeArm LeftFingerBase:LeftHand LThumb:LeftHand RightShoulder:Spine1 RightArm:RightShoulder "
        "RightForeArm:RightArm RightHand:RightForeArm RightFingerBase:RightHand RThumb:RightHand",
        {
            "left_femur": "LeftUpLeg",
            "left_tibia": "LeftLeg",
            "left_humerus": "LeftArm",
            "left_clavicle": "LeftShoulder",
        },
    ),
    "mixamo": (
        "mixamorig:Hips:- mixamorig:Spine:mixamorig:Hips mixamorig:Spine1:mixamorig:Spine "
        "mixamorig:Spine2:mixamorig:Spine1 mixamorig:Neck:mixamorig:Spine2 mixamorig:Head:mixamorig:Neck "
        "mixamorig:HeadTop_End:mixamorig:Head "
        + " ".join(
            f"mixamorig:{s}Shoulder:mixamorig:Spine2 mixamorig:{s}Arm:mixamorig:{s}Shoulder "
            f"mixamorig:{s}ForeArm:mixamorig:{s}Arm mixamorig:{s}Hand:mixamorig:{s}ForeArm "
            f"mixamorig:{s}HandIndex1:mixamorig:{s}Hand mixamorig:{s}UpLeg:mixamorig:Hips "
            f"mixamorig:{s}Leg:mixamorig:{s}UpLeg mixamorig:{s}Foot:mixamorig:{s}Leg "
            f"mixamorig:{s}ToeBase:mixamorig:{s}Foot mixamorig:{s}Toe_End:mixamorig:{s}ToeBase"
            for s in ("Left", "Right")
        ),
        {"head": "mixamorig:Head", "right_tibia": "mixamorig:RightLeg", "right_hand": "mixamorig:RightHand"},
    ),
    "lafan1": (
        "Hips:- Spine:Hips Spine1:Spine Spine2:Spine1 Neck:Spine2 Head:Neck "
        + " ".join(
            f"{s}UpLeg:Hips {s}Leg:{s}UpLeg {s}Foot:{s}Leg {s}Toe:{s}Foot {s}Shoulder:Spine2 {s}Arm:{s}Shoulder "
            f"{s}ForeArm:{s}Arm {s}Hand:{s}ForeArm"
            for s in ("Left", "Right")
        ),
        {"left_toes": "LeftToe", "spine": "Spine, Spine1, Spine2", "neck": "Neck"},
    ),
    "bandai-namco": (
        "joint_Root:- Hips:joint_Root Spine:Hips Chest:Spine Neck:Chest Head:Neck "
        + " ".join(
            f"Shoulder_{s}:Chest UpperArm_{s}:Shoulder_{s} LowerArm_{s}:UpperArm_{s} Hand_{s}:LowerArm_{s} "
            f"UpperLeg_{s}:Hips LowerLeg_{s}:UpperLeg_{s} Foot_{s}:LowerLeg_{s} Toes_{s}:Foot_{s}"
            for s in "LR"
        ),
        {"pelvis": "Hips", "spine": "Spine, Chest", "right_humerus": "UpperArm_R", "left_tibia": "LowerLeg_L"},
    ),
    "xsens": (
        "Hips:- Chest:Hips Chest2:Chest Chest3:Chest2 Chest4:Chest3 Neck:Chest4 Head:Neck "
        + " ".join(
            f"{s}Collar:Chest4 {s}Shoulder:{s}Collar {s}Elbow:{s}Shoulder {s}Wrist:{s}Elbow {s}Hip:Hips {s}Knee:{s}Hip "
            f"{s}Ankle:{s}Knee {s}Toe:{s}Ankle"
            for s in ("Left", "Right")
        ),
        {
            "left_humerus": "LeftShoulder",
            "left_radius": "LeftElbow",
            "right_femur": "RightHip",
            "right_foot": "RightAnkle",
        },
    ),
    "rokoko": (
        "Hips:- Spine1:Hips Spine2:Spine1 Spine3:Spine2 Spine4:Spine3 Neck:Spine4 Head:Neck "
        + " ".join(
            f"{s}Shoulder:Spine4 {s}Arm:{s}Shoulder {s}ForeArm:{s}Arm {s}Hand:{s}ForeArm {s}Thigh:Hips {s}Shin:{s}Thigh "
            f"{s}Foot:{s}Shin {s}Toe:{s}Foot"
            for s in ("Left", "Right")
        ),
        {"left_femur": "LeftThigh", "left_tibia": "LeftShin", "spine": "Spine1, Spine2, Spine3, Spine4"},
    ),
    "smpl": (
        "Pelvis:- Spine1:Pelvis Spine2:Spine1 Spine3:Spine2 Neck:Spine3 Head:Neck "
        + " ".join(
            f"{s}_Hip:Pelvis {s}_Knee:{s}_Hip {s}_Ankle:{s}_Knee {s}_Foot:{s}_Ankle {s}_Collar:Spine3 "
            f"{s}_Shoulder:{s}_Collar {s}_Elbow:{s}_Shoulder {s}_Wrist:{s}_Elbow {s}_Hand:{s}_Wrist"
            for s in "LR"
        ),
        {"left_foot": "L_Ankle", "left_toes": "L_Foot", "left_hand": "L_Wrist", "right_humerus": "R_Shoulder"},
    ),
    "biped": (
        "Bip01:- Bip01 Pelvis:Bip01 Bip01 Spine:Bip01 Pelvis Bip01 Spine1:Bip01 Spine Bip01 Neck:Bip01 Spine1 "
        "Bip01 Head:Bip01 Neck "
        + " ".join(
            f"Bip01 {s} Clavicle:Bip01 Neck Bip01 {s} UpperArm:Bip01 {s} Clavicle Bip01 {s} Forearm:Bip01 {s} UpperArm "
            f"Bip01 {s} Hand:Bip01 {s} Forearm Bip01 {s} Thigh:Bip01 Spine Bip01 {s} Calf:Bip01 {s} Thigh "
            f"Bip01 {s} Foot:Bip01 {s} Calf Bip01 {s} Toe0:Bip01 {s} Foot"
            for s in "LR"
        ),
        {"left_femur": "Bip01 L Thigh", "right_tibia": "Bip01 R Calf", "pelvis": "Bip01 Spine"},
    ),
    "unreal": (
        "root:- pelvis:root spine_01:pelvis spine_02:spine_01 spine_03:spine_02 neck_01:spine_03 head:neck_01 "
        + " ".join(
            f"clavicle_{s}:spine_03 upperarm_{s}:clavicle_{s} upperarm_twist_01_{s}:upperarm_{s} lowerarm_{s}:upperarm_{s} "
            f"hand_{s}:lowerarm_{s} thigh_{s}:pelvis calf_{s}:thigh_{s} foot_{s}:calf_{s} ball_{s}:foot_{s}"
            for s in "lr"
        ),
        {"pelvis": "pelvis", "left_radius": "lowerarm_l", "right_toes": "ball_r", "left_clavicle": "clavicle_l"},
    ),
    "rigify": (
        "spine:- spine.001:spine spine.002:spine.001 spine.003:spine.002 neck:spine.003 head:neck "
        + " ".join(
            f"shoulder.{s}:spine.003 upper_arm.{s}:shoulder.{s} forearm.{s}:upper_arm.{s} hand.{s}:forearm.{s} "
            f"thigh.{s}:spine shin.{s}:thigh.{s} foot.{s}:shin.{s} toe.{s}:foot.{s}"
            for s in "LR"
        ),
        {"left_humerus": "upper_arm.L", "right_tibia": "shin.R", "left_clavicle": "shoulder.L"},
    ),
    "leg and shin": (
        "Hips:- Spine:Hips Chest:Spine Neck:Chest Head:Neck "
        + " ".join(
            f"{s}Leg:Hips {s}Shin:{s}Leg {s}Foot:{s}Shin {s}Shoulder:Chest {s}Elbow:{s}Shoulder {s}Wrist:{s}Elbow"
            for s in ("Left", "Right")
        ),
        {"left_femur": "LeftLeg", "right_tibia": "RightShin", "left_humerus": "LeftShoulder"},
    ),
}
NAMELESS = {"unreal", "rigify", "leg and shin"}
"""Understood, but called by no name of their own."""


def tree(text: str) -> Skeleton:
    """A skeleton from "name:parent" pairs; names may hold colons and spaces, so pairs are cut at known names."""
    names: list[str] = []
    parents: list[int] = []
    rest = text
    while rest:
        # the parent is the longest known name (or "-") that the next pair can end in
        best = None
        for known in [*names, "-"]:
            at = rest.find(":" + known)
            while at >= 0:
                end = at + 1 + len(known)
                if end == len(rest) or rest[end] == " ":
                    key = (at, -len(known))
                    if best is None or key < best[0]:
                        best = (key, known, end)
                at = rest.find(":" + known, at + 1)
        assert best is not None, rest
        (at, _), parent, end = best
        names.append(rest[:at])
        parents.append(-1 if parent == "-" else names.index(parent))
        rest = rest[end + 1 :]
    return Skeleton(tuple(names), tuple(parents), np.ones((len(names), 3)))


@pytest.mark.parametrize("naming", NAMINGS)
def test_known_namings_are_understood(naming: str) -> None:
    """Every naming in use gives its links their joints, left and right not exchanged."""
    text, expected = NAMINGS[naming]
    skeleton = tree(text)
    named = roles.identify(skeleton).named(skeleton)
    assert {role: named.get(role) for role in expected} == expected
    assert joint_names.naming_of(skeleton) == ("left-right" if naming in NAMELESS else naming)
    for side, letter in (("left", "l"), ("right", "r")):
        for part in ("femur", "tibia", "humerus", "radius"):
            assert joint_names.split_name(named[f"{side}_{part}"]).side == side, (letter, named)


@pytest.mark.parametrize("naming", NAMINGS)
def test_partners_pair_left_with_right(naming: str) -> None:
    """The mirror swaps each sided joint with its namesake and leaves the midline; twice is the identity."""
    skeleton = tree(NAMINGS[naming][0])
    partner = mirroring.partners(skeleton, roles.identify(skeleton))
    for j, k in enumerate(partner):
        assert partner[k] == j
        sides = {
            joint_names.split_name(skeleton.joint_names[j]).side,
            joint_names.split_name(skeleton.joint_names[k]).side,
        }
        assert sides in ({"left", "right"}, {""})


@pytest.mark.parametrize(
    ("text", "missing"),
    [
        ("wrist:- thumb1:wrist thumb2:thumb1 index1:wrist index2:index1", "left_femur"),
        (
            "Hips:- Spine:Hips Neck:Spine Head:Neck LeftArm:Spine LeftForeArm:LeftArm RightArm:Spine RightForeArm:RightArm",
            "right_femur",
        ),
        (
            "Hips:- LeftUpLeg:Hips LeftLeg:LeftUpLeg RightUpLeg:Hips RightLeg:RightUpLeg Spine:Hips Head:Spine",
            "left_humerus",
        ),
    ],
)
def test_half_a_body_is_refused_with_what_is_missing(text: str, missing: str) -> None:
    """A hand, an upper body and a lower body are refused with the list of what was found and what is missing."""
    skeleton = tree(text)
    with pytest.raises(SkeletonError, match=missing) as caught:
        roles.identify(skeleton, np.ones((3, skeleton.joint_count, 3)))
    assert missing in caught.value.missing
    assert "--map" in str(caught.value)


def test_a_dog_is_refused_though_its_joints_have_human_names() -> None:
    """A quadruped rig with human limb names is told by its tail."""
    text = NAMINGS["lafan1"][0] + " Tail:Hips Tail1:Tail"
    with pytest.raises(SkeletonError, match="Tail"):
        roles.identify(tree(text))


def test_the_user_may_name_joints() -> None:
    """A mapping fills in what the names do not tell, and unknown roles or joints are named in the error."""
    text = NAMINGS["lafan1"][0].replace("LeftUpLeg", "LimbA").replace("LeftLeg", "LimbB").replace("LeftFoot", "LimbC")
    skeleton = tree(text)
    with pytest.raises(SkeletonError, match="left_femur"):
        roles.identify(skeleton)
    mapping = {"joints": {"left_femur": "LimbA", "left_tibia": "LimbB", "left_foot": "LimbC"}}
    found = roles.identify(skeleton, mapping=mapping)
    assert skeleton.joint_names[found.left_tibia] == "LimbB"
    with pytest.raises(InputError, match=r"'LimbZ'.*LimbA"):
        roles.identify(skeleton, mapping={"joints": {"left_femur": "LimbZ"}})
    with pytest.raises(InputError, match=r"'left_leg'.*left_tibia"):
        roles.identify(skeleton, mapping={"joints": {"left_leg": "LimbB"}})


def test_an_impossible_tree_is_refused() -> None:
    """A shank that does not hang on its thigh is no leg."""
    text = NAMINGS["lafan1"][0].replace("LeftLeg:LeftUpLeg", "LeftLeg:RightUpLeg").replace("RightUpLeg:Hips ", "")
    text = text.replace("Hips:- ", "Hips:- RightUpLeg:Hips ")
    with pytest.raises(SkeletonError, match="left_tibia"):
        roles.identify(tree(text))


def test_unpaired_branches_keep_their_place_in_the_mirror() -> None:
    """A prop on the midline stays; a limb with a finger too many has no mirror image."""
    skeleton = tree(NAMINGS["lafan1"][0] + " Hat:Head")
    partner = mirroring.partners(skeleton, roles.identify(skeleton))
    assert partner[skeleton.find("Hat")] == skeleton.find("Hat")
    lame = tree(NAMINGS["lafan1"][0] + " Sword:LeftHand")
    with pytest.raises(SkeletonError, match="Sword"):
        mirroring.partners(lame, roles.identify(lame))


def test_end_sites_do_not_disturb() -> None:
    """Tips hang on joints and are no joints."""
    skeleton = tree(NAMINGS["smpl"][0]).replace(end_sites=(EndSite(5, (0.0, 0.1, 0.0)),))
    assert skeleton.joint_names[roles.identify(skeleton).head] == "Head"


def test_the_longest_way_down_is_that_of_all_ways(rng: np.random.Generator) -> None:
    """For each joint the greatest sum of bone lengths to any joint or tip below it."""
    parents = (-1, *(int(rng.integers(0, k)) for k in range(1, 30)))
    tips = tuple(EndSite(j, (0.0, float(j), 1.0)) for j in (3, 17, 29))
    skeleton = Skeleton(tuple(f"j{k}" for k in range(30)), parents, rng.normal(size=(30, 3)), tips)
    below = [0.0] * 30
    for joint, last in [(j, 0.0) for j in range(30)] + [(t.parent, float(np.linalg.norm(t.offset))) for t in tips]:
        length = last
        while joint >= 0:
            below[joint] = max(below[joint], length)
            length += float(np.linalg.norm(skeleton.offsets[joint]))
            joint = parents[joint]
    np.testing.assert_allclose(tree_of_joints.reaches(skeleton), below, rtol=1e-12)


def test_a_forked_skeleton_as_deep_as_a_well_is_looked_at() -> None:
    """Two branches of two thousand joints are no body, and no recursion either."""
    parents = (-1, 0, *range(1, 2000), 0, *range(2001, 4000))
    skeleton = Skeleton(tuple(f"j{k}" for k in range(4001)), parents, np.ones((4001, 3)))
    with pytest.raises(SkeletonError, match="cannot be understood"):
        roles.identify(skeleton, np.ones((1, 4001, 3)))


def test_sides_of_what_is_no_human_body_are_told_by_names() -> None:
    """Wings change places and the tail does not; Tip1 with Tip1, whatever their order in the file."""
    skeleton = tree(
        "Root:- LeftWing:Root LeftTip1:LeftWing LeftTip2:LeftWing Tail:Root RightWing:Root RightTip2:RightWing "
        "RightTip1:RightWing"
    )
    partner = mirroring.partners(skeleton)
    told = {a: skeleton.joint_names[partner[j]] for j, a in enumerate(skeleton.joint_names)}
    swapped = {"LeftWing": "RightWing", "LeftTip1": "RightTip1", "LeftTip2": "RightTip2"}
    assert told == {"Root": "Root", "Tail": "Tail", **swapped, **{b: a for a, b in swapped.items()}}
