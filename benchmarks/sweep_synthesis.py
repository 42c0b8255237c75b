"""Performing, over many recordings and wishes drawn by seed: where does it break?

Every case is a few recordings (CMU as AMC and BVH, Bandai-Namco clips, the performer's movements on usual and odd rigs; one
alone, or several of different subjects, formats and frame rates) and a wish (a place, a line, a state, a word, a time; mirrored
or not, backwards, at another frame rate, on another's skeleton). It is performed, measured (`embodiment.quality`), written,
read again, and every third is performed once more from the command line; what is beyond issue's lines (`LINES`) is told. A case
is the same for the same seed, group and number, whatever else is run.

    python benchmarks/sweep_synthesis.py --out rows.jsonl [--groups cmu,performer] [--cases 0:20] [--seed 1] [--stop-after 150]
    python benchmarks/sweep_synthesis.py --out rows.jsonl --summary

Rows that FILE holds are not done again, so that it can be stopped at any time and goes on where it was.
"""

from __future__ import annotations

import argparse
import contextlib
import functools
import io
import json
import math
import random
import sys
import tempfile
import time
import traceback
import warnings
import zipfile
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

import kinesics as kx
from harness import Table, data_folder
from kinesics.body.skeleton import EndSite, Skeleton
from kinesics.cli.app import run as command_line
from kinesics.formats import write
from kinesics.geometry import quaternion
from kinesics.report.performances import save_performance
from kinesics.similarity import paired_distance
from kinesics.synthesis import goals
from kinesics.synthesis.embodiment import quality
from kinesics.synthesis.piece import Piece

Case = dict[str, Any]
Row = dict[str, Any]
Array = NDArray[np.float64]

LINES: Final[dict[str, tuple[float, str]]] = {
    "slides": (0.0, "contacts that slide more than 1 cm, share"),
    "ground time": (0.1, "time on the ground, off by that share of the recordings'"),
    "floor": (0.01, "below the floor, m"),
    "D": (1.0, "D to the nearest source frame, in what was accepted at a transition"),
    "range": (1.0, "beyond a joint's range, degrees"),
    "depth": (0.01, "limbs deeper in the body than recorded, m"),
    "turning": (1.0, "leaps of angular velocity added, in the recordings' p99"),
    "acceleration": (1.0, "accelerations added, in the recordings' p99"),
    "provenance": (1.0, "D to the very frame that is named, in what was accepted"),
    "file": (1e-3, "written and read again, m"),
}
"""Largest value of each measure, and what it is."""
FORMATS: Final = (".bvh", ".amc", ".glb", ".npz")
MOST_FRAMES: Final = 4000
"""Of all recordings of a case, at its frame rate: what takes longer is performed at 30 frames a second."""
BRIEF: Final = 0.1
"""Seconds on the ground, more or less, that are no matter."""
RIGS: Final = ("plain", "no toes", "fingers", "z up", "metres", "z up in millimetres", "facing x", "four joints")
STATES: Final = ("walk", "run", "side_kicks", "sun_salutation", "kata", "jumping_jacks")


# --- what is drawn


def routes(rng: random.Random) -> dict[str, list[list[float]]]:
    """Lines on the floor of every kind."""
    size = rng.uniform(1.5, 4.0)
    around = [2.0 * math.pi * k / 40 for k in range(41)]
    return {
        "straight": [[0.0, 0.0], [rng.uniform(-2, 2), 2 * size]],
        "backwards": [[0.0, 0.0], [0.0, -size]],
        "zigzag": [[size * (k % 2) * 0.5, 0.7 * size * k] for k in range(5)],
        "circle": [[size * (1 - math.cos(a)), size * math.sin(a)] for a in around],
        "self-crossing": [[size * math.sin(2 * a), 1.5 * size * math.sin(a)] for a in around],
        "tiny": [[0.0, 0.0], [0.1, 0.1], [0.0, 0.2]],
        "very long": [[20 * math.sin(k), 20.0 * k] for k in range(6)],
        "doubled corners": [[0.0, 0.0], [0.0, 0.0], [0.0, size], [0.0, size], [0.0, 0.0]],
    }


