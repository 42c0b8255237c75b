"""Z and Z* of all pairs of moments: against other ways in Python, against the machine, and how time and memory grow.

    python benchmarks/bench_similarity.py [--json FILE]

All ways compute both Z and Z*, in float32. Poses come from the real recordings, repeated where a size needs more, or from a
smooth random movement without them. "One GEMM a joint" is the best exact way in NumPy; cdist and scikit-learn work on
poses of canonical sign (w ≥ 0), which is another, wrong distance for a quarter of all real pairs: they are here for speed.
"""

from __future__ import annotations

import math
import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

import kinesics as kx
from harness import Table, data_folder, in_turn, main
from kinesics.body import pose
from kinesics.geometry import quaternion
from kinesics.similarity import _kernel, diagonal_sums
from kinesics.vocabulary import MIRROR_LINKS
from peer import Peer, PeerMissingError

BETA = 40.0
BOUND_SECONDS = {5_000: 0.0115, 10_000: 0.046, 20_000: 0.185}
"""Instructions of abs, add and exp over half the matrix, two threads of the reference machine."""

SKLEARN = f"""
import sys
import numpy as np
from sklearn.metrics.pairwise import euclidean_distances
a, b = np.load(sys.argv[1]), np.load(sys.argv[2])
def job():
    for other in (a, b):
        np.exp(euclidean_distances(a, other, squared=True) * np.float32(-{BETA} / 2))
"""

PEAK = """
import re, sys
from pathlib import Path
import numpy as np
import kinesics as kx
q = np.load(sys.argv[1])
kx.similarity(q[:300], beta=40.0)
def peak():
    # not ru_maxrss: that is inherited from the process that started this one
    return int(re.search(r"VmHWM:\\s*(\\d+)", Path("/proc/self/status").read_text())[1]) * 1024
before = peak()
s = kx.similarity(q, beta=40.0)
print(before, peak(), s.z.nbytes + s.z_mirror.nbytes)
"""


