"""BVH: Biovision hierarchy, one text file with the skeleton and one line of numbers a frame.

Angles are degrees, listed as an intrinsic sequence: channels ``Zrotation Xrotation Yrotation`` are R = Rz·Rx·Ry. Position
channels take the place of the joint's OFFSET. Unit, up axis and meaning of the rest pose are nowhere in the file.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final, NoReturn

import numpy as np
from numpy.typing import NDArray

from kinesics.body.skeleton import EndSite, JointFreedom, Skeleton
from kinesics.formats import angles, text
from kinesics.formats.bvh_writing import write
from kinesics.formats.registry import Format, ReadOptions, Recording
from kinesics.geometry import quaternion

Array = NDArray[np.float64]

_LARGEST_HEADER = 16 << 20
_MOTION = re.compile(rb"^[ \t]*MOTION[ \t\r]*$", re.IGNORECASE | re.MULTILINE)
_COMMENT = re.compile(r"^[ \t]*(?:#|//)[^\n]*", re.MULTILINE)
_WORD = re.compile(r"[{}]|[^\s{}]+")
_FRAMES = re.compile(rb"\s*Frames\b\s*:?\s*(\S*)\s*$", re.IGNORECASE)
_FRAME_TIME = re.compile(rb"\s*Frame\s*Time\b\s*:?\s*(\S*)\s*$", re.IGNORECASE)
_CHANNEL = re.compile(r"([XYZ])(position|rotation)", re.IGNORECASE)
_CUT_BEFORE_FRAMES = f"{text.CUT_OFF} before its first frame: {text.GET_AGAIN}."
_SAME_PLACE = 1e-6
"""Of the skeleton's size: a position channel that stays this near to the OFFSET says nothing that the OFFSET does not."""

_USUAL_RATES = frozenset((
    10, 12, 15, 20, 24, 25, 30, 40, 48, 50, 60, 72, 75, 90, 100, 120, 144, 150, 180, 200,
    240, 250, 300, 360, 480, 500, 1000,
))  # fmt: skip


def sniff(head: bytes) -> bool:
    """Whether a file begins as a BVH does."""
    if head.startswith((b"\xff\xfe", b"\xfe\xff")):
        head = head.replace(b"\0", b"")[2:]
    first = _COMMENT.sub("", head.removeprefix(b"\xef\xbb\xbf").decode("latin-1").replace("\r", "\n")).split(None, 1)
    return bool(first) and first[0].upper() == "HIERARCHY"


@dataclass
class _Joint:
    name: str
    parent: int
    line: int
    offset: tuple[float, float, float] | None = None
    channels: list[tuple[str, str]] | None = None
    """("x", "position") and the like, in the order of the file."""
    first_column: int = 0

    def axes(self, kind: str) -> str:
        return "".join(axis for axis, what in self.channels or () if what == kind)

    def columns(self, kind: str) -> list[int]:
        return [self.first_column + k for k, (_, what) in enumerate(self.channels or ()) if what == kind]


@dataclass
class _Hierarchy:
    joints: list[_Joint] = field(default_factory=list)
    sites: list[tuple[int, tuple[float, float, float]]] = field(default_factory=list)
    columns: int = 0
    assumptions: list[str] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)


def read(path: Path, raw: bytes, options: ReadOptions) -> Recording:
    """A BVH in its own unit and axes.

    Raises
    ------
    FileError
        If it is damaged, with the line.
    """
    file = text.TextFile.of(path, raw)
    motion = _MOTION.search(file.data, 0, _LARGEST_HEADER)
    if motion is None:
        _HeaderReader(file, text.decode(file.data[:_LARGEST_HEADER]), ends_file=True).read()
        file.fail("Expected a line MOTION after the skeleton.", offset=len(file.data.rstrip()), hint=_CUT_BEFORE_FRAMES)
    tree = _HeaderReader(file, text.decode(file.data[: motion.start()])).read()
    fps, values = _read_motion(file, motion.end(), tree, options)
    skeleton = _skeleton(tree)
    joints = tree.joints
    rotations = angles.rotations_of_columns(
        values, [j.columns("rotation") for j in joints], [j.axes("rotation") for j in joints], angles.DEGREE
    )
    roots = _placed(joints[0], skeleton.offsets[0], values)
    if joints[0].axes("position") and np.any(skeleton.offsets[0]):
        numbers = " ".join(f"{v:g}" for v in skeleton.offsets[0])
        tree.assumptions.append(f"the root's OFFSET ({numbers}) is not added: its position channels take its place")
    shifts = _moving_joints(joints, skeleton.offsets, values)
    if options.skeleton is not None:
        tree.assumptions.append("the skeleton file is not used: a BVH has its own")
    first = 0
    if not options.keep_first_frame and _inserted_first_frame(values, joints, rotations, roots):
        tree.assumptions.append("frame 0 is an inserted T-pose: dropped")
        first = 1
    return Recording(
        skeleton=skeleton,
        rotations=rotations[first:],
        root_positions=roots[first:],
        fps=fps,
        joint_translations=None if shifts is None else shifts[first:],
        assumptions=tuple(tree.assumptions),
        warnings=tuple(tree.warnings),
        details=_odd_channel_orders(joints),
    )


