"""What a file does not say: its unit of length and which way is up, judged by the body in it."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinesics.body import kinematics
from kinesics.body.joint_names import by_name
from kinesics.body.shape import by_shape
from kinesics.body.skeleton import Skeleton
from kinesics.errors import InputError
from kinesics.geometry import quaternion

Array = NDArray[np.float64]

UNITS: Final[dict[str, float]] = {
    "m": 1.0,
    "cm": 0.01,
    "mm": 0.001,
    "in": 0.0254,
    "ft": 0.3048,
    "asf": 0.0254 / 0.45,
}
"""Metres in one unit; "asf" is the unit of the CMU database's skeleton files, 1/0.45 inch."""

_UNIT_NAMES: Final = {
    "m": "metres",
    "cm": "centimetres",
    "mm": "millimetres",
    "in": "inches",
    "ft": "feet",
    "asf": "CMU's ASF units (1/0.45 inch)",
}
_TYPICAL_LEG: Final = 0.82
"""Metres from hip joint to ankle of a grown-up: .245 + .246 of the height (Drillis and Contini 1966), 1.70 m."""
_TYPICAL_SIZE: Final = 1.7
_STEADY: Final = 0.05
"""Of the body's size, by which its lowest point may waver over a floor."""


class Conventions(NamedTuple):
    """How a file's lengths and axes relate to metres and y up."""

    metres_per_unit: float
    up_axis: str
    """"x", "y", "z" or with a minus."""
    assumptions: tuple[str, ...]
    warnings: tuple[str, ...] = ()
    """What speaks against the up axis."""


def detect(
    skeleton: Skeleton, positions: Array, *, unit: str | float | None = None, up: str | None = None
) -> Conventions:
    """Judge unit and up axis by the body.

    Parameters
    ----------
    skeleton : in the file's unit.
    positions : of all joints in the file's world and unit, shape (frames, joints, 3); a sample of frames is enough.
    unit, up : what the user says, in place of a judgement: a name of `UNITS` or metres a unit; an axis such as "z" or "-y".

    Raises
    ------
    InputError
        If ``unit`` or ``up`` is none that exists.
    """
    said: list[str] = []
    body: dict[str, int] = by_name(skeleton)
    if "head" not in body:
        # where names tell nothing the shape may
        body = {**(by_shape(skeleton, positions) or {}), **body}
    if up is None:
        up_axis, why = _detect_up(positions, body)
        said.append(f"up axis {up_axis}: {why}")
        doubts = _doubt_of_rest(skeleton, positions, body, up_axis)
    else:
        doubts = ()
        up_axis = up.lower().replace("+", "")
        if up_axis not in ("x", "y", "z", "-x", "-y", "-z"):
            raise InputError(f'Expected an up axis (--up, up=) such as "y", "z" or "-y", got "{up}".')
    if unit is None:
        scale, why = _detect_unit(positions, body)
        said.append(why)
    else:
        scale = unit_scale(unit)
    return Conventions(scale, up_axis, tuple(said), (*doubts, *_doubt_of_up(positions, body, up_axis)))


def unit_scale(unit: str | float) -> float:
    """Metres in a unit given by name or as a number of metres.

    Raises
    ------
    InputError
        If there is no such unit.
    """
    if isinstance(unit, str) and unit in UNITS:
        return UNITS[unit]
    try:
        scale = float(unit)
    except ValueError:
        scale = 0.0
    if not (np.isfinite(scale) and scale > 0):
        raise InputError(
            f'Expected a unit (--unit, unit=), one of {", ".join(UNITS)}, or a number of metres, got "{unit}".'
        )
    return scale


def to_y_up(up_axis: str) -> Array:
    """The rotation that turns a world with the given up axis into one with y up, keeping it right-handed. Shape (4,).

    For "z" the file's −y becomes +z (a quarter turn about x).
    """
    half = np.sqrt(0.5)
    return np.array(
        {
            "y": [1.0, 0.0, 0.0, 0.0],
            "z": [half, -half, 0.0, 0.0],
            "x": [half, 0.0, 0.0, half],
            "-y": [0.0, 1.0, 0.0, 0.0],
            "-z": [half, half, 0.0, 0.0],
            "-x": [half, 0.0, 0.0, -half],
        }[up_axis]
    )


def rotate_world(rotation: Array, rotations: Array, root_positions: Array) -> tuple[Array, Array]:
    """Rotations and root positions of a motion whose world is turned. Shapes (4,), (frames, joints, 4), (frames, 3)."""
    turned = rotations.copy()
    turned[:, 0] = quaternion.multiply(rotation, rotations[:, 0])
    return turned, quaternion.rotate(rotation, root_positions)


def _from_feet_to_head(positions: Array, body: dict[str, int]) -> Array | None:
    """Directions of length 1 in every frame, shape (frames, 3); None where head or feet are not known."""
    feet = [body[k] for k in ("left_foot", "right_foot", "left_tibia", "right_tibia") if k in body][:2]
    if "head" not in body or not feet:
        return None
    rise = positions[:, body["head"]] - positions[:, feet].mean(axis=1)
    return np.asarray(rise / np.maximum(np.linalg.norm(rise, axis=1), 1e-12)[:, None])


