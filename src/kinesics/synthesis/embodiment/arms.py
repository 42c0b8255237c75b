"""Arms that are moved clear of the body, and round each other, as they are in the recordings ([Schultz2012] §2.9: Cfree).

Between two poses in which limbs touch another lies in which they are in each other: the right wrist was in front, and in the
mirror image the left one is. Pushed apart, what is left behind goes one way and what comes the other, and between the two they
pass through each other all the same. Such arms go round each other: turned about the shoulders in one way for as long.
"""

from __future__ import annotations

import itertools
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinesics.body import kinematics
from kinesics.body.capsules import Ends, segment_distance
from kinesics.body.contacts import runs
from kinesics.body.kinematics import Kinematics
from kinesics.geometry import quaternion
from kinesics.synthesis.embodiment import blending
from kinesics.synthesis.embodiment.ranges import YIELD, Ranges, both_ways, envelope, put_joint
from kinesics.synthesis.embodiment.stage import FLESH, Stage

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

_SIDES: Final = ("left", "right")
_ARMS: Final = ("left humerus", "left radius", "right humerus", "right radius")
ASIDE: Final = 5
"""Most times that an arm is moved aside."""
SKIN: Final = FLESH / 3.0
"""Metres deeper than in the recordings from which on limbs are moved apart."""
STEP: Final = 0.001
"""Metres, or radians, that limbs are moved to see what comes of it."""
_LEAST: Final = 1e-2
"""Sum of squares of metres that an arm comes out for each radian that shoulders turn: where that hardly helps they turn no more."""
GO_ROUND: Final = 0.1
"""Seconds before and after over which arms go round each other."""
_AMOUNTS: Final = np.deg2rad(np.arange(1.0, 16.0, 1.0))
"""Radians that shoulders are turned by so that arms go round each other."""
_WAYS: Final = np.array([w for w in itertools.product((-1.0, 0.0, 1.0), repeat=3) if any(w)])
"""Axes about which they are: across, up and ahead."""
_LOOKED_AT: Final = 18
"""Most moments of a stretch at which ways round are tried."""
_TOGETHER: Final = 128
"""Ways that are tried together; those that turn less are tried before."""


def put_arms_clear(stage: Stage, rotations: Array, roots: Array) -> None:
    """Move arms aside that would be deeper in another part of the body than they ever are in the recordings; in place.

    Shoulders turn by the least that brings the arm out, over a stretch of time and within their range. Where that leads nowhere,
    or arms pass through something from one side to the other, they go round it.
    """
    shoulders, arms = shoulders_of(stage), pairs_of_arms(stage)
    _go_round(stage, rotations, roots, arms, crossing=True)
    if _push_aside(stage, rotations, roots, shoulders, arms):
        _go_round(stage, rotations, roots, arms, crossing=False)
        _push_aside(stage, rotations, roots, shoulders, arms)


def _push_aside(stage: Stage, rotations: Array, roots: Array, shoulders: Indices, arms: NDArray[np.bool_]) -> bool:
    """By the least turn of the shoulders, in place; returns whether some are too deep all the same."""
    skeleton, capsules = stage.repertoire.skeleton, stage.capsules
    reach = max(1, round(YIELD * stage.repertoire.fps))
    ranges = Ranges.of(stage)
    middle, low, high = stage.middle[shoulders], stage.low[shoulders], stage.high[shoulders]
    some = np.arange(len(rotations))
    for _ in range(ASIDE):
        known = kinematics.forward(skeleton, rotations[some], roots[some])
        over = np.where(arms.any(axis=0), capsules.depths(*known) - stage.deepest, -np.inf)
        deep = over.max(axis=1, initial=-np.inf) > SKIN
        if not deep.any():
            return False
        near, worst = some[deep], over[deep].argmax(axis=1)
        over = over[deep, worst]
        at = blending.rotation_offset(middle, rotations[np.ix_(near, shoulders)])
        change = np.zeros((len(near), 2, 3))
        for side in (0, 1):
            for axis in range(3):
                moved = rotations[near]
                bent = at[:, side] + STEP * np.eye(3)[axis]
                moved[:, shoulders[side]] = blending.add_rotation(middle[side], bent)
                found = capsules.depths(*kinematics.forward(skeleton, moved, roots[near]))[np.arange(len(near)), worst]
                change[:, side, axis] = np.where(np.isfinite(found), found - over - stage.deepest[worst], 0.0) / STEP
        back = np.zeros((len(rotations), 2, 3))
        back[near] = least_turn(change, over, arms[:, worst].T, Span(at, low, high))
        for side in (0, 1):
            turn = both_ways(back[:, side], reach)
            goes = np.flatnonzero(turn.any(axis=1))
            now = blending.rotation_offset(middle[side], rotations[goes, shoulders[side]]) + turn[goes]
            put_joint(
                rotations,
                goes,
                shoulders[side],
                blending.add_rotation(middle[side], ranges.within(int(shoulders[side]), now)),
            )
        some = np.flatnonzero(back.any(axis=(1, 2)))
        some = np.unique(np.clip(some[:, None] + np.arange(-2 * reach, 2 * reach + 1), 0, len(rotations) - 1))
    known = kinematics.forward(skeleton, rotations, roots)
    return bool(((capsules.depths(*known) - stage.deepest > FLESH) & arms.any(axis=0)).any())


