"""Traversals do what the steps say, along one and the same curve whichever way and however fast."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import kinesics as kx
from kinesics.errors import InputError
from kinesics.performer import STANDING, KeyGraph, KeyPath, KeyState, Step, posture, traverse
from kinesics.performer.key_graph import mirrored_path
from kinesics.performer.postures import mirror
from kinesics.performer.words import Token, class_of
from kinesics.vocabulary import MovementClass
from naive import symmetry as naive

C = MovementClass

LEFT = posture(STANDING, left_shoulder_elevate=40, trunk_lean=-15)
VIA = posture(STANDING, left_shoulder_elevate=-30, left_elbow=90, trunk_twist=30)
UP = posture(STANDING, shoulder_elevate=60)


def small_graph(**changes):
    """Y~ with a raised left arm A and right arm A*, and both arms up X~."""
    states = (
        KeyState("Y~", STANDING, "Y~"),
        KeyState("X~", UP, "X~"),
        KeyState("A", LEFT, "A*"),
        KeyState("A*", mirror(LEFT), "A"),
    )
    path = KeyPath("ya_1", "Y~", "A", 1.0, (VIA,), reversible=True, mirror_of="(ya_1)*")
    image = mirrored_path(path, "(ya_1)*", {s.label: s for s in states})
    other = KeyPath("ya_2", "Y~", "A", 1.2, (posture(VIA, left_elbow=10, trunk_twist=-30),))
    arms = KeyPath("yx~_1", "Y~", "X~", 0.8, reversible=True, mirror_of="yx~_1")
    oneway = KeyPath("ax_1", "A", "X~", 1.0)
    loop = KeyPath("yy~_1", "Y~", "Y~", 1.0, (posture(STANDING, shoulder_flex=60),), mirror_of="yy~_1")
    paths = (path, image, other, arms, oneway, loop)
    return KeyGraph(states, tuple(dataclasses.replace(p, **changes.get(p.label, {})) for p in paths))


def quaternions(performance):
    """The poses as the library reads them."""
    return kx.poses(performance.motion).quaternions


def test_a_path_backwards_is_the_path_played_backwards():
    """Taking a path forwards and back is a palindrome to rounding, and the truth says so."""
    performance = traverse(small_graph(), ["ya_1", "<ya_1"], fps=50.5)
    q = quaternions(performance)
    assert performance.truth.class_ is C.PALINDROMIC
    assert naive.perpendicular(q[1:], len(q) - 2, mirror=False) < 1e-9
    assert performance.truth.notation == "ya_1 <ya_1"
    assert performance.truth.reversals == (51,)  # halfway between frames 50 and 51


def test_a_mirrored_path_is_the_mirror_image():
    """The image of a path passes the mirrored poses at the same pace."""
    graph = small_graph()
    here, there = (quaternions(traverse(graph, [label], fps=60.0)) for label in ("ya_1", "(ya_1)*"))
    assert max(naive.distance(a, naive.mirrored(b)) for a, b in zip(here, there, strict=True)) < 1e-12


def test_parallel_paths_differ_on_the_way():
    """Two paths with the same ends share the ends and not the middle."""
    graph = small_graph()
    u = np.linspace(0.0, 1.0, 11)
    one, two = graph.along("ya_1", u), graph.along("ya_2", u)
    np.testing.assert_allclose(one[[0, -1]], two[[0, -1]], atol=1e-12)
    assert np.abs(one[5] - two[5]).max() > 0.5


def test_holds_strikes_and_turns_are_in_the_truth():
    """A hold is a stay, a strike is named at its impact, and a turn changes the heading alone."""
    steps = [Step("ya_1", hold=0.5, turn_degrees=90.0), Step("ax_1", strike=True), Step("yx~_1", reversed=True)]
    performance = traverse(small_graph(), steps, fps=100.0, first_hold=0.3)
    truth = performance.truth
    assert [(r.start, r.end) for r in truth.stillness] == [(0, 30), (130, 180)]
    assert truth.strikes == (230,)
    assert kx.poses(performance.motion).yaw[150] == pytest.approx(np.pi / 2)
    assert len(truth.state("A").stays) == 1
    assert truth.notation == "ya_1 ax_1 <yx~_1"


def test_seconds_stretch_the_whole():
    """Given a length, everything takes proportionally longer."""
    plain = traverse(small_graph(), ["ya_1", "ax_1"], fps=100.0)
    long = traverse(small_graph(), ["ya_1", "ax_1"], fps=50.0, seconds=2 * plain.motion.duration)
    np.testing.assert_allclose(long.motion.rotations, plain.motion.rotations, atol=1e-12)


def test_states_with_a_velocity_are_passed_without_a_stop():
    """Through such a state the speed stays up; at others the body comes to rest."""
    velocity = (UP - STANDING) * 1.2
    middle = 0.5 * (UP + STANDING)
    states = (KeyState("Y~", STANDING, "Y~"), KeyState("Z~", middle, "Z~", velocity), KeyState("X~", UP, "X~"))
    paths = (
        KeyPath("yz~_1", "Y~", "Z~", 1.0, reversible=True),
        KeyPath("zx~_1", "Z~", "X~", 1.0, reversible=True),
    )
    moving = KeyGraph(states, paths)
    resting = KeyGraph((states[0], dataclasses.replace(states[1], velocity=None), states[2]), paths)
    slowest = []
    for graph in (moving, resting):
        performance = traverse(graph, ["yz~_1", "zx~_1"], fps=100.0)
        q = quaternions(performance)
        at = performance.truth.path("zx~_1").occurrences[0].start
        speed = [naive.distance(q[k], q[k + 1]) ** 0.5 for k in range(len(q) - 1)]
        slowest.append(min(speed[at - 3 : at + 3]) / max(speed))
    assert slowest[0] > 0.5
    assert slowest[1] < 0.05


@pytest.mark.parametrize(
    ("steps", "message"),
    [
        (["ax_1", "ya_1"], "step 1: 'ya_1' starts at 'Y~', but the step before ends at 'X~'"),
        (["ya_1", "<ya_2"], "step 1: path 'ya_2' is not reversible"),
        (["nowhere"], "No path is labelled 'nowhere'. Paths: ya_1"),
        ([Step("ya_1", hold=-1.0)], "step 0: hold of -1.0 s"),
        ([], "at least one step"),
        ([3], "Expected a step as a label"),
    ],
)
def test_impossible_steps_are_refused(steps, message):
    """Steps that do not join, or go up a one-way path, are named before anything is performed."""
    with pytest.raises(InputError, match=message):
        traverse(small_graph(), steps)


def test_impossible_graphs_are_refused_with_every_fault():
    """Unknown ends, wrong images and impossible times are listed together."""
    with pytest.raises(InputError) as caught:
        small_graph(ya_2={"to": "Q"}, ax_1={"seconds": -1.0}, **{"(ya_1)*": {"via": (VIA,)}})
    message = str(caught.value)
    for fault in ("'ya_2' ends at unknown state 'Q'", "'ax_1' takes -1.0 s", "'ya_1' is not the mirror image"):
        assert fault in message
    with pytest.raises(InputError, match="not the mirror image of 'B'"):
        KeyGraph((KeyState("A", LEFT, "B"), KeyState("B", LEFT, "A")), (KeyPath("ab_1", "A", "B", 1.0),))
    with pytest.raises(InputError, match="posture of state 'A' to be"):
        KeyState("A", np.zeros(3))


def token(label, reversed_=False, image=None, both=False):
    """A letter of one second."""
    return Token(label, reversed_, image, both, 1.0)


@pytest.mark.parametrize(
    ("word", "expected"),
    [
        ([token("a")], C.ASYMMETRIC),
        ([token("a", image="a")], C.SYMMETRIC),
        ([token("a"), token("a", True)], C.PALINDROMIC),
        ([token("a", image="b"), token("b", True, image="a")], C.ANTIPALINDROMIC),
        ([token("a", image="a"), token("a", True, image="a")], C.SYMMETRIC_PALINDROMIC),
        ([token("a")] * 2, C.CYCLIC_ASYMMETRIC),
        ([token("a", image="a")] * 3, C.CYCLIC_SYMMETRIC),
        ([token("a", image="b"), token("b", image="a")] * 2, C.CYCLIC_ANTIPHASE),
        ([token("a"), token("a", True)] * 2, C.CYCLIC_PALINDROMIC),
        ([token("a", image="b"), token("b", True, image="a")] * 2, C.CYCLIC_ANTIPALINDROMIC),
        (
            [token("a", image="b"), token("b", True, "a"), token("b", image="a"), token("a", True, "b")] * 2,
            C.CYCLIC_ANTIPHASE_PALINDROMIC,
        ),
        ([token("a", image="a"), token("a", True, image="a")] * 2, C.CYCLIC_SYMMETRIC_PALINDROMIC),
        ([token("a"), token("b"), token("a")], C.ASYMMETRIC),
        ([token("x", both=True), token("a"), token("a", True), token("x", both=True)], C.PALINDROMIC),
    ],
)
def test_words_have_the_class_of_their_letters(word, expected):
    """Mirror, reversal and period of a word of steps give each of the cyclic and single classes."""
    assert class_of(word).class_ is expected
