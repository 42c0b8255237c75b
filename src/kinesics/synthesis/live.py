"""Paths performed live, frame by frame as they are chosen, knowing only the past ([Schultz2012] §4.4).

`kinesics.synthesis.rendering` does the same with the whole performance before it.
"""

from __future__ import annotations

import bisect
import cmath
import math
import operator
import weakref
from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from typing import Final, NamedTuple, Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinesics.body import kinematics
from kinesics.body.motion import Motion
from kinesics.errors import InputError
from kinesics.geometry import quaternion, single
from kinesics.geometry.single import Quaternion, Vector
from kinesics.synthesis import blending
from kinesics.synthesis.foresight import Foresight, Stretch
from kinesics.synthesis.meeting import meetings
from kinesics.synthesis.network import Network
from kinesics.synthesis.rehearsal import played
from kinesics.synthesis.rendering import Performance, Provenance
from kinesics.synthesis.repertoire import BACKWARD_STRANDS, Repertoire
from kinesics.synthesis.stage import LEAST_TURNING, SPARED, Stage, frames_of_reach
from kinesics.synthesis.treading import Treading

Array = NDArray[np.float64]

_UNITS: Final = np.eye(4)
_MULTIPLIED: Final = quaternion.multiply(_UNITS[:, None], _UNITS).reshape(16, 4)
"""What the product a·b is made of: the coefficients of each aᵢbⱼ, shape (16, 4)."""
_UNDONE: Final = quaternion.multiply(quaternion.conjugate(_UNITS)[:, None], _UNITS).reshape(16, 4)
"""The same of a⁻¹·b."""


AHEAD: Final = 0.3
"""Seconds of what comes that are known where nothing else is said: about as long as a human takes to change its mind."""
_SHORTLY: Final = 3
"""Frames: while fewer are known it is hurried."""
LONGEST_AHEAD: Final = 10.0
"""Seconds."""
_DONE: Final = object()
_INSTANT: Final = 1e-3
"""Seconds over which it is told how quickly an offset changes that is known at all times."""


class LiveFrame(NamedTuple):
    """One frame, as it is performed."""

    rotations: Array
    """Of all joints relative to their parents, shape (joints, 4)."""
    root: Array
    """Place of the root, metres, shape (3,)."""
    moment: int
    """What it plays: see `kinesics.synthesis.repertoire`."""
    path: int
    """The path in which it does."""


class _Blend(NamedTuple):
    """A transition."""

    cut: int
    """The frame at which another recording is entered."""
    ends: int
    offset: Array
    """Of joints and root, shape (joints + 1, 3)."""
    velocity: Array
    before: Array
    """Seconds that each takes to either side of the cut, shape (joints + 1, 1)."""
    after: Array
    share: Array
    """Of the offset that each bears before the cut."""
    leap: complex
    """By how much what is then performed lies beside where its feet would stand where those stand that are left, z + i·x."""

    def at(self, time: float) -> Array:
        """What it adds so many seconds from the cut: `kinesics.synthesis.blending.two_sided`."""
        if time < 0.0:
            share, span, time = self.share, self.before, -time
            way = -span
        else:
            share, span = self.share - 1.0, self.after
            way = span
        t = np.minimum(time / span, 1.0)
        rest = 1.0 - t
        cube = share * rest * rest * rest
        return np.asarray(
            (cube * (1.0 + t * (3.0 + 6.0 * t))) * self.offset + (cube * way * t * (1.0 + 3.0 * t)) * self.velocity
        )


class _Crossing(NamedTuple):
    """From one recording into another."""

    left: int
    """The moment with which what is left would have gone on."""
    first: int
    """The one that is entered."""
    aside: complex
    """By which its root lies elsewhere, z + i·x, metres."""
    turn: float
    """By which it is turned about the vertical, radians."""
    met: float
    """By which it faces elsewhere."""
    seam: _Seam


