"""Fetching recordings: tried against a server of our own on 127.0.0.1."""

from __future__ import annotations

import functools
import hashlib
import http.server
import io
import re
import threading
import zipfile
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import pytest

from kinesics import datasets
from kinesics.datasets import catalogue, download
from kinesics.datasets.download import Trust
from kinesics.errors import InputError


@dataclass
class Server:
    """A folder served over HTTP, and what was asked of it."""

    url: str
    root: Path
    asked: list[str] = field(default_factory=list)

    def put(self, path: str, content: bytes) -> None:
        file = self.root / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_bytes(content)


@pytest.fixture
def server(tmp_path: Path) -> Iterator[Server]:
    """A server that knows nothing yet."""
    root = tmp_path / "served"
    root.mkdir()

    class Handler(http.server.SimpleHTTPRequestHandler):
        def do_GET(self) -> None:
            ours.asked.append(self.path)
            if "broken" in self.path:  # promises more than it sends
                self.send_response(200)
                self.send_header("Content-Length", "100000")
                self.end_headers()
                self.wfile.write(b"half a fi")
                return
            super().do_GET()

        def log_message(self, format: str, *args: object) -> None:  # noqa: A002 - the base class calls it so
            pass

    httpd = http.server.ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(Handler, directory=str(root)))
    thread = threading.Thread(target=httpd.serve_forever, args=(0.01,), daemon=True)
    thread.start()
    ours = Server(f"http://127.0.0.1:{httpd.server_port}", root)
    yield ours
    httpd.shutdown()
    httpd.server_close()
    thread.join()


@pytest.fixture(autouse=True)
def no_waiting(monkeypatch: pytest.MonkeyPatch) -> None:
    """Pooch waits a second before it tries again; and no test may reach the real servers or the user's cache."""
    monkeypatch.setattr(download, "_RETRIES", 0)
    monkeypatch.setenv("KINESICS_MIRROR", "http://127.0.0.1:9")


def serve_clip(server: Server, subject: str = "126", clip: str = "126_06") -> None:
    server.put(f"cmu/{subject}/{subject}.asf", b":version 1.10\n")
    server.put(f"cmu/{subject}/{clip}.amc", b":FULLY-SPECIFIED\n")


def test_a_clip_comes_with_its_skeleton(server: Server, tmp_path: Path) -> None:
    """A CMU clip by its number brings .asf and .amc side by side, as the reader wants them."""
    serve_clip(server)
    got = datasets.fetch("126_06", tmp_path / "kept", mirror=server.url)
    assert [f.path.relative_to(tmp_path / "kept").as_posix() for f in got] == ["cmu/126/126.asf", "cmu/126/126_06.amc"]
    assert got[0].path.read_bytes() == b":version 1.10\n"
    assert all(f.is_new and f.trust is Trust.FIRST_USE for f in got)


def test_a_second_time_nothing_is_asked_of_the_server(server: Server, tmp_path: Path) -> None:
    """What is there and unchanged is not fetched again, and is compared with the checksum of the first time."""
    serve_clip(server)
    datasets.fetch("126_06", tmp_path / "kept", mirror=server.url)
    server.asked.clear()
    again = datasets.fetch("126_06", tmp_path / "kept", mirror=server.url)
    assert server.asked == []
    assert [(f.is_new, f.trust) for f in again] == [(False, Trust.REMEMBERED)] * 2


def test_a_file_changed_here_is_refused_and_left_alone(server: Server, tmp_path: Path) -> None:
    """A kept file that no longer has its checksum is neither used nor overwritten."""
    serve_clip(server)
    path = datasets.fetch("126_06", tmp_path, mirror=server.url)[1].path
    path.write_bytes(b"my own notes")
    with pytest.raises(InputError, match=r"126_06\.amc is not the file that its owner gives out"):
        datasets.fetch("126_06", tmp_path, mirror=server.url)
    assert path.read_bytes() == b"my own notes"


