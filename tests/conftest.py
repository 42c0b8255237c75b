"""What all tests share: seeded randomness, where real recordings lie, how long the searching tests search."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, settings

LONG = os.environ.get("KINESICS_LONG") == "1"

settings.register_profile(
    "ci",
    derandomize=True,
    deadline=None,
    max_examples=50,
    database=None,
    suppress_health_check=[HealthCheck.too_slow],
)
settings.register_profile(
    "long",
    deadline=None,
    max_examples=2000,
    database=None,
    print_blob=True,
    suppress_health_check=[HealthCheck.too_slow],
)
settings.load_profile("long" if LONG else "ci")


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Leave out tests marked ``long`` unless KINESICS_LONG=1 (`make check-long`)."""
    if LONG:
        return
    long = [item for item in items if item.get_closest_marker("long")]
    if long:
        config.hook.pytest_deselected(items=long)
        items[:] = [item for item in items if not item.get_closest_marker("long")]


@pytest.fixture
def rng() -> np.random.Generator:
    """The same random numbers in every test and every run."""
    return np.random.default_rng(20120615)


@pytest.fixture(scope="session")
def shared_data() -> Path:
    """The folder of real recordings: $KINESICS_DATA, or ``../shared/data`` beside the project."""
    named = os.environ.get("KINESICS_DATA")
    folder = Path(named) if named else Path(__file__).resolve().parents[2] / "shared" / "data"
    if not folder.is_dir():
        why = "does not exist" if named else "was not found beside the project and $KINESICS_DATA is not set"
        pytest.skip(f"Needs the real recordings, which are not part of the project: {folder.name!r} {why}.")
    return folder
