"""Feet that bear stay where they are, in a movement whose paths are laid end to end and blended ([Schultz2012] §4.4).

After Kovar, Schreiner & Gleicher 2002, *Footskate Cleanup for Motion Capture Editing*. Places of feet and body are sought for
all frames at once (`synthesis.embodiment.footing`), legs reach by inverse kinematics, joints stay within their range and legs out
of each other, and the body goes along as far as it can.
"""

from __future__ import annotations

import dataclasses
import functools
from collections import deque
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinesics.body import contacts, kinematics
from kinesics.body.capsules import Ends
from kinesics.body.kinematics import Kinematics
from kinesics.geometry import quaternion
from kinesics.synthesis.embodiment import blending, footing, inverse_kinematics
from kinesics.synthesis.embodiment.arms import SKIN, STEP, way_apart
from kinesics.synthesis.embodiment.footing import Bounds, Stiffness
from kinesics.synthesis.embodiment.pelvis import turned_for_the_hips
from kinesics.synthesis.embodiment.pivots import spreads, steps_of, way_of
from kinesics.synthesis.embodiment.ranges import YIELD, Ranges, both_ways, envelope, put_within_range, smooth
from kinesics.synthesis.embodiment.stage import (
    LIFT,
    RELEASE,
    SINK,
    SOFTLY,
    SUNK,
    Stage,
    held_around,
    shortfall,
    turn_bodies,
)

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Indices = NDArray[np.intp]

GRIP: Final = 0.04
"""Seconds in which a foot that comes down is held more and more firmly; in reverse as it is lifted."""
_FAINT: Final = 1e-3
"""How firmly it is held as it touches down or leaves: in recordings feet glide there by half a metre a second and more, and one
held wholly until it is let go would be thrown in a single frame. What is held a tenth as firmly is hardly held less, so that it
goes down by decades."""
ROUNDS: Final = 6
"""Most times that feet are planted, joints put back that were bent too far, and planted again as far as these go."""
_LEGS: Final = {"left", "right", "femur", "tibia"}
STAND: Final = 0.25
"""Seconds: who stands on both feet for four times as long is where the feet are, wherever the paths were laid."""
BACK: Final = 2.0
"""Seconds of walking on in which it turns back by two thirds of what it turned along with them."""
_LEAST_TURN: Final = np.deg2rad(1.0)
URGED: Final = 0.05
"""Metres by which more is asked of the body at most than a foot lacked: smoothness gives back as much."""
OVER: Final = 2.0
"""By so much more than it still lacks: in as many rounds again as it has got, it would go half of the way."""
LET_PASS: Final = 0.008
"""Metres that a foot may slide in one contact before it is held for longer."""
_SHORT: Final = 0.0003
"""Metres by which a foot is off where it was planted before the body goes along."""
_OVER: Final = 0.001
"""Radians beyond the range of hip or knee from which on the body goes along."""
_DAMPED: Final = 0.05
"""(rad/m)²: added to the squares of how joints turn, for ways along which none does."""
_FARTHEST: Final = 0.03
"""Metres that a foot is moved beneath the body in one round to bring a joint back: farther, joints do not turn in proportion."""
LONG: Final = 2.0
"""Seconds of a contact from which on a foot is held the more firmly the longer it lasts."""
_CLOSE: Final = 0.001
"""Metres beyond `LET_PASS` for which no other round is gone."""
_HARDLY: Final = 0.0003
"""The same of metres that legs are to move apart."""
_PATIENCE: Final = 2
"""Rounds that may pass without anything getting better."""
_TURNS: Final = (6, 3)
"""Most times that the pelvis is turned in the first round, and in each after that, which begins as the one before ended."""
_LATELY: Final = 3
"""Ways of a foot that are remembered: as it was given, as it was planted, and with its joints put back."""
_NEAR: Final = 0.2
"""Seconds around a contact that slides in which the body is to go along."""
_NOTHING: Final = np.deg2rad(0.2)


class Footed(NamedTuple):
    """A movement whose feet were planted."""

    rotations: Array
    """Shape (frames, joints, 4)."""
    roots: Array
    """Metres, shape (frames, 3)."""


