"""Going: walk, limp, run, jog in place.

The curves of hip, knee and foot follow the normal ranges of gait laboratories (Perry & Burnfield, *Gait Analysis*, 2nd ed.
2010; Winter 2009, ch. 4 and 5; Novacheck, "The biomechanics of running", Gait & Posture 7, 1998). Percent 0 of a cycle is
the strike of the left foot; the right side is the left half a period later, mirrored, to the last bit.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Final, Unpack

import numpy as np
from numpy.typing import NDArray

from kinesics.performer.cycles import cyclic_score, symmetrise, tracks
from kinesics.performer.postures import STANDING, posture
from kinesics.performer.score import check_number
from kinesics.performer.stage import GRAVITY, Conditions, perform_score
from kinesics.performer.truth import Performance
from kinesics.vocabulary import MovementClass

Array = NDArray[np.float64]

_STRIDING: Final = posture(STANDING, head_bend=-3)
_RUNNING: Final = posture(STANDING, pelvis_pitch=7, trunk_bend=6, neck_bend=-12, shoulder_twist=-10)

_WALK: Final[dict[str, list[tuple[float, float]]]] = {
    "left_hip_flex": [
        (0, 29.2), (6, 27.5), (14, 21.3), (24, 10.7), (34, 0.6), (44, -8.9), (51, -13.4), (56, -11.7),
        (62, -2.2), (70, 13.5), (78, 25.8), (85, 32.0), (92, 32.0),
    ],
    "left_knee": [
        (0, 4), (5, 9), (12, 17), (18, 16.5), (28, 9.5), (38, 5), (44, 6), (50, 12), (56, 25), (62, 43), (68, 58),
        (73, 62), (79, 54), (86, 30), (92, 11), (96, 4),
    ],
    "left_ankle": [
        (0, 17), (4, 10), (9, 1.5), (14, 0), (24, 0), (34, -0.5), (40, -4), (46, -12), (52, -27), (58, -46), (63, -60),
        (68, -58), (74, -38), (80, -14), (86, 6), (93, 18),
    ],
    "left_hip_abduct": [
        (0, 1.1), (6, -3.2), (12, -6.5), (18, -6.3), (24, -4.9), (30, -4.5), (36, -6.2), (42, -5.8),
        (48, -3.3), (54, 1.7), (60, 6.2), (66, 8.4), (74, 5.0), (82, 3.5), (90, 4.5),
    ],
    "left_hip_rotate": [(0, 4), (25, 7), (50, 5), (70, 3), (85, 2)],
    # the arm goes with the other leg: furthest forward when the right foot strikes
    "left_shoulder_flex": [(0, -20), (12, -18), (25, -4), (38, 10), (50, 16), (62, 14), (75, 0), (88, -14)],
    "left_elbow": [(0, 16), (12, 15), (25, 20), (38, 30), (50, 36), (62, 33), (75, 25), (88, 18)],
    "left_shoulder_elevate": [(0, -77), (25, -79), (50, -76), (75, -79)],
    "left_shoulder_horizontal": [(0, 0), (50, 6)],
    "pelvis_yaw": [(0, -5), (25, 0), (50, 5), (75, 0)],
    "pelvis_roll": [(0, -0.5), (10, 5), (25, 2), (50, 0.5), (60, -5), (75, -2)],
    "pelvis_pitch": [(0, 3), (12, 4), (25, 3), (37, 2), (50, 3), (62, 4), (75, 3), (87, 2)],
    "lowerback_twist": [(0, 4), (25, 0), (50, -4), (75, 0)],
    "upperback_twist": [(0, 3), (25, 0), (50, -3), (75, 0)],
    "thorax_twist": [(0, 3), (25, 0), (50, -3), (75, 0)],
    "lowerneck_twist": [(0, -3), (25, 0), (50, 3), (75, 0)],
    "upperneck_twist": [(0, -2), (25, 0), (50, 2), (75, 0)],
    "lowerback_lean": [(0, 0), (12, -4), (25, -1.5), (50, 0), (62, 4), (75, 1.5)],
    "upperback_lean": [(0, 0), (12, -1.5), (25, -1), (50, 0), (62, 1.5), (75, 1)],
    "head_bend": [(0, -4), (12, -2), (25, -4), (37, -5), (50, -4), (62, -2), (75, -4), (87, -5)],
    "upperback_bend": [(0, 1.5), (12, 2.5), (25, 1), (37, 0.5), (50, 1.5), (62, 2.5), (75, 1), (87, 0.5)],
}  # fmt: skip

_RUN: Final[dict[str, list[tuple[float, float]]]] = {
    "left_hip_flex": [
        (0, 34), (6, 31), (13, 20), (20, 6), (27, -8), (34, -17), (40, -17), (47, -7), (55, 12), (63, 31), (71, 45),
        (79, 51), (87, 48), (94, 40),
    ],
    "left_knee": [
        (0, 17), (6, 31), (13, 42), (20, 39), (27, 27), (34, 18), (40, 27), (47, 57), (54, 88), (60, 104), (66, 105),
        (73, 87), (81, 54), (89, 23), (95, 14),
    ],
    "left_ankle": [
        (0, 6), (5, 0), (11, 0), (18, -2), (24, -16), (30, -40), (36, -64), (43, -84), (51, -95), (60, -88), (69, -60),
        (78, -26), (87, 2), (94, 8),
    ],
    "left_hip_abduct": [
        (0, 0.0), (6, -4.3), (12, -8.5), (18, -8.0), (24, -4.7), (30, -1.8), (36, -0.6), (42, 1.3),
        (48, 4.4), (54, 9.5), (60, 14.6), (66, 13.8), (74, 6.5), (82, 3.2), (90, 3.4),
    ],
    "left_shoulder_flex": [(0, -38), (14, -35), (30, -12), (44, 8), (54, 12), (66, 3), (80, -20), (92, -36)],
    "left_elbow": [(0, 82), (14, 80), (30, 88), (44, 103), (54, 106), (66, 100), (80, 90), (92, 84)],
    "left_shoulder_elevate": [(0, -68), (25, -72), (50, -72), (75, -70)],
    "left_shoulder_horizontal": [(0, -4), (50, 12)],
    "pelvis_yaw": [(0, -6), (25, 2), (50, 6), (75, -2)],
    "pelvis_roll": [(0, -1), (12, 5), (30, 1), (50, 1), (62, -5), (80, -1)],
    "pelvis_pitch": [(0, 9), (12, 11), (25, 10), (37, 8), (50, 9), (62, 11), (75, 10), (87, 8)],
    "lowerback_twist": [(0, 6), (25, 0), (50, -6), (75, 0)],
    "upperback_twist": [(0, 6), (25, 0), (50, -6), (75, 0)],
    "thorax_twist": [(0, 6), (25, 0), (50, -6), (75, 0)],
    "lowerneck_twist": [(0, -4), (25, 0), (50, 4), (75, 0)],
    "upperneck_twist": [(0, -4), (25, 0), (50, 4), (75, 0)],
    "lowerback_lean": [(0, 0), (14, -3), (30, -1), (50, 0), (64, 3), (80, 1)],
}  # fmt: skip

_JOG: Final[dict[str, list[tuple[float, float]]]] = {
    # about a reversal: percent 0 is the left knee at its highest, percent 50 the right
    "left_hip_flex": [
        (0, 46), (8, 43), (18, 26), (28, 11), (40, 8), (50, 9), (60, 8), (72, 11), (82, 26), (92, 43),
    ],
    "left_knee": [
        (0, 92), (8, 88), (18, 54), (28, 22), (40, 17), (50, 20), (60, 17), (72, 22), (82, 54), (92, 88),
    ],
    "left_ankle": [
        (0, -42), (8, -40), (18, -24), (28, -7), (40, -1), (50, 0), (60, -1), (72, -7), (82, -24),
        (92, -40),
    ],
    "left_shoulder_flex": [(0, -30), (25, -10), (50, 16), (75, -10)],
    "left_elbow": [(0, 64), (25, 84), (50, 102), (75, 84)],
    "left_hip_abduct": [(0, 4), (25, 2), (50, 0), (75, 2)],
    "left_shoulder_elevate": [(0, -68), (50, -72)],
    "pelvis_roll": [(0, -3), (25, 0), (50, 3), (75, 0)],
    "lowerback_twist": [(0, -6), (25, 0), (50, 6), (75, 0)],
    "upperback_twist": [(0, -4), (25, 0), (50, 4), (75, 0)],
    "thorax_twist": [(0, -4), (25, 0), (50, 4), (75, 0)],
    "lowerneck_twist": [(0, 4), (50, -4)],
    "lowerback_lean": [(0, 2), (25, 0), (50, -2), (75, 0)],
}  # fmt: skip


_Curves = dict[str, list[tuple[float, float]]]


def _both_sides(left: Mapping[str, Sequence[tuple[float, float]]]) -> _Curves:
    """The left side's curves, and the same for the right side half a cycle later."""
    full: _Curves = {}
    for name, points in left.items():
        full[name] = list(points)
        if name.startswith("left_"):
            full["right_" + name[5:]] = sorted(((p + 50.0) % 100.0, v) for p, v in points)
    return full


