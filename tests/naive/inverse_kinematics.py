"""A slow, obvious twin of `kinesics.synthesis.embodiment.inverse_kinematics`: one leg, one frame, the knee found by bisection."""

from __future__ import annotations

import numpy as np


def matrix(axis: np.ndarray, angle: float) -> np.ndarray:
    """Rodrigues' formula."""
    x, y, z = axis
    k = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + np.sin(angle) * k + (1.0 - np.cos(angle)) * k @ k


def reach(
    hip: np.ndarray, knee: np.ndarray, ankle: np.ndarray, target: np.ndarray, hinge: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Knee and ankle after the leg has reached: the knee turns about ``hinge`` until the distance fits, then all swings."""
    wanted = np.linalg.norm(target - hip)

    def bent(angle: float) -> np.ndarray:
        return knee + matrix(hinge, angle) @ (ankle - knee)

    # straighten or bend: the distance falls as the knee bends, on this side of straight
    straight = min(np.linspace(-np.pi, np.pi, 20001), key=lambda a: -np.linalg.norm(bent(a) - hip))
    low, high = straight, straight + np.pi
    for _ in range(80):
        middle = 0.5 * (low + high)
        if np.linalg.norm(bent(middle) - hip) > wanted:
            low = middle
        else:
            high = middle
    now = bent(0.5 * (low + high)) - hip
    aim = target - hip
    across = np.cross(now, aim)
    size = np.linalg.norm(across)
    angle = np.arctan2(size, now @ aim)
    turn = matrix(across / size, angle) if size > 1e-12 else np.eye(3)
    return hip + turn @ (knee - hip), hip + turn @ now