def wish_of(rng: random.Random) -> Case:
    """What is wished for, and how."""
    out: Case = {}
    kind = rng.choice(
        ["nothing", "near", "target", "target", "far", "behind", "on the spot", "route", "route", "goal", "word"]
    )
    bearing = rng.uniform(-math.pi, math.pi)
    metres = {"near": 0.3, "target": rng.uniform(1.0, 8.0), "far": 30.0, "on the spot": 0.0}
    if kind in metres:
        out["target"] = [round(metres[kind] * math.sin(bearing), 2), round(metres[kind] * math.cos(bearing), 2)]
        if rng.random() < 0.3 or kind == "near":
            out["radius"] = rng.choice([0.15, 0.3, 1.0])
    elif kind == "behind":
        out["target"] = [0.0, -round(rng.uniform(2, 5), 2)]
    elif kind == "route":
        lines = routes(rng)
        name = rng.choice(sorted(lines))
        out["route"] = [[round(x, 3), round(z, 3)] for x, z in lines[name]]
    elif kind == "goal":
        out["goal"] = rng.choice(["moving", "speed", "heading", "several", "own"])
    elif kind == "word":
        out["favour"] = rng.choice(["A", "A*", "cyclic-antiphase", "walk", "B"])
    if kind in ("nothing", "goal", "word") or rng.random() < 0.2:
        out["seconds"] = rng.choice([1.0, 3.0, 8.0, 20.0, 20.0, 40.0, 120.0])
    if rng.random() < 0.25:
        out["mirrored"] = False
    if rng.random() < 0.2:
        out["backwards"] = True
    if rng.random() < 0.4:
        out["fps"] = rng.choice([24, 25, 30, 60, 120, 240])
    if rng.random() < 0.08:
        out["threshold"] = rng.choice([0.001, 0.01, 0.05, 0.3])
    if rng.random() < 0.15:
        out["bend"] = rng.choice([0.0, 15.0])
    if rng.random() < 0.1:
        out["linger"], out["seconds"] = True, 15.0
    out["seed"] = rng.randrange(1000)
    return out


def made(rng: random.Random, movement: str | None = None) -> Case:
    """A movement of the performer's, and on which rig."""
    movement = movement or rng.choice([n for n in kx.performer.NAMES if n != "stand"])
    out: Case = {
        "movement": movement,
        "fps": rng.choice([24, 30, 30, 60, 120]),
        "height": round(rng.uniform(1.2, 1.95), 2),
        "noise": rng.choice([0.0, 0.5, 0.5, 1.0]),
        "seed": rng.randrange(1000),
        "rig": rng.choice(RIGS) if rng.random() < 0.5 else "plain",
    }
    if out["rig"] == "four joints" and rng.random() < 0.8:
        out["rig"] = "plain"
    if movement in ("walk", "limp", "run"):
        out["route"] = rng.choice(["straight", "circle"])
        out["seconds"] = rng.choice([6, 12])
    return out


@functools.cache
def cmu_files() -> list[str]:
    folder = data_folder()
    return [] if folder is None else sorted(
        p.relative_to(folder).as_posix() for p in (folder / "cmu").rglob("*") if p.suffix in (".amc", ".bvh")
    )  # fmt: skip


@functools.cache
def clips() -> list[str]:
    folder = data_folder()
    if folder is None:
        return []
    with zipfile.ZipFile(folder / "bandai-namco" / "clips.zip") as archive:
        return sorted(n for n in archive.namelist() if n.endswith(".bvh"))


def subject(file: str) -> str:
    """Of a CMU file."""
    name = Path(file).stem.removeprefix("cgspeed_")
    return name.split("_")[0]


def _cmu(rng: random.Random, number: int) -> list[Any]:
    return [cmu_files()[number % len(cmu_files())]]