def pin(
    stage: Stage,
    rotations: Array,
    roots: Array,
    standing: Mask,
    *,
    adrift: float = footing.ADRIFT,
    urged: float = URGED,
    rounds: int = ROUNDS,
    turning: bool = True,
) -> Footed:
    """Plant the feet that bear.

    Parameters
    ----------
    rotations, roots, standing : shapes (frames, joints, 4), (frames, 3) and (frames, 2).
    adrift : as of `kinesics.synthesis.embodiment.footing.footing`.
    urged : metres by which more may be asked of the body than a foot lacked, as one round after the other it goes not as far.
    rounds : of planting and putting joints back, at most.
    turning : whether the body turns along with its feet while it stands on both (`with_the_feet`).
    """
    skeleton = stage.repertoire.skeleton
    held = _held(stage, standing)
    feet = list(stage.legs.feet)
    parents = [skeleton.parents[j] for j in feet]
    joints = np.array([*stage.legs.femurs, *stage.legs.tibias, *feet])
    if turning:
        rotations, roots, _ = with_the_feet(stage, rotations, roots, standing)
    given = rotations
    known = _lower(stage, rotations, roots)
    # feet alone are turned before they are planted: what they hang on stays
    shins, soles = known.rotations[:, parents], known.rotations[:, feet]
    hips, knees, ankles = (known.positions[:, list(part)] for part in (stage.legs.femurs, stage.legs.tibias, feet))
    recorded = ankles - roots[:, None]
    stiff = footing.stiffness(footing.legs_of(hips, knees, ankles), stage.usual, stage.repertoire.fps)
    bounds = way, least = Bounds.none(len(rotations))
    more = np.zeros_like(least)
    gripped = standing
    turned = None
    best, least_slid, found_in = None, np.inf, 0
    stood = _Stood(stage)
    begun: tuple[Array | Mask, ...] = ()
    for attempt in range(rounds):
        if attempt:
            # a round that begins as the one before, but for the first, ends as that did, and so do all that follow
            assert turned is not None
            begins = given[:, feet], gripped, way.copy(), least.copy(), more, turned.wanted
            if attempt > 1 and all(map(np.array_equal, begins, begun)):
                break
            begun = begins
        done = _planted(stage, given, roots, standing, gripped, held, stiff, bounds, adrift, stood)
        turned = turned_for_the_hips(stage, done.rotations, done.roots, turned, _TURNS[min(attempt, 1)])
        done = done._replace(rotations=turned.rotations)
        within = done.rotations.copy()
        put_within_range(stage, within, joints)
        put_back = _lower(stage, within, done.roots)
        push = _apart(stage, put_back)
        pushed = float(np.linalg.norm(push, axis=-1).max())
        slides = _sliding(stage, put_back, stood)
        slid = sum(slide.more for slide in slides) + pushed
        if slid < least_slid:
            best, least_slid, found_in = (done._replace(rotations=within), put_back), slid, attempt
        good = pushed <= _HARDLY and all(slide.more <= _CLOSE for slide in slides)
        if good or attempt == rounds - 1 or attempt - found_in == _PATIENCE:
            break
        planted = _lower(stage, done.rotations, done.roots)
        gripped = gripped | _frames_of(_sliding(stage, planted, stood), len(roots), 0)
        # an ankle that would be bent too far turns its foot, by no more than this leg asks for; it is then planted as it is turned
        above = planted.rotations[:, parents]
        bent = done.rotations.copy()
        bent[:, feet] = level = quaternion.multiply(quaternion.conjugate(above), soles)
        put_within_range(stage, bent, np.array(feet))
        goes = quaternion.angle(level, bent[:, feet]) > _NOTHING
        as_given = quaternion.multiply(quaternion.conjugate(shins), quaternion.multiply(above, bent[:, feet]))
        given = rotations.copy()
        given[:, feet] = np.where(goes[..., None], as_given, given[:, feet])
        # where that and the pelvis do not mend it the body goes along; what it fell short by adds up from round to round
        if attempt == 0:
            continue
        near = _frames_of(slides, len(roots), max(1, round(_NEAR * stage.repertoire.fps)))
        back = np.where(near[..., None], _inward(stage, done), 0.0) + push
        far = np.linalg.norm(back, axis=-1)
        bound = far > _SHORT
        towards = back / np.maximum(far, 1e-9)[..., None]
        along = np.maximum(np.einsum("fki,fki->fk", way, towards), 0.0)
        more = np.where(bound, np.minimum(along * more + OVER * far, urged), more)
        way[bound] = towards[bound]
        limit = planted.positions[:, feet] - done.roots[:, None] - recorded + back
        least[bound] = np.einsum("ni,ni->n", way[bound], limit[bound]) + more[bound]
    # whoever goes not quite as the recordings do yet begins where it was told to
    assert best is not None
    done, put_back = best
    beside = (done.roots[0] - roots[0]) * [1.0, 0.0, 1.0]
    done = done._replace(roots=done.roots - beside)
    return done._replace(roots=above_the_floor(stage, done.roots, put_back))


