"""From a score to a motion: on the ground, along a route, at a frame rate, seen by imperfect sensors.

The feet decide where the body goes: its lowest point touches the ground (except where the score lifts it), and what bears
the weight does not slide. Both are computed on a grid of time of their own, so that the frame rate changes nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final, Literal, TypedDict

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import CubicSpline

from kinesics.body import kinematics
from kinesics.body.motion import Motion
from kinesics.errors import InputError
from kinesics.geometry import quaternion
from kinesics.performer import postures as _postures
from kinesics.performer.body import JOINT_NAMES, Body, ContactPoint
from kinesics.performer.postures import ANGLE, ANGLES, joint_rotations
from kinesics.performer.score import NOISE_STREAM, Score, Shutter, check_number, generator
from kinesics.performer.truth import Performance, Range

Array = NDArray[np.float64]

GRAVITY: Final = 9.80665
_GRID_RATE: Final = 240.0
_HAND_GRIP: Final = 20.0  # a hand on the floor holds its place better than a foot beside it
_BEARING_HEIGHT: Final = 0.006  # metres: points this much above the lowest bear e times less weight

_BIAS: Final = {
    # how a constant asymmetry of one unit lies on the limbs: rotated, not bent backwards
    "left_hip_rotate": 0.5,
    "right_hip_rotate": -0.5,
    "left_shoulder_twist": 0.5,
    "right_shoulder_twist": -0.5,
    "left_elbow": 1.0,
}


class Conditions(TypedDict, total=False):
    """What every movement can be performed under. All optional.

    - ``noise_degrees``: sensor noise, root mean square turn of each joint, degrees, 0 to 30
    - ``noise_kind``: "white" (anew in every frame) or "smooth" (below 3 Hz, the same at every frame rate, and the whole body
      sways over the floor as if it turned as much about its feet)
    - ``asymmetry_degrees``: constant difference of left and right, degrees, −60 to 60: the left elbow bent more, the left
      upper arm and thigh rotated outward and the right inward by half as much
    - ``body``: a `Body`, or its height in metres
    - ``facing_degrees``: heading at the start, turned to the left from +z
    - ``route``: "straight", "circle" (to the left, 3 m radius), or points (n, 2) of x, z in metres from where he starts,
      before ``facing_degrees`` turns them; only for what travels
    - ``mirrored``: perform the mirror image of the movement; asymmetry, facing and route stay as given
    """

    noise_degrees: float
    noise_kind: Literal["white", "smooth"]
    asymmetry_degrees: float
    body: Body | float
    facing_degrees: float
    route: str | ArrayLike
    mirrored: bool


@dataclass(frozen=True)
class _Route:
    """A line on the floor by arc length."""

    place: Callable[[Array], Array]
    """Metres (n,) to x, z (n, 2)."""
    heading: Callable[[Array], Array]
    """Metres to radians about +y from +z."""


_CIRCLE_RADIUS: Final = 3.0


def _straight() -> _Route:
    return _Route(lambda s: np.stack([np.zeros_like(s), s], axis=-1), np.zeros_like)


def _circle() -> _Route:
    r = _CIRCLE_RADIUS
    return _Route(
        lambda s: np.stack([r * (1.0 - np.cos(s / r)), r * np.sin(s / r)], axis=-1),
        lambda s: s / r,
    )


def _line(points: ArrayLike) -> _Route:
    try:
        p = np.asarray(points, dtype=np.float64)
    except (TypeError, ValueError):
        p = np.empty(0)
    if p.ndim != 2 or p.shape[1] != 2 or len(p) < 2 or not np.isfinite(p).all():
        raise InputError(
            f"Expected `route` to be 'straight', 'circle' or at least two finite points (n, 2), got {points!r}."
        )
    steps = np.linalg.norm(np.diff(p, axis=0), axis=1)
    if not np.all(steps > 1e-6):
        raise InputError(
            f"Two neighbouring points of `route` are the same: number {int(np.argmin(steps))} and the next."
        )
    rough = np.concatenate([[0.0], np.cumsum(steps)])
    curve = CubicSpline(rough, p, bc_type="natural")
    # true arc length by many short chords
    fine = np.linspace(0.0, rough[-1], 200 * len(p))
    dense = curve(fine)
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(dense, axis=0), axis=1))])
    headings = np.unwrap(np.arctan2(*curve(fine, 1).T))

    def place(s: Array) -> Array:
        inside = np.stack([np.interp(s, length, dense[:, k]) for k in (0, 1)], axis=-1)
        beyond = np.maximum(s - length[-1], 0.0)[:, None] * np.array([np.sin(headings[-1]), np.cos(headings[-1])])
        before = np.minimum(s, 0.0)[:, None] * np.array([np.sin(headings[0]), np.cos(headings[0])])
        return np.asarray(inside + beyond + before - dense[0])

    return _Route(place, lambda s: np.interp(s, length, headings))


def _route(score: Score, route: str | ArrayLike | None) -> _Route:
    if route is None or (isinstance(route, str) and route == "straight"):
        return _straight()
    if not score.travels:
        raise InputError(f"{score.movement} does not travel and cannot follow a `route`; walk, run and limp can.")
    if isinstance(route, str):
        if route == "circle":
            return _circle()
        raise InputError(f"Expected `route` to be 'straight', 'circle' or points (n, 2), got {route!r}.")
    return _line(route)


def _body(given: Body | float) -> Body:
    if isinstance(given, Body):
        return given
    return Body(height=check_number("body", given, 0.5, 2.5, unit="m"))


def perform_score(
    score: Score,
    *,
    fps: float,
    seed: int,
    noise_degrees: float = 0.0,
    noise_kind: str = "white",
    asymmetry_degrees: float = 0.0,
    body: Body | float = 1.75,
    facing_degrees: float = 0.0,
    route: str | ArrayLike | None = None,
    mirrored: bool = False,
) -> Performance:
    """Perform a score. Keywords as in `Conditions`.

    Raises
    ------
    InputError
        If a condition is out of range; the message names it.
    """
    fps = check_number("fps", fps, 1.0, 10000.0)
    noise_degrees = check_number("noise_degrees", noise_degrees, 0.0, 30.0, unit="degrees")
    asymmetry_degrees = check_number("asymmetry_degrees", asymmetry_degrees, -60.0, 60.0, unit="degrees")
    facing = np.deg2rad(check_number("facing_degrees", facing_degrees, -3600.0, 3600.0, unit="degrees"))
    if noise_kind not in ("white", "smooth"):
        raise InputError(f"Expected `noise_kind` 'white' or 'smooth', got {noise_kind!r}.")
    person = _body(body)
    way = _route(score, route)
    frames = max(1, round(score.seconds * fps))
    shutter = Shutter(fps, frames)
    times = np.arange(frames) / fps
    truth = score.truth(shutter)

    side = -1.0 if mirrored else 1.0
    bias = np.zeros(len(ANGLES))
    for name, share in _BIAS.items():
        bias[ANGLE[name]] = share * np.deg2rad(asymmetry_degrees)

    def angles(at: Array) -> Array:
        values = score.angles(at)
        return (_postures.mirror(values) if mirrored else values) + bias

    def heading(at: Array) -> Array:
        return side * score.heading(at)

    rotations = joint_rotations(angles(times))
    ground = _Ground(person)
    height = ground.support_height(rotations) + score.lift(times)

    grid = np.arange(int(np.ceil(score.seconds * _GRID_RATE)) + 2) / _GRID_RATE
    grid_rotations = joint_rotations(angles(grid))
    travelled = ground.travel(grid_rotations, heading(grid), score.lift(grid), score.blend)
    if score.travels:
        forward = np.interp(times, grid, travelled[:, 1])
        # what sways to the side must not become a drift
        sway = _without_trend(travelled[:, 0])
        course = way.heading(forward)
        aside = np.stack([np.cos(course), -np.sin(course)], axis=-1) * np.interp(times, grid, sway)[:, None]
        floor = way.place(forward) + aside
        yaw = course + heading(times)
    else:
        if score.detrend:
            travelled = _without_trend(travelled)
        floor = np.stack([np.interp(times, grid, travelled[:, k]) for k in (0, 1)], axis=-1)
        yaw = heading(times)

    c, s = np.cos(facing), np.sin(facing)
    floor = floor @ np.array([[c, -s], [s, c]])
    turn = np.zeros((frames, 4))
    turn[:, 0], turn[:, 2] = np.cos((yaw + facing) / 2.0), np.sin((yaw + facing) / 2.0)
    rotations[:, 0] = quaternion.multiply(turn, rotations[:, 0])
    if noise_degrees > 0.0:
        rng = generator(seed, NOISE_STREAM)
        rms = np.deg2rad(noise_degrees)
        rotations = _noisy(rotations, times, rms, noise_kind, rng)
        if noise_kind == "smooth":
            floor = floor + rms * person.leg_length / np.sqrt(2.0) * _slow_waves(times, (2,), rng)
    motion = Motion(
        skeleton=person.skeleton,
        rotations=rotations,
        root_positions=np.stack([floor[:, 0], height, floor[:, 1]], axis=-1),
        fps=fps,
        name=score.movement,
    )
    return Performance(motion, truth.mirror() if mirrored else truth)


def _without_trend(values: Array) -> Array:
    line = np.linspace(0.0, 1.0, len(values)).reshape(-1, *(1,) * (values.ndim - 1))
    return np.asarray(values - values[0] - line * (values[-1] - values[0]))


def _noisy(rotations: Array, times: Array, rms: float, kind: str, rng: np.random.Generator) -> Array:
    shape = (rotations.shape[1], 3)
    noise = rng.standard_normal((len(times), *shape)) if kind == "white" else _slow_waves(times, shape, rng)
    return quaternion.multiply(rotations, quaternion.from_rotvec(rms / np.sqrt(3.0) * noise))


def _slow_waves(times: Array, shape: tuple[int, ...], rng: np.random.Generator) -> Array:
    """Smooth noise of unit variance, shape (times, *shape): a sum of slow waves, that any frame rate may sample."""
    waves = 24
    frequency = rng.uniform(0.1, 3.0, (waves, *shape))
    phase = rng.uniform(0.0, 2.0 * np.pi, (waves, *shape))
    out = np.zeros((len(times), *shape))
    at = times.reshape(-1, *(1,) * len(shape))
    for k in range(waves):
        out += np.cos(2.0 * np.pi * frequency[k] * at + phase[k])
    return np.asarray(out * np.sqrt(2.0 / waves))


@dataclass(frozen=True)
class _Ground:
    """Where a body meets the ground."""

    body: Body

    def _points(self, rotations: Array, points: Sequence[ContactPoint]) -> Array:
        """Contact points relative to the root, shape (frames, points, 3), their radius taken off the height."""
        skeleton = self.body.skeleton
        world = kinematics.forward(skeleton, rotations, np.zeros((len(rotations), 3)))
        out = np.empty((len(rotations), len(points), 3))
        for k, point in enumerate(points):
            out[:, k] = world.positions[:, point.joint]
            if any(point.offset):
                out[:, k] += quaternion.rotate(world.rotations[:, point.joint], np.array(point.offset))
            out[:, k, 1] -= point.radius
        return out

    def support_height(self, rotations: Array) -> Array:
        """Height of the root at which the lowest point of the body touches the ground, metres, shape (frames,)."""
        assert rotations.shape[1] == len(JOINT_NAMES)
        return np.asarray(-self._points(rotations, self.body.contact_points)[..., 1].min(axis=1))

    def travel(self, rotations: Array, heading: Array, lift: Array, blend: float) -> Array:
        """Where the root goes over the floor if what bears the weight stays where it is.

        Shape (frames, 2): x, z from the start, metres. In flight the velocity is carried over from before to after.
        Over ``blend`` seconds the velocity is averaged (`Score.blend`).
        """
        points = self._points(rotations, self.body.contact_points)
        c, s = np.cos(heading)[:, None], np.sin(heading)[:, None]
        x = c * points[..., 0] + s * points[..., 2]
        z = -s * points[..., 0] + c * points[..., 2]
        level = points[..., 1] - points[..., 1].min(axis=1, keepdims=True)
        middle = 0.5 * (level[1:] + level[:-1])
        grip = np.ones(len(self.body.contact_points))
        grip[len(self.body.foot_points) :] = _HAND_GRIP
        weight = grip * np.exp(-middle / _BEARING_HEIGHT)
        weight /= weight.sum(axis=1, keepdims=True)
        step = -np.stack([(weight * np.diff(v, axis=0)).sum(axis=1) for v in (x, z)], axis=-1)
        flying = 0.5 * (lift[1:] + lift[:-1]) > 1e-6
        if flying.any() and not flying.all():
            known = np.flatnonzero(~flying)
            for k in (0, 1):
                step[flying, k] = np.interp(np.flatnonzero(flying), known, step[known, k])
        if blend > 0.0:
            width = 2 * round(0.5 * blend * _GRID_RATE) + 1
            window = np.hanning(width + 2)[1:-1] / np.hanning(width + 2).sum()
            step = np.stack(
                [np.convolve(step[:, k], window, "full")[width // 2 :][: len(step)] for k in (0, 1)], axis=-1
            )
        return np.concatenate([np.zeros((1, 2)), np.cumsum(step, axis=0)])


def stillness_of(holds: Sequence[tuple[float, float]], shutter: Shutter) -> tuple[Range, ...]:
    """The frames of the holds that have any."""
    ranges = (shutter.range(start, end) for start, end in holds)
    return tuple(r for r in ranges if len(r) > 0)
