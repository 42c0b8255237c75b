"""A list of paths performed: one movement without seams, its feet on the ground ([Schultz2012] §4.4).

1. Paths are laid end to end, from recordings whose feet were planted (`synthesis.embodiment.rehearsal`): each is turned about
   the vertical and shifted over the floor so that its bearing feet stand where those stood with which the path before would
   have gone on (`kinesics.synthesis.paths.meeting`).
2. At every cut the offset of pose and place is taken away (`kinesics.synthesis.embodiment.blending`) over a short time, in which it
   accelerates neither a joint's turning nor its place more than the recordings do.
3. Feet that bear stay where they are (after Kovar, Schreiner & Gleicher 2002). Their data tell which part of the sole bears:
   the lower a point, the more (heel, then ball, then tip). What is added to the places of feet and body, so that bearing
   soles neither slide nor hover and nothing is accelerated more than need be, is sought for all frames at once
   (`kinesics.synthesis.embodiment.footing`). No sole is let below the floor.
4. Legs reach by inverse kinematics; feet keep their orientation. A joint that would go beyond its range is put back, a leg that
   would go deeper into the other than it ever does is moved aside, and the body goes along as far as it can (steps 3 and 4
   again); what is left a foot slides: range first.
5. A leg that planting took farther from its source than transitions are accepted at goes back towards it; an arm that would be
   deeper in another part of the body than it ever is, is moved aside. `synthesis.embodiment.checking` measures what came of it.

`kinesics.synthesis.live.renderer` does the same frame by frame, knowing only the past.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinesics.body import kinematics
from kinesics.body.contacts import Soles, runs
from kinesics.body.motion import Motion
from kinesics.body.pose import poses as _poses
from kinesics.errors import InputError
from kinesics.geometry import quaternion
from kinesics.similarity import paired_distance
from kinesics.synthesis.embodiment import blending
from kinesics.synthesis.embodiment.arms import put_arms_clear
from kinesics.synthesis.embodiment.planting import above_the_floor, pin
from kinesics.synthesis.embodiment.ranges import YIELD, Ranges, envelope, put_joint, put_within_range
from kinesics.synthesis.embodiment.rehearsal import drawn, played
from kinesics.synthesis.embodiment.stage import LEAST_TURNING, SPARED, Seams, Stage, bearing, seams, turn_bodies
from kinesics.synthesis.embodiment.steady_feet import unturned_feet
from kinesics.synthesis.embodiment.toes import toes_above_the_floor
from kinesics.synthesis.paths.meeting import meetings
from kinesics.synthesis.paths.network import Network
from kinesics.synthesis.repertoire import Repertoire

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Indices = NDArray[np.intp]

SHORTEST_GAP: Final = 0.13
"""Seconds: at a transition no foot is lifted for less."""
_NEAR: Final = 0.9
"""Share of the largest D accepted at a transition that a blend may lead away from what it plays: feet and ranges come after."""
_BACK: Final = 0.3
"""Share of the way back to the blend that a planted leg goes where it went too far."""
_PLANTED_FAR: Final = np.deg2rad(5.0)
"""By less planting takes no pose from its source: four links of fifteen turned by 5° are a D of .0005."""
_TRIES: Final = 6
"""Most times that blends are made quicker that lead farther."""
_QUICKER: Final = 0.75
"""By which their time is multiplied."""
SHORTEST_CONTACT: Final = 0.06
"""Seconds: at a transition no foot is set down for less."""


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
    """Whether the frame lies within a transition: for its sake the pose is not quite that of its source."""
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
    lowered: Array
    """Metres by which the pelvis was lowered to keep the feet on the ground, shape (frames,)."""


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
    laid = _lay(stage, network, chosen, origin, float(heading), extra, planted=pinned)
    blended = _blend(stage, laid, _NEAR * network.threshold)
    rotations, roots = blended.rotations, blended.roots
    if len(laid.cuts):
        # joints in their own time go over for longer than the window lasts
        touched = np.any(rotations != laid.rotations, axis=(1, 2))
        put_within_range(stage, rotations, np.arange(stage.carrier + 1, rotations.shape[1]), touched)
    changed = quaternion.angle(rotations, laid.rotations).max(axis=1) > 1e-7
    changed |= (blended.weight < 1.0) | np.any(roots != laid.roots, axis=1)
    standing = _standing(network.repertoire, laid)
    if pinned:
        rotations = unturned_feet(stage, rotations, _holding(standing, changed))
        footed = pin(stage, rotations, roots, standing)
        rotations, roots = footed.rotations, footed.roots
        if _not_too_far(stage, rotations, blended.rotations, laid.moments, network.threshold):
            known = kinematics.forward(network.repertoire.skeleton, rotations, roots, joints=stage.lower)
            roots = above_the_floor(stage, roots, known)
        rotations = toes_above_the_floor(stage, rotations, roots, drawn(stage))
    put_arms_clear(stage, rotations, roots)
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
        np.maximum(blended.roots[:, 1] - roots[:, 1], 0.0),
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
    seams: Seams
    """Of the cuts."""
    room: Array
    """Seconds before and after each cut to the beginning and the end: shape (cuts, 2)."""
    fps: float


def _lay(
    stage: Stage, network: Network, chosen: Indices, origin: Array, heading: float, extra: Array, *, planted: bool
) -> _Laid:
    repertoire, carrier = played(stage) if planted else stage.repertoire, stage.carrier
    fps = repertoire.fps
    lengths = network.length[chosen]
    ends = np.cumsum(lengths)
    begins = ends - lengths
    frames = int(ends[-1])
    step = np.repeat(np.arange(len(chosen)), lengths)
    within = np.arange(frames) - begins[step]
    moments = repertoire.advance(network.first[chosen][step], within)
    first, onward = network.first[chosen], network.onward[chosen]
    # the heading: the first moment of a path faces where the one before would have faced, but for how the two meet
    met_place, met_turn = _met(network, repertoire, chosen)
    face_first, face_onward = repertoire.yaw_of(first), repertoire.yaw_of(onward)
    turn = heading - face_first[0] + np.concatenate([[0.0], np.cumsum(face_onward[:-1] + met_turn - face_first[1:])])
    bent = np.concatenate([[0.0], np.cumsum(extra)])
    lean = bent[step] + extra[step] * within / lengths[step]
    yaw = turn[step] + lean
    # the place: steps of the recordings, each turned as its path is
    here, after = repertoire.roots_of(moments), repertoire.roots_of(repertoire.advance(moments, 1))
    moved = after - here
    half = yaw + 0.5 * extra[step] / lengths[step]
    x = np.cos(half) * moved[:, 0] + np.sin(half) * moved[:, 2]
    z = -np.sin(half) * moved[:, 0] + np.cos(half) * moved[:, 2]
    aside = met_place * np.exp(1j * (face_onward[:-1] + turn[:-1] + bent[1:-1]))
    x[begins[1:] - 1] += aside.imag
    z[begins[1:] - 1] += aside.real
    roots = here.copy()
    roots[:, 0] = origin[0] + np.concatenate([[0.0], np.cumsum(x)[:-1]])
    roots[:, 2] = origin[1] + np.concatenate([[0.0], np.cumsum(z)[:-1]])
    rotations = repertoire.rotations_of(moments)
    turn_bodies(repertoire, carrier, rotations, yaw)

    jumps = np.nonzero(first[1:] != onward[:-1])[0] + 1
    cuts = begins[jumps]
    world = turn + bent[:-1]
    crossed = seams(
        repertoire,
        carrier,
        onward[jumps - 1],
        world[jumps - 1] + extra[jumps - 1],
        first[jumps],
        world[jumps],
        np.stack([aside.imag, aside.real], axis=-1)[jumps - 1],
    )
    room = np.stack([cuts, frames - cuts], axis=-1) / fps
    return _Laid(moments, step, chosen[step], cuts, rotations, roots, crossed, room, fps)


def _met(network: Network, played: Repertoire, chosen: Indices) -> tuple[NDArray[np.complex128], Array]:
    """How each path meets the one before, with its feet where they are played; as `Network.met`, shape (paths − 1,) each."""
    edges = network.edges(chosen[:-1], chosen[1:])
    place, turn = network.met[0][edges], network.met[1][edges]
    jumps = np.flatnonzero(network.first[chosen[1:]] != network.onward[chosen[:-1]])
    known = played is network.repertoire or played is network.afoot
    if network.meeting is not None and not known and len(jumps):
        met = meetings(played, network.onward[chosen[jumps]], network.first[chosen[jumps + 1]])
        place[jumps], turn[jumps] = met.place[:, 1] + 1j * met.place[:, 0], met.turn
    return place, turn


# --- without seams


class _Blended(NamedTuple):
    rotations: Array
    roots: Array
    weight: Array


def _blend(stage: Stage, laid: _Laid, threshold: float) -> _Blended:
    """Without seams.

    A transition that takes a frame farther from the moment it plays than ``threshold`` is made again in less time, `_TRIES` times
    at most in all: of a body that leaps at a cut frames may stay farther.
    """
    room = laid.room.copy()
    for _ in range(_TRIES):
        blended, spans = _inertial(stage, laid, room)
        touched = np.nonzero(blended.weight < 1.0)[0]
        if not len(touched):
            break
        poses = _poses(Motion(stage.repertoire.skeleton, blended.rotations[touched], blended.roots[touched], laid.fps))
        apart = paired_distance(poses.quaternions, stage.repertoire.quaternions_of(laid.moments[touched]))
        far = touched[apart > threshold]
        times = (far - laid.cuts[:, None]) / laid.fps
        within = ((times > -spans[:, :1]) & (times < spans[:, 1:])).any(axis=1)
        if not within.any():
            break
        room[within] = _QUICKER * np.minimum(spans[within].max(axis=1, keepdims=True), room[within] / _QUICKER)
    return blended


def _inertial(stage: Stage, laid: _Laid, room: Array) -> tuple[_Blended, Array]:
    """The offset of every cut taken away; seconds before and after each over which it was, shape (cuts, 2)."""
    frames, fps, crossed = len(laid.moments), laid.fps, laid.seams
    rotations, roots = laid.rotations.copy(), laid.roots.copy()
    weight = np.ones(frames)
    spans = np.zeros((len(laid.cuts), 2))
    which = stage.blended
    # hands and head go farther than any joint tells: each joint that they hang on adds to it
    sizes, speeds = (
        np.concatenate([np.linalg.norm(turned[:, which], axis=-1), np.linalg.norm(moved, axis=-1)], axis=1)
        for turned, moved in ((crossed.offsets, crossed.places), (crossed.velocities, crossed.moving))
    )
    spared = SPARED * np.concatenate([stage.accelerations[which], stage.places])
    loose = np.ones(len(stage.accelerations), dtype=np.bool_)
    loose[which] = False
    slowly = np.maximum(SPARED * stage.accelerations, LEAST_TURNING)
    slowly[stage.lower] = np.inf
    ends = [*laid.cuts[1:].tolist(), frames]
    passing: blending.Passing | None = None
    for k, cut in enumerate(laid.cuts.tolist()):
        offset, velocity = crossed.offsets[k], crossed.velocities[k]
        if passing is not None:
            offset, velocity = blending.absorbed(offset, velocity, passing, (cut - laid.cuts[k - 1]) / fps)
            sizes[k, : len(which)] = np.linalg.norm(offset[which], axis=-1)
            speeds[k, : len(which)] = np.linalg.norm(velocity[which], axis=-1)
        span = blending.window(sizes[k], speeds[k], spared, before=room[k, 0], after=room[k, 1])
        spans[k] = span.before, span.after
        passing = blending.Passing(offset, blending.at_their_own_pace(offset, velocity, span, loose, slowly), span)
        slowest = max(1.0, float(passing.paced.pace.max()))
        a = max(0, cut - math.ceil(slowest * span.before * fps))
        b = min(ends[k], cut + math.ceil(slowest * span.after * fps) + 1)
        times = (np.arange(a, b) - cut) / fps
        added = passing.at(times)
        rotations[a:b] = blending.add_rotation(rotations[a:b], added[:, :-1])
        roots[a:b] += added[:, -1]
        own = np.where(times < 0.0, 1.0 - span.share_before * blending.ease(1.0 + times / max(span.before, 1e-9)), 0.0)
        own += np.where(
            times >= 0.0, 1.0 - (1.0 - span.share_before) * blending.ease(1.0 - times / max(span.after, 1e-9)), 0.0
        )
        weight[a:b] = np.minimum(weight[a:b], own)
    return _Blended(rotations, roots, weight), spans


def _not_too_far(stage: Stage, rotations: Array, blended: Array, moments: Indices, threshold: float) -> bool:
    """Where planting took a pose farther from its source than transitions are accepted at, it is taken back as far; in place.

    Returns whether any was. The blend itself is nearer (`_NEAR`).
    """
    repertoire = stage.repertoire
    joints = np.array([*stage.legs.femurs, *stage.legs.tibias])
    reach = max(1, round(YIELD * repertoire.fps))
    ranges = Ranges.of(stage)
    # what planting turns are four of fifteen links
    went = False
    for _ in range(_TRIES):
        some = np.flatnonzero(quaternion.angle(rotations[:, joints], blended[:, joints]).max(axis=1) > _PLANTED_FAR)
        if not len(some):
            break
        poses = _poses(Motion(repertoire.skeleton, rotations[some], np.zeros((len(some), 3)), repertoire.fps))
        apart = paired_distance(poses.quaternions, repertoire.quaternions_of(moments[some]))
        if not (apart > threshold).any():
            break
        went = True
        share = np.zeros(len(rotations))
        share[some[apart > threshold]] = _BACK
        share = envelope(share, reach)
        goes = np.flatnonzero(share)
        for j in (*joints.tolist(), *stage.legs.feet):
            at, towards = (blending.rotation_offset(stage.middle[j], q[goes, j]) for q in (rotations, blended))
            held = ranges.within(j, at + share[goes, None] * (towards - at))
            put_joint(rotations, goes, j, blending.add_rotation(stage.middle[j], held))
    return went


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


def _holding(standing: Mask, frames: Mask) -> Mask:
    """Of contacts, shape (frames, 2), those that hold any of some frames, shape (frames,)."""
    out = np.zeros_like(standing)
    for k in (0, 1):
        for a, b in runs(standing[:, k]):
            out[a:b, k] = frames[a:b].any()
    return out


def _runs_near(mask: Mask, cut: int, reach: int) -> list[tuple[int, int]]:
    """Runs of True within ``reach`` frames of a cut."""
    low, high = max(0, cut - 2 * reach - 2), min(len(mask), cut + 2 * reach + 2)
    return [(low + a, low + b) for a, b in runs(mask[low:high]) if low + a <= cut + reach and cut - reach <= low + b]


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
