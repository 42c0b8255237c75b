"""The folder and the page: complete, safe, the same every time, and back again."""

from __future__ import annotations

import csv
import html.parser
import io
import json
import os
import re
import xml.etree.ElementTree as ET
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest

import bodies
import kinesics as kx
from kinesics import report
from kinesics.analysis import facts
from kinesics.errors import Cancelled, InputError
from kinesics.grammar.graph import MotionGraph, Occurrence, State, Stay
from kinesics.grammar.graph import Path as GraphPath
from kinesics.grammar.graph import Source as GraphSource
from kinesics.plotting.motif_rows import ranked_stretches
from kinesics.report import folder as folder_module
from kinesics.report import markup, pictures
from kinesics.report import page as page_module

PROMISED = {
    "analysis.json",
    "report.html",
    "zz.png",
    "zz-triangle.png",
    "graph.svg",
    "graph.graphml",
    "phrases.csv",
    "motifs.csv",
    "cycles.csv",
}


def _walk(**names: str) -> kx.Analysis:
    return kx.analyze(bodies.legs_striding(90, **names))


def _check(values: dict[str, Any]) -> None:
    jsonschema.Draft202012Validator(report.schema()).validate(values)


def _bytes(folder: Path) -> dict[str, bytes]:
    return {p.name: p.read_bytes() for p in folder.iterdir()}


@pytest.fixture(scope="module")
def saved(tmp_path_factory: pytest.TempPathFactory) -> tuple[kx.Analysis, Path]:
    """An analysis and the folder it was saved in."""
    analysis = _walk(file_name="walk.bvh", sha256="ab" * 32)
    target = tmp_path_factory.mktemp("saved") / "deep" / "walk-kinesics"
    kx.save(analysis, target)
    return analysis, target


def test_every_promised_file_is_there(saved: tuple[kx.Analysis, Path]) -> None:
    """Those of the contract, and no stage is left beside the folder."""
    _, target = saved
    assert set(os.listdir(target)) >= PROMISED
    assert set(os.listdir(target)) == set(report.FILES)
    assert os.listdir(target.parent) == [target.name]


def test_facts_satisfy_the_schema(saved: tuple[kx.Analysis, Path]) -> None:
    """What lies in the folder is valid, and the schema itself is."""
    jsonschema.Draft202012Validator.check_schema(report.schema())
    _check(json.loads((saved[1] / "analysis.json").read_text(encoding="utf-8")))


def test_the_schema_refuses_what_is_missing_or_wrong(saved: tuple[kx.Analysis, Path]) -> None:
    """Each top key is required; a folder in a name, a class that does not exist and a negative frame are no facts."""
    good = saved[0].to_dict()
    for key in good:
        with pytest.raises(jsonschema.ValidationError):
            _check({k: v for k, v in good.items() if k != key})
    for change in (
        {"sources": [{**good["sources"][0], "name": "/home/ann/walk.bvh"}]},
        {"overall": {**good["overall"], "class": "walking"}},
        {"stillness": [{"source": 0, "start": -1, "end": 3}]},
        {"beta": 0},
    ):
        with pytest.raises(jsonschema.ValidationError):
            _check({**good, **change})


def _full() -> facts.Facts:
    """Every kind of fact once, as the grammar will fill them."""
    residuals = facts.Residuals(0.02, 1.1, 0.09, 0.2, 0.2)
    judged: dict[str, Any] = {
        "class_": "cyclic-antiphase",
        "group": "p11g",
        "period_s": 1.1,
        "confidence": 0.9,
        "runner_up": "cyclic-asymmetric",
        "residuals": residuals,
    }
    return facts.Facts(
        schema_version=1,
        kinesics_version="0",
        parameters={},
        beta=20.0,
        sources=(facts.Source("a.bvh", "", "bvh", "left-right", 30.0, 90, 3.0, 17),),
        overall=facts.Overall(**judged),
        phrases=(facts.Phrase(0, 0, 90, 0.0, 3.0, **judged, speed_mean=0.4, smoothness=-2.0),),
        motifs=(facts.Motif(0, "mirror", 0.9, (facts.MotifMember(0, 0, 9, False, True, ((0, 0), (1, 2))),)),),
        state_repetitions=(facts.StateRepetition(0, (3, 40), True),),
        stillness=(facts.Range(0, 1, 2),),
        symmetric_states=(facts.Range(0, 1, 2),),
        reversals=(facts.Reversal(0, 5),),
        strikes=(facts.Strike(0, 5, 0.2, 4.0),),
        cycles=(facts.Cycle(0, 0, 33, 1.1, 0.5, 0.1),),
        gaps=(facts.Gap(0, 4, 6, "markers lost"),),
        speed=facts.Speed(0.1, 0.1, 0.2, 0, 3, 0.1),
        graph=MotionGraph(
            (State(0, "A", mirror_of=1, stays=(Stay(0, 0, 3),)), State(1, "A*", mirror_of=0)),
            (GraphPath(0, "aa*_1", 0, 1, 1, occurrences=(Occurrence(0, 3, 90),)),),
            (GraphSource("a.bvh", 90, 30.0),),
        ),
        warnings=("none",),
    )


