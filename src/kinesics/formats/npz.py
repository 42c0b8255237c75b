"""NumPy's .npz: everything a `Motion` holds, to the last bit, and any arrays that belong to it.

One archive, made by `numpy.savez_compressed` and read with ``allow_pickle=False``. Its entries:

========================  ==================  =======================================================================
``kinesics_motion``       text (0-d)          JSON, below
``rotations``             (frames, joints, 4)  of each joint relative to its parent, unit quaternions (w, x, y, z)
``root_positions``        (frames, 3)         metres, y up
``joint_translations``    (frames, joints, 3)  metres; only where joints other than the root shift
``offsets``               (joints, 3)         from the parent's origin to the joint's, metres
``parents``               (joints,)           −1 for the root
``tip_parents``           (tips,)             joint that a tip hangs on
``tip_offsets``           (tips, 3)           metres
``anatomy_frames``        (joints, 4)         `kinesics.body.anatomy.Anatomy.frames`; only where the body is understood
``extra_NAME``            any                 arrays that were given with the motion, such as where its frames come from
========================  ==================  =======================================================================

The JSON has ``version`` (of this layout, 1), ``name``, ``fps``, ``joint_names``, ``freedoms``, ``skeleton_name``, ``source``,
``assumptions``, ``warnings`` and ``anatomy``: the fields of the classes of the same names. ``source`` is the file that the
movement was first read from, so that it can still be written as that one was.
"""

from __future__ import annotations

import dataclasses
import io
import json
import re
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from kinesics.body.anatomy import Anatomy
from kinesics.body.motion import Motion, Source
from kinesics.body.roles import Roles
from kinesics.body.skeleton import EndSite, JointFreedom, Skeleton
from kinesics.errors import FileError, InputError
from kinesics.formats.registry import Format, ReadOptions, Recording, Written

VERSION: Final = 1
"""Of the layout; a file of a later one is refused."""

_HEADER: Final = "kinesics_motion"
_EXTRA: Final = "extra_"
_MOST_BYTES: Final = 1 << 32
"""Unpacked. A zip archive can promise far more than it has."""


def sniff(head: bytes) -> bool:
    """Whether a file begins as an archive of NumPy arrays does."""
    return head.startswith(b"PK\x03\x04") and b".npy" in head[30:160]


def write(motion: Motion, path: Path, extras: Mapping[str, NDArray[Any]] | None = None) -> Written:
    """All of a motion, and ``extras``: further arrays by name.

    Raises
    ------
    InputError
        If an extra has a name of other than letters, digits and '_', or is no array of numbers or texts.
    """
    skeleton = motion.skeleton
    header: dict[str, Any] = {
        "version": VERSION,
        "name": motion.name,
        "fps": motion.fps,
        "joint_names": list(skeleton.joint_names),
        "freedoms": [dataclasses.asdict(f) for f in skeleton.freedoms],
        "skeleton_name": skeleton.name,
        "source": dataclasses.asdict(motion.source),
        "assumptions": list(motion.assumptions),
        "warnings": list(motion.warnings),
        "anatomy": None,
    }
    arrays: dict[str, NDArray[Any]] = {
        "rotations": motion.rotations,
        "root_positions": motion.root_positions,
        "offsets": skeleton.offsets,
        "parents": np.array(skeleton.parents, dtype=np.int64),
        "tip_parents": np.array([s.parent for s in skeleton.end_sites], dtype=np.int64),
        "tip_offsets": np.array([s.offset for s in skeleton.end_sites], dtype=np.float64).reshape(-1, 3),
    }
    if motion.joint_translations is not None:
        arrays["joint_translations"] = motion.joint_translations
    body = skeleton.anatomy
    if body is not None:
        arrays["anatomy_frames"] = body.frames
        header["anatomy"] = {
            "roles": dataclasses.asdict(body.roles),
            "clavicle": body.clavicle,
            "profile": body.profile,
            "assumptions": list(body.assumptions),
        }
    for name, values in (extras or {}).items():
        array = np.asarray(values)
        if not re.fullmatch(r"\w+", name):
            raise InputError(f"Expected extras with names of letters, digits and '_', got {name!r}.")
        if array.dtype.kind not in "biufcUS":
            raise InputError(f"Expected extra '{name}' to be an array of numbers or texts, got {array.dtype}.")
        arrays[_EXTRA + name] = array
    packed = io.BytesIO()
    # the header comes first: a file is recognised by how it begins. NumPy's stub takes any keyword for its `allow_pickle`
    np.savez_compressed(packed, **{_HEADER: np.array(json.dumps(header)), **arrays})  # type: ignore[arg-type]
    return Written(((path, packed.getvalue()),))


