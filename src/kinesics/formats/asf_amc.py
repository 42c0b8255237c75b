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
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final, NoReturn

import numpy as np
from numpy.typing import NDArray

from kinesics.body import conventions
from kinesics.body.motion import Motion
from kinesics.body.skeleton import EndSite, JointFreedom, Skeleton
from kinesics.errors import FileError, InputError
from kinesics.formats import angles, text
from kinesics.formats.registry import Format, ReadOptions, Recording, Written
from kinesics.geometry import euler, quaternion

Array = NDArray[np.float64]

INCH: Final = 0.0254
CMU_LENGTH: Final = 0.45
"""The ``length`` of CMU's skeletons, and of those written here unless the motion has a unit of its own."""

CMU_60_FPS: Final = frozenset({33, 34, 42, 60, 61, 62, 74, 75, 77, 79, 80, 87, 88, 89})
"""Subjects of the CMU database that were captured at 60 frames a second; all others at 120."""

_DEGREE = np.pi / 180.0
_ANGLE_PLACES = 7
_FPS_REMARK = "# frames per second:"
_HELPERS = "bones that only lead to others:"
_SAID_FPS = re.compile(rb"^[ \t]*(?:# frames per second:|:SAMPLES-PER-SECOND)\s*(\S+)", re.IGNORECASE | re.MULTILINE)
_SECTION = re.compile(
    rb"^[ \t]*:(version|name|units|documentation|root|bonedata|hierarchy)\b", re.IGNORECASE | re.MULTILINE
)
_AMC_KEYWORD = re.compile(
    rb"^[ \t]*:(FULLY-SPECIFIED|DEGREES|RADIANS|SAMPLES-PER-SECOND)\b", re.IGNORECASE | re.MULTILINE
)
_AMC_FRAME = re.compile(rb"^[ \t]*\d+[ \t\r]*\n[ \t]*[A-Za-z_][^\s:]*([ \t]+[-+.\d][-+.\deE]*)+[ \t\r]*$", re.MULTILINE)


def sniff(head: bytes) -> bool:
    """Whether a file begins as an .amc or an .asf does."""
    return _is_skeleton(head) or _is_movement(head)


def _is_skeleton(head: bytes) -> bool:
    return len({m[1].lower() for m in _SECTION.finditer(head)}) >= 2


def _is_movement(head: bytes) -> bool:
    return _AMC_KEYWORD.search(head) is not None or _AMC_FRAME.search(head) is not None


@dataclass
class _Bone:
    name: str
    line: int
    direction: tuple[float, ...] = (0.0, 0.0, 0.0)
    length: float = 0.0
    axis: tuple[float, ...] = (0.0, 0.0, 0.0)
    axis_order: str = "XYZ"
    dofs: tuple[str, ...] = ()
    """Such as ("rx", "rz"), in the order of the numbers in the .amc."""
    limits: tuple[tuple[float, float], ...] = ()
    children: list[str] = field(default_factory=list)
    parent: str = ""
    gap: Array = field(default_factory=lambda: np.zeros(3))
    """From the far end of the parent to the joint, where a helper bone bridged it."""
    ends: list[Array] = field(default_factory=list)
    """Tips beyond the far end, which helper bones led to."""

    def tip(self) -> Array:
        return np.array(self.direction) * self.length

    def turning(self) -> str:
        return "".join(dof[1] for dof in self.dofs if dof[0] == "r")

    def shifting(self) -> str:
        return "".join(dof[1] for dof in self.dofs if dof[0] == "t")

    def columns(self, kind: str) -> list[int]:
        """Places of its turning ("r") or shifting ("t") numbers on its line."""
        return [k for k, dof in enumerate(self.dofs) if dof[0] == kind]


@dataclass
class _Asf:
    path: Path
    name: str = ""
    length: float | None = None
    degrees: bool = True
    position: tuple[float, ...] = (0.0, 0.0, 0.0)
    bones: dict[str, _Bone] = field(default_factory=dict)
    """By name, parents before children; the first is the root."""
    helpers: set[str] = field(default_factory=set)
    """Bones that only lead to others, where the file says so: no joints of the body."""
    warnings: list[str] = field(default_factory=list)