def test_a_full_analysis_satisfies_the_schema_and_comes_back() -> None:
    """The schema knows every field of every fact, and decoding them gives them back."""
    from kinesics.analysis.serial import decode, encode

    full = _full()
    values = encode(full)
    _check(values)
    assert decode(facts.Facts, json.loads(json.dumps(values))) == full
    names = {f.name.rstrip("_") for f in fields(facts.Facts)}
    assert names == set(report.schema()["required"]) == set(report.schema()["properties"])


def test_load_gives_back_what_was_saved(saved: tuple[kx.Analysis, Path]) -> None:
    """Equal facts, and the curves to the last bit."""
    analysis, target = saved
    back = kx.load(target)
    assert back == analysis
    for a, b in zip(analysis.speed_curves, back.speed_curves, strict=True):
        np.testing.assert_array_equal(a, b)
    for a, b in zip(analysis.mirror_distance_curves, back.mirror_distance_curves, strict=True):
        np.testing.assert_array_equal(a, b)


def test_an_analysis_without_its_recording_cannot_be_drawn(saved: tuple[kx.Analysis, Path], tmp_path: Path) -> None:
    """What was read back has no poses: saving it says so and writes nothing."""
    with pytest.raises(InputError, match="analyse the recording again"):
        kx.save(kx.load(saved[1]), tmp_path / "again")
    assert list(tmp_path.iterdir()) == []


def test_the_same_bytes_on_every_run(saved: tuple[kx.Analysis, Path], tmp_path: Path) -> None:
    """No file knows when, where or by whom it was made."""
    kx.save(_walk(file_name="walk.bvh", sha256="ab" * 32), tmp_path / "elsewhere")
    assert _bytes(tmp_path / "elsewhere") == _bytes(saved[1])
    for name, contents in _bytes(tmp_path / "elsewhere").items():
        assert str(tmp_path).encode() not in contents, name


class _Reader(html.parser.HTMLParser):
    """Tags, attributes and text of a page."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.attributes: list[tuple[str, str, str]] = []
        self.text = ""

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.attributes.extend((tag, k, v or "") for k, v in attrs)
        if tag not in {"meta", "img", "br"}:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.attributes.extend((tag, k, v or "") for k, v in attrs)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.text += data


def _page(target: Path) -> _Reader:
    reader = _Reader()
    reader.feed((target / "report.html").read_text(encoding="utf-8"))
    reader.close()
    assert reader.open == []
    return reader


def test_the_page_is_complete_in_itself(saved: tuple[kx.Analysis, Path]) -> None:
    """Nothing is fetched: pictures are data, there is no script, no link, and a policy that forbids the rest."""
    page = _page(saved[1])
    sources = [v for _, k, v in page.attributes if k in {"src", "href", "xlink:href", "action", "data"}]
    assert len([s for s in sources if s.startswith("data:image/png;base64,")]) == 2
    assert all(s.startswith(("data:image/png;base64,", "#")) for s in sources)
    assert "script" not in {tag for tag, _, _ in page.attributes}
    assert any("default-src 'none'" in v for _, _, v in page.attributes)
    assert "walk.bvh" in page.text
    assert "the mirrored pose (Z*)" in page.text
    assert "β" in page.text


def test_ids_of_the_drawings_do_not_collide(saved: tuple[kx.Analysis, Path]) -> None:
    """Each drawing's ids are its own, and every reference meets one."""
    text = (saved[1] / "report.html").read_text(encoding="utf-8")
    ids = re.findall(r'\bid="([^"]+)"', text)
    assert len(ids) == len(set(ids))
    references = set(re.findall(r'href="#([^"]+)"|url\(#([^)]+)\)', text))
    assert references
    assert {a or b for a, b in references} <= set(ids)