class Span(NamedTuple):
    """Where the shoulders are in their range, by components of their rotation vectors, radians: shape (..., 2, 3) each."""

    at: Array
    low: Array
    high: Array


def least_turn(change: Array, over: Array, moved: NDArray[np.bool_], span: Span) -> Array:
    """By how much shoulders turn to bring out what is too deep, radians, shape (..., 2, 3).

    Parameters
    ----------
    change : metres that it gets deeper for each radian, shape (..., 2, 3).
    over : metres that it is too deep, shape (...).
    moved : whether it hangs on this shoulder, shape (..., 2).
    """
    # no component that is at the end of its range helps
    room = np.where(change > 0.0, span.at - span.low, span.high - span.at)
    change = change * ((room > STEP) & moved[..., None])
    square = np.square(change).sum(axis=(-2, -1), keepdims=True)
    return np.asarray(-change * over[..., None, None] / np.maximum(square, _LEAST))


def way_apart(ends: Ends, a: int, b: int, axes: tuple[int, ...] = (0, 1, 2)) -> Array:
    """By how much the distance of two capsules grows as the first is moved along each axis, shape (frames, 3)."""
    first, second = (ends.starts[:, a], ends.ends[:, a]), (ends.starts[:, b], ends.ends[:, b])
    out = np.zeros((len(ends.starts), 3))
    for axis in axes:
        shift = STEP * np.eye(3)[axis]
        farther, nearer = (segment_distance(first[0] + s, first[1] + s, *second) for s in (shift, -shift))
        out[:, axis] = (farther - nearer) / (2.0 * STEP)
    return out


def shoulders_of(stage: Stage) -> Indices:
    """Joints that the arms hang on, left and right."""
    anatomy = stage.repertoire.skeleton.anatomy
    assert anatomy is not None
    return np.array([getattr(anatomy.roles, f"{side}_humerus") for side in _SIDES])


def _capsules_of_arms(stage: Stage) -> NDArray[np.bool_]:
    """Which capsules are the left arm's, and which the right one's, shape (2, capsules)."""
    return np.array([[n in _ARMS and n.startswith(side) for n in stage.capsules.names] for side in _SIDES])


def pairs_of_arms(stage: Stage) -> NDArray[np.bool_]:
    """Which pairs of capsules a part of the left arm is in, and which one of the right, shape (2, pairs)."""
    of_arms = _capsules_of_arms(stage)
    a, b = np.array(stage.capsules.pairs, dtype=np.intp).reshape(-1, 2).T
    return np.asarray(of_arms[:, a] | of_arms[:, b])


def _go_round(stage: Stage, rotations: Array, roots: Array, arms: NDArray[np.bool_], *, crossing: bool) -> None:
    """Where arms pass through something from one side to the other, or anywhere, they go round it; in place."""
    skeleton, capsules = stage.repertoire.skeleton, stage.capsules
    known = kinematics.forward(skeleton, rotations, roots)
    deeper = capsules.depths(*known) - stage.deepest
    deep = (deeper > FLESH) & arms.any(axis=0)
    if not deep.any():
        return
    ends = capsules.ends(*known)
    reach = max(1, round(GO_ROUND * stage.repertoire.fps))
    for n in np.flatnonzero(deep.any(axis=0)).tolist():
        found: list[Array] = []
        near = np.convolve(deep[:, n], np.ones(4 * reach + 1), "same") > 0.5
        for low, high in runs(near):
            some = np.flatnonzero(deep[low:high, n]) + low
            first, past = int(some[0]), int(some[-1]) + 1
            beside = slice(max(0, first - 1), past + 1)
            ways = way_apart(Ends(ends.starts[beside], ends.ends[beside]), *capsules.pairs[n])
            if crossing and (ways @ ways[0]).min() >= 0.0:
                continue
            share = np.zeros(len(roots))
            share[first:past] = 1.0
            share = envelope(share, reach)
            goes = np.flatnonzero(share)
            looked = goes[np.linspace(0, len(goes) - 1, _LOOKED_AT - 1).astype(np.intp)]
            looked = np.union1d(looked, first + deeper[first:past, n].argmax())
            turns = _Moment.at(stage, rotations[looked], roots[looked], share[looked]).way_round(n, arms[:, n], found)
            if not turns.any():
                continue
            found.append(turns)
            moment = _Moment.at(stage, rotations[goes], roots[goes], share[goes])
            for side, turn in enumerate(turns):
                if turn.any():
                    put_joint(rotations, goes, int(moment.shoulders[side]), moment.turned(side, turn[None])[0])


