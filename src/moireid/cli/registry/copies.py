"""registry export, import, rotate-key: copies of a registry as JSON files, and its signing key."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import click

from moireid.cli.common import (
    actor_option,
    echo,
    friendly,
    json_option,
    overwrite_option,
    progress_bar,
    registry_option,
    say,
    show_json,
)
from moireid.cli.registry.records import registry_command, registry_group
from moireid.errors import RegistryError

if TYPE_CHECKING:
    from moireid.registry import Registry


@registry_command("rotate-key")
def registry_rotate_key(registry: Registry, as_json: bool) -> None:
    """Give the registry a new signing key.

    The old key signs one last log entry, and the new one signs it too. By that entry, all who trusted the old
    fingerprint, or have seen it here, accept the new one. All records are signed anew.

    Do it when people who could reach the key leave, or at fixed dates. If the old key was stolen, the thief could do
    the same: then send everybody the new fingerprint yourself, and the checkpoint of the change.
    """
    old = registry.fingerprint
    with progress_bar("signing all records anew") as progress:
        records = registry.rotate_key(progress)
    key, shown, new, head = registry.key_here, registry.shown_url, registry.fingerprint, registry.head()
    if as_json:
        document = {"registry": shown, "old_fingerprint": old, "fingerprint": new}
        show_json(document | {"records": records, "head": head, "key": str(key) if key else None})
        return
    echo(f"{shown} is signed by {new} from now on, and no longer by {old}")
    echo(f"{records} records are signed anew; the change is log entry {head.split(':')[0]}")
    echo("make a checkpoint and give it to others: it shows that the change was yours")
    if key is not None:
        echo(f"the new private key is {key}: keep a copy; that of {old} signs nothing here any more")


@registry_command("export", overwrite_option)
@click.argument("path", type=click.Path(path_type=Path, dir_okay=False))
def registry_export(registry: Registry, path: Path, overwrite: bool, as_json: bool) -> None:
    """Write the records, the log and the public key to a JSON file."""
    with progress_bar("exporting") as progress:
        count = registry.export_json(path, overwrite=overwrite, progress=progress)
        if as_json:
            show_json({"registry": registry.shown_url, "badges": count, "file": str(path)})
        else:
            echo(f"{count} badges of {registry.shown_url} are in {path}")


@registry_group.command("import")
@click.argument("path", type=click.Path(path_type=Path, dir_okay=False))
@actor_option
@registry_option
@json_option
@friendly
def registry_import(path: Path, actor: str | None, registry_url: str | None, as_json: bool) -> None:
    """Read in a file that `registry export` wrote.

    Either everything is imported or nothing. The registry is made if there is none.
    """
    from moireid.registry import import_registry, open_registry

    done = import_registry(path, registry_url, actor=actor)
    with open_registry(registry_url, create=False) as registry:
        try:
            registry.check_head()
        except RegistryError as error:
            # Of an older state than was seen, which every reader refuses.
            say(f"note: {error}")
        if as_json:
            show_json(asdict(done) | {"registry": registry.shown_url, "fingerprint": registry.fingerprint})
            return
        echo(
            f"{registry.shown_url}: {done.added} badges are new, {done.changed} changed, {done.unchanged} as before"
            + (f", {done.erased} erased" if done.erased else "")
        )
        if registry.key_here is None:
            echo("it can only be read here: the authority's private key is not on this machine")
