"""How long work reports that it goes on, and how it is asked to stop. A leaf.

Long functions take ``progress: Progress | None``: a callable given a fraction in [0, 1] and a few words. To stop the
work the callable raises (`kinesics.errors.Cancelled`, or ``KeyboardInterrupt``); nothing half-written is left behind.
"""

from __future__ import annotations

from typing import Protocol


class Progress(Protocol):
    """Called now and then by long work; may raise to stop it."""

    def __call__(self, fraction: float, message: str = "") -> None:
        """``fraction`` is in [0, 1] and never falls; ``message`` says what is being done."""
        ...


def silent(fraction: float, message: str = "") -> None:
    """Report nothing."""