def _limping(curves: _Curves, degree: float) -> _Curves:
    """Spare the right leg: it bends less, swings less, is left sooner, and the trunk falls over it."""
    out = dict(curves)
    late = 6.0 * degree

    def spared(name: str, keep: float, about: float) -> None:
        points = curves[f"right_{name}"]
        out[f"right_{name}"] = sorted(((p + late) % 100.0, about + keep * (v - about)) for p, v in points)

    spared("hip_flex", 1.0 - 0.4 * degree, 8.0)
    spared("knee", 1.0 - 0.6 * degree, 8.0)
    spared("ankle", 1.0 - 0.5 * degree, 0.0)
    spared("shoulder_flex", 1.0 - 0.3 * degree, 0.0)
    spared("elbow", 1.0 - 0.3 * degree, 30.0)
    # the stiff leg is swung round the outside
    out["right_hip_abduct"] = [
        (p, v + (5.0 * degree if 15.0 <= p <= 35.0 else 0.0)) for p, v in out["right_hip_abduct"]
    ]
    out["lowerback_lean"] = [(p, v + 9.0 * degree * _bump(p, 66.0)) for p, v in curves["lowerback_lean"]]
    out["upperback_lean"] = [(p, v + 5.0 * degree * _bump(p, 66.0)) for p, v in curves["upperback_lean"]]
    out["pelvis_pitch"] = [(p, v + 5.0 * degree * _bump(p, 66.0)) for p, v in curves["pelvis_pitch"]]
    return out