def _cmu_together(rng: random.Random, number: int) -> list[Any]:
    names = rng.sample(cmu_files(), len(cmu_files()))
    chosen: list[str] = []
    for name in names:
        if len(chosen) < rng.choice([2, 2, 3]) and subject(name) not in {subject(c) for c in chosen}:
            chosen.append(name)
    return list(chosen)


def _bandai(rng: random.Random, number: int) -> list[Any]:
    return [rng.choice(clips())]


def _bandai_together(rng: random.Random, number: int) -> list[Any]:
    first = rng.choice(clips())
    alike = [c for c in clips() if Path(c).stem.split("_")[0] == Path(first).stem.split("_")[0]]
    return [first, *rng.sample(alike, 2)]


def _bandai_gait(rng: random.Random, number: int) -> list[Any]:
    """Three that go about in one manner: most likely to join."""
    going = [c for c in clips() if "walk" in c or "run" in c]
    style = rng.choice(sorted({Path(c).stem.split("_")[2] for c in going}))
    return rng.sample([c for c in going if Path(c).stem.split("_")[2] == style], 3)


def _performer(rng: random.Random, number: int) -> list[Any]:
    return [made(rng)]


def _performer_together(rng: random.Random, number: int) -> list[Any]:
    movement = rng.choice(["walk", "walk", "run", "limp", "wave", "kata"])
    out: list[Any] = [made(rng, movement), made(rng, movement)]
    return [*out, made(rng)] if rng.random() < 0.5 else out


def _mixed(rng: random.Random, number: int) -> list[Any]:
    walks = [f for f in cmu_files() if subject(f) in ("02", "07", "16", "35", "91")]
    return [rng.choice(walks), made(rng, "walk"), rng.choice(clips())]


def _going(rng: random.Random, number: int) -> list[Any]:
    """One recording that goes about, to be gone far with: the same steps over and over."""
    going = [f for f in cmu_files() if subject(f) in ("02", "07", "09", "16", "35", "49", "91")]
    if number < len(going):
        return [going[number]]
    return [rng.choice([c for c in clips() if "walk" in c or "run" in c])]


def _states(rng: random.Random, number: int) -> list[Any]:
    if cmu_files() and rng.random() < 0.5:
        return [rng.choice([f for f in cmu_files() if "135_02" not in f])]
    return [{**made(rng, rng.choice(STATES)), "fps": 30, "noise": 0.0}]


GROUPS: Final[dict[str, tuple[Callable[[random.Random, int], list[Any]], bool, int]]] = {
    "cmu": (_cmu, True, 48),
    "cmu together": (_cmu_together, True, 40),
    "bandai": (_bandai, True, 60),
    "bandai together": (_bandai_together, True, 30),
    "bandai gaits": (_bandai_gait, True, 30),
    "performer": (_performer, False, 60),
    "performer together": (_performer_together, False, 40),
    "mixed": (_mixed, True, 20),
    "far": (_going, True, 30),
    "states": (_states, False, 30),
}
"""How recordings are chosen, whether it needs real ones, and how many cases are usual."""


def case(group: str, number: int, seed: int) -> Case:
    """The same for the same group, number and seed."""
    rng = random.Random(f"{seed}/{group}/{number}")
    files = GROUPS[group][0](rng, number)
    wish: Case = wish_of(rng)
    if group in ("bandai", "bandai together", "performer") and rng.random() < 0.7:  # most of these stay in place
        wish = {k: v for k, v in wish.items() if k not in ("target", "route", "radius", "linger")}
    if group == "states":
        wish = {k: v for k, v in wish.items() if k in ("mirrored", "seed", "backwards")} | {"states": rng.random()}
    elif group == "far":
        wish = {k: v for k, v in wish.items() if k in ("mirrored", "seed", "fps")}
        wish |= rng.choice(
            [{"target": [rng.choice([-30, 5, 40]), rng.choice([-90, 100])]}, {"goal": "own", "seconds": 120.0}]
        )
    elif rng.random() < 0.15:
        wish["skeleton_of"] = rng.choice(cmu_files()) if cmu_files() and rng.random() < 0.5 else made(rng, "walk")
    return {"id": f"{group}/{number}/{seed}", "group": group, "files": files, "wish": wish, "format": FORMATS[number % 4],
            "again": number % 3 == 0}  # fmt: skip


