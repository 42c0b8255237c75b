"""Longer sequences with a grammar: side kicks (§3.5.6), the sun salutation (§3.6.1), a kata (§3.6.3)."""

from __future__ import annotations

import dataclasses
from typing import Final, Unpack

import numpy as np
from numpy.typing import NDArray

from kinesics.performer import postures as _postures
from kinesics.performer.key_graph import KeyGraph, KeyPath, KeyState, mirrored_path
from kinesics.performer.postures import STANDING, posture
from kinesics.performer.score import check_number
from kinesics.performer.stage import Conditions, perform_score
from kinesics.performer.traversal import Part, Step, traversal_score
from kinesics.performer.truth import Performance

Array = NDArray[np.float64]

_BLEND: Final = 0.25
"""Seconds over which the weight goes from foot to foot in kicks, stamps and lunges (`kinesics.performer.score.Score`)."""


def _pair(path: KeyPath, states: tuple[KeyState, ...]) -> tuple[KeyPath, KeyPath]:
    """A path and its mirror image."""
    image = mirrored_path(path, f"({path.label})*", {s.label: s for s in states})
    return dataclasses.replace(path, mirror_of=image.label), image


def _grown(base: Array, target: Array, amplitude: float) -> Array:
    return np.asarray(base + amplitude * (target - base))


_GUARD: Final = posture(
    STANDING, trunk_twist=-10, neck_twist=8, trunk_bend=6, pelvis_yaw=-12, shoulder_elevate=-66, shoulder_flex=28,
    left_elbow=98, right_elbow=112, shoulder_twist=18, left_shoulder_horizontal=10, right_shoulder_horizontal=16,
    left_hip_flex=24, left_knee=26, left_hip_abduct=8, right_hip_flex=-6, right_knee=22, right_hip_abduct=10,
    right_ankle=-12, left_hip_rotate=2, right_hip_rotate=18,
)  # fmt: skip

_READY: Final = posture(
    STANDING, shoulder_elevate=-66, shoulder_flex=26, elbow=102, shoulder_twist=18, shoulder_horizontal=12, hip_abduct=10,
    knee=16, hip_flex=11, trunk_bend=4,
)  # fmt: skip


def side_kicks(
    seconds: float = 14.0,
    fps: float = 120.0,
    *,
    period: float = 1.4,
    amplitude: float = 1.0,
    tempo_jitter: float = 0.0,
    seed: int = 0,
    **conditions: Unpack[Conditions],
) -> Performance:
    """Side kicks to the left, a turn about, side kicks to the right (§3.5.6).

    The phrases are `cyclic-asymmetric`, `antipalindromic` (the turn, through a symmetric stance) and `cyclic-asymmetric`.

    Parameters
    ----------
    seconds : the whole; as many kicks of about ``period`` seconds as fit, at least two to each side.
    amplitude, tempo_jitter, seed, conditions : as in `kinesics.performer.walk`.
    """
    seconds = check_number("seconds", seconds, 2.0, 3600.0, unit="s")
    period = check_number("period", period, 0.5, 10.0, unit="s")
    amplitude = check_number("amplitude", amplitude, 0.4, 1.1)
    kicks = max(2, int((seconds / period - 1.4) / 2.0))
    chamber = posture(
        _GUARD, pelvis_yaw=-26, pelvis_roll=10, trunk_lean=6, left_hip_flex=66, left_hip_abduct=30, left_knee=112,
        left_plant=0, left_ankle=10, right_hip_flex=0, right_knee=16, right_hip_abduct=10, right_ankle=0,
    )  # fmt: skip
    kick = posture(
        _GUARD, pelvis_yaw=-36, pelvis_roll=34, trunk_lean=22, trunk_bend=2, neck_lean=-22, left_hip_flex=18,
        left_hip_abduct=58, left_hip_rotate=-8, left_knee=8, left_plant=0, left_ankle=14, right_hip_abduct=32,
        right_knee=10, right_hip_flex=2, right_ankle=0, left_elbow=60, left_shoulder_elevate=-50,
    )  # fmt: skip
    lowered = posture(
        _GUARD, pelvis_yaw=-20, pelvis_roll=6, left_hip_flex=58, left_hip_abduct=12, left_knee=74, left_plant=0,
        left_ankle=0, right_hip_flex=-2, right_knee=20, right_ankle=0, trunk_bend=10,
    )  # fmt: skip
    stepping = posture(
        _READY, pelvis_yaw=-4, right_hip_flex=44, right_knee=62, right_plant=0.2, right_ankle=-16, left_hip_flex=10,
        left_knee=16, left_hip_abduct=3, pelvis_roll=-3, trunk_twist=-4,
    )  # fmt: skip
    guard = _grown(_READY, _GUARD, amplitude)
    kicking = KeyPath(
        "aa_1", "A", "A", period, via=tuple(_grown(_READY, v, amplitude) for v in (chamber, kick, lowered))
    )
    turning = KeyPath("ax_1", "A", "X~", 0.6 * period, via=(_grown(_READY, stepping, amplitude),), reversible=True)
    states = (KeyState("A", guard, "A*"), KeyState("X~", _READY, "X~"), KeyState("A*", _postures.mirror(guard), "A"))
    graph = KeyGraph(states, (*_pair(kicking, states), *_pair(turning, states)), name="side_kicks")
    steps = [
        *[Step("aa_1")] * kicks,
        Step("ax_1", turn_degrees=90.0),
        Step("(ax_1)*", reversed=True, turn_degrees=90.0),
        *[Step("(aa_1)*")] * kicks,
    ]
    parts = (Part("kicks left", 0, kicks), Part("turn", kicks, kicks + 2), Part("kicks right", kicks + 2, len(steps)))
    score = traversal_score(graph, steps, seconds=seconds, tempo_jitter=tempo_jitter, seed=seed, parts=parts)
    return perform_score(dataclasses.replace(score, blend=_BLEND), fps=fps, seed=seed, **conditions)