HOSTILE = '<script>alert("x")</script>&"\'$x_1$.bvh'


def test_hostile_names_are_text_and_nothing_else(tmp_path: Path) -> None:
    """A file may be called anything: markup in its name, its assumptions and its warnings is shown, not obeyed."""
    motion = bodies.arms_swinging(20, file_name=HOSTILE).replace(
        assumptions=("<img src=x onerror=alert(1)>",), warnings=("</title><b>bold</b>",)
    )
    analysis = kx.analyze(motion)
    kx.save(analysis, tmp_path / "out")
    page = _page(tmp_path / "out")
    tags = {tag for tag, _, _ in page.attributes}
    assert not tags & {"script", "b"}
    assert not any(k.startswith("on") for _, k, _ in page.attributes)
    shown = HOSTILE.rsplit("/", 1)[-1]
    assert shown in page.text
    assert "</title><b>bold</b>" in page.text
    _check(json.loads((tmp_path / "out" / "analysis.json").read_text(encoding="utf-8")))


@pytest.mark.parametrize("frames", [1, 2])
def test_very_short_recordings_are_reported(frames: int, tmp_path: Path) -> None:
    """One frame makes a whole folder too."""
    analysis = kx.analyze(bodies.arms_swinging(frames))
    kx.save(analysis, tmp_path / "out")
    assert kx.load(tmp_path / "out") == analysis
    _check(analysis.to_dict())


def test_several_sources_share_one_folder(tmp_path: Path) -> None:
    """Of different frame rates: one pair of matrices, a pair of curves for each."""
    a, b = bodies.arms_swinging(60, fps=60.0, file_name="a.bvh"), bodies.legs_striding(50, fps=25.0, file_name="b.bvh")
    analysis = kx.analyze([a, b])
    kx.save(analysis, tmp_path / "out")
    assert kx.load(tmp_path / "out") == analysis
    assert _page(tmp_path / "out").text.count("a.bvh") >= 2


def test_the_page_says_which_recording_is_which(tmp_path: Path) -> None:
    """Two of one name: numbered, each with its stretch of the common time; kinds are counted through both."""
    walk = bodies.legs_striding(90, file_name="walk.bvh")
    kx.save(kx.analyze([walk, walk]), tmp_path / "two")
    text = _page(tmp_path / "two").text
    one, two = f"{walk.duration:.2f}", f"{2 * walk.duration:.2f}"
    assert f"walk.bvh (1) from 0.00 to {one} s, walk.bvh (2) from {one} to {two} s" in text
    assert "Phrases of one kind have one number and one colour, in whichever recording they are." in text


def test_every_path_has_a_strip_and_twins_share_one() -> None:
    """Of two mirror images the one that is done more often stands for both; beyond the most, the frequent ones are kept."""
    chain = [Occurrence(0, k, k + 1) for k in range(6)]
    states = tuple(State(k, label, mirror_of=1 - k) for k, label in enumerate(("A", "A*")))
    paths = (
        GraphPath(0, "aa_1", 0, 0, 1, mirror_of=1, occurrences=(chain[0],)),
        GraphPath(1, "(aa_1)*", 1, 1, 1, mirror_of=0, occurrences=tuple(chain[2:6])),
        GraphPath(2, "aa*_1", 0, 1, 1, occurrences=(chain[1],)),
    )
    graph = MotionGraph(states, paths, (GraphSource("a", 6, 30.0),))
    assert pictures.strip_paths(graph) == ([1, 2], 0)
    many = MotionGraph(
        (State(0, "A"),),
        tuple(
            GraphPath(k, f"aa_{k + 1}", 0, 0, k + 1, occurrences=(Occurrence(0, k, k + 1),))
            for k in range(pictures.MOST_STRIPS + 5)
        ),
        (GraphSource("a", pictures.MOST_STRIPS + 5, 30.0),),
    )
    shown, left_out = pictures.strip_paths(many)
    assert (len(shown), left_out) == (pictures.MOST_STRIPS, 5)


