"""The template of the human figure, ``figure.npz``: a neutral mannequin of 1.75 m with its arms let down by 45°.

Stored is its left half, with each vertex's shares of the bones and of the helpers that stand at joints.
"""

from __future__ import annotations

from functools import cache
from importlib import resources
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

SIDES: Final = ("left", "right")
_BEFORE: Final = {"humerus": None, "radius": "humerus", "femur": None, "tibia": "femur"}
"""Bones of the limbs and what they hang on, None for the trunk."""


class Template(NamedTuple):
    """The figure before it is fitted."""

    vertices: Array
    triangles: Indices
    partner: Indices
    bones: dict[str, Array]
    """Shares of the vertices in "axial", "left_femur", "left_femur_half" …, each of shape (vertices,)."""
    masses: dict[str, Array]
    """The same where the helpers' shares are given to the bones: what is carried along with which bone."""
    points: dict[str, Array]
    """Landmarks, both sides."""


@cache
def mannequin() -> Template:
    """Both halves of what is stored."""
    with resources.files("kinesics.body").joinpath("figure.npz").open("rb") as file, np.load(file) as stored:
        half = stored["vertices"].astype(np.float64)
        faces = stored["faces"].astype(np.intp)
        rim = int(stored["rim"])
        shares = stored["weights"].astype(np.float64)
        names = [str(n) for n in stored["bones"]]
        points = {str(n): p for n, p in zip(stored["point_names"], stored["points"], strict=True)}
    count = len(half)
    # the rim lies on the midline and is its own mirror image
    image = np.concatenate([np.arange(rim), np.arange(count, 2 * count - rim)])
    partner = np.concatenate([image, np.arange(rim, count)])
    flip = np.array([-1.0, 1.0, 1.0])
    shares /= shares.sum(axis=1, keepdims=True)
    bones: dict[str, Array] = {}
    for name, own in zip(names, shares.T, strict=True):
        if name == "axial":
            bones[name] = np.concatenate([own, own[rim:]])
            continue
        for side, other in (("left", False), ("right", True)):
            # on the rim both sides have an equal share
            beside = np.zeros(count - rim)
            bones[f"{side}_{name}"] = np.concatenate(
                [own[:rim] / 2, beside if other else own[rim:], own[rim:] if other else beside]
            )
    masses = {n: share.copy() for n, share in bones.items() if not n.endswith(("_half", "_swing", "_twist"))}
    for side in SIDES:
        masses["axial"] += masses.pop(f"{side}_clavicle")
        masses[f"{side}_foot"] += masses.pop(f"{side}_toes")
        masses[f"{side}_radius"] += bones[f"{side}_hand_twist"]
        for name, before in _BEFORE.items():
            own, seam = f"{side}_{name}", bones[f"{side}_{name}_half"] / 2
            masses[own] += seam + bones.get(f"{own}_swing", 0.0)
            masses["axial" if before is None else f"{side}_{before}"] += seam
    sided = {
        f"{side}_{name}": point * (1.0 if side == "left" else flip)
        for name, point in points.items()
        if point[0] > 0.0
        for side in SIDES
    }
    return Template(
        vertices=np.concatenate([half, half[rim:] * flip]),
        triangles=np.concatenate([faces, image[faces][:, ::-1]]),
        partner=partner,
        bones=bones,
        masses=masses,
        points={**{n: p for n, p in points.items() if p[0] == 0.0}, **sided},
    )
