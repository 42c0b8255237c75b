"""One cut at a time, live: the seam is that which a whole performance has there."""

from __future__ import annotations

import gc
import itertools
import tracemalloc
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

import kinesics as kx
from kinesics.body.skeleton import Skeleton
from kinesics.errors import InputError
from kinesics.geometry import quaternion
from kinesics.synthesis.control import controller as controlling
from kinesics.synthesis.control.controller import Controller
from kinesics.synthesis.control.weighing import Weighing
from kinesics.synthesis.embodiment import blending, quality
from kinesics.synthesis.embodiment.rehearsal import played
from kinesics.synthesis.embodiment.rendering import render
from kinesics.synthesis.embodiment.stage import Stage, seams
from kinesics.synthesis.goals import Economy, MovingTarget, Novelty, Target
from kinesics.synthesis.live.blends import Blend
from kinesics.synthesis.live.cuts import Crossing, Cuts
from kinesics.synthesis.live.poses import Poses
from kinesics.synthesis.live.renderer import AHEAD, LiveRenderer, performed
from kinesics.synthesis.live.treading import Treading
from kinesics.synthesis.paths import prospects as prospects_of
from kinesics.synthesis.paths.network import Network, network
from kinesics.synthesis.repertoire import repertoire


def carried(motion: kx.Motion, turns: np.ndarray) -> kx.Motion:
    """The same movement with the pelvis on a joint of its own that stands beneath it and turns, shape (frames, 4)."""
    old = motion.skeleton
    skeleton = Skeleton(
        ("Reference", *old.joint_names), (-1, *(p + 1 for p in old.parents)), np.insert(old.offsets, 0, 0.0, axis=0)
    )
    rotations = np.insert(motion.rotations, 0, turns, axis=1)
    rotations[:, 1] = quaternion.multiply(quaternion.conjugate(turns), motion.rotations[:, 0])
    return kx.Motion(skeleton, rotations, motion.root_positions, motion.fps)


@pytest.fixture(scope="module", params=["root", "beneath the pelvis"])
def made(request: pytest.FixtureRequest) -> Network:
    """Of a walk in a circle, backwards too; once with a joint above the pelvis that turns to and fro."""
    walk = kx.performer.walk(seconds=6, fps=30, noise_degrees=0.5, noise_kind="smooth", route="circle", seed=5).motion
    if request.param != "root":
        angles = 0.4 * np.sin(np.arange(len(walk)) / 7.0)
        walk = carried(walk, quaternion.from_axis_angle(np.tile([0.3, 1.0, 0.1], (len(walk), 1)), angles))
    return network(repertoire(walk, backwards=True))


