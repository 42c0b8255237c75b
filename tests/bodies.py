"""A small human figure and a few movements of it, for tests that need a motion and not a recording."""

from __future__ import annotations

import numpy as np

from kinesics.body.motion import Motion, Source
from kinesics.body.skeleton import EndSite, Skeleton
from kinesics.geometry import quaternion

_JOINTS: list[tuple[str, str, tuple[float, float, float]]] = [
    ("Hips", "", (0.0, 0.0, 0.0)),
    ("Spine", "Hips", (0.0, 0.12, 0.0)),
    ("Chest", "Spine", (0.0, 0.18, 0.0)),
    ("Neck", "Chest", (0.0, 0.2, 0.0)),
    ("Head", "Neck", (0.0, 0.1, 0.0)),
    *(
        joint
        for side, sign in (("Left", 1.0), ("Right", -1.0))
        for joint in (
            (f"{side}Arm", "Chest", (0.18 * sign, 0.16, 0.0)),
            (f"{side}ForeArm", f"{side}Arm", (0.28 * sign, 0.0, 0.0)),
            (f"{side}Hand", f"{side}ForeArm", (0.25 * sign, 0.0, 0.0)),
            (f"{side}UpLeg", "Hips", (0.1 * sign, -0.04, 0.0)),
            (f"{side}Leg", f"{side}UpLeg", (0.0, -0.42, 0.0)),
            (f"{side}Foot", f"{side}Leg", (0.0, -0.41, 0.0)),
        )
    ),
]


def human() -> Skeleton:
    """Seventeen joints in a T-pose facing +z."""
    names = [name for name, _, _ in _JOINTS]
    sites = [
        EndSite(names.index("Head"), (0.0, 0.2, 0.0)),
        *(EndSite(names.index(f"{side}Foot"), (0.0, -0.06, 0.15)) for side in ("Left", "Right")),
    ]
    return Skeleton(
        joint_names=tuple(names),
        parents=tuple(names.index(parent) if parent else -1 for _, parent, _ in _JOINTS),
        offsets=np.array([offset for _, _, offset in _JOINTS]),
        end_sites=tuple(sites),
        name="human",
    )


def moving(
    angles: dict[str, np.ndarray[tuple[int, ...], np.dtype[np.float64]]],
    *,
    fps: float = 60.0,
    file_name: str = "",
    sha256: str = "",
) -> Motion:
    """Joints turned by rotation vectors in radians, shape (frames, 3); the others rest."""
    skeleton = human()
    frames = len(next(iter(angles.values())))
    rotations = quaternion.identity((frames, skeleton.joint_count))
    for name, vectors in angles.items():
        rotations[:, skeleton.find(name)] = quaternion.from_rotvec(vectors)
    roots = np.tile([0.0, 0.9, 0.0], (frames, 1))
    source = Source(format="bvh", file_name=file_name, sha256=sha256)
    return Motion(skeleton, rotations, roots, fps, name=file_name, source=source)


def about(
    axis: int, angle: np.ndarray[tuple[int, ...], np.dtype[np.float64]]
) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    """Rotation vectors about the x (0), y (1) or z (2) axis, shape (frames, 3)."""
    out = np.zeros((len(angle), 3))
    out[:, axis] = angle
    return out


def arms_swinging(
    frames: int = 240, *, fps: float = 60.0, period: float = 2.0, mirrored: bool = True, **names: str
) -> Motion:
    """Both arms up and down together (mirrored), or only the left one."""
    t = np.arange(frames) / fps
    swing = 0.8 * np.sin(2.0 * np.pi * t / period)
    angles = {"LeftArm": about(2, swing)}
    if mirrored:
        angles["RightArm"] = about(2, -swing)
    return moving(angles, fps=fps, **names)


def legs_striding(frames: int = 240, *, fps: float = 60.0, period: float = 1.0, **names: str) -> Motion:
    """Legs and arms in anti-phase, knees bending: a walk on the spot."""
    phase = 2.0 * np.pi * np.arange(frames) / fps / period
    return moving(
        {
            "LeftUpLeg": about(0, 0.5 * np.sin(phase)),
            "RightUpLeg": about(0, -0.5 * np.sin(phase)),
            "LeftLeg": about(0, 0.4 + 0.4 * np.cos(phase)),
            "RightLeg": about(0, 0.4 - 0.4 * np.cos(phase)),
            "LeftArm": about(1, 0.4 * np.sin(phase)),
            "RightArm": about(1, 0.4 * np.sin(phase)),
        },
        fps=fps,
        **names,
    )


def rounds(seconds: float = 16.0, *, fps: float = 30.0, lead: float = 0.0, speed: float = 1.2) -> Motion:
    """A march that bends to the left, arms and legs together, now wider and now less, after ``lead`` seconds of reaching up."""
    t = np.arange(round(seconds * fps)) / fps
    swing = (1.0 + 0.15 * np.sin(2.0 * np.pi * 0.13 * t)) * np.sin(2.0 * np.pi * 0.9 * t)
    up = 1.5 * np.clip(1.0 - t / lead, 0.0, 1.0) if lead else np.zeros_like(t)
    turned = 0.12 * t**1.2
    angles = {"Hips": about(1, turned), "Neck": about(0, up)}
    for side, sign in (("Left", 1.0), ("Right", -1.0)):
        angles[f"{side}UpLeg"] = about(0, 0.5 * sign * swing)
        angles[f"{side}Leg"] = about(0, 0.4 + 0.3 * sign * swing)
        angles[f"{side}Arm"] = about(0, -0.4 * sign * swing - up)
    motion = moving(angles, fps=fps, file_name="rounds")
    steps = np.stack([np.sin(turned), np.zeros_like(t), np.cos(turned)], axis=1) * speed / fps
    return motion.replace(root_positions=motion.root_positions + np.cumsum(steps, axis=0))
