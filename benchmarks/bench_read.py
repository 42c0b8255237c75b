"""Reading BVH and ASF/AMC: frames a second against pymotion, bvhio and fairmotion, and whether joints come out at the same places.

    python benchmarks/bench_read.py [--json FILE]

Ours is the whole of ``kx.read``: checksum, parsing, quaternions, unit and up axis judged, every value checked. The peers only
parse and turn angles into their own rotations; bvhio is timed in its faster mode, which leaves the angles as they are.
fairmotion's package asks for a version of PyTorch that is no longer to be had; its readers do not use it, so an empty module
stands in for it. It reads an .asf with line feeds only, so it gets a copy without carriage returns.
"""

from __future__ import annotations

import os
import subprocess
import tempfile
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from pathlib import Path
from unittest import mock

import numpy as np

import kinesics as kx
from harness import Table, data_folder, in_turn, main
from peer import Peer, PeerMissingError

PYMOTION = """
import sys
from pymotion.io.bvh import BVH
def job():
    BVH().load(sys.argv[1])
"""
BVHIO = """
import sys
import bvhio
def job():
    bvhio.readAsBvh(sys.argv[1])
"""
STAND_IN = """
import sys, types
torch = types.ModuleType("torch")
torch.Tensor = type("Tensor", (), {})
sys.modules["torch"] = torch
"""
FAIRMOTION_BVH = f"""{STAND_IN}
from fairmotion.data import bvh
def job():
    bvh.load(sys.argv[1])
"""
FAIRMOTION_AMC = f"""{STAND_IN}
from fairmotion.data import asfamc
def job():
    asfamc.load(sys.argv[1], sys.argv[2])
"""

PYMOTION_POSITIONS = """
import sys
import numpy as np
from pymotion.io.bvh import BVH
from pymotion.ops.skeleton import fk
b = BVH()
b.load(sys.argv[1])
turned, shifted, parents, offsets, *_ = b.get_data()
where, _ = fk(turned, shifted[:, 0], offsets, parents)
np.savez(sys.argv[2], names=np.array(b.data["names"]), positions=where)
"""
BVHIO_POSITIONS = """
import sys
import numpy as np
import bvhio
root = bvhio.readAsHierarchy(sys.argv[1])
joints = [joint for joint, _, _ in root.layout()]
frames = []
for frame in range(*root.getKeyframeRange()[:1], root.getKeyframeRange()[1] + 1):
    root.loadPose(frame)
    frames.append([list(joint.PositionWorld) for joint in joints])
np.savez(sys.argv[2], names=np.array([joint.Name for joint in joints]), positions=np.array(frames))
"""


def without_native(path: Path) -> Callable[[], object]:
    """Our reader as it is where the compiled kernels were not built."""

    def job() -> None:
        with mock.patch.dict(os.environ, KINESICS_NO_NATIVE="1"):
            kx.read(path)

    return job


def speed(title: str, path: Path, peers: dict[str, tuple[str, Sequence[str]]], target: str) -> Table:
    """Frames a second of ours and of the peers, read in turn."""
    frames = kx.read(path).frame_count
    rivals: dict[str, Callable[[], object]] = {
        "kinesics": lambda: kx.read(path),
        "kinesics, not compiled": without_native(path),
    }
    missing: dict[str, str] = {}
    with ExitStack() as stack:
        for name, (source, arguments) in peers.items():
            try:
                rivals[name] = stack.enter_context(Peer(source, arguments))
            except PeerMissingError as why:
                missing[name] = str(why)
        seconds = in_turn(rivals)
    ours = seconds["kinesics"]
    rows = [
        [name, f"{1e3 * took:.0f}", f"{frames / took:,.0f}", "" if name == "kinesics" else f"{took / ours:.1f}"]
        for name, took in seconds.items()
    ]
    rows += [[name, "", "", why] for name, why in missing.items()]
    return Table(
        f"{title}: {path.name}, {frames} frames",
        ("reader", "ms", "frames/s", "kinesics is faster by"),
        rows,
        (target,),
    )


def agreement(path: Path, folder: Path) -> Table:
    """Largest distance between our joints and theirs."""
    motion = kx.read(path)
    motion = motion[:: max(1, motion.frame_count // 60)]
    thinned = folder / "thinned.bvh"
    kx.write(motion, thinned, overwrite=True)
    motion = kx.read(thinned)
    ours = motion.positions() / motion.source.metres_per_unit
    rows = []
    python = os.environ.get("KINESICS_PEERS")
    for name, source in (("pymotion", PYMOTION_POSITIONS), ("bvhio", BVHIO_POSITIONS)):
        out = folder / f"{name}.npz"
        if not python:
            rows.append([name, "not measured: $KINESICS_PEERS is not set"])
            continue
        done = subprocess.run([python, "-c", source, thinned, out], capture_output=True, text=True, check=False)
        if done.returncode:
            rows.append([name, f"not measured: {done.stderr.strip().splitlines()[-1]}"])
            continue
        theirs = np.load(out)
        index = [list(theirs["names"]).index(n) for n in motion.skeleton.joint_names]
        apart = np.linalg.norm(theirs["positions"][:, index] - ours, axis=-1) * motion.source.metres_per_unit
        rows.append([name, f"{apart.max():.1e}"])
    return Table(
        f"Joints of {path.name}, {motion.frame_count} frames of it, all joints",
        ("reader", "largest distance from ours, m"),
        rows,
    )


def run() -> Sequence[Table]:
    """The tables."""
    data = data_folder()
    if data is None:
        return [Table("Reading", ("",), [["not measured: the real recordings are not here"]])]
    bvh = data / "cmu/bvh/135_02_120fps.bvh"
    amc, asf = data / "cmu/91/91_01.amc", data / "cmu/91/91.asf"
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for path in (amc, asf):
            (folder / path.name).write_bytes(path.read_bytes().replace(b"\r\n", b"\n"))
        plain_asf, plain_amc = str(folder / asf.name), str(folder / amc.name)
        return [
            speed(
                "ASF/AMC",
                amc,
                {"fairmotion": (FAIRMOTION_AMC, [plain_asf, plain_amc])},
                "Target: 20 times fairmotion, 30,000 frames/s.",
            ),
            speed(
                "BVH",
                bvh,
                {
                    "pymotion": (PYMOTION, [str(bvh)]),
                    "bvhio": (BVHIO, [str(bvh)]),
                    "fairmotion": (FAIRMOTION_BVH, [str(bvh)]),
                },
                "Target: 3 times the fastest of the three.",
            ),
            agreement(bvh, folder),
            agreement(data / "cmu/bvh/135_01_bassai_30fps.bvh", folder),
        ]


if __name__ == "__main__":
    main(run)
