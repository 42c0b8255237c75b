"""Euler angles and the look at quality: rates against SciPy, and the time for a whole recording.

    python benchmarks/bench_geometry.py [--json FILE]

Euler angles of a recording of 5,000 frames and 31 joints to quaternions and back, where readers and writers spend their
time; and what `kinesics info` adds to reading: the look at quality, joint limits and collisions, on the longest CMU
kata.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

import kinesics as kx
from harness import Table, data_folder, in_turn, main
from kinesics.body import limits, quality
from kinesics.geometry import euler, quaternion

FRAMES, JOINTS = 5_000, 31


def rates() -> Table:
    """Ours against SciPy's, in joint rotations a second."""
    angles = np.random.default_rng(1).uniform(-3.0, 3.0, size=(FRAMES, JOINTS, 3))
    flat = angles.reshape(-1, 3)
    q = euler.from_euler(angles, "ZXY")
    theirs = quaternion.as_scalar_last(q).reshape(-1, 4)
    seconds = in_turn(
        {
            "from": lambda: euler.from_euler(angles, "ZXY"),
            "from, SciPy": lambda: Rotation.from_euler("ZXY", flat).as_quat(),
            "to": lambda: euler.as_euler(q, "ZXY"),
            "to, SciPy": lambda: Rotation.from_quat(theirs).as_euler("ZXY"),
        }
    )
    rows = [
        [
            label,
            f"{len(flat) / seconds[key] / 1e6:.1f} M/s",
            f"{len(flat) / seconds[f'{key}, SciPy'] / 1e6:.1f} M/s",
            f"{seconds[f'{key}, SciPy'] / seconds[key]:.1f}x",
        ]
        for key, label in (("from", "Euler angles to quaternions"), ("to", "quaternions to Euler angles"))
    ]
    return Table(f"Euler angles (ZXY), {FRAMES:,} frames of {JOINTS} joints", ["", "kinesics", "SciPy", "ratio"], rows)


def looks() -> list[Table]:
    """Seconds for one recording."""
    folder = data_folder()
    if folder is None:
        return []
    motion = kx.read(folder / "cmu" / "135" / "135_02.amc")
    seconds = in_turn(
        {"quality": lambda: quality.inspect(motion), "limits and collisions": lambda: limits.free_space(motion)}
    )
    rows = [[name, f"{1000 * took:.0f} ms"] for name, took in seconds.items()]
    return [Table(f"Looking at CMU 135_02, {motion.frame_count:,} frames", ["", "time"], rows)]


def run() -> list[Table]:
    """Rates, then looks."""
    return [rates(), *looks()]


if __name__ == "__main__":
    main(run)
