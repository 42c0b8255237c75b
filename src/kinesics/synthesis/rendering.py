"""A list of paths performed: one movement without seams, its feet on the ground ([Schultz2012] §4.4).

1. Paths are laid end to end: each is turned about the vertical and shifted over the floor so that its first moment takes
   the place and the heading of the one with which the path before would have gone on (Kovar, Gleicher & Pighin 2002, §3.3).
2. At every cut the offset of pose, height and tilt is taken away over a short time (`kinesics.synthesis.blending`), over a
   time that accelerates nothing more than the recordings do.
3. Feet that bear stay where they are (after Kovar, Schreiner & Gleicher 2002). Their data tell which part of the sole bears:
   the lower a point, the more (heel, then ball, then tip). What is added to the places of feet and body, so that bearing
   soles neither slide nor hover and nothing is accelerated more than need be, is sought for all frames at once
   (`kinesics.synthesis.footing`). No sole is let below the floor.
4. Legs reach by inverse kinematics; feet keep their orientation. A joint that would go more than a degree beyond its range is
   put back, a leg that would go deeper into the other than it ever does is moved aside, and the body goes along as far as it
   can (steps 3 and 4 again); what is left a foot slides: range first.

`LiveRenderer` does the same frame by frame, knowing only the past.
"""

from __future__ import annotations

import dataclasses
import itertools
import weakref
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinesics.body import contacts as _contacts
from kinesics.body import kinematics
from kinesics.body.contacts import Floor, Soles, runs
from kinesics.body.limits import JOINT_TOLERANCE, Capsules, segment_distance
from kinesics.body.motion import Motion
from kinesics.errors import InputError
from kinesics.geometry import quaternion
from kinesics.synthesis import blending, footing, inverse_kinematics
from kinesics.synthesis.footing import Bounds
from kinesics.synthesis.inverse_kinematics import Legs
from kinesics.synthesis.network import Network
from kinesics.synthesis.repertoire import Repertoire

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Indices = NDArray[np.intp]

YARDSTICK: Final = 0.99
"""Quantile of the recordings' own accelerations that a transition may not exceed."""
LEAST_TURNING: Final = 1.0
"""rad/s²: legs that stand perfectly still in the recordings may yet be turned by so much; nobody sees it."""
LEAST_BODY: Final = 0.1
"""m/s²: the same of the body."""
SPARED: Final = 0.5
"""Share of that acceleration which the transition may add to the recordings' own."""
BEARING: Final = 0.008
"""Metres: a point of the sole this much above the lowest bears e times less."""
RELEASE: Final = 0.07
"""Seconds before and after a contact over which the foot is let go."""
_MARGIN: Final = 0.25
"""Share of such times for which the foot is still held as if it bore: no rule tells the very frame of its lifting."""
GRIP: Final = 0.03
"""Seconds in which a foot that comes down is held more and more firmly; in reverse as it is lifted."""
GRIP_BEFORE: Final = 0.05
"""Seconds before and after a contact from which on it is."""
LIFT: Final = 0.10
"""Seconds before and after a contact over which the sole comes down to the floor."""
SHORTEST_GAP: Final = 0.13
"""Seconds: at a transition no foot is lifted for less."""
SHORTEST_CONTACT: Final = 0.06
"""Seconds: at a transition no foot is set down for less."""
SOFTLY: Final = 0.05
"""Seconds before and after over which the height of a foot is corrected: less than a step, more than a marker's tremble."""
SUNK: Final = 0.004
"""Metres below the floor that are let pass: a sole gives way."""
ROUNDS: Final = 10
"""Most times that feet are planted, joints put back that were bent too far, and planted again as far as these go."""
_LEGS: Final = {"left", "right", "femur", "tibia"}
_SHORT: Final = 0.001
"""Metres by which a foot is off where it was planted before the body goes along."""
FLESH: Final = 0.01
"""Metres that limbs may press deeper into each other than they do in the recordings: flesh gives way by twice as much, and
radii are known no better (`kinesics.body.limits.DEPTH_TOLERANCE`)."""
_NOTHING: Final = np.deg2rad(0.2)
RANGE_TOLERANCE: Final = JOINT_TOLERANCE
"""Radians that a joint may go beyond its range in the recordings: as much as the limits of a file are known to
(`kinesics.body.limits.JOINT_TOLERANCE`). At the end of a leg it is a centimetre and a half."""
YIELD: Final = 0.1
"""Seconds before and after over which a joint goes back that would go beyond its range."""
_FLIGHT: Final = 0.05
"""What weighs for no shift at all, so that a body in flight comes back."""
SINK: Final = 0.15
"""Seconds before and after over which the pelvis gives way where a leg cannot reach."""


@dataclass(frozen=True, eq=False)
class Provenance:
    """Where every frame of a performance comes from; arrays of shape (frames,) unless said otherwise."""

    moment: Indices
    """In the repertoire: see `kinesics.synthesis.repertoire`."""
    recording: Indices
    """Number of the recording."""
    source_frame: Array
    """Place in that recording, in its own frames."""
    mirrored: Mask
    backwards: Mask
    step: Indices
    """Place in the list of paths."""
    path: Indices
    """Number of the path in the network."""
    transition: Mask
    """Whether the frame lies within a transition: its pose is not quite that of its source."""
    weight: Array
    """Share of the frame's own recording in it: 1 away from transitions, about ½ at a cut, where the other is the rest."""


class Contact(NamedTuple):
    """One foot on the ground."""

    foot: int
    """0 left, 1 right."""
    start: int
    """Frames [start, end)."""
    end: int
    place: tuple[float, float]
    """Of the bearing part of the sole, on the average: x, z, metres."""


@dataclass(frozen=True, eq=False)
class Performance:
    """A new movement, and where it comes from."""

    motion: Motion
    provenance: Provenance
    paths: tuple[int, ...]
    """Numbers of the paths in the network, in the order of performance."""
    cuts: Indices
    """First frame of every path that a transition leads to, shape (cuts,)."""
    feet: Mask
    """Whether the left and the right foot bear on the ground, shape (frames, 2)."""
    contacts: tuple[Contact, ...]
    soles: Soles
    corrected: Array
    """Metres by which the ankles were moved to keep the feet on the ground, shape (frames, 2, 3)."""
    lowered: Array
    """Metres by which the pelvis was lowered, shape (frames,)."""
    missed: Array
    """Metres by which each ankle falls short of its place all the same, shape (frames, 2)."""


