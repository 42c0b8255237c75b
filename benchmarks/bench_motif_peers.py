"""Motifs against LoCoMotif and stumpy: planted repeats, and movements that return backwards and mirrored.

    python benchmarks/bench_motif_peers.py [--json FILE]

Equal input for all: the quaternions of the 15 links at 30 frames a second, with 0.5° of noise. In the first kind of recording a
movement of 2 to 4 s is performed several times between unrelated movement, each time at its own wavering tempo. In the second,
[A, rest, A backwards, rest, A mirrored], it comes once each way. We are told nothing. LoCoMotif is told the shortest and the
longest occurrence and has the best of several strictnesses in each recording; stumpy is told the middling length and how many
occurrences there are.

An occurrence is found when the member that overlaps it most shares half of it (intersection over union), all within one motif;
ends are judged where it is found.
"""

from __future__ import annotations

import os
import subprocess
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import kinesics as kx
from harness import Table, main
from kinesics.body.pose import mirror
from kinesics.geometry import quaternion
from kinesics.grammar import moments
from kinesics.grammar.motifs import find_motifs

Array = NDArray[np.float64]
Interval = tuple[int, int]
FPS = 30.0
LINKS = 15
RECORDINGS = 20
NOISE = np.radians(0.5)
REST_S = 1.0
KNOT_S = 0.5
SIZE = 0.35
"""Radians, of random postures."""
TEMPO = (0.75, 1.33)
WAVER = 0.15
SHARED = 0.5

LOCOMOTIF = """
import sys, json
import numpy as np
from locomotif import locomotif
def job():
    out = []
    for entry in json.load(open(sys.argv[1])):
        series = np.load(entry["file"])
        series = (series - series.mean(axis=0)) / (series.std(axis=0) + 1e-9)
        tried = []
        for rho in (0.5, 0.6, 0.7, 0.8, 0.9):
            found = locomotif.apply_locomotif(series, l_min=entry["shortest"], l_max=entry["longest"], rho=rho, nb=5)
            tried.append([[[int(a), int(b)] for a, b in members] for _, members in found])
        out.append(tried)
    json.dump(out, open(sys.argv[2], "w"))
job()
"""
STUMPY = """
import sys, json
import numpy as np
import stumpy
def job():
    out = []
    for entry in json.load(open(sys.argv[1])):
        series = np.load(entry["file"]).T.copy()
        m = entry["length"]
        profile, index = stumpy.mstump(series, m)
        _, where, *_ = stumpy.mmotifs(series, profile, index, max_matches=entry["count"], max_motifs=1, k=len(series) - 1,
                                      max_distance=np.inf, cutoffs=np.inf)
        out.append([[[[int(i), int(i) + m] for i in row if i >= 0] for row in where]])
    json.dump(out, open(sys.argv[2], "w"))
job()
"""


@dataclass(frozen=True, eq=False)
class Planted:
    """A recording and where its movement comes."""

    quaternions: Array
    occurrences: tuple[Interval, ...]
    relations: tuple[str, ...] = ()
    """Of each occurrence to the first one; empty where all are the same."""


@dataclass
class Score:
    """How many are found, how exactly, and what else is taken for one."""

    planted: int = 0
    found: int = 0
    complete: int = 0
    """Recordings in which all are found."""
    others: int = 0
    ends: list[float] = field(default_factory=list)

    def add(self, truth: Sequence[Interval], sets: Sequence[Sequence[Interval]]) -> None:
        """The motif that has most of the occurrences counts."""
        best: tuple[int, int, list[float]] = (0, 0, [])
        for members in sets:
            ends: list[float] = []
            used: set[int] = set()
            for a, b in truth:
                shares = [max(0, min(b, d) - max(a, c)) / (max(b, d) - min(a, c)) for c, d in members]
                k = int(np.argmax(shares)) if shares else -1
                if shares and shares[k] >= SHARED and k not in used:
                    used.add(k)
                    ends += [abs(members[k][0] - a) / FPS, abs(members[k][1] - b) / FPS]
            # one alone is no repetition
            if len(used) >= 2:
                best = max(best, (len(used), len(used) - len(members), ends), key=lambda x: x[:2])
        self.planted += len(truth)
        self.found += best[0]
        self.complete += best[0] == len(truth)
        self.others -= best[1]
        self.ends += best[2]

    def row(self, name: str) -> list[str]:
        """For the table."""
        exact = f"{np.median(self.ends):.3f}" if self.ends else ""
        worst = f"{np.quantile(self.ends, 0.9):.3f}" if self.ends else ""
        return [name, f"{self.found} of {self.planted}", str(self.complete), str(self.others), exact, worst]


