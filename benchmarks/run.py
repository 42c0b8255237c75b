"""Runs the benchmarks and rewrites RESULTS.md: `make bench`.

    python benchmarks/run.py [--only TOPIC…] [--peers PYTHON]

Each ``bench_<topic>.py`` is run on its own; a section of RESULTS.md holds its tables and the command that makes them. With
``--only`` the other sections stay as they are. ``--peers`` names the Python of the environment that the peers are installed
in; it is handed on as $KINESICS_PEERS, and rows of peers that are not there say so.
"""

from __future__ import annotations

import argparse
import ast
import json
import os
import platform
import subprocess
import sys
import tempfile
from pathlib import Path

from harness import Table

HERE = Path(__file__).resolve().parent
RESULTS = HERE / "RESULTS.md"
HEAD = """# Results

Made by `make bench`; do not edit by hand. Every claim is a ratio of two things timed in turn in one run, medians of at least
five; absolute figures are of the machine named, which others may be using at the same time.
"""


def machine() -> str:
    """Processor, memory, system, versions: one line."""
    import numpy
    import scipy

    import kinesics

    processor = platform.processor() or platform.machine()
    info = Path("/proc/cpuinfo")
    if info.exists():
        named = [
            line.split(":", 1)[1].strip() for line in info.read_text().splitlines() if line.startswith("model name")
        ]
        processor = named[0] if named else processor
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 2**30
    return (
        f"{processor}, {os.cpu_count()} cores, {memory:.0f} GiB; {platform.system()} {platform.machine()}; "
        f"Python {platform.python_version()}, NumPy {numpy.__version__}, SciPy {scipy.__version__}, "
        f"kinesics {kinesics.__version__}"
    )


def sections_there() -> dict[str, str]:
    """Topic to section, as RESULTS.md has them now."""
    if not RESULTS.exists():
        return {}
    parts = RESULTS.read_text(encoding="utf-8").split("\n## ")[1:]
    return {part.split("\n", 1)[0].strip(): part.split("\n", 1)[1].strip() for part in parts}


def measure(topic: str, environment: dict[str, str]) -> str:
    """Run one benchmark; its section without the heading."""
    script = HERE / f"bench_{topic}.py"
    what = (ast.get_docstring(ast.parse(script.read_text(encoding="utf-8"))) or "").split("\n")[0]
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "tables.json"
        print(f"\n=== {script.name}", flush=True)
        subprocess.run([sys.executable, str(script), "--json", str(out)], check=True, env=environment)
        tables = [Table(**table) for table in json.loads(out.read_text(encoding="utf-8"))]
    command = f"python benchmarks/{script.name}"
    return "\n".join([what, "", f"`{command}` on {machine()}", "", *(t.markdown() for t in tables)]).strip()


def main() -> int:
    """Run what was asked for; a benchmark that fails keeps its old section, and the exit code says so."""
    topics = sorted(p.stem.removeprefix("bench_") for p in HERE.glob("bench_*.py"))
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", nargs="+", choices=topics, default=topics, metavar="TOPIC")
    parser.add_argument("--peers", type=Path, metavar="PYTHON")
    told = parser.parse_args()
    environment = dict(os.environ)
    if told.peers:
        environment["KINESICS_PEERS"] = str(told.peers.absolute())
    failed = []
    for topic in told.only:
        try:
            measured = measure(topic, environment)
        except subprocess.CalledProcessError as error:
            print(f"bench_{topic}.py failed (exit {error.returncode}); its section stays as it was.", file=sys.stderr)
            failed.append(topic)
            continue
        # after each one, so that stopping half-way keeps what was measured; read anew, for another run may have written since
        sections = sections_there() | {topic: measured}
        text = HEAD + "".join(f"\n## {name}\n\n{body}\n" for name, body in sorted(sections.items()))
        RESULTS.write_text(text, encoding="utf-8")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