def _lower(stage: Stage, rotations: Array, roots: Array) -> Kinematics:
    """Where legs and soles are."""
    return kinematics.forward(stage.repertoire.skeleton, rotations, roots, joints=stage.lower)


def _inward(stage: Stage, done: Footed) -> Array:
    """By how much beneath the body each foot is to move so that hip and knee come back into their range: (frames, 2, 3).

    The least way, by how these joints turn as the leg reaches elsewhere: near full extension a hip that is flexed too far asks for
    millimetres along the leg rather than for centimetres across it.
    """
    legs, skeleton = stage.legs, stage.repertoire.skeleton
    joints = np.stack([legs.femurs, legs.tibias], axis=1)
    middle = stage.middle[joints]
    now = blending.rotation_offset(middle, done.rotations[:, joints])
    over = Ranges.of(stage).over(joints, now)
    out = np.zeros((len(now), 2, 3))
    some = np.flatnonzero(np.abs(over).max(axis=(1, 2, 3)) > _OVER)
    if not len(some):
        return out
    rotations, roots = done.rotations[some], done.roots[some]
    known = _lower(stage, rotations, roots)
    ankles = known.positions[:, list(legs.feet)]
    change = np.empty((len(some), 2, 6, 3))
    for axis in range(3):
        targets = ankles + STEP * np.eye(3)[axis]
        moved = inverse_kinematics.reach(skeleton, rotations, roots, targets, limbs=legs, known=known).rotations
        change[..., axis] = (blending.rotation_offset(middle, moved[:, joints]) - now[some]).reshape(-1, 2, 6) / STEP
    beyond = over[some].reshape(-1, 2, 6)
    change *= (np.abs(beyond) > _OVER)[..., None]
    square = change @ np.swapaxes(change, -1, -2) + _DAMPED * np.eye(6)
    back = -np.einsum("fkci,fkc->fki", change, np.linalg.solve(square, beyond[..., None])[..., 0])
    far = np.linalg.norm(back, axis=-1, keepdims=True)
    out[some] = back * np.minimum(1.0, _FARTHEST / np.maximum(far, 1e-9))
    return out


def _lowest(soles: Array) -> Array:
    """Height of the lowest point of each sole, shape (frames, 2, points, 3) to (frames, 2)."""
    # over as short an axis NumPy reduces ten times more slowly
    return functools.reduce(np.minimum, np.moveaxis(soles[..., 1], -1, 0))


class _Slide(NamedTuple):
    """A contact in which a foot slides by more than is let pass."""

    foot: int
    start: int
    stop: int
    more: float
    """Metres."""


class _Stood:
    """How far the points go that feet stand on, as `pivots.steps_of`; of a foot that goes as it lately did, what it did then."""

    def __init__(self, stage: Stage) -> None:
        self._stage = stage
        self._known: list[deque[tuple[Array, Array]]] = [deque(maxlen=_LATELY) for _ in stage.legs.feet]

    def steps(self, places: Array) -> list[Array]:
        """Of soles (frames, 2, 3, 3), in metres over the floor from each frame to the next, shape (frames − 1, 2) each."""
        # both feet whole, for the sake of speed: between contacts a change of the point costs nothing
        return [self._steps(k, places[:, k]) for k in range(len(self._known))]

    def _steps(self, foot: int, points: Array) -> Array:
        known = self._known[foot]
        found = next((steps for before, steps in known if np.array_equal(before, points)), None)
        if found is None:
            height = points[..., 1] - self._stage.levels[foot]
            found = steps_of(points, height, self._stage.repertoire.fps)
            known.append((points, found))
        return found