def read(path: Path, raw: bytes, options: ReadOptions) -> Recording:
    """An .amc on its .asf, in the skeleton's unit.

    Raises
    ------
    FileError
        If one of the two is damaged, with the line; if they do not belong together; if there is no .asf.
    """
    file = text.TextFile.of(path, raw)
    if _is_skeleton(file.data[:8192]) and not _is_movement(file.data[:8192]):
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
            f"{_some(missing)} {'does' if len(missing) == 1 else 'do'} not occur in the .amc: taken as not turning"
        )
        for name in missing:
            columns[name] = []
    unit = _DEGREE if degrees else 1.0
    turning = [[columns[b.name][k] for k in b.columns("r")] if columns.get(b.name) else [] for b in bones]
    # axes fixed in C, the first listed turned first: the intrinsic sequence is the list backwards
    rotations = angles.rotations_of_columns(
        values,
        [c[::-1] for c in turning],
        [b.turning()[::-1] if c else "" for b, c in zip(bones, turning, strict=True)],
        unit,
    )
    skeleton = _skeleton(asf)
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


def read_asf(path: Path) -> _Asf:
    """A skeleton file as it stands.

    Raises
    ------
    FileError
        If it is missing or damaged, with the line.
    """
    from kinesics.formats import load

    file = text.TextFile.of(path, load(path))
    if not _is_skeleton(file.data[:65536]):
        raise FileError(path, "Expected a skeleton (.asf), but the file does not begin as one.")
    return _AsfReader(file).read()


