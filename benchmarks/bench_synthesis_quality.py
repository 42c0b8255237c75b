"""Quality of performances, with their own recordings as the yardstick, and how quickly they are made.

Paths are those a `Controller` chooses ("controller": after a route of a square and, seed by seed, without repeating itself),
and others drawn at random: a transition whenever none was for half a second ("calm") or wherever there is one at every other
chance ("wild": up to three a second, more than a controller asks for). Contacts are found anew in the performance, with the
recordings' own thresholds. What feet, body and joints weigh against each other (`synthesis.embodiment.footing`) was set once for
all on 91_01, the kata, Bandai-Namco walks and runs and the performer's walk, limits of transitions on these and 13, 86 and the
dance; rows called "held out" were looked at only afterwards.

Speed: a live step is one frame of `LiveRenderer`, of a calm stroll; and, deciding, of paths that a `Controller` chooses as they
are asked for (a target far away, nothing twice lately, few transitions), the time of the decision counted into the frame that
waits for it; the first, and those after the target was moved to the other side, besides.

    python benchmarks/bench_synthesis_quality.py [--json FILE] [--only speed|live]
"""

from __future__ import annotations

import itertools
import statistics
import tempfile
import time
import warnings
import zipfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import kinesics as kx
from harness import Table, data_folder, main
from kinesics.body.motion import Motion
from kinesics.synthesis.control.controller import Controller
from kinesics.synthesis.control.courses import perform_paths
from kinesics.synthesis.embodiment.quality import Quality, measure
from kinesics.synthesis.embodiment.rendering import Performance, render
from kinesics.synthesis.embodiment.stage import Stage
from kinesics.synthesis.goals import Economy, Novelty, Route, Target
from kinesics.synthesis.live.renderer import LiveRenderer, performed
from kinesics.synthesis.paths.network import Network, network
from kinesics.synthesis.paths.prospects import Prospects, prospects
from kinesics.synthesis.paths.trails import trails
from kinesics.synthesis.repertoire import repertoire

