"""The closed vocabularies: links of the body, classes of movement. A leaf.

Sources: links [Schultz2012] §2.7, §2.10; classes §3.4 completed by the seven frieze groups
(CONVENTIONS.md).
"""

from __future__ import annotations

from enum import StrEnum
from typing import Final

LINKS: Final[tuple[str, ...]] = (
    "root",
    "lowerback",
    "upperback",
    "thorax",
    "lowerneck",
    "upperneck",
    "head",
    "left_femur",
    "left_tibia",
    "left_humerus",
    "left_radius",
    "right_femur",
    "right_tibia",
    "right_humerus",
    "right_radius",
)
"""The 15 links of the anatomical model, in the order of every pose array ([Schultz2012] §2.10)."""

LINK_PARENTS: Final[tuple[int, ...]] = (-1, 0, 1, 2, 3, 4, 5, 0, 7, 3, 9, 0, 11, 3, 13)
"""Index of each link's parent link; −1 for the root."""

MIRROR_LINKS: Final[tuple[int, ...]] = (0, 1, 2, 3, 4, 5, 6, 11, 12, 13, 14, 7, 8, 9, 10)
"""Index of the link that each link becomes in the mirror: W swaps left and right ([Schultz2012] §2.10)."""


class MovementClass(StrEnum):
    """The symmetry classes of movement; the value is the slug used everywhere."""

    CYCLIC_ASYMMETRIC = "cyclic-asymmetric"
    CYCLIC_ANTIPHASE = "cyclic-antiphase"
    CYCLIC_SYMMETRIC = "cyclic-symmetric"
    CYCLIC_PALINDROMIC = "cyclic-palindromic"
    CYCLIC_ANTIPALINDROMIC = "cyclic-antipalindromic"
    CYCLIC_ANTIPHASE_PALINDROMIC = "cyclic-antiphase-palindromic"
    CYCLIC_SYMMETRIC_PALINDROMIC = "cyclic-symmetric-palindromic"
    ASYMMETRIC = "asymmetric"
    SYMMETRIC = "symmetric"
    PALINDROMIC = "palindromic"
    ANTIPALINDROMIC = "antipalindromic"
    SYMMETRIC_PALINDROMIC = "symmetric-palindromic"
    STILL = "still"


CLASS_WORDS: Final[dict[MovementClass, str]] = {
    MovementClass.CYCLIC_ASYMMETRIC: "cyclic, without symmetry",
    MovementClass.CYCLIC_ANTIPHASE: "cyclic, left and right in turn",
    MovementClass.CYCLIC_SYMMETRIC: "cyclic, left and right together",
    MovementClass.CYCLIC_PALINDROMIC: "cyclic, to and fro",
    MovementClass.CYCLIC_ANTIPALINDROMIC: "cyclic, taken back as its mirror image",
    MovementClass.CYCLIC_ANTIPHASE_PALINDROMIC: "cyclic, to and fro, left and right in turn",
    MovementClass.CYCLIC_SYMMETRIC_PALINDROMIC: "cyclic, to and fro, left and right together",
    MovementClass.ASYMMETRIC: "made once, without symmetry",
    MovementClass.SYMMETRIC: "made once, left and right together",
    MovementClass.PALINDROMIC: "made once, to and fro",
    MovementClass.ANTIPALINDROMIC: "made once, taken back as its mirror image",
    MovementClass.SYMMETRIC_PALINDROMIC: "made once, to and fro, left and right together",
    MovementClass.STILL: "still",
}
"""Each class in a few words."""

FRIEZE_GROUPS: Final[dict[MovementClass, str]] = {
    MovementClass.CYCLIC_ASYMMETRIC: "p1",
    MovementClass.CYCLIC_ANTIPHASE: "p11g",
    MovementClass.CYCLIC_SYMMETRIC: "p11m",
    MovementClass.CYCLIC_PALINDROMIC: "p1m1",
    MovementClass.CYCLIC_ANTIPALINDROMIC: "p2",
    MovementClass.CYCLIC_ANTIPHASE_PALINDROMIC: "p2mg",
    MovementClass.CYCLIC_SYMMETRIC_PALINDROMIC: "p2mm",
}
"""The frieze group of each cyclic class."""