# --- recordings


def rigged(motion: kx.Motion, rig: str) -> kx.Motion:
    """The same movement on an odd rig."""
    if rig == "no toes":
        keep = [j for j, name in enumerate(motion.skeleton.joint_names) if not name.endswith("ToeBase")]
        return _only(motion, keep)
    if rig == "four joints":
        return _only(motion, [motion.skeleton.find(n) for n in ("Hips", "Spine", "LeftUpLeg", "RightUpLeg")])
    if rig == "fingers":
        return _with_fingers(motion)
    if rig == "facing x":
        return _turned(motion, quaternion.from_rotvec(np.array([0.0, 0.5 * math.pi, 0.0])))
    if rig.startswith("z up"):
        motion = _turned(motion, quaternion.from_rotvec(np.array([0.5 * math.pi, 0.0, 0.0])))
    # a BVH is written in centimetres
    times = {"metres": 0.01, "z up in millimetres": 10.0}
    return _scaled(motion, times[rig]) if rig in times else motion


def _only(motion: kx.Motion, keep: list[int]) -> kx.Motion:
    skeleton = motion.skeleton
    place = {j: k for k, j in enumerate(keep)}

    def above(j: int) -> int:
        parent = skeleton.parents[j]
        return place.get(parent, -1) if parent < 0 or parent in place else above(parent)

    leaves = [j for j in keep if not any(skeleton.parents[c] == j for c in keep)]
    sites = tuple(EndSite(place[s.parent], s.offset) for s in skeleton.end_sites if s.parent in place)
    lacking = [j for j in leaves if place[j] not in {s.parent for s in sites}]
    for j in lacking:
        first = next((c for c in skeleton.children[j]), None)
        offset = (0.0, -0.1, 0.0) if first is None else tuple(float(v) for v in skeleton.offsets[first])
        sites += (EndSite(place[j], (offset[0], offset[1], offset[2])),)
    made_of = Skeleton(
        tuple(skeleton.joint_names[j] for j in keep), tuple(above(j) for j in keep), skeleton.offsets[keep], sites
    )
    return kx.Motion(made_of, motion.rotations[:, keep], motion.root_positions, motion.fps, name=motion.name)


def _with_fingers(motion: kx.Motion) -> kx.Motion:
    skeleton = motion.skeleton
    names, parents = list(skeleton.joint_names), list(skeleton.parents)
    offsets, sites = skeleton.offsets.tolist(), list(skeleton.end_sites)
    for side in ("Left", "Right"):
        hand = skeleton.find(f"{side}Hand")
        sites = [s for s in sites if s.parent != hand]
        along = next(np.array(s.offset) for s in skeleton.end_sites if s.parent == hand)
        for finger, z in (("Thumb", 0.03), ("Index", 0.02), ("Middle", 0.0), ("Ring", -0.02), ("Pinky", -0.03)):
            parent = hand
            for k in (1, 2):
                names.append(f"{side}Hand{finger}{k}")
                parents.append(parent)
                offsets.append((along * (0.5 if k == 1 else 0.25) + [0.0, 0.0, z if k == 1 else 0.0]).tolist())
                parent = len(names) - 1
            sites.append(EndSite(parent, tuple((0.2 * along).tolist())))
    body = Skeleton(tuple(names), tuple(parents), np.array(offsets), tuple(sites))
    extra = body.joint_count - skeleton.joint_count
    rotations = np.concatenate([motion.rotations, quaternion.identity((motion.frame_count, extra))], axis=1)
    curl = 0.3 + 0.2 * np.sin(np.arange(motion.frame_count) / motion.fps)
    bent = quaternion.from_rotvec(np.stack([0 * curl, 0 * curl, curl], axis=-1))
    rotations[:, skeleton.joint_count :] = bent[:, None]
    return kx.Motion(body, rotations, motion.root_positions, motion.fps, name=motion.name)