def _bump(percent: float, centre: float) -> float:
    return float(0.5 + 0.5 * np.cos(2.0 * np.pi * (percent - centre) / 100.0)) ** 2


def flights(*windows: tuple[float, float]) -> Callable[[Array, Array], Array]:
    """Ballistic height over phases of flight: ½ g (t − take-off)(landing − t)."""

    def lift(phase: Array, cycle_seconds: Array) -> Array:
        out = np.zeros(len(phase))
        for start, end in windows:
            x = np.mod(phase - start, 1.0)
            fall = 0.5 * GRAVITY * x * (end - start - x) * cycle_seconds**2
            out += np.where(x < end - start, fall, 0.0)
        return out

    return lift


def walk(
    seconds: float = 10.0,
    fps: float = 120.0,
    *,
    limp: float = 0.0,
    period: float = 1.1,
    amplitude: float = 1.0,
    tempo_jitter: float = 0.0,
    seed: int = 0,
    **conditions: Unpack[Conditions],
) -> Performance:
    """Walk: `cyclic-antiphase`; with a limp `cyclic-asymmetric`.

    Parameters
    ----------
    seconds : at least two periods.
    limp : 0 (none) to 1 (the right leg hardly used).
    period : seconds of two steps, without the jitter.
    amplitude : size of the movement, 0.3 to 1.5.
    tempo_jitter : relative deviation of the cycles' lengths, 0 to 0.3.
    seed : of the jitter and the noise.
    conditions : see `kinesics.performer.Conditions`.

    Raises
    ------
    InputError
        If a value is out of range; the message names it.
    """
    limp = check_number("limp", limp, 0.0, 1.0)
    amplitude = check_number("amplitude", amplitude, 0.3, 1.5)
    curves = _both_sides(_WALK)
    if limp > 0.0:
        name, class_ = "limp", MovementClass.CYCLIC_ASYMMETRIC
        shape = tracks(_STRIDING, _limping(curves, limp), amplitude)
    else:
        name, class_ = "walk", MovementClass.CYCLIC_ANTIPHASE
        shape = symmetrise(tracks(_STRIDING, curves, amplitude), class_)
    score = cyclic_score(
        name,
        class_,
        shape,
        seconds=seconds,
        period=period,
        tempo_jitter=tempo_jitter,
        seed=seed,
        travels=True,
    )
    return perform_score(score, fps=fps, seed=seed, **conditions)


