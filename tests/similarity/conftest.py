"""The code paths, each forced in turn."""

from __future__ import annotations

import pytest

from kinesics.similarity import _kernel


@pytest.fixture(params=["avx512", "avx2", "portable", "numpy"])
def kernel(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> str:
    """The name of the code path that the test runs on."""
    if request.param not in _kernel.available():
        pytest.skip(f"This machine has no code path '{request.param}'.")
    monkeypatch.setenv("KINESICS_KERNEL", request.param)
    return str(request.param)
