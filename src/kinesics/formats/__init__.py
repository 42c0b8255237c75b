"""Recordings of movement in files: read to a `Motion`, written from one.

- `read`, `write`: any format; the content decides which one it is
- `read_extras`: arrays that were written with a motion
- `read_mapping`: which joint is what, by the user's word
- `formats`, `readable`, `writable`: which there are
- `kinesics.formats.registry`: what a new format must bring
"""

from __future__ import annotations

import contextlib
import dataclasses
import hashlib
import secrets
import stat
from collections.abc import Mapping
from os import PathLike
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from kinesics.body import anatomy, kinematics
from kinesics.body.feet import Soles
from kinesics.body.motion import Motion, Source
from kinesics.errors import FileError, InputError, SkeletonError
from kinesics.formats.registry import (
    HEAD_BYTES,
    Format,
    ReadOptions,
    Recording,
    Written,
    for_writing,
    formats,
    of_content,
    readable,
    writable,
)
from kinesics.geometry import quaternion

__all__ = [
    "LARGEST_FILE",
    "Format",
    "ReadOptions",
    "Recording",
    "Written",
    "formats",
    "read",
    "read_extras",
    "read_mapping",
    "readable",
    "writable",
    "write",
]

LARGEST_FILE: Final = 1 << 30
"""Bytes. A gigabyte of text is more than two hours at 120 frames a second; reading it takes some five times its size."""

_JUDGED_FRAMES = 64
_SAYS_NO_UP: Final = ("bvh", "asf_amc")
_SHORTEST_BODY = 1e-6
"""Metres: a body whose longest bone is shorter is none."""


def read(
    path: str | PathLike[str],
    *,
    skeleton: str | PathLike[str] | None = None,
    unit: str | float | None = None,
    up: str | None = None,
    fps: float | None = None,
    mapping: Mapping[str, object] | str | PathLike[str] | None = None,
    keep_first_frame: bool = False,
) -> Motion:
    """Read a recording, whatever its format: metres, y up, quaternions.

    What the file does not say (unit, up axis, the frame rate of an .amc) is judged, and stated in ``motion.assumptions``;
    what looks wrong is in ``motion.warnings``.

    Parameters
    ----------
    path : the recording.
    skeleton : the .asf of an .amc, where it does not lie beside it.
    unit : of length: "m", "cm", "mm", "in", "ft", "asf" (CMU's, 1/0.45 inch), or metres in one unit.
    up : the file's vertical axis: "y", "z", "x", or with a minus.
    fps : frames a second.
    mapping : which joint is which link, for skeletons that are not understood: a table as `kinesics.body.anatomy.resolve`
        takes it, or a TOML file of it.
    keep_first_frame : keep an inserted T-pose at the beginning of a BVH.

    Raises
    ------
    FileError
        If the file cannot be read; the message names the line.
    InputError
        If an argument cannot be used.
    """
    if fps is not None and not (np.isfinite(fps) and fps > 0):
        raise InputError(f"Expected a frame rate (--fps, `fps`) above 0, got {fps}.")
    path = _as_path(path)
    options = ReadOptions(None if skeleton is None else _as_path(skeleton), unit, up, fps, keep_first_frame)
    head = load(path, HEAD_BYTES)
    chosen = of_content(path, head)
    raw = load(path)
    assert chosen.read is not None, "of_content gives readable formats only"
    recording = chosen.read(path, raw, options)
    source = Source(format=chosen.name, file_name=path.name, sha256=hashlib.sha256(raw).hexdigest())
    motion = _to_metres_and_y_up(recording, source, options, path)
    if mapping:
        return _stated(anatomy.understood(motion, _as_mapping(mapping)))
    # found once on the whole recording, the body's frames are the same for every slice of it; a skeleton that is no human
    # body is still a recording, and `kinesics.poses` will say what is missing
    with contextlib.suppress(SkeletonError):
        motion = _stated(anatomy.understood(motion))
    return motion


def _stated(motion: Motion) -> Motion:
    """With what was assumed of the body among what was assumed of the file."""
    body = motion.skeleton.anatomy
    if body is None:
        return motion
    more = tuple(text for text in body.assumptions if text not in motion.assumptions)
    return motion.replace(assumptions=(*motion.assumptions, *more))


