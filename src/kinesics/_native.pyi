"""The compiled kernels. They check shapes, not values: call them through `kinesics.similarity`, `kinesics.body`."""

import numpy as np
from numpy.typing import NDArray

_Doubles = NDArray[np.float64]
_Floats = NDArray[np.float32]
_Quaternion = tuple[float, float, float, float]
_Vector = tuple[float, float, float]

class Poses:
    """Poses packed for the pair kernels: float32, weights folded in."""

    def __init__(self, quaternions: _Doubles, gravity: _Doubles, weights: _Doubles, lead: int = 0) -> None:
        """Shapes (n, 15, 4), (n, 3), (15,). ``lead``: floats between a cache line and the start of the output."""
    def taken(self, frames: NDArray[np.int64]) -> Poses:
        """Some frames, in the order given."""
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
    wanted: NDArray[np.int32] | None = None,
    threads: int = 0,
) -> None:
    """Fill world orientations (frames, joints, 4) and positions (frames, joints, 3), whichever are given.

    Joints that are not wanted, and that none wanted hangs on, are NaN.
    """

def reach_legs(
    positions: _Doubles,
    world: _Doubles,
    targets: _Doubles,
    joints: NDArray[np.int32],
    hinges: _Doubles,
    soft: float,
    straightest: float,
    backward: float,
    out: _Doubles,
    misses: _Doubles,
) -> None:
    """Change femurs, tibias and feet in ``out`` (frames, joints, 4) so that ankles come to their targets.

    Of each leg ``joints`` (2, 6) has femur, tibia and foot, then the parents of these.
    """

def cheapest_path(rows: _Floats, low: int, width: int, bend: float, out: NDArray[np.int64]) -> None:
    """Fill ``out`` with the row, counted from ``low``, of the cheapest path through the band in each column."""

def turning_costs(rows: _Floats, reach: int, bend: float, out: _Doubles) -> None:
    """Fill ``out`` with the mean distance along the cheapest path outwards from each place, shape (2n − 1,)."""

def seed_costs(rows: _Floats, bend: float, backwards: bool, out: _Floats) -> None:
    """Fill ``out`` with the mean along the cheapest path of all rows that passes each column in the middle one, the worse half."""

def subsequence(rows: _Floats, backwards: bool, bend: float, total: _Floats, start: NDArray[np.int64]) -> None:
    """Fill in the cheapest way through all rows that ends at each column, and the column it began at."""

def folded(distance: _Floats, weight: _Doubles) -> tuple[float, int]:
    """The cheapest path from (first, last) inwards to the identity axis, and the row where it ends."""

def warped(blocks: _Floats, out: _Doubles) -> None:
    """Fill ``out`` with the mean along the best monotone way from corner to corner of each square block."""

def localise(
    d: _Floats,
    s: _Floats,
    first: int,
    same: float,
    count: int,
    last: int,
    last_mirrored: bool,
    ground: NDArray[np.int64],
    farthest: _Floats,
    new: NDArray[np.bool_],
    where: NDArray[np.int64],
    mirrored: NDArray[np.bool_],
) -> tuple[int, int, bool]:
    """Where moments from ``first`` on were before; columns of d and s: the ground so far, then these moments.

    Returns how many places there are on the ground now, the place of the last moment (−1: none), and whether it is mirrored.
    """

def seconds_by(
    tables: _Floats,
    kinds: NDArray[np.int64],
    paths: NDArray[np.int32],
    places: _Floats,
    swerve: _Floats,
    headings: _Floats,
    travelled: _Floats,
    times: _Floats,
    bends: _Floats,
    target_z: float,
    target_x: float,
    per_fold: float,
    farthest: float,
    slowness: float,
    out: _Floats,
) -> None:
    """Fill ``out`` with the seconds to a target by each trail (columns), bent by each of ``bends`` (rows), and on from its end."""

def quaternion_products(a: _Doubles, b: _Doubles, out: _Doubles) -> None:
    """Fill ``out`` with a · b. Shapes (n, m, 4), of the inputs with any strides; so of all that follow."""

def quaternion_turned(a: _Doubles, b: _Doubles, out: _Doubles) -> None:
    """Fill ``out`` (n, m, 3) with vectors ``b``, turned."""

def quaternion_logarithms(a: _Doubles, out: _Doubles) -> None:
    """Fill ``out`` (n, m, 3) with rotation vectors."""

