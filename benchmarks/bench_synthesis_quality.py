"""Quality of performances, with their own recordings as the yardstick, and how quickly they are made.

Paths are chosen at random, a transition whenever none was for half a second ("calm") or wherever there is one at every other
chance ("wild": up to three a second, more than a controller asks for). Contacts are found anew in the performance. Times of
release, margin and lean were compared on 91_01, the kata, Bandai-Namco walks and the performer's walk and set once for all,
and how long a transition takes on the first two and the exercises of 13: these rows are not held out, the others are.

    python benchmarks/bench_synthesis_quality.py [--json FILE]
"""

from __future__ import annotations

import statistics
import tempfile
import time
import warnings
import zipfile
from pathlib import Path

import numpy as np

import kinesics as kx
from harness import Table, data_folder, main
from kinesics.body.motion import Motion
from kinesics.synthesis.network import Network, network
from kinesics.synthesis.quality import Quality, measure
from kinesics.synthesis.rendering import LiveRenderer, Stage, render
from kinesics.synthesis.repertoire import repertoire

_CMU = {
    "walks of 91": ("91/91_01", "91/91_34"),
    "walks of 35 and 16": ("35/35_01", "16/16_21"),
    "Empi kata": ("135/135_02",),
    "exercises of 13": ("13/13_29", "13/13_30"),
    "86_01: jumps, kicks, punches": ("86/86_01",),
}
_BANDAI = {
    "Bandai-Namco walks, turns": (
        "dataset-2_walk_normal",
        "dataset-2_walk-turn-left_normal",
        "dataset-2_walk-turn-right_normal",
    ),
    "Bandai-Namco walk, run, wave": (
        "dataset-2_walk_active",
        "dataset-2_run_active",
        "dataset-2_wave-both-hands_active",
    ),
    "Bandai-Namco dance": ("dataset-1_dance-short_normal", "dataset-1_dance-long_normal"),
}
_PATHS = 150
_SEEDS = (1, 2, 3)


def stroll(made: Network, count: int, seed: int, *, hold: float) -> list[int]:
    """Paths at random, with a transition whenever none was for ``hold`` seconds; at half of all chances if that is 0."""
    rng = np.random.default_rng(seed)
    paths, since = [int(rng.integers(len(made)))], 0.0
    while len(paths) < count:
        since += float(made.duration[paths[-1]])
        nexts = made.successors(paths[-1])
        jumps = nexts[made.first[nexts] != made.onward[paths[-1]]]
        stays = np.setdiff1d(nexts, jumps)
        wanted = since > hold if hold > 0.0 else rng.random() < 0.5
        if len(jumps) and (wanted or not len(stays)):
            paths.append(int(rng.choice(jumps)))
            since = 0.0
        else:
            paths.append(int(stays[0]))
    return paths


def _sources() -> dict[str, list[Motion]]:
    folder = data_folder()
    if folder is None:
        walk = kx.performer.walk(seconds=20, fps=60, noise_degrees=0.5, noise_kind="smooth", route="circle", seed=1)
        return {"performer's walk (no real recordings here)": [walk.motion]}
    out = {name: [kx.read(folder / "cmu" / f"{clip}.amc") for clip in clips] for name, clips in _CMU.items()}
    with zipfile.ZipFile(folder / "bandai-namco" / "clips.zip") as archive, tempfile.TemporaryDirectory() as place:
        names = sorted(archive.namelist())
        for title, kinds in _BANDAI.items():
            motions = []
            for kind in kinds:
                for name in [n for n in names if Path(n).name.startswith(kind)][:3]:
                    path = Path(place) / Path(name).name
                    path.write_bytes(archive.read(name))
                    motions.append(kx.read(path))
            out[title] = motions
    return out


