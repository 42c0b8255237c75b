"""How long one waits: `import kinesics`, the command's help, and the main job as a whole process.

    python benchmarks/bench_startup.py [--json FILE]

Whole processes, start-up included, warm file cache; wall seconds and peak resident memory as the operating system counts
them. Modules are compiled once, as those of an installed package are, whatever the environment says. The recording is Empi (43 s
at 120 fps) of the real recordings; without them, a synthetic one of the same length.
"""

from __future__ import annotations

import os
import statistics
import sys
import tempfile
from pathlib import Path

from harness import Table, data_folder, main, measure

REPEATS = 7


def empi(folder: str) -> tuple[str, list[str]]:
    """The recording, and the arguments that name it."""
    data = data_folder()
    if data is not None:
        return "Empi, 5,202 frames of ASF/AMC", [str(data / "cmu" / "135" / "135_02.amc")]
    import kinesics as kx

    path = Path(folder) / "kata.bvh"
    kx.write(kx.performer.walk(seconds=43.35, fps=120).motion, path)
    return "a synthetic walk, 5,202 frames of BVH", [str(path)]


def run() -> list[Table]:
    """All rows; each command is run in turn with the others."""
    with tempfile.TemporaryDirectory() as folder:
        name, files = empi(folder)
        python = sys.executable
        jobs = {
            "python alone": [python, "-c", "pass"],
            "import numpy": [python, "-c", "import numpy"],
            "import kinesics": [python, "-c", "import kinesics"],
            "import kinesics, Motion and poses": [python, "-c", "from kinesics import Motion, poses"],
            "kinesics --help": [python, "-m", "kinesics.cli", "--help"],
            f"kinesics info ({name})": [python, "-m", "kinesics.cli", "info", *files],
            f"kinesics analyze ({name})": [python, "-m", "kinesics.cli", "analyze", *files, "--out", "report"],
        }
        targets = {
            "import kinesics": "≤ 0.3 s",
            "kinesics --help": "≤ 0.5 s",
            f"kinesics analyze ({name})": "≤ 4 s, ≤ 600 MB",
        }
        environment = {k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"}
        environment["PYTHONPYCACHEPREFIX"] = str(Path(folder) / "bytecode")
        samples: dict[str, list[tuple[float, float, float]]] = {job: [] for job in jobs}
        for arguments in jobs.values():
            measure(arguments, folder, environment)
        for _ in range(REPEATS):
            for job, arguments in jobs.items():
                samples[job].append(measure(arguments, folder, environment))
    rows = [
        (
            job,
            f"{statistics.median(s for s, _, _ in got):.2f}",
            f"{min(s for s, _, _ in got):.2f}",
            f"{statistics.median(c for _, c, _ in got):.2f}",
            f"{max(m for _, _, m in got):.0f}",
            targets.get(job, ""),
        )
        for job, got in samples.items()
    ]
    return [
        Table(
            title="Start-up and the main job, whole processes",
            columns=("what", "median s", "least s", "CPU s", "peak MB", "target"),
            rows=rows,
            notes=(
                f"Median of {REPEATS} runs taken in turn, after one to warm the file cache. Peak memory is that of the largest "
                "process; where a core is free analyze has two, which together hold less than twice as much. CPU seconds are "
                "those of both.",
            ),
        )
    ]


if __name__ == "__main__":
    main(run)
