"""ASF/AMC: Acclaim's two text files, the skeleton (.asf) and the movement (.amc), as the CMU database has them.

A bone of the ASF begins at a joint: the joint is called as the bone and sits at its near end; children hang at its far end,
``direction · length`` away. Angles are about axes fixed in a frame C of the bone (``axis``), the first listed turned first:
``dof rx ry rz`` is M = Rz·Ry·Rx, and relative to the parent the bone turns by C·M·C⁻¹. So with all angles zero every joint's
orientation in the world is the identity, as in a BVH.

Lengths are in units of 1/``length`` inch: CMU's 0.45 makes a unit .0564 m. The frame rate is not in the files.

Sources: M. Schafer, Acclaim Skeleton File Definition V1.10 (1994); Vicon, "Acclaim Format - ASF line details".
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from kinesics.body import conventions
from kinesics.errors import FileError, some_of
from kinesics.formats import angles, text
from kinesics.formats.asf import Asf, is_skeleton, read_asf, skeleton_of
from kinesics.formats.asf_amc_writing import FPS_REMARK, write
from kinesics.formats.registry import Format, ReadOptions, Recording
from kinesics.geometry import quaternion

Array = NDArray[np.float64]

CMU_60_FPS: Final = frozenset({33, 34, 42, 60, 61, 62, 74, 75, 77, 79, 80, 87, 88, 89})
"""Subjects of the CMU database that were captured at 60 frames a second; all others at 120."""

_SAID_FPS = re.compile(
    rb"^[ \t]*(?:" + re.escape(FPS_REMARK.encode()) + rb"|:SAMPLES-PER-SECOND)\s*(\S+)", re.IGNORECASE | re.MULTILINE
)
_AMC_KEYWORD = re.compile(
    rb"^[ \t]*:(FULLY-SPECIFIED|DEGREES|RADIANS|SAMPLES-PER-SECOND)\b", re.IGNORECASE | re.MULTILINE
)
_AMC_FRAME = re.compile(rb"^[ \t]*\d+[ \t\r]*\n[ \t]*[A-Za-z_][^\s:]*([ \t]+[-+.\d][-+.\deE]*)+[ \t\r]*$", re.MULTILINE)


def sniff(head: bytes) -> bool:
    """Whether a file begins as an .amc or an .asf does."""
    return is_skeleton(head) or _is_movement(head)


def _is_movement(head: bytes) -> bool:
    return _AMC_KEYWORD.search(head) is not None or _AMC_FRAME.search(head) is not None


def read(path: Path, raw: bytes, options: ReadOptions) -> Recording:
    """An .amc on its .asf, in the skeleton's unit.

    Raises
    ------
    FileError
        If one of the two is damaged, with the line; if they do not belong together; if there is no .asf.
    """
    file = text.TextFile.of(path, raw)
    if is_skeleton(file.data[:8192]) and not _is_movement(file.data[:8192]):
        raise FileError(
            path,
            "This is a skeleton (.asf), not a recording.",
            hint="Give the .amc, which has the movement; the .asf beside it is found by itself.",
        )
    assumptions: list[str] = []
    asf_path = options.skeleton or _find_asf(path, assumptions)
    asf = read_asf(asf_path)
    bones = list(asf.bones.values())
    degrees, start = _movement_header(file, asf)
    values, columns, warnings = _read_frames(file, start, asf)
    missing = [b.name for b in bones if b.dofs and b.name not in columns]
    if missing:
        assumptions.append(
            f"{some_of(missing)} {'does' if len(missing) == 1 else 'do'} not occur in the .amc: taken as not turning"
        )
        for name in missing:
            columns[name] = []
    unit = angles.DEGREE if degrees else 1.0
    turning = [[columns[b.name][k] for k in b.columns("r")] if columns.get(b.name) else [] for b in bones]
    # axes fixed in C, the first listed turned first: the intrinsic sequence is the list backwards
    rotations = angles.rotations_of_columns(
        values,
        [c[::-1] for c in turning],
        [b.turning()[::-1] if c else "" for b, c in zip(bones, turning, strict=True)],
        unit,
    )
    skeleton = skeleton_of(asf)
    for joint, freedom in enumerate(skeleton.freedoms):
        if freedom.axis != (1.0, 0.0, 0.0, 0.0):
            # C·M·C⁻¹ turns the axis of M by C and leaves the angle
            rotations[:, joint, 1:] = rotations[:, joint, 1:] @ quaternion.as_matrix(freedom.axis).T
    shifts = np.tile(skeleton.offsets, (len(values), 1, 1)) if any(b.shifting() for b in bones[1:]) else None
    roots = np.tile(np.array(asf.position), (len(values), 1))
    for joint, bone in enumerate(bones):
        target = roots if joint == 0 else None if shifts is None else shifts[:, joint]
        if target is not None and columns.get(bone.name):
            for axis, place in zip(bone.shifting(), bone.columns("t"), strict=True):
                along = np.eye(3)["xyz".index(axis)]
                if joint:
                    along = quaternion.rotate(skeleton.freedoms[joint].axis, along)
                target += values[:, columns[bone.name][place], None] * along
    fps, said = _frame_rate(file, options)
    return Recording(
        skeleton=skeleton,
        rotations=rotations,
        root_positions=roots,
        fps=fps,
        joint_translations=shifts,
        metres_per_unit=_known_unit(asf, options, assumptions),
        assumptions=(*assumptions, *said),
        warnings=(*asf.warnings, *warnings),
        details={"skeleton_file": asf_path.name},
    )


def _find_asf(path: Path, assumptions: list[str]) -> Path:
    """The skeleton beside an .amc: of the same name, of the subject (07 of 07_01), or the only one there is."""
    there = {p.name.lower(): p for p in sorted(path.parent.iterdir()) if p.suffix.lower() == ".asf"}
    wanted = [f"{path.stem}.asf".lower()]
    if "_" in path.stem:
        wanted.append(f"{path.stem.rsplit('_', 1)[0]}.asf".lower())
    for name in wanted:
        if name in there:
            assumptions.append(f"skeleton taken from {there[name].name}, which lies beside the recording")
            return there[name]
    if len(there) == 1:
        (only,) = there.values()
        assumptions.append(f"skeleton taken from {only.name}, the only .asf beside the recording")
        return only
    found = f"there are {len(there)} beside it and none is called so" if there else "there is none beside it"
    raise FileError(
        path,
        f"An .amc needs its skeleton: expected {' or '.join(wanted)}, {found}.",
        hint="Give it (--skeleton, skeleton=).",
    )


def _movement_header(file: text.TextFile, asf: Asf) -> tuple[bool, int]:
    """Whether angles are degrees, and the byte where the first frame begins."""
    degrees = asf.degrees
    position = 0
    while position < len(file.data):
        line = file.line_at(position)
        word = line.strip().upper()
        if word.startswith((b":DEGREES", b":RADIANS")):
            degrees = word.startswith(b":DEGREES")
        elif word and not word.startswith((b"#", b":")):
            break
        position += len(line) + 1
    return degrees, min(position, len(file.data))


def _read_frames(file: text.TextFile, start: int, asf: Asf) -> tuple[Array, dict[str, list[int]], list[str]]:
    """All numbers, one row a frame; the columns of each bone; what looks wrong.

    The first frame says which bones there are and in which order; frames of that layout, in practice all, are read in one
    pass, others one by one.
    """
    _, bones, _ = _frame_at(file, start, asf)
    columns: dict[str, list[int]] = {}
    free = 1
    for name, listed in bones.items():
        columns[name] = list(range(free, free + len(listed)))
        free += len(listed)
    values, stop = text.parse_labelled(file.data, start, list(bones), [len(n) for n in bones.values()])
    if stop >= 0:
        values = np.concatenate([values, _read_slowly(file, stop, asf, columns, free)])
    text.refuse_huge(file, values[:, 1:])
    numbers = values[:, 0]
    if np.any(numbers != np.floor(numbers)):
        row = int(np.argmax(numbers != np.floor(numbers)))
        file.fail(f"Expected whole frame numbers, got {numbers[row]:g} as the {row + 1}th.")
    return values, columns, _jumps(numbers)


def _read_slowly(file: text.TextFile, position: int, asf: Asf, columns: dict[str, list[int]], width: int) -> Array:
    """Frames that may list their bones in another order."""
    rows = []
    while position < len(file.data):
        start = position
        number, bones, position = _frame_at(file, position, asf)
        lacking = [name for name in columns if name not in bones]
        if lacking:
            last = not file.data[position:].strip()
            file.fail(
                f"Frame {number} has no values for {some_of(lacking)}, which the first frame has.",
                offset=len(file.data.rstrip()) if last else position,
                hint=_cut_off(number) if last else "",
            )
        extra = [name for name in bones if name not in columns]
        if extra:
            file.fail(f"Frame {number} has values for {some_of(extra)}, which the first frame lacks.", offset=start)
        row = np.zeros(width)
        row[0] = number
        for name, numbers in bones.items():
            row[columns[name]] = numbers
        rows.append(row)
        position += len(file.data[position:]) - len(file.data[position:].lstrip())
    return np.array(rows).reshape(-1, width)


def _frame_at(file: text.TextFile, position: int, asf: Asf) -> tuple[int, dict[str, list[float]], int]:
    """The frame that begins at a byte: its number, its bones' values, and the byte where the next begins."""
    number: int | None = None
    bones: dict[str, list[float]] = {}
    while position < len(file.data):
        line = file.line_at(position)
        words = text.decode(line.split(b"#")[0]).split()
        if len(words) == 1 and words[0].isascii() and words[0].isdigit() and len(words[0]) < 16:
            if number is not None:
                break
            number = int(words[0])
        elif words:
            if number is None:
                hint = (
                    f"Perhaps the first frame has no '{words[0]}'; all frames must have the same bones."
                    if words[0] in asf.bones
                    else ""
                )
                file.fail(f"Expected a frame number, got '{text.short(' '.join(words))}'.", offset=position, hint=hint)
            if words[0] in bones:
                file.fail(f"Frame {number} has '{words[0]}' twice.", offset=position)
            bones[words[0]] = _bone_values(file, words, position, asf, number)
        position += len(line) + 1
    if number is None:
        file.fail("There are no frames in this file.", offset=len(file.data))
    if not bones:
        last = not file.data[position:].strip()
        file.fail(f"Frame {number} has no values.", offset=position, hint=_cut_off(number) if last else "")
    return number, bones, min(position, len(file.data))


