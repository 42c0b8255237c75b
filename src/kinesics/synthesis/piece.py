"""A new movement and how it came about: which frames of which recording, over which transitions, with which numbers."""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinesics.body.motion import Motion
from kinesics.synthesis.control.courses import Course
from kinesics.synthesis.embodiment.checking import Check
from kinesics.synthesis.embodiment.rendering import Performance, Provenance
from kinesics.synthesis.goals import RADIUS
from kinesics.synthesis.paths.network import Network
from kinesics.synthesis.paths.pruning import Pruned

ASIDE: Final = 1.0
"""Metres: who goes further than this from a route, in the median, did not follow it."""

IN_PLACE: Final = 1.0
"""Metres: a body that keeps within stays in place, however it sways there."""
SWAY: Final = 1.0
"""Seconds over which the way of the body is smoothed before its length is measured: a stride, about."""

Array = NDArray[np.float64]

SCHEMA_VERSION: Final = 1
"""Of `Piece.to_dict`."""


class SourceFacts(NamedTuple):
    """A recording that was performed from."""

    name: str
    """Of the file, without folders; of the motion where there is no file."""
    sha256: str | None
    """Of the file."""
    format: str | None
    frames: int
    fps: float


class Span(NamedTuple):
    """A stretch that plays one recording on and on."""

    start: int
    """Frames [start, end) of the performance."""
    end: int
    source: int
    """Number of the recording."""
    source_start: float
    """[source_start, source_end) of it, in its own frames, which hold as much of it as the performance does: parts of frames
    where it was resampled."""
    source_end: float
    mirrored: bool
    backwards: bool


class Crossing(NamedTuple):
    """A transition that was used."""

    frame: int
    """First frame of the performance after it."""
    from_source: int
    from_frame: float
    """Last frame that is played before, in that recording's own frames."""
    to_source: int
    to_frame: float
    """First frame that is played after."""
    distance: float
    """Mean D over the window."""
    mirrors: bool
    """Whether the body is mirrored after it that was not before, or the other way round."""