def write(
    motion: Motion,
    path: str | PathLike[str],
    *,
    overwrite: bool = False,
    extras: Mapping[str, NDArray[Any]] | None = None,
    soles: Soles | None = None,
) -> tuple[str, ...]:
    """Write a motion; the suffix decides the format. Files appear whole or not at all.

    A motion read from the same format is written in its own unit, axes and channels.

    Parameters
    ----------
    overwrite : replace files that are there.
    extras : arrays that belong to the motion, by name; only .npz has room for them (`read_extras` gives them back).
    soles : of the body, where they are known: the figure of .glb and .gltf stands on them. Otherwise they are found in the motion,
        and where no foot stands in it, the figure's feet are flat as the skeleton rests.

    Returns
    -------
    What the format could not hold, in words; empty where nothing was lost.

    Raises
    ------
    InputError
        If the suffix belongs to no format, a file is there and ``overwrite`` is false, or the motion cannot be expressed.
    FileError
        If there is no such folder, or the file cannot be written.
    """
    path = _as_path(path)
    chosen = for_writing(path)
    assert chosen.write is not None, "for_writing gives writable formats only"
    if not path.parent.is_dir():
        raise FileError(path, "The folder to write to does not exist.", hint="Make it first.")
    if extras and chosen.extras is not None:
        written = chosen.extras(motion, path, extras)
    else:
        if soles is not None and chosen.on_soles is not None:
            written = chosen.on_soles(motion, path, soles)
        else:
            written = chosen.write(motion, path)
        if extras:
            left_out = f"{chosen.title} has no room for {', '.join(extras)}: left out (.npz has)"
            written = dataclasses.replace(written, remarks=(*written.remarks, left_out))
    if not overwrite:
        there = [p.name for p, _ in written.files if p.exists()]
        if there:
            raise InputError(
                f"'{there[0]}' is there already, in '{path.parent}'; nothing was written. Give another name, or say that it "
                "may be replaced (--overwrite, overwrite=True)."
            )
    _put_down(written)
    return (*written.remarks, *_judged_otherwise(motion, chosen, path))


def _judged_otherwise(motion: Motion, chosen: Format, path: Path) -> tuple[str, ...]:
    """Whether a reader that judges the up axis by the body, as ours does, would take another for it."""
    from kinesics.body import conventions

    if chosen.name not in _SAYS_NO_UP:
        return ()
    up = motion.source.up_axis if motion.source.format == chosen.name else "y"
    sample = _sample(motion.frame_count)
    shifts = motion.joint_translations
    positions = kinematics.forward(
        motion.skeleton,
        motion.rotations[sample],
        motion.root_positions[sample],
        None if shifts is None else shifts[sample],
    ).positions
    if up != "y":
        positions = quaternion.rotate(quaternion.conjugate(conventions.to_y_up(up)), positions)
    judged = conventions.detect(motion.skeleton, positions, unit="m").up_axis
    if judged == up:
        return ()
    return (
        f"{path.name} does not say that {up} is up, and the body lies or bends in it as if {judged} were: read it with --up {up} "
        f'(up="{up}"); .glb and .npz do say so',
    )


def read_extras(path: str | PathLike[str]) -> dict[str, NDArray[Any]]:
    """The arrays that were written with a motion to .npz, by name; none where there were none.

    Raises
    ------
    FileError
        If the file cannot be read, or is no .npz of a motion.
    """
    from kinesics.formats import npz

    path = _as_path(path)
    return npz.extras_of(path, load(path))


