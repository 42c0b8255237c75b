"""The command line put together, and the one place where errors become exit codes."""

from __future__ import annotations

import os
import sys
import traceback
from collections.abc import Sequence
from typing import Annotated

import typer

from kinesics import __version__
from kinesics.cli import analyze, convert, data, demo, info, perform, terminal
from kinesics.errors import Cancelled, KinesicsError

app = typer.Typer(
    name="kinesics",
    help="Reads the grammar of human movement from motion capture.\n\nStart with: kinesics demo",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode="rich",
    context_settings={"help_option_names": ["-h", "--help"]},
)
for command, told in (
    (demo.demo, demo),
    (info.info, info),
    (analyze.analyze, analyze),
    (perform.perform, perform),
    (convert.convert, convert),
):
    app.command(short_help=told.SUMMARY, epilog=terminal.examples(told.EXAMPLES))(command)
app.add_typer(data.app, name="data", short_help="List and fetch recordings of others.")


def _print_version(wanted: bool) -> None:
    if wanted:
        print(f"kinesics {__version__}")
        raise typer.Exit


def _set_debug(wanted: bool) -> None:
    if wanted:
        os.environ["KINESICS_DEBUG"] = "1"


@app.callback()
def _common(
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version and stop.")
    ] = False,
    debug: Annotated[
        bool,
        typer.Option("--debug", callback=_set_debug, help="Show the traceback of a defect (also KINESICS_DEBUG=1)."),
    ] = False,
) -> None:
    pass


def run(arguments: Sequence[str]) -> int:
    """Run one command; its exit code."""
    try:
        try:
            app(args=list(arguments), prog_name="kinesics")
        finally:
            sys.stdout.flush()
    except SystemExit as stop:
        return _unheard() if isinstance(stop.__context__, BrokenPipeError) else _code(stop.code)
    except (KeyboardInterrupt, Cancelled):
        return _stopped()
    except BrokenPipeError:
        return _unheard()
    except KinesicsError as error:
        terminal.error(str(error))
        return 2
    except OSError as error:
        if _debugging():
            raise
        named = f"{error.filename}: " if error.filename else ""
        terminal.error(f"{named}{error.strerror or error}")
        return 2
    except MemoryError:
        terminal.error(
            "There is not enough memory for this recording. Analyse a part of it, or give --fps a lower rate."
        )
        return 2
    except Exception as error:
        if _debugging():
            traceback.print_exc()
        terminal.error(
            f"A defect of kinesics, not of your call: {type(error).__name__}: {error}\n"
            "Please report it with the command, and the file if you may. KINESICS_DEBUG=1 shows where it happened."
        )
        return 1
    return 0


def _code(code: str | int | None) -> int:
    if code is None:
        return 0
    if code == 130:
        return _stopped()
    return code if isinstance(code, int) else 1


def _unheard() -> int:
    """The reader of our output went away (`kinesics … | head`): no error, and Python must not try to flush again."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    return 0


def _stopped() -> int:
    terminal.remark("Stopped.")
    return 130


def _debugging() -> bool:
    return os.environ.get("KINESICS_DEBUG", "") not in ("", "0")