@dataclass(frozen=True, eq=False)
class Piece:
    """A new movement and how it came about. Made by `kinesics.performance`."""

    performance: Performance
    """Motion, feet and contacts, provenance of every frame."""
    course: Course
    """What was decided."""
    network: Network
    """What was to choose from."""
    sources: tuple[SourceFacts, ...]
    check: Check
    """Slides, floor, ranges, depths and D, measured on the movement as performed."""
    parameters: Mapping[str, Any]
    """Everything that, with the recordings, makes this very movement: plain values."""
    places: tuple[tuple[float, float], ...] = ()
    """To be reached one after the other: x, z in metres."""
    radius: float = RADIUS
    """How near to a place counts as there."""

    def with_warnings(self, lines: Sequence[str]) -> Piece:
        """The same with something else to be warned of, said first."""
        motion = self.motion.replace(warnings=(*lines, *self.motion.warnings))
        return dataclasses.replace(self, performance=dataclasses.replace(self.performance, motion=motion))

    @property
    def motion(self) -> Motion:
        """The new movement."""
        return self.performance.motion

    @property
    def provenance(self) -> Provenance:
        """Where every frame comes from."""
        return self.performance.provenance

    @property
    def paths(self) -> tuple[int, ...]:
        """Numbers of the paths in the network, in the order of performance."""
        return self.performance.paths

    @property
    def attained(self) -> bool:
        """Whether the goal was, places or a route by the movement as performed; False if there was none that could be."""
        if self.aside is not None and self.aside > ASIDE:
            return False
        return len(self.visits) == len(self.places) if self.places else self.course.attained

    @property
    def outcome(self) -> tuple[str, ...]:
        """What came of the goal, in words."""
        if not self.places:
            return self.course.outcome
        there = self.visits
        told = [
            f"reached ({x:.2f}, {z:.2f}) after {frame / self.motion.fps:.1f} s"
            for (x, z), frame in zip(self.places, there, strict=False)
        ]
        if len(there) < len(self.places):
            x, z = self.places[len(there)]
            since = self.trail[there[-1] if there else 0 :]
            told.append(
                f"did not reach ({x:.2f}, {z:.2f}): came within {float(np.hypot(*(since - [x, z]).T).min()):.2f} m"
            )
        return ("; ".join(told),)

    @cached_property
    def visits(self) -> list[int]:
        """Frames at which the places were reached, one after the other, as many as were."""
        return visits(self.trail, self.places, self.radius)

    @property
    def pruned(self) -> tuple[Pruned, ...]:
        """What of the recordings could not be used."""
        return self.network.pruned

    @property
    def trail(self) -> Array:
        """Root on the floor: x, z in metres, shape (frames, 2)."""
        return self.motion.root_positions[:, [0, 2]]

    @cached_property
    def length(self) -> float:
        """Metres that the body went over the floor, its swaying to and fro within a second (`SWAY`) left aside."""
        return way_of(self.trail, SWAY * self.motion.fps)

    @property
    def stays(self) -> float | None:
        """Metres from where it begins that the body keeps within, if it stays in place (`IN_PLACE`); None if it gets about."""
        return float(np.hypot(*(self.trail - self.trail[0]).T).max()) if self.in_place else None

    @property
    def in_place(self) -> bool:
        """Whether the body keeps within a square of `IN_PLACE`, and was not sent anywhere."""
        sent = bool(self.places) or self.parameters["route"] is not None
        return not sent and bool(np.ptp(self.trail, axis=0).max() < IN_PLACE)

    @property
    def mirrored_share(self) -> float:
        """Share of the frames that play a mirror image."""
        return float(self.provenance.mirrored.mean())

    @property
    def backwards_share(self) -> float:
        """Share of the frames that play a recording backwards."""
        return float(self.provenance.backwards.mean())

    @property
    def nearest(self) -> float | None:
        """Metres from the target at which the performer came nearest to it; None without a target."""
        target = self.parameters["target"]
        return None if target is None else float(np.hypot(*(self.trail - target).T).min())

    @property
    def aside(self) -> float | None:
        """Median of the metres between the performer and the route; None without a route."""
        route = self.parameters["route"]
        return None if route is None else aside_of(self.trail, np.asarray(route))

    @cached_property
    def spans(self) -> tuple[Span, ...]:
        """The stretches between transitions; they tile the performance."""
        where, fps = self.provenance, self.motion.fps
        bounds = [0, *self.performance.cuts.tolist(), self.motion.frame_count]
        out = []
        for a, b in itertools.pairwise(bounds):
            source = int(where.recording[a])
            facts = self.sources[source]
            first, last = sorted((float(where.source_frame[a]), float(where.source_frame[b - 1])))
            end = min(last + facts.fps / fps, float(facts.frames))
            out.append(Span(a, b, source, first, end, bool(where.mirrored[a]), bool(where.backwards[a])))
        return tuple(out)

    @cached_property
    def crossings(self) -> tuple[Crossing, ...]:
        """The transitions that were used."""
        where, net = self.provenance, self.network
        out = []
        for cut in self.performance.cuts.tolist():
            before, after = int(where.path[cut - 1]), int(where.path[cut])
            low = int(net.indptr[before])
            at = low + int(np.flatnonzero(net.successors(before) == after)[0])
            out.append(
                Crossing(
                    cut,
                    int(where.recording[cut - 1]),
                    float(where.source_frame[cut - 1]),
                    int(where.recording[cut]),
                    float(where.source_frame[cut]),
                    float(net.distance[at]),
                    bool(where.mirrored[cut] != where.mirrored[cut - 1]),
                )
            )
        return tuple(out)

    def extras(self) -> dict[str, NDArray[Any]]:
        """The provenance of every frame as arrays of shape (frames,), to be kept beside the motion."""
        where = self.provenance
        return {
            "provenance_source": where.recording.astype(np.int32),
            "provenance_source_frame": where.source_frame,
            "provenance_mirrored": where.mirrored,
            "provenance_backwards": where.backwards,
            "provenance_transition": where.transition,
            "provenance_weight": where.weight,
        }

    def to_dict(self) -> dict[str, Any]:
        """All of it in plain values, as ``*.provenance.json`` holds it (`kinesics.report.performances.performance_schema`)."""
        from kinesics import __version__

        motion, net = self.motion, self.network
        return {
            "schema_version": SCHEMA_VERSION,
            "kinesics_version": __version__,
            "parameters": dict(self.parameters),
            "sources": [
                {**facts._asdict(), "duration_s": _rounded(facts.frames / facts.fps)} for facts in self.sources
            ],
            "output": {
                "name": motion.name,
                "frames": motion.frame_count,
                "fps": motion.fps,
                "duration_s": _rounded(motion.duration),
                "skeleton": motion.skeleton.name,
                "joints": list(motion.skeleton.joint_names),
                "files": [],
                "assumptions": list(motion.assumptions),
                "warnings": list(motion.warnings),
            },
            "network": {
                "paths": len(net),
                "successors": len(net.indices),
                "seconds": _rounded(net.seconds),
                "threshold": net.threshold,
                "rule": net.rule,
                "pruned": [
                    {"source": p.recording, "strand": p.strand, "seconds": _rounded(p.seconds), "why": p.why}
                    for p in net.pruned
                ],
            },
            "goal": {
                "attained": self.attained,
                "outcome": list(self.outcome),
                "length_m": _rounded(self.length),
                "nearest_m": None if self.nearest is None else _rounded(self.nearest),
                "aside_m": None if self.aside is None else _rounded(self.aside),
            },
            "check": self.check.to_dict(),
            "mirrored_share": _rounded(self.mirrored_share),
            "backwards_share": _rounded(self.backwards_share),
            "spans": [
                {**s._asdict(), "source_start": _rounded(s.source_start), "source_end": _rounded(s.source_end)}
                for s in self.spans
            ],
            "transitions": [
                {
                    "frame": c.frame,
                    "time_s": _rounded(c.frame / motion.fps),
                    "from": {"source": c.from_source, "frame": _rounded(c.from_frame)},
                    "to": {"source": c.to_source, "frame": _rounded(c.to_frame)},
                    "distance": c.distance,
                    "mirrors": c.mirrors,
                }
                for c in self.crossings
            ],
        }