def smooth(rng: np.random.Generator, first: Array, last: Array, seconds: float, *, still: bool) -> Array:
    """Rotation vectors of a smooth random movement from one posture to another, shape (frames, links · 3)."""
    from scipy.interpolate import CubicSpline

    count = max(1, round(seconds / KNOT_S) - 1)
    inside = rng.normal(0.0, SIZE, (count, first.size))
    knots = np.concatenate([[first], inside, [last]])
    curve = CubicSpline(np.linspace(0.0, 1.0, len(knots)), knots, bc_type="clamped" if still else "natural")
    return np.asarray(curve(np.linspace(0.0, 1.0, round(seconds * FPS) + 1)))


def at_tempo(rng: np.random.Generator, movement: Array, factor: float) -> Array:
    """The movement faster or slower, and unevenly so."""
    u = np.linspace(0.0, 1.0, round((len(movement) - 1) * factor) + 1)
    u = u + WAVER / (2 * np.pi) * np.sin(2 * np.pi * u + rng.uniform(0, 2 * np.pi)) * np.sin(np.pi * u)
    at = np.clip(u, 0.0, 1.0) * (len(movement) - 1)
    return np.stack([np.interp(at, np.arange(len(movement)), column) for column in movement.T], axis=1)


def noisy(rng: np.random.Generator, rotations: Array) -> Array:
    """Quaternions, shape (frames, links, 4), each turned a little."""
    q = quaternion.from_rotvec(rotations.reshape(len(rotations), LINKS, 3))
    return np.asarray(
        quaternion.multiply(q, quaternion.from_rotvec(rng.normal(0.0, NOISE / np.sqrt(3), (*q.shape[:2], 3))))
    )


def planted_repeats(seed: int) -> Planted:
    """A movement three to six times, between unrelated ones."""
    rng = np.random.default_rng(seed)
    posture = rng.normal(0.0, SIZE, (2, LINKS * 3))
    movement = smooth(rng, *posture, rng.uniform(2.0, 4.0), still=False)
    pieces: list[Array] = []
    where: list[Interval] = []
    now, here = 0, rng.normal(0.0, SIZE, LINKS * 3)
    for _ in range(3 + seed % 4):
        pieces.append(smooth(rng, here, movement[0], rng.uniform(1.5, 4.0), still=False)[:-1])
        now += len(pieces[-1])
        pieces.append(at_tempo(rng, movement, rng.uniform(*TEMPO)))
        where.append((now, now + len(pieces[-1])))
        now += len(pieces[-1])
        here = movement[-1]
    pieces.append(smooth(rng, here, rng.normal(0.0, SIZE, here.size), 2.0, still=False)[1:])
    return Planted(noisy(rng, np.concatenate(pieces)), tuple(where))


def there_back_mirrored(seed: int, *, unrelated: bool = False) -> Planted:
    """[A, rest, A backwards, rest, A mirrored], A from a symmetric posture; or in their places three unrelated movements."""
    rng = np.random.default_rng(1000 + seed)
    start = np.zeros(LINKS * 3)
    movement = smooth(rng, start, rng.normal(0.0, SIZE, start.size), rng.uniform(2.0, 4.0), still=True)
    image = quaternion.as_rotvec(mirror(quaternion.from_rotvec(movement.reshape(-1, LINKS, 3)))).reshape(movement.shape)
    rest = round(REST_S * FPS)
    away, home = np.repeat(movement[-1:], rest, axis=0), np.repeat(movement[:1], rest, axis=0)
    n = len(movement)
    starts = (0, n + rest, 2 * (n + rest))
    back = movement[::-1]
    if unrelated:
        seconds = (n - 1) / FPS
        back = smooth(rng, movement[-1], start, seconds, still=True)
        image = smooth(rng, start, rng.normal(0.0, SIZE, start.size), seconds, still=True)
    whole = np.concatenate([movement, away, back, home, image])
    return Planted(noisy(rng, whole), tuple((s, s + n) for s in starts), ("same", "reverse", "mirror"))


