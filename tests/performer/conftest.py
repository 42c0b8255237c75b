"""Performances that several tests look at, made once."""

from __future__ import annotations

from functools import cache

import pytest

from kinesics import performer
from kinesics.performer import Performance


@cache
def _performed(name: str, fps: float) -> Performance:
    return performer.perform(name, fps=fps)


@pytest.fixture(params=performer.NAMES)
def performance(request: pytest.FixtureRequest) -> Performance:
    """Every movement in turn, as it is by default, at 60 frames a second."""
    return _performed(str(request.param), 60.0)
