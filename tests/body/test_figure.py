"""The human figure: closed, even-handed, of one piece with the skeleton it is bound to."""

from __future__ import annotations

import numpy as np
import pytest

import bodies
import kinesics as kx
from kinesics.body import anatomy, figure
from kinesics.body.anatomy import understood
from kinesics.body.skeleton import Skeleton
from kinesics.errors import SkeletonError
from kinesics.geometry import quaternion
from naive import skinning


def lame() -> kx.Motion:
    """Strides of a body whose left arm and leg are longer."""
    motion = bodies.legs_striding(7)
    offsets = motion.skeleton.offsets.copy()
    for name, factor in (("LeftLeg", 1.07), ("LeftFoot", 1.05), ("LeftForeArm", 1.1), ("LeftArm", 1.05)):
        offsets[motion.skeleton.find(name)] *= factor
    return motion.replace(skeleton=motion.skeleton.replace(offsets=offsets, anatomy=None))


def bound(fitted: figure.Figure) -> np.ndarray:
    """Local rotations of the joints in the binding pose."""
    world = fitted.bind_rotations[: len(fitted.joint_parents)]
    local = world.copy()
    local[1:] = quaternion.multiply(quaternion.conjugate(world[list(fitted.joint_parents[1:])]), world[1:])
    return local


@pytest.fixture(params=["performer", "small", "lame"])
def motion(request) -> kx.Motion:
    """Bodies with and without toes and collar bones, even and uneven."""
    made = {
        "performer": lambda: kx.performer.walk(seconds=3, fps=30).motion[:9],
        "small": lambda: bodies.legs_striding(7),
        "lame": lame,
    }
    return understood(made[request.param]())


def test_the_surface_is_closed_and_of_one_piece(motion) -> None:
    """Every edge belongs to two triangles, once in each direction, and there is no hole and no handle."""
    fitted = figure.fit(motion.skeleton)
    edges = fitted.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    assert len(np.unique(edges, axis=0)) == len(edges)
    undirected, uses = np.unique(np.sort(edges, axis=1), axis=0, return_counts=True)
    assert set(uses) == {2}
    assert len(fitted.vertices) - len(undirected) + len(fitted.triangles) == 2
    reached = np.zeros(len(fitted.vertices), dtype=bool)
    reached[0] = True
    while True:
        on = undirected[reached[undirected].any(axis=1)]
        if reached[on].all():
            break
        reached[on] = True
    assert reached.all()


def test_the_surface_has_the_volume_of_a_body_and_looks_outward(motion) -> None:
    """Its volume, signed, is that of a person of this stature, and its normals lean as its triangles do."""
    fitted = figure.fit(motion.skeleton)
    a, b, c = (fitted.vertices[fitted.triangles[:, k]] for k in range(3))
    flat = np.cross(b - a, c - a)
    stature = np.ptp(fitted.vertices[:, 1])
    # 75 litres at 1.78 m are 13.3 a cubed metre of stature
    assert 10.0 < np.einsum("ij,ij->", a, flat) / 6 / stature**3 * 1000 < 17.0
    np.testing.assert_allclose(np.linalg.norm(fitted.normals, axis=1), 1.0, atol=1e-12)
    for k in range(3):
        assert np.mean(np.einsum("ij,ij->i", flat, fitted.normals[fitted.triangles[:, k]]) > 0.0) > 0.99


def test_weights_are_shares(motion) -> None:
    """They are not negative, sum to 1, fall, and name joints of the skeleton."""
    fitted = figure.fit(motion.skeleton)
    assert fitted.weights.min() >= 0.0
    np.testing.assert_allclose(fitted.weights.sum(axis=1), 1.0, atol=1e-12)
    assert np.all(np.diff(fitted.weights, axis=1) <= 0.0)
    assert fitted.joints.min() >= 0
    assert fitted.joints.max() < motion.skeleton.joint_count + len(fitted.helpers)