def _sun_graph(amplitude: float) -> KeyGraph:
    """States Ȳ X̄ T̄ W̄ V̄ of §3.6.1 and the paths between them."""
    # where hands and feet both bear, the angles were solved for both to touch the ground
    overhead = posture(
        STANDING, shoulder_elevate=78, shoulder_flex=0, shoulder_twist=-70, elbow=6, trunk_bend=-8, neck_bend=-14
    )
    aside = posture(STANDING, shoulder_elevate=2, shoulder_horizontal=10, shoulder_twist=-34, elbow=10)
    forward = posture(STANDING, shoulder_flex=52, elbow=10)
    half = posture(
        STANDING,
        pelvis_pitch=66,
        trunk_bend=12,
        hip_flex=60,
        knee=4,
        neck_bend=-24,
        shoulder_flex=78,
        shoulder_elevate=-82,
    )
    diving = posture(
        STANDING, pelvis_pitch=30, trunk_bend=4, hip_flex=28, knee=6, neck_bend=-16, shoulder_elevate=14,
        shoulder_horizontal=16, shoulder_twist=-20, elbow=10,
    )  # fmt: skip
    fold = posture(
        STANDING, pelvis_pitch=88, trunk_bend=58, hip_flex=82, knee=6, neck_bend=14, shoulder_flex=168.8,
        shoulder_elevate=-84, elbow=10, pronate=60,
    )  # fmt: skip
    support = posture(STANDING, shoulder_elevate=-88, pronate=90, wrist=75, hip_abduct=2, hip_rotate=0, plant=0, knee=2)
    plank = posture(support, pelvis_pitch=71.6, elbow=7, shoulder_flex=72, hip_flex=0, ankle=25, neck_bend=-8)
    low = posture(support, pelvis_pitch=83.0, elbow=82, shoulder_flex=2, hip_flex=0, ankle=22, neck_bend=-14)
    up_dog = posture(
        support, pelvis_pitch=67.9, hip_flex=-13.3, elbow=12, shoulder_flex=4, ankle=-45, trunk_bend=-58, neck_bend=-22
    )
    # one leg back, then the other: hands and the foot that stands stay where they are
    first_back = posture(
        STANDING, pelvis_pitch=68.8, trunk_bend=41.1, neck_bend=-0.9, left_hip_flex=40, left_knee=50, left_ankle=-10,
        left_plant=0, right_hip_flex=86, right_knee=68.9, right_ankle=0, shoulder_flex=117.3, shoulder_elevate=-85,
        elbow=7.4, pronate=75, wrist=20,
    )  # fmt: skip
    lunge = posture(
        STANDING, pelvis_pitch=61.8, trunk_bend=8.1, neck_bend=-16, left_hip_flex=-5, left_knee=6, left_ankle=25,
        left_plant=0, right_hip_flex=94.1, right_knee=114.2, right_ankle=0, shoulder_flex=78, shoulder_elevate=-86,
        elbow=4.8, pronate=90, wrist=40,
    )  # fmt: skip
    foot_lifted = posture(
        STANDING, pelvis_pitch=69.9, trunk_bend=5.1, neck_bend=-14.7, left_hip_flex=6.1, left_knee=5.4, left_ankle=25,
        left_plant=0, right_hip_flex=87.1, right_knee=124, right_ankle=6, right_plant=0.6, hip_rotate=4.2,
        shoulder_flex=82.9, shoulder_elevate=-86.3, elbow=4.4, pronate=90, wrist=45.2,
    )  # fmt: skip
    second_back = posture(
        STANDING, pelvis_pitch=79.4, trunk_bend=-2.1, neck_bend=-12, left_hip_flex=16.6, left_ankle=25, left_plant=0,
        right_hip_flex=50, right_knee=70, right_ankle=-10, right_plant=0, hip_rotate=2.5, shoulder_flex=84.7,
        shoulder_elevate=-87, elbow=3.4, pronate=90, wrist=57.5,
    )  # fmt: skip
    jump = posture(
        STANDING, pelvis_pitch=104, trunk_bend=14, hip_flex=88, knee=70, shoulder_flex=118, elbow=4, neck_bend=-10,
        ankle=-20, plant=0, shoulder_elevate=-86, pronate=90, wrist=60,
    )  # fmt: skip

    def state(label: str, values: Array) -> KeyState:
        return KeyState(label, values, mirror_of=label)

    def symmetric(label: str, from_: str, to: str, seconds: float, *via: Array, reversible: bool = False) -> KeyPath:
        return KeyPath(label, from_, to, seconds, via=via, reversible=reversible, mirror_of=label)

    def grown(values: Array) -> Array:
        return _grown(STANDING, values, amplitude)

    return KeyGraph(
        (
            state("Y~", STANDING),
            state("X~", grown(overhead)),
            state("T~", half),
            state("W~", fold),
            state("V~", plank),
        ),
        (
            symmetric("yx~_1", "Y~", "X~", 1.9, grown(aside), reversible=True),
            symmetric("yy~_1", "Y~", "Y~", 1.7, grown(forward)),
            symmetric("xt~_1", "X~", "T~", 2.0, diving, reversible=True),
            symmetric("tw~_1", "T~", "W~", 1.3, reversible=True),
            KeyPath("wv_1", "W~", "V~", 3.4, via=(first_back, lunge, foot_lifted, second_back)),
            symmetric("vv~_1", "V~", "V~", 4.2, low, up_dog, _grown(plank, up_dog, 0.45)),
            symmetric("vw~_1", "V~", "W~", 1.5, jump),
        ),
        name="sun_salutation",
    )


