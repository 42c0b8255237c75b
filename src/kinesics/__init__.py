"""kinesics reads the grammar of human movement.

A recording of a body becomes poses; a pose metric D and its mirror D* over all pairs of moments give the similarity plots
Z and Z*; their motifs give each movement its symmetry class and the recording its motion graph.

    >>> import kinesics as kx
    >>> motion = kx.performer.walk(seconds=4).motion
    >>> sim = kx.similarity(kx.poses(motion))

This module is the front door: every name is loaded when it is first used, so that importing kinesics stays light.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from kinesics import performer as performer
    from kinesics.analysis import Analysis as Analysis
    from kinesics.analysis import analyze as analyze
    from kinesics.analysis.joint import graph as graph
    from kinesics.body.mirroring import mirror as mirror
    from kinesics.body.motion import Motion as Motion
    from kinesics.body.motion import reverse as reverse
    from kinesics.body.pose import PoseSequence as PoseSequence
    from kinesics.body.pose import poses as poses
    from kinesics.body.quality import inspect as inspect
    from kinesics.body.skeleton import Skeleton as Skeleton
    from kinesics.errors import InputError as InputError
    from kinesics.errors import KinesicsError as KinesicsError
    from kinesics.formats import read as read
    from kinesics.formats import write as write
    from kinesics.report import load as load
    from kinesics.report import save as save
    from kinesics.similarity import Similarity as Similarity
    from kinesics.similarity import distance as distance
    from kinesics.similarity import mirror_distance as mirror_distance
    from kinesics.similarity import similarity as similarity
    from kinesics.synthesis.avatar import Avatar as Avatar
    from kinesics.synthesis.material import Material as Material
    from kinesics.synthesis.material import prepare as prepare
    from kinesics.synthesis.perform import perform as perform
    from kinesics.synthesis.perform import performance as performance

__version__ = "0.1.0"

_HOME = {
    "Analysis": "kinesics.analysis",
    "Avatar": "kinesics.synthesis.avatar",
    "InputError": "kinesics.errors",
    "KinesicsError": "kinesics.errors",
    "Material": "kinesics.synthesis.material",
    "Motion": "kinesics.body.motion",
    "PoseSequence": "kinesics.body.pose",
    "Similarity": "kinesics.similarity",
    "Skeleton": "kinesics.body.skeleton",
    "analyze": "kinesics.analysis",
    "distance": "kinesics.similarity",
    "graph": "kinesics.analysis.joint",
    "inspect": "kinesics.body.quality",
    "load": "kinesics.report",
    "mirror": "kinesics.body.mirroring",
    "mirror_distance": "kinesics.similarity",
    "perform": "kinesics.synthesis.perform",
    "performance": "kinesics.synthesis.perform",
    "poses": "kinesics.body.pose",
    "prepare": "kinesics.synthesis.material",
    "read": "kinesics.formats",
    "reverse": "kinesics.body.motion",
    "save": "kinesics.report",
    "write": "kinesics.formats",
}

__all__ = [*_HOME, "performer", "similarity"]


def __getattr__(name: str) -> Any:
    """Load a public name from its room on first use (PEP 562)."""
    if name in ("performer", "similarity"):  # rooms; that of similarity can be called
        return importlib.import_module(f"kinesics.{name}")
    if name in _HOME:
        value = getattr(importlib.import_module(_HOME[name]), name)
        globals()[name] = value
        return value
    raise AttributeError(f"module 'kinesics' has no attribute '{name}'")


def __dir__() -> list[str]:
    """All public names, loaded or not."""
    return sorted({*globals(), *__all__})