def test_tables_have_headers(saved: tuple[kx.Analysis, Path]) -> None:
    """Also where there is nothing to list."""
    for name in ("phrases.csv", "motifs.csv", "cycles.csv", "frames.csv"):
        header = (saved[1] / name).read_text(encoding="utf-8").splitlines()[0].split(",")
        assert {"start", "frame"} & set(header)
    full = kx.Analysis(**{f.name: getattr(_full(), f.name) for f in fields(facts.Facts)})
    assert len(report.tables.phrases(full).splitlines()) == 2
    assert report.tables.motifs(full).splitlines()[1] == "1,0,mirror,0.9,0,a.bvh,0,9,0.0,0.3,0,1"
    assert report.tables.cycles(full).splitlines()[1] == "1,0,a.bvh,0,33,0.0,1.1,1.1,0.5,0.1"
    explained = (saved[1] / "tables.txt").read_text(encoding="utf-8")
    for column in ("phrase", "kind", "stretch", "source", "motif", "phase"):
        assert re.search(rf"^ *{column}\b", explained, re.MULTILINE)


def _rows(text: str) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(text)))


def _cells(target: Path, title: str, which: int = 0) -> list[list[str]]:
    """The rows of a table of the page, by the title above it."""
    text = (target / "report.html").read_text(encoding="utf-8")
    table = text[text.index(f">{title}<") :].split("<table")[1 + which].split("</table>")[0]
    return [re.findall(r"<t[dh][^>]*>(.*?)</t[dh]>", row) for row in table.split("<tr>")[1:]]


def test_a_number_of_a_phrase_finds_it_everywhere(tmp_path: Path) -> None:
    """The page's tables and bars, and the CSV: one number a phrase through both recordings; whose a cycle is stands beside it."""
    jacks = kx.performer.jumping_jacks(seconds=5, fps=30, seed=0).motion.replace(name="jacks")
    limp = kx.performer.limp(seconds=7, fps=30, degree=1.0, seed=0).motion.replace(name="limp")
    analysis = kx.analyze([jacks, limp])
    kx.save(analysis, tmp_path / "two")
    phrases, cycles, motifs = (
        _rows((tmp_path / "two" / f"{n}.csv").read_text()) for n in ("phrases", "cycles", "motifs")
    )
    assert [r["phrase"] for r in phrases] == [str(k + 1) for k in range(len(phrases))]
    assert [int(r["kind"]) for r in phrases] == [1 + (p.kind or 0) for p in analysis.phrases]
    of = {r["phrase"]: r for r in phrases}
    assert {r["recording"] for r in cycles} == {"jacks", "limp"}
    for cycle in cycles:
        phrase = of[cycle["phrase"]]
        assert (cycle["source"], cycle["recording"]) == (phrase["source"], phrase["recording"])
        assert float(phrase["start_s"]) <= float(cycle["start_s"]) < float(cycle["end_s"]) <= float(phrase["end_s"])
        assert float(cycle["end_s"]) == int(cycle["end"]) / 30.0
    # the page
    header, *shown = _cells(tmp_path / "two", "Phrases")
    assert header[:2] == ["phrase", "source"]
    assert [(r[0], r[1], r[header.index("kind")].rstrip("*")) for r in shown] == [
        (r["phrase"], r["recording"], r["kind"]) for r in phrases
    ]
    header, *summed = _cells(tmp_path / "two", "Cycles")
    assert [(r[0], r[1], r[header.index("cycles")]) for r in summed] == [
        (p, of[p]["recording"], str(sum(c["phrase"] == p for c in cycles)))
        for p in dict.fromkeys(c["phrase"] for c in cycles)
    ]
    # a sentence about a recording keeps its name
    assert "<li>limp: " in (tmp_path / "two" / "report.html").read_text(encoding="utf-8")
    _, *single = _cells(tmp_path / "two", "One by one")
    assert [r[:3] for r in single] == [[c["phrase"], c["recording"], f"{float(c['start_s']):.2f}"] for c in cycles]
    bars = [t.get_text() for t in pictures._phrases(analysis, 1).axes[0].texts]
    assert {r["phrase"] for r in phrases if r["recording"] == "limp"} <= set(bars)
    # stretches are numbered as the rows of the picture of what recurs, whatever their motifs' ids
    for number, members in enumerate(ranked_stretches(analysis.motifs), 1):
        own = [r for r in motifs if r["stretch"] == str(number)]
        assert len(own) >= len(members)
        assert (int(own[0]["start"]), int(own[0]["end"])) == (members[0].start, members[0].end)


def test_no_two_kinds_look_the_same() -> None:
    """However many there are; and phrases of one kind do."""
    looks = [pictures.look_of(k) for k in range(2000)]
    assert len({(colour, tuple(sorted(hatch))) for colour, hatch in looks}) == 2000
    assert [hatch for _, hatch in looks[:10]] == [""] * 10