def test_an_even_body_has_an_even_figure() -> None:
    """Left and right of equal lengths: vertices, normals and weights are those of the partner, mirrored."""
    fitted = figure.fit(understood(kx.performer.walk(seconds=3, fps=30).motion).skeleton)
    twin = fitted.partner
    np.testing.assert_array_equal(twin[twin], np.arange(len(twin)))
    flip = np.array([-1.0, 1.0, 1.0])
    np.testing.assert_allclose(fitted.vertices[twin] * flip, fitted.vertices, atol=1e-9)
    np.testing.assert_allclose(fitted.normals[twin] * flip, fitted.normals, atol=1e-9)
    np.testing.assert_allclose(fitted.weights[twin], fitted.weights, atol=1e-9)


def test_it_stands_on_the_ground_and_faces_ahead(motion) -> None:
    """The binding pose: soles at y = 0, nose and toes ahead, left to +x, the crown at some 1.2 times the shoulders."""
    fitted = figure.fit(motion.skeleton)
    v = fitted.vertices
    assert abs(v[:, 1].min()) < 0.01
    shoulder = fitted.bind_positions[motion.skeleton.find("LeftArm")]
    assert 1.15 < v[:, 1].max() / shoulder[1] < 1.35
    assert shoulder[0] > 0.0
    low = v[v[:, 1] < 0.05]
    assert low[:, 2].max() > 0.1 > -low[:, 2].min()
    head = v[v[:, 1] > 0.93 * v[:, 1].max()]
    assert abs(head[:, 0].mean()) < 0.01


def test_bones_run_inside_the_flesh(motion) -> None:
    """In every frame each joint with flesh lies at the middle of what follows it most: elbows in elbows, knees in knees."""
    fitted = figure.fit(motion.skeleton)
    skin, joints = fitted.posed(motion), motion.positions()
    for name in ("LeftLeg", "RightLeg", "LeftForeArm", "RightForeArm"):
        j = motion.skeleton.find(name)
        up = motion.skeleton.parents[j]
        # the seam: vertices that both bones pull at alike, or what stands halfway
        swings = {len(fitted.joint_parents) + k: h.swing for k, h in enumerate(fitted.helpers) if h.joint == j}
        lower = sum(
            share * np.where(fitted.joints == k, fitted.weights, 0.0).sum(axis=1) for k, share in swings.items()
        )
        lower = lower + np.where(fitted.joints == j, fitted.weights, 0.0).sum(axis=1)
        above = {
            len(fitted.joint_parents) + k for k, h in enumerate(fitted.helpers) if h.joint == up and h.swing == 1.0
        }
        upper = np.where(np.isin(fitted.joints, [up, *above, *swings]), fitted.weights, 0.0).sum(axis=1)
        upper -= lower - np.where(fitted.joints == j, fitted.weights, 0.0).sum(axis=1)
        both = [lower, upper]
        seam = (np.abs(both[0] - both[1]) < 0.25) & (both[0] + both[1] > 0.9)
        assert seam.sum() >= 8
        assert np.linalg.norm(skin[:, seam].mean(axis=1) - joints[:, j], axis=1).max() < 0.03


def test_skinning_agrees_with_its_definition(motion, rng) -> None:
    """World matrix times inverse binding matrix, weighted: for some vertices in all frames, within 1e-9 m."""
    fitted = figure.fit(motion.skeleton)
    inverse = [
        np.linalg.inv(skinning.placed(q, p)) for q, p in zip(fitted.bind_rotations, fitted.bind_positions, strict=True)
    ]
    skin = fitted.posed(motion)
    for frame in range(0, motion.frame_count, 3):
        turns = motion.rotations[frame]
        matrices = skinning.world_matrices(motion.skeleton, turns, motion.root_positions[frame])
        for helper in fitted.helpers:
            j = helper.joint
            turn = quaternion.multiply(turns[j], quaternion.conjugate(bound(fitted)[j]))
            own = skinning.helped(turn, helper.axis, helper.swing, helper.twist)
            place = motion.skeleton.offsets[j]
            matrices.append(matrices[motion.skeleton.parents[j]] @ skinning.placed(own, place))
        for v in rng.integers(0, len(fitted.vertices), 40):
            twin = skinning.skinned(fitted.vertices[v], fitted.joints[v], fitted.weights[v], inverse, matrices)
            assert np.abs(skin[frame, v] - twin).max() < 1e-9