def test_a_file_changed_at_its_home_is_refused(server: Server, tmp_path: Path) -> None:
    """Trust on first use: when the server gives out something else later, it is said and nothing is kept."""
    serve_clip(server)
    path = datasets.fetch("126_06", tmp_path / "kept", mirror=server.url)[1].path
    path.unlink()
    server.put("cmu/126/126_06.amc", b"something else")
    with pytest.raises(InputError, match="not the file it should be"):
        datasets.fetch("126_06", tmp_path / "kept", mirror=server.url)
    assert not path.exists()


def test_a_known_checksum_is_asked_for(server: Server, tmp_path: Path) -> None:
    """Where kinesics ships the checksum, anything else is refused at the first fetch, and no debris is left."""
    serve_clip(server, "07", "07_01")
    with pytest.raises(InputError, match=r"checksum.*mocap\.cs\.cmu\.edu"):
        datasets.fetch("07_01", tmp_path / "kept", mirror=server.url)
    assert not [p for p in (tmp_path / "kept").rglob("*") if p.is_file()]


def test_the_shipped_checksums_are_those_of_the_real_files(shared_data: Path, server: Server, tmp_path: Path) -> None:
    """The real Empi take and its skeleton pass the check."""
    for name in ("135/135.asf", "135/135_02.amc"):
        server.put(f"cmu/{name}", (shared_data / "cmu" / name).read_bytes())
    got = datasets.fetch("135_02", tmp_path / "kept", mirror=server.url)
    assert [f.trust for f in got] == [Trust.KNOWN, Trust.KNOWN]


def test_a_missing_file_names_the_address(server: Server, tmp_path: Path) -> None:
    """404: the address and the page where one can look."""
    with pytest.raises(InputError, match=r"no such file: http://127.*126\.asf.*mocap\.cs\.cmu\.edu"):
        datasets.fetch("126_06", tmp_path / "kept", mirror=server.url)


def test_without_a_network_it_says_what_to_do(tmp_path: Path) -> None:
    """Nothing listens: the network is named, and the way by hand with the place to put the file."""
    with pytest.raises(InputError, match=r"(?s)Could not reach.*Check the network.*put it at .*126\.asf"):
        datasets.fetch("126_06", tmp_path / "kept", mirror="http://127.0.0.1:9")


def test_a_broken_off_download_leaves_nothing_and_can_go_on(server: Server, tmp_path: Path) -> None:
    """The first file stays, the half one is gone; the next call fetches only what lacks."""
    serve_clip(server)
    files = catalogue.find("126_06").files
    broken = catalogue.Dataset("x", "x", "cmu", (files[0], catalogue.RemoteFile("cmu", "broken", "126/126_06.amc")))
    with pytest.raises(InputError, match=r"broke off|Could not reach"):
        datasets.fetch(broken, tmp_path / "kept", mirror=server.url)
    left = [p.relative_to(tmp_path / "kept").as_posix() for p in (tmp_path / "kept" / "cmu").rglob("*") if p.is_file()]
    assert left == ["cmu/126/126.asf"]
    server.asked.clear()
    datasets.fetch("126_06", tmp_path / "kept", mirror=server.url)
    assert server.asked == ["/cmu/126/126_06.amc"]


def test_a_log_in_page_is_not_taken_for_a_recording(server: Server, tmp_path: Path) -> None:
    """A captive network answers everything with a page and status 200."""
    server.put("cmu/126/126.asf", b"\n<!DOCTYPE html><html>Welcome to the hotel</html>")
    with pytest.raises(InputError, match="web page"):
        datasets.fetch("126_06", tmp_path / "kept", mirror=server.url)
    assert not (tmp_path / "kept" / "cmu" / "126" / "126.asf").exists()


def test_an_archive_is_unpacked_whole(server: Server, tmp_path: Path) -> None:
    """A zip becomes a folder of its recordings; a second call finds them."""
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w") as archive:
        archive.writestr("walk1_subject1.bvh", "HIERARCHY")
        archive.writestr("deep/dance1_subject2.bvh", "HIERARCHY")
        archive.writestr("../outside.bvh", "HIERARCHY")
    server.put("lafan1/lafan1/lafan1.zip", packed.getvalue())
    for new in (True, False):
        got = datasets.fetch("lafan1", tmp_path / "kept", mirror=server.url)
        assert [f.is_new for f in got] == [new] * 3
    assert all((tmp_path / "kept" / "lafan1" / "lafan1") in f.path.parents for f in got)
    assert not (tmp_path / "kept" / "lafan1" / "outside.bvh").exists()


