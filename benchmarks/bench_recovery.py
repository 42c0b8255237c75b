"""Recovery of motion graphs: random graphs are performed, the recordings read, the graphs compared.

Random graphs of 3 to 12 states (symmetric and chiral ones, reversible and one-way paths, a third of the paths parallel, states
at least .01 apart in D, half of them passed without a stop), each traversed for 60 to 180 s with wavering tempo and sensor
noise, every path taken at least twice. A graph counts as recovered when the graph read is isomorphic to the one performed, with
symmetry and reversibility right, after states that leave no trace are contracted in both. What was never traversed
backwards cannot be known to be reversible and is not asked for.

    python benchmarks/bench_recovery.py [--count 200] [--json FILE]
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from pathlib import Path

import kinesics as kx
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
        row["edit_distance"] = str(read.edit_distance(truth))
    return row


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--noise", type=float, default=1.0, help="degrees, root mean square")
    parser.add_argument("--jitter", type=float, default=0.05)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--json", type=Path)
    arguments = parser.parse_args()
    rows = []
    for seed in range(arguments.first, arguments.first + arguments.count):
        row = one(seed, arguments.noise, arguments.jitter, distance=True)
        rows.append(row)
        if not row["recovered"]:
            print(f"not recovered: {row}", file=sys.stderr, flush=True)
    good = sum(bool(r["recovered"]) for r in rows)
    print("| states | graphs | recovered |\n| --- | --- | --- |")
    for states in sorted({r["states"] for r in rows}):  # type: ignore[type-var]
        mine = [r for r in rows if r["states"] == states]
        print(f"| {states} | {len(mine)} | {sum(bool(r['recovered']) for r in mine)} |")
    print(f"| all | {len(rows)} | {good} ({good / len(rows):.1%}) |")
    if arguments.json:
        arguments.json.write_text(json.dumps({"rows": rows, "recovered": good, "count": len(rows)}, indent=1))


if __name__ == "__main__":
    main()