_SUN_ROUND: Final = (
    # Ȳ → X̄ and back, the arms swing, then down to the plank and up again
    ("yx~_1", "<yx~_1", "yy~_1", "yx~_1", "xt~_1", "tw~_1", "wv_1", "vv~_1", "vw~_1", "<tw~_1", "<xt~_1", "<yx~_1")
)


def sun_salutation(
    seconds: float = 68.0,
    fps: float = 120.0,
    *,
    period: float = 34.0,
    amplitude: float = 1.0,
    tempo_jitter: float = 0.0,
    seed: int = 0,
    **conditions: Unpack[Conditions],
) -> Performance:
    """The sun salutation of §3.6.1: symmetric but for the way into the plank, with a moment of stillness in every state.

    Parameters
    ----------
    seconds : the whole; as many rounds of about ``period`` seconds as fit, at least one (two or more are cyclic).
    period : seconds of one round.
    amplitude : how high the arms go, .5 to 1.05.
    tempo_jitter, seed, conditions : as in `kinesics.performer.walk`.
    """
    seconds = check_number("seconds", seconds, 4.0, 3600.0, unit="s")
    period = check_number("period", period, 4.0, 300.0, unit="s")
    amplitude = check_number("amplitude", amplitude, 0.5, 1.05)
    rounds = max(1, round(seconds / period))
    graph = _sun_graph(amplitude)
    steps = [Step(label.lstrip("<"), label.startswith("<"), hold=0.8) for label in _SUN_ROUND * rounds]
    score = traversal_score(graph, steps, seconds=seconds, tempo_jitter=tempo_jitter, seed=seed)
    return perform_score(score, fps=fps, seed=seed, **conditions)


