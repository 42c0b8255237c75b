"""Loops that are played round and round, and what comes far more often than the rest."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from floor_networks import FPS, Path, floor_network
from kinesics.synthesis.control.courses import Course
from kinesics.synthesis.paths.network import Network
from kinesics.synthesis.rounds import longest_loop, played_most

SHORT, OTHER, LONG = range(3)


@pytest.fixture(scope="module")
def net() -> Network:
    return floor_network([Path("short", 6, 0.0, 0.0), Path("other", 8, 0.0, 0.0), Path("long", 50, 0.0, 0.0)])


def played(net: Network, paths: Sequence[int]) -> Course:
    """The course of these paths one after the other."""
    chosen = np.asarray(paths)
    moments = np.concatenate([net.first[p] + np.arange(net.length[p]) for p in chosen])
    nothing = np.zeros(len(moments))
    return Course(
        paths=chosen,
        bends=np.zeros(len(chosen)),
        begins=np.cumsum(net.length[chosen]) - net.length[chosen],
        moments=moments,
        ground=np.stack([nothing, nothing], axis=1),
        yaw=nothing,
        fps=FPS,
        attained=False,
        outcome=(),
    )


def test_a_loop_is_found_with_its_frames_period_and_rounds(net: Network) -> None:
    """Of two that are left and come back to the one in which most time is spent."""
    course = played(net, [LONG, *[SHORT] * 5, LONG, *[OTHER] * 6, LONG, *[SHORT] * 9, LONG])
    loop = longest_loop(course, net)
    assert loop is not None
    assert (loop.recording, loop.first, loop.end) == (SHORT, 0, 6)
    assert loop.period == pytest.approx(6 / FPS)
    assert loop.rounds == 14


@pytest.mark.parametrize(
    "paths", [[LONG] * 5, [LONG, SHORT, SHORT, SHORT, LONG, OTHER, SHORT], [SHORT, OTHER, LONG] * 4, [SHORT]]
)
def test_what_is_repeated_slowly_or_a_few_times_is_no_loop(net: Network, paths: list[int]) -> None:
    """More than a second apart, or not four times on end."""
    assert longest_loop(played(net, paths), net) is None


def test_what_is_played_far_more_often_than_the_rest_is_told(net: Network) -> None:
    """With the number of its plays; not where all comes about as often, nor where hardly anything was played."""
    often = played_most(played(net, [LONG, *[SHORT] * 9, OTHER, LONG]), net)
    assert often is not None
    assert (often.recording, often.first, often.end, often.times) == (SHORT, 0, 6, 9)
    assert played_most(played(net, [SHORT, OTHER, LONG] * 9), net) is None
    assert played_most(played(net, [SHORT] * 4), net) is None
