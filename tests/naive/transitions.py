"""Transitions and networks by their definitions, a pair and a path at a time: slow and obvious."""

from __future__ import annotations

import math

from naive import similarity


def window_distance(recorded, source, target, frame_count, half):
    """Mean D across a transition: what would go on after ``source`` against what goes on at ``target``.

    ``recorded`` holds the poses of the recordings as they are, shape (frames, 15, 4); moments are frame + frame_count · strand.
    """
    total = 0.0
    for step in range(-half, half):
        total += similarity.pose_distance(
            pose_at(recorded, source, step + 1, frame_count), pose_at(recorded, target, step, frame_count)
        )
    return total / (2 * half)


def pose_at(recorded, moment, steps, frame_count):
    """The pose that is played ``steps`` frames after a moment."""
    frame, strand = moment % frame_count, moment // frame_count
    pose = recorded[frame - steps if strand >= 2 else frame + steps]
    return similarity.mirror(pose) if strand % 2 else pose


def frames_played(first, length, frame_count):
    """The moments of a path, in the order in which they are played."""
    step = -1 if first // frame_count >= 2 else 1
    return [first + step * k for k in range(length)]


def reachable(successors, start):
    """All paths that can be performed sooner or later after one."""
    seen, waiting = set(), list(successors[start])
    while waiting:
        path = waiting.pop()
        if path not in seen:
            seen.add(path)
            waiting.extend(successors[path])
    return seen


def seen_from(yaw, x, z):
    """A step (x, z) in the world as one who faces ``yaw`` sees it: to the left, ahead."""
    left = (math.cos(yaw), -math.sin(yaw))
    ahead = (math.sin(yaw), math.cos(yaw))
    return x * left[0] + z * left[1], x * ahead[0] + z * ahead[1]
