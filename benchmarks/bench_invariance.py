"""What must not change what is read: a mirror, the frame rate, the heading, the body, the direction of time.

    python benchmarks/bench_invariance.py [--json FILE]

Each recording is read, changed, and read again. The class and the period (within 1 %) should be the same, and the motion graph
isomorphic, labels up to renaming: for the mirrored recording to the mirrored graph, for the reversed one to the graph with every
one-way arrow turned. Recordings are chosen by rule: every study of the performer (120 frames a second, 0.5° of noise); every
AMC file; every segment of `cmu/segments.tsv`, labelled or not; the first clip of every content and style of Bandai-Namco.
"""

from __future__ import annotations

import csv
import tempfile
import zipfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import kinesics as kx
from harness import Table, data_folder, main
from kinesics.body.mirroring import partners
from kinesics.geometry import quaternion
from kinesics.grammar.graph import MotionGraph
from kinesics.grammar.whole import read_grammar

NOISE_DEGREES = 0.5
PERIOD = 0.01
"""Relative difference of two periods that count as the same."""
TURN = 2.1
"""Radians about the vertical."""
LIMBS, TRUNK = 1.3, 1.1
"""How much longer the bones of the longer-limbed body are."""
EFFORT = 20_000
"""Of the search for the fewest changes between two graphs that should be one; beyond it the number is an upper bound."""


def turned(motion: kx.Motion) -> kx.Motion:
    """About the vertical, and standing elsewhere."""
    turn = quaternion.from_rotvec(np.array([0.0, TURN, 0.0]))
    rotations = motion.rotations.copy()
    rotations[:, 0] = quaternion.multiply(turn, rotations[:, 0])
    shift = np.array([3.0, 0.0, -2.0])
    moved = {"rotations": rotations, "root_positions": quaternion.rotate(turn, motion.root_positions) + shift}
    if motion.joint_translations is not None:
        translations = motion.joint_translations.copy()
        translations[:, 0] = moved["root_positions"]
        moved["joint_translations"] = translations
    return motion.replace(**moved)


def longer_limbed(motion: kx.Motion) -> kx.Motion:
    """The same angles on a body with longer arms and legs."""
    skeleton = motion.skeleton
    factors = np.array([TRUNK if k == p else LIMBS for k, p in enumerate(partners(skeleton, None))])
    ends = tuple(type(e)(e.parent, (factors[e.parent] * np.array(e.offset)).tolist()) for e in skeleton.end_sites)
    longer = skeleton.replace(offsets=skeleton.offsets * factors[:, None], end_sites=ends)
    translations = motion.joint_translations
    return motion.replace(
        skeleton=longer,
        root_positions=motion.root_positions * LIMBS,
        joint_translations=None if translations is None else translations * factors[:, None],
    )


@dataclass(frozen=True)
class Change:
    """A change to a recording, and what it should do to the graph."""

    name: str
    recording: Callable[[kx.Motion], kx.Motion]
    graph: Callable[[MotionGraph], MotionGraph]


CHANGES = (
    Change("mirrored", kx.mirror, MotionGraph.mirrored),
    Change("120 to 30 frames/s", lambda m: m.resample(30.0), lambda g: g),
    Change("turned about the vertical", turned, lambda g: g),
    Change("longer limbs", longer_limbed, lambda g: g),
    Change("reversed", kx.reverse, MotionGraph.reversed_in_time),
)


@dataclass(frozen=True)
class Read:
    """What is compared."""

    class_: str
    period: float | None
    graph: MotionGraph | None

    @classmethod
    def of(cls, motion: kx.Motion) -> Read:
        """Read a recording."""
        found = read_grammar(kx.poses(motion))
        verdict = found.overall
        class_ = "cannot tell" if verdict is None or verdict.class_ is None else verdict.class_.value
        return cls(class_, None if verdict is None else verdict.period_s, found.graph)

    def __str__(self) -> str:
        """In a few words."""
        period = "" if self.period is None else f", {self.period:.3f} s"
        graph = "no graph" if self.graph is None else f"{len(self.graph.states)} states {len(self.graph.paths)} paths"
        return f"{self.class_}{period}, {graph}"


@dataclass(frozen=True)
class Outcome:
    """One recording under one change."""

    recording: str
    change: str
    same_class: bool
    same_period: bool
    same_graph: bool
    contracted: bool
    """Whether the graphs are the same without the states that leave no trace."""
    said: str
    """Empty where all is the same."""


