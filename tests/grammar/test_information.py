"""Shannon's measure: textbook values, the loops, and standard errors that are what they say."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kinesics.performer as performer
from kinesics.errors import InputError
from kinesics.grammar import information
from kinesics.grammar.graph import MotionGraph, Occurrence, Path, Source, State, Stay, build
from kinesics.grammar.information import Estimate, Information
from motion_graphs import graph_of
from naive import information as naive

LETTERS = st.lists(st.sampled_from("abcdef"), min_size=2, max_size=40)


def _pairs(text: str) -> list[tuple[str, str]]:
    return list(itertools.pairwise(text))


def test_a_long_row_of_fair_coins_has_one_bit() -> None:
    """10,000 heads and 10,000 tails; and eight equally likely words have three."""
    assert information.entropy([10_000, 10_000]) == Estimate(pytest.approx(1.0, abs=1e-4), pytest.approx(0.0, abs=1e-4))
    eight = information.entropy([5000] * 8)
    assert eight is not None
    assert eight.value == pytest.approx(3.0, abs=1e-3)


def test_shannons_example() -> None:
    """Probabilities 1/2, 1/4, 1/8, 1/8 have 7/4 bits (Shannon 1948, section 7)."""
    found = information.entropy([8000, 4000, 2000, 2000])
    assert found is not None
    assert found.value == pytest.approx(1.75, abs=1e-3)


def test_a_markov_source_of_two_states() -> None:
    """Stay with 3/4, change with 1/4, in both states: H = .8113 bits (Cover & Thomas 2006, example 4.2.1 in form)."""
    rng = np.random.default_rng(1)
    steps = np.cumsum(rng.random(20_000) < 0.25) % 2
    found = information.conditional_entropy(_pairs("".join("ab"[k] for k in steps)))
    assert found is not None
    exact = -(0.75 * math.log2(0.75) + 0.25 * math.log2(0.25))
    assert abs(found.value - exact) < 3 * found.standard_error
    assert found.standard_error < 0.01
    zero = information.entropy([int((steps == 0).sum()), int((steps == 1).sum())])
    assert zero is not None
    assert zero.value == pytest.approx(1.0, abs=0.01)


def test_over_and_over_the_same_says_nothing_new() -> None:
    """abcabcabc: log2 3 bits by frequency, none once the word before is known."""
    assert information.conditional_entropy(_pairs("abc" * 30)) == Estimate(0.0, 0.0)
    found = information.entropy([30, 30, 30])
    assert found is not None
    assert found.value == pytest.approx(math.log2(3))


def test_millers_correction_removes_most_of_the_bias() -> None:
    """Mean over many short samples: 20 words of a source of 1.75 bits."""
    rng = np.random.default_rng(2)
    p = np.array([0.5, 0.25, 0.125, 0.125])
    counts = rng.multinomial(20, p, size=2000)
    corrected = np.mean([e.value for c in counts if (e := information.entropy(c.tolist())) is not None])
    plain = np.mean([-sum(q * math.log2(q) for q in c / 20 if q > 0) for c in counts])
    assert plain < 1.75 - 0.08
    assert abs(corrected - 1.75) < 0.03


@pytest.mark.parametrize("order", [0, 1])
def test_standard_errors_are_the_spread_of_repeated_recordings(order: int) -> None:
    """The mean standard error of 300 samples of a Markov source of three words is their standard deviation to 20 %."""
    rng = np.random.default_rng(3)
    table = np.array([[0.6, 0.3, 0.1], [0.2, 0.2, 0.6], [0.3, 0.5, 0.2]])
    values, errors = [], []
    for _ in range(300):
        words = [0]
        for _ in range(250):
            # independent draws for order 0, else the chain
            row = table[words[-1]] if order else np.array([0.6, 0.3, 0.1])
            words.append(int(rng.choice(3, p=row)))
        counts = [words.count(k) for k in range(3)]
        found = information.conditional_entropy(itertools.pairwise(words)) if order else information.entropy(counts)
        assert found is not None
        values.append(found.value)
        errors.append(found.standard_error)
    assert np.mean(errors) == pytest.approx(np.std(values), rel=0.2)


@given(LETTERS)
def test_order_0_is_the_loops(words: list[str]) -> None:
    """Value and standard error."""
    found = information.entropy([words.count(w) for w in sorted(set(words))])
    assert found is not None
    assert found.value == pytest.approx(naive.entropy(words), abs=1e-12)
    assert found.standard_error == pytest.approx(naive.jackknife(naive.entropy, words), abs=1e-9)


@given(LETTERS)
def test_order_1_is_the_loops(words: list[str]) -> None:
    """Value and standard error."""
    pairs = list(itertools.pairwise(words))
    found = information.conditional_entropy(pairs)
    if len(pairs) < 2:
        assert found is None
        return
    assert found is not None
    assert found.value == pytest.approx(naive.conditional_entropy(pairs), abs=1e-12)
    assert found.standard_error == pytest.approx(naive.jackknife(naive.conditional_entropy, pairs), abs=1e-9)


@given(LETTERS)
def test_the_vocabulary_is_the_loops(words: list[str]) -> None:
    """And never less than was seen."""
    found = information.vocabulary_size([words.count(w) for w in sorted(set(words))])
    assert found is not None
    assert found.value == pytest.approx(naive.vocabulary(words))
    assert found.value >= len(set(words))
    assert found.standard_error >= 0.0


def test_the_vocabulary_that_was_not_seen_is_guessed() -> None:
    """40 draws from 30 words show about 22; Chao's lower bound comes nearer, and its error covers the rest."""
    rng = np.random.default_rng(4)
    seen, guessed, inside = [], [], 0
    for _ in range(200):
        counts = np.bincount(rng.integers(30, size=40), minlength=30)
        found = information.vocabulary_size(counts.tolist())
        assert found is not None
        seen.append((counts > 0).sum())
        guessed.append(found.value)
        inside += abs(found.value - 30) < 2 * found.standard_error
    assert np.mean(seen) < 23
    assert abs(np.mean(guessed) - 30) < 2.0
    assert inside > 160


