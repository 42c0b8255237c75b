"""Movements made once: one for each of the five single classes. Each begins and ends in stillness of equal length."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Unpack

import numpy as np
from numpy.typing import NDArray

from kinesics.errors import InputError
from kinesics.performer import postures as _postures
from kinesics.performer.key_graph import KeyGraph, KeyPath, KeyState, mirrored_path
from kinesics.performer.postures import STANDING, posture
from kinesics.performer.score import check_number
from kinesics.performer.stage import Conditions, perform_score
from kinesics.performer.traversal import parse_step, traversal_score
from kinesics.performer.truth import Performance

Array = NDArray[np.float64]


def _once(
    graph: KeyGraph,
    steps: Sequence[str],
    seconds: float,
    fps: float,
    period: float,
    tempo_jitter: float,
    seed: int,
    conditions: Conditions,
) -> Performance:
    rest = (seconds - period) / 2.0
    *first, last = map(parse_step, steps)
    taken = [*first, dataclasses.replace(last, hold=rest)]
    score = traversal_score(graph, taken, seconds=seconds, first_hold=rest, tempo_jitter=tempo_jitter, seed=seed)
    return perform_score(score, fps=fps, seed=seed, **conditions)


def _timing(seconds: float, period: float, amplitude: float, most: float) -> tuple[float, float, float]:
    seconds = check_number("seconds", seconds, 0.2, 3600.0, unit="s")
    period = check_number("period", period, 0.2, 60.0, unit="s")
    if period > seconds:
        raise InputError(f"Expected `period` (the movement itself) within `seconds` of {seconds:g}, got {period:g}.")
    return seconds, period, check_number("amplitude", amplitude, 0.2, most)


def _grown(target: Array, amplitude: float) -> Array:
    """A posture as far from standing as asked."""
    return np.asarray(STANDING + amplitude * (target - STANDING))


def throw(
    seconds: float = 3.0,
    fps: float = 120.0,
    *,
    period: float = 1.6,
    amplitude: float = 1.0,
    tempo_jitter: float = 0.0,
    seed: int = 0,
    **conditions: Unpack[Conditions],
) -> Performance:
    """Throw with the right arm: `asymmetric`.

    Parameters
    ----------
    seconds : the whole, with equal stillness before and after.
    period : seconds of the movement itself.
    amplitude, tempo_jitter, seed, conditions : as in `kinesics.performer.walk`.
    """
    seconds, period, amplitude = _timing(seconds, period, amplitude, 1.1)
    back = posture(
        STANDING, pelvis_yaw=-14, trunk_twist=-34, trunk_lean=6, neck_twist=26, right_shoulder_elevate=12,
        right_shoulder_horizontal=-22, right_shoulder_twist=-82, right_elbow=98, left_shoulder_elevate=-18,
        left_shoulder_horizontal=48, left_elbow=34, left_hip_flex=26, left_knee=34, left_ankle=-6, right_knee=20,
        right_hip_flex=8,
    )  # fmt: skip
    release = posture(
        STANDING, pelvis_yaw=10, trunk_twist=16, trunk_bend=12, right_shoulder_elevate=26, right_shoulder_horizontal=52,
        right_shoulder_twist=-64, right_elbow=36, left_shoulder_elevate=-44, left_elbow=64, left_hip_flex=30, left_knee=22,
        right_hip_flex=-14, right_knee=14, right_ankle=-22,
    )  # fmt: skip
    end = posture(
        STANDING, pelvis_yaw=16, pelvis_pitch=8, trunk_twist=34, trunk_bend=26, neck_bend=-20, right_shoulder_elevate=-34,
        right_shoulder_horizontal=78, right_elbow=24, left_shoulder_elevate=-62, left_shoulder_flex=-20, left_elbow=72,
        left_hip_flex=42, left_knee=34, right_hip_flex=-12, right_knee=20, right_ankle=-38,
    )  # fmt: skip
    graph = KeyGraph(
        (KeyState("X~", STANDING, "X~"), KeyState("A", _grown(end, amplitude))),
        (KeyPath("xa_1", "X~", "A", period, via=(_grown(back, amplitude), _grown(release, amplitude))),),
        name="throw",
    )
    return _once(graph, ["xa_1"], seconds, fps, period, tempo_jitter, seed, conditions)


def raise_arms(
    seconds: float = 3.0,
    fps: float = 120.0,
    *,
    period: float = 1.6,
    amplitude: float = 1.0,
    tempo_jitter: float = 0.0,
    seed: int = 0,
    **conditions: Unpack[Conditions],
) -> Performance:
    """Raise both arms overhead and keep them there: `symmetric`. Parameters as in `throw`."""
    seconds, period, amplitude = _timing(seconds, period, amplitude, 1.05)
    up = posture(
        STANDING, shoulder_elevate=76, shoulder_flex=0, shoulder_twist=-70, elbow=10, trunk_bend=-8, neck_bend=-16
    )
    half = posture(
        STANDING, shoulder_elevate=0, shoulder_horizontal=24, shoulder_twist=-20, elbow=24, knee=9, hip_flex=7
    )
    graph = KeyGraph(
        (KeyState("X~", STANDING, "X~"), KeyState("Y~", _grown(up, amplitude), "Y~")),
        (KeyPath("xy~_1", "X~", "Y~", period, via=(_grown(half, amplitude),), mirror_of="xy~_1"),),
        name="raise_arms",
    )
    return _once(graph, ["xy~_1"], seconds, fps, period, tempo_jitter, seed, conditions)


def reach(
    seconds: float = 4.0,
    fps: float = 120.0,
    *,
    period: float = 2.4,
    amplitude: float = 1.0,
    tempo_jitter: float = 0.0,
    seed: int = 0,
    **conditions: Unpack[Conditions],
) -> Performance:
    """Reach up to the left and come back the same way: `palindromic`. Parameters as in `throw`."""
    seconds, period, amplitude = _timing(seconds, period, amplitude, 1.1)
    high = posture(
        STANDING, trunk_lean=-18, trunk_twist=12, neck_twist=14, neck_bend=-14, left_shoulder_elevate=58,
        left_shoulder_twist=-40, left_elbow=8, right_shoulder_elevate=-66, right_elbow=30, pelvis_roll=-3,
        left_hip_abduct=6, right_hip_abduct=6, right_knee=12, right_hip_flex=8,
    )  # fmt: skip
    half = posture(
        STANDING,
        trunk_lean=-4,
        left_shoulder_elevate=-18,
        left_shoulder_horizontal=40,
        left_elbow=62,
        left_shoulder_twist=-24,
    )
    graph = KeyGraph(
        (KeyState("X~", STANDING, "X~"), KeyState("A", _grown(high, amplitude))),
        (KeyPath("xa_1", "X~", "A", period / 2.0, via=(_grown(half, amplitude),), reversible=True),),
        name="reach",
    )
    return _once(graph, ["xa_1", "<xa_1"], seconds, fps, period, tempo_jitter, seed, conditions)


def sway(
    seconds: float = 4.0,
    fps: float = 120.0,
    *,
    period: float = 2.0,
    amplitude: float = 1.0,
    tempo_jitter: float = 0.0,
    seed: int = 0,
    **conditions: Unpack[Conditions],
) -> Performance:
    """From leaning over to the left through the middle to the right: `antipalindromic` (§3.4.8). Parameters as in `throw`."""
    seconds, period, amplitude = _timing(seconds, period, amplitude, 1.1)
    middle = posture(STANDING, shoulder_elevate=-12, elbow=22, hip_abduct=14, knee=14, hip_flex=10)
    left = posture(
        middle, trunk_lean=-26, trunk_twist=10, neck_lean=-8, pelvis_roll=-5, left_knee=30, left_hip_flex=24,
        left_hip_abduct=17, right_knee=5, right_hip_flex=4, right_hip_abduct=20, left_shoulder_elevate=-44,
        right_shoulder_elevate=48, right_elbow=32,
    )  # fmt: skip
    left = np.asarray(middle + amplitude * (left - middle))
    right = _postures.mirror(left)
    states = (
        KeyState("A", left, "A*"),
        # swaying through, the body moves from left to right without a stop
        KeyState("X~", middle, "X~", velocity=(right - left) / (0.75 * period)),
        KeyState("A*", right, "A"),
    )
    path = KeyPath("ax_1", "A", "X~", period / 1.6, reversible=True, mirror_of="(ax_1)*")
    image = mirrored_path(path, "(ax_1)*", {s.label: s for s in states})
    graph = KeyGraph(states, (path, image), name="sway")
    return _once(graph, ["ax_1", "<(ax_1)*"], seconds, fps, period, tempo_jitter, seed, conditions)


def bow(
    seconds: float = 4.0,
    fps: float = 120.0,
    *,
    period: float = 2.6,
    amplitude: float = 1.0,
    tempo_jitter: float = 0.0,
    seed: int = 0,
    **conditions: Unpack[Conditions],
) -> Performance:
    """Bow and rise again: `symmetric-palindromic`. Parameters as in `throw`."""
    seconds, period, amplitude = _timing(seconds, period, amplitude, 1.2)
    low = posture(
        STANDING,
        pelvis_pitch=38,
        hip_flex=36,
        trunk_bend=28,
        neck_bend=16,
        shoulder_flex=40,
        shoulder_elevate=-80,
        knee=4,
    )
    graph = KeyGraph(
        (KeyState("X~", STANDING, "X~"), KeyState("Y~", _grown(low, amplitude), "Y~")),
        (KeyPath("xy~_1", "X~", "Y~", period / 2.0, reversible=True, mirror_of="xy~_1"),),
        name="bow",
    )
    return _once(graph, ["xy~_1", "<xy~_1"], seconds, fps, period, tempo_jitter, seed, conditions)