def test_every_kind_is_drawn_as_it_looks(saved: tuple[kx.Analysis, Path]) -> None:
    """Twelve kinds in one recording: the eleventh has the colour of the first, and strokes."""
    analysis, _ = saved
    phrases = tuple(
        facts.Phrase(0, 7 * k, 7 * k + 7, 7 * k / 30, (7 * k + 7) / 30, class_="asymmetric", kind=k) for k in range(12)
    )
    bars = pictures._phrases(replace(analysis, phrases=phrases, cycles=()), 0).axes[0].patches
    assert len({(p.get_facecolor(), p.get_hatch()) for p in bars}) == 12
    assert bars[0].get_facecolor() == bars[10].get_facecolor()


def test_a_wide_graph_fits_the_page_and_can_be_enlarged() -> None:
    """As wide as the page at first; without scripts a tick makes it as large as it was drawn."""
    svg = b'<svg width="1400pt" height="300pt" viewBox="0 0 1400 300"><g id="a"/></svg>'
    wide = markup.drawing(svg, "graph", "A graph.", kind="natural")
    assert '<div class="scaled"' in wide
    assert 'type="checkbox" id="graph-zoom"' in wide
    assert "--full: 1400pt" in wide
    assert re.search(r'<svg[^>]*width="', wide) is None
    style = Path(page_module.__file__).with_name("page.css").read_text(encoding="utf-8")
    assert "input.zoom:checked ~ div.scaled svg { width: var(--full); }" in style
    assert "figure svg { display: block; width: 100%" in style
    assert "zoom" not in markup.drawing(svg.replace(b"1400", b"300"), "graph", "A graph.", kind="natural")


def test_graphs_are_well_formed(saved: tuple[kx.Analysis, Path]) -> None:
    """GraphML that networkx reads back, also of a graph without states; SVG that is XML."""
    import networkx as nx

    assert set(nx.read_graphml(saved[1] / "graph.graphml", force_multigraph=True).nodes) == {"A", "A*"}
    assert len(nx.read_graphml(io.BytesIO(MotionGraph().to_graphml().encode()))) == 0
    full = nx.read_graphml(io.BytesIO(_full().graph.to_graphml().encode()), force_multigraph=True)
    assert list(full.nodes) == ["A", "A*"]
    assert [d["label"] for *_, d in full.edges(data=True)] == ["aa*_1"]
    assert ET.parse(saved[1] / "graph.svg").getroot().tag.endswith("svg")


