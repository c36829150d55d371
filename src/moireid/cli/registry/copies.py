"""registry export, import: copies of a registry in files, also under another key."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from moireid.cli.common import (
    actor_option,
    counted,
    echo,
    friendly,
    json_option,
    overwrite_option,
    progress_bar,
    registry_option,
    say,
    show_json,
)
from moireid.cli.registry.records import Answer, registry_command, registry_group
from moireid.errors import RegistryError

if TYPE_CHECKING:
    from moireid.registry import Registry


@registry_command("export", overwrite_option)
@click.argument("path", type=click.Path(path_type=Path, dir_okay=False))
def registry_export(registry: Registry, path: Path, overwrite: bool) -> Answer:
    """Write a checked copy of records, log and public key to a file.

    The file is a registry in SQLite's format, which can be asked as any other; without the private key it can only be
    read.
    """
    with progress_bar("exporting") as progress:
        count = registry.export(path, overwrite=overwrite, progress=progress)
    shown = registry.shown_url
    return lambda: {"registry": shown, "badges": count, "file": str(path)}, [f"{count} badges of {shown} are in {path}"]


@registry_group.command("import")
@click.argument("path", type=click.Path(path_type=Path, dir_okay=False))
@click.option(
    "--new-key",
    is_flag=True,
    help="Sign all records by the key of this registry, which must be empty: where the key of the other one was lost, "
    "or is in other hands. Readers need the new fingerprint.",
)
@actor_option
@registry_option
@json_option
@friendly
def registry_import(path: Path, new_key: bool, actor: str | None, registry_url: str | None, as_json: bool) -> None:
    """Read in a file that `registry export` wrote.

    Either everything is imported or nothing. The registry is made if there is none.
    """
    from moireid.registry import import_registry, open_registry

    count = import_registry(path, registry_url, actor=actor, new_key=new_key)
    with open_registry(registry_url, create=False) as registry:
        try:
            registry.standing()
        except RegistryError as error:
            # Of an older state than was seen, which every reader refuses.
            say(f"note: {error}")
        if as_json:
            show_json({"registry": registry.shown_url, "badges": count, "fingerprint": registry.fingerprint})
            return
        echo(f"{registry.shown_url} holds the {counted(count, 'badge')} of {path}")
        if registry.key_here is None:
            echo("it can only be read here: the authority's private key is not on this machine")
