"""``python -m kinesics.cli``: the same as the ``kinesics`` command."""

from kinesics.cli import main

main()