@pytest.mark.parametrize(("reach", "plain"), [(1.0 / 30.0, "0"), (0.07, "0"), (0.07, "1")])
def test_the_seam_is_that_of_the_whole(
    made: Network, rng: np.random.Generator, reach: float, plain: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Offsets and velocities of all joints and the root, anywhere, also where a recording begins or ends; compiled and in NumPy."""
    monkeypatch.setenv("KINESICS_NO_NATIVE", plain)
    monkeypatch.setattr("kinesics.synthesis.embodiment.stage.REACH", reach)
    own = made.repertoire
    stage = Stage.of(own)
    cuts = Cuts(made, stage, Poses(stage, own, made), Treading(stage))
    last = own.frame_count - 1
    ends = [own.frame_count * strand + frame for strand in range(4) for frame in (0, last)]
    drawn = rng.integers(own.moment_count, size=(60, 2)).tolist()
    for left, first in [*drawn, *zip(ends, reversed(ends), strict=True), *((e, 10) for e in ends)]:
        yaw, turn = rng.uniform(-3.0, 3.0, 2)
        x, z = rng.uniform(-0.2, 0.2, 2)
        at = (np.array([v]) for v in (left, yaw, first, turn, (x, z)))
        found = cuts.seam(Crossing(left, first, complex(z, x), yaw, turn, 0.0))
        whole = seams(own, stage.carrier, *at)
        for one, many, most in zip(found, whole, (1e-7, 1e-5, 1e-7, 1e-5), strict=True):
            assert np.abs(one - many[0]).max() < most


def test_a_cut_is_the_same_compiled_and_in_numpy(
    made: Network, rng: np.random.Generator, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The seam, what remains of the transition before and how long each joint takes: of drawn cuts, with little time and much."""
    own, stage = made.repertoire, Stage.of(made.repertoire)
    cuts = Cuts(made, stage, Poses(stage, own, made), Treading(stage))
    earlier: Blend | None = None
    for k, (left, first) in enumerate(rng.integers(own.moment_count, size=(40, 2)).tolist()):
        yaw, turn, x, z = rng.uniform(-0.3, 0.3, 4)
        leap, frames = complex(*rng.normal(0.0, 0.02, 2)), int(rng.integers(12))
        made_of: list[Blend] = []
        for plain in ("0", "1"):
            monkeypatch.setenv("KINESICS_NO_NATIVE", plain)
            seam = cuts.seam(Crossing(left, first, complex(z, x), yaw, turn, 0.0))
            made_of.append(cuts.blend(seam, leap, 10 * k, frames, earlier if k % 3 else None))
        compiled, numpy = made_of
        assert compiled.ends == numpy.ends
        for one, other in zip(compiled[2:7], numpy[2:7], strict=True):
            assert one.shape == other.shape
            assert np.abs(one - other).max() < 1e-6 * max(1.0, np.abs(other).max())
        earlier = compiled


def test_overlapping_transitions_do_not_leap(made: Network) -> None:
    """Where a cut follows while the transition before is not over, what is left and what is entered are the same pose there."""
    own, stage = made.repertoire, Stage.of(made.repertoire)
    paths = [3]
    while len(paths) < 150:
        may = made.successors(paths[-1])
        leaves = may[made.first[may] != made.onward[paths[-1]]]
        paths.append(int(leaves[0] if len(leaves) else may[0]))
    renderer, overlaps, played_last = LiveRenderer(made, paths, pinned=False), 0, -1
    for _ in range(int(15 * own.fps)):
        blends, frame = renderer._blends, renderer._frame
        moment = next(renderer).moment
        if any(blend.cut == frame for blend in blends):
            left = own.rotations_of(own.advance(np.array([played_last]), 1))[0]
            entered = own.rotations_of(np.array([moment]))[0]
            for blend in blends:
                time = (frame - blend.cut) / own.fps
                left = blending.add_rotation(left, blend.at(time - 1e-9)[:-1])
                if blend.ends > frame:
                    entered = blending.add_rotation(entered, blend.at(time)[:-1])
                elif blend.cut < frame:
                    overlaps += bool(np.abs(blend.at(time)).max() > 0.03)
            assert np.delete(quaternion.angle(left, entered), stage.carrier).max() < 1e-6
        played_last = moment
    assert overlaps > 3


@pytest.mark.parametrize("plain", ["0", "1"])
def test_a_transition_adds_what_it_is(rng: np.random.Generator, plain: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Compiled and in NumPy: to rotations and root what blending adds, on both sides of the cut and after its end."""
    monkeypatch.setenv("KINESICS_NO_NATIVE", plain)
    own = quaternion.normalize(rng.normal(size=(7, 4)))
    offset, velocity = rng.normal(0.0, 0.3, (2, 8, 3))
    before, after, share = rng.uniform(0.1, 0.4, (3, 8))
    blend = Blend(10, 40, offset, velocity, before[:, None], after[:, None], share[:, None], 0j)
    for time in (-0.3, -0.05, 0.0, 0.2, 0.5):
        added = np.stack(
            [
                blending.two_sided(offset[k], velocity[k], np.array([time]), blending.Window(b, a, s))[0]
                for k, (b, a, s) in enumerate(zip(before, after, share, strict=True))
            ]
        )
        rotations = own.copy()
        assert np.abs(np.array(blend.add(rotations, time)) - added[-1]).max() < 1e-14
        assert quaternion.angle(rotations, blending.add_rotation(own, added[:-1])).max() < 1e-7


def test_a_body_is_carried_by_what_its_pelvis_hangs_on(made: Network) -> None:
    """Both bodies were read as they were meant, so that what is tested here is tested on both."""
    stage = Stage.of(made.repertoire)
    assert stage.carrier == (1 if made.repertoire.skeleton.joint_names[0] == "Reference" else 0)


@pytest.mark.parametrize("heading", [0.0, 2.0])
def test_the_body_faces_where_it_is_told_to(made: Network, heading: float) -> None:
    """The first frame has the heading asked for, and the place."""
    frame = next(LiveRenderer(made, [3], start=(1.0, -2.0), heading=heading, pinned=False))
    own = made.repertoire
    body = kx.Motion(own.skeleton, np.stack([frame.rotations] * 2), np.stack([frame.root] * 2), own.fps)
    assert np.exp(1j * kx.poses(body).yaw[0]) == pytest.approx(np.exp(1j * heading), abs=1e-6)
    assert frame.root[[0, 2]] == pytest.approx([1.0, -2.0])


def test_bent_ways_are_those_of_the_whole(made: Network, rng: np.random.Generator) -> None:
    """Bent path by path, the body goes where it goes when all is performed at once."""
    paths = [3]
    while len(paths) < 120:
        may = made.successors(paths[-1])
        onward = may[made.first[may] == made.onward[paths[-1]]]
        paths.append(int(rng.choice(onward if len(onward) and len(paths) % 12 else may)))
    bend = rng.uniform(-0.2, 0.2, len(paths))
    done = render(made, paths, start=(1.0, 2.0), heading=0.5, bend=bend, pinned=False)
    chosen = ((path, float(angle)) for path, angle in zip(paths, bend, strict=True))
    frames = list(LiveRenderer(made, chosen, start=(1.0, 2.0), heading=0.5, pinned=False))
    # a transition is spread otherwise, and longer: frames far from any
    near = np.convolve(done.provenance.transition, np.ones(31), mode="same") > 0.0
    assert (~near).sum() > 20
    for k in np.flatnonzero(~near):
        assert frames[k].root == pytest.approx(done.motion.root_positions[k], abs=1e-9)
        assert quaternion.angle(frames[k].rotations, done.motion.rotations[k]).max() < 1e-6
    for wrong in ((3, np.nan), (3, 0.1, 0.2)):
        with pytest.raises(InputError, match="pair"):
            next(LiveRenderer(made, [wrong]))


@pytest.mark.parametrize("wrong", [["a"], [(0, "x")], [(0, None)], [1.7], [(1.7, 0.0)], ["ab"], [[0, 0.1]]])
def test_what_is_no_path_is_refused(made: Network, wrong: list) -> None:
    """A path is a whole number, its bend a finite one."""
    with pytest.raises(InputError, match="number of a path"):
        next(LiveRenderer(made, wrong))


@pytest.mark.parametrize(
    "wrong", [{"heading": "x"}, {"heading": None}, {"heading": [0.0, 1.0]}, {"start": "ab"}, {"start": ("a", 0.0)}]
)
def test_what_is_no_place_or_heading_is_refused(made: Network, wrong: dict) -> None:
    """Before the first frame."""
    with pytest.raises(InputError, match=r"`start`.*`heading`"):
        LiveRenderer(made, [0], **wrong)
    with pytest.raises(InputError, match="`paths`"):
        LiveRenderer(made, 3)


class Watched:
    """A controller, and what it is told."""

    def __init__(self, controller: Controller) -> None:
        self.controller = controller
        self.told: list[complex] = []
        self.reckoned: list[complex] = []

    def choices(self) -> Iterator[tuple[int, float] | None]:
        """Those of the controller."""
        return self.controller.choices()

    def be_at(self, place: complex, heading: float) -> None:
        """Where it is, beside what the controller reckons."""
        assert np.exp(1j * heading) == pytest.approx(np.exp(1j * self.controller.now.heading), abs=0.02)
        self.reckoned.append(self.controller.now.place)
        self.told.append(place)
        self.controller.be_at(place, heading)


def test_the_controller_is_told_where_the_body_is(made: Network) -> None:
    """Decision by decision: it reckons from where the body truly comes to be, and is hardly off by the next."""
    watched = Watched(Controller(made, Target((2.0, -1.5)), seed=1))
    renderer = LiveRenderer(made, watched)
    begins: list[tuple[int, complex]] = []
    frames = [renderer.step() for _ in range(300)]
    for before, after in itertools.pairwise(frames):
        if after.path != before.path or after.moment == made.first[after.path]:
            begins.append((after.path, complex(after.root[2], after.root[0])))
    assert len(watched.told) > 10
    assert np.abs(np.subtract(watched.told, watched.reckoned)).max() < 0.15
    # the pelvis still sways as transitions die away
    true = [place for _, place in begins][: len(watched.told)]
    assert np.abs(np.subtract(watched.told[: len(true)], true)).max() < 0.12


@pytest.mark.parametrize("radius", [0.5, 0.12])
def test_what_feet_take_away_is_left_over(made: Network, radius: float) -> None:
    """Told where the body is, a controller is there only where the body will be, too: .1 m inside, or half of the radius."""
    inside = max(radius - 0.1, 0.5 * radius)
    for told, far, there in ((False, radius - 0.01, True), (True, radius - 0.01, False), (True, inside - 0.01, True)):
        controller = Controller(made, Target((0.0, 40.0), radius=radius), seed=1)
        controller.step()
        if told:
            controller.be_at(controller.now.place, controller.now.heading)
        (pursuit,) = controller._pursuits
        pursuit.passed(np.array([40.0 + 1j * far]), np.zeros(1))
        assert controller.attained == there


def test_a_target_is_come_to_live(made: Network) -> None:
    """By the body itself, wherever its feet take it, before it is said that one is there and stands."""
    own = made.repertoire
    for seed in range(6):
        there = np.array([3.0 * np.sin(seed), 3.0 * np.cos(seed)])
        controller = Controller(made, Target((float(there[0]), float(there[1]))), seed=seed)
        live, near = LiveRenderer(made, controller), np.inf
        for _ in range(int(40 * own.fps)):
            near = min(near, float(np.hypot(*(next(live).root[[0, 2]] - there))))
            if near <= 0.5 or (controller.finished and live._reaches - live._frame < 2):
                break
        assert near <= 0.5


def pushes(motion: kx.Motion, joints: list[int]) -> np.ndarray:
    """Accelerations of the joints' places, m/s², shape (frames − 2, joints)."""
    return np.linalg.norm(np.diff(motion.positions()[:, joints], n=2, axis=0), axis=-1) * motion.fps**2


def sent_about(made: Network, seed: int, seconds: float) -> kx.Motion:
    """Performed live, sent elsewhere every five seconds."""
    own = made.repertoire
    controller = Controller(made, Target((2.0, 4.0)), seed=seed)
    live = LiveRenderer(made, controller.choices())
    frames = []
    for k in range(round(seconds * own.fps)):
        if k and k % round(5 * own.fps) == 0:
            controller.pursue(Target(((-3.0) ** (k % 2), 4.0 - k / own.fps)))
        frames.append(next(live))
    rotations, roots = np.stack([f.rotations for f in frames]), np.stack([f.root for f in frames])
    return kx.Motion(own.skeleton, rotations, roots, own.fps)


def snaps(made: Network, seed: int, seconds: float) -> tuple[float, float]:
    """Greatest accelerations live as shares of those of the recordings, as they are and put on the ground: of pelvis, hips and
    knees; and of those and the ankles.
    """
    own, stage = made.repertoire, Stage.of(made.repertoire)
    joints = [0, *stage.legs.femurs, *stage.legs.tibias, *stage.legs.feet]
    live = pushes(sent_about(made, seed, seconds), joints)
    recorded = np.concatenate([pushes(own.motion(k), joints) for k in range(own.recording_count)])
    on_the_floor = played(stage)
    planted = [
        pushes(
            kx.Motion(own.skeleton, on_the_floor.rotations[k, a:b], on_the_floor.root_positions[k, a:b], own.fps),
            joints,
        )
        for k in (0, 1)
        for a, b in itertools.pairwise(own.starts.tolist())
    ]
    usual = np.concatenate([recorded, *planted])
    return float(live[:, :5].max() / usual[:, :5].max()), float(live.max() / usual.max())


def test_knees_do_not_snap() -> None:
    """Sent about at 60 frames a second, knees are accelerated by half more than in the walk played, four times, and by a fifth more
    on the average. Where most comes together, at the moment a heel strikes, the walk itself has 38 of the 54 m/s².
    """
    walk = kx.performer.walk(seconds=8, fps=60, noise_degrees=0.5, noise_kind="smooth", route="circle", seed=5).motion
    made = network(repertoire([walk]))
    knees = [snaps(made, seed, 15.0)[0] for seed in (1, 2, 3, 4)]
    assert max(knees) < 1.5
    assert np.mean(knees) < 1.25


@pytest.mark.parametrize("names", [["35_01"], ["91_34", "35_01"]])
def test_knees_of_real_walkers_do_not_snap(shared_data: Path, names: list[str]) -> None:
    """Nor are knees and ankles of walkers whose legs come near to being straight, also from one's walk into the other's."""
    walks = [kx.read(shared_data / "cmu" / name[:2] / f"{name}.amc").resample(60.0) for name in names]
    knees, ankles = snaps(network(repertoire(walks)), 0, 15.0)
    assert knees < 1.1
    assert ankles < 1.2


def test_steps_compute_no_tables(made: Network, monkeypatch: pytest.MonkeyPatch) -> None:
    """Neither the first step nor one after another wish: where to begin was weighed, and how long targets take, before; also for
    targets of another radius, where that was prepared.
    """

    def refused(*_: object) -> None:
        raise AssertionError("computed during a step")

    controller = Controller(made, MovingTarget(lambda t: (np.sin(t), np.cos(t))), seed=1)
    live = LiveRenderer(made, controller)
    controller.prepare(Target((0.0, 0.0), radius=0.3))
    controller.pursue(Target((1.0, 1.0)))
    monkeypatch.setattr(prospects_of, "to_go", refused)
    for name in ("Stop", "Laying"):
        monkeypatch.setattr(controlling, name, refused)
    monkeypatch.setattr(Weighing, "opening", refused)
    for goal in (None, Target((3.0, 3.0)), Target((-2.0, 3.0), radius=0.3), [Novelty(0.1), Economy(0.1)]):
        for _ in range(30):
            next(live)
        controller.pursue(goal)
    next(live)
    with pytest.raises(AssertionError, match="computed"):
        controller.pursue(Target((1.0, 1.0), radius=0.2))


def test_cuts_are_known_in_time(made: Network) -> None:
    """At 30 frames a second, too, a transition is known half of what is to be known before its cut."""
    live = LiveRenderer(made, Controller(made, [Target((900.0, 0.0)), Novelty(0.3)], seed=1))
    known: dict[int, int] = {}
    for _ in range(900):
        next(live)
        for blend in live._blends:
            known.setdefault(blend.cut, blend.cut - live._frame)
    assert len(known) > 5
    assert np.mean(list(known.values())) > 0.5 * AHEAD * made.repertoire.fps


@pytest.mark.parametrize("done", [1, 2, 3])
def test_choices_are_those_of_the_controller_in_parts(made: Network, done: int) -> None:
    """None between; the same paths and bends as one decision after the other, also if the wish changes while one is made."""

    def chosen(controller: Controller) -> list[tuple[int, float]]:
        return [(step.path, step.turned) for step in (controller.step() for _ in range(40))]

    goals = [Target((4.0, 40.0)), Novelty(0.1)]
    parts = Controller(made, goals, seed=3).choices()
    given = list(itertools.islice(parts, 160))
    assert given.count(None) > 80
    assert [c for c in given if c is not None][:40] == chosen(Controller(made, goals, seed=3))
    there, here = Controller(made, goals, seed=3), Controller(made, goals, seed=3)
    parts = there.choices()
    begun = 0
    while begun < done:
        begun = begun + 1 if next(parts) is None else 0
    made_before = [c for c in itertools.chain([None], given) if c is not None]
    before = int(there.now.plays.sum())
    there.pursue(Target((-9.0, -9.0)))
    assert [(s.path, s.turned) for s in (here.step() for _ in range(before))] == made_before[:before]
    here.pursue(Target((-9.0, -9.0)))
    assert [c for c in itertools.islice(parts, 110) if c is not None][:20] == chosen(here)[:20]


def test_the_same_seed_gives_the_same_frames(made: Network) -> None:
    """To the last bit, sent elsewhere on the way."""
    one, other = sent_about(made, 4, 7.0), sent_about(made, 4, 7.0)
    assert np.array_equal(one.rotations, other.rotations)
    assert np.array_equal(one.root_positions, other.root_positions)


def test_hours_take_no_more_memory_than_minutes(made: Network) -> None:
    """Hundreds of frames after something that moves leave behind no more than a list of gaps."""
    controller = Controller(made, [MovingTarget(lambda t: (np.sin(t), np.cos(t))), Novelty(0.1)], seed=1)
    live = LiveRenderer(made, controller.choices())

    def left_behind(frames: int) -> int:
        for _ in range(frames):
            next(live)
        gc.collect()
        return tracemalloc.get_traced_memory()[0]

    tracemalloc.start()
    try:
        settled = left_behind(150)
        assert left_behind(450) - settled < 100_000
    finally:
        tracemalloc.stop()


def test_what_was_performed_live_says_where_it_comes_from(made: Network) -> None:
    """Paths, cuts and moments are those that it was made of, and it can be measured; of nothing there is none."""
    controller = Controller(made, seed=2)
    paths = [controller.step().path for _ in range(30)]
    live = LiveRenderer(made, paths)
    done = performed(made, list(live))
    whole = render(made, paths)
    assert done.paths == whole.paths
    assert np.array_equal(done.provenance.moment, whole.provenance.moment)
    assert np.array_equal(done.provenance.step, whole.provenance.step)
    assert np.array_equal(done.cuts, whole.cuts)
    assert done.provenance.transition[done.cuts].all()
    assert quality.measure(done, made.repertoire).cuts == len(whole.cuts)
    with pytest.raises(InputError, match="frame"):
        performed(made, [])


def quality_live(made: Network, seconds: float, seed: int) -> quality.Quality:
    """Of a performance sent far away, as of one made at once."""
    own = made.repertoire
    controller = Controller(made, [Target((900.0, 0.0)), Economy(0.1), Novelty(0.1)], seed=seed)
    live = LiveRenderer(made, controller.choices())
    frames = list(itertools.islice(live, round(seconds * own.fps)))
    return quality.measure(performed(made, frames), own)


@pytest.mark.parametrize("clips", [["91/91_01"], ["135/135_02"]])
def test_feet_stay_live(shared_data: Path, clips: list[str]) -> None:
    """At most one contact in ten slides a centimetre, time on the ground is as recorded, nothing goes a centimetre below the
    floor or beyond its range; of those recorded nearly all slide.
    """
    read = [kx.read(shared_data / "cmu" / f"{clip}.amc").resample(60.0) for clip in clips]
    found = quality_live(network(repertoire(read)), 12.0, 2)
    assert found.contacts > 4
    assert found.slides_over.recordings > 0.6
    assert found.slides_over.performance <= 0.1
    assert found.contact_share.performance == pytest.approx(found.contact_share.recordings, rel=0.1)
    assert found.penetration.performance < 0.01
    assert found.joint_excess < 1e-6
    assert found.acceleration_added < 0.9