def _cut_off(number: int) -> str:
    """What to do where the file ends within a frame."""
    return f"{text.CUT_OFF} in frame {number}: {text.GET_AGAIN}, or delete what there is of that frame."


def _bone_values(file: text.TextFile, words: list[str], position: int, asf: Asf, frame: int) -> list[float]:
    """The numbers of one bone's line."""
    bone = asf.bones.get(words[0])
    last = file.ends_with_line_at(position)
    # a last name or number may be cut to its beginning, which no line end follows
    halved = last and not file.data.endswith(b"\n")
    if bone is None:
        if halved and len(words) == 1 and any(name.startswith(words[0]) for name in asf.bones):
            file.fail(f"Frame {frame} ends with '{words[0]}'.", offset=position, hint=_cut_off(frame))
        file.fail(
            f"'{text.short(words[0])}' is no bone of {asf.path.name}.",
            offset=position,
            hint=f"Its bones are: {', '.join(asf.bones)}. Is it the skeleton of this recording?",
        )
    values = []
    for place, word in enumerate(words[1:], start=2):
        try:
            values.append(text.number(word))
        except ValueError:
            hint = _cut_off(frame) if halved and place == len(words) else ""
            file.fail(f"{bone.name}: {text.why_not_a_number(word)}", offset=position, hint=hint)
    if len(values) != len(bone.dofs):
        listed = f" ({' '.join(bone.dofs)})" if bone.dofs else ""
        file.fail(
            f"Expected {len(bone.dofs)} values{listed} for '{bone.name}', got {len(values)}.",
            offset=position,
            hint=_cut_off(frame) if last and len(values) < len(bone.dofs) else "",
        )
    return values