class _AsfReader:
    """Reads a skeleton line by line."""

    def __init__(self, file: text.TextFile) -> None:
        self.file = file
        self.asf = _Asf(file.path)
        self.line = 0
        self.root = _Bone("root", 0, dofs=("tx", "ty", "tz", "rx", "ry", "rz"))
        self.links: list[tuple[int, list[str]]] = []
        self.parsed: dict[str, _Bone] = {}
        self.bone: _Bone | None = None
        self.in_limits = False

    def read(self) -> _Asf:
        section = ""
        for raw in text.decode(self.file.data).split("\n"):
            self.line += 1
            line = raw.strip()
            if line.startswith("#") or not line:
                continue
            if line.startswith(":"):
                section, _, rest = line[1:].partition(" ")
                section = section.lower()
                if section == "name":
                    self.asf.name = rest.strip()
                continue
            if section == "documentation" and line.startswith(_HELPERS):
                self.asf.helpers = set(line.removeprefix(_HELPERS).split())
            # the definition has commas and brackets count as white space
            words = re.sub(r"[(),]", " ", line.split("#")[0]).split()
            if not words:
                continue
            if section == "units":
                self._unit(words)
            elif section == "root":
                self._root(words)
            elif section == "bonedata":
                self._bone_line(words)
            elif section == "hierarchy" and words[0].lower() not in ("begin", "end"):
                self.links.append((self.line, words))
        if self.bone is not None:
            self._fail(f"The bone '{self.bone.name}' has no 'end'.", hint="The file seems cut off.")
        self._join()
        return self.asf

    def _unit(self, words: list[str]) -> None:
        if words[0].lower() == "length":
            (self.asf.length,) = self._numbers(words, 1)
            if not 1e-6 < self.asf.length < 1e6:
                self._fail(f"A length scale of {words[1]} cannot be.")
        elif words[0].lower() == "angle":
            kind = words[1].lower() if len(words) > 1 else ""
            if not kind.startswith(("deg", "rad")):
                self._fail(f"Expected 'angle deg' or 'angle rad', got 'angle {text.short(kind)}'.")
            self.asf.degrees = kind.startswith("deg")

    def _root(self, words: list[str]) -> None:
        keyword = words[0].lower()
        if keyword == "order":
            self.root.dofs = self._dofs(words[1:])
        elif keyword == "axis":
            self.root.axis_order = self._order(words[1] if len(words) > 1 else "")
        elif keyword == "position":
            self.asf.position = self._numbers(words, 3)
        elif keyword == "orientation":
            self.root.axis = self._numbers(words, 3)

    def _bone_line(self, words: list[str]) -> None:
        keyword = words[0].lower()
        if keyword == "begin":
            if self.bone is not None:
                self._fail(f"The bone '{self.bone.name}' has no 'end'.")
            self.bone = _Bone("", self.line)
            return
        if self.bone is None:
            self._fail(f"Expected 'begin' of a bone, got '{text.short(words[0])}'.")
        # limits go on over several lines, which begin with a number
        if self.in_limits and (more := self._limits(words)) is not None:
            self.bone.limits += more
            return
        self.in_limits = keyword == "limits"
        if keyword == "limits":
            pairs = self._limits(words[1:])
            if pairs is None:
                self._fail("Expected limits in pairs of numbers.")
            self.bone.limits = pairs
        elif keyword == "end":
            self._close_bone(self.bone)
            self.bone = None
        elif keyword == "name":
            self.bone.name = words[1] if len(words) == 2 else self._fail("Expected 'name' and one word.")
        elif keyword == "direction":
            self.bone.direction = self._numbers(words, 3)
        elif keyword == "length":
            (self.bone.length,) = self._numbers(words, 1)
        elif keyword == "axis":
            self.bone.axis = self._numbers(words, 3)
            self.bone.axis_order = self._order(words[4] if len(words) > 4 else "XYZ")
        elif keyword == "dof":
            self.bone.dofs = self._dofs(words[1:])

    def _limits(self, words: list[str]) -> tuple[tuple[float, float], ...] | None:
        """Pairs of numbers, infinite ones among them; None if the line is something else."""
        try:
            numbers = [float(w) for w in words]
        except ValueError:
            return None
        if len(numbers) % 2 or any(np.isnan(numbers)):
            self._fail("Expected limits in pairs of numbers.")
        return tuple(zip(numbers[::2], numbers[1::2], strict=True))

    def _close_bone(self, bone: _Bone) -> None:
        self.in_limits = False
        if not bone.name:
            self._fail(f"The bone that begins on line {bone.line} has no name.")
        if bone.name in self.parsed or bone.name == "root":
            self._fail(f"There are two bones called '{bone.name}'.")
        if bone.limits and len(bone.limits) != len(bone.dofs):
            self.asf.warnings.append(
                f"{self.file.path.name}: '{bone.name}' has {len(bone.limits)} limits for {len(bone.dofs)} degrees of freedom: "
                "its limits are left out"
            )
            bone.limits = ()
        self.parsed[bone.name] = bone

    def _join(self) -> None:
        """Hang the bones on one another, parents first."""
        everyone = {"root": self.root, **self.parsed}
        for line, (parent, *children) in self.links:
            for name in (parent, *children):
                if name not in everyone:
                    self._fail(
                        f"The hierarchy names a bone '{text.short(name)}' that is not among the bones.", line=line
                    )
            for name in children:
                if name == "root" or everyone[name].parent:
                    self._fail(f"The bone '{name}' hangs on two others.", line=line)
                everyone[name].parent = parent
                everyone[parent].children.append(name)
        todo = ["root"]
        while todo:
            name = todo.pop()
            self.asf.bones[name] = everyone[name]
            todo.extend(reversed(everyone[name].children))
        lost = [name for name in everyone if name not in self.asf.bones]
        if lost:
            self.asf.warnings.append(f"{self.file.path.name}: {_some(lost)} not connected with the root: left out")
        for name in self.asf.helpers:
            self._fold(name)
        if len(self.asf.bones) == 1:
            self._fail("No bone hangs on the root.", hint="The file seems cut off: there is no :hierarchy section.")

    def _fold(self, name: str) -> None:
        """Take a helper bone out: what it led to hangs on its parent, at a distance."""
        bone = self.asf.bones.get(name)
        if bone is None or bone.dofs or not bone.parent or len(bone.children) > 1:
            return
        parent = self.asf.bones[bone.parent]
        parent.children[parent.children.index(name) : parent.children.index(name) + 1] = bone.children
        if bone.children:
            child = self.asf.bones[bone.children[0]]
            child.parent, child.gap = bone.parent, bone.tip() + bone.gap + child.gap
        else:
            parent.ends.append(bone.tip())
        del self.asf.bones[name]

    def _dofs(self, words: list[str]) -> tuple[str, ...]:
        dofs = tuple(w.lower() for w in words)
        for dof in dofs:
            if dof == "l":
                self._fail("Bones that change their length (dof 'l') cannot be read.")
            if not re.fullmatch("[rt][xyz]", dof):
                self._fail(f"Expected degrees of freedom such as rx or tz, got '{text.short(dof)}'.")
        if len(set(dofs)) != len(dofs):
            self._fail("A degree of freedom is listed twice.")
        return dofs

    def _order(self, word: str) -> str:
        if sorted(word.upper()) != ["X", "Y", "Z"]:
            self._fail(f"Expected an order of axes such as XYZ, got '{text.short(word)}'.")
        return word.upper()

    def _numbers(self, words: list[str], count: int) -> tuple[float, ...]:
        try:
            numbers = tuple(text.number(w) for w in words[1 : 1 + count])
        except ValueError:
            bad = next(w for w in words[1 : 1 + count] if not _is_number(w))
            self._fail(f"{words[0]}: {text.why_not_a_number(bad)}")
        if len(numbers) != count:
            self._fail(f"Expected {count} number{'s' * (count > 1)} after '{words[0]}', got {len(numbers)}.")
        if any(abs(n) > text.LARGEST_VALUE for n in numbers):
            self._fail(f"'{words[0]}' is larger than anything of a body can be.")
        return numbers

    def _fail(self, problem: str, *, line: int | None = None, hint: str = "") -> NoReturn:
        self.file.fail(problem, line=line or self.line, hint=hint)


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


