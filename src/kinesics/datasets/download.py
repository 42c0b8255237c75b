"""Fetching: through pooch, checked, kept in one folder; a file is there whole or not at all."""

from __future__ import annotations

import contextlib
import logging
import os
import shutil
import tempfile
import zipfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Any

from kinesics import progress as _progress
from kinesics.datasets.catalogue import COLLECTIONS, Dataset, RemoteFile, find, parse_checksums
from kinesics.errors import InputError

if TYPE_CHECKING:
    from kinesics.progress import Progress

_REMEMBERED = "checksums.txt"
_RETRIES = 1
_TIMEOUT_SECONDS = 30


class Trust(StrEnum):
    """Why a file is believed to be the right one."""

    KNOWN = "known"
    """Its checksum is shipped with kinesics."""
    REMEMBERED = "remembered"
    """Its checksum is that of the first time it was fetched into this folder."""
    FIRST_USE = "first use"
    """Nothing to compare with: its checksum was written down and will be asked for from now on."""


@dataclass(frozen=True)
class Fetched:
    """One recording on this machine."""

    path: Path
    is_new: bool
    """Whether it was downloaded just now."""
    trust: Trust


def default_folder() -> Path:
    """Where fetched files are kept: the platform's folder for caches."""
    import pooch

    return Path(pooch.os_cache("kinesics"))


def fetch(
    name: str | Dataset,
    folder: str | os.PathLike[str] | None = None,
    *,
    mirror: str | None = None,
    progress: Progress = _progress.silent,
) -> list[Fetched]:
    """Bring a named set or a single clip onto this machine, unless it is there already.

    A file is checked against its checksum: the one shipped with kinesics where there is one, else the one written down
    when it was first fetched into this folder. Stopped or broken off, it leaves only whole files; called again, it goes on
    with those that lack.

    Parameters
    ----------
    name : as in `kinesics.datasets.find`.
    folder : where to keep it; by default the platform's folder for caches.
    mirror : address that stands in for all owners' servers: ``<mirror>/<collection>/<path>``. Also $KINESICS_MIRROR.

    Raises
    ------
    InputError
        If the name is not known, the server cannot be reached or lacks the file, or a file is not what it should be.
    """
    dataset = name if isinstance(name, Dataset) else find(name)
    root = Path(folder) if folder is not None else default_folder()
    mirror = mirror or os.environ.get("KINESICS_MIRROR")
    try:
        root.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"Cannot keep files in {root}: {error.strerror}. Choose another folder.") from error
    remembered = _read_remembered(root)
    fetched: list[Fetched] = []
    for number, file in enumerate(dataset.files):

        def within(fraction: float, message: str = "", number: int = number, file: RemoteFile = file) -> None:
            progress((number + fraction) / len(dataset.files), message or file.place)

        within(0.0)
        path, is_new, trust = _fetch_file(file, root, mirror, remembered, within)
        paths = _unpack(path) if file.is_archive else [path]
        fetched += [Fetched(p, is_new, trust) for p in paths]
    progress(1.0, "")
    return fetched


def address(file: RemoteFile, mirror: str | None = None) -> str:
    """Where a file is fetched from."""
    if mirror:
        return f"{mirror.rstrip('/')}/{file.collection}/{file.path}"
    return COLLECTIONS[file.collection].url + file.path


def _fetch_file(
    file: RemoteFile, root: Path, mirror: str | None, remembered: dict[str, str], progress: Callable[[float], None]
) -> tuple[Path, bool, Trust]:
    import pooch

    path = root / file.collection / file.place
    expected = file.sha256 or remembered.get(file.key)
    trust = Trust.KNOWN if file.sha256 else Trust.REMEMBERED if expected else Trust.FIRST_USE
    is_new = not path.exists()
    if is_new:
        _download(file, address(file, mirror), path, expected, progress)
    found = pooch.file_hash(str(path), alg="sha256")
    if expected and found != expected:
        raise InputError(
            f"{path} is not the file that its owner gives out: it was changed here, or is damaged. "
            "Remove it and fetch it again."
        )
    if trust is Trust.FIRST_USE:
        remembered[file.key] = found
        _write_remembered(root, remembered)
    return path, is_new, trust