def _turned(motion: kx.Motion, turn: Array) -> kx.Motion:
    """The very movement in other axes: rest pose, rotations and places all turned."""
    skeleton = motion.skeleton
    back = quaternion.conjugate(turn)
    sites = tuple(
        EndSite(s.parent, tuple(float(v) for v in quaternion.rotate(turn, np.array(s.offset))))
        for s in skeleton.end_sites
    )
    body = Skeleton(skeleton.joint_names, skeleton.parents, quaternion.rotate(turn, skeleton.offsets), sites)
    return kx.Motion(
        body,
        quaternion.multiply(quaternion.multiply(turn, motion.rotations), back),
        quaternion.rotate(turn, motion.root_positions),
        motion.fps,
        name=motion.name,
    )


def _scaled(motion: kx.Motion, times: float) -> kx.Motion:
    skeleton = motion.skeleton
    sites = tuple(EndSite(s.parent, tuple(times * v for v in s.offset)) for s in skeleton.end_sites)
    body = Skeleton(skeleton.joint_names, skeleton.parents, times * skeleton.offsets, sites)
    return kx.Motion(body, motion.rotations, times * motion.root_positions, motion.fps, name=motion.name)


def file_of(what: Any, folder: Path) -> Path:
    """A recording's file; what is not there yet is unpacked or performed into ``folder``."""
    data = data_folder()
    if isinstance(what, dict):
        words = [str(v).replace(" ", "-") for v in what.values()]
        path = folder / f"{'_'.join(words)}.bvh"
        if not path.exists():
            more = {k: what[k] for k in ("route", "seconds") if k in what}
            done = kx.performer.perform(what["movement"], fps=what["fps"], body=what["height"], noise_degrees=what["noise"],
                                        noise_kind="smooth", seed=what["seed"], **more)  # fmt: skip
            write(rigged(done.motion, what["rig"]), path)
        return path
    assert data is not None
    if what.startswith("cmu/"):
        return data / what
    path = folder / Path(what).name
    if not path.exists():
        with zipfile.ZipFile(data / "bandai-namco" / "clips.zip") as archive:
            path.write_bytes(archive.read(what))
    return path


# --- what is done


class _Fast:
    """A feature of the user's own: metres a second, as quick as it goes."""

    weight = 1.0

    def values(self, network: Any) -> Any:
        return np.hypot(*network.displacement.T) / network.duration

    def wish(self, now: Any) -> Any:
        return 2.0


def goal_of(name: str) -> Any:
    return {
        "moving": lambda: goals.MovingTarget(lambda t: (2.0 * math.sin(0.3 * t), 2.0 - 2.0 * math.cos(0.3 * t))),
        "speed": lambda: goals.Speed(1.0),
        "heading": lambda: goals.Heading(math.pi / 2),
        "several": lambda: [goals.Targets([(1.0, 2.0), (-1.0, 4.0)]), goals.Novelty(0.1)],
        "own": lambda: _Fast(),
    }[name]()


def options(wish: Case, motions: Sequence[kx.Motion], folder: Path) -> dict[str, Any]:
    """As `kinesics.performance` takes them."""
    out = {k: v for k, v in wish.items() if k not in ("goal", "skeleton_of", "states")}
    if "goal" in wish:
        out["goal"] = goal_of(wish["goal"])
    if "skeleton_of" in wish:
        out["skeleton"] = kx.read(file_of(wish["skeleton_of"], folder))
    if "states" in wish:
        labels = [s.label for s in kx.graph(motions).racemic().states]
        pairs = [(a, b) for a in labels for b in labels]
        out["from_state"], out["to_state"] = pairs[int(wish["states"] * len(pairs))]
    if "fps" not in out:
        fps = motions[0].fps
        if sum(m.duration for m in motions) * fps > MOST_FRAMES:
            out["fps"] = 30.0
    elif sum(m.duration for m in motions) * out["fps"] > MOST_FRAMES:
        out["fps"] = 30.0
    return out


