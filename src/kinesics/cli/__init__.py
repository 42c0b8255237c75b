"""The command line: one file a command, and the only room that prints.

The result of a command goes to stdout; progress, remarks and the one message of an error go to stderr. Exit codes: 0 done;
2 the input or the call is wrong; 130 stopped by Ctrl-C; 1 a defect of kinesics.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence


def main(arguments: Sequence[str] | None = None) -> None:
    """Entry point of the ``kinesics`` command."""
    try:
        from kinesics import compiled

        if compiled.wanted():
            # what is left to NumPy's products is small: their second thread waits busily, and takes the core from what has use
            # for it (the compiled kernels have threads of their own). To be said before NumPy is loaded
            os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
        from kinesics.cli.app import run
    except KeyboardInterrupt:
        sys.exit(130)
    sys.exit(run(list(sys.argv[1:] if arguments is None else arguments)))
