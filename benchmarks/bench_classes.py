"""How often the symmetry class is right: labelled recordings, synthetic performances of every class, and how far to trust it.

    python benchmarks/bench_classes.py [--json FILE]

The coefficients of the classifier are fitted on synthetic performances, under other seeds than here, by `fit_classes.py`; where
the line between symmetric and not lies is a convention stated there, which was set with these labels known.
Labels: Bandai-Namco Research Motiondataset (content of the clip), CMU mocap6 (exercise).
"""

from __future__ import annotations

import csv
import io
import tempfile
import time
import zipfile
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import kinesics as kx
from harness import Table, data_folder, main
from kinesics.grammar import classes, moments, whole
from kinesics.vocabulary import MovementClass

SYNTHETIC = {
    "limp": "cyclic-asymmetric",
    "walk": "cyclic-antiphase",
    "butterfly": "cyclic-symmetric",
    "wave": "cyclic-palindromic",
    "arm_circles": "cyclic-antipalindromic",
    "jog_in_place": "cyclic-antiphase-palindromic",
    "jumping_jacks": "cyclic-symmetric-palindromic",
    "throw": "asymmetric",
    "raise_arms": "symmetric",
    "reach": "palindromic",
    "sway": "antipalindromic",
    "bow": "symmetric-palindromic",
    "stand": "still",
}
SEEDS = 20
RATES = (30.0, 60.0, 120.0)


class Tally:
    """Verdicts beside the truth."""

    def __init__(self) -> None:
        self.pairs: list[tuple[str, str]] = []
        self.confidence: list[float] = []

    def add(self, expected: str, verdict: classes.Verdict) -> None:
        found = "cannot tell" if verdict.class_ is None else verdict.class_.value
        self.pairs.append((expected, found))
        self.confidence.append(verdict.confidence)

    @property
    def right(self) -> NDArray[np.bool_]:
        return np.array([a == b for a, b in self.pairs])

    def calibration_error(self, bins: int = 10) -> float:
        """Expected calibration error: mean of |confidence − share right| over bins of equal width, by how many fall in."""
        chance, right = np.array(self.confidence), self.right
        which = np.minimum((chance * bins).astype(int), bins - 1)
        return float(
            sum(
                abs(chance[which == b].mean() - right[which == b].mean()) * (which == b).mean()
                for b in np.unique(which)
            )
        )

    def confusion(self, title: str, notes: Sequence[str] = ()) -> Table:
        found = [c.value for c in MovementClass if any(b == c.value for _, b in self.pairs)]
        if any(b == "cannot tell" for _, b in self.pairs):
            found.append("cannot tell")
        expected = [c.value for c in MovementClass if any(a == c.value for a, _ in self.pairs)]
        count = Counter(self.pairs)
        rows = []
        for a in expected:
            total = sum(count[a, b] for b in found)
            rows.append([a, str(total), *(str(count[a, b] or "") for b in found), f"{count[a, a] / total:.1%}"])
        return Table(
            title,
            ["expected", "clips", *found, "right"],
            rows,
            [
                f"{self.right.sum()} of {len(self.pairs)} right ({self.right.mean():.1%}), "
                f"expected calibration error {self.calibration_error():.3f}.",
                *notes,
            ],
        )


def labelled_clips(folder: Path) -> Tally:
    tally = Tally()
    with (folder / "bandai-namco" / "labels.tsv").open(encoding="utf-8") as lines:
        labels = {r["file"]: r["expected_class"] for r in csv.DictReader(lines, delimiter="\t") if r["expected_class"]}
    with zipfile.ZipFile(folder / "bandai-namco" / "clips.zip") as archive, tempfile.TemporaryDirectory() as place:
        inside = {Path(name).name: name for name in archive.namelist()}
        for name, expected in labels.items():
            path = Path(place) / name
            path.write_bytes(archive.read(inside[name]))
            tally.add(expected, classes.classify(moments.from_poses(kx.poses(kx.read(path)))))
            path.unlink()
    return tally