def read(path: Path, raw: bytes, options: ReadOptions) -> Recording:
    """What `write` wrote.

    Raises
    ------
    FileError
        If it is no such file, is damaged or is of a later layout.
    """
    arrays = _unpacked(path, raw)
    try:
        header = json.loads(str(arrays[_HEADER][()]))
        if header["version"] != VERSION:
            raise FileError(
                path, f"Expected layout {VERSION} of this format, got {header['version']!r}.", hint="Update kinesics."
            )
        # making a motion of it checks shapes and values
        motion = Motion(
            skeleton=_skeleton(header, arrays),
            rotations=_numbers(arrays["rotations"]),
            root_positions=_numbers(arrays["root_positions"]),
            fps=float(header["fps"]),
            joint_translations=_numbers(arrays["joint_translations"]) if "joint_translations" in arrays else None,
        )
        return Recording(
            skeleton=motion.skeleton,
            rotations=motion.rotations,
            root_positions=motion.root_positions,
            fps=motion.fps if options.fps is None else options.fps,
            joint_translations=motion.joint_translations,
            metres_per_unit=1.0,
            up_axis="y",
            assumptions=tuple(map(str, header["assumptions"])),
            warnings=tuple(map(str, header["warnings"])),
            name=str(header["name"]),
            source=_source(header["source"]),
        )
    except FileError:
        raise
    except InputError as error:
        raise FileError(path, f"What this file holds is no motion: {error}") from None
    except (LookupError, TypeError, ValueError, AttributeError, ArithmeticError, RecursionError) as error:
        # entries are taken as they come: one of another kind than ours is found where it is used
        raise FileError(path, f"This file is damaged or was not written by kinesics: {_said(error)}.") from None


def extras_of(path: Path, raw: bytes) -> dict[str, NDArray[Any]]:
    """The arrays that were given with the motion, by name.

    Raises
    ------
    FileError
        If the file is no such archive.
    """
    arrays = _unpacked(path, raw)
    return {name.removeprefix(_EXTRA): array for name, array in arrays.items() if name.startswith(_EXTRA)}


def _unpacked(path: Path, raw: bytes) -> dict[str, NDArray[Any]]:
    try:
        with zipfile.ZipFile(io.BytesIO(raw)) as archive:
            size = sum(entry.file_size for entry in archive.infolist())
        if size > _MOST_BYTES:
            raise FileError(
                path, f"Unpacked, this file has {size / 2**30:.1f} GiB; at most {_MOST_BYTES / 2**30:.0f} GiB are read."
            )
        with np.load(io.BytesIO(raw), allow_pickle=False) as archive:
            if _HEADER not in archive.files:
                raise FileError(
                    path,
                    f"This archive of NumPy arrays holds no motion: it lacks the entry '{_HEADER}'.",
                    hint="Only .npz files that kinesics wrote are read.",
                )
            return {name: archive[name] for name in archive.files}
    except FileError:
        raise
    except Exception as error:
        # at a damaged archive zipfile, zlib, NumPy and the tokenizer with which it reads headers raise errors of a dozen
        # kinds, and no list of them holds for long
        raise FileError(path, f"This archive of NumPy arrays is damaged: {_said(error)}.") from None


def _said(error: BaseException) -> str:
    return (str(error).split("\n")[0] or type(error).__name__)[:120].rstrip(".")


def _numbers(values: NDArray[Any]) -> NDArray[np.float64]:
    if values.dtype.kind not in "fiu":
        raise TypeError(f"expected numbers, got {values.dtype}")
    return values.astype(np.float64)


def _skeleton(header: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]]) -> Skeleton:
    names = tuple(map(str, header["joint_names"]))
    tips = zip(arrays["tip_parents"].tolist(), _numbers(arrays["tip_offsets"]).tolist(), strict=True)
    return Skeleton(
        joint_names=names,
        parents=tuple(arrays["parents"].tolist()),
        offsets=_numbers(arrays["offsets"]),
        end_sites=tuple(EndSite(int(parent), (x, y, z)) for parent, (x, y, z) in tips),
        freedoms=tuple(
            JointFreedom(
                order=str(f["order"]),
                channels=str(f["channels"]),
                translation=str(f["translation"]),
                axis=_four(f["axis"]),
                limits=tuple((float(low), float(high)) for low, high in f["limits"]),
            )
            for f in header["freedoms"]
        ),
        name=str(header["skeleton_name"]),
        anatomy=_anatomy(header["anatomy"], arrays, len(names)),
    )


def _anatomy(stored: Mapping[str, Any] | None, arrays: Mapping[str, NDArray[Any]], joints: int) -> Anatomy | None:
    if stored is None:
        return None
    roles: dict[str, Any] = {}
    for role in dataclasses.fields(Roles):
        value = stored["roles"][role.name]
        roles[role.name] = tuple(value) if isinstance(value, list) else value
        if role.name == "naming":
            continue
        for joint in value if isinstance(value, list) else [value]:
            if joint is not None and not (isinstance(joint, int) and 0 <= joint < joints):
                raise ValueError(f"its {role.name} is joint {joint}, and there are {joints}")
    frames = _numbers(arrays["anatomy_frames"])
    if frames.shape != (joints, 4) or not np.isfinite(frames).all():
        raise ValueError("its anatomical frames are not those of its joints")
    return Anatomy(
        roles=Roles(**roles),
        frames=frames,
        clavicle=str(stored["clavicle"]),
        profile=str(stored["profile"]),
        assumptions=tuple(map(str, stored["assumptions"])),
    )


def _source(stored: Mapping[str, Any]) -> Source | None:
    """The file that the movement was first read from; None where a program made it."""
    if not stored["format"]:
        return None
    return Source(
        format=str(stored["format"]),
        file_name=str(stored["file_name"]),
        sha256=str(stored["sha256"]),
        metres_per_unit=float(stored["metres_per_unit"]),
        up_axis=str(stored["up_axis"]),
        details={str(k): str(v) for k, v in stored["details"].items()},
    )


def _four(values: Any) -> tuple[float, float, float, float]:
    a, b, c, d = (float(v) for v in values)
    return (a, b, c, d)


FORMAT: Final = Format(
    name="npz",
    title="NumPy archive",
    suffixes=(".npz",),
    sniff=sniff,
    read=read,
    write=write,
    extras=write,
)