def _skeleton(asf: _Asf) -> Skeleton:
    bones = list(asf.bones.values())
    index = {b.name: j for j, b in enumerate(bones)}
    unit = _DEGREE if asf.degrees else 1.0
    offsets = np.zeros((len(bones), 3))
    sites = []
    freedoms = []
    for j, bone in enumerate(bones):
        tip = bone.tip()
        ends = [tip + end for end in bone.ends]
        if not bone.children and j and tip.any():
            ends.insert(0, tip)
        sites += [EndSite(j, (float(end[0]), float(end[1]), float(end[2]))) for end in ends]
        for child in bone.children:
            offsets[index[child]] = tip + asf.bones[child].gap
        # about axes fixed in the world, the first letter first: as an intrinsic sequence, backwards
        letters = bone.axis_order[::-1]
        c = euler.from_euler([bone.axis["XYZ".index(a)] * unit for a in letters], letters)
        limited = [k for k in bone.columns("r") if bone.limits]
        freedoms.append(
            JointFreedom(
                order=angles.complete_order(bone.turning()[::-1], "ZYX"),
                channels=bone.turning(),
                translation=bone.shifting().upper(),
                axis=(float(c[0]), float(c[1]), float(c[2]), float(c[3])) if any(bone.axis) else (1.0, 0.0, 0.0, 0.0),
                limits=tuple((bone.limits[k][0] * unit, bone.limits[k][1] * unit) for k in limited),
            )
        )
    return Skeleton(
        joint_names=tuple(index),
        parents=tuple(index[b.parent] if b.parent else -1 for b in bones),
        offsets=offsets,
        end_sites=tuple(sites),
        freedoms=tuple(freedoms),
        name=asf.name,
    )


def _movement_header(file: text.TextFile, asf: _Asf) -> tuple[bool, int]:
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


def _read_frames(file: text.TextFile, start: int, asf: _Asf) -> tuple[Array, dict[str, list[int]], list[str]]:
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


def _read_slowly(file: text.TextFile, position: int, asf: _Asf, columns: dict[str, list[int]], width: int) -> Array:
    """Frames that may list their bones in another order."""
    rows = []
    while position < len(file.data):
        start = position
        number, bones, position = _frame_at(file, position, asf)
        lacking = [name for name in columns if name not in bones]
        if lacking:
            last = not file.data[position:].strip()
            file.fail(
                f"Frame {number} has no values for {_some(lacking)}, which the first frame has.",
                offset=len(file.data.rstrip()) if last else position,
                hint="The file seems cut off." if last else "",
            )
        extra = [name for name in bones if name not in columns]
        if extra:
            file.fail(f"Frame {number} has values for {_some(extra)}, which the first frame lacks.", offset=start)
        row = np.zeros(width)
        row[0] = number
        for name, numbers in bones.items():
            row[columns[name]] = numbers
        rows.append(row)
        position += len(file.data[position:]) - len(file.data[position:].lstrip())
    return np.array(rows).reshape(-1, width)


