"""The skeleton of an ASF/AMC recording (.asf): its bones as they stand, and the `Skeleton` of joints that they make.

What the two files mean is told in `kinesics.formats.asf_amc`.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final, NoReturn

import numpy as np
from numpy.typing import NDArray

from kinesics.body.skeleton import EndSite, JointFreedom, Skeleton
from kinesics.errors import FileError, some_of
from kinesics.formats import angles, load, text
from kinesics.geometry import euler

Array = NDArray[np.float64]

HELPERS: Final = "bones that only lead to others:"
"""In the documentation of skeletons written here: what follows are no joints of the body."""

_SECTION = re.compile(
    rb"^[ \t]*:(version|name|units|documentation|root|bonedata|hierarchy)\b", re.IGNORECASE | re.MULTILINE
)


def is_skeleton(head: bytes) -> bool:
    """Whether a file begins as an .asf does."""
    return len({m[1].lower() for m in _SECTION.finditer(head)}) >= 2


@dataclass
class Bone:
    """As the file has it: in its units, angles in degrees or radians as the file says."""

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
        """Its far end, from its joint."""
        return np.array(self.direction) * self.length

    def turning(self) -> str:
        """Axes about which it turns, such as "xz"."""
        return "".join(dof[1] for dof in self.dofs if dof[0] == "r")

    def shifting(self) -> str:
        """Axes along which it shifts."""
        return "".join(dof[1] for dof in self.dofs if dof[0] == "t")

    def columns(self, kind: str) -> list[int]:
        """Places of its turning ("r") or shifting ("t") numbers on its line."""
        return [k for k, dof in enumerate(self.dofs) if dof[0] == kind]


@dataclass
class Asf:
    """A skeleton file."""

    path: Path
    name: str = ""
    length: float | None = None
    degrees: bool = True
    position: tuple[float, ...] = (0.0, 0.0, 0.0)
    bones: dict[str, Bone] = field(default_factory=dict)
    """By name, parents before children; the first is the root."""
    helpers: set[str] = field(default_factory=set)
    """Bones that only lead to others, where the file says so: no joints of the body."""
    warnings: list[str] = field(default_factory=list)


def read_asf(path: Path) -> Asf:
    """A skeleton file as it stands.

    Raises
    ------
    FileError
        If it is missing or damaged, with the line.
    """
    file = text.TextFile.of(path, load(path))
    if not is_skeleton(file.data[:65536]):
        raise FileError(path, "Expected a skeleton (.asf), but the file does not begin as one.")
    return _AsfReader(file).read()


class _AsfReader:
    """Reads a skeleton line by line."""

    def __init__(self, file: text.TextFile) -> None:
        self.file = file
        self.asf = Asf(file.path)
        self.line = 0
        self.root = Bone("root", 0, dofs=("tx", "ty", "tz", "rx", "ry", "rz"))
        self.links: list[tuple[int, list[str]]] = []
        self.parsed: dict[str, Bone] = {}
        self.bone: Bone | None = None
        self.in_limits = False

    def read(self) -> Asf:
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
            if section == "documentation" and line.startswith(HELPERS):
                self.asf.helpers = set(line.removeprefix(HELPERS).split())
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
            self.bone = Bone("", self.line)
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

    def _close_bone(self, bone: Bone) -> None:
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
            self.asf.warnings.append(f"{self.file.path.name}: {some_of(lost)} not connected with the root: left out")
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


def skeleton_of(asf: Asf) -> Skeleton:
    """The joints, in the file's unit."""
    bones = list(asf.bones.values())
    index = {b.name: j for j, b in enumerate(bones)}
    unit = angles.DEGREE if asf.degrees else 1.0
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


def _is_number(word: str) -> bool:
    try:
        text.number(word)
    except ValueError:
        return False
    return True
