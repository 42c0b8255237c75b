"""``kinesics info FILE…``: what a file is, before anything is computed from it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from kinesics.cli import recording, terminal
from kinesics.cli.recording import Reading
from kinesics.errors import SkeletonError

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rich.console import Console

    from kinesics.body.motion import Motion

SUMMARY = "Say what a file is and what looks wrong with it."
EXAMPLES = (
    ("kinesics info walk.bvh", ""),
    ("kinesics info 07_01.amc --skeleton 07.asf", "the skeleton lies elsewhere"),
    ("kinesics info left.bvh right.bvh", "one after another"),
    ("kinesics info walk.bvh --json", "for programs; of several files a list"),
)


def info(
    files: Annotated[list[Path], typer.Argument(metavar="FILE", show_default=False, help="Recordings.")],
    json: recording.Json = False,
    skeleton: recording.Skeleton = None,
    map_: recording.Map = None,
    unit: recording.Unit = None,
    up: recording.Up = None,
    fps: recording.Fps = None,
) -> None:
    """Say what a file is: format, skeleton, length, units, what was assumed, what looks wrong."""
    reading = Reading(skeleton, map_, unit, up, fps)
    # all before the first is shown: of a bad file nothing but the message is seen
    found = [inspect(reading.read(file), reading.mapping()) for file in files]
    if json:
        terminal.print_json(found[0] if len(found) == 1 else found)
        return
    for number, facts in enumerate(found):
        if number:
            print()
        _show(facts)


def inspect(motion: Motion, mapping: Mapping[str, Any] | None = None) -> dict[str, Any]:
    """What is known of a recording, as plain values."""
    from kinesics.body import anatomy, limits, quality

    source = motion.source
    facts: dict[str, Any] = {
        "name": source.file_name,
        "format": source.format,
        "sha256": source.sha256,
        "frames": motion.frame_count,
        "fps": motion.fps,
        "duration_s": motion.duration,
        "metres_per_unit": source.metres_per_unit,
        "up": source.up_axis,
        "joints": list(motion.skeleton.joint_names),
        "assumptions": list(motion.assumptions),
        "warnings": list(motion.warnings),
    }
    try:
        motion = anatomy.understood(motion, mapping)
        body = anatomy.resolve(motion)
    except SkeletonError as error:
        facts["body"] = None
        facts["not_understood"] = {"reason": str(error), "found": error.found, "missing": list(error.missing)}
    else:
        facts["body"] = {"profile": body.profile, "parts": body.roles.named(motion.skeleton)}
        facts["not_understood"] = None
        facts["assumptions"] = list(dict.fromkeys((*facts["assumptions"], *body.assumptions)))
    facts["quality"] = quality.inspect(motion).to_dict()
    facts["free_space"] = limits.free_space(motion).to_dict()
    return facts


def _show(facts: dict[str, Any]) -> None:
    console = terminal.console()

    def row(label: str, text: str) -> None:
        console.print(f"  [cyan]{label:<10}[/cyan]{terminal.escape(text)}")

    console.print(f"[bold]{terminal.escape(facts['name'])}[/bold]")
    row("format", facts["format"])
    row("length", f"{terminal.counted(facts['frames'], 'frame')} at {facts['fps']:g} fps: {facts['duration_s']:.2f} s")
    row("unit", f"{facts['metres_per_unit']:.6g} m; up is {facts['up']}")
    row("joints", str(len(facts["joints"])))
    if facts["body"] is None:
        missing = facts["not_understood"]
        console.print("\n[yellow]This skeleton is not understood as a human body[/yellow]")
        row("reason", missing["reason"])
        row("found", ", ".join(f"{role} = {joint}" for role, joint in missing["found"].items()) or "nothing")
        row("missing", ", ".join(missing["missing"]) or "nothing")
    else:
        row("body", facts["body"]["profile"])
        for role, joint in facts["body"]["parts"].items():
            console.print(f"    [dim]{role:<16}[/dim]{terminal.escape(joint)}")
    _list(console, "Assumed", facts["assumptions"], "nothing: the file says it all")
    _list(console, "Looks wrong", [*facts["warnings"], *facts["quality"]["sentences"]], "nothing")
    _list(console, "Joint limits and collisions", facts["free_space"]["sentences"], "nothing to check")


def _list(console: Console, title: str, lines: list[str], otherwise: str) -> None:
    console.print(f"\n[bold]{title}[/bold]" + ("" if lines else f": {otherwise}"))
    for line in lines:
        console.print(f"  {terminal.escape(line)}")