def test_in_the_binding_pose_the_joints_are_where_they_are_bound(motion) -> None:
    """Local rotations that lead to the binding pose give its joints and its vertices back."""
    fitted = figure.fit(motion.skeleton)
    still = motion.replace(rotations=bound(fitted)[None], root_positions=fitted.bind_positions[:1])
    np.testing.assert_allclose(still.positions()[0], fitted.bind_positions[: motion.skeleton.joint_count], atol=1e-12)
    np.testing.assert_allclose(fitted.posed(still)[0], fitted.vertices, atol=1e-12)
    upright = kx.poses(still).quaternions[0]
    arms = [9, 13]
    others = [k for k in range(15) if k not in arms]
    assert quaternion.angle(upright[others]).max() < 1e-6
    np.testing.assert_allclose(quaternion.angle(upright[arms]), figure.ARMS_DOWN, atol=1e-6)


def test_the_mirror_law_holds_for_the_skin(motion) -> None:
    """The figure of the mirrored motion is the mirror image of the figure: vertex by partner, x negated, within 1e-6 m."""
    seen = kx.mirror(motion)
    first, second = figure.fit(motion.skeleton), figure.fit(seen.skeleton)
    image = first.posed(motion)[:, first.partner] * [-1.0, 1.0, 1.0]
    assert np.abs(second.posed(seen) - image).max() < 1e-6


def test_limbs_keep_their_thickness_when_they_bend() -> None:
    """With elbows and knees at 90° no part of the skin comes nearer to its bone than half of what it was."""
    motion = understood(bodies.legs_striding(1))
    skeleton = motion.skeleton
    fitted = figure.fit(skeleton)
    local = bound(fitted)
    for name, axis, angle in (("LeftForeArm", [0, 1, 0], -1.57), ("LeftLeg", [1, 0, 0], 1.57)):
        j = skeleton.find(name)
        bent = local.copy()
        bent[j] = quaternion.multiply(local[j], quaternion.from_axis_angle(np.array(axis, dtype=float), angle))
        pose = motion.replace(rotations=bent[None], root_positions=fitted.bind_positions[:1])
        near = np.linalg.norm(fitted.vertices - fitted.bind_positions[j], axis=1) < 0.09
        before = np.linalg.norm(fitted.vertices[near] - fitted.bind_positions[j], axis=1).min()
        after = np.linalg.norm(fitted.posed(pose)[0][near] - pose.positions()[0, j], axis=1).min()
        assert after > 0.5 * before


def test_what_is_no_body_gets_no_figure() -> None:
    """A skeleton without anatomy is refused, and one whose bones have no length."""
    motion = bodies.legs_striding(1)
    with pytest.raises(SkeletonError, match="not understood"):
        figure.fit(motion.skeleton.replace(anatomy=None))
    body = anatomy.understood(motion).skeleton
    with pytest.raises(SkeletonError, match="length"):
        figure.fit(body.replace(offsets=body.offsets * 0.0))


# -------------------------------------------------------------------------------------------------- poses far from rest


def turned(fitted: figure.Figure, skeleton: Skeleton, **away: tuple[str, float]) -> kx.Motion:
    """The binding pose with parts turned about a world axis, with what hangs on them: "femur" both, the right side mirrored."""
    local = bound(fitted)
    world = fitted.bind_rotations[: skeleton.joint_count]
    for part, (axis, degrees) in away.items():
        direction = np.eye(3)["xyz".index(axis)]
        for side in ("left", "right"):
            sign = -1.0 if side == "right" and axis != "x" else 1.0
            j = getattr(skeleton.anatomy.roles, f"{side}_{part}")
            parent = quaternion.conjugate(world[skeleton.parents[j]])
            turn = quaternion.from_axis_angle(quaternion.rotate(parent, direction), sign * np.radians(degrees))
            local[j] = quaternion.multiply(turn, local[j])
    return kx.Motion(skeleton, local[None], fitted.bind_positions[:1], 30.0)


def volume(skin: np.ndarray, triangles: np.ndarray) -> float:
    """Enclosed by a surface."""
    a, b, c = (skin[triangles[:, k]] for k in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)


EXTREMES = {
    "arms up": {"humerus": ("z", 130.0)},
    "arms at the sides": {"humerus": ("z", -35.0)},
    "arms forward": {"humerus": ("y", -85.0)},
    "squat": {"femur": ("x", -105.0), "tibia": ("x", 130.0)},
    "legs apart": {"femur": ("z", 60.0)},
    "elbows bent": {"radius": ("y", -140.0)},
}