def test_a_damaged_archive_says_so(server: Server, tmp_path: Path) -> None:
    """A zip that is none leaves no folder."""
    server.put("lafan1/lafan1/lafan1.zip", b"PK but no more")
    with pytest.raises(InputError, match="not a whole zip"):
        datasets.fetch("lafan1", tmp_path / "kept", mirror=server.url)
    assert [p.name for p in (tmp_path / "kept" / "lafan1").iterdir()] == ["lafan1.zip"]


def test_progress_never_falls_and_ends_at_one(server: Server, tmp_path: Path) -> None:
    """What the progress bar is told."""
    serve_clip(server)
    told: list[float] = []
    datasets.fetch("126_06", tmp_path / "kept", mirror=server.url, progress=lambda f, message="": told.append(f))
    assert told == sorted(told)
    assert told[-1] == 1.0


def test_stopping_leaves_no_half_file(server: Server, tmp_path: Path) -> None:
    """Ctrl-C in the middle of a file: the temporary one is removed."""
    serve_clip(server)
    server.put("cmu/126/126_06.amc", b"x" * 1_000_000)

    def stop(fraction: float, message: str = "") -> None:
        if fraction > 0.6:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        datasets.fetch("126_06", tmp_path / "kept", mirror=server.url, progress=stop)
    left = [p.name for p in (tmp_path / "kept" / "cmu").rglob("*") if p.is_file()]
    assert left == ["126.asf"]


def test_a_folder_that_cannot_be_written_is_named(server: Server, tmp_path: Path) -> None:
    """A file stands where the folder should be."""
    serve_clip(server)
    (tmp_path / "kept").write_text("I am a file")
    with pytest.raises(InputError, match=r"Cannot keep files in .*kept"):
        datasets.fetch("126_06", tmp_path / "kept", mirror=server.url)


@pytest.mark.parametrize("name", ["butterflies", "limp", "1_2_3", "", "dataset-3_walk_normal_001"])
def test_an_unknown_name_lists_what_there_is(name: str) -> None:
    """The message holds all sets, and what comes near."""
    with pytest.raises(InputError, match="sun-salutation") as caught:
        catalogue.find(name)
    if name == "butterflies":
        assert "Did you mean butterfly?" in str(caught.value)


@pytest.mark.parametrize(
    ("name", "path"),
    [
        ("7_01", "07/07_01.amc"),
        ("cmu:07_01", "07/07_01.amc"),
        ("135_02.amc", "135/135_02.amc"),
        ("dataset-2_walk_normal_001.bvh", "Bandai-Namco-Research-Motiondataset-2/data/dataset-2_walk_normal_001.bvh"),
    ],
)
def test_single_clips_by_their_names(name: str, path: str) -> None:
    """However one writes them."""
    assert catalogue.find(name).files[-1].path == path


def test_subjects_at_60_fps_are_said() -> None:
    """CMU's files do not give a rate; for these subjects the usual 120 would be wrong."""
    assert "--fps 60" in catalogue.find("77_19").note
    assert catalogue.find("07_01").note == ""


def test_every_set_has_terms_a_credit_and_an_address() -> None:
    """Nothing is fetched without its owner's terms; shipped checksums are checksums of files in known places."""
    for dataset in datasets.NAMED_SETS.values():
        home = datasets.COLLECTIONS[dataset.collection]
        assert home.terms
        assert home.credit
        for file in dataset.files:
            assert re.fullmatch(r"https?://[^ ]+", download.address(file))
    for key, digest in catalogue._known_checksums().items():
        assert key.split("/")[0] in datasets.COLLECTIONS
        assert len(bytes.fromhex(digest)) == hashlib.sha256().digest_size
