"""The controller on CMU walks: targets in any direction, routes, what mirrored copies are worth, time for a decision.

    python benchmarks/bench_synthesis_control.py [--json FILE] [--only decisions|performed|chirality|ready]

Everything is measured on the way of the root over the floor, as planted feet carry the body (`synthesis.embodiment.afoot`), and of
some whole performances on the movement performed. Networks are made from the walks of the data folder at 30 frames a second.
Targets lie 3-8 m away in any direction, drawn by seed. A trial begins with any path as recorded, drawn by seed (so it may begin
turning the other way, or standing), and ends, at the latest, after 30 s. "Looked ahead 0 s" weighs single paths, as the
dissertation does. How long a graph takes is that of whole processes, from the files on.
"""

from __future__ import annotations

import random
import statistics
import sys
import tempfile
import time
import zipfile
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

import kinesics as kx
from harness import Table, data_folder, main, measure
from kinesics.synthesis.control.controller import BEND, Controller
from kinesics.synthesis.control.courses import Course, perform_paths
from kinesics.synthesis.embodiment.afoot import afoot
from kinesics.synthesis.goals import RADIUS, Economy, Goal, Novelty, Route, Target, Targets
from kinesics.synthesis.paths.network import Network, network
from kinesics.synthesis.paths.prospects import LOOKAHEAD, Prospects, prospects
from kinesics.synthesis.repertoire import repertoire

WALKS = ("91/91_01", "91/91_34", "07/07_01", "07/07_05", "35/35_01", "02/02_01", "16/16_21")
STRAIGHT = ("07/07_01", "07/07_05", "35/35_01", "02/02_01", "16/16_21")
ONE_SIDED = (10.5, 19.0)
"""Seconds of 91_01 in which the walker turns to the right only."""
FPS = 30.0
TRIALS = 200
ROUTE_SEEDS = 10
DECISIONS = 2_000
PERFORMED = 40
PERFORMED_ROUTES = 5
MINUTES = (1, 10)
READY_RUNS = 3
READY = """
import sys, warnings
import kinesics as kx
from kinesics.synthesis.embodiment.afoot import afoot
from kinesics.synthesis.paths.network import network
from kinesics.synthesis.paths.prospects import prospects
from kinesics.synthesis.repertoire import repertoire
warnings.simplefilter("ignore")
prospects(afoot(network(repertoire([kx.read(file) for file in sys.argv[1:]]))))
"""


class Trial(NamedTuple):
    """One target."""

    reached: bool
    seconds: float
    """Until reached; infinite if it was not."""
    ratio: float
    """Metres walked until then, over the straight line."""
    nearest: float
    bearing: float
    """Of the target at the start, radians, positive to the left."""


def read(names: Sequence[str]) -> list[kx.Motion]:
    folder = data_folder()
    assert folder is not None
    return [kx.read(folder / "cmu" / f"{name}.amc") for name in names]


def _clips(kind: str, count: int) -> list[kx.Motion]:
    """The first clips of a kind of Bandai-Namco's."""
    folder = data_folder()
    assert folder is not None
    archive = folder / "bandai-namco" / "clips.zip"
    with zipfile.ZipFile(archive) as packed, tempfile.TemporaryDirectory() as place:
        names = sorted(n for n in packed.namelist() if Path(n).name.startswith(kind) and n.endswith(".bvh"))
        return [kx.read(packed.extract(name, place)) for name in names[:count]]


def prepared(motions: Sequence[kx.Motion], mirrored: bool, lookahead: float = LOOKAHEAD) -> tuple[Network, Prospects]:
    made = afoot(network(repertoire(motions, fps=FPS, mirrored=mirrored)))
    return made, prospects(made, lookahead)


def to_target(
    walks: Network,
    ready: Prospects,
    seed: int,
    bend: float,
    seconds: float = 30.0,
    away: tuple[float, float] = (3.0, 8.0),
) -> tuple[Trial, Course]:
    rng = np.random.default_rng([2012, seed])
    metres, bearing = rng.uniform(*away), rng.uniform(-np.pi, np.pi)
    # with and without mirrored copies from about the same moment of the same recording
    recorded = np.flatnonzero(walks.first < walks.repertoire.frame_count)
    start = int(recorded[int(rng.random() * len(recorded))])
    place = np.array([metres * np.sin(bearing), metres * np.cos(bearing)])
    goal = Target((float(place[0]), float(place[1])))
    course = perform_paths(
        walks, goal, seconds, seed=seed, finish=True, bend=bend, start=start, prepared=ready, stand=False
    )
    off = np.hypot(*(course.ground - place).T)
    hits = np.flatnonzero(off <= 0.5)
    if not len(hits):
        return Trial(False, np.inf, np.nan, float(off.min()), bearing), course
    walked = np.hypot(*np.diff(course.ground[: hits[0] + 1], axis=0).T).sum()
    return Trial(True, hits[0] / FPS, float(walked / metres), float(off.min()), bearing), course


