"""What the functions of this room accept, checked once at the door."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinesics.body.pose import PoseSequence
from kinesics.errors import InputError
from kinesics.vocabulary import LINKS, MIRROR_LINKS

Array = NDArray[np.float64]
Floats = NDArray[np.float32]
Poses = PoseSequence | ArrayLike
Weights = Mapping[str, float] | ArrayLike


class Checked(NamedTuple):
    """Poses as every algorithm here wants them."""

    quaternions: Array
    """Unit, float64, C-contiguous, shape (frames, 15, 4)."""
    fps: float | None


def check_poses(poses: Poses, name: str = "poses") -> Checked:
    """Take a `PoseSequence`, or an array (frames, 15, 4) of unit quaternions.

    Raises
    ------
    InputError
        If the shape is another, there is no frame, or a quaternion is not finite or not of length 1 (to .001).
    """
    if isinstance(poses, PoseSequence):
        return Checked(poses.quaternions, poses.fps)
    try:
        q = np.ascontiguousarray(poses, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InputError(
            f"Expected `{name}` to be a PoseSequence or an array of shape (frames, 15, 4), got {type(poses).__name__}. "
            "Poses of a motion: kinesics.poses(motion)."
        ) from error
    if q.ndim != 3 or q.shape[1:] != (len(LINKS), 4):
        raise InputError(f"Expected `{name}` of shape (frames, {len(LINKS)}, 4), got {q.shape}.")
    if len(q) == 0:
        raise InputError(f"Expected `{name}` to hold at least one frame, got none.")
    norm = np.sqrt(np.einsum("fji,fji->fj", q, q))
    bad = ~(np.abs(norm - 1.0) < 1e-3)
    if bad.any():
        frame, link = (int(v) for v in np.argwhere(bad)[0])
        raise InputError(
            f"Expected unit quaternions in `{name}`; that of {LINKS[link]} in frame {frame} has length "
            f"{norm[frame, link]:.4g}."
        )
    return Checked(q / norm[..., None], None)


def check_weights(weights: Weights | None) -> Array:
    """One weight for each of the 15 links, shape (15,); None weighs all alike.

    A mapping names links of `kinesics.vocabulary.LINKS`, or limbs without their side ("femur", "tibia", "humerus",
    "radius") for both; links it does not name weigh 1.

    Raises
    ------
    InputError
        If a name is unknown, a weight is negative or not finite, all are 0, or a left one differs from its right one (D* would
        not be symmetric).
    """
    count = len(LINKS)
    if weights is None:
        return np.ones(count)
    if isinstance(weights, Mapping):
        out = np.ones(count)
        limbs = {name.removeprefix("left_") for name in LINKS if name.startswith("left_")}
        unknown = [str(name) for name in weights if name not in LINKS and name not in limbs]
        if unknown:
            raise InputError(
                f"Unknown link in `weights`: {', '.join(unknown)}. Links: {', '.join(LINKS)}; "
                f"both sides at once: {', '.join(sorted(limbs))}."
            )
        for name, value in weights.items():
            for link in [name] if name in LINKS else [f"left_{name}", f"right_{name}"]:
                try:
                    out[LINKS.index(link)] = value
                except (TypeError, ValueError) as error:
                    raise InputError(f"Expected `weights` to be numbers; that of {name} is {value!r}.") from error
    else:
        try:
            out = np.array(weights, dtype=np.float64)
        except (TypeError, ValueError) as error:
            raise InputError(
                f"Expected `weights` to be {count} numbers or a mapping of link names, got {type(weights).__name__}."
            ) from error
        if out.shape != (count,):
            raise InputError(f"Expected `weights` of shape ({count},), one for each link, got {out.shape}.")
    if not np.isfinite(out).all() or (out < 0.0).any():
        link = LINKS[int(np.argmax(~(np.isfinite(out) & (out >= 0.0))))]
        raise InputError(
            f"Expected `weights` that are finite and not negative; that of {link} is {out[LINKS.index(link)]}."
        )
    if not out.any():
        raise InputError("Expected at least one of `weights` above 0.")
    uneven = [LINKS[i] for i, j in enumerate(MIRROR_LINKS) if i < j and out[i] != out[j]]
    if uneven:
        raise InputError(
            f"Left and right `weights` must be equal, or D* is not symmetric; they differ for {', '.join(uneven)}."
        )
    return out


def check_outputs(
    shape: tuple[int, int], out: tuple[Floats, Floats] | None, names: tuple[str, str]
) -> tuple[Floats, Floats]:
    """The pair of arrays to write into: the given ones, or fresh ones.

    Raises
    ------
    InputError
        If they are not two float32 arrays of that shape, C-contiguous, writeable and apart.
    """
    if out is None:
        return np.empty(shape, dtype=np.float32), np.empty(shape, dtype=np.float32)
    if not isinstance(out, tuple | list) or len(out) != 2:
        raise InputError(f"Expected `out` to be the pair ({', '.join(names)}).")
    for name, array in zip(names, out, strict=True):
        if not isinstance(array, np.ndarray) or array.dtype != np.float32 or array.shape != shape:
            came = f"{array.dtype} {array.shape}" if isinstance(array, np.ndarray) else type(array).__name__
            raise InputError(f"Expected `out` {name} to be a float32 array of shape {shape}, got {came}.")
        if not array.flags.c_contiguous or not array.flags.writeable:
            raise InputError(f"Expected `out` {name} to be C-contiguous and writeable.")
    if np.may_share_memory(*out):
        raise InputError(f"Expected `out` {names[0]} and {names[1]} not to overlap.")
    return out[0], out[1]
