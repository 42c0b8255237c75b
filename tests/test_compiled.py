"""Whether the compiled module does the work is decided in one place."""

from __future__ import annotations

import pytest

from kinesics import compiled
from kinesics.similarity import _kernel


@pytest.mark.parametrize(
    ("name", "value", "declined"),
    [
        ("KINESICS_NO_NATIVE", "1", True),
        ("KINESICS_NO_NATIVE", "0", False),
        ("KINESICS_NO_NATIVE", "", False),
        ("KINESICS_KERNEL", "numpy", True),
        ("KINESICS_KERNEL", "", False),
    ],
)
def test_the_environment_may_decline_it(monkeypatch: pytest.MonkeyPatch, name: str, value: str, declined: bool) -> None:
    """Both ways of asking for NumPy hold for everything, the kernels of similarity too."""
    monkeypatch.delenv("KINESICS_NO_NATIVE", raising=False)
    monkeypatch.delenv("KINESICS_KERNEL", raising=False)
    monkeypatch.setenv(name, value)
    assert compiled.declined() is declined
    assert compiled.wanted() is (compiled.native is not None and not declined)
    assert (_kernel.chosen() == "numpy") is not compiled.wanted()


def test_where_it_was_not_built_it_is_not_wanted(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without a compiler everything goes on without it."""
    monkeypatch.setattr(compiled, "native", None)
    monkeypatch.delenv("KINESICS_NO_NATIVE", raising=False)
    monkeypatch.delenv("KINESICS_KERNEL", raising=False)
    assert not compiled.wanted()
    assert _kernel.chosen() == "numpy"
