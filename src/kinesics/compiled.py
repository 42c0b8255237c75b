"""The compiled module, where it was built, and whether it is to do the work.

Wherever it does, NumPy or Python can too, more slowly: where there was no compiler, with ``KINESICS_NO_NATIVE=1``, or with
``KINESICS_KERNEL=numpy``.
"""

from __future__ import annotations

import os

try:
    from kinesics import _native as native
except ImportError:  # built without a compiler
    native = None  # type: ignore[assignment]  # a module's name cannot be declared as one that may be None

__all__ = ["declined", "native", "wanted"]


def declined() -> bool:
    """Whether the environment asks to do without it."""
    return os.environ.get("KINESICS_NO_NATIVE", "") not in ("", "0") or os.environ.get("KINESICS_KERNEL", "") == "numpy"


def wanted() -> bool:
    """Whether the compiled module does the work."""
    return native is not None and not declined()