def summary(trials: Sequence[Trial]) -> list[str]:
    ratios = [t.ratio for t in trials if t.reached]
    return [
        f"{100 * np.mean([t.reached for t in trials]):.1f} %",
        f"{np.median(ratios):.2f}" if ratios else "-",
        f"{np.quantile(ratios, 0.9):.2f}" if ratios else "-",
        f"{np.median([t.seconds for t in trials]):.1f} s",
        f"{max(t.nearest for t in trials):.2f} m",
    ]


def targets(motions: Sequence[kx.Motion]) -> Table:
    rows = []
    for lookahead in (0.0, 1.0, LOOKAHEAD, 3.0):
        walks, ready = prepared(motions, True, lookahead)
        for bend in (0.0, BEND):
            trials, performed, began = [], 0.0, time.perf_counter()
            for seed in range(TRIALS):
                trial, course = to_target(walks, ready, seed, bend)
                trials.append(trial)
                performed += course.seconds
            speed = performed / (time.perf_counter() - began)
            rows.append([f"{lookahead:g} s", f"{bend:g}°/m", *summary(trials), f"{speed:.0f}x"])
    return Table(
        f"{TRIALS} targets 3-8 m away in any direction, with mirrored copies",
        ["looked ahead", "bend", "within .5 m", "way / straight, median", "90th percentile", "time, median", "worst miss",
         "against real time"],
        rows,
        ["Wanted: within .5 m in 98 %, median way 1.5 times the straight line or less, 50 times real time or faster."],
    )  # fmt: skip


def inside_turns() -> Table:
    """Targets inside the narrowest turn there is."""
    motions = [
        kx.performer.walk(seconds=8.0, fps=FPS).motion,
        kx.performer.walk(seconds=16.0, fps=FPS, route="circle").motion,
    ]
    rows = []
    for mirrored in (True, False):
        walks, ready = prepared(motions, mirrored)
        for bend in (0.0, BEND):
            trials = [to_target(walks, ready, seed, bend, 60.0, (1.0, 3.0))[0] for seed in range(TRIALS)]
            rows.append(["either side" if mirrored else "one side", f"{bend:g}°/m", *summary(trials)])
    return Table(
        f"{TRIALS} targets 1-3 m away, by performed walks straight on and round a circle of 2.7 m radius, 60 s at most",
        ["turns to", "bend", "within .5 m", "way / straight, median", "90th percentile", "time, median", "worst miss"],
        rows,
        ["Where the target lies inside the narrowest turn, one has to walk away from it and come back."],
    )


SIDES = {"ahead": (0.0, 45.0), "left": (45.0, 135.0), "behind": (135.0, 180.0), "right": (-135.0, -45.0)}
"""Degrees of the target's bearing at the start; ahead and behind to either side."""


def saved(without: Sequence[Trial], with_them: Sequence[Trial], low: float = 0.0, high: float = 180.0) -> str:
    """By how much the median time falls, of the targets that lie so at the start."""

    def median(trials: Sequence[Trial]) -> float:
        degrees = [np.degrees(t.bearing) for t in trials]
        inside = [low <= (d if low < 0.0 or (low, high) == SIDES["left"] else abs(d)) < high for d in degrees]
        return float(np.median([t.seconds for t, used in zip(trials, inside, strict=True) if used]))

    before = median(without)
    return f"{100 * (1 - median(with_them) / before):.0f} %" if np.isfinite(before) else "-"


