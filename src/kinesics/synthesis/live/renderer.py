"""Paths performed live, frame by frame as they are chosen, knowing only the past ([Schultz2012] §4.4).

`kinesics.synthesis.embodiment.rendering` does the same with the whole performance before it.
"""

from __future__ import annotations

import gc
import math
import operator
from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from typing import Final, NamedTuple, Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinesics.body.motion import Motion
from kinesics.errors import InputError
from kinesics.geometry import single
from kinesics.synthesis.embodiment import blending
from kinesics.synthesis.embodiment.ranges import Ranges
from kinesics.synthesis.embodiment.rehearsal import played
from kinesics.synthesis.embodiment.rendering import Performance, Provenance
from kinesics.synthesis.embodiment.stage import Stage
from kinesics.synthesis.live.blends import Blend
from kinesics.synthesis.live.clear_arms import ClearArms
from kinesics.synthesis.live.cuts import Cuts
from kinesics.synthesis.live.foresight import Foresight, Stretch
from kinesics.synthesis.live.poses import Poses
from kinesics.synthesis.live.treading import Treading
from kinesics.synthesis.live.yielding import Yielding
from kinesics.synthesis.paths.network import Network
from kinesics.synthesis.repertoire import BACKWARD_STRANDS

Array = NDArray[np.float64]

AHEAD: Final = 0.32
"""Seconds of what comes that are known where nothing else is said: about as long as a human takes to change its mind."""
_SHORTLY: Final = 3
"""Frames: while fewer are known, or less than half of what is to be, it is hurried: one part more of a decision or cut is done in
each."""
_PARTS: Final = 6
"""Of a decision and the cut that comes of it, from being asked for to being known, at most."""
_THOUGHT: Final = 0.1
"""Seconds in which they are done: of 30 frames a second each does two parts, else a transition would begin late."""
LONGEST_AHEAD: Final = 10.0
"""Seconds."""
_DONE: Final = object()


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


@runtime_checkable
class Guide(Protocol):
    """Decides which way to go: a `kinesics.synthesis.control.controller.Controller`."""

    def choices(self) -> Iterator[tuple[int, float] | None]:
        """Paths, and by how many radians each is turned besides; None while one is thought over."""

    def be_at(self, place: complex, heading: float) -> None:
        """Be told where the body truly is as the next path begins, z + i·x, metres, and where it faces, radians."""


