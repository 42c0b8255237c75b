"""A slow, obvious twin of `kinesics.synthesis.embodiment.ranges`: one joint at one moment, slopes by small differences."""

from __future__ import annotations

import numpy as np

from kinesics.geometry import quaternion


def bend(stage, joint: int, q: np.ndarray, bone: np.ndarray) -> float:
    """The angle between a bone that hangs on a joint and the bone before, radians, 0 straight on."""
    before = stage.repertoire.skeleton.offsets[joint]
    here = quaternion.rotate(q, bone)
    cosine = before @ here / np.linalg.norm(before) / np.linalg.norm(here)
    return float(np.arccos(np.clip(cosine, -1.0, 1.0)))


def side(before: np.ndarray, bone: np.ndarray) -> float:
    """To which side of straight on a bone is bent, radians around the bone before."""
    before = before / np.linalg.norm(before)
    aside = np.cross(before, np.eye(3)[np.argmin(np.abs(before))])
    return float(np.arctan2(bone @ np.cross(before, aside), bone @ aside))


def bones(stage, joint: int) -> list[np.ndarray]:
    """Those that hang on a joint which hangs on a bone itself, and is not one that carries the body whole."""
    skeleton = stage.repertoire.skeleton
    if joint <= stage.carrier or np.linalg.norm(skeleton.offsets[joint]) <= 1e-3:
        return []
    found = [skeleton.offsets[c] for c in range(skeleton.joint_count) if skeleton.parents[c] == joint]
    found += [np.array(site.offset) for site in skeleton.end_sites if site.parent == joint]
    return [bone for bone in found if np.linalg.norm(bone) > 1e-3]


def limits(stage, joint: int) -> list[tuple[float, float]]:
    """Least and greatest angle of each of its bones in the recordings, mirrored counted; within 1° of straight is straight."""
    own = stage.repertoire
    out = []
    for bone in bones(stage, joint):
        images = (0, 1) if own.mirrored else (0,)
        angles = [bend(stage, joint, q, bone) for image in images for q in own.rotations[image, :, joint]]
        least, most = min(angles), max(angles)
        before = own.skeleton.offsets[joint]
        towards = sorted(
            side(before, quaternion.rotate(q, bone)) for image in images for q in own.rotations[image, :, joint]
        )
        gaps = [b - a for a, b in zip(towards, [*towards[1:], towards[0] + 2.0 * np.pi], strict=True)]
        if max(gaps) < np.pi:
            least = 0.0  # bent to all sides of straight, which then lies between
        out.append((0.0 if least < np.deg2rad(1.0) else least, np.pi if most > np.deg2rad(179.0) else most))
    return out


def within(stage, joint: int, vector: np.ndarray, known=None) -> np.ndarray:
    """A rotation vector from the mean, brought into its range.

    Parameters
    ----------
    known : what `limits` gives, where known.
    """
    low, high = stage.low[joint], stage.high[joint]
    ends = limits(stage, joint) if known is None else known

    def angles(v: np.ndarray) -> list[float]:
        q = quaternion.multiply(stage.middle[joint], quaternion.from_rotvec(v))
        return [bend(stage, joint, q, bone) for bone in bones(stage, joint)]

    at = np.clip(vector, low, high)
    for _ in range(16):
        over = [max(a - most, 0.0) + min(a - least, 0.0) for a, (least, most) in zip(angles(at), ends, strict=True)]
        if not over or max(map(abs, over)) <= 1e-9:
            return at
        k = int(np.argmax(np.abs(over)))
        steps = 1e-6 * np.eye(3)
        slope = np.array([(angles(at + step)[k] - angles(at - step)[k]) / 2e-6 for step in steps])
        for n in range(3):
            outwards = -over[k] * slope[n]
            if (outwards > 0.0 and at[n] >= high[n]) or (outwards < 0.0 and at[n] <= low[n]):
                slope[n] = 0.0
        if slope @ slope < 1e-6:
            break
        at = np.clip(at - over[k] * slope / (slope @ slope), low, high)
    raise NotImplementedError("where slopes lead nowhere there is no obvious way")