def run() -> list[Table]:
    """Every set of recordings, calm and wild, three seeds each: the median of the seeds, the worst where it says so."""
    rows, speeds = [], []
    for name, motions in _sources().items():
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # what is pruned is no matter here
            try:
                made = network(repertoire(motions))
            except kx.InputError as error:
                rows.append([name, "", str(error).split(".")[0], *[""] * 8])
                continue
        own = made.repertoire
        Stage.of(own)
        for manner, hold in (("calm", 0.5), ("wild", 0.0)):
            found: list[Quality] = []
            seconds, ratios = 0.0, []
            for seed in _SEEDS:
                paths = stroll(made, _PATHS, seed, hold=hold)
                began = time.perf_counter()
                done = render(made, paths)
                ratios.append(done.motion.duration / (time.perf_counter() - began))
                seconds += done.motion.duration
                found.append(measure(done, own, threshold=made.threshold))
            rows.append([name, manner, *_cells(found, seconds)])
            if manner == "calm":
                paths = stroll(made, _PATHS, 1, hold=hold)
                live = LiveRenderer(made, paths)
                steps = []
                for _ in range(min(600, int(made.length[paths].sum()))):
                    began = time.perf_counter()
                    live.step()
                    steps.append(1e3 * (time.perf_counter() - began))
                speeds.append(
                    [name, f"{own.fps:g}", f"{statistics.median(ratios):.0f}x", f"{statistics.median(steps):.2f}"]
                )
    return [
        Table(
            "Performances beside their recordings (in brackets: the recordings, at the same moments where it applies)",
            [
                "recordings",
                "manner",
                "cuts a second",
                "leaps of angular velocity, share of p99",
                "accelerations, share of p99",
                "slide of a contact, cm: p95 (recordings)",
                "slides > 1 cm",
                "time on the ground",
                "below the floor, cm",
                "D to nearest, worst (accepted)",
                "beyond joint range: frames > 1°, worst",
                "limbs too deep: frames, worst cm (recordings)",
            ],
            rows,
            [
                "p99 is the 99th percentile of the recordings, joint by joint; the figure is the 99th percentile of the frames "
                "of transitions. Targets: ≤ 1; slide ≤ 1 cm; ground time within 10 %; ≤ 1 cm below the floor; D ≤ accepted.",
            ],
        ),
        Table(
            "Speed of performing (targets: ≥ 50 times real time; ≤ 1 ms a live step)",
            ["recordings", "fps", "times real time", "median ms a live step"],
            speeds,
        ),
    ]


def _cells(found: list[Quality], seconds: float) -> list[str]:
    def middle(values: list[float]) -> float:
        return statistics.median(values)

    cuts = sum(q.cuts for q in found) / seconds
    share = middle([q.contact_share.performance for q in found])
    played = middle([q.contact_share.recordings for q in found])
    return [
        f"{cuts:.1f}",
        f"{middle([q.turning.performance for q in found]):.2f} ({middle([q.turning.recordings for q in found]):.2f})",
        f"{middle([q.acceleration.performance for q in found]):.2f} ({middle([q.acceleration.recordings for q in found]):.2f})",
        f"{100 * middle([q.slide.performance for q in found]):.1f} ({100 * found[0].slide.recordings:.1f})",
        f"{middle([q.slides_over for q in found]):.1%}",
        f"{share:.0%} ({played:.0%})",
        f"{100 * max(q.penetration.performance for q in found):.1f} ({100 * found[0].penetration.recordings:.1f})",
        f"{max(q.distance.performance for q in found):.4f} ({found[0].distance.recordings:.4f})",
        f"{middle([q.joint_excess_share for q in found]):.1%}, {np.rad2deg(max(q.joint_excess for q in found)):.0f}°",
        f"{middle([q.collision_share.performance for q in found]):.1%}, "
        f"{100 * max(q.collision.performance for q in found):.0f} ({found[0].collision_share.recordings:.1%}, "
        f"{100 * found[0].collision.recordings:.0f})",
    ]


if __name__ == "__main__":
    main(run)