def _download(file: RemoteFile, url: str, path: Path, expected: str | None, progress: Callable[[float], None]) -> None:
    """Download to a temporary name beside ``path``; it takes its place only when whole and right."""
    import pooch
    import requests

    http = pooch.HTTPDownloader(progressbar=_Meter(progress), timeout=_TIMEOUT_SECONDS, chunk_size=1 << 16)

    def download(url: str, output: str, manager: Any) -> None:
        http(url, output, manager)
        _refuse_web_page(Path(output), url)

    by_hand = f"You can also download it in a browser and put it at {path}"
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with _quiet(pooch.get_logger()):
            manager = pooch.create(
                path=path.parent,
                base_url="",
                registry={path.name: f"sha256:{expected}" if expected else None},
                urls={path.name: url},
                retry_if_failed=_RETRIES,
            )
            manager.fetch(path.name, downloader=download)
    except requests.HTTPError as error:
        status = error.response.status_code if error.response is not None else 0
        why = "has no such file" if status == 404 else f"refused it (status {status})"
        raise InputError(
            f"The server {why}: {url}. See {COLLECTIONS[file.collection].home} for what there is."
        ) from error
    except (requests.ConnectionError, requests.Timeout) as error:
        raise InputError(
            f"Could not reach the server for {url}. Check the network and try again. {by_hand}."
        ) from error
    except requests.RequestException as error:
        raise InputError(f"The download of {url} broke off ({error}). Try again. {by_hand}.") from error
    except InputError:
        raise
    except ValueError as error:  # pooch: the checksum
        raise InputError(
            f"What came from {url} is not the file it should be (its checksum is not {expected}). Nothing was kept. "
            f"Try again; if it stays so, the file was changed at its home: look at "
            f"{COLLECTIONS[file.collection].home}."
        ) from error
    except OSError as error:
        raise InputError(f"Cannot write to {path.parent}: {error.strerror or error}. Choose another folder.") from error


def _refuse_web_page(path: Path, url: str) -> None:
    """A network's log-in page answers every address with status 200; no recording begins like one."""
    with path.open("rb") as stream:
        head = stream.read(256).lstrip().lower()
    if head.startswith((b"<!doctype", b"<html")):
        raise InputError(
            f"A web page came instead of {url}: the network may ask you to log in first, or the file has moved. "
            "Nothing was kept."
        )


def _unpack(archive: Path) -> list[Path]:
    """Unpack a zip into a folder of its name beside it, all or nothing; its recordings, sorted."""
    folder = archive.with_suffix("")
    if not folder.exists():
        room = Path(tempfile.mkdtemp(dir=archive.parent, prefix=".unpacking-"))
        try:
            with zipfile.ZipFile(archive) as stream:
                stream.extractall(room)
            room.rename(folder)
        except zipfile.BadZipFile as error:
            raise InputError(f"{archive} is not a whole zip file ({error}). Remove it and fetch it again.") from error
        finally:
            shutil.rmtree(room, ignore_errors=True)
    return sorted(path for path in folder.rglob("*") if path.is_file())


def _read_remembered(root: Path) -> dict[str, str]:
    try:
        return parse_checksums((root / _REMEMBERED).read_text(encoding="utf-8"))
    except FileNotFoundError:
        return {}


def _write_remembered(root: Path, remembered: dict[str, str]) -> None:
    lines = ["# sha256 of every file when it was first fetched; later copies are compared with it"]
    lines += [f"{key} {value}" for key, value in sorted(remembered.items())]
    new = root / f".{_REMEMBERED}.new"
    new.write_text("\n".join(lines) + "\n", encoding="utf-8")
    new.replace(root / _REMEMBERED)


class _Meter:
    """What pooch asks of a progress bar, handed on as a fraction."""

    def __init__(self, progress: Callable[[float], None]) -> None:
        self._progress = progress
        self._done = 0
        self.total = 0

    def update(self, size: int) -> None:
        """``size`` more bytes have come (pooch counts whole chunks, so it may run over)."""
        self._done += size
        if self.total:
            self._progress(min(self._done / self.total, 1.0))

    def reset(self) -> None:
        """Pooch starts counting anew before it reports the whole."""
        self._done = 0

    def close(self) -> None:
        """Nothing to close."""


@contextlib.contextmanager
def _quiet(logger: logging.Logger) -> Iterator[None]:
    """Errors are raised; what pooch logs besides would stand between the reader and them."""
    level = logger.level
    logger.setLevel(logging.CRITICAL)
    try:
        yield
    finally:
        logger.setLevel(level)