class LiveRenderer:
    """Performs paths frame by frame, as they are chosen, knowing little of what comes.

    A transition begins as soon as it is known (`synthesis.embodiment.blending.two_sided`), at the latest with the cut. A foot
    comes down where it will be needed (`kinesics.synthesis.live.foresight`) and stays there. An iterator of `LiveFrame`; it ends
    when the paths do.

    Parameters
    ----------
    network : of the paths.
    paths : a `synthesis.control.controller.Controller`, which is then told where the body truly comes to be as it goes with
        its feet; or numbers of paths, each a successor of the one before, or pairs of such a number and the radians that the
        path is turned by besides, as ``bend`` of `render`; None where none is decided for yet: then it is asked again a frame
        later.
    start, heading : see `render`.
    pinned : whether feet are kept in place.
    ahead : seconds that are to be known: the next path is asked for as soon as less is. With 0 it is asked for as the one
        before has ended, and feet and transitions begin late. Asking for a path and getting ready for it are done in frames
        of their own, where there is time.

    All tables are made here, those of a controller included, so that no step waits for them, not even the first.
    Garbage is collected once, too; who makes much of it afterwards may call ``gc.freeze()``, or collect between steps.

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
        own = played(self.stage) if pinned else network.repertoire
        self._treading = Treading(self.stage)
        self._poses = Poses(self.stage, own, network)
        self._cuts = Cuts(network, self.stage, self._poses, self._treading)
        self._yielding = Yielding(
            Ranges.of(self.stage), network.repertoire.skeleton.joint_count, network.repertoire.fps
        )
        self._clear_arms = ClearArms(self.stage)
        self._anew = False
        self._foresight = Foresight.of(self.stage)
        network.edge(0, 0)  # a table that is made when first asked for
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
        self._hurried = max(_SHORTLY, self._ahead // 2)
        self._parts = math.ceil(_PARTS / (_THOUGHT * network.repertoire.fps))
        self._frame = self._reaches = 0
        self._blends: list[Blend] = []
        # what getting ready has made is looked through now, not by collections of garbage during steps, tens of milliseconds long
        gc.collect()

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
        rotations, root = self._poses.at(image, frame, turn, playing.places[self._at])
        if self._blends:
            if self._blends[0].ends <= self._frame:
                self._blends = [blend for blend in self._blends if blend.ends > self._frame]
            for blend in self._blends:
                added = blend.add(rotations, (self._frame - blend.cut) / self.network.repertoire.fps)
                root = single.add(root, added)
        if self._blends or not self._yielding.at_rest:
            self._yielding.step(rotations, self._coming, anew=self._anew)
            self._anew = False
        if self.pinned:
            for blend in self._blends:
                if blend.cut == self._frame:
                    self._treading.leap(blend.leap)
            root = self._treading.step(rotations, root, image, frame, self._foresight.coming(self._known, self._at))
        self._clear_arms.put_clear(rotations)
        self._at += 1
        self._frame += 1
        if self._at == playing.length:
            self._known.popleft()
            self._at = 0
        return LiveFrame(rotations, np.array(root), self.moment, self.path)

    def _coming(self, later: int) -> Array | None:
        """The rotations so many frames later, as far as transitions add to them and they are known."""
        frame = self._frame + later
        adding = [blend for blend in self._blends if blend.ends > frame]
        if not adding or frame >= self._reaches:
            return None
        at = self._at + later
        for stretch in self._known:
            if at < stretch.length:
                break
            at -= stretch.length
        rotations: Array = self._poses.own.rotations[stretch.image, stretch.frame + at * stretch.onward].copy()
        for blend in adding:
            blend.add(rotations, (frame - blend.cut) / self.network.repertoire.fps)
        return rotations

    def _look(self) -> None:
        """Ask for what comes, and get ready for it: one after the other, if there is time."""
        if self._known:
            for _ in range(self._parts if self._reaches - self._frame >= self._hurried else self._parts + 1):
                self._prepare()
        # at first, and where all that was known has been performed: no more than what is needed now
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
        if self._last >= 0 and network.edge(self._last, path) < 0:
            raise InputError(f"Path {path} does not follow path {self._last}.")
        return path, bend

    def _lay(self, path: int, bend: float) -> None:
        """Put a path behind those that are known."""
        network, repertoire = self.network, self.network.repertoire
        first, length = int(network.first[path]), int(network.length[path])
        if self._last < 0:
            self._turn = self.heading - self._poses.faces[path]
        strand, frame = divmod(first, repertoire.frame_count)
        image, onward = strand % 2, -1 if BACKWARD_STRANDS[strand] else 1
        bent = bend / length
        places = self._laid + self._poses.way(image, frame, onward, length, self._turn, bent)
        self._known.append(Stretch(path, first, image, frame, onward, length, self._turn, bent, places[:-1].tolist()))
        self._last = path
        # more than the frames that follow those known is known anew, if those are few or what is laid comes by a transition
        self._anew |= self._reaches - self._frame <= self._yielding.ahead
        self._reaches += length
        self._laid, self._tell = complex(places[-1]), True
        self._turn += bend
        self.heading = self._poses.faces_onward[path] + self._turn

    def _goes_on(self, path: int) -> bool:
        """Whether a path is performed without leaving the recording that is played."""
        return self._last < 0 or int(self.network.first[path]) == int(self.network.onward[self._last])

    def _over(self, path: int, bend: float) -> Iterator[None]:
        """Get ready for a path of another recording; in parts."""
        crossing = self._cuts.crossing(self._last, path, self._turn, self.heading)
        leap = self._cuts.leap(crossing) if self.pinned else 0j
        yield
        seam = self._cuts.seam(crossing)
        earlier = self._blends[-1] if self._blends and self._blends[-1].ends > self._reaches else None
        blend = self._cuts.blend(seam, leap, self._reaches, self._reaches - self._frame, earlier)
        if earlier is not None:
            # what remains of the transition before ends here
            self._blends[-1] = earlier._replace(ends=self._reaches)
        self._blends.append(blend)
        self._anew = True
        self._turn = crossing.turn
        self._laid += crossing.aside
        self.heading += crossing.met
        self._lay(path, bend)


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
    return Performance(
        motion,
        came,
        tuple(paths[begins].tolist()),
        cuts,
        standing,
        (),
        stage.soles,
        np.zeros(count),
    )
