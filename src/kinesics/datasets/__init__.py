"""Recordings that can be fetched from their official homes, and where they are kept.

- `kinesics.datasets.catalogue`: what there is, whose it is, on which terms
- `kinesics.datasets.download`: fetching, checking and keeping

Nothing of it is part of the package: every recording comes from its owner, on the owner's terms.
"""

from kinesics.datasets.catalogue import COLLECTIONS, NAMED_SETS, Collection, Dataset, RemoteFile, find
from kinesics.datasets.download import Fetched, Trust, default_folder, fetch

__all__ = [
    "COLLECTIONS",
    "NAMED_SETS",
    "Collection",
    "Dataset",
    "Fetched",
    "RemoteFile",
    "Trust",
    "default_folder",
    "fetch",
    "find",
]