class _Seam(NamedTuple):
    """By how much what is entered differs from what is left, and how quickly that changes: `kinesics.synthesis.stage.Seams`."""

    offset: Array
    """Of joints and root, shape (joints + 1, 3)."""
    velocity: Array
    places: Array
    """Of the joints' places, shape (joints, 3)."""
    moving: Array


@runtime_checkable
class Guide(Protocol):
    """Decides which way to go: a `kinesics.synthesis.controller.Controller`."""

    def choices(self) -> Iterator[tuple[int, float] | None]:
        """Paths, and by how many radians each is turned besides; None while one is thought over."""

    def be_at(self, place: complex, heading: float) -> None:
        """Be told where the body truly is as the next path begins, z + i·x, metres, and where it faces, radians."""


class LiveRenderer:
    """Performs paths frame by frame, as they are chosen, knowing little of what comes.

    A transition begins as soon as it is known (`kinesics.synthesis.blending.two_sided`), at the latest with the cut. A foot
    comes down where it will be needed (`kinesics.synthesis.foresight`) and stays there. An iterator of `LiveFrame`; it ends
    when the paths do.

    Parameters
    ----------
    network : of the paths.
    paths : a `kinesics.synthesis.controller.Controller`, which is then told where the body truly comes to be as it goes with
        its feet; or numbers of paths, each a successor of the one before, or pairs of such a number and the radians that the
        path is turned by besides, as ``bend`` of `render`; None where none is decided for yet: then it is asked again a frame
        later.
    start, heading : see `render`.
    pinned : whether feet are kept in place.
    ahead : seconds that are to be known: the next path is asked for as soon as less is. With 0 it is asked for as the one
        before has ended, and feet and transitions begin late. Asking for a path and getting ready for it are done in frames
        of their own, where there is time.

    Raises
    ------
    InputError
        If ``start``, ``heading`` or ``ahead`` is not finite or ``paths`` cannot be gone through; on the way, if a path is none,
        does not follow the one before or its bend is not finite.
    """

    def __init__(
        self,
        network: Network,
        paths: Guide | Iterable[int | tuple[int, float] | None],
        *,
        start: ArrayLike = (0.0, 0.0),
        heading: float = 0.0,
        pinned: bool = True,
        ahead: float = AHEAD,
    ) -> None:
        try:
            origin, faced = np.asarray(start, dtype=np.float64), float(heading)
        except (TypeError, ValueError):
            origin, faced = np.empty(0), math.nan
        if origin.shape != (2,) or not np.isfinite(origin).all() or not math.isfinite(faced):
            raise InputError(f"Expected `start` as finite x, z and a finite `heading`, got {start!r} and {heading!r}.")
        self._guide = paths if isinstance(paths, Guide) else None
        if isinstance(paths, Guide):
            paths = paths.choices()
        if not isinstance(paths, Iterable):
            raise InputError(f"Expected `paths` as numbers of paths one after the other, got {paths!r}.")
        if not (isinstance(ahead, int | float) and 0.0 <= ahead <= LONGEST_AHEAD):
            raise InputError(f"Expected `ahead` in seconds, from 0 to {LONGEST_AHEAD:g}, got {ahead!r}.")
        self.network, self.pinned = network, pinned
        self.stage = Stage.of(network.repertoire)
        self._paths = iter(paths)
        self._treading = Treading(self.stage)
        self._played = played(self.stage) if pinned else network.repertoire
        self._met = _met(network, self._played)
        self._foresight = Foresight.of(self.stage)
        # joints that the body's carrier hangs on, from the root on
        self._above: list[int] = []
        joint = self.stage.carrier
        while joint > 0:
            joint = network.repertoire.skeleton.parents[joint]
            self._above.insert(0, joint)
        self._starts = network.repertoire.starts.tolist()
        self._reach = frames_of_reach(network.repertoire.fps)
        network.edges(0, 0), network.onward  # tables that are made when first asked for
        self.path = -1
        """Number of the path that is being performed, −1 before the first frame."""
        self.moment = -1
        """Moment of the repertoire that is being performed."""
        self._laid = complex(origin[1], origin[0])
        self._tell = False
        self.heading = faced
        """Where it is to face where the next path that is asked for begins, radians."""
        self._turn = 0.0
        self._known: deque[Stretch] = deque()
        self._at = 0
        self._last = -1
        self._under_way: Iterator[None] | None = None
        self._ended = False
        self._ahead = round(ahead * network.repertoire.fps)
        self._frame = self._reaches = 0
        self._blends: list[_Blend] = []
        stage, which = self.stage, self.stage.blended
        self._spared = SPARED * np.concatenate([stage.accelerations[which], stage.places])
        self._loose = np.ones(len(stage.accelerations), dtype=np.bool_)
        self._loose[which] = False
        # what each may be accelerated by that may take a time of its own
        self._slowly = np.maximum(SPARED * stage.accelerations, LEAST_TURNING)
        self._slowly[stage.lower] = np.inf

    @property
    def place(self) -> Array:
        """Where the root comes to be, as far as is known, where the next path that is asked for begins: x and z, metres."""
        carried = self._laid + self._treading.carried
        for blend in self._blends:
            if blend.cut >= self._frame:
                carried -= blend.leap
        return np.array([carried.imag, carried.real])

    def __iter__(self) -> LiveRenderer:
        """Itself."""
        return self

    def __next__(self) -> LiveFrame:
        """The next frame."""
        return self.step()

    def step(self) -> LiveFrame:
        """The next frame.

        Raises
        ------
        StopIteration
            If the paths have ended.
        """
        self._look()
        playing = self._known[0]
        image, frame = playing.image, playing.frame + self._at * playing.onward
        self.path, self.moment = playing.path, playing.moment + self._at * playing.onward
        turn = playing.turn + self._at * playing.bend
        rotations, root = self._pose(image, frame, turn, playing.places[self._at])
        if self._blends:
            for added in self._added():
                rotations = _added(rotations, added[:-1])
                root = single.add(root, _vector(added[-1]))
            rotations = self._inside(rotations)
        if self.pinned:
            for blend in self._blends:
                if blend.cut == self._frame:
                    self._treading.leap(blend.leap)
            root = self._treading.step(rotations, root, image, frame, self._foresight.coming(self._known, self._at))
        self._at += 1
        self._frame += 1
        if self._at == playing.length:
            self._known.popleft()
            self._at = 0
        return LiveFrame(rotations, np.array(root), self.moment, self.path)

    def _look(self) -> None:
        """Ask for what comes, and get ready for it: one after the other, if there is time."""
        for _ in range(1 if self._reaches - self._frame >= _SHORTLY else 2):
            self._prepare()
        while not self._known:
            if self._ended:
                raise StopIteration
            self._prepare()

    def _prepare(self) -> None:
        if self._under_way is not None:
            if next(self._under_way, _DONE) is _DONE:
                self._under_way = None
        elif not self._ended and self._reaches - self._frame <= self._ahead:
            if self._guide is not None and self._tell:
                x, z = self.place.tolist()
                self._guide.be_at(complex(z, x), self.heading)
                self._tell = False
            try:
                chosen = next(self._paths)
            except StopIteration:
                self._ended = True
            else:
                if chosen is None:
                    return
                path, bend = self._checked(chosen)
                if self._goes_on(path):
                    self._lay(path, bend)
                else:
                    self._under_way = self._over(path, bend)

    def _added(self) -> list[Array]:
        """What each transition adds to joints and root, the earliest first, shape (joints + 1, 3) each."""
        if self._blends[0].ends <= self._frame:
            self._blends = [blend for blend in self._blends if blend.ends > self._frame]
        return [blend.at((self._frame - blend.cut) / self.network.repertoire.fps) for blend in self._blends]

    def _faced(self, rotations: Array, turn: float) -> Quaternion:
        """The rotation of the joint that a body hangs on, turned about the vertical: see `turn_bodies`."""
        yaw: Quaternion = (math.cos(0.5 * turn), 0.0, math.sin(0.5 * turn), 0.0)
        if self._above:
            above, *others = (_plain(rotations[joint]) for joint in self._above)
            for q in others:
                above = single.multiply(above, q)
            yaw = single.undo(above, single.multiply(yaw, above))
        return single.multiply(yaw, _plain(rotations[self.stage.carrier]))

    def _checked(self, chosen: int | tuple[int, float]) -> tuple[int, float]:
        """A path and its bend, if it is one and may be next."""
        network = self.network
        try:
            number, turned = chosen if isinstance(chosen, tuple) else (chosen, 0.0)
            path, bend = operator.index(number), float(turned)
        except (TypeError, ValueError):
            path, bend = -1, math.nan
        if not math.isfinite(bend):
            raise InputError(
                f"Expected the number of a path, or a pair of one and finite radians that it is bent by, got {chosen!r}."
            )
        if not 0 <= path < len(network):
            raise InputError(f"Expected a path below {len(network)}, got {path}.")
        if self._last >= 0 and int(network.edges(self._last, path)) < 0:
            raise InputError(f"Path {path} does not follow path {self._last}.")
        return path, bend

    def _lay(self, path: int, bend: float) -> None:
        """Put a path behind those that are known."""
        network, repertoire = self.network, self.network.repertoire
        first, length = int(network.first[path]), int(network.length[path])
        if self._last < 0:
            self._turn = self.heading - float(repertoire.yaw_of(first))
        strand, frame = divmod(first, repertoire.frame_count)
        image, onward = strand % 2, -1 if BACKWARD_STRANDS[strand] else 1
        bent = bend / length
        frames = frame + onward * np.arange(length + 1)
        roots = self._played.root_positions[image, frames]
        moved = np.diff(roots[:, 2] + 1j * roots[:, 0]) * np.exp(1j * (self._turn + bent * (np.arange(length) + 0.5)))
        places = self._laid + np.concatenate([[0j], np.cumsum(moved)])
        self._known.append(Stretch(path, first, image, frame, onward, length, self._turn, bent, places[:-1].tolist()))
        self._last = path
        self._reaches += length
        self._laid, self._tell = complex(places[-1]), True
        self._turn += bend
        yaw = float(repertoire.poses.yaw[frames[-1]])
        self.heading = (-yaw if image else yaw) + self._turn

    def _goes_on(self, path: int) -> bool:
        """Whether a path is performed without leaving the recording that is played."""
        return self._last < 0 or int(self.network.first[path]) == int(self.network.onward[self._last])

    def _over(self, path: int, bend: float) -> Iterator[None]:
        """Get ready for a path of another recording; in parts."""
        crossing = self._crossed(path)
        yield
        self._cut(crossing)
        yield
        self._lay(path, bend)

    def _crossed(self, path: int) -> _Crossing:
        """How a path of another recording is gone over into."""
        network, repertoire = self.network, self.network.repertoire
        left, first = int(network.onward[self._last]), int(network.first[path])
        # how the two meet: as the controller and `kinesics.synthesis.rendering` have it
        edge = int(network.edges(self._last, path))
        place, met = complex(self._met[0][edge]), float(self._met[1][edge])
        aside = place * cmath.exp(1j * self.heading)
        turn = self._turn + float(repertoire.yaw_of(left)) + met - float(repertoire.yaw_of(first))
        return _Crossing(left, first, aside, turn, met, self._seam(left, first, turn, aside))

    def _cut(self, crossing: _Crossing) -> None:
        """Go over into what is entered."""
        stage, fps = self.stage, self.network.repertoire.fps
        left, first, aside, turn, met, (offset, velocity, places, moving) = crossing
        leap = self._apart(left, first, turn, aside) if self.pinned else 0j
        stays = np.array([leap.imag, 0.0, leap.real])
        offset[-1] -= stays
        self._laid += aside
        self.heading += met
        if self._blends and self._blends[-1].ends > self._reaches:
            # what remains of the transition before ends here
            earlier = self._blends[-1]
            since = (self._reaches - earlier.cut) / fps
            offset, velocity = _absorbed(offset, velocity, earlier, since)
            self._blends[-1] = earlier._replace(ends=self._reaches)
        which = stage.blended
        half = blending.window(
            _sizes(np.concatenate([offset[which], places - stays])),
            _sizes(np.concatenate([velocity[which], moving])),
            self._spared,
        ).after
        before = min(half, (self._reaches - self._frame) / fps)
        # what there is no time for before the cut has to be done after it
        after = min(math.sqrt(2.0 * half * half - before * before), blending.LONGEST)
        share = before * before / (before * before + after * after)
        window = blending.Window(before, after, share)
        velocity, pace = blending.at_their_own_pace(offset, velocity, window, self._loose, self._slowly)
        # what takes longer cannot have begun before it was known
        early, late = before * np.minimum(pace, 1.0), after * pace
        shares = early * early / (early * early + late * late)
        ends = self._reaches + math.ceil(float(late.max()) * fps)
        spans = np.maximum(early, _INSTANT)[:, None], late[:, None]
        self._blends.append(_Blend(self._reaches, ends, offset, velocity, *spans, shares[:, None], leap))
        self._turn = turn

    def _seam(self, left: int, first: int, turn: float, aside: complex) -> _Seam:
        """`kinesics.synthesis.stage.seams` of one cut."""
        repertoire, fps = self._played, self._played.fps
        (image, here), (entered, there) = self._around(left), self._around(first)
        reached = [a >= 0 and b >= 0 for a, b in zip(here, there, strict=True)]
        # where either recording does not reach, the moment itself stands for the one beside it
        here = [a if both else here[1] for a, both in zip(here, reached, strict=True)]
        there = [b if both else there[1] for b, both in zip(there, reached, strict=True)]
        old, new = repertoire.rotations[image, here], repertoire.rotations[entered, there]
        places = repertoire.root_positions
        offsets = np.empty((3, old.shape[1] + 1, 3))
        offsets[:, :-1] = _offset(old, new)
        roots = places[image, here].tolist(), places[entered, there].tolist()
        carrier = self.stage.carrier
        stood = np.empty((6, 3))
        for k, (before, after) in enumerate(zip(*roots, strict=True)):
            own, other = self._faced(old[k], self._turn), self._faced(new[k], turn)
            offsets[k, carrier] = single.as_rotvec(single.undo(own, other))
            old[k, carrier], new[k, carrier] = own, other
            stood[k], stood[k + 3] = _turned(before, self._turn), _turned(after, turn)
        offsets[:, -1] = stood[3:] - stood[:3]
        body = kinematics.forward(repertoire.skeleton, np.concatenate([old, new]), stood).positions
        away = body[3:] - body[:3]
        earlier, now, later = offsets
        span = self._reach * (reached[0] + reached[2])
        change, moving = later - earlier, away[2] - away[0]
        velocity = change * (fps / span) if span else np.zeros_like(change)
        # a rotation vector leaps where it passes half a turn; such an offset has no velocity that could be told
        velocity[np.einsum("ij,ij->i", change, change) >= 4.0] = 0.0
        apart = away[1] - now[-1]
        now[-1, 0], now[-1, 2] = aside.imag, aside.real
        return _Seam(now, velocity, apart + now[-1], moving * (fps / span) if span else np.zeros_like(moving))

    def _apart(self, left: int, first: int, turn: float, aside: complex) -> complex:
        """By how much bearing feet stand elsewhere in what is entered."""
        poses: list[tuple[Array, Vector]] = []
        borne = [1.0, 1.0]
        for moment, yaw, place in ((left, self._turn, 0j), (first, turn, aside)):
            strand, frame = divmod(moment, self.network.repertoire.frame_count)
            image = strand % 2
            rotations, (x, y, z) = self._pose(image, frame, yaw, place)
            poses.append((rotations, (x, y, z)))
            borne = [a * b for a, b in zip(borne, self._treading.held(image, frame), strict=True)]
        return self._treading.apart(poses[0], poses[1], borne)

    def _pose(self, image: int, frame: int, turn: float, place: complex) -> tuple[Array, Vector]:
        """What is performed in a frame, turned and put in its place: rotations (joints, 4), and where the root is."""
        own = self._played
        rotations = own.rotations[image, frame].copy()
        root: Vector = (place.imag, float(own.root_positions[image, frame, 1]), place.real)
        rotations[self.stage.carrier] = self._faced(rotations, turn)
        return rotations, root

    def _around(self, moment: int) -> tuple[int, list[int]]:
        """Which image a moment plays, and the frames before, at and after it, −1 where its recording does not reach."""
        strand, frame = divmod(moment, self.network.repertoire.frame_count)
        k = bisect.bisect_right(self._starts, frame)
        step = -self._reach if BACKWARD_STRANDS[strand] else self._reach
        inside = range(self._starts[k - 1], self._starts[k])
        return strand % 2, [f if f in inside else -1 for f in (frame - step, frame, frame + step)]

    def _inside(self, rotations: Array) -> Array:
        """Joints of the body within their range, shape (joints, 4)."""
        stage = self.stage
        vectors = _offset(stage.middle, rotations)
        beyond = np.any((vectors < stage.low) | (vectors > stage.high), axis=-1)
        beyond[: stage.carrier + 1] = False
        if beyond.any():
            held = np.clip(vectors[beyond], stage.low[beyond], stage.high[beyond])
            rotations[beyond] = blending.add_rotation(stage.middle[beyond], held)
        return rotations