def chirality(motions: Sequence[kx.Motion]) -> list[Table]:
    start, end = (round(s * motions[0].fps) for s in ONE_SIDED)
    one_sided = [motions[0][start:end], *read(STRAIGHT)]
    left, right = (
        [*_clips("dataset-2_walk_normal", 2), *_clips(f"dataset-2_walk-turn-{side}_normal", 3)]
        for side in ("left", "right")
    )
    circle = kx.performer.walk(seconds=16.0, fps=FPS, route="circle").motion
    on_and_round = [kx.performer.walk(seconds=8.0, fps=FPS).motion, circle]
    rows, gains = [], []
    for what, recordings in (
        ("all walks", motions),
        ("turns to the right only", one_sided),
        ("performed, a wide circle to the left only", on_and_round),
        ("Bandai-Namco, straight on and to the left", left),
        ("Bandai-Namco, straight on and to the right", right),
    ):
        for bend in (0.0, BEND):
            both = []
            for mirrored in (False, True):
                walks, ready = prepared(recordings, mirrored)
                both.append([to_target(walks, ready, seed, bend, 60.0)[0] for seed in range(TRIALS)])
                rows.append([what, f"{bend:g}°/m", "with" if mirrored else "without", *summary(both[-1])])
            gains.append(
                [what, f"{bend:g}°/m", saved(*both), *(saved(*both, low, high) for low, high in SIDES.values())]
            )
    return [
        Table(
            f"What mirrored copies are worth: {TRIALS} targets, 60 s at most",
            ["recordings", "bend", "mirrored", "within .5 m", "way / straight, median", "90th percentile",
             "time, median", "worst miss"],
            rows,
            [f"Turns to the right only: 91_01 from {ONE_SIDED[0]:g} to {ONE_SIDED[1]:g} s, and straight walks. All walks turn "
             "to either side as they are (91_01 walks a figure of eight): mirrored copies add no direction that was missing."],
        ),
        Table(
            "By how much the median time falls with mirrored copies, by where the target lies at the start",
            ["recordings", "bend", "all", *SIDES],
            gains,
            ["Wanted: 15 % over all. What is gained lies on the side to which the recordings do not turn; the median over all "
             "directions also counts the targets ahead and on the side to which they do, which are as near as they were."],
        ),
    ]  # fmt: skip


def lines() -> dict[str, NDArray[np.float64]]:
    around = np.linspace(0.0, 2.0 * np.pi, 400)
    spiral = np.linspace(0.0, 6.0 * np.pi, 600)
    radius = 1.0 + 3.0 * spiral / spiral[-1]
    return {
        "figure of eight, 5 x 8 m": np.stack([2.5 * np.sin(2 * around), 4.0 * np.sin(around)], axis=1),
        "spiral of 3 rounds, radius 1-4 m": np.stack([radius * np.cos(spiral) - 1.0, radius * np.sin(spiral)], axis=1),
        "square of 4 m": np.array([[0, 0], [0, 4], [4, 4], [4, 0], [0, 0]], dtype=np.float64),
    }


def routes(motions: Sequence[kx.Motion]) -> Table:
    walks, ready = prepared(motions, True)
    rows = []
    for name, line in lines().items():
        route = Route(line)
        points = route.sampled()
        for bend in (0.0, BEND):
            off, left_out, pace, finished = [], [], [], 0
            for seed in range(ROUTE_SEEDS):
                course = perform_paths(walks, route, 4.0 * route.length, seed, finish=True, bend=bend, prepared=ready)
                gaps = np.abs((course.ground[:, 1] + 1j * course.ground[:, 0])[:, None] - points)
                off.append(gaps.min(axis=1))
                left_out.append(gaps.min(axis=0).max())
                pace.append(route.length / course.seconds)
                finished += course.attained
            medians = [float(np.median(o)) for o in off]
            rows.append(
                [name, f"{bend:g}°/m", f"{finished} of {ROUTE_SEEDS}", f"{np.median(medians):.2f} m",
                 f"{max(medians):.2f} m", f"{np.median([np.quantile(o, 0.95) for o in off]):.2f} m",
                 f"{np.median(left_out):.2f} m", f"{np.median(pace):.2f} m/s"]
            )  # fmt: skip
    return Table(
        f"Routes, {ROUTE_SEEDS} seeds each",
        ["route", "bend", "to the end", "median deviation", "worst seed's", "95th percentile", "point of it left out most",
         "progress"],
        rows,
        ["Deviation: from every frame's root to the nearest point of the line. The pelvis itself sways some 2-4 cm."],
    )  # fmt: skip


def performed(motions: Sequence[kx.Motion]) -> Table:
    """The same asked of `kinesics.perform`, and measured on the movement that comes of it."""
    misses, ratios = [], []
    rng = np.random.default_rng(2012)
    for seed in range(PERFORMED):
        metres, bearing = rng.uniform(3.0, 8.0), rng.uniform(-np.pi, np.pi)
        place = metres * np.array([np.sin(bearing), np.cos(bearing)])
        way = _root(kx.perform(motions, target=(float(place[0]), float(place[1])), fps=FPS, seed=seed))
        off = np.hypot(*(way - place).T)
        there = int(np.argmax(off <= 0.5)) if (off <= 0.5).any() else len(way) - 1
        misses.append(off.min())
        ratios.append(np.hypot(*np.diff(way[: there + 1], axis=0).T).sum() / metres)
    rows = [
        [f"{PERFORMED} targets 3-8 m away", f"{100.0 * np.mean(np.array(misses) <= 0.5):.0f} % within .5 m",
         f"worst {max(misses):.2f} m", f"way / straight {np.median(ratios):.2f}"]
    ]  # fmt: skip
    for name, line in lines().items():
        route = Route(line)
        points = route.sampled()
        medians, worst = [], []
        for seed in range(PERFORMED_ROUTES):
            way = _root(kx.perform(motions, route=line, fps=FPS, seed=seed))
            off = np.abs((way[:, 1] + 1j * way[:, 0])[:, None] - points).min(axis=1)
            medians.append(np.median(off))
            worst.append(off.max())
        rows.append([name, f"median deviation {np.median(medians):.2f} m", f"worst seed's {max(medians):.2f} m",
                     f"farthest, median {np.median(worst):.2f} m, worst {max(worst):.2f} m"])  # fmt: skip
    return Table("As performed, feet planted", ["wish", "", "", ""], rows)


