"""Joints that would go beyond their range live: eased back before and after, as all at once."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import kinesics as kx
from kinesics.geometry import quaternion
from kinesics.synthesis.control.controller import Controller
from kinesics.synthesis.embodiment import blending
from kinesics.synthesis.embodiment.ranges import Ranges, put_within_range
from kinesics.synthesis.embodiment.stage import Stage
from kinesics.synthesis.goals import Target
from kinesics.synthesis.live.renderer import LiveRenderer
from kinesics.synthesis.live.yielding import Yielding
from kinesics.synthesis.paths.network import network
from kinesics.synthesis.repertoire import repertoire

FPS = 60.0


@pytest.fixture(scope="module")
def stage() -> Stage:
    """Of a performed walk."""
    walk = kx.performer.walk(seconds=4, fps=FPS, noise_degrees=0.5, noise_kind="smooth", seed=5).motion
    return Stage.of(repertoire(walk))


def flying(stage: Stage, joint: int, frames: int) -> np.ndarray:
    """A joint that flies beyond its range and comes back, all others as they usually are: shape (frames, joints, 4)."""
    ranges = Ranges.of(stage)
    vectors = np.tile(ranges.inner, (frames, 1, 1))
    size = ranges.high[joint] - ranges.low[joint]
    along = np.abs(np.linspace(-1.0, 1.0, frames))
    vectors[:, joint] = ranges.high[joint] + size * (0.3 - 0.9 * along)[:, None]
    return blending.add_rotation(stage.middle, vectors)


def yielded(
    stage: Stage, rotations: np.ndarray, known: Callable[[int, int], bool] = lambda now, at: True, anew: int = -1
) -> np.ndarray:
    """Frame by frame, those being known of which ``known(now, at)`` is true, other ones from frame ``anew`` on."""
    yielding = Yielding(Ranges.of(stage), rotations.shape[1], FPS)
    out = rotations.copy()
    for now in range(len(out)):

        def coming(later: int, now: int = now) -> np.ndarray | None:
            at = now + later
            return rotations[at] if at < len(rotations) and known(now, at) else None

        yielding.step(out[now], coming, anew=now == anew)
    return out


def hard(stage: Stage, rotations: np.ndarray) -> np.ndarray:
    """Each frame held by itself."""
    out = rotations.copy()
    for one in out:
        Ranges.of(stage).hold(one)
    return out


def added(before: np.ndarray, after: np.ndarray) -> np.ndarray:
    """Leaps of angular velocity that are added from frame to frame, rad/s, shape (frames - 2, joints)."""
    back = blending.rotation_offset(before, after)
    return np.linalg.norm(np.diff(back, n=2, axis=0), axis=-1) * FPS


def begins(stage: Stage, rotations: np.ndarray) -> int:
    """The first frame in which a joint is beyond; not the very first."""
    first = int(np.flatnonzero(Ranges.of(stage).beyond(rotations).max(axis=1) > 1e-6)[0])
    assert first > 20
    return first


def knee(stage: Stage) -> int:
    return int(stage.legs.tibias[0])


@pytest.mark.parametrize("plain", ["0", "1"])
def test_joints_go_back_as_all_at_once(
    stage: Stage, rng: np.random.Generator, plain: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """All being known in time, frame by frame comes to what `put_within_range` makes of the whole; compiled and in NumPy."""
    monkeypatch.setenv("KINESICS_NO_NATIVE", plain)
    ranges = Ranges.of(stage)
    joints = np.arange(ranges.first, len(stage.middle))
    times = np.arange(60)[:, None, None] / FPS
    waves = np.sin(rng.uniform(3.0, 12.0, (1, len(stage.middle), 3)) * times + rng.uniform(0.0, 6.0, (1, 1, 3)))
    wild = blending.add_rotation(stage.middle, ranges.inner + 0.5 * waves)
    wild[[*range(8), *range(52, 60)]] = blending.add_rotation(stage.middle, ranges.inner)
    whole = wild.copy()
    put_within_range(stage, whole, joints)
    found = yielded(stage, wild)
    assert quaternion.angle(found, whole).max() < 1e-7
    assert quaternion.angle(found, wild).max() > 0.1
    assert np.array_equal(found[:, : ranges.first], wild[:, : ranges.first])


def test_a_joint_comes_to_rest_over_several_frames(stage: Stage) -> None:
    """A knee that flies beyond its range is stopped by a third of what stopping it dead takes, and never is beyond."""
    rotations = flying(stage, knee(stage), 80)
    soft, stopped = yielded(stage, rotations), hard(stage, rotations)
    assert added(rotations, stopped).max() > 0.5
    assert added(rotations, soft).max() < 0.35 * added(rotations, stopped).max()
    assert Ranges.of(stage).beyond(soft).max() < 1e-8


@pytest.mark.parametrize("late", [1, 3, 6])
def test_what_is_known_late_makes_no_leap(stage: Stage, late: int) -> None:
    """Known only a few frames before, a knee is stopped by less than stopping it dead takes; and never is beyond."""
    rotations = flying(stage, knee(stage), 80)
    first = begins(stage, rotations)
    soft = yielded(stage, rotations, lambda now, at: now >= first - late, anew=first - late)
    assert added(rotations, soft).max() < 0.8 * added(rotations, hard(stage, rotations)).max()
    assert Ranges.of(stage).beyond(soft).max() < 1e-8


def test_what_does_not_come_is_let_go(stage: Stage) -> None:
    """A knee that begins to go back, and then need not, comes to where it is played without a leap, and stays there."""
    rotations = flying(stage, knee(stage), 80)
    first = begins(stage, rotations)
    rotations[first:] = rotations[first - 1]
    wild = rotations.copy()
    wild[first:] = flying(stage, knee(stage), 80)[first:]
    yielding, out = Yielding(Ranges.of(stage), rotations.shape[1], FPS), rotations.copy()
    for now in range(80):
        asked = wild if now < first - 1 else rotations
        yielding.step(
            out[now], lambda k, now=now, asked=asked: asked[now + k] if now + k < 80 else None, anew=now == first - 1
        )
    turned = quaternion.angle(out, rotations)[:, knee(stage)]
    assert turned.max() > 1e-3
    assert turned[first + 2 * yielding.ahead :].max() < 1e-9
    assert yielding.at_rest
    # let go in one frame, it would come back at once by all that it has gone
    assert added(rotations, out).max() < 0.35 * turned.max() * FPS


def test_walkers_are_not_stopped_dead(shared_data: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """In live transitions of a walk joints are stopped by less than a fifth of what holding them frame by frame takes."""
    walk = kx.read(shared_data / "cmu" / "35" / "35_01.amc").resample(FPS)
    made = network(repertoire(walk))
    controller = Controller(made, Target((0.0, 40.0)), seed=2)
    paths = [(step.path, step.turned) for step in (controller.step() for _ in range(40))]

    def performed() -> np.ndarray:
        return np.stack([frame.rotations for frame in LiveRenderer(made, paths, pinned=False)])

    soft = performed()
    steps = {"free": lambda self, rotations, *_, **__: None, "held": lambda self, q, *_, **__: self._ranges.hold(q)}
    done = {}
    for name, step in steps.items():
        monkeypatch.setattr(Yielding, "step", step)
        done[name] = performed()
    ranges = Ranges.of(Stage.of(made.repertoire))
    assert ranges.beyond(done["free"]).max() > 0.02
    assert ranges.beyond(soft).max() < 1e-8
    assert added(done["free"], soft).max() < 0.2 * added(done["free"], done["held"]).max()