def arguments(
    files: Sequence[Path], given: dict[str, Any], folder: Path, out: Path, skeleton_of: Path | None
) -> list[str]:
    """The same on the command line."""
    words = ["perform", *map(str, files), "--out", str(out), "--overwrite"]
    plain = {"radius": "within", "from_state": "from", "to_state": "to"}
    for key, value in given.items():
        name = f"--{plain.get(key, key)}"
        if key == "mirrored":
            words += [] if value else ["--no-mirror"]
        elif key in ("backwards", "linger"):
            words += [name] if value else []
        elif key == "target":
            words += [name, f"{value[0]},{value[1]}"]
        elif key == "route":
            line = folder / "line.csv"
            line.write_text("x,z\n" + "".join(f"{x},{z}\n" for x, z in value), encoding="utf-8")
            words += [name, str(line)]
        elif key == "skeleton":
            words += ["--skeleton-of", str(skeleton_of)]
        else:
            words += [name, str(value)]
    return words


def provenance(piece: Piece, motions: Sequence[kx.Motion]) -> float:
    """Largest D of a frame of no transition to the frame of the recording that is named."""
    where = piece.provenance
    own = kx.poses(piece.motion).quaternions
    worst = 0.0
    for k, motion in enumerate(motions):
        at = np.flatnonzero((where.recording == k) & ~where.transition)
        if not len(at):
            continue
        body = piece.motion.skeleton
        same = motion.skeleton.same_tree(body) and _rest_alike(motion.skeleton.offsets, body.offsets)
        # what a rest pose does not tell is seen in the recording: alike for all on one skeleton
        poses = kx.poses(motion.replace(skeleton=body) if same else motion)
        best = np.full(len(at), np.inf)
        for frame in (np.floor(where.source_frame[at]), np.ceil(where.source_frame[at])):
            chosen = np.clip(frame.astype(int), 0, motion.frame_count - 1)
            there = np.where(
                where.mirrored[at][:, None, None], poses.mirror().quaternions[chosen], poses.quaternions[chosen]
            )
            best = np.minimum(best, paired_distance(own[at], there))
        worst = max(worst, float(best.max()))
    return worst


def _rest_alike(a: Array, b: Array) -> bool:
    """Whether bones of two skeletons lie alike at rest, of whatever length."""
    sizes = np.linalg.norm(a, axis=-1) * np.linalg.norm(b, axis=-1)
    return bool((np.einsum("ji,ji->j", a, b) >= 0.95 * sizes - 1e-6).all())


def measured(piece: Piece, motions: Sequence[kx.Motion]) -> dict[str, float]:
    """Everything that has a line."""
    net = piece.network
    q = quality.measure(piece.performance, net.repertoire, threshold=net.threshold)
    share = q.contact_share
    # of a second or two a frame at either end is more than any share
    off = max(0.0, abs(share.performance - share.recordings) - BRIEF / piece.motion.duration)
    accepted = max(net.threshold, 1e-6)
    return {
        "slides": q.slides_over.performance,
        "slides recorded": q.slides_over.recordings,
        "slide worst": q.slide_worst.performance,
        "ground time": off / max(share.recordings, 0.05),
        "on the ground": share.performance,
        "on the ground as recorded": share.recordings,
        "floor": q.penetration.performance,
        "D": q.distance.performance / accepted,
        "range": math.degrees(q.joint_excess),
        "depth": q.collision,
        "turning": q.turning_added,
        "acceleration": q.acceleration_added,
        "provenance": provenance(piece, motions) / accepted,
        "contacts": q.contacts,
        "cuts": q.cuts,
    }


