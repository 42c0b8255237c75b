"""In place and over and over: jumping jacks, squats, twists, waving, arm circles, the butterfly stroke; and standing still."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final, Unpack

import numpy as np
from numpy.typing import NDArray

from kinesics.performer.cycles import Shape, cyclic_score, scaled, symmetrise, through, tracks
from kinesics.performer.gaits import flights
from kinesics.performer.postures import ANGLE, STANDING, posture
from kinesics.performer.score import check_number
from kinesics.performer.stage import Conditions, perform_score
from kinesics.performer.traversal import still_score
from kinesics.performer.truth import Performance
from kinesics.vocabulary import MovementClass

Array = NDArray[np.float64]
_Curves = Mapping[str, Sequence[tuple[float, float]]]


def _there_and_back(curves: _Curves) -> dict[str, list[tuple[float, float]]]:
    """Curves given from percent 0 to 50, and the same way back."""
    return {
        name: [*points, *((100.0 - p, v) for p, v in reversed(points) if 0.0 < p < 50.0)]
        for name, points in curves.items()
    }


def _perform(
    movement: str,
    class_: MovementClass,
    shape: Shape,
    seconds: float,
    fps: float,
    period: float,
    tempo_jitter: float,
    seed: int,
    conditions: Conditions,
    *windows: tuple[float, float],
) -> Performance:
    score = cyclic_score(
        movement,
        class_,
        symmetrise(shape, class_),
        seconds=seconds,
        period=period,
        tempo_jitter=tempo_jitter,
        seed=seed,
        lift=flights(*windows) if windows else None,
    )
    return perform_score(score, fps=fps, seed=seed, **conditions)


_JACK: Final[_Curves] = {
    "shoulder_elevate": [(0, -74), (12, -62), (25, -8), (38, 46), (50, 58)],
    "elbow": [(0, 16), (12, 12), (25, 18), (38, 44), (50, 66)],
    "shoulder_twist": [(0, -10), (25, -30), (50, -64)],
    "shoulder_horizontal": [(0, 4), (25, 6), (50, 8)],
    "hip_abduct": [(0, 2), (15, 3.5), (35, 19.5), (50, 21)],
    "hip_flex": [(0, 21), (14, 6), (25, 1), (36, 6), (50, 17)],
    "knee": [(0, 30), (14, 7), (25, 5), (36, 9), (50, 26)],
    "ankle": [(0, -4), (14, -28), (25, -36), (36, -26), (50, -4)],
    "pelvis_pitch": [(0, 11), (14, 3), (25, 0), (36, 2), (50, 7)],
    "trunk_bend": [(0, 14), (25, 2), (50, -4)],
    "neck_bend": [(0, -14), (25, 2), (50, 6)],
}

_SQUAT: Final[_Curves] = {
    "knee": [(0, 6), (12, 26), (25, 70), (38, 108), (50, 122)],
    "hip_flex": [(0, 4), (12, 21), (25, 56), (38, 89), (50, 103)],
    "pelvis_pitch": [(0, 1), (12, 5), (25, 10), (38, 13), (50, 14)],
    "lowerback_bend": [(0, 0), (25, 18), (50, 28)],
    "upperback_bend": [(0, 0), (50, 7)],
    "thorax_bend": [(0, 0), (50, 8)],
    "neck_bend": [(0, 0), (25, -12), (50, -20)],
    "shoulder_flex": [(0, 4), (25, 52), (50, 84)],
    "hip_abduct": [(0, 7), (25, 10), (50, 14)],
    "hip_rotate": [(0, 10), (50, 14)],
    "elbow": [(0, 12), (25, 28), (50, 32)],
}

_TWIST: Final[_Curves] = {
    "pelvis_yaw": [(0, 28), (50, -28)],
    "pelvis_roll": [(0, 2), (50, -2)],
    "trunk_twist": [(0, 52), (50, -52)],
    "neck_twist": [(0, 16), (50, -16)],
    "left_shoulder_horizontal": [(0, -18), (50, 74)],
    "right_shoulder_horizontal": [(0, 74), (50, -18)],
    "left_elbow": [(0, 40), (50, 92)],
    "right_elbow": [(0, 92), (50, 40)],
    # the feet stay where they are under the turning pelvis
    "left_hip_rotate": [(0, -21), (50, 35)],
    "right_hip_rotate": [(0, 35), (50, -21)],
    "left_knee": [(0, 12), (50, 6)],
    "right_knee": [(0, 6), (50, 12)],
    "left_hip_flex": [(0, 8), (50, 4)],
    "right_hip_flex": [(0, 4), (50, 8)],
}

_WAVE_ARM: Final[_Curves] = {
    "elbow": [(0, 58), (25, 86), (50, 116)],
    "shoulder_elevate": [(0, 22), (25, 17), (50, 12)],
    "shoulder_twist": [(0, -84), (50, -98)],
    "shoulder_horizontal": [(0, 14), (50, 22)],
    "wrist": [(0, 14), (25, 0), (50, -14)],
}


def jumping_jacks(
    seconds: float = 8.0,
    fps: float = 120.0,
    *,
    period: float = 1.05,
    amplitude: float = 1.0,
    tempo_jitter: float = 0.0,
    seed: int = 0,
    **conditions: Unpack[Conditions],
) -> Performance:
    """Jumping jacks: `cyclic-symmetric-palindromic` (§3.5.2). Parameters as in `kinesics.performer.walk`."""
    amplitude = check_number("amplitude", amplitude, 0.3, 1.15)
    shape = tracks(STANDING, _there_and_back(_JACK), amplitude)
    class_ = MovementClass.CYCLIC_SYMMETRIC_PALINDROMIC
    windows = ((0.14, 0.36), (0.64, 0.86))
    return _perform("jumping_jacks", class_, shape, seconds, fps, period, tempo_jitter, seed, conditions, *windows)


def squat(
    seconds: float = 10.0,
    fps: float = 120.0,
    *,
    period: float = 2.4,
    amplitude: float = 1.0,
    tempo_jitter: float = 0.0,
    seed: int = 0,
    **conditions: Unpack[Conditions],
) -> Performance:
    """Squats: `cyclic-symmetric-palindromic`. ``amplitude`` 1 goes down until the thighs are level, 1.15 at most."""
    amplitude = check_number("amplitude", amplitude, 0.2, 1.15)
    curves = _there_and_back(_SQUAT)
    shape = scaled(tracks(STANDING, curves), tracks(STANDING, curves)(np.zeros(1))[0], amplitude)
    class_ = MovementClass.CYCLIC_SYMMETRIC_PALINDROMIC
    return _perform("squat", class_, shape, seconds, fps, period, tempo_jitter, seed, conditions)


def twist(
    seconds: float = 10.0,
    fps: float = 120.0,
    *,
    period: float = 1.8,
    amplitude: float = 1.0,
    tempo_jitter: float = 0.0,
    seed: int = 0,
    **conditions: Unpack[Conditions],
) -> Performance:
    """Twist the trunk left and right: `cyclic-antiphase-palindromic`. Parameters as in `kinesics.performer.walk`."""
    amplitude = check_number("amplitude", amplitude, 0.2, 1.3)
    base = posture(STANDING, shoulder_elevate=-34, elbow=66, shoulder_twist=0, hip_abduct=8, pronate=0)
    shape = tracks(base, _there_and_back(_TWIST), amplitude)
    class_ = MovementClass.CYCLIC_ANTIPHASE_PALINDROMIC
    return _perform("twist", class_, shape, seconds, fps, period, tempo_jitter, seed, conditions)


def wave(
    seconds: float = 6.0,
    fps: float = 120.0,
    *,
    period: float = 0.9,
    amplitude: float = 1.0,
    tempo_jitter: float = 0.0,
    seed: int = 0,
    **conditions: Unpack[Conditions],
) -> Performance:
    """Wave the right hand: `cyclic-palindromic` (§3.4.6). Parameters as in `kinesics.performer.walk`."""
    amplitude = check_number("amplitude", amplitude, 0.3, 1.4)
    curves = {f"right_{name}": points for name, points in _there_and_back(_WAVE_ARM).items()}
    curves["trunk_lean"] = [(0, 3), (50, 1)]
    base = posture(STANDING, right_pronate=0)
    shape = tracks(base, curves, amplitude)
    class_ = MovementClass.CYCLIC_PALINDROMIC
    return _perform("wave", class_, shape, seconds, fps, period, tempo_jitter, seed, conditions)


def wave_both(
    seconds: float = 6.0,
    fps: float = 120.0,
    *,
    period: float = 1.0,
    amplitude: float = 1.0,
    tempo_jitter: float = 0.0,
    seed: int = 0,
    **conditions: Unpack[Conditions],
) -> Performance:
    """Wave both hands together: `cyclic-symmetric-palindromic`. Parameters as in `kinesics.performer.walk`."""
    amplitude = check_number("amplitude", amplitude, 0.3, 1.4)
    shape = tracks(posture(STANDING, pronate=0), _there_and_back(_WAVE_ARM), amplitude)
    class_ = MovementClass.CYCLIC_SYMMETRIC_PALINDROMIC
    return _perform("wave_both", class_, shape, seconds, fps, period, tempo_jitter, seed, conditions)


def arm_circles(
    seconds: float = 8.0,
    fps: float = 120.0,
    *,
    period: float = 1.4,
    amplitude: float = 1.0,
    tempo_jitter: float = 0.0,
    seed: int = 0,
    **conditions: Unpack[Conditions],
) -> Performance:
    """One arm circles forwards, the other backwards: `cyclic-antipalindromic`, the class the dissertation lacks.

    The arms meet hanging and overhead: the two symmetric poses. ``amplitude`` (.3 to 1.3) narrows or widens the turning
    of the trunk; the arms always go all the way round. The rest as in `kinesics.performer.walk`.
    """
    amplitude = check_number("amplitude", amplitude, 0.3, 1.3)
    base = posture(STANDING, shoulder_elevate=-77, elbow=8, hip_abduct=6, pronate=0)

    def shape(phase: Array) -> Array:
        out = np.tile(base, (len(phase), 1))
        wave_ = amplitude * np.sin(2.0 * np.pi * phase)
        # not periodic as an angle, but as a rotation
        out[:, ANGLE["left_shoulder_flex"]] = -2.0 * np.pi * phase
        out[:, ANGLE["right_shoulder_flex"]] = 2.0 * np.pi * phase
        for name, degrees in (("pelvis_yaw", 3), ("lowerback_twist", 4), ("upperback_twist", 5), ("thorax_twist", 6)):
            out[:, ANGLE[name]] = np.deg2rad(degrees) * wave_
        out[:, ANGLE["head_twist"]] = np.deg2rad(-9) * wave_
        return out

    class_ = MovementClass.CYCLIC_ANTIPALINDROMIC
    return _perform("arm_circles", class_, shape, seconds, fps, period, tempo_jitter, seed, conditions)


def butterfly(
    seconds: float = 10.0,
    fps: float = 120.0,
    *,
    period: float = 1.7,
    amplitude: float = 1.0,
    tempo_jitter: float = 0.0,
    seed: int = 0,
    **conditions: Unpack[Conditions],
) -> Performance:
    """The butterfly stroke on dry land, bent forward: `cyclic-symmetric` (§3.5.1). Parameters as in `walk`."""
    amplitude = check_number("amplitude", amplitude, 0.4, 1.1)
    base = posture(
        STANDING, pelvis_pitch=38, trunk_bend=22, neck_bend=-30, hip_flex=42, knee=18, hip_abduct=7, elbow=10, pronate=0
    )

    def key(**degrees: float) -> Array:
        return posture(base, **degrees)

    # catch, pull, push past the hips; then the arms swing out and over
    keys = [
        (0.00, key(shoulder_elevate=72, shoulder_horizontal=18, elbow=8, pelvis_pitch=44, hip_flex=46, knee=14)),
        (0.14, key(shoulder_elevate=46, shoulder_horizontal=34, elbow=30, trunk_bend=25, knee=18)),
        (0.28, key(shoulder_elevate=4, shoulder_horizontal=58, elbow=72, shoulder_twist=28, knee=24, hip_flex=46)),
        (0.42, key(shoulder_elevate=-44, shoulder_horizontal=46, elbow=70, shoulder_twist=18, neck_bend=-42, knee=22)),
        (0.55, key(shoulder_elevate=-74, shoulder_horizontal=2, elbow=18, pelvis_pitch=33, hip_flex=37, neck_bend=-46)),
        (0.68, key(shoulder_elevate=-50, shoulder_horizontal=-26, elbow=14, pelvis_pitch=33, hip_flex=38, neck_bend=-40)),
        (0.80, key(shoulder_elevate=0, shoulder_horizontal=-12, elbow=14, shoulder_twist=-14, pelvis_pitch=37)),
        (0.91, key(shoulder_elevate=52, shoulder_horizontal=4, elbow=12, shoulder_twist=-8, pelvis_pitch=42, hip_flex=45)),
    ]  # fmt: skip
    shape = scaled(through(keys), np.mean([k for _, k in keys], axis=0), amplitude)
    class_ = MovementClass.CYCLIC_SYMMETRIC
    return _perform("butterfly", class_, shape, seconds, fps, period, tempo_jitter, seed, conditions)


def stand(seconds: float = 5.0, fps: float = 120.0, *, seed: int = 0, **conditions: Unpack[Conditions]) -> Performance:
    """Stand at ease: `still`. Only noise moves it."""
    return perform_score(still_score("stand", STANDING, seconds), fps=fps, seed=seed, **conditions)