class _HeaderReader:
    """Reads the part before MOTION, word by word; it may also be where the file ends."""

    def __init__(self, file: text.TextFile, header: str, *, ends_file: bool = False) -> None:
        self.file = file
        self.ends_file = ends_file
        # comments are blanked and not cut out, so that lines keep their numbers
        self.text = _COMMENT.sub("", header)
        self.position = 0
        self.line = 1

    def read(self) -> _Hierarchy:
        """The whole tree; of several roots the first."""
        tree = _Hierarchy()
        begin = self._word()
        if begin.upper() != "HIERARCHY":
            # other text is no half of a BVH
            self.ends_file &= "HIERARCHY".startswith(begin.upper())
            self._fail(f"Expected a BVH to begin with HIERARCHY, got '{text.short(begin)}'.")
        roots: list[int] = []
        column = 0
        while (word := self._word(end=True)) != "":
            if word.upper() != "ROOT":
                self._fail(f"Expected ROOT or MOTION, got '{text.short(word)}'.")
            roots.append(len(tree.joints))
            column = self._read_root(tree, column)
        if not roots:
            self._fail("Expected a ROOT joint.")
        tree.columns = column
        if column == 0:
            self._fail("No joint has a channel: nothing moves in this file.")
        if len(roots) > 1:
            tree.warnings.append(
                f"{len(roots)} skeletons in one file: only the first, '{tree.joints[0].name}', is read"
            )
            kept = roots[1]
            del tree.joints[kept:]
            tree.sites = [s for s in tree.sites if s[0] < kept]
        self._make_names_unique(tree)
        return tree

    def _read_root(self, tree: _Hierarchy, column: int) -> int:
        """One root with all that hangs on it; returns the next free column."""
        open_blocks = [self._open_joint(tree, -1)]
        while open_blocks:
            here = open_blocks[-1]
            word = self._word()
            keyword = word.upper()
            if keyword == "OFFSET":
                offset = (self._number("OFFSET"), self._number("OFFSET"), self._number("OFFSET"))
                if here < 0:
                    tree.sites.append((~here, offset))
                else:
                    tree.joints[here].offset = offset
            elif keyword == "}":
                if here >= 0 and tree.joints[here].offset is None:
                    self._fail(f"The joint '{tree.joints[here].name}' has no OFFSET.")
                open_blocks.pop()
            elif keyword == "CHANNELS" and here >= 0:
                if tree.joints[here].channels is not None:
                    self._fail(f"The joint '{tree.joints[here].name}' has CHANNELS twice.")
                tree.joints[here].channels = self._channels()
                tree.joints[here].first_column = column
                column += len(tree.joints[here].channels or ())
            elif keyword == "JOINT" and here >= 0:
                open_blocks.append(self._open_joint(tree, here))
            elif keyword == "END" and here >= 0:
                self._rest_of_line()
                self._open_brace("End Site")
                # an end site is known by the joint that it hangs on; ~ keeps it apart from a joint
                open_blocks.append(~here)
            else:
                expected = "OFFSET, CHANNELS, JOINT, End Site or }" if here >= 0 else "OFFSET or }"
                self._fail(f"Expected {expected}, got '{text.short(word)}'.")
        return column

    def _open_joint(self, tree: _Hierarchy, parent: int) -> int:
        line = self.line
        name = self._rest_of_line()
        if not name:
            self._fail("Expected the name of a joint.", line=line)
        self._open_brace(name)
        tree.joints.append(_Joint(name, parent, line))
        return len(tree.joints) - 1

    def _open_brace(self, name: str) -> None:
        word = self._word()
        if word != "{":
            self._fail(f"Expected {{ after '{text.short(name)}', got '{text.short(word)}'.")

    def _channels(self) -> list[tuple[str, str]]:
        word = self._word()
        if not word.isascii() or not word.isdigit() or int(word[:9]) > 6:
            self._fail(f"Expected a number of CHANNELS from 0 to 6, got '{text.short(word)}'.")
        found: list[tuple[str, str]] = []
        for _ in range(int(word)):
            name = self._word()
            channel = _CHANNEL.fullmatch(name)
            if channel is None:
                self._fail(f"Expected a channel such as Xposition or Zrotation, got '{text.short(name)}'.")
            found.append((channel[1].lower(), channel[2].lower()))
        if len(set(found)) != len(found):
            self._fail("A channel is listed twice for one joint.")
        return found

    def _number(self, what: str) -> float:
        word = self._word()
        try:
            value = text.number(word)
        except ValueError:
            self._fail(f"Expected three numbers after {what}: {text.why_not_a_number(word)}")
        if abs(value) > text.LARGEST_VALUE:
            self._fail(f"{what} {word} is no length that a body can have.")
        return value

    def _word(self, *, end: bool = False) -> str:
        """The next word; "" at the end where that is allowed."""
        found = _WORD.search(self.text, self.position)
        stop = len(self.text) if found is None else found.start()
        self.line += self.text.count("\n", self.position, stop)
        if found is None:
            self.position = stop
            if not end:
                self._fail("The skeleton ends before all its brackets are closed.")
            return ""
        self.position = found.end()
        return found[0]

    def _rest_of_line(self) -> str:
        """What is left of the line, up to a bracket: names may have spaces in them."""
        stop = len(self.text)
        for mark in "\n{}":
            here = self.text.find(mark, self.position, stop)
            stop = stop if here < 0 else here
        rest = self.text[self.position : stop].strip()
        self.position = stop
        return rest

    def _fail(self, problem: str, *, line: int | None = None) -> NoReturn:
        # what does not fit at the very end of a file is most often half of what stood there
        cut = self.ends_file and not self.text[self.position :].strip()
        if cut:
            line = self.text.count("\n", 0, len(self.text.rstrip())) + 1
        self.file.fail(problem, line=line or self.line, hint=_CUT_BEFORE_FRAMES if cut else "")

    def _make_names_unique(self, tree: _Hierarchy) -> None:
        taken = {joint.name for joint in tree.joints}
        seen: set[str] = set()
        for joint in tree.joints:
            if joint.name in seen:
                number = 2
                while f"{joint.name}_{number}" in taken:
                    number += 1
                new = f"{joint.name}_{number}"
                tree.assumptions.append(
                    f"two joints are called '{joint.name}': the one on line {joint.line} is called '{new}'"
                )
                taken.add(new)
                joint.name = new
            seen.add(joint.name)


