"""What holds of every performance: lawful motion, feet on the ground, a truth that adds up, chance that repeats."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

import kinesics as kx
from kinesics import performer
from kinesics.errors import InputError
from kinesics.geometry import quaternion
from kinesics.performer import Body
from kinesics.performer.body import JOINT
from kinesics.vocabulary import MovementClass
from naive import symmetry as naive

CYCLIC = ("walk", "limp", "run", "jog_in_place", "jumping_jacks", "squat", "twist", "wave", "arm_circles", "butterfly")
HELD = {"throw", "raise_arms", "reach", "sway", "bow", "sun_salutation", "kata", "stand"}
TURNING_BACK = {
    *("jog_in_place", "jumping_jacks", "squat", "twist", "wave", "wave_both"),
    *("reach", "bow", "sun_salutation", "kata"),
}


def lowest(performance, body=None):
    """Height of the lowest point of feet and hands in every frame, metres."""
    body = body or Body()
    motion = performance.motion
    world, turned = motion.positions(), motion.global_rotations()
    heights = []
    for point in body.contact_points:
        at = world[:, point.joint] + quaternion.rotate(turned[:, point.joint], np.array(point.offset))
        heights.append(at[:, 1] - point.radius)
    return np.min(heights, axis=0)


def test_motions_are_lawful(performance):
    """Rotations are unit, everything is finite, and there are as many frames as seconds times rate."""
    motion, truth = performance.motion, performance.truth
    np.testing.assert_allclose(np.linalg.norm(motion.rotations, axis=-1), 1.0, atol=1e-12)
    assert np.isfinite(motion.root_positions).all()
    assert motion.frame_count == truth.frame_count
    assert motion.fps == truth.fps == 60.0


def test_bodies_stand_on_the_ground(performance):
    """The lowest point touches the ground in every frame, except in the flights of what leaves it."""
    height = lowest(performance)
    assert height.min() > -1e-9
    flying = performance.truth.movement in ("run", "jog_in_place", "jumping_jacks")
    assert height.max() < (0.16 if flying else 1e-9)
    assert not flying or np.mean(height < 1e-9) > 0.4
    assert not flying or height.max() > 0.01


def test_phrases_cover_every_frame(performance):
    """Phrases follow each other without gap or overlap from the first frame to the last."""
    truth = performance.truth
    borders = [(p.start, p.end) for p in truth.phrases]
    assert borders[0][0] == 0
    assert borders[-1][1] == truth.frame_count
    assert all(a[1] == b[0] for a, b in pairwise(borders))
    for phrase in truth.phrases:
        assert list(phrase.cycles) == sorted(set(phrase.cycles))
        assert all(phrase.start <= c <= phrase.end for c in phrase.cycles)
        assert (phrase.period_s is not None) == phrase.class_.value.startswith("cyclic")
        assert (phrase.group is not None) == phrase.class_.value.startswith("cyclic")


def test_stays_and_occurrences_cover_every_frame_once(performance):
    """Stays in states and occurrences of paths tile [0, frames)."""
    truth = performance.truth
    pieces = [(s.start, s.end) for state in truth.states for s in state.stays]
    pieces += [(o.start, o.end) for path in truth.paths for o in path.occurrences]
    pieces.sort()
    assert pieces[0][0] == 0
    assert pieces[-1][1] == truth.frame_count
    assert all(a[1] == b[0] for a, b in pairwise(pieces))


def test_paths_begin_and_end_in_their_states(performance):
    """At the border frames of each complete occurrence the pose is that of the state, to a frame's movement."""
    truth = performance.truth
    q = kx.poses(performance.motion).quaternions
    step = max(naive.distance(a, b) for a, b in pairwise(q)) if len(q) > 1 else 0.0
    whole = [o for path in truth.paths for o in path.occurrences if o.complete]
    assert bool(whole) == (truth.movement != "stand")
    for path in truth.paths:
        ends = [truth.state(path.from_).pose, truth.state(path.to).pose]
        for occurrence in path.occurrences:
            if not occurrence.complete:
                continue
            first, last = ends[::-1] if occurrence.reversed else ends
            assert naive.distance(q[occurrence.start], first) <= step + 1e-9
            assert naive.distance(q[occurrence.end - 1], last) <= step + 1e-9