def poses(count: int) -> tuple[np.ndarray, str]:
    """Unit quaternions, shape (count, 15, 4), and where they come from."""
    folder = data_folder()
    files = [] if folder is None else sorted((folder / "cmu").glob("*/*.amc"))
    parts: list[np.ndarray] = []
    for file in files:
        parts.append(kx.poses(kx.read(file)).quaternions)
        if sum(len(p) for p in parts) >= count:
            break
    if parts:
        real = np.concatenate(parts)
        repeats = -(-count // len(real))
        note = f"{len(real):,} real frames of the CMU recordings" + (f", repeated {repeats}x" if repeats > 1 else "")
        return np.tile(real, (repeats, 1, 1))[:count], note
    rng = np.random.default_rng(1)
    t = np.arange(count)[:, None, None] / 120.0
    angles = sum(np.sin(rng.uniform(0.5, 9.0, (15, 3)) * t + rng.uniform(0, 6, (15, 3))) for _ in range(3)) * 0.4
    return quaternion.from_rotvec(angles), "a smooth random movement (the real recordings are not here)"


def gemm_a_joint(q: np.ndarray, z: np.ndarray, z_mirror: np.ndarray, *, exponential: bool = True) -> Callable[[], None]:
    """NumPy: one matrix product a joint, modulus, sum, exponential; whole matrices, nothing allocated twice."""
    links = np.ascontiguousarray(np.swapaxes(q, 0, 1)[1:], dtype=np.float32)
    images = links[[m - 1 for m in MIRROR_LINKS[1:]]] * np.array([1, 1, -1, -1], dtype=np.float32)
    down = pose.gravity(q).astype(np.float32)
    product = np.empty_like(z)

    def job() -> None:
        for out, others, below in ((z, links, down), (z_mirror, images, down * np.array([-1, 1, 1], np.float32))):
            np.matmul(down, below.T, out=out)
            np.sqrt(np.maximum(0.5 + 0.5 * out, 0.0, out=out), out=out)
            for mine, other in zip(links, others, strict=True):
                np.matmul(mine, other.T, out=product)
                np.add(out, np.abs(product, out=product), out=out)
            np.subtract(np.float32(1.0), np.multiply(out, np.float32(1 / 15), out=out), out=out)
            np.maximum(out, 0.0, out=out)
            if exponential:
                np.exp(np.multiply(out, np.float32(-BETA), out=out), out=out)

    return job


def embedded(q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Poses and their images as 60 numbers each, signs canonical, so that |a − b|²/2 is D where signs agree."""
    return tuple(
        quaternion.canonical(x).reshape(len(x), 60).astype(np.float32) / np.float32(math.sqrt(15))
        for x in (q, pose.mirror(q))
    )


def cdist(a: np.ndarray, b: np.ndarray) -> Callable[[], None]:
    from scipy.spatial.distance import cdist as scipy_cdist

    def job() -> None:
        for other in (a, b):
            np.exp(scipy_cdist(a, other, "sqeuclidean").astype(np.float32) * np.float32(-BETA / 2))

    return job


def ms(seconds: float) -> str:
    return f"{seconds * 1e3:,.1f} ms"


def check(q: np.ndarray, z: np.ndarray, z_mirror: np.ndarray) -> float:
    """Greatest difference between ours and one GEMM a joint: what is compared is the same thing."""
    ours = kx.similarity(q, beta=BETA)
    gemm_a_joint(q, z, z_mirror)()
    return max(float(np.abs(ours.z - z).max()), float(np.abs(ours.z_mirror - z_mirror).max()))


def reused(q: np.ndarray, source: str) -> Table:
    """Into arrays that are there already."""
    n = len(q)
    z, z_mirror = np.zeros((2, n, n), dtype=np.float32)
    other, other_mirror = np.zeros((2, n, n), dtype=np.float32)

    def write() -> None:
        z.fill(0.5)
        z_mirror.fill(0.5)

    times = in_turn(
        {
            "ours": lambda: kx.similarity(q, beta=BETA, out=(z, z_mirror)),
            "plain write of the two arrays": write,
            "NumPy, one GEMM a joint": gemm_a_joint(q, other, other_mirror),
        }
    )
    ours, plain, gemm = times.values()
    rows = [[name, ms(t), f"{t / ours:.1f}x"] for name, t in times.items()]
    if n in BOUND_SECONDS:
        bound = BOUND_SECONDS[n] + plain
        rows.append(["bound: instructions + plain write", ms(bound), f"ours is {ours / bound:.2f}x the bound (≤ 1.5x)"])
    return Table(
        f"Z and Z*, N = {n:,}, `out=` reused (target ≥ 60x NumPy: {gemm / ours:.0f}x)",
        ("way", "seconds", "against ours"),
        rows,
        (f"Poses: {source}. Code path: {_kernel.chosen()}.",),
    )


def fresh(q: np.ndarray) -> Table:
    """Into arrays made by each way."""
    n = len(q)
    a, b = embedded(q)

    def gemm() -> None:
        gemm_a_joint(q, np.empty((n, n), np.float32), np.empty((n, n), np.float32))()

    rivals: dict[str, Callable[[], object]] = {
        "ours": lambda: kx.similarity(q, beta=BETA),
        "NumPy, one GEMM a joint (≥ 20x)": gemm,
        "SciPy cdist, canonical (≥ 25x)": cdist(a, b),
    }
    label = "scikit-learn euclidean_distances, canonical (≥ 8x)"
    missing: list[list[str]] = []
    with tempfile.TemporaryDirectory() as folder:
        paths = [str(Path(folder) / f"{k}.npy") for k in range(2)]
        for path, array in zip(paths, (a, b), strict=True):
            np.save(path, array)
        try:
            with Peer(SKLEARN, paths) as peer:
                times = in_turn({**rivals, label: peer})
        except PeerMissingError as why:
            missing.append([label, str(why), ""])
            times = in_turn(rivals)
    ours = times["ours"]
    largest = check(q[:1000], np.empty((1000, 1000), np.float32), np.empty((1000, 1000), np.float32))
    return Table(
        f"Z and Z*, N = {n:,}, fresh arrays",
        ("way (target)", "seconds", "against ours"),
        [*([name, ms(t), f"{t / ours:.1f}x"] for name, t in times.items()), *missing],
        (
            f"Greatest difference between ours and one GEMM a joint over 1,000 frames: {largest:.1e} (float32, β = {BETA:g}).",
        ),
    )


def windows(q: np.ndarray, length: int = 8) -> Table:
    """Sums of D and D* over short stretches, along diagonals."""
    n = len(q)
    d, d_mirror = np.zeros((2, n, n), dtype=np.float32)
    sums = np.zeros((2, n - length + 1, n - length + 1), dtype=np.float32)
    distances = gemm_a_joint(q, d, d_mirror, exponential=False)

    def plain() -> None:
        distances()
        for total, part in zip(sums, (d, d_mirror), strict=True):
            np.copyto(total, part[: len(total), : len(total)])
            for k in range(1, length):
                total += part[k : k + len(total), k : k + len(total)]

    into = tuple(np.zeros_like(sums))
    label = "NumPy, one GEMM a joint and shifted sums"
    times = in_turn({"ours": lambda: diagonal_sums(q, length=length, out=into), label: plain})
    ours = times["ours"]
    return Table(
        f"Sums of D and D* along diagonals, L = {length}, N = {n:,} (target ≥ 30x NumPy: {times[label] / ours:.0f}x)",
        ("way", "seconds", "against ours"),
        [[name, ms(t), f"{t / ours:.1f}x"] for name, t in times.items()],
        ("Both write into arrays that are there.",),
    )


def growth(q: np.ndarray, sizes: Sequence[int]) -> Table:
    """How time grows with the number of frames, arrays reused."""
    jobs: dict[str, Callable[[], object]] = {}
    for n in sizes:
        out = tuple(np.zeros((2, n, n), dtype=np.float32))
        jobs[f"{n:,}"] = lambda n=n, out=out: kx.similarity(q[:n], beta=BETA, out=out)
    times = in_turn(jobs)
    rows = []
    for (name, t), previous in zip(times.items(), [None, *times.values()], strict=False):
        rows.append([name, ms(t), "" if previous is None else f"{math.log2(t / previous):.2f}"])
    first, last = (list(times.values())[k] for k in (0, -1))
    exponent = math.log(last / first) / math.log(sizes[-1] / sizes[0])
    return Table(
        f"Growth, `out=` reused: exponent {exponent:.2f} from {sizes[0]:,} to {sizes[-1]:,} (target ≤ 2.05)",
        ("N", "seconds", "exponent from the size above"),
        rows,
    )


def memory(q: np.ndarray) -> Table:
    """Peak resident memory of a process of its own, as Linux counts it."""
    title = f"Peak memory, N = {len(q):,} (target ≤ outputs + 64 MB)"
    if not Path("/proc/self/status").exists():
        return Table(title, ("what", "MB"), [["not measured: this system has no /proc", ""]])
    with tempfile.TemporaryDirectory() as folder:
        path = str(Path(folder) / "q.npy")
        np.save(path, q)
        said = subprocess.run([sys.executable, "-c", PEAK, path], check=True, capture_output=True, text=True).stdout
    before, peak, outputs = (int(v) for v in said.split())
    beside = (peak - before - outputs) / 2**20
    return Table(
        title,
        ("what", "MB"),
        [
            ["the two outputs", f"{outputs / 2**20:,.0f}"],
            ["beside them while computing", f"{beside:,.1f}"],
            ["interpreter, NumPy, kinesics and the poses, before", f"{before / 2**20:,.0f}"],
        ],
    )


def code_paths(q: np.ndarray) -> Table:
    """What each code path costs."""
    import os

    n = len(q)
    z, z_mirror = np.zeros((2, n, n), dtype=np.float32)

    def forced(path: str) -> Callable[[], None]:
        def job() -> None:
            os.environ["KINESICS_KERNEL"] = path
            kx.similarity(q, beta=BETA, out=(z, z_mirror))
            del os.environ["KINESICS_KERNEL"]

        return job

    times = in_turn({path: forced(path) for path in _kernel.available()})
    best = min(times.values())
    return Table(
        f"Code paths, N = {n:,}, `out=` reused",
        ("KINESICS_KERNEL", "seconds", "against the fastest"),
        [[name, ms(t), f"{t / best:.1f}x"] for name, t in times.items()],
    )


def run() -> list[Table]:
    """All tables; about two minutes."""
    q, source = poses(20_000)
    return [
        reused(q[:10_000], source),
        fresh(q[:5_000]),
        code_paths(q[:3_000]),
        windows(q[:10_000]),
        memory(q[:10_000]),
        growth(q, [5_000, 10_000, 20_000]),
    ]


if __name__ == "__main__":
    main(run)
