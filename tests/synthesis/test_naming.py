"""Words in the names of recordings."""

from __future__ import annotations

import pytest

from kinesics.synthesis.goals.naming import unknown, with_word

NAMES = ("07_01", "91_07", "MaleWalk01", "slow walking", "sidewalk", "dataset-1_walk-left_active_001")


@pytest.mark.parametrize(
    ("word", "meant"),
    [
        ("walk", ["MaleWalk01", "dataset-1_walk-left_active_001", "slow walking"]),
        ("Walk", ["MaleWalk01", "dataset-1_walk-left_active_001", "slow walking"]),
        ("walk left", ["dataset-1_walk-left_active_001"]),
        ("left walk", []),
        ("07", ["07_01", "91_07"]),
        ("07_01", ["07_01"]),
        ("0", []),
        ("00", []),
        ("a", []),
        ("ma", []),
        ("", []),
        ("_", []),
    ],
)
def test_a_word_is_found_where_a_word_begins(word: str, meant: list[str]) -> None:
    """Not within another; too short a word is none, and a number is meant whole."""
    assert with_word(word, NAMES) == meant


def test_a_whole_word_is_asked_for() -> None:
    """Of classes, which are few and known: "cyclic" is in two, "cyc" is a slip."""
    classes = ("cyclic-antiphase", "cyclic-symmetric", "symmetric")
    assert with_word("cyclic", classes, whole=True) == ["cyclic-antiphase", "cyclic-symmetric"]
    assert with_word("cyc", classes, whole=True) == []


@pytest.mark.parametrize("slip", ["wlaking", "slow walkign", "walking fast"])
def test_a_slip_finds_its_name(slip: str) -> None:
    """All of the name, one word of it, or one word right."""
    assert "Did you mean" in unknown("recording", slip, NAMES)
    assert "slow walking" in unknown("recording", slip, NAMES).split("There are")[0]
