"""verdicts: which verdicts a studio gave, listed or exported."""

from __future__ import annotations

import csv
import io
from dataclasses import fields
from pathlib import Path

import click

from moireid.cli.common import echo, friendly, json_option, overwrite_option, show_json
from moireid.errors import SpecError
from moireid_studio.commands.serve_cmd import data_option, state_option

#: Verdicts read at a time, and shown where no file is asked for.
PAGE, SHOWN = 500, 50


@click.command("verdicts")
@click.option(
    "--out",
    "path",
    type=click.Path(path_type=Path, dir_okay=False),
    help="Write all of them to this CSV file, in place of showing the newest.",
)
@click.option(
    "--since",
    type=click.DateTime(["%Y-%m-%d"]),
    metavar="DATE",
    help="Only from this day on (UTC).",
)
@data_option
@state_option
@overwrite_option
@json_option
@friendly
def verdicts_command(
    path: Path | None, since: object, data: Path | None, state: str | None, overwrite: bool, as_json: bool
) -> None:
    """List or export the verdicts that a studio gave.

    Each says when and by whose token it was asked for, the film's SHA-256, the id of the claimed badge, the verdict,
    the registry's state and the version. Neither films nor names are kept. How long they are kept,
    `moireid serve --keep-verdicts` says.
    """
    from moireid.files import planned, write_text
    from moireid_studio.settings import default_data
    from moireid_studio.store.verdict_store import FILE, StoredVerdict, Verdicts

    folder = data or default_data()
    if state is None and not (folder / FILE).is_file():
        raise SpecError(f"no studio has given verdicts in {folder}; name its folder with --data")
    if path is not None:
        planned([path], overwrite=overwrite)
    store = Verdicts(folder, None, state)
    try:
        begin = None if since is None else f"{since:%Y-%m-%dT00:00:00Z}"
        found = store.given(SHOWN if path is None and not as_json else PAGE, None, begin)
        while (path is not None or as_json) and (more := store.given(PAGE, found[-1].number if found else 0, begin)):
            found += more
    finally:
        store.close()
    if path is not None:
        text = io.StringIO()
        columns = [field.name for field in fields(StoredVerdict)]
        table = csv.DictWriter(text, columns, lineterminator="\n")
        table.writeheader()
        table.writerows(one.to_json() for one in found)
        write_text(path, text.getvalue())
    if as_json:
        document = {"file": str(path)} if path is not None else {"verdicts": [one.to_json() for one in found]}
        show_json(document | {"count": len(found)})
    elif path is not None:
        echo(f"{path}: {len(found)} verdicts")
    else:
        for one in found:
            film = one.film_sha256[:12] if one.film_sha256 else "live"
            claim = one.claim or "no claim"
            echo(f"{one.at}  {one.token}  {one.kind:<8}  {film:<12}  {claim:<16}  {one.verdict}")