def _jumps(numbers: Array) -> list[str]:
    """Where frame numbers do not go up by one."""
    steps = np.diff(numbers)
    wrong = np.flatnonzero(steps != 1)
    if len(wrong) == 0:
        return []
    if len(steps) > 1 and np.all(steps == steps[0]) and steps[0] > 1:
        return [f"frame numbers go up by {steps[0]:g}: frames may have been left out, and the frame rate be lower"]
    first = int(wrong[0])
    places = "once" if len(wrong) == 1 else f"{len(wrong)} times, first"
    return [
        f"frame numbers jump {places} from {numbers[first]:g} to {numbers[first + 1]:g} (frame {first + 1} of the motion): "
        "frames may be missing there"
    ]


def _frame_rate(file: text.TextFile, options: ReadOptions) -> tuple[float, tuple[str, ...]]:
    if options.fps is not None:
        return options.fps, ()
    said = _SAID_FPS.search(file.data[:8192])
    if said is not None:
        try:
            fps = text.number(said[1])
        except ValueError:
            fps = 0.0
        if not 1e-4 <= fps <= 1e5:
            file.fail(f"A rate of {text.decode(said[1])} frames a second cannot be.", offset=said.start())
        return fps, ()
    subject = re.fullmatch(r"(\d{1,3})_\d{2,3}", file.path.stem)
    if subject is not None and int(subject[1]) in CMU_60_FPS:
        return 60.0, (f"60 frames a second: subject {int(subject[1])} of the CMU database was captured so",)
    return 120.0, ("120 frames a second: as in the CMU database; the file does not say",)


def _known_unit(asf: Asf, options: ReadOptions, assumptions: list[str]) -> float | None:
    """Metres in a unit, where the skeleton has a length scale; a scale of 1 is what files have that know nothing of it."""
    if asf.length is None or asf.length == 1.0:
        return None
    unit = conventions.UNITS["in"] / asf.length
    if options.unit is None:
        assumptions.append(f"unit {unit:.5g} m: 1/{asf.length:g} inch, by the length scale in {asf.path.name}")
    return unit


FORMAT: Final = Format(
    name="asf_amc", title="Acclaim ASF/AMC", suffixes=(".amc", ".asf"), sniff=sniff, read=read, write=write
)
