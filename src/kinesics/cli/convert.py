"""``kinesics convert IN OUT``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from kinesics.cli import recording, terminal
from kinesics.cli.recording import Reading
from kinesics.errors import InputError

SUMMARY = "Write a recording in another format."
EXAMPLES = (
    ("kinesics convert 07_01.amc walk.bvh", "07.asf lies beside it"),
    ("kinesics convert walk.bvh walk.amc", "writes walk.asf too"),
    ("kinesics convert walk.bvh walk.glb", "a human figure that walks, for Blender and viewers"),
)


def convert(
    source: Annotated[Path, typer.Argument(metavar="IN", show_default=False, help="The recording.")],
    target: Annotated[
        Path,
        typer.Argument(
            metavar="OUT", show_default=False, help="Its suffix decides the format: .bvh .amc .glb .gltf .npz."
        ),
    ],
    overwrite: recording.Overwrite = False,
    skeleton: recording.Skeleton = None,
    map_: recording.Map = None,
    unit: recording.Unit = None,
    up: recording.Up = None,
    fps: recording.Fps = None,
) -> None:
    """Write a recording in another format; nothing of the movement is lost beyond a millionth."""
    from kinesics import formats

    if target.exists():
        if source.exists() and target.samefile(source):
            raise InputError(f"'{target}' is the recording itself; give the copy another name.")
        if not overwrite:
            raise InputError(f"'{target}' is there already; give another name, or --overwrite.")
    with terminal.Bar("Converting") as bar:
        bar(0.0, f"reading {source.name}")
        motion = Reading(skeleton, map_, unit, up, fps).read(source)
        bar(0.5, f"writing {target.name}")
        remarks = formats.write(motion, target, overwrite=overwrite)
    for line in (*motion.assumptions, *motion.warnings, *remarks):
        terminal.remark(line)
    print(target)
