"""The compiled kernels. They check shapes, not values: call them through `kinesics.similarity`, `kinesics.body`."""

import numpy as np
from numpy.typing import NDArray

_Doubles = NDArray[np.float64]
_Floats = NDArray[np.float32]

class Poses:
    """Poses packed for the pair kernels: float32, weights folded in."""

    def __init__(self, quaternions: _Doubles, gravity: _Doubles, weights: _Doubles, lead: int = 0) -> None:
        """Shapes (n, 15, 4), (n, 3), (15,). ``lead``: floats between a cache line and the start of the output."""
    @property
    def frames(self) -> int: ...
    @property
    def tile_count(self) -> int:
        """Tiles in the upper triangle of the square matrix of these poses."""

def similarity_tiles(
    poses: Poses,
    z: _Floats,
    z_mirror: _Floats | None,
    beta: float,
    first: int,
    last: int,
    fresh: bool = False,
    path: str = "",
    threads: int = 0,
) -> None:
    """Fill tiles [first, last) of exp(−β D) and exp(−β D*), and their images below the diagonal."""

def distances(
    a: Poses,
    b: Poses,
    d: _Floats,
    d_mirror: _Floats | None,
    row_start: int = 0,
    column_start: int = 0,
    path: str = "",
    threads: int = 0,
) -> None:
    """Fill D and D* between the frames of ``a`` and ``b`` from the given ones on (multiples of 16)."""

def diagonal_sums(
    a: Poses,
    b: Poses,
    length: int,
    d: _Floats,
    d_mirror: _Floats | None,
    path: str = "",
    threads: int = 0,
) -> None:
    """Fill sums of D and D* over ``length`` frames along diagonals."""

def paths() -> list[str]:
    """Code paths this processor has, the fastest first."""

def forward_kinematics(
    parents: NDArray[np.int32],
    offsets: _Doubles,
    rotations: _Doubles,
    root_positions: _Doubles | None,
    joint_translations: _Doubles | None,
    world: _Doubles | None,
    positions: _Doubles | None,
    threads: int = 0,
) -> None:
    """Fill world orientations (frames, joints, 4) and positions (frames, joints, 3), whichever are given."""

def cheapest_path(rows: _Floats, low: int, width: int, bend: float, out: NDArray[np.int64]) -> None:
    """Fill ``out`` with the row, counted from ``low``, of the cheapest path through the band in each column."""

def turning_costs(rows: _Floats, reach: int, bend: float, out: _Doubles) -> None:
    """Fill ``out`` with the mean distance along the cheapest path outwards from each place, shape (2n − 1,)."""

def parse_rows(data: bytes, start: int, columns: int) -> tuple[_Doubles, int]:
    """Rows of numbers, one a line; and the byte where the first line begins that is not one, or −1."""

def parse_labelled(data: bytes, start: int, labels: list[str], counts: list[int]) -> tuple[_Doubles, int]:
    """Frames of labelled numbers; and the byte where the first frame begins that is not of this layout, or −1."""