def _there_and_back(piece: Piece, path: Path) -> float:
    """Metres that the farthest joint is off after writing and reading."""
    save_performance(piece, path, overwrite=True)
    # what lies or props itself up throughout could not be told from what stands under another axis
    again = kx.read(path, up="y") if any("--up y" in doubt for doubt in kx.read(path).warnings) else kx.read(path)
    if again.frame_count != piece.motion.frame_count or abs(again.fps - piece.motion.fps) > 1e-3:
        return math.inf
    if again.skeleton.parents != piece.motion.skeleton.parents:
        return math.inf
    return float(np.linalg.norm(again.positions() - piece.motion.positions(), axis=-1).max())


def perform(what: Case, folder: Path) -> Row:
    """One case done: its row."""
    began = time.process_time()
    row: Row = {k: what[k] for k in ("id", "group", "files", "wish")}
    try:
        with warnings.catch_warnings(record=True) as heard:
            warnings.simplefilter("always")
            row |= _performed(what, folder)
        numeric = sorted({str(w.message)[:100] for w in heard if issubclass(w.category, RuntimeWarning)})
        if numeric:
            row["beyond"] = {**row.get("beyond", {}), "warned": numeric}
    except Exception:
        row |= {"outcome": "defect", "told": traceback.format_exc(limit=-6)}
    row["processor_s"] = round(time.process_time() - began, 1)
    return row


def _performed(what: Case, folder: Path) -> Row:
    files = [file_of(f, folder) for f in what["files"]]
    wish = what["wish"]
    try:
        motions = [kx.read(f) for f in files]
        given = options(wish, motions, folder)
        began = time.process_time()
        piece = kx.performance(motions, **given)
        took = time.process_time() - began
    except kx.InputError as error:
        return {"outcome": "refused", "told": str(error)}
    row: Row = {"outcome": "performed", "performing_s": round(took, 1), "length_s": round(piece.motion.duration, 1)}
    for name, key in (("fps", "fps"), ("from_state", "from"), ("to_state", "to")):
        if name in given:
            row[key] = given[name]
    values = measured(piece, motions)
    # another format of the same name would be another movement's, beside the provenance of the last
    path = folder / f"out-{what['format'][1:]}{what['format']}"
    values["file"] = _there_and_back(piece, path)
    beyond: dict[str, Any] = {
        k: round(v, 4) for k, v in values.items() if k in LINES and not v <= LINES[k][0] * (1 + 1e-6)
    }
    motion = piece.motion
    if not (np.isfinite(motion.rotations).all() and np.isfinite(motion.root_positions).all()):
        beyond["not finite"] = True
    attainable = any(k in given for k in ("target", "route", "to_state")) or wish.get("goal") == "several"
    told = "; ".join(motion.warnings[-1:])
    if attainable and not piece.attained and "take longer than" not in told:
        beyond["attained"] = told or "not, and no word of it"
    if "radius" in given and piece.attained and piece.nearest is not None and piece.nearest > given["radius"] + 1e-9:
        beyond["attained"] = f"said to be, {piece.nearest:.2f} m away"
    if what["again"]:
        beyond |= _once_more(what, files, given, piece, motions, folder)
    row |= {"values": {k: round(v, 5) for k, v in values.items()}, "beyond": beyond, "doubts": list(motion.warnings)}
    return row


def _once_more(
    what: Case, files: list[Path], given: dict[str, Any], piece: Piece, motions: list[kx.Motion], folder: Path
) -> dict[str, Any]:
    """From the command line where it can be said there."""
    if "goal" in given:
        again = kx.performance([kx.read(f) for f in files], **{**given, "goal": goal_of(what["wish"]["goal"])}).motion
    else:
        out = folder / "again.npz"
        skeleton_of = file_of(what["wish"]["skeleton_of"], folder) if "skeleton_of" in what["wish"] else None
        said, erred = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(said), contextlib.redirect_stderr(erred):
            code = command_line(arguments(files, given, folder, out, skeleton_of))
        if code != 0:
            return {"command line": f"{code}: {erred.getvalue()[-400:]}"}
        again = kx.read(out)
    same = np.array_equal(again.rotations, piece.motion.rotations) and np.array_equal(
        again.root_positions, piece.motion.root_positions
    )
    return {} if same else {"again": "another movement by the same seed"}