def labelled_segments(folder: Path) -> tuple[Tally, list[list[str]]]:
    tally, rows = Tally(), []
    recordings: dict[str, moments.Moments] = {}
    text = (folder / "cmu" / "segments.tsv").read_text(encoding="utf-8")
    for row in csv.DictReader(io.StringIO(text), delimiter="\t"):
        if not row["expected_class"]:
            continue
        clip = row["clip"]
        if clip not in recordings:
            recordings[clip] = moments.from_poses(
                kx.poses(kx.read(folder / "cmu" / clip.split("_")[0] / f"{clip}.amc"))
            )
        m = recordings[clip]
        verdict = classes.classify(m, m.moment_of(int(row["start_frame"])), m.moment_of(int(row["end_frame"])))
        tally.add(row["expected_class"], verdict)
        found = "cannot tell" if verdict.class_ is None else verdict.class_.value
        rows.append(
            [
                clip,
                row["action"],
                row["expected_class"],
                found,
                f"{verdict.confidence:.2f}",
                f"{verdict.repeats or 0:.1f}",
            ]
        )
    return tally, rows


def found_segments(folder: Path) -> tuple[int, list[list[str]]]:
    """Of each labelled segment the phrase that overlaps it most, found in the whole recording with nothing told."""
    right, rows = 0, []
    recordings: dict[str, list[whole.JudgedPhrase]] = {}
    text = (folder / "cmu" / "segments.tsv").read_text(encoding="utf-8")
    for row in csv.DictReader(io.StringIO(text), delimiter="\t"):
        if not row["expected_class"]:
            continue
        clip, start, end = row["clip"], int(row["start_frame"]), int(row["end_frame"])
        if clip not in recordings:
            poses = kx.poses(kx.read(folder / "cmu" / clip.split("_")[0] / f"{clip}.amc"))
            recordings[clip] = whole.judge(moments.from_poses(poses))[1]
        shared = [min(end, p.end) - max(start, p.start) for p in recordings[clip]]
        most = max(shared)
        best = recordings[clip][shared.index(most)]
        assert best.verdict is not None
        name = "cannot tell" if best.verdict.class_ is None else best.verdict.class_.value
        right += name == row["expected_class"]
        rows.append(
            [
                clip,
                row["action"],
                row["expected_class"],
                name,
                f"{best.verdict.confidence:.2f}",
                f"{most / (end - start):.0%}",
                f"{most / (max(end, best.end) - min(start, best.start)):.0%}",
            ]
        )
    return right, rows


def synthetic(rate: float) -> Tally:
    tally = Tally()
    for name, expected in SYNTHETIC.items():
        for seed in range(SEEDS):
            jitter = {} if name == "stand" else {"tempo_jitter": 0.05}
            p = kx.performer.perform(name, fps=rate, noise_degrees=1.0, seed=1000 + seed, **jitter)
            assert p.truth.class_.value == expected
            tally.add(expected, classes.classify(moments.from_poses(kx.poses(p.motion))))
    return tally


def run() -> Sequence[Table]:
    tables = []
    everything = Tally()
    for rate in RATES:
        tally = synthetic(rate)
        everything.pairs += tally.pairs
        everything.confidence += tally.confidence
    tables.append(
        everything.confusion(
            f"Synthetic performances: {SEEDS} seeds of each class at 30, 60 and 120 frames a second, 1° noise, 5 % tempo jitter"
        )
    )
    folder = data_folder()
    if folder is None:
        return tables
    began = time.perf_counter()
    clips = labelled_clips(folder)
    tables.append(
        clips.confusion(
            "Bandai-Namco clips, class by what the clip is said to hold",
            [f"Read and classed in {time.perf_counter() - began:.0f} s."],
        )
    )
    segments, rows = labelled_segments(folder)
    tables.append(
        Table(
            "CMU mocap6, class of the given segment",
            ["clip", "exercise", "expected", "found", "confidence", "periods"],
            rows,
            [f"{segments.right.sum()} of {len(rows)} right."],
        )
    )
    right, rows = found_segments(folder)
    tables.append(
        Table(
            "CMU mocap6, class of the phrase found in the whole recording, nothing told",
            ["clip", "exercise", "expected", "found", "confidence", "overlap, of the segment", "of both together"],
            rows,
            [f"{right} of {len(rows)} right (goal: 11). The phrase is the one that overlaps the segment most."],
        )
    )
    real = Tally()
    real.pairs, real.confidence = clips.pairs + segments.pairs, clips.confidence + segments.confidence
    tables.append(
        Table(
            "Confidence",
            ["where", "verdicts", "right", "mean confidence", "expected calibration error"],
            [
                [
                    name,
                    str(len(t.pairs)),
                    f"{t.right.mean():.1%}",
                    f"{np.mean(t.confidence):.1%}",
                    f"{t.calibration_error():.3f}",
                ]
                for name, t in (("synthetic", everything), ("real", real))
            ],
        )
    )
    return tables


if __name__ == "__main__":
    main(run)