@pytest.mark.parametrize("away", EXTREMES.values(), ids=EXTREMES)
def test_flesh_neither_collapses_nor_swells(motion, away) -> None:
    """Far from the binding pose the figure keeps its volume within 4 %."""
    fitted = figure.fit(motion.skeleton)
    skin = fitted.posed(turned(fitted, motion.skeleton, **away))[0]
    assert volume(skin, fitted.triangles) / volume(fitted.vertices, fitted.triangles) == pytest.approx(1.0, abs=0.04)


@pytest.mark.parametrize(
    ("away", "part"),
    [
        ("arms up", "humerus"),
        ("arms forward", "humerus"),
        ("squat", "femur"),
        ("squat", "tibia"),
        ("legs apart", "femur"),
    ],
)
def test_joints_stay_covered(motion, away, part) -> None:
    """Far from the binding pose no skin comes nearer to the joint that turns than six tenths of what it was."""
    fitted = figure.fit(motion.skeleton)
    posed = turned(fitted, motion.skeleton, **EXTREMES[away])
    j = getattr(motion.skeleton.anatomy.roles, f"left_{part}")
    before = np.linalg.norm(fitted.vertices - fitted.bind_positions[j], axis=1).min()
    after = np.linalg.norm(fitted.posed(posed)[0] - posed.positions()[0, j], axis=1).min()
    assert after > 0.6 * before


@pytest.mark.parametrize(("part", "upper", "lower"), [("humerus", "Arm", "ForeArm"), ("radius", "ForeArm", "Hand")])
def test_a_twist_wrings_no_limb(motion, part, upper, lower) -> None:
    """A bone twisted by 90°: no place of it loses more than a quarter of its distance from its axis; and the skin does twist."""
    fitted = figure.fit(motion.skeleton)
    skeleton = motion.skeleton
    a, b = (fitted.bind_positions[skeleton.find(f"Left{name}")] for name in (upper, lower))
    axis = (b - a) / np.linalg.norm(b - a)
    local = bound(fitted)
    j = getattr(skeleton.anatomy.roles, f"left_{part}")
    parent = quaternion.conjugate(fitted.bind_rotations[skeleton.parents[j]])
    turn = quaternion.from_axis_angle(quaternion.rotate(parent, axis), np.pi / 2)
    local[j] = quaternion.multiply(turn, local[j])
    still = kx.Motion(skeleton, local[None], fitted.bind_positions[:1], 30.0)

    def off_axis(skin: np.ndarray) -> np.ndarray:
        return np.linalg.norm(np.cross(skin - a, axis), axis=1)

    along = (fitted.vertices - a) @ axis / np.linalg.norm(b - a)
    bone = (along > 0.35) & (along < 0.95) & (off_axis(fitted.vertices) < 0.1)
    skin = fitted.posed(still)[0]
    assert bone.sum() > 100
    assert (off_axis(skin)[bone] / off_axis(fitted.vertices)[bone]).min() > 0.75
    assert np.linalg.norm(skin - fitted.vertices, axis=1)[bone].max() > 0.04


def test_a_twist_beyond_half_a_turn_does_not_jump() -> None:
    """A forearm that turns steadily once about itself: helpers turn steadily with it."""
    motion = understood(bodies.legs_striding(1))
    fitted = figure.fit(motion.skeleton)
    (helper,) = (h for h in fitted.helpers if h.name == "LeftForeArm_swing")
    frames = 73
    local = np.repeat(bound(fitted)[None], frames, axis=0)
    turns = quaternion.from_axis_angle(helper.axis, np.linspace(0.0, 2.0 * np.pi, frames))
    local[:, helper.joint] = quaternion.multiply(turns, local[:, helper.joint])
    helped = fitted.helper_rotations(local)[:, fitted.helpers.index(helper)]
    np.testing.assert_allclose(quaternion.angle(helped[1:], helped[:-1]), helper.twist * np.radians(5.0), atol=1e-9)


def test_the_figure_does_not_cut_itself_where_it_is_bound(motion) -> None:
    """In the binding pose no edge of the surface goes through a triangle that it does not touch."""
    fitted = figure.fit(motion.skeleton)
    assert not skinning.crossings(fitted.vertices, fitted.triangles)
