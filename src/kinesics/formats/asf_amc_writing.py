"""A motion as .amc with its .asf beside it.

What the two files mean is told in `kinesics.formats.asf_amc`.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from kinesics.body import conventions
from kinesics.body.motion import Motion
from kinesics.body.skeleton import JointFreedom, Skeleton
from kinesics.errors import InputError
from kinesics.formats import angles
from kinesics.formats.asf import HELPERS
from kinesics.formats.registry import Written
from kinesics.geometry import euler, quaternion

Array = NDArray[np.float64]

FPS_REMARK: Final = "# frames per second:"
"""Before the frame rate, for which the format has no word."""

_ANGLE_PLACES = 7
_INCH = conventions.UNITS["in"]


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
    scale = (
        motion.source.metres_per_unit if own and motion.source.metres_per_unit != _INCH else conventions.UNITS["asf"]
    )
    skeleton = motion.skeleton
    rotations, roots = motion.rotations, motion.root_positions
    if own and motion.source.up_axis != "y":
        back = quaternion.conjugate(conventions.to_y_up(motion.source.up_axis))
        rotations, roots = conventions.rotate_world(back, rotations, roots)
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
    head = f"{FPS_REMARK} {motion.fps!r}\n:FULLY-SPECIFIED\n:DEGREES\n"
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
    columns = [turned[:, ::-1] / angles.DEGREE]
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
        return numbers(euler.as_euler(skeleton.freedoms[joint].axis, "ZYX").angles[::-1] / angles.DEGREE)

    root, *others = bones
    helpers = [bone.name for bone in bones if bone.joint is None]
    lines = [
        ":version 1.10",
        f":name {title}",
        ":units",
        "  mass 1.0",
        f"  length {_INCH / scale:.15g}",
        "  angle deg",
        ":documentation",
        "  lengths in units of 1/length inch; written by kinesics",
        *([f"  {HELPERS} {' '.join(helpers)}"] if helpers else []),
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
            lines.append(
                f"    {'limits' if k == 0 else '      '} ({low / angles.DEGREE:.12g} {high / angles.DEGREE:.12g})"
            )
        lines.append("  end")
    lines += [":hierarchy", "  begin"]
    for bone in bones:
        children = [other.name for other in others if other.parent == bone.name]
        if children:
            lines.append(f"    {bone.name} {' '.join(children)}")
    return "\n".join([*lines, "  end", ""])