def visits(trail: Array, places: Sequence[tuple[float, float]], radius: float) -> list[int]:
    """Frames at which a trail of shape (frames, 2) first comes near to places one after the other, as many as it reaches."""
    out: list[int] = []
    for place in places:
        begun = out[-1] if out else 0
        near = np.flatnonzero(np.hypot(*(trail[begun:] - place).T) <= radius)
        if not len(near):
            break
        out.append(begun + int(near[0]))
    return out


def way_of(trail: Array, frames: float) -> float:
    """Metres of a trail of shape (frames, 2), smoothed by its mean over so many frames; a way straight on is as long as it is."""
    half = min(int(frames / 2.0), len(trail) - 1)
    if half < 1:
        return float(np.hypot(*np.diff(trail, axis=0).T).sum())
    # beyond its ends it goes on as it came
    before, after = 2.0 * trail[0] - trail[half:0:-1], 2.0 * trail[-1] - trail[-2 : -half - 2 : -1]
    total = np.cumsum(np.concatenate([np.zeros((1, 2)), before, trail, after]), axis=0)
    smooth = (total[2 * half + 1 :] - total[: -2 * half - 1]) / (2 * half + 1)
    return float(np.hypot(*np.diff(smooth, axis=0).T).sum())


def aside_of(trail: Array, corners: Array) -> float:
    """Median of the metres between a trail of shape (frames, 2) and a line with these corners."""
    return float(np.median(distance_to_line(trail, corners)))


def distance_to_line(points: Array, corners: Array) -> Array:
    """Metres from each point to the nearest place on a line of straight pieces: shape (n,)."""
    least = np.full(len(points), np.inf)
    for a, b in itertools.pairwise(corners):
        along = b - a
        square = float(along @ along)
        t = np.clip((points - a) @ along / square, 0.0, 1.0) if square > 0.0 else np.zeros(len(points))
        least = np.minimum(least, np.hypot(*(points - a - t[:, None] * along).T))
    return least


def _rounded(value: float) -> float:
    return round(float(value), 6)
