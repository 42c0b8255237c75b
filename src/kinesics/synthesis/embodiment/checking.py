"""Whether a performance stays where its recordings were (C_free, [Schultz2012] §2.9) and its feet where they are put.

What `synthesis.embodiment.rendering` sees to as it makes a movement is measured here on the movement it made: nothing is taken
from the maker but which moment each frame plays, where the nearest pose of the recordings is looked for first; soles, ranges and
depths that the recordings set are those that it goes by (`kinesics.synthesis.embodiment.stage`).
"""

from __future__ import annotations

import itertools
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinesics.body import contacts as _contacts
from kinesics.body import kinematics
from kinesics.body.contacts import runs
from kinesics.body.motion import Motion
from kinesics.body.pose import PoseSequence
from kinesics.body.pose import poses as _poses
from kinesics.geometry import quaternion
from kinesics.similarity import distance, mirror_distance, paired_distance
from kinesics.synthesis.embodiment.pivots import way_over
from kinesics.synthesis.embodiment.ranges import Ranges
from kinesics.synthesis.embodiment.rendering import Performance
from kinesics.synthesis.embodiment.stage import FLESH, Stage
from kinesics.synthesis.paths.network import Network
from kinesics.synthesis.repertoire import Repertoire

Array = NDArray[np.float64]

SLIDE: Final = 0.01
"""Metres that a foot may slide in one contact."""
SUNK: Final = 0.01
"""Metres that a sole may be below the floor."""
ROUNDING: Final = 1e-6
"""Radians that are no excess."""
LEAP: Final = 1.45
"""m/s: an ankle whose velocity changes by more leaps, unless the recording's does so there: at 120 frames a second what is thrown
aside for a frame is 6 mm off its way then, at 30 it is 2.4 cm."""
JERK: Final = np.deg2rad(5.0)
"""Radians, and half of the greatest in the recordings, by which a joint may turn more from one frame to the next than there."""
_WITHIN: Final = 1.0 / 120.0
"""Seconds to either side over which velocities are measured, or a frame where that is longer."""
BEYOND: Final = 2.5
"""Times what the recording does there: so much more is a leap."""
_ABOUT: Final = 0.05
"""Seconds to either side of a moment that count as there."""
_BLOCK: Final = 512


class Slid(NamedTuple):
    """A contact in which a foot slides more than it may."""

    foot: str
    """left or right."""
    start: int
    """Frames [start, end) of the performance."""
    end: int
    slide: float
    """Metres."""


class Leap(NamedTuple):
    """An ankle that is thrown off its way for a frame or two."""

    foot: str
    """left or right."""
    frame: int
    """Of the performance."""
    velocity: float
    """By which its velocity changes, m/s."""


class Jerk(NamedTuple):
    """A joint that turns more from one frame to the next than it ever does in the recordings."""

    joint: str
    frame: int
    """Of the performance: the later one."""
    turn: float
    """Radians."""