def test_the_same_recording_is_replaced_and_other_files_stay(tmp_path: Path) -> None:
    """An analysis of the same file gives way; the user's notes beside it do not."""
    target = tmp_path / "out"
    kx.save(_walk(file_name="walk.bvh"), target)
    (target / "notes.txt").write_text("mine")
    (target / "zz.png").write_bytes(b"old")
    kx.save(_walk(file_name="walk.bvh"), target)
    assert (target / "notes.txt").read_text() == "mine"
    assert (target / "zz.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize("held", ["another file", "the same name, other bytes", "no analysis", "a broken one"])
def test_other_contents_are_not_replaced_unless_asked(held: str, tmp_path: Path) -> None:
    """Exit code 2 territory: the message names --overwrite, nothing is touched; with it the folder is taken."""
    target = tmp_path / "out"
    if held == "another file":
        kx.save(_walk(file_name="run.bvh"), target)
    elif held == "the same name, other bytes":
        kx.save(_walk(file_name="walk.bvh", sha256="cd" * 32), target)
    else:
        target.mkdir()
        (target / ("thesis.tex" if held == "no analysis" else "analysis.json")).write_text("{")
    before = _bytes(target)
    analysis = _walk(file_name="walk.bvh", sha256="ab" * 32)
    with pytest.raises(InputError, match="--overwrite"):
        kx.save(analysis, target)
    assert _bytes(target) == before
    kx.save(analysis, target, overwrite=True)
    assert kx.load(target) == analysis


def test_an_empty_folder_is_filled_and_a_file_is_refused(tmp_path: Path) -> None:
    """The folder of `mkdir out` is welcome; a file in its place is not."""
    (tmp_path / "out").mkdir()
    kx.save(_walk(), tmp_path / "out")
    assert (tmp_path / "out" / "analysis.json").exists()
    (tmp_path / "file").write_text("x")
    with pytest.raises(InputError, match="is a file"):
        kx.save(_walk(), tmp_path / "file")


@pytest.mark.parametrize("stop", [KeyboardInterrupt, Cancelled, MemoryError])
@pytest.mark.parametrize("moment", [0.0, 0.3, 0.6, 0.8, 0.99])
def test_stopping_leaves_what_was_there(stop: type[BaseException], moment: float, tmp_path: Path) -> None:
    """At whatever moment the work is stopped, the old folder is as it was and nothing new lies about."""
    target = tmp_path / "out"
    target.mkdir()
    (target / "analysis.json").write_text("an older one")

    def interrupt(fraction: float, message: str = "") -> None:
        if fraction >= moment:
            raise stop

    with pytest.raises(stop):
        kx.save(kx.analyze(bodies.arms_swinging(2)), target, overwrite=True, progress=interrupt)
    assert _bytes(target) == {"analysis.json": b"an older one"}
    assert os.listdir(tmp_path) == ["out"]


def test_saving_reports_how_far_it_is(tmp_path: Path) -> None:
    """Fractions never fall and end at 1."""
    seen: list[float] = []
    kx.save(kx.analyze(bodies.arms_swinging(2)), tmp_path / "out", progress=lambda f, message="": seen.append(f))
    assert seen == sorted(seen)
    assert seen[-1] == 1.0


def test_ctrl_c_between_two_renames_finishes_them(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Old and new files never stand side by side: the last step is finished, then the interrupt goes on."""
    target = tmp_path / "out"
    kx.save(_walk(file_name="walk.bvh"), target)
    changed = kx.analyze(bodies.legs_striding(70, file_name="walk.bvh"))
    rename, count = Path.replace, 0

    def interrupted(self: Path, to: Path) -> Path:
        nonlocal count
        count += 1
        if count == 3:
            raise KeyboardInterrupt
        return rename(self, to)

    monkeypatch.setattr(folder_module.Path, "replace", interrupted)
    with pytest.raises(KeyboardInterrupt):
        kx.save(changed, target)
    monkeypatch.undo()
    assert kx.load(target) == changed
    assert os.listdir(tmp_path) == ["out"]


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="the superuser may write everywhere")
def test_a_folder_that_cannot_be_written_is_one_sentence(tmp_path: Path) -> None:
    """No traceback for a read-only place."""
    tmp_path.chmod(0o500)
    try:
        with pytest.raises(InputError, match="cannot be written"):
            kx.save(_walk(), tmp_path / "out")
    finally:
        tmp_path.chmod(0o700)


@pytest.mark.parametrize("place", ["file/sub", "file/sub/deeper", "file", "x" * 300, "/proc/nope"])
def test_a_place_that_can_be_no_folder_is_one_sentence(place: str, tmp_path: Path) -> None:
    """The place is named as the user gave it, no other name is, and nothing is left behind."""
    if place.startswith("/proc") and not Path("/proc/self").exists():
        pytest.skip("This system has no /proc.")
    (tmp_path / "file").write_text("")
    target = tmp_path / place
    with pytest.raises(InputError) as refused:
        kx.save(_walk(), target)
    assert str(target) in str(refused.value)
    assert ".nope-" not in str(refused.value)
    assert os.listdir(tmp_path) == ["file"]


@pytest.mark.parametrize(
    ("contents", "message"),
    [
        (None, "not there"),
        (b"{", "not JSON"),
        (b"[]", "JSON object"),
        (b"\xff\xfe", "UTF-8"),
        (b"{}", "schema_version"),
    ],
)
def test_a_folder_that_holds_no_analysis_is_one_sentence(contents: bytes | None, message: str, tmp_path: Path) -> None:
    """What is wrong with the file, and which file it is."""
    if contents is not None:
        (tmp_path / "analysis.json").write_bytes(contents)
    with pytest.raises(InputError, match=message):
        kx.load(tmp_path)


def test_a_damaged_table_of_curves_is_one_sentence(saved: tuple[kx.Analysis, Path], tmp_path: Path) -> None:
    """Without the table the facts are read all the same."""
    facts_text = (saved[1] / "analysis.json").read_bytes()
    (tmp_path / "analysis.json").write_bytes(facts_text)
    assert kx.load(tmp_path) == saved[0]
    for text in (
        "frame\n1\n",
        "source,frame,time_s,speed,mirror_distance\n0,0,0,x,0\n",
        "source,frame,time_s,speed,mirror_distance\n0\n",
    ):
        (tmp_path / "frames.csv").write_text(text)
        with pytest.raises(InputError, match=r"frames\.csv"):
            kx.load(tmp_path)