def _stands_along(share: Array) -> str | None:
    """The axis that the head is over the feet along, by the mean direction; None where it is none."""
    axis = int(np.argmax(np.abs(share)))
    # most of the time the head is over the feet; a clip spent lying down tells nothing, and y is the custom
    return ("-" if share[axis] < 0 else "") + "xyz"[axis] if abs(share[axis]) > 0.6 else None


def _detect_up(positions: Array, body: dict[str, int]) -> tuple[str, str]:
    rise = _from_feet_to_head(positions, body)
    if rise is not None:
        share = rise.mean(axis=0)
        name = _stands_along(share)
        if name is not None:
            return name, "the head is over the feet along it"
        floor = _detect_floor(positions, share)
        if floor is not None:
            return (
                floor,
                "the lowest point of the body keeps to one height along it, and the head is over the feet more than not",
            )
        return "y", "by custom, for the body does not stand in this recording (if it is not, say so: --up, up=)"
    return "y", "by custom, for head and feet are not known (if it is not, say so: --up, up=)"


def _doubt_of_up(positions: Array, body: dict[str, int], up_axis: str) -> tuple[str, ...]:
    """A sentence if the body never stands, as it does at some time in nearly every recording."""
    rise = _from_feet_to_head(positions, body)
    if rise is None or not rise.any():
        return ()
    upwards = rise[:, "xyz".index(up_axis[-1])] * (-1.0 if up_axis[0] == "-" else 1.0)
    # within 60 degrees of upright is no lying
    if upwards.max() > 0.5:
        return ()
    does = "hangs head down" if upwards.max() < -0.5 else "lies"
    along = _stands_along(rise.mean(axis=0))
    mend = "give the axis that points up (--up, up=)"
    if along is not None:
        does += f", its head over its feet along {along}"
        mend = f'read it with --up {along} (up="{along}")'
    return (f"With {up_axis} up the body never stands: it {does}. If it should stand, {mend}.",)


def _doubt_of_rest(skeleton: Skeleton, positions: Array, body: dict[str, int], up_axis: str) -> tuple[str, ...]:
    """A sentence if all but the body's direction speaks for y, by custom the axis that points up: it may lie on that floor."""
    if up_axis == "y":
        return ()
    rest = kinematics.forward(skeleton, quaternion.identity((1, skeleton.joint_count)), np.zeros((1, 3))).positions
    rise = _from_feet_to_head(rest, body)
    if rise is None or _stands_along(rise[0]) != "y" or _waver(positions, "y") > _STEADY * _size(positions):
        return ()
    return (
        f"{up_axis} is taken for up, for the head is over the feet along it; but the skeleton rests standing along y, and the "
        "lowest point of the body keeps to one height along that, too. If the body lies or props itself up here, read it with "
        '--up y (up="y").',
    )


def _waver(positions: Array, up_axis: str) -> float:
    """By how much the height of the body's lowest point varies, the standard deviation."""
    height = positions[:, :, "xyz".index(up_axis[-1])] * (-1.0 if up_axis[0] == "-" else 1.0)
    return float(height.min(axis=1).std())


def _size(positions: Array) -> float:
    """Of the body, from corner to corner."""
    return float(np.median(np.linalg.norm(np.ptp(positions, axis=1), axis=1)))


def _detect_floor(positions: Array, share: Array) -> str | None:
    """The axis along which something is always at one height, the floor, though the body tumbles; None where it is not plain.

    ``share`` is the mean direction from feet to head: the head is up more often than not, upside down or lying now and then.
    """
    if len(positions) < 8:
        return None
    waver: dict[str, float] = {}
    for axis in range(3):
        name = ("-" if share[axis] < 0 else "") + "xyz"[axis]
        if abs(share[axis]) > 0.15:
            waver[name] = _waver(positions, name)
    ranked = sorted(waver, key=lambda name: waver[name])
    if not ranked or waver[ranked[0]] > _STEADY * _size(positions):
        return None
    return ranked[0] if len(ranked) == 1 or waver[ranked[0]] < 0.3 * waver[ranked[1]] else None


def _detect_unit(positions: Array, body: dict[str, int]) -> tuple[float, str]:
    lengths = []
    for side in ("left", "right"):
        hip, knee, ankle = (body.get(f"{side}_{part}") for part in ("femur", "tibia", "foot"))
        if hip is not None and knee is not None and ankle is not None:
            lengths.append(
                float(
                    np.median(
                        np.linalg.norm(positions[:, knee] - positions[:, hip], axis=1)
                        + np.linalg.norm(positions[:, ankle] - positions[:, knee], axis=1)
                    )
                )
            )
    if lengths:
        measured, typical, what = float(np.mean(lengths)), _TYPICAL_LEG, "from hip to ankle"
    else:
        span = np.ptp(positions, axis=1)
        measured, typical, what = (
            float(np.median(np.linalg.norm(span, axis=1))),
            _TYPICAL_SIZE,
            "across the body",
        )
    if measured <= 0:
        return 0.01, "unit centimetres: by custom, for the body has no size"
    name = min(UNITS, key=lambda u: abs(np.log(measured * UNITS[u] / typical)))
    size = measured * UNITS[name]
    text = f"unit {_UNIT_NAMES[name]}: {measured:.4g} units {what} make {size:.2f} m"
    if not 0.4 < size / typical < 1.6:
        if not lengths:
            return 0.01, "unit centimetres: by custom, for no legs are known to measure it by"
        text += ", which is no grown-up's size"
    return UNITS[name], text