@dataclass(frozen=True, eq=False)
class Stage:
    """What is measured once on a repertoire: soles, legs, how quick its joints are and how far they go."""

    repertoire: Repertoire
    legs: Legs
    soles: Soles
    levels: Array
    """Height above the floor at which each point of the soles usually bears, metres, shape (2, 3)."""
    slow: float
    """Speed below which a sole begins to bear, m/s."""
    accelerations: Array
    """99th percentile for each joint (rad/s²) and, last, for the root's place (m/s²), shape (joints + 1,)."""
    blended: Indices
    """Joints that set the length of a transition: those of the body, not fingers or toes; and the root's place."""
    middle: Array
    """Mean rotation of each joint over all recordings and mirror images, shape (joints, 4)."""
    carrier: int
    """Joint that the body hangs on: the root, or the pelvis where the root joint does nothing but stand beneath it."""
    low: Array
    """Least and greatest component of the rotation vector of each joint from its mean, radians, shape (joints, 3)."""
    high: Array
    usual: footing.Usual
    """Accelerations of the legs and the body."""
    capsules: Capsules
    deepest: Array
    """Metres that each pair of the capsules passes into each other in the recordings, mirrored counted; 0 if never."""

    @classmethod
    def of(cls, repertoire: Repertoire) -> Stage:
        """Of a repertoire; measured once and kept as long as the repertoire is.

        Raises
        ------
        SkeletonError
            If the skeleton's legs have no feet.
        """
        if repertoire not in _stages:
            _stages[repertoire] = cls._measured(repertoire)
        return _stages[repertoire]

    @classmethod
    def _measured(cls, repertoire: Repertoire) -> Stage:
        skeleton, fps = repertoire.skeleton, repertoire.fps
        whole = Motion(skeleton, repertoire.rotations[0], repertoire.root_positions[0], fps)
        found = _contacts.contacts(whole, ground=Floor(0.0))
        legs = inverse_kinematics.legs(skeleton, repertoire.rotations[0][:: max(1, repertoire.frame_count // 4000)])
        strands = (0, 1) if repertoire.mirrored else (0,)
        rotations = repertoire.rotations[list(strands)]
        accelerations = np.full(skeleton.joint_count + 1, 1e-6)
        # over a thirtieth of a second to either side: from frame to frame it would be the tremble of the markers
        w = max(1, round(fps / 30.0))
        inside = _inner(repertoire, w)
        if len(inside):
            seconds = w / fps
            at = rotations[:, inside]
            before = blending.rotation_offset(rotations[:, inside - w], at)
            after = blending.rotation_offset(at, rotations[:, inside + w])
            change = np.linalg.norm(after - before, axis=-1) / seconds**2
            accelerations[:-1] = np.quantile(change.reshape(-1, skeleton.joint_count), YARDSTICK, axis=0)
            place = repertoire.root_positions[0]
            change = place[inside + w] - 2.0 * place[inside] + place[inside - w]
            accelerations[-1] = np.quantile(np.linalg.norm(change, axis=-1), YARDSTICK) / seconds**2
            np.maximum(accelerations, 1e-6, out=accelerations)  # legs of a performed body may not move at all
        middle = np.empty((skeleton.joint_count, 4))
        flat = rotations.reshape(-1, skeleton.joint_count, 4)
        middle[:] = quaternion.mean(flat[:: max(1, len(flat) // 4000)])
        vectors = blending.rotation_offset(middle, flat)
        levels = 0.5 * (found.levels + found.levels[::-1])
        capsules = Capsules.of(whole)
        deepest = np.zeros(len(capsules.pairs))
        for strand in strands:
            known = kinematics.forward(skeleton, repertoire.rotations[strand], repertoire.root_positions[strand])
            deepest = np.maximum(deepest, capsules.depths(*known).max(axis=0, initial=0.0))
        return cls(
            repertoire,
            legs,
            found.soles,
            levels,
            found.slow,
            accelerations,
            _body_joints(repertoire),
            middle,
            _carrier(repertoire),
            vectors.min(axis=0),
            vectors.max(axis=0),
            footing.Usual(
                np.maximum(accelerations[list(legs.femurs)], LEAST_TURNING),
                np.maximum(accelerations[list(legs.tibias)], LEAST_TURNING),
                max(float(accelerations[-1]), LEAST_BODY),
            ),
            capsules,
            deepest,
        )


_stages: weakref.WeakKeyDictionary[Repertoire, Stage] = weakref.WeakKeyDictionary()


def _inner(repertoire: Repertoire, reach: int) -> Indices:
    """Frames that have ``reach`` frames of their own recording before and behind them."""
    inside = np.zeros(repertoire.frame_count, dtype=np.bool_)
    for a, b in itertools.pairwise(repertoire.starts.tolist()):
        inside[a + reach : max(a, b - reach)] = True
    return np.nonzero(inside)[0]


def _carrier(repertoire: Repertoire) -> int:
    """The pelvis, if nothing else hangs on the joints above it; else the root."""
    skeleton = repertoire.skeleton
    assert skeleton.anatomy is not None
    joint = pelvis = skeleton.anatomy.pelvis
    while joint > 0:
        joint = skeleton.parents[joint]
        if len(skeleton.children[joint]) > 1:
            return 0
    return pelvis


def _turned(repertoire: Repertoire, carrier: int, rotations: Array, yaw: Array) -> None:
    """Turn bodies (frames, joints, 4) about the vertical, in place, by turning the joint that they hang on."""
    turn = _about_y(yaw)
    above: Array | None = None
    joint = carrier
    while joint > 0:
        joint = repertoire.skeleton.parents[joint]
        own = rotations[:, joint]
        above = own if above is None else quaternion.multiply(own, above)
    if above is not None:
        turn = quaternion.multiply(quaternion.conjugate(above), quaternion.multiply(turn, above))
    rotations[:, carrier] = quaternion.multiply(turn, rotations[:, carrier])


def _body_joints(repertoire: Repertoire) -> Indices:
    """Joints that carry the 15 links, and number ``joint_count`` for the root's place."""
    skeleton = repertoire.skeleton
    assert skeleton.anatomy is not None
    roles = skeleton.anatomy.roles
    joints = {0, roles.pelvis, *roles.spine, *roles.neck, roles.head}
    for side in ("left", "right"):
        joints |= {getattr(roles, f"{side}_{part}") for part in ("femur", "tibia", "humerus", "radius")}
    return np.array([*sorted(joints), skeleton.joint_count], dtype=np.intp)


def render(
    network: Network,
    paths: Sequence[int] | Indices,
    *,
    start: ArrayLike = (0.0, 0.0),
    heading: float = 0.0,
    bend: ArrayLike | None = None,
    pinned: bool = True,
    name: str = "performance",
) -> Performance:
    """Perform paths one after another as one continuous movement.

    Parameters
    ----------
    network : of the paths.
    paths : numbers of paths, each a successor of the one before.
    start : where the root is in the first frame, x and z, metres.
    heading : where the pelvis faces in the first frame, radians about +y from +z.
    bend : radians that each path is turned by besides, spread evenly over its frames, to the left if positive: shape (paths,).
    pinned : whether feet are kept in place.

    Raises
    ------
    InputError
        If there is no path, a number is none of a path, or a path does not follow the one before.
    SkeletonError
        If the skeleton's legs have no feet.
    """
    chosen = _checked(network, paths)
    extra = np.zeros(len(chosen)) if bend is None else np.asarray(bend, dtype=np.float64)
    origin = np.asarray(start, dtype=np.float64)
    if extra.shape != (len(chosen),) or not np.isfinite(extra).all():
        raise InputError(f"Expected one finite `bend` for each of {len(chosen)} paths, got shape {extra.shape}.")
    if origin.shape != (2,) or not np.isfinite(origin).all() or not np.isfinite(heading):
        raise InputError(f"Expected `start` as finite x, z and a finite `heading`, got {start!r} and {heading!r}.")
    stage = Stage.of(network.repertoire)
    laid = _lay(stage, network, chosen, origin, float(heading), extra)
    blended = _blend(stage, laid)
    rotations, roots = blended.rotations, blended.roots
    if len(laid.cuts):
        _within_range(stage, rotations, np.arange(stage.carrier + 1, rotations.shape[1]), blended.weight < 1.0)
    changed = quaternion.angle(rotations, laid.rotations).max(axis=1) > 1e-7
    changed |= (blended.weight < 1.0) | np.any(roots != laid.roots, axis=1)
    standing = _standing(network.repertoire, laid)
    if pinned:
        footed = _pin(stage, rotations, roots, standing)
        rotations, roots = footed.rotations, footed.roots
    else:
        zero = np.zeros((len(roots), 2, 3))
        footed = _Footed(rotations, roots, zero, np.zeros(len(roots)), np.zeros((len(roots), 2)))
    motion = Motion(
        network.repertoire.skeleton,
        rotations,
        roots,
        network.repertoire.fps,
        name=name,
        assumptions=network.repertoire.assumptions,
    )
    return Performance(
        motion,
        _provenance(network, laid, blended.weight, changed),
        tuple(int(p) for p in chosen),
        laid.cuts,
        standing,
        _contact_list(stage, motion, standing),
        stage.soles,
        footed.corrected,
        footed.lowered,
        footed.missed,
    )


def _checked(network: Network, paths: Sequence[int] | Indices) -> Indices:
    chosen = np.asarray(paths)
    if chosen.ndim != 1 or len(chosen) == 0 or not np.issubdtype(chosen.dtype, np.integer):
        raise InputError(f"Expected a list of path numbers, got {paths!r}.")
    chosen = chosen.astype(np.intp)
    if chosen.min() < 0 or chosen.max() >= len(network):
        raise InputError(f"Expected paths below {len(network)}, got {chosen.min()} to {chosen.max()}.")
    for k in range(1, len(chosen)):
        if chosen[k] not in network.successors(int(chosen[k - 1])):
            raise InputError(
                f"Path {chosen[k]} (number {k} in the list) does not follow path {chosen[k - 1]}. Its successors: "
                f"{', '.join(str(s) for s in network.successors(int(chosen[k - 1])))}."
            )
    return chosen


# --- laid end to end


@dataclass(frozen=True, eq=False)
class _Laid:
    """Paths end to end, before anything is blended."""

    moments: Indices
    """Shape (frames,)."""
    step: Indices
    path: Indices
    cuts: Indices
    """Frames at which a transition arrives."""
    rotations: Array
    roots: Array
    offsets: Array
    """Of every cut, joints and (last) the root's place: shape (cuts, joints + 1, 3)."""
    velocities: Array
    """The same of what they change by in a second."""
    room: Array
    """Seconds before and after each cut to the next: shape (cuts, 2)."""
    fps: float


def _lay(stage: Stage, network: Network, chosen: Indices, origin: Array, heading: float, extra: Array) -> _Laid:
    repertoire, carrier = stage.repertoire, stage.carrier
    fps = repertoire.fps
    lengths = network.length[chosen]
    ends = np.cumsum(lengths)
    begins = ends - lengths
    frames = int(ends[-1])
    step = np.repeat(np.arange(len(chosen)), lengths)
    within = np.arange(frames) - begins[step]
    moments = repertoire.advance(network.first[chosen][step], within)
    first, onward = network.first[chosen], network.onward[chosen]
    # the heading: the first moment of a path faces where the one before would have faced
    face_first, face_onward = repertoire.yaw_of(first), repertoire.yaw_of(onward)
    turn = heading - face_first[0] + np.concatenate([[0.0], np.cumsum(face_onward[:-1] - face_first[1:])])
    bent = np.concatenate([[0.0], np.cumsum(extra)])
    lean = bent[step] + extra[step] * within / lengths[step]
    yaw = turn[step] + lean
    # the place: steps of the recordings, each turned as its path is
    here, after = repertoire.roots_of(moments), repertoire.roots_of(repertoire.advance(moments, 1))
    moved = after - here
    half = yaw + 0.5 * extra[step] / lengths[step]
    x = np.cos(half) * moved[:, 0] + np.sin(half) * moved[:, 2]
    z = -np.sin(half) * moved[:, 0] + np.cos(half) * moved[:, 2]
    roots = here.copy()
    roots[:, 0] = origin[0] + np.concatenate([[0.0], np.cumsum(x)[:-1]])
    roots[:, 2] = origin[1] + np.concatenate([[0.0], np.cumsum(z)[:-1]])
    rotations = repertoire.rotations_of(moments)
    _turned(repertoire, carrier, rotations, yaw)

    jumps = np.nonzero(first[1:] != onward[:-1])[0] + 1
    cuts = begins[jumps]
    joints = repertoire.skeleton.joint_count
    offsets = np.zeros((len(cuts), joints + 1, 3))
    velocities = np.zeros_like(offsets)
    if len(cuts):
        world = turn + bent[:-1]
        offsets, velocities = _seams(
            repertoire, carrier, onward[jumps - 1], world[jumps - 1] + extra[jumps - 1], first[jumps], world[jumps]
        )
    bounds = np.concatenate([[0], cuts, [frames]])
    room = np.stack([cuts - bounds[:-2], bounds[2:] - cuts], axis=-1) / fps
    return _Laid(moments, step, chosen[step], cuts, rotations, roots, offsets, velocities, room, fps)


def _seams(
    repertoire: Repertoire,
    carrier: int,
    left: Indices,
    left_yaw: Array,
    entered: Indices,
    entered_yaw: Array,
) -> tuple[Array, Array]:
    """Offsets of what is entered from what is left, and how quickly they change, shapes (cuts, joints + 1, 3)."""
    around = np.array([[-1], [0], [1]])
    sides = np.stack([left, entered])
    moments = repertoire.advance(sides[None], around[..., None])
    there = np.asarray((moments >= 0).all(axis=1))
    moments = np.where(there[:, None], moments, sides)
    yaw = np.broadcast_to(np.stack([left_yaw, entered_yaw]), moments.shape).ravel()
    q, roots = repertoire.rotations_of(moments.ravel()), repertoire.roots_of(moments.ravel())
    _turned(repertoire, carrier, q, yaw)
    q = q.reshape(*moments.shape, *q.shape[1:])
    place = quaternion.rotate(_about_y(yaw), roots).reshape(*moments.shape, 3)
    turned = blending.rotation_offset(q[:, 0], q[:, 1])
    before, now, after = np.concatenate([turned, (place[:, 1] - place[:, 0])[:, :, None]], axis=2)
    span = (there[0].astype(np.float64) + there[2].astype(np.float64))[:, None, None]
    fps = repertoire.fps
    # a rotation vector leaps where it passes half a turn; such an offset has no velocity that could be told
    change = after - before
    velocity = np.where(span > 0.0, change / np.maximum(span, 1.0) * fps, 0.0)
    velocity = np.where(np.linalg.norm(change, axis=-1, keepdims=True) < 2.0, velocity, 0.0)
    now = now.copy()
    now[:, -1, [0, 2]] = 0.0  # the place on the floor is that of the recording left, by the way the paths were laid
    return now, velocity


def _about_y(yaw: Array) -> Array:
    half = 0.5 * np.asarray(yaw)
    zero = np.zeros_like(half)
    return np.stack([np.cos(half), zero, np.sin(half), zero], axis=-1)


# --- without seams


class _Blended(NamedTuple):
    rotations: Array
    roots: Array
    weight: Array


def _blend(stage: Stage, laid: _Laid) -> _Blended:
    frames = len(laid.moments)
    rotations, roots = laid.rotations.copy(), laid.roots.copy()
    weight = np.ones(frames)
    added = np.zeros((frames, *laid.offsets.shape[1:])) if len(laid.cuts) else None
    for k, cut in enumerate(laid.cuts.tolist()):
        assert added is not None
        size, speed = np.linalg.norm(laid.offsets[k], axis=-1), np.linalg.norm(laid.velocities[k], axis=-1)
        which = stage.blended
        span = blending.window(
            size[which],
            speed[which],
            SPARED * stage.accelerations[which],
            before=laid.room[k, 0],
            after=laid.room[k, 1],
        )
        a = max(0, cut - int(np.ceil(span.before * laid.fps)))
        b = min(frames, cut + int(np.ceil(span.after * laid.fps)) + 1)
        times = (np.arange(a, b) - cut) / laid.fps
        added[a:b] += blending.two_sided(laid.offsets[k], laid.velocities[k], times, span)
        own = np.where(times < 0.0, 1.0 - span.share_before * blending.ease(1.0 + times / max(span.before, 1e-9)), 0.0)
        own += np.where(
            times >= 0.0, 1.0 - (1.0 - span.share_before) * blending.ease(1.0 - times / max(span.after, 1e-9)), 0.0
        )
        weight[a:b] = np.minimum(weight[a:b], own)
    if added is not None:
        touched = np.nonzero(np.any(added != 0.0, axis=(1, 2)))[0]
        rotations[touched] = blending.add_rotation(rotations[touched], added[touched, :-1])
        roots += added[:, -1]
    return _Blended(rotations, roots, weight)


def _within_range(stage: Stage, rotations: Array, joints: Indices, where: Mask | None = None) -> None:
    """Put joints back into the range that they have in the recordings, over a stretch of time rather than at once.

    Parameters
    ----------
    rotations : shape (frames, joints, 4); changed in place.
    joints : numbers of those looked at.
    where : frames in which a joint can be beyond at all.
    """
    reach = max(1, round(YIELD * stage.repertoire.fps))
    frames = np.arange(len(rotations)) if where is None else np.nonzero(where)[0]
    middle = stage.middle[joints]
    low, high = stage.low[joints] - RANGE_TOLERANCE, stage.high[joints] + RANGE_TOLERANCE
    vectors = blending.rotation_offset(middle, rotations[np.ix_(frames, joints)])
    beyond = np.maximum(np.maximum(vectors - high, low - vectors), 0.0)
    for n in np.nonzero((beyond > 1e-9).any(axis=(0, 2)))[0].tolist():
        at = blending.rotation_offset(middle[n], rotations[:, joints[n]])
        for axis in np.nonzero((beyond[:, n] > 1e-9).any(axis=0))[0].tolist():
            over = np.zeros((2, len(rotations)))
            over[0, frames] = np.maximum(vectors[:, n, axis] - high[n, axis], 0.0)
            over[1, frames] = np.maximum(low[n, axis] - vectors[:, n, axis], 0.0)
            back = envelope(over[0], reach) - envelope(over[1], reach)
            at[:, axis] = np.where(back != 0.0, np.clip(at[:, axis] - back, low[n, axis], high[n, axis]), at[:, axis])
        rotations[:, joints[n]] = blending.add_rotation(middle[n], at)


def envelope(values: Array, reach: int) -> Array:
    """A smooth curve that is nowhere below ``values`` (frames,), which are not negative: it rises and falls over ``reach``.

    The greatest within ``reach`` frames, averaged under a Hann window of the same reach.
    """
    from scipy.ndimage import maximum_filter1d

    if not values.any():
        return np.zeros_like(values)
    wide = maximum_filter1d(values, 2 * reach + 1, mode="nearest")
    return _smooth(wide, reach)


# --- feet


def _standing(repertoire: Repertoire, laid: _Laid) -> Mask:
    """When the feet bear: as in the sources, but for what is too short at a cut to be a contact or a gap."""
    out = repertoire.contacts_of(laid.moments).copy()
    for k in (0, 1):
        for cut in laid.cuts.tolist():
            for value, seconds in ((False, SHORTEST_GAP), (True, SHORTEST_CONTACT)):
                shortest = round(seconds * laid.fps)
                for a, b in _runs_near(out[:, k] == value, cut, shortest):
                    if b - a < shortest and a > 0 and b < len(out):
                        out[a:b, k] = not value
    return out


def _runs_near(mask: Mask, cut: int, reach: int) -> list[tuple[int, int]]:
    """Runs of True within ``reach`` frames of a cut."""
    low, high = max(0, cut - 2 * reach - 2), min(len(mask), cut + 2 * reach + 2)
    return [(low + a, low + b) for a, b in runs(mask[low:high]) if low + a <= cut + reach and cut - reach <= low + b]


class _Footed(NamedTuple):
    rotations: Array
    roots: Array
    corrected: Array
    lowered: Array
    missed: Array


def _pin(stage: Stage, rotations: Array, roots: Array, standing: Mask) -> _Footed:
    skeleton = stage.repertoire.skeleton
    held = np.stack([_held(standing[:, k], RELEASE * stage.repertoire.fps) for k in (0, 1)], axis=-1)
    feet = list(stage.legs.feet)
    parents = [skeleton.parents[j] for j in feet]
    joints = np.array([*stage.legs.femurs, *stage.legs.tibias, *feet])
    given = rotations
    recorded = kinematics.positions(skeleton, rotations, roots)[:, feet] - roots[:, None]
    bounds = Bounds.none(len(rotations))
    for attempt in range(ROUNDS):
        done = _planted(stage, given, roots, standing, held, bounds)
        within = done.rotations.copy()
        _within_range(stage, within, joints)
        push = _apart(stage, within, done.roots)
        settled = quaternion.angle(done.rotations[:, joints], within[:, joints]).max() < _NOTHING
        if attempt == ROUNDS - 1 or (settled and not push.any()):
            break
        # an ankle that would be bent too far turns its foot; the foot is then planted as it is turned
        given = given.copy()
        world = kinematics.global_rotations(skeleton, done.rotations)[:, parents]
        own = kinematics.global_rotations(skeleton, given)[:, parents]
        turned = quaternion.angle(done.rotations[:, feet], within[:, feet]) > _NOTHING
        new = quaternion.multiply(quaternion.conjugate(own), quaternion.multiply(world, within[:, feet]))
        given[:, feet] = np.where(turned[..., None], new, given[:, feet])
        # where the leg would go too far the body goes along instead
        placed = within.copy()
        placed[:, feet] = done.rotations[:, feet]
        reached = kinematics.positions(skeleton, placed, done.roots)[:, feet] - done.roots[:, None]
        asked = kinematics.positions(skeleton, done.rotations, done.roots)[:, feet] - done.roots[:, None]
        bound = (np.linalg.norm(reached - asked, axis=-1) > _SHORT) | (np.abs(push).max(axis=-1) > _SHORT)
        bounds = Bounds(
            np.where(bound[..., None], reached + push - recorded, bounds.place),
            np.where(bound, footing.BOUND, bounds.tolerance),
        )
    return _above_the_floor(stage, done._replace(rotations=within))


def _apart(stage: Stage, rotations: Array, roots: Array) -> Array:
    """By how much over the floor each foot is to move so that no leg is deeper in the other than ever: (frames, 2, 3)."""
    legs = [
        n
        for n, (a, b) in enumerate(stage.capsules.pairs)
        if {part for m in (a, b) for part in stage.capsules.names[m].split()} <= _LEGS
    ]
    capsules = dataclasses.replace(stage.capsules, pairs=tuple(stage.capsules.pairs[n] for n in legs))
    deepest = stage.deepest[legs]
    known = kinematics.forward(stage.repertoire.skeleton, rotations, roots)
    over = capsules.depths(*known) - deepest - 0.5 * FLESH
    out = np.zeros((len(rotations), 2, 3))
    if not (over > 0.5 * FLESH).any():
        return out
    starts, ends = capsules.ends(*known)
    for n, (a, b) in enumerate(capsules.pairs):
        deep = np.flatnonzero(over[:, n] > 0.0)
        sides = (0, 1) if capsules.names[a].startswith("left") else (1, 0)
        # the way apart is that in which the distance grows
        ways = np.zeros((len(deep), 3))
        for axis in (0, 2):
            for sign in (1.0, -1.0):
                shift = sign * _SHORT * np.eye(3)[axis]
                ways[:, axis] += sign * segment_distance(
                    starts[deep, a] + shift, ends[deep, a] + shift, starts[deep, b], ends[deep, b]
                )
        ways *= (over[deep, n] / np.maximum(np.linalg.norm(ways, axis=-1), 1e-9))[:, None]
        for foot, sign in zip(sides, (1.0, -1.0), strict=True):
            stronger = np.linalg.norm(ways, axis=-1) > np.linalg.norm(out[deep, foot], axis=-1)
            out[deep, foot] = np.where(stronger[:, None], sign * ways, out[deep, foot])
    reach = max(1, round(YIELD * stage.repertoire.fps))
    for foot in (0, 1):
        for axis in (0, 2):
            away = out[:, foot, axis]
            out[:, foot, axis] = envelope(np.maximum(away, 0.0), reach) - envelope(np.maximum(-away, 0.0), reach)
    return out


def _above_the_floor(stage: Stage, footed: _Footed) -> _Footed:
    """Where feet came below the floor as joints went back into their range, the body is raised."""
    known = kinematics.forward(stage.repertoire.skeleton, footed.rotations, footed.roots)
    sunk = -stage.soles.place(known.positions, known.rotations)[..., 1].min(axis=(1, 2)) - SUNK
    if sunk.max() <= 0.0:
        return footed
    roots = footed.roots.copy()
    roots[:, 1] += envelope(np.maximum(sunk, 0.0), max(1, round(SOFTLY * stage.repertoire.fps)))
    return footed._replace(roots=roots)


def _planted(stage: Stage, rotations: Array, roots: Array, standing: Mask, held: Array, bounds: Bounds) -> _Footed:
    repertoire, legs = stage.repertoire, stage.legs
    skeleton, fps = repertoire.skeleton, repertoire.fps
    known = kinematics.forward(skeleton, rotations, roots)
    soles = stage.soles.place(known.positions, known.rotations)
    hips, knees, ankles = (known.positions[:, list(joints)] for joints in (legs.femurs, legs.tibias, legs.feet))
    lowest = soles[..., 1].min(axis=2)
    height = soles[..., 1] - stage.levels
    share = bearing(0.5 * (height[1:] + height[:-1]))
    slid = np.einsum("fkp,fkpi->fki", share, np.diff(soles[..., [0, 2]], axis=0))
    grip = np.stack([_grip(standing[:, k], fps) for k in (0, 1)], axis=-1)
    press = np.stack([_held(standing[:, k], LIFT * fps) for k in (0, 1)], axis=-1)
    found = footing.footing(
        slid,
        np.minimum(grip[1:], grip[:-1]),
        lowest,
        press,
        footing.legs_of(hips, knees, ankles),
        stage.usual,
        fps,
        bounds,
    )
    corrected, shift = found.feet, found.body
    reach = max(1, round(SOFTLY * fps))
    for k in (0, 1):
        corrected[:, k, 1] += envelope(np.maximum(-(lowest[:, k] + corrected[:, k, 1]) - SUNK, 0.0), reach)
    targets = ankles + corrected
    shift[:, 1] -= _lowering(stage, known.positions + shift[:, None], targets, held, fps)
    known = known._replace(positions=known.positions + shift[:, None])
    done = inverse_kinematics.reach(skeleton, rotations, roots + shift, targets, limbs=legs, known=known)
    return _Footed(done.rotations, roots + shift, corrected, np.maximum(-shift[:, 1], 0.0), done.misses)


def bearing(height: Array) -> Array:
    """Share of the weight that each point of a sole bears, by its height: shape (..., points) to the same, sum 1."""
    level = height - height.min(axis=-1, keepdims=True)
    weight = np.exp(-level / BEARING)
    return np.asarray(weight / weight.sum(axis=-1, keepdims=True))


def _grip(standing: Mask, fps: float) -> Array:
    """How firmly a foot is held, 0 to 1: wholly while it bears, but for where it rolls on and off, shape (frames,)."""
    from scipy.ndimage import distance_transform_edt

    if standing.all() or not standing.any():
        return standing.astype(np.float64)
    inside = np.asarray(distance_transform_edt(standing)) - np.asarray(distance_transform_edt(~standing))
    return np.asarray(blending.ease((inside / fps + GRIP_BEFORE) / GRIP))


def _held(standing: Mask, reach: float) -> Array:
    """1 while a foot bears, going to 0 smoothly over ``reach`` frames before and after."""
    from scipy.ndimage import distance_transform_edt

    if standing.all():
        return np.ones(len(standing))
    away = np.asarray(distance_transform_edt(~standing))
    return 1.0 - blending.ease((away - _MARGIN * reach) / ((1.0 - _MARGIN) * reach + 1.0))


def _smooth(values: Array, reach: int) -> Array:
    """Averaged under a Hann window of ``reach`` frames to either side."""
    window = np.hanning(2 * reach + 3)[1:-1]
    return np.convolve(np.pad(values, reach, mode="edge"), window / window.sum(), "valid")


def _need(stage: Stage, positions: Array, targets: Array) -> Array:
    """How far each hip must come down for its leg to reach, metres, shape (frames, 2)."""
    legs = stage.legs
    hips, knees, ankles = (positions[:, list(joints)] for joints in (legs.femurs, legs.tibias, legs.feet))
    length = np.linalg.norm(knees - hips, axis=-1) + np.linalg.norm(ankles - knees, axis=-1)
    now = np.linalg.norm(ankles - hips, axis=-1)
    most = np.minimum(np.maximum(now, inverse_kinematics.SOFT * length), inverse_kinematics.STRAIGHTEST * length)
    away = targets - hips
    flat = np.linalg.norm(away[..., [0, 2]], axis=-1)
    return np.asarray(np.maximum(-away[..., 1] - np.sqrt(np.maximum(most**2 - flat**2, 0.0)), 0.0))


def _lowering(stage: Stage, positions: Array, targets: Array, held: Array, fps: float) -> Array:
    """How far the pelvis gives way so that the legs reach, metres, shape (frames,)."""
    need = _need(stage, positions, targets)
    return envelope((need * held).max(axis=1), max(1, round(SINK * fps)))


def _contact_list(stage: Stage, motion: Motion, standing: Mask) -> tuple[Contact, ...]:
    places = stage.soles.place(motion.positions(), motion.global_rotations())
    share = bearing(places[..., 1] - stage.levels)
    under = np.einsum("fkp,fkpi->fki", share, places)[..., [0, 2]]
    out = []
    for k in (0, 1):
        for a, b in runs(standing[:, k]):
            x, z = under[a:b, k].mean(axis=0).tolist()
            out.append(Contact(k, a, b, (x, z)))
    return tuple(sorted(out, key=lambda c: (c.start, c.foot)))


def _provenance(network: Network, laid: _Laid, weight: Array, transition: Mask) -> Provenance:
    repertoire = network.repertoire
    frame = repertoire.frame_of(laid.moments)
    return Provenance(
        moment=laid.moments,
        recording=repertoire.recording_of(frame),
        source_frame=repertoire.source_frames[frame],
        mirrored=repertoire.is_mirrored(laid.moments),
        backwards=repertoire.is_backward(laid.moments),
        step=laid.step,
        path=laid.path,
        transition=transition,
        weight=weight,
    )


# --- live


class LiveFrame(NamedTuple):
    """One frame, as it is performed."""

    rotations: Array
    """Of all joints relative to their parents, shape (joints, 4)."""
    root: Array
    """Place of the root, metres, shape (3,)."""


class LiveRenderer:
    """Performs paths frame by frame, as they are chosen: nothing is known of what comes.

    A transition takes its whole offset away after the cut (`kinesics.synthesis.blending.one_sided`); a foot stays where it
    came down, and comes back to its place in the recording while it swings. An iterator of `LiveFrame`; it ends when the
    paths do.

    Parameters
    ----------
    network : of the paths.
    paths : numbers of paths, each a successor of the one before; the next is asked for as the one before has ended.
    start, heading : see `render`.
    pinned : whether feet are kept in place.

    Raises
    ------
    InputError
        If ``start`` or ``heading`` is not finite; on the way, if a path does not follow the one before.
    """

    def __init__(
        self,
        network: Network,
        paths: Iterable[int],
        *,
        start: ArrayLike = (0.0, 0.0),
        heading: float = 0.0,
        pinned: bool = True,
    ) -> None:
        origin = np.asarray(start, dtype=np.float64)
        if origin.shape != (2,) or not np.isfinite(origin).all() or not np.isfinite(heading):
            raise InputError(f"Expected `start` as finite x, z and a finite `heading`, got {start!r} and {heading!r}.")
        self.network, self.pinned = network, pinned
        self.stage = Stage.of(network.repertoire)
        self._paths = iter(paths)
        self._feet = _LiveFeet(self.stage)
        joints = network.repertoire.skeleton.joint_count
        self.path = -1
        """Number of the path that is being performed, −1 before the first frame."""
        self.moment = -1
        """Moment of the repertoire that is being performed."""
        self.place = origin.copy()
        """Where the root goes next, x and z, metres: where the next path begins, once a path has ended."""
        self.heading = float(heading)
        """The same of the heading, radians."""
        self._left = 0
        self._onwards = 1
        self._turn = 0.0
        self._onward = -1
        self._offset = np.zeros((joints + 1, 3))
        self._velocity = np.zeros((joints + 1, 3))
        self._since = np.inf
        self._duration = 1.0

    def __iter__(self) -> LiveRenderer:
        """Itself."""
        return self

    def __next__(self) -> LiveFrame:
        """The next frame."""
        return self.step()

    def step(self) -> LiveFrame:
        """The next frame.

        Raises
        ------
        StopIteration
            If the paths have ended.
        """
        repertoire = self.network.repertoire
        if self._left == 0:
            self._begin(next(self._paths))
        else:
            self.moment += self._onwards
        self._left -= 1
        # within a path, and just behind it, the recording goes on: no need to ask how far it reaches
        strand, frame = divmod(self.moment, repertoire.frame_count)
        image, onward = strand % 2, frame + self._onwards
        rotations = repertoire.rotations[image, frame][None].copy()
        _turned(repertoire, self.stage.carrier, rotations, np.array([self._turn]))
        here, after = repertoire.root_positions[image, frame], repertoire.root_positions[image, onward]
        moved = after - here
        root = np.array([self.place[0], here[1], self.place[1]])
        cosine, sine = np.cos(self._turn), np.sin(self._turn)
        self.place += cosine * moved[0] + sine * moved[2], -sine * moved[0] + cosine * moved[2]
        yaw = float(repertoire.poses.yaw[onward])
        self.heading = (-yaw if image else yaw) + self._turn
        if self._since < self._duration:
            added = blending.decay(self._offset, self._velocity, np.full(1, self._since), self._duration)
            rotations[0] = self._inside(blending.add_rotation(rotations[0], added[:-1]))
            root += added[-1]
            self._since += 1.0 / repertoire.fps
        if self.pinned:
            return self._feet.step(rotations, root, self.moment)
        return LiveFrame(rotations[0], root)

    def _begin(self, path: int) -> None:
        network, repertoire = self.network, self.network.repertoire
        path = int(path)
        if not 0 <= path < len(network):
            raise InputError(f"Expected a path below {len(network)}, got {path}.")
        first = int(network.first[path])
        if self.path < 0:
            self._turn = self.heading - float(repertoire.yaw_of(first))
        else:
            if path not in network.successors(self.path):
                raise InputError(f"Path {path} does not follow path {self.path}.")
            left = int(network.onward[self.path])
            if first != left:
                self._cut(left, first)
        self.path, self.moment, self._left = path, first, int(network.length[path])
        self._onwards = -1 if bool(repertoire.is_backward(first)) else 1

    def _cut(self, left: int, first: int) -> None:
        repertoire, stage = self.network.repertoire, self.stage
        turn = self._turn + float(repertoire.yaw_of(left)) - float(repertoire.yaw_of(first))
        offsets, velocities = _seams(
            repertoire,
            stage.carrier,
            np.array([left]),
            np.array([self._turn]),
            np.array([first]),
            np.array([turn]),
        )
        # what is still left of the last transition goes along
        rest, speed = np.zeros_like(self._offset), np.zeros_like(self._velocity)
        if self._since < self._duration:
            dt = 0.5 / repertoire.fps
            at = np.array([max(self._since - dt, 0.0), self._since, self._since + dt])
            before, rest, after = blending.decay(self._offset, self._velocity, at[:, None], self._duration)
            speed = (after - before) / (at[2] - at[0])
        self._offset, self._velocity = rest - offsets[0], speed - velocities[0]
        which = stage.blended
        span = blending.window(
            np.linalg.norm(self._offset[which], axis=-1),
            np.linalg.norm(self._velocity[which], axis=-1),
            SPARED * stage.accelerations[which],
        )
        # one side alone has twice the offset to take away
        self._duration = min(np.sqrt(2.0) * span.after, blending.LONGEST)
        self._since = 0.0
        self._turn = turn

    def _inside(self, rotations: Array) -> Array:
        """Joints of the body within their range, shape (joints, 4)."""
        stage = self.stage
        vectors = blending.rotation_offset(stage.middle, rotations)
        beyond = np.any((vectors < stage.low) | (vectors > stage.high), axis=-1)
        beyond[: stage.carrier + 1] = False
        if beyond.any():
            held = np.clip(vectors[beyond], stage.low[beyond], stage.high[beyond])
            rotations[beyond] = blending.add_rotation(stage.middle[beyond], held)
        return rotations


class _LiveFeet:
    """Keeps feet in place knowing only the past, and what the recordings themselves would do next."""

    def __init__(self, stage: Stage) -> None:
        self.stage = stage
        repertoire = stage.repertoire
        fps = repertoire.fps
        self._held, self._near = _holds(repertoire, RELEASE * fps), _holds(repertoire, LIFT * fps)
        self._soles: Array | None = None
        self._height = np.zeros((2, 3))
        self._shift = np.zeros((2, 2))
        self._lift = np.zeros(2)
        self._hold = np.zeros(2)
        self._lean = np.zeros(2)
        self._drop = 0.0
        self._fps = fps
        legs = stage.legs
        self._joints = [*legs.femurs, *legs.tibias, *legs.feet]
        self._middle, self._low, self._high = (v[self._joints] for v in (stage.middle, stage.low, stage.high))

    def step(self, rotations: Array, root: Array, moment: int) -> LiveFrame:
        """Plant the feet of one frame: rotations of shape (1, joints, 4)."""
        stage, dt = self.stage, 1.0 / self._fps
        skeleton, legs = stage.repertoire.skeleton, stage.legs
        frame, strand = moment % stage.repertoire.frame_count, moment // stage.repertoire.frame_count
        known = kinematics.forward(skeleton, rotations, root[None])
        soles = stage.soles.place(known.positions, known.rotations)[0]
        height = soles[..., 1] - stage.levels
        lowest = soles[..., 1].min(axis=1)
        held, near = self._held[strand % 2, frame], self._near[strand % 2, frame]
        # at a cut a foot may be grasped or let go from one frame to the next: not so quickly
        self._hold += np.clip(held - self._hold, -dt / RELEASE, dt / _GRASP)
        if self._soles is None:
            self._hold = held.copy()
            self._lift = -near * lowest
        else:
            share = bearing(0.5 * (height + self._height))
            slid = np.einsum("kp,kpi->ki", share, (soles - self._soles)[..., [0, 2]])
            free = 1.0 - self._hold
            self._shift += -self._hold[:, None] * slid - (free * _eased(dt, RETURN))[:, None] * self._shift
        self._soles, self._height = soles, height
        self._lift += _eased(dt, SOFTLY) * (-near * lowest - self._lift)
        lift = np.maximum(self._lift, -lowest - SUNK)
        toward = (self._hold[:, None] * self._shift).sum(axis=0) / (self._hold.sum() + _FLIGHT)
        self._lean += _eased(dt, LIVE_LEAN) * (toward - self._lean)
        corrected = np.stack([self._shift[:, 0], lift, self._shift[:, 1]], axis=-1)
        targets = known.positions[:, list(legs.feet)] + corrected
        shift = np.array([self._lean[0], 0.0, self._lean[1]])
        need = float((_need(stage, known.positions + shift, targets) * self._hold).max())
        self._drop += _eased(dt, 0.25 * SINK if need > self._drop else SINK) * (need - self._drop)
        shift[1] = -self._drop
        known = known._replace(positions=known.positions + shift)
        done = inverse_kinematics.reach(skeleton, rotations, (root + shift)[None], targets, limbs=legs, known=known)
        return LiveFrame(*self._within(done.rotations, root + shift, targets))

    def _within(self, rotations: Array, root: Array, targets: Array) -> tuple[Array, Array]:
        """Legs within their range: the foot slides, and the body goes after it from the next frame on."""
        stage, joints = self.stage, self._joints
        vectors = blending.rotation_offset(self._middle, rotations[0, joints])
        held = np.clip(vectors, self._low, self._high)
        if np.array_equal(held, vectors):
            return rotations[0], root
        rotations[0, joints] = blending.add_rotation(self._middle, held)
        known = kinematics.forward(stage.repertoire.skeleton, rotations, root[None])
        off = (targets - known.positions[:, list(stage.legs.feet)])[0][:, [0, 2]]
        self._shift -= _SLIPPED * off
        self._lean += _FOLLOWED * (self._hold[:, None] * off).sum(axis=0) / (self._hold.sum() + _FLIGHT)
        sunk = -float(stage.soles.place(known.positions, known.rotations)[..., 1].min()) - SUNK
        return rotations[0], root + np.array([0.0, max(sunk, 0.0), 0.0])


_SLIPPED: Final = 0.3
"""Share of what a leg falls short of that its foot slides for good."""
_FOLLOWED: Final = 0.3
"""Share of it by which the body goes along in one frame."""
_GRASP: Final = 0.03
"""Seconds in which a foot that is on the ground after a cut is grasped."""
LIVE_LEAN: Final = 0.4
"""Seconds in which, live, the body follows its feet by two thirds: quicker it would lurch, for it cannot begin before."""
RETURN: Final = 0.12
"""Seconds in which, live, a swinging foot comes back to its place in the recording by two thirds."""


def _eased(dt: float, seconds: float) -> float:
    """Share of the way that is gone in ``dt`` by what goes two thirds in ``seconds``."""
    return float(-np.expm1(-dt / seconds))


def _holds(repertoire: Repertoire, reach: float) -> Array:
    """`_held` of every frame, of both feet, as recorded and mirrored: shape (2, frames, 2)."""
    out = np.zeros((2, repertoire.frame_count, 2))
    for a, b in itertools.pairwise(repertoire.starts.tolist()):
        for k in (0, 1):
            standing = repertoire.contacts[0, a:b, k]
            if standing.any():
                out[0, a:b, k] = _held(standing, reach)
    out[1] = out[0, :, ::-1]
    return out