def limp(
    seconds: float = 10.0,
    fps: float = 120.0,
    *,
    degree: float = 0.7,
    period: float = 1.3,
    amplitude: float = 0.85,
    tempo_jitter: float = 0.0,
    seed: int = 0,
    **conditions: Unpack[Conditions],
) -> Performance:
    """Limp on the right leg: `cyclic-asymmetric` (§3.5.5). ``degree`` is above 0 and at most 1; the rest as in `walk`."""
    degree = check_number("degree", degree, 0.01, 1.0)
    return walk(
        seconds,
        fps,
        limp=degree,
        period=period,
        amplitude=amplitude,
        tempo_jitter=tempo_jitter,
        seed=seed,
        **conditions,
    )


def run(
    seconds: float = 8.0,
    fps: float = 120.0,
    *,
    period: float = 0.74,
    amplitude: float = 1.0,
    tempo_jitter: float = 0.0,
    seed: int = 0,
    **conditions: Unpack[Conditions],
) -> Performance:
    """Run, both feet off the ground twice a cycle: `cyclic-antiphase`. Parameters as in `walk`."""
    amplitude = check_number("amplitude", amplitude, 0.3, 1.5)
    shape = symmetrise(tracks(_RUNNING, _both_sides(_RUN), amplitude), MovementClass.CYCLIC_ANTIPHASE)
    score = cyclic_score(
        "run",
        MovementClass.CYCLIC_ANTIPHASE,
        shape,
        seconds=seconds,
        period=period,
        tempo_jitter=tempo_jitter,
        seed=seed,
        lift=flights((0.36, 0.5), (0.86, 1.0)),
        travels=True,
    )
    return perform_score(score, fps=fps, seed=seed, **conditions)


def jog_in_place(
    seconds: float = 8.0,
    fps: float = 120.0,
    *,
    period: float = 0.76,
    amplitude: float = 1.0,
    tempo_jitter: float = 0.0,
    seed: int = 0,
    **conditions: Unpack[Conditions],
) -> Performance:
    """Jog in place: `cyclic-antiphase-palindromic` (§3.5.3). Parameters as in `walk`."""
    amplitude = check_number("amplitude", amplitude, 0.3, 1.5)
    class_ = MovementClass.CYCLIC_ANTIPHASE_PALINDROMIC
    shape = symmetrise(tracks(_RUNNING, _both_sides(_JOG), amplitude), class_)
    score = cyclic_score(
        "jog_in_place",
        class_,
        shape,
        seconds=seconds,
        period=period,
        tempo_jitter=tempo_jitter,
        seed=seed,
        lift=flights((0.19, 0.31), (0.69, 0.81)),
    )
    return perform_score(score, fps=fps, seed=seed, **conditions)