class Check(NamedTuple):
    """The worst of a performance, each beside what it may be."""

    contacts: int
    """Feet on the ground, found in the movement itself."""
    slides: int
    """Of them, those that slide more than `SLIDE`."""
    slide: float
    """Metres that a foot slides in one contact at worst."""
    below_floor: float
    """Metres that a sole is below the floor at worst."""
    beyond_range: float
    """Radians by which a joint is beyond its range in the recordings, mirrored counted, at worst."""
    deeper: float
    """Metres by which two parts of the body are deeper in each other than ever in the recordings, mirrored counted, at worst."""
    distance: float
    """D of a frame to the nearest of the recordings is nowhere more than that."""
    accepted: float
    """The largest D accepted at a transition."""
    slid: tuple[Slid, ...] = ()
    """The contacts that slide more than `SLIDE`, in the order in which they begin."""
    leaps: tuple[Leap, ...] = ()
    """Ankles that leap as the recording does not (`LEAP`, `BEYOND`), in order of time."""
    jerked: tuple[Jerk, ...] = ()
    """Joints that turn in one frame as they never do in the recordings, mirrored counted (`JERK`), in order of time."""

    @property
    def holds(self) -> bool:
        """Whether everything is as it may be."""
        return not self.slides and not self.leaps and not self.jerked and self.stays

    @property
    def stays(self) -> bool:
        """Whether, but for slides, leaps and joints that are jerked, everything is as it may be."""
        return (
            self.below_floor <= SUNK
            and self.beyond_range <= ROUNDING
            and self.deeper <= FLESH
            and self.distance <= self.accepted
        )

    @property
    def sentence(self) -> str:
        """All of it in one line."""
        slide = "slides" if self.slides == 1 else "slide"
        slid = (
            f"{self.slides} of {self.contacts} contacts {slide} more than {100 * SLIDE:g} cm, " if self.slides else ""
        )
        leapt = f"{_times(len(self.leaps))} an ankle leaps for a frame, " if self.leaps else ""
        jerked = f"{_times(len(self.jerked))} a joint turns in a frame as never recorded, " if self.jerked else ""
        beyond = 0.0 if self.beyond_range <= ROUNDING else np.rad2deg(self.beyond_range)
        return (
            f"{slid}{leapt}{jerked}feet slide {100 * self.slide:.1f} cm at most, {100 * self.below_floor:.1f} cm below the floor; "
            f"joints {beyond:.2g}° beyond their range, limbs {1000 * self.deeper:.1f} mm deeper in each other than recorded; "
            f"D to the recordings at most {self.distance:.2g} of {self.accepted:.2g}"
        )

    def to_dict(self) -> dict[str, Any]:
        """Plain values, for JSON."""
        return {
            "holds": self.holds,
            "contacts": self.contacts,
            "slides": self.slides,
            "slide_m": round(self.slide, 6),
            "below_floor_m": round(self.below_floor, 6),
            "beyond_range_rad": round(self.beyond_range, 6),
            "deeper_m": round(self.deeper, 6),
            "distance": round(self.distance, 6),
            "accepted": self.accepted,
            "slid": [{"foot": s.foot, "start": s.start, "end": s.end, "slide_m": round(s.slide, 6)} for s in self.slid],
            "leaps": [{"foot": p.foot, "frame": p.frame, "velocity_m_s": round(p.velocity, 3)} for p in self.leaps],
            "jerked": [{"joint": j.joint, "frame": j.frame, "turn_rad": round(j.turn, 4)} for j in self.jerked],
        }


def check(done: Performance, network: Network) -> Check:
    """Measure a performance of paths of this network."""
    motion, repertoire = done.motion, network.repertoire
    stage = Stage.of(repertoire)
    known = kinematics.forward(motion.skeleton, motion.rotations, motion.root_positions)
    places = stage.soles.place(known.positions, known.rotations)
    found = _contacts.touching(places, places[..., 1], motion.fps, stage.stature, stage.slow)
    feet = [
        Slid(side, a, b, slide(places[a:b, k], places[a:b, k, :, 1] - stage.levels[k], motion.fps))
        for k, side in enumerate(("left", "right"))
        for a, b in runs(found.feet[:, k])
    ]
    slid = sorted((foot for foot in feet if foot.slide > SLIDE), key=lambda foot: (foot.start, foot.foot))
    deep = stage.capsules.depths(*known) - stage.deepest
    return Check(
        len(feet),
        len(slid),
        max((foot.slide for foot in feet), default=0.0),
        float(max(0.0, -places[..., 1].min())),
        float(beyond(motion, stage).max(initial=0.0)),
        float(deep.max(initial=0.0)),
        _farthest(_poses(motion), repertoire, done, network.threshold),
        network.threshold,
        tuple(slid),
        _leaps(done, known.positions[:, list(stage.legs.feet)], stage),
        _jerked(motion, repertoire),
    )


def slide(points: Array, height: Array, fps: float) -> float:
    """How far the point that a sole stands on goes over the floor during one contact, metres: see `pivots.stood_on`.

    Parameters
    ----------
    points : of the sole, shape (frames, points, 3).
    height : above where each usually bears, shape (frames, points).
    """
    return farthest(way_over(points, height, fps)) if len(points) > 1 else 0.0


def farthest(places: Array) -> float:
    """Greatest distance between any two of some places, shape (n, 2)."""
    blocks = (places[a : a + _BLOCK, None] - places[None] for a in range(0, len(places), _BLOCK))
    return float(max(np.einsum("abi,abi->ab", apart, apart).max() for apart in blocks) ** 0.5)


