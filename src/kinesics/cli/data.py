"""``kinesics data list`` and ``kinesics data fetch NAME``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from kinesics.cli import recording, terminal

LIST_EXAMPLES = (("kinesics data list", ""),)
FETCH_EXAMPLES = (
    ("kinesics data fetch butterfly", "a set"),
    ("kinesics data fetch 07_01 --to data", "one clip of CMU, into a folder of yours"),
    ("kinesics data fetch dataset-2_walk_normal_001", "one clip of Bandai-Namco"),
)

app = typer.Typer(
    help="Recordings of others, fetched from their official homes on their owners' terms.",
    no_args_is_help=True,
    rich_markup_mode="rich",
)


def _listing() -> dict[str, Any]:
    from kinesics import datasets

    return {
        "sets": [
            {"name": d.name, "title": d.title, "collection": d.collection, "files": len(d.files), "note": d.note}
            for d in datasets.NAMED_SETS.values()
        ],
        "collections": [
            {"name": c.name, "title": c.title, "home": c.home, "terms": c.terms, "credit": c.credit}
            for c in datasets.COLLECTIONS.values()
        ],
    }


@app.command(name="list", epilog=terminal.examples(LIST_EXAMPLES))
def list_(json: recording.Json = False) -> None:
    """What can be fetched, whose it is, and on which terms."""
    listing = _listing()
    if json:
        terminal.print_json(listing)
        return
    console = terminal.console()
    for collection in listing["collections"]:
        console.print(f"[bold]{collection['title']}[/bold]\n{collection['home']}\n{collection['terms']}")
        for entry in listing["sets"]:
            if entry["collection"] == collection["name"]:
                console.print(f"  [cyan]{entry['name']:<16}[/cyan]{entry['title']}")
        console.print()
    console.print(
        "Single clips: of CMU by number, such as 07_01; of Bandai-Namco by name, such as dataset-2_walk_normal_001."
    )


@app.command(epilog=terminal.examples(FETCH_EXAMPLES))
def fetch(
    name: Annotated[str, typer.Argument(metavar="NAME", show_default=False, help="A set of `data list`, or a clip.")],
    to: Annotated[
        Path | None,
        typer.Option("--to", metavar="DIR", show_default=False, help="Keep it here, not in the user's cache."),
    ] = None,
    json: recording.Json = False,
) -> None:
    """Fetch a set or a clip, unless it is there already; prints where each file is."""
    from kinesics import datasets

    dataset = datasets.find(name)
    home = datasets.COLLECTIONS[dataset.collection]
    with terminal.Bar("Fetching") as bar:
        fetched = datasets.fetch(dataset, to, progress=bar)
    if json:
        terminal.print_json(
            {
                "name": dataset.name,
                "files": [{"path": str(f.path), "new": f.is_new, "checksum": str(f.trust)} for f in fetched],
                "terms": home.terms,
                "credit": home.credit,
                "note": dataset.note,
            }
        )
        return
    for file in fetched:
        print(file.path)
    first = sum(f.trust is datasets.Trust.FIRST_USE for f in fetched)
    if first:
        terminal.remark(
            f"No checksum is known of {first} of the {len(fetched)} files: it was written down now, and later copies must match."
        )
    if dataset.note:
        terminal.remark(dataset.note)
    terminal.remark(f"Terms: {home.terms} {home.home}\nCredit: {home.credit}")
