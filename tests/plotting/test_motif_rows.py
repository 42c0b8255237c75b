"""What recurs, as rows of figures and bars."""

from __future__ import annotations

import pytest

import bodies
from kinesics.analysis.facts import Motif, MotifMember
from kinesics.errors import InputError
from kinesics.plotting import motif_plot
from kinesics.plotting.motif_rows import ranked_stretches

FIRST = MotifMember(0, 0, 30, False, False)
SHORT = MotifMember(0, 40, 45, False, False)
MOTIFS = (
    Motif(0, "same", 0.9, (SHORT, MotifMember(0, 60, 65, False, False))),
    Motif(1, "same", 0.9, (FIRST, MotifMember(0, 60, 90, False, False))),
    Motif(2, "mirror_reverse", 0.8, (FIRST, MotifMember(1, 0, 30, True, True))),
)


def test_one_stretch_under_several_relations_is_one_row() -> None:
    """Its first occurrence comes once; what recurs longest comes first."""
    rows = ranked_stretches(MOTIFS)
    assert [len(r) for r in rows] == [3, 2]
    assert [r[0] for r in rows] == [FIRST, SHORT]


def test_a_bar_for_every_occurrence() -> None:
    """Mirrored ones in the colour of Z*, those done backwards with an arrow to the left."""
    motions = [bodies.legs_striding(90), bodies.legs_striding(60)]
    ax = motif_plot(MOTIFS, motions)
    bars = [p for p in ax.patches if p.get_path().vertices.shape[0] == 5]
    assert len(bars) == 5
    red = [b for b in bars if b.get_facecolor()[0] > b.get_facecolor()[2]]
    assert len(red) == 4
    texts = [t.get_text() for t in ax.texts]
    assert texts.count("←") == 1


def test_nothing_recurs() -> None:
    """It says so."""
    assert motif_plot((), [bodies.legs_striding(10)]).texts[0].get_text() == "nothing recurs"


def test_rows_are_limited_and_motions_needed() -> None:
    """Bad arguments are named."""
    motions = [bodies.legs_striding(90), bodies.legs_striding(60)]
    assert motif_plot(MOTIFS, motions).get_ylim()[0] == pytest.approx(-2.3)
    assert motif_plot(MOTIFS, motions, most=1).get_ylim()[0] == pytest.approx(-1.3)
    with pytest.raises(InputError, match="at least one row"):
        motif_plot(MOTIFS, motions, most=0)
    with pytest.raises(InputError, match="more than the 1 motions"):
        motif_plot(MOTIFS, motions[:1])
