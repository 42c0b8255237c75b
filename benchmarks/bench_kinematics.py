"""Forward kinematics: frames a second, against pymotion and NumPy.

    python benchmarks/bench_kinematics.py [--json FILE]

World positions and orientations of all joints of a real skeleton of some thirty joints, from quaternions relative to the
parents. pymotion runs in the environment of the peers and returns rotation matrices, which it makes as part of its work.
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np

import kinesics as kx
from harness import Table, data_folder, in_turn, main
from kinesics.body import kinematics
from kinesics.body.skeleton import Skeleton
from kinesics.geometry import quaternion
from peer import Peer, PeerMissingError

FRAMES = 20_000

PYMOTION = """
import sys
import numpy as np
from pymotion.ops import skeleton
given = np.load(sys.argv[1])
rotations, roots, offsets, parents = (given[k] for k in ("rotations", "roots", "offsets", "parents"))
def job():
    return skeleton.fk(rotations, roots, offsets, parents)
positions = job()[0]
assert np.abs(positions - given["expected"]).max() < 1e-6, "positions differ"
"""


def movement() -> tuple[Skeleton, np.ndarray, np.ndarray, str]:
    """A skeleton, rotations (frames, joints, 4), root positions (frames, 3), and where they come from."""
    folder = data_folder()
    files = [] if folder is None else sorted((folder / "cmu").glob("*/*.amc"))
    if files:
        motion = kx.read(files[0])
        repeats = -(-FRAMES // len(motion))
        rotations = np.tile(motion.rotations, (repeats, 1, 1))[:FRAMES]
        roots = np.tile(motion.root_positions, (repeats, 1))[:FRAMES]
        return motion.skeleton, rotations, roots, f"CMU {files[0].stem}, {len(motion)} frames repeated"
    rng = np.random.default_rng(1)
    parents = (-1, *(max(0, j - 1 - int(rng.integers(0, 4))) for j in range(1, 31)))
    skeleton = Skeleton(tuple(f"joint{j}" for j in range(31)), parents, rng.normal(size=(31, 3)))
    rotations = quaternion.normalize(rng.normal(size=(FRAMES, 31, 4)))
    return skeleton, rotations, rng.normal(size=(FRAMES, 3)), "a random tree (the real recordings are not here)"


def run() -> list[Table]:
    """One table."""
    skeleton, rotations, roots, source = movement()

    def plain() -> None:
        os.environ["KINESICS_NO_NATIVE"] = "1"
        kinematics.forward(skeleton, rotations, roots)
        del os.environ["KINESICS_NO_NATIVE"]

    rivals: dict[str, Callable[[], object]] = {
        "ours": lambda: kinematics.forward(skeleton, rotations, roots),
        "ours, positions alone": lambda: kinematics.positions(skeleton, rotations, roots),
        "ours, in NumPy (extension not built)": plain,
    }
    label = "pymotion (≥ 1.3x)"
    missing: list[list[str]] = []
    with tempfile.TemporaryDirectory() as folder:
        path = str(Path(folder) / "motion.npz")
        # pymotion wants an offset of 0 for the root and its parent to be itself
        offsets = skeleton.offsets.copy()
        offsets[0] = 0.0
        np.savez(
            path,
            rotations=rotations,
            roots=roots,
            offsets=offsets,
            parents=np.array([0, *skeleton.parents[1:]]),
            expected=kinematics.positions(skeleton, rotations, roots),
        )
        try:
            with Peer(PYMOTION, [path]) as peer:
                times = in_turn({**rivals, label: peer})
        except PeerMissingError as why:
            missing.append([label, str(why), ""])
            times = in_turn(rivals)
    ours = times["ours"]
    return [
        Table(
            f"Forward kinematics, {skeleton.joint_count} joints, {len(rotations):,} frames",
            ("way (target)", "frames a second", "ours is"),
            [
                *([name, f"{len(rotations) / t:,.0f}", f"{t / ours:.1f}x as fast"] for name, t in times.items()),
                *missing,
            ],
            (f"{source}.",),
        )
    ]


if __name__ == "__main__":
    main(run)