def ours(recording: Planted) -> list[list[Interval]]:
    """Members of each motif under all relations."""
    q = recording.quaternions
    poses = kx.PoseSequence(q, np.zeros(len(q)), np.zeros((len(q), 2)), FPS)
    families: dict[int, set[Interval]] = {}
    for motif in find_motifs(moments.from_poses(poses)):
        families.setdefault(motif.family, set()).update((m.start, m.end) for m in motif.members)
    return [sorted(f) for f in families.values()]


def theirs(source: str, recordings: Sequence[Planted]) -> list[list[list[list[Interval]]]] | str:
    """For each recording and setting the motifs; or why there are none."""
    import json

    python = os.environ.get("KINESICS_PEERS")
    if not python:
        return "not measured: $KINESICS_PEERS is not set (`make bench` sets it)"
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        entries = []
        for k, recording in enumerate(recordings):
            file = folder / f"{k}.npy"
            np.save(file, recording.quaternions.reshape(len(recording.quaternions), -1))
            lengths = [b - a for a, b in recording.occurrences]
            entries.append(
                {
                    "file": str(file),
                    "shortest": min(lengths),
                    "longest": max(lengths) + 1,
                    "length": int(np.median(lengths)),
                    "count": len(lengths),
                }
            )
        (folder / "in.json").write_text(json.dumps(entries), encoding="utf-8")
        command = [python, "-c", source, str(folder / "in.json"), str(folder / "out.json")]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode:
            return f"not measured: {(done.stderr.strip().splitlines() or ['it stopped without a word'])[-1]}"
        return json.loads((folder / "out.json").read_text(encoding="utf-8"))


def scored(recordings: Sequence[Planted]) -> list[list[str]]:
    """A row for each of the three."""
    rows = []
    score = Score()
    for recording in recordings:
        score.add(recording.occurrences, ours(recording))
    rows.append(score.row("kinesics"))
    for name, source in (("LoCoMotif", LOCOMOTIF), ("stumpy", STUMPY)):
        found = theirs(source, recordings)
        if isinstance(found, str):
            rows.append([name, found, "", "", "", ""])
            continue
        score = Score()
        for recording, settings in zip(recordings, found, strict=True):
            # the setting that finds most, and of those the one with the exactest ends
            trials = []
            for sets in settings:
                trial = Score()
                trial.add(recording.occurrences, sets)
                trials.append((-trial.found, trial.others, float(np.mean(trial.ends)) if trial.ends else 0.0, sets))
            score.add(recording.occurrences, min(trials, key=lambda t: t[:3])[3])
        rows.append(score.row(name))
    return rows


COLUMNS = ("", "occurrences found", "recordings with all", "other members", "ends off, median s", "9 of 10 within, s")


def run() -> Sequence[Table]:
    """The tables."""
    return [
        Table(
            f"Planted repeats, tempo ×{TEMPO[0]} to ×{TEMPO[1]}: {RECORDINGS} recordings",
            COLUMNS,
            scored([planted_repeats(seed) for seed in range(RECORDINGS)]),
            ("Target: at least as many found as either, ends at least as exact.",),
        ),
        Table(
            f"[A, rest, A backwards, rest, A mirrored]: {RECORDINGS} recordings",
            COLUMNS,
            scored([there_back_mirrored(seed) for seed in range(RECORDINGS)]),
            (
                "The peers look for repetitions alone and are not made for this; the next table tells what of it is chance.",
            ),
        ),
        Table(
            f"Control: three unrelated movements in their places, so that nothing is there to be found: {RECORDINGS} recordings",
            COLUMNS,
            scored([there_back_mirrored(seed, unrelated=True) for seed in range(RECORDINGS)]),
        ),
    ]


if __name__ == "__main__":
    main(run)