def _read_motion(file: text.TextFile, position: int, tree: _Hierarchy, options: ReadOptions) -> tuple[float, Array]:
    """Frame rate, and one row of numbers a frame."""
    promised: int | None = None
    frame_time: str | None = None
    frame_time_line = frames_line = 0
    frame_time_cut = ""
    while position < len(file.data):
        line = file.line_at(position)
        if (found := _FRAMES.match(line)) is not None:
            frames_line = file.line_number(position)
            promised = _frame_count(file, text.decode(found[1]), frames_line, _cut_at(file, position))
        elif (found := _FRAME_TIME.match(line)) is not None:
            frame_time, frame_time_line = text.decode(found[1]), file.line_number(position)
            frame_time_cut = _cut_at(file, position)
        elif line.strip() and not line.lstrip().startswith((b"#", b"//")):
            break
        position += len(line) + 1
    position = min(position, len(file.data))
    if options.fps is not None:
        fps = options.fps
    elif frame_time is None:
        cut = b"frame time:".startswith(file.data[position:].strip().lower())
        file.fail(
            "Expected a line 'Frame Time:' after MOTION.",
            offset=len(file.data.rstrip()) if cut else position,
            hint=_CUT_BEFORE_FRAMES if cut else "Give the frame rate (--fps, fps=).",
        )
    else:
        fps, said = _frame_rate(file, frame_time, frame_time_line, frame_time_cut)
        tree.assumptions.extend(said)
    values, stop = text.parse_rows(file.data, position, tree.columns)
    if stop >= 0:
        _explain_row(file, stop, tree, _Frames(len(values), promised, frames_line))
    if promised is not None and len(values) < promised:
        frames = _Frames(len(values), promised, frames_line)
        file.fail(
            f"Expected {frames.expected()}, got {len(values) or 'none'}.",
            offset=len(file.data.rstrip()),
            hint=frames.cut_off(),
        )
    if len(values) == 0:
        file.fail("There are no frames in this file.", line=frames_line or None)
    if promised is not None and len(values) > promised:
        tree.warnings.append(f"line {frames_line} promises {promised} frames but there are {len(values)}: all are read")
    text.refuse_huge(file, values)
    return fps, values