def _leaps(done: Performance, ankles: Array, stage: Stage) -> tuple[Leap, ...]:
    """Ankles (frames, 2, 3) that leap as what they play does not; of those that follow at once, the greatest."""
    repertoire, fps, moments = stage.repertoire, done.motion.fps, done.provenance.moment
    w = max(1, round(_WITHIN * fps))
    pushed = _pushed(ankles, w, fps)
    reach = max(2, round(_ABOUT * fps))
    out: list[Leap] = []
    for k, foot in enumerate(("left", "right")):
        for at in np.flatnonzero(pushed[:, k] > LEAP).tolist():
            around = repertoire.advance(moments[at + w : at + w + 1], np.arange(-reach - w, reach + w + 1))
            around = around[around >= 0]
            known = kinematics.forward(
                repertoire.skeleton,
                repertoire.rotations_of(around),
                repertoire.roots_of(around),
                joints=np.array(stage.legs.feet[k : k + 1]),
            )
            way = known.positions[:, stage.legs.feet[k]]
            usual = _pushed(way, w, fps).max(initial=0.0)
            leap = Leap(foot, at + w, float(pushed[at, k]))
            if leap.velocity <= BEYOND * usual:
                continue
            if out and out[-1].foot == foot and leap.frame - out[-1].frame <= reach:
                out[-1] = max(out[-1], leap, key=lambda found: found.velocity)
            else:
                out.append(leap)
    return tuple(sorted(out, key=lambda found: (found.frame, found.foot)))


def _jerked(motion: Motion, repertoire: Repertoire) -> tuple[Jerk, ...]:
    turns = quaternion.angle(motion.rotations[1:], motion.rotations[:-1])
    # the root turns as the whole body does
    over = turns[:, 1:] > 1.5 * repertoire.kept(_quickest)[1:] + JERK
    found = [
        Jerk(motion.skeleton.joint_names[j + 1], t + 1, float(turns[t, j + 1])) for t, j in np.argwhere(over).tolist()
    ]
    return tuple(found)


def _quickest(repertoire: Repertoire) -> Array:
    """The most that each joint turns from one frame to the next, radians, shape (joints,)."""
    out = np.zeros(repertoire.skeleton.joint_count)
    for a, b in itertools.pairwise(repertoire.starts.tolist()):
        for rotations in repertoire.rotations[: 2 if repertoire.mirrored else 1, a:b]:
            np.maximum(out, quaternion.angle(rotations[1:], rotations[:-1]).max(axis=0, initial=0.0), out=out)
    return out


def _pushed(places: Array, w: int, fps: float) -> Array:
    """Changes of velocity over w frames to either side, m/s: shape (frames, ..., 3) to (frames − 2w, ...)."""
    bent = places[2 * w :] - 2.0 * places[w:-w] + places[: -2 * w]
    return np.asarray(np.linalg.norm(bent, axis=-1) * fps / w)


def _times(count: int) -> str:
    return {1: "once", 2: "twice"}.get(count, f"{count} times")


def beyond(motion: Motion, stage: Stage) -> Array:
    """Radians by which each joint but those the body hangs on is beyond its range, shape (frames, joints)."""
    return Ranges.of(stage).beyond(motion.rotations)


def nearest(own: PoseSequence, repertoire: Repertoire) -> Array:
    """D of every frame to the nearest of the recordings, mirrored counted, shape (frames,)."""
    out = np.empty(len(own))
    for a in range(0, len(own), _BLOCK):
        block = own[a : a + _BLOCK]
        best = distance(block, repertoire.poses).min(axis=1)
        if repertoire.mirrored:
            best = np.minimum(best, mirror_distance(block, repertoire.poses).min(axis=1))
        out[a : a + _BLOCK] = best
    return out


def _farthest(own: PoseSequence, repertoire: Repertoire, done: Performance, accepted: float) -> float:
    """What D to the nearest frame nowhere exceeds: to the moment played, and to all of them where that is more than accepted."""
    apart = paired_distance(own.quaternions, repertoire.quaternions_of(done.provenance.moment))
    for frame in np.flatnonzero(apart > accepted).tolist():
        apart[frame] = nearest(own[frame : frame + 1], repertoire)[0]
    return float(apart.max(initial=0.0))