def _root(motion: kx.Motion) -> NDArray[np.float64]:
    """Where it is over the floor: x, z in metres, shape (frames, 2)."""
    return motion.root_positions[:, [0, 2]]


def decisions(motions: Sequence[kx.Motion]) -> Table:
    walks = afoot(network(repertoire(motions, fps=FPS)))
    began = time.perf_counter()
    ready = prospects(walks)
    built = time.perf_counter() - began
    began = time.perf_counter()
    ready.to_go(RADIUS, float(np.radians(BEND)))
    tables = time.perf_counter() - began
    goals: dict[str, Goal | list[Goal] | None] = {
        "none": None,
        "target, far": Target((9_000.0, 0.0)),
        "targets, near": Targets(
            [tuple(p) for p in np.random.default_rng(0).uniform(-6.0, 6.0, (DECISIONS, 2)).tolist()]
        ),
        "route": Route(lines()["figure of eight, 5 x 8 m"]),
        "target, novelty, economy": [Target((9_000.0, 0.0)), Novelty(0.1), Economy(0.1)],
    }
    rows = []
    for name, goal in goals.items():
        controller = Controller(walks, goal, prepared=ready)
        wall, cpu = [], []
        for _ in range(DECISIONS):
            w, c = time.perf_counter(), time.thread_time()
            controller.step()
            wall.append(time.perf_counter() - w)
            cpu.append(time.thread_time() - c)
        rows.append(
            [name, f"{1e3 * np.median(wall):.2f} ms", f"{1e3 * np.quantile(wall, 0.99):.2f} ms",
             f"{1e3 * np.median(cpu):.2f} ms", f"{1e3 * np.quantile(cpu, 0.99):.2f} ms"]
        )  # fmt: skip
    return Table(
        f"Time for a decision: {len(walks)} paths, {len(ready.sequence):,} composites, built in {built:.1f} s; seconds to go to "
        f"a target, tables built in {tables:.1f} s",
        ["goal", "median", "99th percentile", "processor time, median", "99th percentile"],
        rows,
        ["Wanted: 1 ms. Processor time leaves out what other programs took of the core meanwhile."],
    )


def ready() -> list[Table]:
    """From the files of many short recordings to a motion graph that paths can be chosen from."""
    data = data_folder()
    if data is None:
        return []
    rows = []
    with zipfile.ZipFile(data / "bandai-namco" / "clips.zip") as archive, tempfile.TemporaryDirectory() as folder:
        names = sorted(n for n in archive.namelist() if n.endswith(".bvh"))
        random.Random(0).shuffle(names)
        for minutes in MINUTES:
            files: list[str] = []
            seconds = 0.0
            while seconds < 60.0 * minutes:
                files.append(archive.extract(names[len(files)], folder))
                seconds += kx.read(files[-1]).duration
            got = [measure([sys.executable, "-c", READY, *files], folder) for _ in range(READY_RUNS)]
            rows.append(
                (
                    f"{seconds / 60.0:.1f} minutes, {len(files)} files",
                    *(f"{statistics.median(run[k] for run in got):.1f}" for k in (0, 1)),
                    f"{max(run[2] for run in got):.0f}",
                    "≤ 60 s" if minutes == 10 else "",
                )
            )
    return [
        Table(
            "From files at 30 frames a second to a ready motion graph, start-up and tables of what lies ahead included",
            ("recordings (Bandai-Namco)", "seconds", "CPU s", "peak MB", "target"),
            rows,
            (f"Median of {READY_RUNS} runs.",),
        )
    ]


def run() -> list[Table]:
    if data_folder() is None:
        return []
    motions = read(WALKS)
    return [
        targets(motions),
        inside_turns(),
        *chirality(motions),
        routes(motions),
        performed(motions),
        decisions(motions),
        *ready(),
    ]


if __name__ == "__main__":
    main(
        run,
        parts={
            "decisions": lambda: [decisions(read(WALKS))] if data_folder() else [],
            "performed": lambda: [performed(read(WALKS))] if data_folder() else [],
            "chirality": lambda: chirality(read(WALKS)) if data_folder() else [],
            "ready": ready,
        },
    )