def compare(name: str, motion: kx.Motion) -> Iterator[Outcome]:
    """A recording under every change that can be made to it."""
    base = Read.of(motion)
    for change in CHANGES:
        if change.name.startswith("120") and motion.fps < 60.0:
            continue
        read = Read.of(change.recording(motion))
        periods = (base.period, read.period)
        same_period = (
            periods == (None, None)
            if base.period is None or read.period is None
            else abs(base.period / read.period - 1.0) <= PERIOD
        )
        same = contracted = base.graph is read.graph
        apart = ""
        if base.graph is not None and read.graph is not None:
            expected = change.graph(base.graph)
            same = read.graph.isomorphic_to(expected)
            contracted = same or read.graph.contracted().isomorphic_to(expected.contracted())
            if not same:
                from kinesics.grammar.comparison import edit_distance

                distance = edit_distance(read.graph, expected, effort=EFFORT)
                apart = f"; {'' if distance.exact else 'at most '}{distance.value} changes"
        good = base.class_ == read.class_ and same_period and same
        yield Outcome(
            name,
            change.name,
            base.class_ == read.class_,
            same_period,
            same,
            contracted,
            "" if good else f"{base} → {read}{apart}",
        )


def studies() -> Iterator[tuple[str, kx.Motion]]:
    """Every study of the performer."""
    for name in kx.performer.NAMES:
        yield name, kx.performer.perform(name, fps=120.0, noise_degrees=NOISE_DEGREES, seed=1).motion


def real(folder: Path) -> Iterator[tuple[str, kx.Motion]]:
    """The real recordings."""
    whole = {path.stem: path for path in sorted((folder / "cmu").glob("*/*.amc"))}
    for name, path in whole.items():
        yield name, kx.read(path)
    with (folder / "cmu" / "segments.tsv").open(encoding="utf-8") as lines:
        for row in csv.DictReader(lines, delimiter="\t"):
            motion = kx.read(whole[row["clip"]])
            yield f"{row['clip']} {row['action']}", motion[int(row["start_frame"]) : int(row["end_frame"])]
    with (folder / "bandai-namco" / "labels.tsv").open(encoding="utf-8") as lines:
        first: dict[tuple[str, str], str] = {}
        for row in csv.DictReader(lines, delimiter="\t"):
            first.setdefault((row["content"], row["style"]), row["file"])
    with zipfile.ZipFile(folder / "bandai-namco" / "clips.zip") as archive, tempfile.TemporaryDirectory() as place:
        inside = {Path(name).name: name for name in archive.namelist()}
        for file in first.values():
            path = Path(place) / file
            path.write_bytes(archive.read(inside[file]))
            yield Path(file).stem, kx.read(path)
            path.unlink()


def outcomes(recordings: Iterator[tuple[str, kx.Motion]]) -> tuple[Outcome, ...]:
    """All of them."""
    return tuple(outcome for name, motion in recordings for outcome in compare(name, motion))


def tables(title: str, found: Sequence[Outcome]) -> list[Table]:
    """Counts, and what differs."""
    names = {o.recording for o in found}
    bad = {o.recording for o in found if o.said}

    def row(name: str, some: Sequence[Outcome]) -> list[str]:
        def share(good: Callable[[Outcome], bool]) -> str:
            right = sum(map(good, some))
            return f"{right} ({right / len(some):.0%})" if some else ""

        return [
            name,
            str(len(some)),
            share(lambda o: o.same_class),
            share(lambda o: o.same_period),
            share(lambda o: o.same_graph),
            share(lambda o: o.contracted),
            share(lambda o: not o.said),
        ]

    rows = [row(c.name, [o for o in found if o.change == c.name]) for c in CHANGES]
    counted = Table(
        title,
        ("change", "recordings", "same class", "same period", "same graph", "contracted", "all three"),
        [*rows, row("all", found)],
        (f"{len(names) - len(bad)} of {len(names)} recordings come out the same under every change.",),
    )
    differing = Table(
        f"{title}: what differs",
        ("recording", "change", "class", "period", "graph", "as it is → changed"),
        [
            [o.recording, o.change, *(" " if x else "✗" for x in (o.same_class, o.same_period, o.same_graph)), o.said]
            for o in found
            if o.said
        ],
    )
    return [counted, differing] if bad else [counted]


def run() -> Sequence[Table]:
    """The tables."""
    out = tables("Studies of the performer, 0.5° of noise", outcomes(studies()))
    folder = data_folder()
    if folder is None:
        return [*out, Table("Real recordings", ("",), [["not measured: the real recordings are not here"]])]
    return [*out, *tables("Real recordings", outcomes(real(folder)))]


if __name__ == "__main__":
    main(run)
