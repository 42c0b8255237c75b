"""A motion graph of key poses: each path one smooth curve through its own, whatever way and however often it is taken.

Passing a state without a stop needs one direction of movement for all paths through it (`KeyState.velocity`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from kinesics.errors import InputError
from kinesics.performer import postures as _postures
from kinesics.performer.postures import ANGLES, pose

Array = NDArray[np.float64]

STOP_TO_STOP: Final = 1.875
"""A path from stop to stop takes this many times as long as one passed at full speed: the top speed is the same."""


@dataclass(frozen=True, eq=False)
class KeyState:
    """A node: a key pose.

    Raises
    ------
    InputError
        If the posture has the wrong shape or is not finite.
    """

    label: str
    """"A", the mirror image "A*", symmetric "X~"."""
    posture: Array
    """See `kinesics.performer.postures`; shape (angles,)."""
    mirror_of: str | None = None
    """The state of the graph that is its mirror image; itself where it is symmetric."""
    velocity: Array | None = None
    """How the body moves through it, radians a second, shape (angles,); None where it always stops."""

    def __post_init__(self) -> None:
        """Check the arrays."""
        for label in ("posture", "velocity"):
            values = getattr(self, label)
            if values is None:
                continue
            values = np.array(values, dtype=np.float64)
            if values.shape != (len(ANGLES),) or not np.isfinite(values).all():
                raise InputError(f"Expected {label} of state '{self.label}' to be {len(ANGLES)} finite numbers.")
            values.setflags(write=False)
            object.__setattr__(self, label, values)

    @property
    def symmetric(self) -> bool:
        """Whether it is its own mirror image."""
        return bool(np.allclose(_postures.mirror(self.posture), self.posture, atol=1e-9))

    @cached_property
    def pose(self) -> Array:
        """Unit quaternions of the 15 links, shape (15, 4)."""
        return pose(self.posture)


@dataclass(frozen=True, eq=False)
class KeyPath:
    """An edge: a smooth way from one state to another through key poses of its own."""

    label: str
    """"ab_1", the mirror image "(ab_1)*", symmetric "xy~_1"."""
    from_: str
    to: str
    seconds: float
    """From stop to stop."""
    via: tuple[Array, ...] = ()
    """Postures on the way, evenly spaced."""
    reversible: bool = False
    mirror_of: str | None = None
    """The path of the graph that is its mirror image; itself where it is symmetric."""
    along: tuple[int, int] = (1, 1)
    """Whether it leaves and arrives with the velocities of its states (1) or against them (−1)."""


@dataclass(frozen=True, eq=False)
class KeyGraph:
    """A motion graph of key poses.

    Raises
    ------
    InputError
        With all that is wrong: doubled labels, unknown states, images that are no images, times out of range.
    """

    states: tuple[KeyState, ...]
    paths: tuple[KeyPath, ...]
    name: str = "traversal"
    _curves: dict[str, CubicSpline] = field(default_factory=dict, init=False, repr=False)

    def __post_init__(self) -> None:
        """Check the graph as a whole and list every fault."""
        faults: list[str] = []
        labels = [s.label for s in self.states]
        names = [p.label for p in self.paths]
        faults += [f"state '{x}' is there twice" for x in sorted({x for x in labels if labels.count(x) > 1})]
        faults += [f"path '{x}' is there twice" for x in sorted({x for x in names if names.count(x) > 1})]
        states = {s.label: s for s in self.states}
        paths = {p.label: p for p in self.paths}
        for s in self.states:
            if s.mirror_of is None:
                continue
            image = states.get(s.mirror_of)
            if image is None or not np.allclose(_postures.mirror(s.posture), image.posture, atol=1e-9):
                faults.append(f"state '{s.label}' is not the mirror image of '{s.mirror_of}'")
        for p in self.paths:
            faults += [f"path '{p.label}' ends at unknown state '{x}'" for x in (p.from_, p.to) if x not in states]
            if p.along[0] not in (-1, 1) or p.along[1] not in (-1, 1):
                faults.append(f"path '{p.label}' goes along {p.along}, not 1 or -1")
            if not (np.isfinite(p.seconds) and 0.05 <= p.seconds <= 60.0):
                faults.append(f"path '{p.label}' takes {p.seconds} s, not .05 to 60")
            if any(np.shape(v) != (len(ANGLES),) or not np.isfinite(v).all() for v in p.via):
                faults.append(f"path '{p.label}' goes through what is not {len(ANGLES)} finite numbers")
            elif p.from_ == p.to and not p.via:
                faults.append(f"path '{p.label}' goes nowhere: a loop needs postures on the way")
            if p.mirror_of is not None and not _is_image(p, paths.get(p.mirror_of), states):
                faults.append(f"path '{p.label}' is not the mirror image of '{p.mirror_of}'")
        if not self.states or not self.paths:
            faults.append("it needs at least one state and one path")
        if faults:
            raise InputError("This graph cannot be traversed: " + "; ".join(faults) + ".")
        for p in self.paths:
            self._curves[p.label] = self._curve(p)

    def state(self, label: str) -> KeyState:
        """The state of that label.

        Raises
        ------
        InputError
            If there is none.
        """
        for s in self.states:
            if s.label == label:
                return s
        raise InputError(f"No state is labelled '{label}'. States: {', '.join(s.label for s in self.states)}.")

    def path(self, label: str) -> KeyPath:
        """The path of that label.

        Raises
        ------
        InputError
            If there is none.
        """
        for p in self.paths:
            if p.label == label:
                return p
        raise InputError(f"No path is labelled '{label}'. Paths: {', '.join(p.label for p in self.paths)}.")

    def _curve(self, p: KeyPath) -> CubicSpline:
        """Geometry of a path over u in [0, 1]; at a state with a velocity it is tangent to it."""
        ends = self.state(p.from_), self.state(p.to)
        knots = np.array([ends[0].posture, *p.via, ends[1].posture])
        full_speed = p.seconds / STOP_TO_STOP
        boundary: list[tuple[Literal[1, 2], Array]] = [
            # the second derivative is zero at a stop, the first is given at a passage
            (1, sign * s.velocity * full_speed) if s.velocity is not None else (2, np.zeros(len(ANGLES)))
            for s, sign in zip(ends, p.along, strict=True)
        ]
        return CubicSpline(np.linspace(0.0, 1.0, len(knots)), knots, bc_type=(boundary[0], boundary[1]))

    def along(self, label: str, u: Array) -> Array:
        """Postures on a path at u in [0, 1], shape (n, angles)."""
        self.path(label)
        return np.asarray(self._curves[label](u))

    def velocity(self, label: str, *, reversed_: bool, at_end: bool) -> Array:
        """Angular velocities at full speed at one end of a traversal, radians a second, shape (angles,)."""
        p = self.path(label)
        direction = -1.0 if reversed_ else 1.0
        u = 1.0 if at_end != reversed_ else 0.0
        return np.asarray(direction * self._curves[label](u, 1) * STOP_TO_STOP / p.seconds)

    def palindromic(self, label: str) -> bool:
        """Whether a loop is its own way back."""
        p = self.path(label)
        if p.from_ != p.to:
            return False
        u = np.linspace(0.0, 1.0, 41)
        return bool(np.allclose(self.along(label, u), self.along(label, u[::-1]), atol=1e-9))


def _is_image(p: KeyPath, image: KeyPath | None, states: dict[str, KeyState]) -> bool:
    if image is None or len(image.via) != len(p.via) or image.seconds != p.seconds:
        return False
    ends = [(p.from_, image.from_), (p.to, image.to)]
    if any(a not in states or states[a].mirror_of != b for a, b in ends):
        return False
    for k, end in enumerate((p.from_, p.to)):
        velocity, image_velocity = states[end].velocity, states[(image.from_, image.to)[k]].velocity
        if (velocity is None) != (image_velocity is None):
            return False
        if velocity is not None and image_velocity is not None:
            reflected = _postures.mirror(velocity) * p.along[k]
            if not np.allclose(reflected, image_velocity * image.along[k], atol=1e-9):
                return False
    return all(np.allclose(_postures.mirror(a), b, atol=1e-9) for a, b in zip(p.via, image.via, strict=True))


def mirrored_path(path: KeyPath, label: str, graph_states: Mapping[str, KeyState]) -> KeyPath:
    """The mirror image of a path between the images of its ends.

    Raises
    ------
    InputError
        If an end has no mirror image.
    """
    ends: list[str] = []
    signs: list[int] = []
    for end, sign in zip((path.from_, path.to), path.along, strict=True):
        state = graph_states[end]
        if state.mirror_of is None:
            raise InputError(f"Path '{path.label}' has no mirror image: state '{end}' has none.")
        image = graph_states[state.mirror_of]
        turned = (
            state.velocity is not None
            and image.velocity is not None
            and not np.allclose(_postures.mirror(state.velocity), image.velocity, atol=1e-9)
        )
        ends.append(image.label)
        signs.append(-sign if turned else sign)
    return KeyPath(
        label,
        ends[0],
        ends[1],
        path.seconds,
        via=tuple(_postures.mirror(v) for v in path.via),
        reversible=path.reversible,
        mirror_of=path.label,
        along=(signs[0], signs[1]),
    )