def _sliding(stage: Stage, known: Kinematics, stood: _Stood) -> list[_Slide]:
    """Contacts, as anyone would find them, in which a foot slides."""
    places = stage.soles.place(known.positions, known.rotations)
    found = contacts.touching(places, places[..., 1], stage.repertoire.fps, stage.stature, stage.slow)
    spans = [contacts.runs(found.feet[:, k]) for k in (0, 1)]
    far = [spreads(way_of(steps), runs) - LET_PASS for steps, runs in zip(stood.steps(places), spans, strict=True)]
    return [_Slide(k, *spans[k][n], float(far[k][n])) for k in (0, 1) for n in np.flatnonzero(far[k] > 0.0).tolist()]


def _frames_of(slides: list[_Slide], frames: int, around: int) -> Mask:
    """Frames of these and around them, shape (frames, 2)."""
    out = np.zeros((frames, 2), dtype=np.bool_)
    for slide in slides:
        out[max(0, slide.start - around) : slide.stop + around, slide.foot] = True
    return out


def _apart(stage: Stage, known: Kinematics) -> Array:
    """By how much over the floor each foot is to move so that no leg is deeper in the other than ever: (frames, 2, 3)."""
    legs = [
        n
        for n, (a, b) in enumerate(stage.capsules.pairs)
        if {part for m in (a, b) for part in stage.capsules.names[m].split()} <= _LEGS
    ]
    capsules = dataclasses.replace(stage.capsules, pairs=tuple(stage.capsules.pairs[n] for n in legs))
    deepest = stage.deepest[legs]
    over = capsules.depths(*known) - deepest - SKIN
    out = np.zeros((len(over), 2, 3))
    if not (over > 0.0).any():
        return out
    starts, ends = capsules.ends(*known)
    for n, (a, b) in enumerate(capsules.pairs):
        deep = np.flatnonzero(over[:, n] > 0.0)
        sides = (0, 1) if capsules.names[a].startswith("left") else (1, 0)
        # the way apart is that in which the distance grows
        ways = way_apart(Ends(starts[deep], ends[deep]), a, b, (0, 2))
        ways *= (over[deep, n] / np.maximum(np.linalg.norm(ways, axis=-1), 1e-9))[:, None]
        for foot, sign in zip(sides, (1.0, -1.0), strict=True):
            stronger = np.linalg.norm(ways, axis=-1) > np.linalg.norm(out[deep, foot], axis=-1)
            out[deep, foot] = np.where(stronger[:, None], sign * ways, out[deep, foot])
    reach = max(1, round(YIELD * stage.repertoire.fps))
    for foot in (0, 1):
        out[:, foot] = both_ways(out[:, foot], reach)
    return out


def above_the_floor(stage: Stage, roots: Array, known: Kinematics) -> Array:
    """Where feet came below the floor as joints went back, the body is raised: its places, shape (frames, 3).

    Parameters
    ----------
    known : where legs and soles are with the body at ``roots``.
    """
    sunk = -_lowest(stage.soles.place(known.positions, known.rotations)).min(axis=1) - SUNK
    if sunk.max() <= 0.0:
        return roots
    raised = roots.copy()
    raised[:, 1] += envelope(np.maximum(sunk, 0.0), max(1, round(SOFTLY * stage.repertoire.fps)))
    return raised


def _planted(
    stage: Stage,
    rotations: Array,
    roots: Array,
    standing: Mask,
    gripped: Mask,
    held: Array,
    stiff: Stiffness,
    bounds: Bounds,
    adrift: float,
    stood: _Stood,
) -> Footed:
    repertoire, legs = stage.repertoire, stage.legs
    skeleton, fps = repertoire.skeleton, repertoire.fps
    known = _lower(stage, rotations, roots)
    soles = stage.soles.place(known.positions, known.rotations)
    ankles = known.positions[:, list(legs.feet)]
    lowest = _lowest(soles)
    slid = np.stack(stood.steps(soles), axis=1)
    grip = np.stack([_grip(gripped[:, k], fps) * _firmly(gripped[:, k], fps) for k in (0, 1)], axis=-1)
    press = np.stack([held_around(standing[:, k], LIFT * fps) for k in (0, 1)], axis=-1)
    gripping = np.minimum(grip[1:], grip[:-1])
    found = footing.footing(slid, gripping, lowest, press, stiff, fps, bounds, _both(held, fps), adrift)
    corrected, shift = found.feet, found.body
    reach = max(1, round(SOFTLY * fps))
    for k in (0, 1):
        corrected[:, k, 1] += envelope(np.maximum(-(lowest[:, k] + corrected[:, k, 1]) - SUNK, 0.0), reach)
    targets = ankles + corrected
    shift[:, 1] -= _lowering(stage, known.positions + shift[:, None], targets, held, fps)
    known = known._replace(positions=known.positions + shift[:, None])
    done = inverse_kinematics.reach(skeleton, rotations, roots + shift, targets, limbs=legs, known=known)
    return Footed(done.rotations, roots + shift)