def test_repeated_paths_repeat():
    """Each complete occurrence passes the same poses in the middle, forwards, backwards or mirrored."""
    compared = set()
    for name in performer.NAMES:
        performance = performer.perform(name, fps=400.0, **({"seconds": 6.0} if name in CYCLIC else {}))
        truth = performance.truth
        for path in truth.paths:
            whole = [o for o in path.occurrences if o.complete]
            middles = np.array([(o.start + o.end) // 2 for o in whole], dtype=int)
            if len(middles) < 2 or len({len(o) // 4 for o in whole}) > 2:
                continue  # a strike and a gentle arrival do not share a clock
            compared.add(name)
            q = kx.poses(performance.motion[middles.min() : middles.max() + 1]).quaternions[middles - middles.min()]
            assert max(naive.distance(q[0], other) for other in q[1:]) < 2e-4, (name, path.label)
    assert compared > set(CYCLIC)


def test_held_states_are_still(performance):
    """During a stay the pose is the state's own."""
    q = kx.poses(performance.motion).quaternions
    truth = performance.truth
    assert any(state.stays for state in truth.states) == (truth.movement in HELD)
    for state in truth.states:
        for stay in state.stays:
            for frame in (stay.start, (stay.start + stay.end) // 2, stay.end - 1):
                assert naive.distance(q[frame], state.pose) < 1e-9


def test_reversals_turn_back(performance):
    """About each reversal frame the movement before is the movement after, played backwards."""
    truth, fps = performance.truth, performance.motion.fps
    q = kx.poses(performance.motion).quaternions
    reach = 6
    assert any(reach <= frame < len(q) - reach for frame in truth.reversals) == (truth.movement in TURNING_BACK)
    for frame in truth.reversals:
        if reach <= frame < len(q) - reach:
            away = naive.distance(q[frame - reach], q[frame + reach])
            going = np.linalg.norm(q[frame + reach] - q[frame]) / fps
            # a reversal between two frames is half a frame off
            assert away < 3e-3 + 0.1 * going


def test_strikes_hit_at_full_speed():
    """At a strike the body comes in faster than it goes out, and turns back on its path."""
    performance = performer.kata(fps=120.0)
    q = kx.poses(performance.motion).quaternions
    assert len(performance.truth.strikes) >= 8
    for frame in performance.truth.strikes:
        before = naive.distance(q[frame - 6], q[frame - 4]) ** 0.5
        after = naive.distance(q[frame + 4], q[frame + 6]) ** 0.5
        assert before > 1.5 * after
        # it recoils: a little later it is back where it was a little before the impact
        assert min(naive.distance(q[frame - k], q[frame + 4]) for k in range(1, 9)) < 3e-3


@pytest.mark.parametrize("name", performer.NAMES)
def test_the_frame_rate_changes_nothing(name):
    """At 30 and at 120 fps the same seed is the same movement: each 30 fps frame is one of the 120 fps frames."""
    kw = {"tempo_jitter": 0.1, "seed": 5} if name != "stand" else {"seed": 5}
    kw |= {"noise_degrees": 2.0, "noise_kind": "smooth"}
    slow, fast = performer.perform(name, fps=30.0, **kw), performer.perform(name, fps=120.0, **kw)
    frames = slow.motion.frame_count
    np.testing.assert_allclose(slow.motion.rotations, fast.motion.rotations[::4][:frames], atol=1e-9)
    np.testing.assert_allclose(slow.motion.root_positions, fast.motion.root_positions[::4][:frames], atol=1e-9)
    assert slow.truth.class_ is fast.truth.class_
    for a, b in zip(slow.truth.phrases, fast.truth.phrases, strict=True):
        assert len(a.cycles) == len(b.cycles)
        assert all(0 <= 4 * x - y < 4 for x, y in zip(a.cycles, b.cycles, strict=True))


def test_seeds_repeat_and_differ():
    """The same seed gives the same performance to the last bit, another seed another; noise leaves the tempo alone."""
    first = performer.walk(seconds=4.0, tempo_jitter=0.1, noise_degrees=1.0, seed=7)
    again = performer.walk(seconds=4.0, tempo_jitter=0.1, noise_degrees=1.0, seed=7)
    other = performer.walk(seconds=4.0, tempo_jitter=0.1, noise_degrees=1.0, seed=8)
    quiet = performer.walk(seconds=4.0, tempo_jitter=0.1, seed=7)
    np.testing.assert_array_equal(first.motion.rotations, again.motion.rotations)
    assert np.abs(first.motion.rotations - other.motion.rotations).max() > 1e-3
    assert first.truth.cycles == quiet.truth.cycles != other.truth.cycles


def test_the_mirror_image_has_the_mirrored_truth(performance):
    """`mirrored=True` is `kx.mirror` of the performance; its truth is the same sentence about reflected poses."""
    image = performance.mirror()
    performed = performer.perform(performance.truth.movement, fps=60.0, mirrored=True)
    # the reach of the left and right limbs is the same, so the places agree as well as the poses
    np.testing.assert_allclose(image.motion.positions(), performed.motion.positions(), atol=1e-9)
    assert image.truth.phrases == performed.truth.phrases == performance.truth.phrases
    assert image.truth.paths == performed.truth.paths
    q = kx.poses(image.motion).quaternions
    for state in image.truth.states:
        for stay in state.stays:
            assert naive.distance(q[stay.start], state.pose) < 1e-9


def test_the_reverse_has_the_reversed_truth(performance):
    """Played backwards, the truth still tiles the frames, paths still join their states, and twice is once."""
    backwards = performance.reverse()
    test_phrases_cover_every_frame(backwards)
    test_stays_and_occurrences_cover_every_frame_once(backwards)
    test_paths_begin_and_end_in_their_states(backwards)
    twice = backwards.truth.reverse()
    assert twice.phrases == performance.truth.phrases
    assert twice.paths == performance.truth.paths
    assert twice.reversals == performance.truth.reversals


@pytest.mark.parametrize(
    ("name", "parameters", "message"),
    [
        ("walk", {"limp": 2.0}, r"`limp` between 0 and 1"),
        ("walk", {"seconds": float("nan")}, r"`seconds` between"),
        ("walk", {"seconds": 1.0}, r"two full periods"),
        ("walk", {"fps": 0.0}, r"`fps` between"),
        ("walk", {"period": "fast"}, r"`period` between .* got 'fast'"),
        ("run", {"amplitude": 9.0}, r"`amplitude` between"),
        ("run", {"tempo_jitter": -0.1}, r"`tempo_jitter` between"),
        ("squat", {"seed": -1}, r"`seed` to be a whole number"),
        ("squat", {"tempo_jitter": 0.1, "seed": 1.5}, r"`seed` to be a whole number"),
        ("twist", {"noise_degrees": 90.0}, r"`noise_degrees` between 0 and 30"),
        ("twist", {"noise_degrees": 1.0, "noise_kind": "pink"}, r"`noise_kind` 'white' or 'smooth'"),
        ("wave", {"asymmetry_degrees": 100.0}, r"`asymmetry_degrees` between"),
        ("wave", {"body": 17.5}, r"`body` between"),
        ("wave", {"facing_degrees": float("inf")}, r"`facing_degrees`"),
        ("wave", {"route": "circle"}, r"wave does not travel"),
        ("walk", {"route": "zigzag"}, r"`route` to be 'straight', 'circle' or points"),
        ("walk", {"route": [(0.0, 0.0)]}, r"at least two finite points"),
        ("walk", {"route": [(0.0, 0.0), (0.0, 0.0)]}, r"points of `route` are the same"),
        ("bow", {"seconds": 1.0, "period": 2.0}, r"`period` \(the movement itself\) within `seconds`"),
        ("stand", {"period": 2.0}, r"stand has no parameter period. Parameters: seconds"),
        ("walk", {"speed": 2.0}, r"walk has no parameter speed. Parameters: .*limp.*noise_degrees"),
        ("fly", {}, r"Nobody knows the movement 'fly'. Movements: walk"),
    ],
)
def test_bad_arguments_are_named(name, parameters, message):
    """What cannot be performed is an `InputError` naming the argument, its range and what came."""
    with pytest.raises(InputError, match=message):
        performer.perform(name, **parameters)


def test_periods_are_unequal_under_jitter():
    """Tempo jitter spreads the true boundaries about the period; they are where the movement really begins again."""
    performance = performer.squat(seconds=60.0, period=2.0, tempo_jitter=0.1, fps=100.0, seed=2)
    lengths = np.diff(performance.truth.cycles) / 100.0
    assert 0.04 < np.std(lengths / 2.0) < 0.2
    assert np.mean(lengths) == pytest.approx(performance.truth.period_s, rel=1e-2)
    q = kx.poses(performance.motion).quaternions
    starts = [q[c] for c in performance.truth.cycles if c < len(q)]
    assert max(naive.distance(starts[0], other) for other in starts[1:]) < 1e-4


def test_what_is_asked_of_a_walk_is_what_it_does():
    """A period of 1.2 s at 100 fps gives boundaries every 120 frames; amplitude scales the speed; size scales the stride."""
    walk = performer.walk(seconds=6.0, fps=100.0, period=1.2)
    assert walk.truth.cycles == (0, 120, 240, 360, 480, 600)

    def distance(**kw):
        return performer.walk(seconds=6.0, fps=100.0, period=1.2, **kw).motion.root_positions[-1, 2]

    assert distance(amplitude=0.6) < 0.75 * distance()
    assert distance(body=1.2) == pytest.approx(distance() * 1.2 / 1.75, rel=0.03)
    assert distance(body=Body(legs=1.2)) > 1.1 * distance()


def test_planted_feet_do_not_slide():
    """In walking, a foot flat on the ground moves less than 1 cm between heel strike and heel rise."""
    motion = performer.walk(seconds=5.0, fps=120.0).motion
    ankle = motion.positions()[:, JOINT["LeftFoot"]]
    flat = np.abs(ankle[:, 1] - 0.039 * 1.75) < 1e-3
    edges = np.flatnonzero(np.diff(np.concatenate([[0], flat.astype(int), [0]])))
    stances = [(a, b) for a, b in zip(edges[::2], edges[1::2], strict=True) if b - a > 12]
    assert len(stances) >= 3
    for start, end in stances:
        assert np.ptp(ankle[start:end, 2]) < 0.01
        assert np.ptp(ankle[start:end, 0]) < 0.02


def test_gaits_go_as_fast_as_people():
    """Walking goes at 1 to 1.6 m/s, running at 2.5 to 4.5, limping slower than walking; jogging in place stays."""

    def speed(performance):
        path = performance.motion.root_positions
        return np.linalg.norm(path[-1] - path[0]) / performance.motion.duration

    assert 1.0 < speed(performer.walk()) < 1.6
    assert 2.5 < speed(performer.run()) < 4.5
    assert speed(performer.limp()) < 0.8
    assert speed(performer.jog_in_place()) < 0.02


def test_white_noise_has_the_size_asked_for():
    """The root mean square turn of the joints is the given number of degrees, white or smooth."""
    clean = performer.stand(seconds=20.0, fps=100.0).motion
    for kind in ("white", "smooth"):
        noisy = performer.stand(seconds=20.0, fps=100.0, noise_degrees=3.0, noise_kind=kind, seed=4).motion
        turn = np.rad2deg(quaternion.angle(clean.rotations, noisy.rotations))
        assert np.sqrt(np.mean(turn**2)) == pytest.approx(3.0, rel=0.1)
        jump = np.rad2deg(quaternion.angle(noisy.rotations[1:], noisy.rotations[:-1]))
        assert (np.median(jump) > 3.0) == (kind == "white")


def test_asymmetry_is_a_constant_difference_of_left_and_right():
    """Upper arms and thighs differ from their mirror images by the given angle in every frame; it is no movement."""
    for name in ("squat", "jumping_jacks"):
        q = kx.poses(performer.perform(name, fps=20.0, asymmetry_degrees=12.0).motion).quaternions
        for left, right in ((7, 11), (9, 13), (10, 14)):
            image = q[:, right] * [1, 1, -1, -1]
            angle = np.rad2deg(quaternion.angle(q[:, left], image))
            np.testing.assert_allclose(angle, 12.0, atol=1e-6)


def test_facing_turns_the_whole_performance():
    """A start facing left turns every position about the vertical and changes no pose."""
    ahead, left = performer.walk(seconds=3.0), performer.walk(seconds=3.0, facing_degrees=90.0)
    turned = ahead.motion.positions()[..., [2, 1, 0]] * [1, 1, -1]
    np.testing.assert_allclose(left.motion.positions(), turned, atol=1e-9)
    a, b = kx.poses(ahead.motion), kx.poses(left.motion)
    np.testing.assert_allclose(np.abs(np.sum(a.quaternions * b.quaternions, axis=-1)), 1.0, atol=1e-9)
    assert left.motion.root_positions[-1, 0] > 2.0


def test_routes_are_followed():
    """On a circle the walker comes round to the left; through points it passes them, facing along the way."""
    circle = performer.walk(seconds=30.0, fps=30.0, route="circle").motion.root_positions[:, [0, 2]]
    radius = np.linalg.norm(circle - [3.0, 0.0], axis=1)
    assert np.abs(radius - 3.0).max() < 0.05
    assert circle[:, 0].max() > 5.9
    points = np.array([(0.0, 0.0), (0.0, 3.0), (3.0, 5.0), (6.0, 5.0)])
    performance = performer.walk(seconds=12.0, fps=60.0, route=points)
    floor = performance.motion.root_positions[:, [0, 2]]
    for point in points:
        assert np.linalg.norm(floor - point, axis=1).min() < 0.08
    going = np.diff(floor[::30], axis=0)
    heading = np.arctan2(going[:, 0], going[:, 1])
    difference = np.angle(np.exp(1j * (heading - kx.poses(performance.motion).yaw[15::30][: len(heading)])))
    assert np.rad2deg(np.abs(difference)).max() < 20.0


def test_parameters_are_listed():
    """Each movement's parameters can be asked for by name, its own before the common ones."""
    assert performer.parameters_of("walk")[:3] == ("seconds", "fps", "limp")
    for name in performer.NAMES:
        assert {"seconds", "fps", "seed", "noise_degrees", "body", "mirrored"} <= set(performer.parameters_of(name))


def test_one_full_round_is_no_cycle():
    """One sun salutation is asymmetric as a whole; two are cyclic with the round as period."""
    once = performer.sun_salutation(seconds=34.0, fps=10.0).truth
    twice = performer.sun_salutation(seconds=68.0, fps=10.0).truth
    assert once.class_ is MovementClass.ASYMMETRIC
    assert once.period_s is None
    assert twice.class_ is MovementClass.CYCLIC_ASYMMETRIC
    assert twice.period_s == pytest.approx(34.0)


def test_the_sun_salutation_is_that_of_the_dissertation():
    """States Y X T W V, all symmetric; every path symmetric but the one into the plank; the order of §3.6.1."""
    truth = performer.sun_salutation(seconds=34.0, fps=10.0).truth
    assert {s.label for s in truth.states} == {"Y~", "X~", "T~", "W~", "V~"}
    assert all(s.symmetric for s in truth.states)
    assert [p.label for p in truth.paths if p.mirror_of != p.label] == ["wv_1"]
    assert {p.label for p in truth.paths if p.reversible} == {"yx~_1", "xt~_1", "tw~_1"}
    assert truth.notation == ("yx~_1 <yx~_1 yy~_1 yx~_1 xt~_1 tw~_1 wv_1 vv~_1 vw~_1 <tw~_1 <xt~_1 <yx~_1")
    assert len(truth.stillness) == 12


def test_side_kicks_are_three_phrases():
    """Cycles to the left, an antipalindromic turn about, the mirrored cycles to the right (§3.5.6)."""
    performance = performer.side_kicks(fps=60.0)
    kinds = [p.class_ for p in performance.truth.phrases]
    assert kinds == [
        MovementClass.CYCLIC_ASYMMETRIC,
        MovementClass.ANTIPALINDROMIC,
        MovementClass.CYCLIC_ASYMMETRIC,
    ]
    left, _, right = performance.truth.phrases
    q = kx.poses(performance.motion)
    length = left.end - left.start
    assert naive.distance(q.quaternions[left.start + 40], naive.mirrored(q.quaternions[right.start + 40])) < 1e-3
    assert length == pytest.approx(right.end - right.start, abs=1)
    turned = np.angle(np.exp(1j * (q.yaw[right.start + 20] + q.yaw[left.start + 20])))
    assert abs(turned) == pytest.approx(np.pi, abs=0.02)


def test_the_kata_returns_to_its_symmetric_state():
    """X is held at the start, in the middle and at the end; A to D and their images are asymmetric."""
    truth = performer.kata(fps=30.0).truth
    held = truth.state("X~").stays
    assert held[0].start == 0
    assert held[-1].end == truth.frame_count
    assert any(abs((s.start + s.end) / 2 - truth.frame_count / 2) < 0.03 * truth.frame_count for s in held)
    assert {s.label for s in truth.states if not s.symmetric} == {"A", "B", "C", "D", "A*", "B*", "C*", "D*"}