@dataclass(frozen=True)
class _Frames:
    """How many frames came whole, and how many were promised, on which line."""

    whole: int
    promised: int | None
    line: int

    def expected(self) -> str:
        """What was promised, in words."""
        return f"{self.promised} {'frame' if self.promised == 1 else 'frames'} as said on line {self.line}"

    def cut_off(self, *, within_line: bool = False) -> str:
        """What to do where the file ends before its time, perhaps within its last line."""
        if self.promised is not None and self.whole >= self.promised:
            return f"The {self.expected()} are there: delete this line."
        if self.whole == 0:
            return _CUT_BEFORE_FRAMES if not within_line else f"{text.CUT_OFF} in its first frame: {text.GET_AGAIN}."
        came = ""
        if within_line:
            came = f" after {self.whole} whole {'frame' if self.whole == 1 else 'frames'}"
            came += f" of {self.promised}" if self.promised is not None else ""
        mend = ["delete this line"] if within_line else []
        mend += [] if self.promised is None else [f"write 'Frames: {self.whole}' on line {self.line}"]
        return f"{text.CUT_OFF}{came}: {text.GET_AGAIN}, or {' and '.join(mend)} to use what there is."


def _cut_at(file: text.TextFile, position: int) -> str:
    """A hint where the file ends with this line, which then may lack its word, or half of it."""
    return _CUT_BEFORE_FRAMES if file.ends_with_line_at(position) else ""


def _frame_count(file: text.TextFile, word: str, line: int, hint: str) -> int:
    try:
        count = text.number(word)
    except ValueError:
        count = -1.0
    if count < 0 or count != int(count):
        file.fail(f"Expected a number of frames after 'Frames:', got '{text.short(word)}'.", line=line, hint=hint)
    return int(count)


def _frame_rate(file: text.TextFile, word: str, line: int, hint: str) -> tuple[float, list[str]]:
    """Frames a second of a printed frame time.

    A time is printed with few digits (0.00833333): where a usual rate prints as the same digits, or a whole number of frames
    a second is as near as six digits can say, that is what is meant.
    """
    try:
        seconds = text.number(word)
    except ValueError:
        file.fail(f"Expected seconds after 'Frame Time:': {text.why_not_a_number(word)}", line=line, hint=hint)
    if not 1e-5 <= seconds <= 1e4:
        file.fail(f"A frame time of {word} s cannot be.", line=line, hint=hint or "Give the frame rate (--fps, fps=).")
    mantissa, _, exponent = word.lower().partition("e")
    last_place = 10.0 ** (int(exponent or 0) - len(mantissa.partition(".")[2]))
    fps = 1.0 / seconds
    whole = round(fps)
    off = abs(fps - whole) / fps
    usual = whole in _USUAL_RATES and off <= 0.005 and abs(1.0 / whole - seconds) <= last_place
    if usual or off < 1e-5:
        said = [] if abs(fps - whole) < 1e-9 * whole else [f"frame time {word} s means {whole} frames a second"]
        return float(whole), said
    return fps, []