class Followed(NamedTuple):
    """What `with_the_feet` gives."""

    rotations: Array
    """Shape (frames, joints, 4)."""
    roots: Array
    """Metres, shape (frames, 3)."""
    turn: Array
    """By which the body is turned to the left, radians, shape (frames,)."""


def with_the_feet(stage: Stage, rotations: Array, roots: Array, standing: Mask) -> Followed:
    """The body turned along with its feet while it stands on both, and gently back as it goes on.

    In a recording feet that stand creep; where a stand is played round after round, each goes on from the last, and what adds up
    no leg could follow. Where the body goes over the floor `footing` sees to.

    Parameters
    ----------
    rotations, roots, standing : shapes (frames, joints, 4), (frames, 3) and (frames, 2).
    """
    both = _both(_held(stage, standing), stage.repertoire.fps)
    known = _lower(stage, rotations, roots)
    soles = stage.soles.place(known.positions, known.rotations).mean(axis=2)
    feet = soles[..., 2] + 1j * soles[..., 0]
    apart = feet[:, 0] - feet[:, 1]
    crept = np.angle(apart[1:] * apart[:-1].conj()) * both[1:]
    back = 1.0 - (1.0 - both[1:]) / (BACK * stage.repertoire.fps)
    turn = np.zeros(len(roots))
    for t, (by, left) in enumerate(zip(crept.tolist(), back.tolist(), strict=True), start=1):
        turn[t] = (turn[t - 1] - by) * left
    if np.abs(turn).max() < _LEAST_TURN:
        return Followed(rotations, roots, np.zeros(len(roots)))
    turn = smooth(turn, max(1, round(STAND * stage.repertoire.fps)))
    turned, moved = rotations.copy(), roots.copy()
    turn_bodies(stage.repertoire, stage.carrier, turned, turn)
    middle = feet.mean(axis=1)
    place = middle + np.exp(1j * turn) * (roots[:, 2] + 1j * roots[:, 0] - middle)
    moved[:, 0], moved[:, 2] = place.imag, place.real
    return Followed(turned, moved, turn)


def _held(stage: Stage, standing: Mask) -> Array:
    """1 while a foot bears, and a little around it, shape (frames, 2)."""
    return np.stack([held_around(standing[:, k], RELEASE * stage.repertoire.fps) for k in (0, 1)], axis=-1)


def _both(held: Array, fps: float) -> Array:
    """1 where both feet have borne and will bear for three times `STAND`, going to 0 smoothly, shape (frames,)."""
    from scipy.ndimage import minimum_filter1d

    reach = max(1, round(STAND * fps))
    return smooth(minimum_filter1d(held.min(axis=1), 4 * reach + 1, mode="nearest"), reach)


def _grip(standing: Mask, fps: float) -> Array:
    """How firmly a foot is held, 0 to 1: wholly while it bears, less and less where it rolls on and off, shape (frames,)."""
    from scipy.ndimage import distance_transform_edt

    if standing.all() or not standing.any():
        return standing.astype(np.float64)
    inside = np.asarray(distance_transform_edt(standing))
    return np.where(standing, _FAINT ** (1.0 - blending.ease(inside / fps / GRIP)), 0.0)


def _firmly(standing: Mask, fps: float) -> Array:
    """By how much more a foot is held in long contacts, over which the little that it gives way each moment adds up: (frames,)."""
    out = np.ones(len(standing))
    for a, b in contacts.runs(standing):
        out[a:b] = np.sqrt(max(1.0, (b - a) / fps / LONG))
    return out


def _lowering(stage: Stage, positions: Array, targets: Array, held: Array, fps: float) -> Array:
    """How far the pelvis gives way so that the legs reach, metres, shape (frames,)."""
    need = shortfall(stage, positions, targets)
    return envelope((need * held).max(axis=1), max(1, round(SINK * fps)))