def performed(network: Network, frames: Sequence[LiveFrame], *, name: str = "live") -> Performance:
    """What was performed live, as what is performed at once: to be written, looked at and measured.

    Around a cut frames count as transition for as long as one may take.

    Raises
    ------
    InputError
        If there is no frame.
    """
    if not frames:
        raise InputError("Expected at least one frame that was performed, got none.")
    repertoire, stage = network.repertoire, Stage.of(network.repertoire)
    moments, paths = (np.array(values, dtype=np.intp) for values in zip(*(f[2:] for f in frames), strict=True))
    frame, count = repertoire.frame_of(moments), len(frames)
    cuts = 1 + np.flatnonzero(repertoire.advance(moments[:-1], 1) != moments[1:])
    begins = np.concatenate(
        [[0], 1 + np.flatnonzero((paths[1:] != paths[:-1]) | (moments[1:] == network.first[paths[1:]]))]
    )
    step = np.zeros(count, dtype=np.intp)
    step[begins[1:]] = 1
    transition, reach = np.zeros(count, dtype=np.bool_), math.ceil(blending.LONGEST * repertoire.fps)
    for cut in cuts.tolist():
        transition[max(cut - reach, 0) : cut + reach] = True
    standing = repertoire.contacts_of(moments)
    motion = Motion(
        repertoire.skeleton,
        np.stack([f.rotations for f in frames]),
        np.stack([f.root for f in frames]),
        repertoire.fps,
        name=name,
        assumptions=repertoire.assumptions,
    )
    came = Provenance(
        moment=moments,
        recording=repertoire.recording_of(frame),
        source_frame=repertoire.source_frames[frame],
        mirrored=repertoire.is_mirrored(moments),
        backwards=repertoire.is_backward(moments),
        step=np.cumsum(step),
        path=paths,
        transition=transition,
        weight=np.ones(count),
    )
    zero = np.zeros((count, 2))
    return Performance(
        motion,
        came,
        tuple(paths[begins].tolist()),
        cuts,
        standing,
        (),
        stage.soles,
        np.zeros((count, 2, 3)),
        np.zeros(count),
        zero,
    )