def _kata_graph(amplitude: float) -> KeyGraph:
    """One symmetric state, four asymmetric ones and their images (§3.6.3)."""
    ready = posture(
        STANDING, shoulder_elevate=-68, shoulder_flex=18, elbow=38, shoulder_twist=10, shoulder_horizontal=6, hip_abduct=8,
        knee=8, hip_flex=6,
    )  # fmt: skip
    hip_fist = {"shoulder_elevate": -74.0, "shoulder_flex": -38.0, "elbow": 104.0, "pronate": -60.0}
    front_stance = {
        "left_hip_flex": 52.0, "left_knee": 58.0, "left_hip_abduct": 6.0, "right_hip_flex": -22.0, "right_knee": 6.0,
        "right_hip_abduct": 12.0, "right_hip_rotate": 24.0, "plant": 1.0, "ankle": 0.0,
    }  # fmt: skip

    def one_side(side: str, **values: float) -> dict[str, float]:
        return {f"{side}_{name}": value for name, value in values.items()}

    # A: front stance, right fist forward; B: back stance, left hand high; C: riding stance, left fist aside; D: on one leg
    a = posture(
        ready, pelvis_yaw=4, trunk_twist=10, **front_stance, **one_side("left", **hip_fist), right_shoulder_elevate=-72,
        right_shoulder_flex=84, right_shoulder_horizontal=8, right_elbow=10, right_shoulder_twist=0,
    )  # fmt: skip
    b = posture(
        ready, pelvis_yaw=-34, trunk_twist=-22, neck_twist=48, left_hip_flex=34, left_knee=24, left_hip_abduct=14,
        right_hip_flex=40, right_knee=74, right_hip_abduct=16, right_hip_rotate=40, left_shoulder_elevate=-30,
        left_shoulder_horizontal=42, left_elbow=82, left_shoulder_twist=-62, right_shoulder_elevate=-70,
        right_shoulder_flex=34, right_elbow=92, right_shoulder_twist=22, trunk_bend=2,
    )  # fmt: skip
    c = posture(
        ready, hip_abduct=34, knee=62, hip_flex=46, hip_rotate=30, pelvis_pitch=6, neck_twist=62,
        left_shoulder_elevate=-6, left_shoulder_horizontal=4, left_elbow=8, **one_side("right", **hip_fist), trunk_twist=12,
    )  # fmt: skip
    d = posture(
        ready, right_hip_flex=84, right_knee=112, right_plant=0, right_ankle=-22, left_hip_flex=8, left_knee=16,
        left_hip_abduct=-2, pelvis_roll=-3, left_shoulder_elevate=34, left_elbow=72, left_shoulder_twist=-50,
        right_shoulder_elevate=-58, right_shoulder_flex=30, right_elbow=70,
    )  # fmt: skip
    kick = posture(
        d, right_hip_flex=92, right_knee=12, right_ankle=-30, trunk_bend=-8, pelvis_pitch=-8, left_shoulder_elevate=-40
    )
    gather = posture(ready, trunk_twist=-26, right_shoulder_flex=-40, right_elbow=104, left_shoulder_flex=50, left_knee=30,
                     left_hip_flex=26, left_plant=0.4, knee=24, hip_flex=18)  # fmt: skip
    sweep = posture(
        ready, trunk_twist=28, left_shoulder_elevate=-50, left_shoulder_horizontal=70, left_elbow=60, right_hip_flex=40,
        right_knee=60, right_plant=0.3, left_knee=30, left_hip_flex=22, right_shoulder_elevate=10, right_elbow=40,
    )  # fmt: skip
    a, b, c, d, kick, gather, sweep = (_grown(ready, v, amplitude) for v in (a, b, c, d, kick, gather, sweep))
    crouch = posture(ready, knee=40, hip_flex=30, right_hip_flex=44, right_knee=66, right_plant=0.3, trunk_bend=8)
    crouch = _grown(ready, crouch, amplitude)
    states = (
        KeyState("X~", ready, "X~"),
        *(
            state
            for label, values in zip("ABCD", (a, b, c, d), strict=True)
            for state in (
                KeyState(label, values, f"{label}*"),
                KeyState(f"{label}*", _postures.mirror(values), label),
            )
        ),
    )
    paths = (
        KeyPath("xa_1", "X~", "A", 1.1, (gather,)),
        KeyPath("xa_2", "X~", "A", 1.5, (sweep,)),
        KeyPath("aa*_1", "A", "A*", 1.3, (crouch,)),
        KeyPath("ab_1", "A", "B", 1.2),
        KeyPath("bc_1", "B", "C", 1.1, (gather,)),
        KeyPath("cd_1", "C", "D", 1.0),
        KeyPath("da_1", "D", "A", 1.8, (kick,)),
        KeyPath("cx_1", "C", "X~", 1.6, reversible=True),
        KeyPath("bd_1", "B", "D", 1.0, reversible=True),
    )
    return KeyGraph(states, tuple(p for path in paths for p in _pair(path, states)), name="kata")