def _frame_at(file: text.TextFile, position: int, asf: _Asf) -> tuple[int, dict[str, list[float]], int]:
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
        elif words and number is None:
            hint = (
                f"Perhaps the first frame has no '{words[0]}'; all frames must have the same bones."
                if words[0] in asf.bones
                else ""
            )
            file.fail(f"Expected a frame number, got '{text.short(' '.join(words))}'.", offset=position, hint=hint)
        elif words:
            if words[0] in bones:
                file.fail(f"Frame {number} has '{words[0]}' twice.", offset=position)
            bones[words[0]] = _bone_values(file, words, position, asf)
        position += len(line) + 1
    if number is None:
        file.fail("There are no frames in this file.", offset=len(file.data))
    if not bones:
        file.fail(f"Frame {number} has no values.", offset=position, hint="The file seems cut off.")
    return number, bones, min(position, len(file.data))


def _bone_values(file: text.TextFile, words: list[str], position: int, asf: _Asf) -> list[float]:
    """The numbers of one bone's line."""
    bone = asf.bones.get(words[0])
    if bone is None:
        file.fail(
            f"'{text.short(words[0])}' is no bone of {asf.path.name}.",
            offset=position,
            hint=f"Its bones are: {', '.join(asf.bones)}. Is it the skeleton of this recording?",
        )
    values = []
    for word in words[1:]:
        try:
            values.append(text.number(word))
        except ValueError:
            file.fail(f"{bone.name}: {text.why_not_a_number(word)}", offset=position)
    if len(values) != len(bone.dofs):
        listed = f" ({' '.join(bone.dofs)})" if bone.dofs else ""
        last = not file.data[position + len(file.line_at(position)) :].strip()
        file.fail(
            f"Expected {len(bone.dofs)} values{listed} for '{bone.name}', got {len(values)}.",
            offset=position,
            hint="The file seems cut off." if last and len(values) < len(bone.dofs) else "",
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


def _known_unit(asf: _Asf, options: ReadOptions, assumptions: list[str]) -> float | None:
    """Metres in a unit, where the skeleton has a length scale; a scale of 1 is what files have that know nothing of it."""
    if asf.length is None or asf.length == 1.0:
        return None
    unit = INCH / asf.length
    if options.unit is None:
        assumptions.append(f"unit {unit:.5g} m: 1/{asf.length:g} inch, by the length scale in {asf.path.name}")
    return unit


def _some(names: Sequence[str]) -> str:
    shown = ", ".join(f"'{n}'" for n in names[:4])
    return shown if len(names) <= 4 else f"{shown} and {len(names) - 4} more"


def _is_number(word: str) -> bool:
    try:
        text.number(word)
    except ValueError:
        return False
    return True


@dataclass
class _BoneOut:
    """A bone to be written."""

    name: str
    parent: str
    tip: Array
    """From its joint to where its children hang."""
    joint: int | None = None
    dofs: tuple[str, ...] = ()
    limits: tuple[tuple[float, float], ...] = ()


def write(motion: Motion, path: Path) -> Written:
    """A motion as .amc with its .asf beside it, of the same name.

    Children of one bone hang at one place. Where a motion's do not, helper bones of no freedom lead to them; the
    documentation in the .asf names them, and reading takes them out again. The root is called "root".

    Raises
    ------
    InputError
        If the name ends in .asf.
    """
    if path.suffix.lower() == ".asf":
        raise InputError(
            f"A recording is written as .amc, with its skeleton beside it: give '{path.with_suffix('.amc').name}'."
        )
    own = motion.source.format == "asf_amc"
    # a scale of 1 would be taken for none
    scale = motion.source.metres_per_unit if own and motion.source.metres_per_unit != INCH else INCH / CMU_LENGTH
    skeleton = motion.skeleton
    rotations, roots = motion.rotations, motion.root_positions
    if own and motion.source.up_axis != "y":
        back = quaternion.conjugate(conventions.to_y_up(motion.source.up_axis))
        first, roots = conventions.rotate_world(back, rotations[:, 0], roots)
        rotations = rotations.copy()
        rotations[:, 0] = first
    remarks: list[str] = []
    names = _writable_names(skeleton.joint_names, remarks)
    offsets, moving = _where_joints_are(motion)
    bones = _bones(skeleton, names, offsets)
    blocks: list[Array] = []
    decimals: list[int] = []
    lines = ["%d"]
    for bone in bones:
        if bone.joint is None:
            continue
        placed = roots if bone.joint == 0 else moving.get(bone.joint)
        if bone.joint and placed is not None:
            remarks.append(f"'{bone.name}' moves against its parent (dof tx ty tz), which not every program reads")
        numbers = _numbers_of(bone, skeleton.freedoms[bone.joint], rotations[:, bone.joint], placed, scale, own)
        if not bone.dofs:
            continue
        places = [_ANGLE_PLACES if dof[0] == "r" else 9 + int(np.floor(np.log10(scale))) for dof in bone.dofs]
        blocks.append(numbers)
        decimals += places
        lines.append(" ".join([bone.name, *(f"%.{p}f" for p in places)]))
    # adding 0 turns −0 into 0
    table = np.concatenate(blocks, axis=1)
    frame = "\n".join(lines)
    head = f"{_FPS_REMARK} {motion.fps!r}\n:FULLY-SPECIFIED\n:DEGREES\n"
    body = "\n".join([frame % (k, *row) for k, row in enumerate((table + 0.0).tolist(), start=1)])
    asf = _asf_text(motion, bones, scale)
    return Written(
        ((path.with_suffix(".asf"), asf.encode("utf-8")), (path, (head + body + "\n").encode("utf-8"))), tuple(remarks)
    )


def _where_joints_are(motion: Motion) -> tuple[Array, dict[int, Array]]:
    """Offsets that stay, shape (joints, 3), and for joints that move how far from there, shape (frames, 3)."""
    offsets = np.array(motion.skeleton.offsets)
    moving: dict[int, Array] = {}
    if motion.joint_translations is not None:
        for j in range(1, len(offsets)):
            placed = motion.joint_translations[:, j]
            still = float(np.ptp(placed, axis=0).max()) < 1e-7
            offsets[j] = placed.mean(axis=0) if still else offsets[j]
            if not still:
                moving[j] = placed - offsets[j]
    offsets[0] = 0.0
    return offsets, moving


def _bones(skeleton: Skeleton, names: Sequence[str], offsets: Array) -> list[_BoneOut]:
    """Bones for all joints, and those of no freedom that are needed between them; parents first."""
    sites: dict[int, list[Array]] = {}
    for site in skeleton.end_sites:
        sites.setdefault(site.parent, []).append(np.array(site.offset))
    taken = set(names)
    hangs_on = [""] * len(names)
    out: list[_BoneOut] = []

    def helper(name: str, parent: str, tip: Array) -> str:
        while name in taken:
            name += "_"
        taken.add(name)
        out.append(_BoneOut(name, parent, tip))
        return name

    for j, name in enumerate(names):
        children = skeleton.children[j]
        ends = sites.get(j, [])
        reached = [offsets[c] for c in children] or ends[:1] or [np.zeros(3)]
        together = j > 0 and all(np.abs(where - reached[0]).max() < 1e-10 for where in reached)
        tip = reached[0] if together else np.zeros(3)
        out.append(_BoneOut(name, hangs_on[j], tip, joint=j))
        for child in children:
            gap = offsets[child] - tip
            reaches = np.abs(gap).max() < 1e-10
            hangs_on[child] = name if reaches else helper(f"{names[child]}_link", name, gap)
        for end in ends if children or not together else ends[1:]:
            helper(f"{name}_end", name, end - tip)
    return out


def _numbers_of(
    bone: _BoneOut, freedom: JointFreedom, rotations: Array, shifts: Array | None, scale: float, own: bool
) -> Array:
    """A bone's columns, shape (frames, degrees of freedom); the bone is given these degrees and their limits."""
    axis = np.array(freedom.axis)
    local = quaternion.multiply(quaternion.multiply(quaternion.conjugate(axis), rotations), axis)
    axes = freedom.channels.upper()
    if not own or "".join(a for a in freedom.order if a in axes) != axes[::-1]:
        axes = "XYZ"
    order = angles.complete_order(axes[::-1], "ZYX")
    turned, missed = angles.angles_of_rotations(local, order, axes)
    if missed > 1e-7:
        axes = order[::-1]
        turned, _ = angles.angles_of_rotations(local, order, axes)
    if freedom.limits and axes == freedom.channels.upper():
        bone.limits = freedom.limits
    columns = [turned[:, ::-1] / _DEGREE]
    bone.dofs = tuple("r" + a.lower() for a in axes)
    if shifts is not None:
        # the root's are along the axes of the world, the others' along those of C
        along = shifts if bone.joint == 0 else quaternion.rotate(quaternion.conjugate(axis), shifts)
        columns.insert(0, along / scale)
        bone.dofs = ("tx", "ty", "tz", *bone.dofs)
        bone.limits = ((-np.inf, np.inf),) * 3 + bone.limits if bone.limits else ()
    return np.concatenate(columns, axis=1)


def _writable_names(names: Sequence[str], remarks: list[str]) -> list[str]:
    """Names of one word each that no keyword and no number is; the root's is "root"."""
    out = ["root"]
    if names[0] != "root":
        remarks.append(f"the root '{names[0]}' is called 'root' in the file")
    for name in names[1:]:
        clean = re.sub(r"[\s#(),]+", "_", name)
        if clean.lower() in ("", "root", "begin", "end") or clean[0] in ":+-.0123456789":
            clean = f"joint_{clean}"
        while clean in out:
            clean += "_"
        if clean != name:
            remarks.append(f"joint '{name}' is called '{clean}' in the file")
        out.append(clean)
    return out


def _asf_text(motion: Motion, bones: Sequence[_BoneOut], scale: float) -> str:
    skeleton = motion.skeleton
    title = re.sub(r"\s+", " ", skeleton.name or motion.name or "body")

    def numbers(values: Sequence[float] | Array) -> str:
        return " ".join(f"{float(v) + 0.0:.12g}" for v in values)

    def axis_of(joint: int | None) -> str:
        if joint is None:
            return "0 0 0"
        return numbers(euler.as_euler(skeleton.freedoms[joint].axis, "ZYX").angles[::-1] / _DEGREE)

    root, *others = bones
    helpers = [bone.name for bone in bones if bone.joint is None]
    lines = [
        ":version 1.10",
        f":name {title}",
        ":units",
        "  mass 1.0",
        f"  length {INCH / scale:.15g}",
        "  angle deg",
        ":documentation",
        "  lengths in units of 1/length inch; written by kinesics",
        *([f"  {_HELPERS} {' '.join(helpers)}"] if helpers else []),
        ":root",
        f"  order {' '.join(root.dofs).upper()}",
        "  axis XYZ",
        "  position 0 0 0",
        f"  orientation {axis_of(0)}",
        ":bonedata",
    ]
    for number, bone in enumerate(others, start=1):
        length = float(np.linalg.norm(bone.tip))
        direction = bone.tip / length if length else np.array([0.0, 1.0, 0.0])
        lines += [
            "  begin",
            f"    id {number}",
            f"    name {bone.name}",
            f"    direction {numbers(direction)}",
            f"    length {length / scale:.12g}",
            f"    axis {axis_of(bone.joint)} XYZ",
        ]
        if bone.dofs:
            lines.append(f"    dof {' '.join(bone.dofs)}")
        for k, (low, high) in enumerate(bone.limits):
            lines.append(f"    {'limits' if k == 0 else '      '} ({low / _DEGREE:.12g} {high / _DEGREE:.12g})")
        lines.append("  end")
    lines += [":hierarchy", "  begin"]
    for bone in bones:
        children = [other.name for other in others if other.parent == bone.name]
        if children:
            lines.append(f"    {bone.name} {' '.join(children)}")
    return "\n".join([*lines, "  end", ""])


FORMAT: Final = Format(
    name="asf_amc", title="Acclaim ASF/AMC", suffixes=(".amc", ".asf"), sniff=sniff, read=read, write=write
)