class _Moment(NamedTuple):
    """Bodies whose arms may be turned about the shoulders."""

    stage: Stage
    rotations: Array
    known: Kinematics
    ends: Ends
    shoulders: Indices
    of_arms: NDArray[np.bool_]
    basis: Array
    """Columns across (to the left), up and ahead, shape (frames, 3, 3)."""
    share: Array
    """Of a turn that is made at each moment, shape (frames,)."""

    @classmethod
    def at(cls, stage: Stage, rotations: Array, roots: Array, share: Array) -> _Moment:
        known = kinematics.forward(stage.repertoire.skeleton, rotations, roots)
        shoulders = shoulders_of(stage)
        left, right = np.moveaxis(known.positions[:, shoulders], 1, 0)
        across = left - right
        across /= np.maximum(np.linalg.norm(across, axis=-1, keepdims=True), 1e-9)
        ahead = np.cross(across, [0.0, 1.0, 0.0])
        ahead /= np.maximum(np.linalg.norm(ahead, axis=-1, keepdims=True), 1e-9)
        basis = np.stack([across, np.cross(ahead, across), ahead], axis=-1)
        return cls(
            stage, rotations, known, stage.capsules.ends(*known), shoulders, _capsules_of_arms(stage), basis, share
        )

    def turned(self, side: int, turns: Array) -> Array:
        """The shoulder's rotation, turned about the axes of the basis, within its range: (ways, 3) to (ways, frames, 4)."""
        joint = int(self.shoulders[side])
        above = self.known.rotations[:, self.stage.repertoire.skeleton.parents[joint]]
        vectors = self.share[:, None] * np.einsum("fij,wj->wfi", self.basis, turns)
        by = quaternion.from_rotvec(quaternion.rotate(quaternion.conjugate(above), vectors))
        middle = self.stage.middle[joint]
        asked = blending.rotation_offset(middle, quaternion.multiply(by, self.rotations[:, joint]))
        held = Ranges.of(self.stage).within(joint, asked.reshape(-1, 3)).reshape(asked.shape)
        return blending.add_rotation(middle, held)

    def over(self, turns: Array, pairs: list[int]) -> Array:
        """Metres by which any of these pairs is deeper than ever at any moment: turns (ways, 2, 3) to (ways,)."""
        capsules, count = self.stage.capsules, len(turns)
        a, b = np.array([capsules.pairs[n] for n in pairs]).T
        starts, ends = (np.repeat(p[None], count, axis=0) for p in self.ends)
        for side, joint in enumerate(self.shoulders.tolist()):
            above = self.known.rotations[:, self.stage.repertoire.skeleton.parents[joint]]
            now = quaternion.multiply(above, self.turned(side, turns[:, side]))
            by = quaternion.multiply(now, quaternion.conjugate(self.known.rotations[:, joint]))
            about = self.known.positions[:, joint]
            for n in np.intersect1d(np.flatnonzero(self.of_arms[side]), np.concatenate([a, b])).tolist():
                for p in (starts, ends):
                    p[:, :, n] = about + quaternion.rotate(by, p[:, :, n] - about)
        apart = segment_distance(starts[:, :, a], ends[:, :, a], starts[:, :, b], ends[:, :, b])
        over = capsules.radii[a] + capsules.radii[b] - apart - self.stage.deepest[pairs]
        return np.asarray(over.max(axis=(1, 2)))

    def way_round(self, pair: int, sides: NDArray[np.bool_], found: list[Array]) -> Array:
        """Least turns of both shoulders by which neither this pair nor any other of the arms' is too deep; else the best.

        None where none is too deep, as turns for another pair may have seen to. Those ``found`` for other moments of the movement
        are tried first, for much of it recurs.
        """
        one, none = _WAYS / np.linalg.norm(_WAYS, axis=1, keepdims=True), np.zeros((len(_WAYS), 3))
        # one arm alone; both as in a mirror; one this way and one that
        kinds = [np.stack(kind, axis=1) for kind in ((one, none), (none, one), (one, one * [1, -1, -1]), (one, -one))]
        able = (sides[0], sides[1], sides.all(), sides.all())
        ways = np.concatenate([kind for kind, may in zip(kinds, able, strict=True) if may])
        tried = (_AMOUNTS[:, None, None, None] * ways).reshape(-1, 2, 3)
        tried = tried[np.argsort(np.linalg.norm(tried, axis=(1, 2)), kind="stable")]
        every = [n for n, of in enumerate(self.stage.capsules.pairs) if self.of_arms[:, list(of)].any()]
        best, least = np.zeros((2, 3)), float(self.over(np.zeros((1, 2, 3)), every)[0])
        if least <= SKIN:
            return best
        for a in range(-_TOGETHER if found else 0, len(tried), _TOGETHER):
            some = tried[a : a + _TOGETHER] if a >= 0 else np.array(found)
            some = some[self.over(some, [pair]) < least]
            if not len(some):
                continue
            over = self.over(some, every)
            good = np.flatnonzero(over <= SKIN)
            if len(good):
                return np.asarray(some[good[0]])
            if over.min() < least:
                best, least = some[over.argmin()], float(over.min())
        return np.asarray(best)