# --- what is told


def cases(groups: Sequence[str], numbers: range | None, seed: int) -> Iterator[Case]:
    """In turn of every group, so that whatever is done first goes over all."""
    usable = [g for g in groups if not GROUPS[g][1] or data_folder() is not None]
    spans = {g: numbers if numbers is not None else range(GROUPS[g][2]) for g in usable}
    for k in range(max((len(s) for s in spans.values()), default=0)):
        for group in usable:
            if k < len(spans[group]):
                yield case(group, spans[group][k], seed)


def rows_of(file: Path) -> list[Row]:
    """The last row of every case."""
    text = file.read_text(encoding="utf-8") if file.exists() else ""
    rows = [json.loads(line) for line in text.splitlines()]
    return list({row["id"]: row for row in rows}.values())


def summary(rows: Sequence[Row]) -> list[Table]:
    """How many of each group, and what lay beyond which line."""
    done = [r for r in rows if r["outcome"] == "performed"]
    groups = [g for g in GROUPS if any(r["group"] == g for r in rows)]
    per_group = []
    for group in groups:
        of = [r for r in rows if r["group"] == group]
        good = [r for r in of if r["outcome"] == "performed"]
        per_group.append(
            [group, str(len(of)), str(sum(r["outcome"] == "defect" for r in of)), str(sum(r["outcome"] == "refused" for r in of)),
             str(len(good)), str(sum(not r["beyond"] for r in good)), f"{np.median([r['processor_s'] for r in of]):.0f} s"]
        )  # fmt: skip
    per_line = []
    for name in dict.fromkeys([*LINES, *(k for r in done for k in r["beyond"])]):
        bad = [r for r in done if name in r["beyond"]]
        values = [r["values"][name] for r in done if name in r["values"]]
        per_line.append(
            [name, LINES[name][1] if name in LINES else "", f"{LINES[name][0]:g}" if name in LINES else "",
             f"{len(bad)} of {len(done)}", f"{np.median(values):.3g}" if values else "",
             f"{np.quantile(values, 0.9):.3g}" if values else "", f"{max(values):.3g}" if values else ""]
        )  # fmt: skip
    return [
        Table(
            "Cases",
            [
                "recordings",
                "cases",
                "defects",
                "refused in words",
                "performed",
                "within all lines",
                "processor time, median",
            ],
            per_group,
        ),
        Table("Lines", ["measure", "what", "at most", "beyond", "median", "90th percentile", "worst"], per_line),
    ]


def main(given: Sequence[str] | None = None) -> None:
    """See the top."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, required=True, metavar="FILE")
    parser.add_argument("--groups", default=",".join(GROUPS), metavar="A,B")
    parser.add_argument("--cases", metavar="FROM:TO", help="numbers of each group; the usual ones unless given")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--stop-after", type=float, default=math.inf, metavar="SECONDS")
    parser.add_argument("--again", action="store_true", help="do also those that FILE holds")
    parser.add_argument("--summary", action="store_true")
    told = parser.parse_args(given)
    if told.summary:
        for table in summary(rows_of(told.out)):
            print(table.text())
        return
    numbers = range(*map(int, told.cases.split(":"))) if told.cases else None
    there = set() if told.again else {row["id"] for row in rows_of(told.out)}
    began = time.monotonic()
    folder = Path(tempfile.mkdtemp(prefix="kinesics-sweep-"))
    for what in cases(told.groups.split(","), numbers, told.seed):
        if what["id"] in there:
            continue
        if time.monotonic() - began > told.stop_after:
            break
        row = perform(what, folder)
        with told.out.open("a", encoding="utf-8") as file:
            file.write(json.dumps(row, ensure_ascii=False) + "\n")
        said = row.get("beyond") or row.get("told", "")[-300:] or "as it should be"
        print(f"{row['id']}: {row['outcome']}, {row['processor_s']} s: {said}", flush=True)
    sys.stdout.flush()


if __name__ == "__main__":
    main()