def _kata_half(mirrored: bool) -> list[Step]:
    """From X̄ to X̄: struck, guarded, kicked."""
    plan = (
        ("xa_1", True, 0.35, 90.0),
        ("aa*_1", True, 0.25, 0.0),
        ("(aa*_1)*", True, 0.25, 0.0),
        ("ab_1", False, 0.5, -180.0),
        ("bd_1", False, 0.2, 0.0),
        ("<bd_1", False, 0.3, 0.0),
        ("bc_1", True, 0.5, 90.0),
        ("cd_1", False, 0.3, 0.0),
        ("da_1", False, 0.35, 0.0),
        ("ab_1", False, 0.4, 90.0),
        ("bc_1", True, 0.4, -90.0),
        ("cx_1", False, 1.0, 0.0),
        ("xa_2", True, 0.4, 0.0),
        ("ab_1", False, 0.4, 0.0),
        ("bc_1", True, 0.5, 0.0),
        ("cx_1", False, 1.0, 0.0),
    )

    def image(label: str) -> str:
        return label[1:-2] if label.startswith("(") else f"({label})*"

    steps: list[Step] = []
    for notation, strike, hold, turn in plan:
        backwards, label = notation.startswith("<"), notation.lstrip("<")
        steps.append(Step(image(label) if mirrored else label, backwards, hold, strike, -turn if mirrored else turn))
    return steps


_KATA_STEPS: Final = (*_kata_half(False), *_kata_half(True))


def kata(
    seconds: float = 48.0,
    fps: float = 120.0,
    *,
    period: float = 48.0,
    amplitude: float = 1.0,
    tempo_jitter: float = 0.0,
    seed: int = 0,
    **conditions: Unpack[Conditions],
) -> Performance:
    """A kata after §3.6.3: X̄ at the start, in the middle and at the end, A to D and their images, strikes that recoil.

    It is `asymmetric` as a whole. Parameters as in `sun_salutation`; ``amplitude`` is .6 to 1.1.
    """
    seconds = check_number("seconds", seconds, 5.0, 3600.0, unit="s")
    period = check_number("period", period, 5.0, 600.0, unit="s")
    amplitude = check_number("amplitude", amplitude, 0.6, 1.1)
    rounds = max(1, round(seconds / period))
    steps = [step for _ in range(rounds) for step in _KATA_STEPS]
    score = traversal_score(
        _kata_graph(amplitude), steps, seconds=seconds, first_hold=1.0, tempo_jitter=tempo_jitter, seed=seed
    )
    return perform_score(dataclasses.replace(score, blend=_BLEND), fps=fps, seed=seed, **conditions)
