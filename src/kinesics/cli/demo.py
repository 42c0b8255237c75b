"""``kinesics demo``: the main job on a body of our own making."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from kinesics.cli import terminal
from kinesics.cli.analyze import summarize

SUMMARY = "Analyse a synthetic performance; say where the report is."
EXAMPLES = (
    ("kinesics demo", "leaves demo-kinesics/report.html"),
    ("kinesics demo --movement walk --out walk", "another movement, another folder"),
)
_MOVEMENT = "kata"
_TREMOR_DEGREES = 0.2  # living bodies are never exactly still


def demo(
    movement: Annotated[
        str, typer.Option("--movement", metavar="NAME", help="What is performed; a wrong name lists them all.")
    ] = _MOVEMENT,
    seed: Annotated[int, typer.Option("--seed", metavar="N", help="Another number, another performance.")] = 0,
    out: Annotated[Path, typer.Option("--out", metavar="DIR", help="Where the report goes.")] = Path("demo-kinesics"),
) -> None:
    """Analyse a synthetic performance: no recording is needed. Prints where the report is."""
    from kinesics import analysis, performer, report

    with report.helping() as helper, terminal.Bar("Performing and analysing") as bar:
        performance = performer.perform(movement, seed=seed, noise_degrees=_TREMOR_DEGREES, noise_kind="smooth")
        result = analysis.analyze(performance.motion, progress=bar.part(0.1, 0.4))
        report.save(result, out, progress=bar.part(0.4, 1.0), helper=helper)
    summarize(result)
    print(f"Report: {out / 'report.html'}")