def test_too_little_tells_nothing() -> None:
    """One word has no entropy, none has no vocabulary; nothing is not zero."""
    assert information.entropy([1]) is None
    assert information.entropy([]) is None
    assert information.conditional_entropy([("a", "b")]) is None
    assert information.vocabulary_size([0]) is None
    still = graph_of(performer.stand().truth).information()
    assert still == Information(seconds=still.seconds)


def test_negative_counts_are_refused() -> None:
    """There is no such thing."""
    with pytest.raises(InputError, match="counts of at least 0, got -2"):
        information.entropy([3, -2])


def _recording() -> MotionGraph:
    """X held 1 s; A and back, A* and back, twice the symmetric loop: 12 s at 10 fps."""
    return build(
        [State(0, symmetric=True, stays=(Stay(0, 0, 10),)), State(1, mirror_of=2), State(2, mirror_of=1)],
        [
            Path(0, from_=0, to=1, reversible=True, mirror_of=1,
                 occurrences=(Occurrence(0, 10, 30), Occurrence(0, 30, 50, reversed=True))),
            Path(1, from_=0, to=2, reversible=True, mirror_of=0,
                 occurrences=(Occurrence(0, 50, 65), Occurrence(0, 65, 80, reversed=True))),
            Path(2, from_=0, to=0, symmetric=True, occurrences=(Occurrence(0, 80, 100), Occurrence(0, 100, 120))),
        ],
        [Source("made", 120, 10.0)],
    )  # fmt: skip


def test_the_measures_of_a_recording() -> None:
    """Words, seconds and shares counted by hand: 7 of 11 s of movement reversible and mirrored, 4 symmetric."""
    found = _recording().information()
    assert (found.words, found.seconds, found.vocabulary_seen) == (6, 12.0, 3)
    assert found.symmetric_share is not None
    assert found.symmetric_share.value == pytest.approx(4 / 11)
    assert found.reversible_share is not None
    assert found.reversible_share.value == pytest.approx(7 / 11)
    assert found.mirrored_share is not None
    assert found.mirrored_share.value == pytest.approx(7 / 11)
    times = [(2.0, 0), (2.0, 0), (1.5, 0), (1.5, 0), (2.0, 1), (2.0, 1)]
    share = naive.jackknife(lambda part: sum(t * s for t, s in part) / sum(t for t, _ in part), times)
    assert found.symmetric_share.standard_error == pytest.approx(share)
    assert found.order1_bits is not None
    assert found.bits_per_s is not None
    assert found.bits_per_s.value == pytest.approx(found.order1_bits.value * 6 / 12.0)


def test_a_mirror_image_that_was_never_performed_does_not_count() -> None:
    """Racemising adds to the graph, not to what was said."""
    limp = graph_of(performer.limp(seconds=8).truth)
    assert limp.racemic().information() == limp.information()
    assert limp.information().mirrored_share == Estimate(0.0, 0.0)


def test_mirroring_and_playing_backwards_say_as_much() -> None:
    """Order 0 and the shares are those of the recording itself."""
    graph = graph_of(performer.kata().truth)
    for other in (graph.mirrored(), graph.reversed_in_time()):
        found, known = other.information(), graph.information()
        assert found.order0_bits is not None
        assert known.order0_bits is not None
        assert found.order0_bits.value == pytest.approx(known.order0_bits.value)
        assert found.order0_bits.standard_error == pytest.approx(known.order0_bits.standard_error)
        assert found.reversible_share is not None
        assert known.reversible_share is not None
        assert found.reversible_share.value == pytest.approx(known.reversible_share.value)


def test_estimates_are_compared_by_subtraction() -> None:
    """The difference has the standard error of both."""
    assert Estimate(3.0, 0.3) - Estimate(1.0, 0.4) == Estimate(2.0, 0.5)
