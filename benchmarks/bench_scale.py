"""How time and memory grow with the recording: ten minutes and an hour, from poses to phrases, classes, motifs and graph.

    python benchmarks/bench_scale.py [--json FILE]

Long recordings are real ones (Bandai-Namco, 30 fps) put end to end; without the real recordings, performed graphs. An hour at
120 fps is the one at 30 with frames between. Each job is a process of its own on one thread: seconds of processor time and peak
resident memory, as the operating system counts them; loading the motion and its poses is a job of its own.
"""

from __future__ import annotations

import os
import pickle
import random
import statistics
import sys
import tempfile
import time
import zipfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np

import kinesics as kx
from harness import Table, data_folder, main, measure

FPS = 30
REPEATS = 5
LOAD = "import pickle, sys; import kinesics as kx; motion = pickle.load(open(sys.argv[1], 'rb'))"
POSES = f"{LOAD}; poses = kx.poses(motion)"
GRAMMAR = f"{POSES}; from kinesics.grammar.whole import read_grammar; read_grammar(poses)"
ANALYZE = f"{LOAD}; kx.analyze(motion)"


def clips() -> Iterator[kx.Motion]:
    """Short recordings of one skeleton, in no order, again and again."""
    data = data_folder()
    archive = data / "bandai-namco" / "clips.zip" if data else None
    if archive is None or not archive.exists():
        from kinesics.performer.random_graphs import covering_steps, random_graph

        for seed in range(10_000):
            graph = random_graph(states=3 + seed % 10, seed=seed)
            steps = covering_steps(graph, seed=seed)
            yield kx.performer.traverse(graph, steps, fps=FPS, noise_degrees=0.5, tempo_jitter=0.05, seed=seed).motion
        return
    with zipfile.ZipFile(archive) as files, tempfile.TemporaryDirectory() as folder:
        names = sorted(n for n in files.namelist() if n.endswith(".bvh"))
        random.Random(0).shuffle(names)
        while True:
            for name in names:
                yield kx.read(files.extract(name, folder))


def recording(seconds: float) -> kx.Motion:
    """Clips end to end, so many seconds of them."""
    taken: list[kx.Motion] = []
    wanted = round(seconds * FPS)
    source = clips()
    while sum(m.frame_count for m in taken) < wanted:
        taken.append(next(source))
    return kx.Motion(
        taken[0].skeleton,
        np.concatenate([m.rotations for m in taken])[:wanted],
        np.concatenate([m.root_positions for m in taken])[:wanted],
        FPS,
        name=f"{seconds / 60:.0f} minutes",
    )


def from_poses_to_graph() -> list[Table]:
    """A kata of 43 s at 120 frames a second: phrases, classes, motifs and graph of its poses, in this process."""
    data = data_folder()
    file = data / "cmu" / "135" / "135_02.amc" if data else None
    if file is None or not file.exists():
        return []
    from kinesics.grammar.whole import read_grammar

    poses = kx.poses(kx.read(file))
    taken = []
    for _ in range(REPEATS + 1):  # the first one imports what it needs
        wall, processor = time.perf_counter(), time.process_time()
        read_grammar(poses)
        taken.append((time.perf_counter() - wall, time.process_time() - processor))
    rows = [
        (
            f"Empi (CMU 135_02), {len(poses):,} frames",
            *(f"{statistics.median(t[k] for t in taken[1:]):.2f}" for k in (0, 1)),
            f"{taken[0][0]:.2f}",
            "≤ 2 s",
        )
    ]
    columns = ("recording", "seconds, median", "CPU s, median", "the first time, imports included", "target")
    return [Table("From poses to phrases, classes, motifs and graph", columns, rows, (f"{REPEATS} runs.",))]


def run() -> list[Table]:
    """All rows. Short jobs are run five times in turn, those of an hour once."""
    compiled = {**os.environ, "OMP_NUM_THREADS": "1", "KINESICS_NO_NATIVE": "0"}
    with_numpy = {**compiled, "KINESICS_NO_NATIVE": "1"}
    rows: list[tuple[str, ...]] = []
    with tempfile.TemporaryDirectory() as folder:

        def job(name: str, code: str, file: Path, environment: dict[str, str], repeats: int, target: str = "") -> None:
            got = [measure([sys.executable, "-c", code, str(file)], folder, environment) for _ in range(repeats)]
            seconds, peak = statistics.median(c for _, c, _ in got), max(m for _, _, m in got)
            rows.append((name, f"{seconds:.1f}", f"{peak:.0f}", str(repeats), target))

        for name, motion, repeats in (
            ("10 minutes at 30 fps", recording(600), REPEATS),
            ("1 hour at 30 fps", recording(3600), 1),
            ("1 hour at 120 fps", recording(3600).resample(120), 1),
        ):
            file = Path(folder) / "motion.pickle"
            file.write_bytes(pickle.dumps(motion))
            hour = repeats == 1
            job(f"{name}: loaded, poses", POSES, file, compiled, repeats)
            limits = "≤ 10 min, ≤ 2 GB" if hour else "≤ 20 s, ≤ 1 GB"
            job(f"{name}: and the grammar with its graph", GRAMMAR, file, compiled, repeats, limits)
            job(f"{name}: analyze", ANALYZE, file, compiled, repeats)
            if not hour:
                job(f"{name}: grammar without compiled kernels", GRAMMAR, file, with_numpy, 1)
    return [
        *from_poses_to_graph(),
        Table(
            title="Long recordings, whole processes on one thread",
            columns=("what", "CPU s", "peak MB", "runs", "target"),
            rows=rows,
            notes=("CPU seconds are the median of the runs, start-up and loading included.",),
        ),
    ]


if __name__ == "__main__":
    main(run)