_CMU = {
    "walks of 91, 07 and 35, those of the targets": ("91/91_01", "91/91_34", "07/07_01", "35/35_01"),
    "walks of 91": ("91/91_01", "91/91_34"),
    "walks of 35 and 16": ("35/35_01", "16/16_21"),
    "Empi kata": ("135/135_02",),
    "exercises of 13": ("13/13_29", "13/13_30"),
    "86_01: jumps, kicks, punches": ("86/86_01",),
    "walks of 02 and 07, held out": ("02/02_01", "07/07_01", "07/07_05"),
    "14_06, held out": ("14/14_06",),
    "Bassai kata, held out": ("135/135_11",),
    "runs of 09 and 16, held out": ("09/09_06", "16/16_35"),
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
_MANNERS = ("controller", "calm", "wild")
_STEPS = 2000
_FAR = (9_000.0, 0.0)
"""Metres: a target that is never come to."""
_SECONDS = 30.0
_SQUARE = ((0.0, 0.0), (0.0, 3.0), (3.0, 3.0), (3.0, 0.0), (0.0, 0.0))
_COLUMNS = [
    "recordings",
    "manner",
    "cuts a second",
    "leaps of angular velocity beyond p99",
    "added, share of p99",
    "accelerations beyond p99",
    "added, share of p99",
    "slide of a contact, cm: p95 (recordings)",
    "slides > 1 cm (recordings)",
    "heel or ball that is firmly down shifts, cm: p90 (recordings)",
    "time on the ground",
    "touches not played",
    "below the floor, cm",
    "D to nearest, worst (accepted)",
    "beyond joint range: frames, worst",
    "limbs deeper than recorded: frames > 3 mm, worst cm",
]
_GOES_ABOUT = 0.3
"""Metres a second, below which recordings stay in place."""


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


def chosen(made: Network, ready: Prospects, seed: int) -> tuple[list[int], NDArray[np.float64]]:
    """Paths as a controller chooses them, and by how much each is bent."""
    follows = seed % 2 == 1 and ready.reach / ready.lookahead > _GOES_ABOUT
    course = perform_paths(made, Route(_SQUARE) if follows else Novelty(), _SECONDS, seed=seed, prepared=ready)
    ways = trails(made)
    return list(course.paths), course.bends * ways.travelled[ways.start + made.length][course.paths]


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


def _networks() -> Iterator[tuple[str, Network | str]]:
    """Of every set of recordings, or why there is none."""
    for name, motions in _sources().items():
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # what is pruned is no matter here
            try:
                yield name, network(repertoire(motions))
            except kx.InputError as error:
                yield name, str(error).split(".")[0]


def _performed(made: Network, ready: Prospects, manner: str, seed: int) -> tuple[Performance, float]:
    """A performance, and how many times as fast as real time it was made."""
    bend = None
    if manner == "controller":
        paths, bend = chosen(made, ready, seed)
    else:
        paths = stroll(made, _PATHS, seed, hold=0.5 if manner == "calm" else 0.0)
    began = time.process_time()
    done = render(made, paths, bend=bend)
    return done, done.motion.duration / (time.process_time() - began)


def run() -> list[Table]:
    """Every set of recordings, calm and wild, three seeds each: the median of the seeds, the worst where it says so."""
    rows, speeds = [], []
    for name, made in _networks():
        if isinstance(made, str):
            rows.append([name, "", made, *[""] * 12])
            continue
        Stage.of(made.repertoire)
        ready = prospects(made)
        ratios = []
        for manner in _MANNERS:
            found: list[Quality] = []
            seconds = 0.0
            for seed in _SEEDS:
                done, ratio = _performed(made, ready, manner, seed)
                ratios.append(ratio)
                seconds += done.motion.duration
                found.append(measure(done, made.repertoire, threshold=made.threshold))
            rows.append([name, manner, *_cells(found, seconds)])
        speeds.append(_speed(name, made, ready, ratios))
    return [
        Table(
            "Performances beside their recordings (in brackets: the recordings, at the same moments where it applies)",
            _COLUMNS,
            rows,
            [
                "p99 is the 99th percentile of the recordings, joint by joint. Beyond p99: share of all joints and frames of "
                "transitions, 1 % over all that was recorded. Added: 99th percentile of what differs, as a vector, from the "
                "same moment as recorded. Targets: shares as in brackets, added ≤ 1; slide ≤ 1 cm; ground time within 10 %; ≤ 1 cm "
                "below the floor; D ≤ accepted; no joint beyond its range, no limb deeper by more than 3 mm.",
            ],
        ),
        _speeds(speeds),
    ]


def speed() -> list[Table]:
    """How quickly they are made alone, of one seed."""
    rows = []
    for name, made in _networks():
        if isinstance(made, Network):
            Stage.of(made.repertoire)
            ready = prospects(made)
            rows.append(_speed(name, made, ready, [_performed(made, ready, manner, 1)[1] for manner in _MANNERS]))
    return [_speeds(rows)]


def _speeds(rows: list[list[str]]) -> Table:
    return Table(
        "Speed of performing in processor time (targets: ≥ 50 times real time; ≤ 1 ms a live step)",
        ["recordings", "fps", "times real time", "ms a live step, median", "99th percentile", "deciding too, median",
         "99th percentile", "first step, worst of 3", "sent elsewhere, worst of a second"],
        rows,
    )  # fmt: skip


def _speed(name: str, made: Network, ready: Prospects, ratios: list[float]) -> list[str]:
    goals = [Target(_FAR), Novelty(0.1), Economy(0.1)]
    strolling = LiveRenderer(made, stroll(made, _PATHS, 1, hold=0.5))
    controllers = [Controller(made, goals, seed=seed, prepared=ready) for seed in _SEEDS]
    decided = [LiveRenderer(made, controller) for controller in controllers]
    first = max(_milliseconds(live) or 0.0 for live in decided)
    cells = [cell for live in (strolling, decided[0]) for cell in _live(live)]
    # elsewhere, from the middle of a performance: a moment's decision, and those of a second
    controllers[0].pursue(Target((-_FAR[0], 0.0)))
    sent = max(_milliseconds(decided[0]) or 0.0 for _ in range(round(made.repertoire.fps)))
    ratio = f"{statistics.median(ratios):.0f}x"
    return [name, f"{made.repertoire.fps:g}", ratio, *cells, f"{first:.2f}", f"{sent:.2f}"]


def _cells(found: list[Quality], seconds: float) -> list[str]:
    def middle(values: list[float]) -> float:
        return statistics.median(values)

    cuts = sum(q.cuts for q in found) / seconds
    share = middle([q.contact_share.performance for q in found])
    played = middle([q.contact_share.recordings for q in found])
    return [
        f"{cuts:.1f}",
        *(
            cell
            for over, added in (
                ([q.turning_over for q in found], [q.turning_added for q in found]),
                ([q.acceleration_over for q in found], [q.acceleration_added for q in found]),
            )
            for cell in (
                f"{middle([o.performance for o in over]):.1%} ({middle([o.recordings for o in over]):.1%})",
                f"{middle(added):.2f}",
            )
        ),
        f"{100 * middle([q.slide.performance for q in found]):.1f} ({100 * found[0].slide.recordings:.1f})",
        f"{middle([q.slides_over.performance for q in found]):.0%} ({found[0].slides_over.recordings:.0%})",
        f"{100 * middle([q.shift.performance for q in found]):.1f} ({100 * found[0].shift.recordings:.1f})",
        f"{share:.0%} ({played:.0%})",
        f"{middle([q.touches for q in found]):.1%}",
        f"{100 * max(q.penetration.performance for q in found):.1f} ({100 * found[0].penetration.recordings:.1f})",
        f"{max(q.distance.performance for q in found):.4f} ({found[0].distance.recordings:.4f})",
        f"{max(q.joint_excess_share for q in found):.1%}, {np.rad2deg(max(q.joint_excess for q in found)):.1f}°",
        f"{max(q.collision_share for q in found):.1%}, {100 * max(q.collision for q in found):.1f}",
    ]


def _milliseconds(live: LiveRenderer) -> float | None:
    """Of one live step; None where there is none any more."""
    began = time.process_time()
    return None if next(live, None) is None else 1e3 * (time.process_time() - began)


def _live(live: LiveRenderer) -> list[str]:
    """Milliseconds of a live step: the median, the 99th percentile."""
    steps = [taken for _ in range(_STEPS) if (taken := _milliseconds(live)) is not None]
    return [f"{statistics.median(steps):.2f}", f"{np.quantile(steps, 0.99):.2f}"]


def live() -> list[Table]:
    """How good what is performed live is: calm, and by decisions towards a target far away, without repeating itself."""
    rows = []
    for name, made in _networks():
        if not isinstance(made, Network):
            continue
        count = round(_SECONDS * made.repertoire.fps)
        goals = [Target(_FAR), Novelty(0.1), Economy(0.1)]
        for manner, paths in (
            ("calm", iter(stroll(made, _PATHS, 1, hold=0.5))),
            ("deciding", Controller(made, goals, seed=1)),
        ):
            frames = list(itertools.islice(LiveRenderer(made, paths), count))
            found = measure(performed(made, frames), made.repertoire, threshold=made.threshold)
            rows.append([name, manner, *_cells([found], count / made.repertoire.fps)])
    return [Table("Performed live, beside their recordings", _COLUMNS, rows)]


if __name__ == "__main__":
    main(run, parts={"speed": speed, "live": live})