def read_mapping(path: str | PathLike[str]) -> Mapping[str, object]:
    """A mapping file: TOML with a table ``[joints]`` of role = "joint name" (see `kinesics.body.anatomy.resolve`).

    Raises
    ------
    FileError
        If it cannot be read or is not TOML.
    """
    import tomllib

    path = _as_path(path)
    try:
        table: dict[str, object] = tomllib.loads(load(path).decode("utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise FileError(
            path, f"This is not TOML: {error}.", hint='Expected lines such as left_femur = "Hip_L" under [joints].'
        ) from None
    return table


def load(path: Path, most: int | None = None) -> bytes:
    """The bytes of a file, or its first ``most``.

    Raises
    ------
    FileError
        If it is missing, no plain file, too large or may not be read.
    """
    try:
        status = path.stat()
        if stat.S_ISDIR(status.st_mode):
            raise FileError(path, "Expected a file, but this is a folder.", hint="Give one file of it.")
        if not stat.S_ISREG(status.st_mode):
            raise FileError(path, "Expected a plain file, but this is a device or a pipe.")
        if most is None and status.st_size > LARGEST_FILE:
            raise FileError(
                path,
                f"The file has {status.st_size / 2**30:.1f} GiB; at most {LARGEST_FILE / 2**30:.0f} GiB can be read.",
                hint="Cut it into shorter recordings.",
            )
        with path.open("rb") as file:
            return file.read(-1 if most is None else most)
    except FileError:
        raise
    except FileNotFoundError:
        raise FileError(path, "There is no such file.") from None
    except (OSError, ValueError) as error:
        # a ValueError is a name with a zero byte in it
        reason = getattr(error, "strerror", None) or str(error)
        raise FileError(path, f"The file cannot be opened: {reason}.") from None


def _sample(frames: int) -> NDArray[np.intp]:
    """The frames by which unit and up axis are judged."""
    return np.unique(np.linspace(0, frames - 1, _JUDGED_FRAMES).astype(np.intp))


def _to_metres_and_y_up(recording: Recording, source: Source, options: ReadOptions, path: Path) -> Motion:
    """The `Motion` of a `Recording`: what is the same for all formats."""
    from kinesics.body import conventions

    skeleton = recording.skeleton
    sample = _sample(len(recording.rotations))
    shifts = recording.joint_translations
    positions = kinematics.forward(
        skeleton,
        recording.rotations[sample],
        recording.root_positions[sample],
        None if shifts is None else shifts[sample],
    ).positions
    unit = recording.metres_per_unit if options.unit is None else options.unit
    up = recording.up_axis if options.up is None else options.up
    judged = conventions.detect(skeleton, positions, unit=unit, up=up)
    scale = judged.metres_per_unit
    longest = float(np.linalg.norm(skeleton.offsets[1:], axis=-1).max(initial=0.0)) * scale
    if 0.0 < longest < _SHORTEST_BODY:
        raise FileError(
            path,
            f"holds a body whose longest bone is {longest:.3g} m, with {scale:g} m for a unit of length: the unit is wrong. "
            "Give it by --unit (unit=): m, cm, mm, in, ft, asf, or metres per unit.",
        )

    rotations, roots = recording.rotations, recording.root_positions * scale
    if judged.up_axis != "y":
        turn = conventions.to_y_up(judged.up_axis)
        rotations, roots = conventions.rotate_world(turn, rotations, roots)
    if shifts is not None:
        shifts = shifts * scale
        shifts[:, 0] = roots
    sites = tuple(
        dataclasses.replace(s, offset=(s.offset[0] * scale, s.offset[1] * scale, s.offset[2] * scale))
        for s in skeleton.end_sites
    )
    for array in (rotations, roots, shifts):
        if array is not None:
            # nobody else has it: a motion then keeps it as it is, and long recordings are not copied
            array.setflags(write=False)
    if recording.source is None:
        source = dataclasses.replace(
            source, metres_per_unit=scale, up_axis=judged.up_axis, details=dict(recording.details)
        )
    else:
        source = recording.source
    return Motion(
        skeleton=skeleton.replace(offsets=skeleton.offsets * scale, end_sites=sites),
        rotations=rotations,
        root_positions=roots,
        fps=recording.fps,
        joint_translations=shifts,
        name=path.stem if recording.name is None else recording.name,
        source=source,
        assumptions=(*recording.assumptions, *judged.assumptions),
        # a motion that was stored as one was doubted when it was first read
        warnings=(*recording.warnings, *(judged.warnings if recording.source is None else ())),
    )


def _as_path(path: str | PathLike[str]) -> Path:
    try:
        return Path(path)
    except TypeError:
        raise InputError(f"Expected the path of a file, got {type(path).__name__}.") from None


def _as_mapping(mapping: Mapping[str, object] | str | PathLike[str]) -> Mapping[str, object]:
    """Roles to joint names: as given, or of a TOML file; a table ``[joints]`` is opened."""
    table = mapping if isinstance(mapping, Mapping) else read_mapping(mapping)
    joints = table.get("joints")
    if isinstance(joints, Mapping):
        return {**{k: v for k, v in table.items() if k != "joints"}, **joints}
    return table


def _put_down(written: Written) -> None:
    """Write all files beside where they belong, then move them there: none is ever seen half-written."""
    parts: list[tuple[Path, Path]] = []
    try:
        for path, data in written.files:
            part = path.with_name(f".{path.name}.{secrets.token_hex(4)}.part")
            parts.append((part, path))
            with part.open("xb") as file:
                file.write(data)
        for part, path in parts:
            part.replace(path)
    except OSError as error:
        raise FileError(written.files[0][0], f"The file cannot be written: {error.strerror or error}.") from None
    finally:
        for part, _ in parts:
            with contextlib.suppress(OSError):
                part.unlink(missing_ok=True)