def quaternion_exponentials(a: _Doubles, out: _Doubles) -> None:
    """Fill ``out`` (n, m, 4) with the quaternions of rotation vectors."""

def quaternion_offsets(a: _Doubles, b: _Doubles, out: _Doubles) -> None:
    """Fill ``out`` (n, m, 3) with the rotation vectors of a⁻¹ · b."""

def quaternion_angles(a: _Doubles, b: _Doubles, out: _Doubles) -> None:
    """Fill ``out`` (n, m, 1) with the angles of a⁻¹ · b."""

def seek_footing(
    knees: _Doubles,
    hips: _Doubles,
    foot: float,
    body: float,
    slid: _Doubles,
    grip: _Doubles,
    height: _Doubles,
    press: _Doubles,
    way: _Doubles,
    least: _Doubles,
    astray: float,
    drift: _Doubles,
    out: _Doubles,
) -> bool:
    """Fill ``out`` with what is added to both feet and the body where the sum of squares is least; False if there is no least."""

def stand_on(
    step: _Doubles,
    height: _Doubles,
    farthest: _Doubles,
    change: _Doubles,
    turn: _Doubles,
    parts: _Doubles,
    beside: _Doubles,
    apart: float,
    far: float,
    gives: float,
    rise: float,
    out: NDArray[np.int32],
) -> None:
    """Fill ``out`` (steps,) with which of the points along a sole, of these ``parts``, it stands on in each step."""

def spreads(way: _Doubles, starts: NDArray[np.int64], stops: NDArray[np.int64], out: _Doubles) -> None:
    """Fill ``out`` (runs,) with how far apart the places of a way (frames, 2) are at most in each run of frames."""

def taut(low: _Doubles, high: _Doubles, at: _Doubles, where: _Doubles, height: _Doubles) -> int:
    """The corners of a string pulled taut in a tube, as ``where`` and ``height`` (2 · frames,); 0 if nothing bends it."""

def blended(
    rotations: _Doubles,
    offset: _Doubles,
    velocity: _Doubles,
    before: _Doubles,
    after: _Doubles,
    share: _Doubles,
    time: float,
) -> tuple[float, float, float]:
    """Add what a transition does so many seconds from its cut to ``rotations`` (joints, 4), in place; to the root it adds this."""

class Ranges:
    """How far joints go: see ``kinesics.synthesis.embodiment.ranges``."""

    def __init__(
        self, middle: _Doubles, low: _Doubles, high: _Doubles, inner: _Doubles, bent: list[int], bends: _Doubles
    ) -> None:
        """Of shapes (joints, 4) and (joints, 3).

        Each row of ``bends`` (n, 8) has the directions of the bone before a joint of ``bent`` and of one that hangs on it, the
        least and the greatest angle between them.
        """

    def within(self, joint: int, vectors: _Doubles) -> None:
        """Move rotation vectors (n, 3) of a joint from its mean to within its range, in place."""

    def hold(self, rotations: _Doubles, first: int) -> None:
        """Hold ``rotations`` (joints, 4) from joint ``first`` on in their ranges, in place."""

    def hold_back(self, rotations: _Doubles, first: int, back: _Doubles) -> None:
        """The same, each turned back first by a rotation vector of ``back`` (joints, 3) in the frame of its mean."""

    def excess(self, rotations: _Doubles, first: int, out: _Doubles) -> bool:
        """Rotation vectors by which joints are beyond, to ``out`` (joints, 3), 0 within; whether any is."""

def eased(beyond: _Doubles, window: _Doubles, out: _Doubles) -> None:
    """The middle of the smooth curve that is nowhere less than ``beyond`` (2n − 1, joints, 3), under a window (n,), to ``out``."""

def seam(
    left: _Doubles,
    entered: _Doubles,
    left_roots: _Doubles,
    entered_roots: _Doubles,
    parents: NDArray[np.int32],
    arms: _Doubles,
    above: list[int],
    carrier: int,
    turns: tuple[float, float],
    aside: tuple[float, float],
    pace: float,
    offset: _Doubles,
    velocity: _Doubles,
    places: _Doubles,
    moving: _Doubles,
) -> None:
    """Fill by how much the pose that is entered differs from the one left, and how quickly that changes; both before, at and
    after the cut, (3, joints, 4) and (3, 3)."""

