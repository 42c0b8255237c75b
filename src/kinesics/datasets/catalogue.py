"""What can be fetched: collections with their terms, named sets of recordings, and single clips by their number."""

from __future__ import annotations

import difflib
import re
from dataclasses import dataclass
from functools import cache
from importlib import resources

from kinesics.errors import InputError
from kinesics.formats.asf_amc import CMU_60_FPS


@dataclass(frozen=True)
class Collection:
    """A public body of recordings and its owner's terms."""

    name: str
    """Also the folder in which its files are kept."""
    title: str
    home: str
    """The page that describes it."""
    url: str
    """What the paths of its files are added to; ends in a slash."""
    terms: str
    credit: str
    """What its owner asks to be said."""


@dataclass(frozen=True)
class RemoteFile:
    """One file of a collection."""

    collection: str
    path: str
    """Below the collection's address."""
    place: str
    """Below the collection's folder here."""
    is_archive: bool = False
    """A zip that is unpacked beside itself."""

    @property
    def key(self) -> str:
        """Its name in the list of checksums: collection and place."""
        return f"{self.collection}/{self.place}"

    @property
    def sha256(self) -> str | None:
        """Checksum, where this version of kinesics knows it."""
        return _known_checksums().get(self.key)


@dataclass(frozen=True)
class Dataset:
    """One or more recordings that are fetched together."""

    name: str
    title: str
    collection: str
    files: tuple[RemoteFile, ...]
    note: str = ""
    """What to know when reading it."""


COLLECTIONS: dict[str, Collection] = {
    c.name: c
    for c in (
        Collection(
            name="cmu",
            title="Carnegie Mellon University Motion Capture Database (ASF/AMC)",
            home="http://mocap.cs.cmu.edu",
            url="http://mocap.cs.cmu.edu/subjects/",
            terms="Free for research and in commercial products; the data itself may not be resold, even converted.",
            credit=(
                "The data used in this project was obtained from mocap.cs.cmu.edu. "
                "The database was created with funding from NSF EIA-0196217."
            ),
        ),
        Collection(
            name="bandai-namco",
            title="Bandai-Namco-Research-Motiondataset (BVH, 30 fps, three actors in many styles)",
            home="https://github.com/BandaiNamcoResearchInc/Bandai-Namco-Research-Motiondataset",
            url=(
                "https://raw.githubusercontent.com/BandaiNamcoResearchInc/Bandai-Namco-Research-Motiondataset/"
                "3c23012e5022a736046171553a27a592735122c9/dataset/"
            ),
            terms="CC BY-NC 4.0: with credit, not for commercial use. Read the licence at its home.",
            credit="Bandai Namco Research Inc., Bandai-Namco-Research-Motiondataset.",
        ),
        Collection(
            name="lafan1",
            title="Ubisoft La Forge Animation Dataset (BVH, 30 fps, 77 sequences)",
            home="https://github.com/ubisoft/ubisoft-laforge-animation-dataset",
            url="https://github.com/ubisoft/ubisoft-laforge-animation-dataset/raw/master/",
            terms="CC BY-NC-ND 4.0: with credit, not for commercial use, not to be passed on in changed form.",
            credit="Harvey, Yurick, Nowrouzezahrai, Pal: Robust Motion In-betweening (2020); Ubisoft La Forge.",
        ),
    )
}


def _cmu_files(*clips: str) -> tuple[RemoteFile, ...]:
    """The skeletons and motions of clips such as "07_01"."""
    paths: list[str] = []
    for clip in clips:
        subject = clip.split("_")[0]
        paths += [f"{subject}/{subject}.asf", f"{subject}/{clip}.amc"]
    return tuple(RemoteFile("cmu", path, path) for path in dict.fromkeys(paths))


def _cmu_note(*clips: str) -> str:
    slow = sorted({c.split("_")[0] for c in clips if int(c.split("_")[0]) in CMU_60_FPS})
    return (
        f"Subject {', '.join(slow)} was captured at 60 fps, which its files do not say: read it with --fps 60."
        if slow
        else ""
    )


def _cmu(name: str, title: str, *clips: str) -> Dataset:
    return Dataset(name, f"{title} ({', '.join(clips)})", "cmu", _cmu_files(*clips), _cmu_note(*clips))


def _bandai(name: str, title: str, *clips: str) -> Dataset:
    return Dataset(name, title, "bandai-namco", tuple(_bandai_file(clip) for clip in clips))


