"""Recovery of motion graphs: random graphs are performed, the recordings read, the graphs compared.

Random graphs of 3 to 12 states (symmetric and chiral ones, reversible and one-way paths, a third of the paths parallel, states
at least .01 apart in D, half of them passed without a stop), each traversed for 60 to 180 s with wavering tempo and sensor
noise, every path taken at least twice. A graph counts as recovered when the graph read is isomorphic to the one performed, with
symmetry and reversibility right, after states that leave no trace are contracted in both. What was never traversed
backwards cannot be known to be reversible and is not asked for.

    python benchmarks/bench_recovery.py [--json FILE]
"""

from __future__ import annotations

import os
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import kinesics as kx
from harness import Table, main
from kinesics.grammar import whole
from kinesics.performer.random_graphs import covering_steps, random_graph

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))
from performed_graphs import performed


def one(seed: int, noise: float, jitter: float, distance: bool) -> dict[str, object]:
    states = 3 + seed % 10
    graph = random_graph(states=states, seed=seed)
    done = kx.performer.traverse(
        graph, covering_steps(graph, seed=seed), fps=60, noise_degrees=noise, tempo_jitter=jitter, seed=seed
    )
    poses = kx.poses(done.motion)
    started = time.process_time()
    graph_read = whole.read_grammar(poses).graph
    assert graph_read is not None
    read = graph_read.contracted()
    seconds = time.process_time() - started
    truth = performed(done.truth).contracted()
    same = bool(read.isomorphic_to(truth))
    row: dict[str, object] = {
        "seed": seed,
        "states": states,
        "seconds": done.motion.duration,
        "recovered": same,
        "reading_cpu_s": seconds,
        "true": [len(truth.states), len(truth.paths)],
        "read": [len(read.states), len(read.paths)],
    }
    if not same and distance:
        row["edit_distance"] = read.edit_distance(truth).value
    return row


def _one(seed: int) -> dict[str, object]:
    return one(seed, 1.0, 0.05, distance=True)


def run() -> list[Table]:
    """200 graphs with 1° of noise and 5 % of tempo jitter; $KINESICS_RECOVERY_COUNT gives another number."""
    count = int(os.environ.get("KINESICS_RECOVERY_COUNT", "200"))
    with ProcessPoolExecutor(os.cpu_count()) as pool:
        rows = list(pool.map(_one, range(count)))
    good = sum(bool(r["recovered"]) for r in rows)
    table = []
    for states in sorted({int(str(r["states"])) for r in rows}):
        mine = [r for r in rows if r["states"] == states]
        table.append([str(states), str(len(mine)), str(sum(bool(r["recovered"]) for r in mine))])
    table.append(["all", str(len(rows)), f"{good} ({good / len(rows):.1%})"])
    recorded = sum(float(str(r["seconds"])) for r in rows)
    cpu = sum(float(str(r["reading_cpu_s"])) for r in rows)
    return [
        Table(
            f"Graphs recovered, 1° noise, 5 % tempo jitter (target ≥ 90 %: {good / len(rows):.1%})",
            ["states", "graphs", "recovered"],
            table,
            [f"{recorded / 3600:.1f} h of movement read in {cpu:.0f} s of processor time: classes, phrases and graph."],
        ),
        Table(
            "Not recovered",
            ["seed", "states and paths performed", "read", "edit distance"],
            [
                [str(r["seed"]), str(r["true"]), str(r["read"]), str(r.get("edit_distance", ""))]
                for r in rows
                if not r["recovered"]
            ],
        ),
    ]


if __name__ == "__main__":
    main(run)