def absorbed(
    offset: _Doubles,
    velocity: _Doubles,
    earlier: _Doubles,
    its_velocity: _Doubles,
    before: _Doubles,
    after: _Doubles,
    share: _Doubles,
    since: float,
    instant: float,
) -> None:
    """Let what remains of an earlier transition end in ``offset`` and ``velocity`` (joints + 1, 3), in place."""

def paced(
    offset: _Doubles,
    velocity: _Doubles,
    places: _Doubles,
    moving: _Doubles,
    which: NDArray[np.int32],
    spared: _Doubles,
    loose: NDArray[np.bool_],
    slowly: _Doubles,
    stays: tuple[float, float, float],
    seconds: float,
    rules: list[float],
    before: _Doubles,
    after: _Doubles,
    share: _Doubles,
) -> float:
    """Fill the seconds that each takes to either side of a cut, and its share before; velocities in place. The longest after."""

class Chain:
    """The joints between root and soles, parents first, the root at their head."""

    def __init__(self, joints: list[int], above: list[int], offsets: list[_Vector]) -> None: ...
    def placed(self, rotations: _Doubles, root: _Vector) -> tuple[list[_Quaternion], list[_Vector], list[_Quaternion]]:
        """Their rotations, of those of all joints (joints, 4); their places and orientations in the world."""

class Leg:
    """One leg of one performance, which goes gently: see ``kinesics.synthesis.live.leg``."""

    def __init__(
        self,
        ranges: Ranges,
        joints: list[int],
        at: list[int],
        above: list[int],
        most: list[float],
        hinge: _Vector,
        seconds: float,
        brake: float,
        soft: float,
        straightest: float,
        backward: float,
    ) -> None: ...
    def reach(
        self,
        places: list[_Vector],
        world: list[_Quaternion],
        local: list[_Quaternion],
        sole: list[_Vector],
        target: _Vector,
        shift: _Vector,
        bears: float,
    ) -> tuple[_Quaternion, _Quaternion, _Quaternion, _Vector, float]: ...

def shared_values(values: _Doubles, sequence: NDArray[np.int32], shares: _Floats, out: _Doubles) -> None:
    """Fill ``out`` (rows,) with the values of the paths of each composite, times their shares, together."""

def too_soon(
    last_played: _Doubles,
    now: float,
    paths: NDArray[np.int32],
    begins: _Floats,
    again: _Floats,
    shares: _Floats,
    within: float,
    out: _Doubles,
) -> None:
    """Add to ``out`` (rows,) by how much too soon each composite plays what was played lately."""

def met_at(
    places: _Floats,
    swerve: _Floats,
    times: _Floats,
    z: float,
    x: float,
    most: float,
    within: float,
    pace: float,
    straight: float,
    late: float,
    out: _Doubles,
) -> None:
    """Fill ``out`` (rows, points) with what it costs to be at a target there, infinite where one is not within √``within`` m."""

def sought(
    places: _Floats,
    swerve: _Floats,
    headings: _Floats,
    times: _Floats,
    wish: _Doubles,
    most: float,
    reach: float,
    pace: float,
    haste: float,
    facing: float,
    out: _Doubles,
) -> None:
    """Fill ``out`` (rows, points) with what each misses of what is wished for there: ``wish`` (1 or points, 3) z, x, metres off."""

def envelope(values: _Doubles, window: _Doubles, out: _Doubles) -> None:
    """Fill ``out`` with the greatest of ``values`` within half a window, averaged under the window."""

def carried_points(
    positions: _Doubles, rotations: _Doubles, joints: NDArray[np.int32], offsets: _Doubles, out: _Doubles
) -> None:
    """Fill ``out`` (frames, points, 3) with where points are that joints carry at offsets (points, 3)."""

def capsule_depths(
    starts: _Doubles,
    ends: _Doubles,
    first: NDArray[np.int32],
    second: NDArray[np.int32],
    reach: _Doubles,
    least: float,
    out: _Doubles,
) -> None:
    """Fill ``out`` (frames, pairs) with the metres by which capsules interpenetrate, −∞ where by less than about ``least``."""

def parse_rows(data: bytes, start: int, columns: int) -> tuple[_Doubles, int]:
    """Rows of numbers, one a line; and the byte where the first line begins that is not one, or −1."""

def parse_labelled(data: bytes, start: int, labels: list[str], counts: list[int]) -> tuple[_Doubles, int]:
    """Frames of labelled numbers; and the byte where the first frame begins that is not of this layout, or −1."""