_meetings: weakref.WeakKeyDictionary[Network, tuple[NDArray[np.complex128], Array]] = weakref.WeakKeyDictionary()


def _met(network: Network, played: Repertoire) -> tuple[NDArray[np.complex128], Array]:
    """`Network.met`, of moments with their feet where they are played; made once and kept as long as the network is."""
    if network.meeting is None or played is network.repertoire:
        return network.met
    if network not in _meetings:
        place, turn = network.met[0].copy(), network.met[1].copy()
        jumps = np.flatnonzero(network.cost > 0.0)
        owners = np.searchsorted(network.indptr, jumps, side="right") - 1
        met = meetings(played, network.onward[owners], network.first[network.indices[jumps]])
        place[jumps], turn[jumps] = met.place[:, 1] + 1j * met.place[:, 0], met.turn
        _meetings[network] = place, turn
    return _meetings[network]


def _offset(left: Array, entered: Array) -> Array:
    """`kinesics.synthesis.blending.rotation_offset` of one frame or three: fewer steps, more memory for each rotation."""
    q = (left[..., :, None] * entered[..., None, :]).reshape(*entered.shape[:-1], 16) @ _UNDONE
    w, vector = q[..., 0], q[..., 1:]
    sin_half = np.sqrt(np.einsum("...i,...i->...", vector, vector))
    scale = 2.0 * np.arctan2(sin_half, np.abs(w)) / np.maximum(sin_half, 1e-150)
    return np.asarray(np.copysign(scale, w)[..., None] * vector)


