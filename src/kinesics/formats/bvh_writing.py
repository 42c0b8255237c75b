"""A motion as BVH: the tree of its joints, and one line of numbers a frame.

What the numbers mean is told in `kinesics.formats.bvh`.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from kinesics.body import conventions
from kinesics.body.motion import Motion
from kinesics.body.skeleton import EndSite, JointFreedom, Skeleton
from kinesics.formats import angles
from kinesics.formats.registry import Written
from kinesics.geometry import quaternion

Array = NDArray[np.float64]

ANGLE_PLACES: Final = 7
"""Decimals of a degree on writing: 1e-9 radians."""


def write(motion: Motion, path: Path) -> Written:
    """A motion as BVH: in its own unit, axes and channels if it was a BVH, else in centimetres, y up."""
    own = motion.source.format == "bvh"
    scale = motion.source.metres_per_unit if own else 0.01
    up = motion.source.up_axis if own else "y"
    places = max(6, int(np.ceil(9.0 + np.log10(scale))))
    skeleton = motion.skeleton
    rotations, roots = motion.rotations, motion.root_positions
    if up != "y":
        back = quaternion.conjugate(conventions.to_y_up(up))
        rotations, roots = conventions.rotate_world(back, rotations, roots)
    names, remarks = _writable_names(skeleton.joint_names)
    channels: list[list[str]] = [[] for _ in names]
    blocks: list[Array] = []
    decimals: list[int] = []
    for j in _file_order(skeleton):
        freedom = skeleton.freedoms[j]
        placed = np.broadcast_to(skeleton.offsets[j], roots.shape)
        if j == 0:
            placed = roots
        elif motion.joint_translations is not None:
            placed = motion.joint_translations[:, j]
        columns = _positions(freedom, placed / scale, skeleton.offsets[j] / scale, root=j == 0, keep=own)
        columns |= _rotations(freedom, rotations[:, j], keep=own)
        listed = motion.source.details.get(f"channels {skeleton.joint_names[j]}", "").split() if own else []
        channels[j] = listed if sorted(listed) == sorted(columns) else list(columns)
        blocks.extend(columns[channel] for channel in channels[j])
        decimals.extend(ANGLE_PLACES if channel.endswith("rotation") else places for channel in channels[j])
    # adding 0 turns −0 into 0
    table = np.stack([np.round(b, d) + 0.0 for b, d in zip(blocks, decimals, strict=True)], axis=1)
    row = " ".join(f"%.{d}f" for d in decimals)
    lines = [row % tuple(values) for values in table.tolist()]
    head = _header(skeleton, names, channels, scale)
    head += f"MOTION\nFrames: {len(lines)}\nFrame Time: {_frame_time(motion.fps)}\n"
    return Written(((path, (head + "\n".join(lines) + "\n").encode("utf-8")),), remarks)


def _file_order(skeleton: Skeleton) -> list[int]:
    """Joints as a BVH lists them: each with all that hangs on it before the next."""
    out: list[int] = []
    todo = [0]
    while todo:
        joint = todo.pop()
        out.append(joint)
        todo.extend(reversed(skeleton.children[joint]))
    return out


def _frame_time(fps: float) -> str:
    """Seconds between frames: so many digits that they give back the rate, and that none is taken for another."""
    return np.format_float_positional(1.0 / fps, unique=True, min_digits=10)


def _positions(freedom: JointFreedom, placed: Array, offset: Array, *, root: bool, keep: bool) -> dict[str, Array]:
    """Position channels: those the file had, or all where these cannot say where the joint is."""
    axes = freedom.translation.upper() if keep else ("XYZ" if root else "")
    missed = max(
        (float(np.abs(placed[:, k] - offset[k]).max()) for k, a in enumerate("XYZ") if a not in axes), default=0.0
    )
    if missed > 1e-9 * max(1.0, float(np.abs(offset).max())):
        axes = "XYZ"
    return {f"{a}position": placed[:, "XYZ".index(a)] for a in axes}


def _rotations(freedom: JointFreedom, rotations: Array, *, keep: bool) -> dict[str, Array]:
    """Rotation channels: those the file had, or all three where these cannot say the rotation."""
    order = freedom.order.upper()
    axes = "".join(a for a in order if a.lower() in freedom.channels) if keep else order
    turned, missed = angles.angles_of_rotations(rotations, order, axes)
    if missed > 1e-7:
        axes = order
        turned, _ = angles.angles_of_rotations(rotations, order, axes)
    return {f"{a}rotation": turned[:, k] / angles.DEGREE for k, a in enumerate(axes)}


def _writable_names(names: Sequence[str]) -> tuple[list[str], tuple[str, ...]]:
    """Names that can stand on a line of their own."""
    out: list[str] = []
    remarks = []
    for name in names:
        clean = re.sub(r"[\s{}]+", " ", name).strip() or "joint"
        while clean in out:
            clean += "_"
        if clean != name:
            remarks.append(f"joint '{name}' is called '{clean}' in the file")
        out.append(clean)
    return out, tuple(remarks)


def _header(skeleton: Skeleton, names: Sequence[str], channels: Sequence[Sequence[str]], scale: float) -> str:
    sites: dict[int, list[EndSite]] = {}
    for site in skeleton.end_sites:
        sites.setdefault(site.parent, []).append(site)
    lines = ["HIERARCHY"]

    def numbers(offset: Sequence[float] | Array) -> str:
        return " ".join(f"{float(v) / scale + 0.0:.12g}" for v in offset)

    # a stack of its own and not the interpreter's: skeletons may be deep. A number opens a joint, a text is a line to come.
    todo: list[tuple[int, int | str]] = [(0, 0)]
    while todo:
        depth, item = todo.pop()
        indent = "\t" * depth
        if isinstance(item, str):
            lines.append(indent + item)
            continue
        lines += [
            f"{indent}{'ROOT' if item == 0 else 'JOINT'} {names[item]}",
            f"{indent}{{",
            f"{indent}\tOFFSET {numbers(skeleton.offsets[item])}",
            f"{indent}\tCHANNELS {len(channels[item])} {' '.join(channels[item])}".rstrip(),
        ]
        for site in sites.get(item, ()):
            lines += [
                f"{indent}\tEnd Site",
                f"{indent}\t{{",
                f"{indent}\t\tOFFSET {numbers(site.offset)}",
                f"{indent}\t}}",
            ]
        todo.append((depth, "}"))
        todo.extend((depth + 1, child) for child in reversed(skeleton.children[item]))
    return "\n".join(lines) + "\n"