def _explain_row(file: text.TextFile, offset: int, tree: _Hierarchy, frames: _Frames) -> None:
    """Say what is wrong with a line of the motion."""
    words = text.decode(file.line_at(offset)).split()
    last = file.ends_with_line_at(offset)
    # a last number may be cut to a sign or an open power, which no line end follows
    halved = last and not file.data.endswith(b"\n")
    for place, word in enumerate(words):
        try:
            text.number(word)
        except ValueError:
            names = _column_names(tree)
            where = f" ({names[place]})" if place < len(names) else ""
            hint = frames.cut_off(within_line=True) if halved and place == len(words) - 1 else ""
            file.fail(f"Value {place + 1}{where}: {text.why_not_a_number(word)}", offset=offset, hint=hint)
    hint = frames.cut_off(within_line=True) if last and len(words) < tree.columns else ""
    file.fail(
        f"Expected {tree.columns} values, one for each channel of the skeleton, got {len(words)}.",
        offset=offset,
        hint=hint,
    )


def _column_names(tree: _Hierarchy) -> list[str]:
    return [f"{axis.upper()}{what} of {j.name}" for j in tree.joints for axis, what in j.channels or ()]


def _skeleton(tree: _Hierarchy) -> Skeleton:
    freedoms = []
    for joint in tree.joints:
        turns = joint.axes("rotation")
        freedoms.append(
            JointFreedom(
                order=angles.complete_order(turns, "ZXY"),
                channels=turns,
                translation=joint.axes("position").upper(),
            )
        )
    return Skeleton(
        joint_names=tuple(j.name for j in tree.joints),
        parents=tuple(j.parent for j in tree.joints),
        offsets=np.array([j.offset for j in tree.joints]),
        end_sites=tuple(EndSite(joint, offset) for joint, offset in tree.sites),
        freedoms=tuple(freedoms),
    )


def _placed(joint: _Joint, offset: Array, values: Array) -> Array:
    """Where a joint is in its parent's frame, shape (frames, 3): its position channels, its OFFSET for those it lacks."""
    out = np.tile(offset, (len(values), 1))
    for axis, column in zip(joint.axes("position"), joint.columns("position"), strict=True):
        out[:, "xyz".index(axis)] = values[:, column]
    return out


def _moving_joints(joints: Sequence[_Joint], offsets: Array, values: Array) -> Array | None:
    """Joints in their parents' frames, shape (frames, joints, 3), if position channels say more than the OFFSETs do."""
    placed = {j: _placed(joint, offsets[j], values) for j, joint in enumerate(joints) if j and joint.axes("position")}
    tolerance = _SAME_PLACE * float(np.abs(offsets[1:]).max(initial=0.0))
    if all(np.abs(where - offsets[j]).max() <= tolerance for j, where in placed.items()):
        return None
    out = np.tile(offsets, (len(values), 1, 1))
    for j, where in placed.items():
        out[:, j] = where
    return out


def _odd_channel_orders(joints: Sequence[_Joint]) -> dict[str, str]:
    """Channels of joints that do not list positions first: `JointFreedom` cannot say that."""
    return {
        f"channels {j.name}": " ".join(axis.upper() + what for axis, what in j.channels)
        for j in joints
        if j.channels and [what for _, what in j.channels] != sorted(what for _, what in j.channels)
    }


def _inserted_first_frame(values: Array, joints: Sequence[_Joint], rotations: Array, roots: Array) -> bool:
    """Whether frame 0 is no part of the recording but a T-pose put before it, as in the cgspeed conversions of CMU.

    Such a frame is written by hand, in whole degrees, while the recording's are not; the body jumps out of it at once; and
    it stands where the recording begins, or at the origin.
    """
    if len(values) < 3:
        return False
    turning = [c for j in joints for c in j.columns("rotation")]
    if not turning:
        return False
    by_hand = np.abs(values[:2, turning] - np.round(values[:2, turning])) < 1e-6
    if not by_hand[0].all() or by_hand[1].mean() > 0.6:
        return False
    jump = float(quaternion.angle(rotations[0], rotations[1]).mean())
    step = float(quaternion.angle(rotations[1], rotations[2]).mean())
    in_place = bool(np.allclose(roots[0], roots[1], rtol=1e-6, atol=1e-6) or not roots[0, [0, 2]].any())
    return in_place and jump > 5.0 * angles.DEGREE and jump > 10.0 * step


FORMAT: Final = Format(name="bvh", title="Biovision hierarchy", suffixes=(".bvh",), sniff=sniff, read=read, write=write)