def _added(q: Array, offset: Array) -> Array:
    """The same of `kinesics.synthesis.blending.add_rotation`."""
    return np.asarray((q[..., :, None] * _turns(offset)[..., None, :]).reshape(*q.shape[:-1], 16) @ _MULTIPLIED)


def _turns(vectors: Array) -> Array:
    """The same of `quaternion.from_rotvec`."""
    angle = np.sqrt(np.einsum("...i,...i->...", vectors, vectors))
    out = np.empty((*vectors.shape[:-1], 4))
    out[..., 0] = np.cos(0.5 * angle)
    out[..., 1:] = (np.sin(0.5 * angle) / np.maximum(angle, 1e-150))[..., None] * vectors
    return out


def _sizes(vectors: Array) -> Array:
    return np.asarray(np.sqrt(np.einsum("ij,ij->i", vectors, vectors)))


def _absorbed(offset: Array, velocity: Array, earlier: _Blend, since: float) -> tuple[Array, Array]:
    """`kinesics.synthesis.blending.absorbed`."""
    remains = np.stack([earlier.at(since + time) for time in (-_INSTANT, 0.0, _INSTANT)])
    apart = offset + np.array([-_INSTANT, 0.0, _INSTANT])[:, None, None] * velocity
    gone, turned = (_turns(vectors[:, :-1]) for vectors in (remains, apart))
    apart[:, :-1] = _offset(gone, turned)
    apart[:, -1] -= remains[:, -1]
    return apart[1], (apart[2] - apart[0]) / (2.0 * _INSTANT)


def _vector(values: Array) -> Vector:
    x, y, z = values.tolist()
    return x, y, z


def _plain(rotation: Array) -> Quaternion:
    w, x, y, z = rotation.tolist()
    return w, x, y, z


def _turned(place: Sequence[float], yaw: float) -> Vector:
    """A place turned about the vertical."""
    cosine, sine = math.cos(yaw), math.sin(yaw)
    return cosine * place[0] + sine * place[2], place[1], -sine * place[0] + cosine * place[2]