def _bandai_file(clip: str) -> RemoteFile:
    number = clip.split("_")[0].rsplit("-", 1)[1]
    return RemoteFile("bandai-namco", f"Bandai-Namco-Research-Motiondataset-{number}/data/{clip}.bvh", f"{clip}.bvh")


NAMED_SETS: dict[str, Dataset] = {
    d.name: d
    for d in (
        _cmu("walking", "Walking", "07_01", "91_34"),
        _cmu("running", "Running", "09_06", "16_35"),
        _cmu("limping", "Limping", "91_16", "77_19", "77_20", "77_22", "77_23", "77_24"),
        _cmu("jumping-jacks", "Jumping jacks and other exercises in one take", "13_29", "13_30", "14_06"),
        _cmu("jog-in-place", "Jogging in place, among other exercises", "13_30", "14_06"),
        _cmu("butterfly", "The butterfly stroke, swum in the air", "125_05", "126_06", "126_07", "126_08", "126_09"),
        _cmu("sun-salutation", "Sun salutation", "144_30", "144_31", "144_32"),
        _cmu("side-kicks", "Side kicks to both sides (Yokogeri)", "135_11"),
        _cmu("bassai", "The kata Bassai", "135_01"),
        _cmu("empi", "The kata Empi, twice", "135_02", "135_03"),
        _bandai(
            "raised-hands",
            "Raising the left hand, the right hand, both",
            "dataset-2_raise-up-left-hand_normal_002",
            "dataset-2_raise-up-right-hand_normal_001",
            "dataset-2_raise-up-both-hands_normal_002",
        ),
        _bandai(
            "waving",
            "Waving the left hand, the right hand, both",
            "dataset-2_wave-left-hand_normal_001",
            "dataset-2_wave-right-hand_normal_001",
            "dataset-2_wave-both-hands_normal_001",
        ),
        Dataset(
            "lafan1",
            "The whole of LaFAN1, about 150 MB: obstacles, walks, dances, fights, falls",
            "lafan1",
            (RemoteFile("lafan1", "lafan1/lafan1.zip", "lafan1.zip", is_archive=True),),
        ),
    )
}
"""Sets by name. The CMU ones are the movements that [Schultz2012] §3.5-3.6 discusses, and their like."""

_CMU_CLIP = re.compile(r"(?:cmu[:/])?(\d{1,3})_(\d{2})(?:\.amc)?", re.IGNORECASE)
_BANDAI_CLIP = re.compile(r"(?:bandai-namco[:/])?(dataset-[12]_[a-z0-9-]+_[a-z-]+_\d{3})(?:\.bvh)?", re.IGNORECASE)


def find(name: str) -> Dataset:
    """The set called ``name``, or the single clip: "07_01" of CMU, "dataset-2_walk_normal_001" of Bandai-Namco.

    Raises
    ------
    InputError
        If nothing is called so; the message says what comes near and what there is.
    """
    if name in NAMED_SETS:
        return NAMED_SETS[name]
    if match := _CMU_CLIP.fullmatch(name):
        clip = f"{int(match[1]):02d}_{match[2]}"
        return _cmu(clip, "One clip", clip)
    if match := _BANDAI_CLIP.fullmatch(name):
        return _bandai(match[1].lower(), f"One clip ({match[1].lower()})", match[1].lower())
    near = difflib.get_close_matches(name, NAMED_SETS, n=3)
    hint = f"Did you mean {' or '.join(near)}? " if near else ""
    raise InputError(
        f"No data set is called '{name}'. {hint}There are: {', '.join(NAMED_SETS)}; "
        "any clip of CMU by its number, such as 07_01; any clip of Bandai-Namco by its name, "
        "such as dataset-2_walk_normal_001."
    )


@cache
def _known_checksums() -> dict[str, str]:
    """Key to sha256, as shipped with this version."""
    text = resources.files("kinesics.datasets").joinpath("checksums.txt").read_text(encoding="utf-8")
    return parse_checksums(text)


def parse_checksums(text: str) -> dict[str, str]:
    """Lines of "key sha256"; empty lines and comments are skipped."""
    lines = (line.split() for line in text.splitlines() if line.strip() and not line.startswith("#"))
    return {parts[0]: parts[1] for parts in lines if len(parts) == 2}
