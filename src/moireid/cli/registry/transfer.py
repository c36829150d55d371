"""registry export, import: a registry to a JSON file, and back."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from moireid.cli.common import (
    actor_option,
    friendly,
    json_option,
    overwrite_option,
    progress_bar,
    registry_option,
    say,
    show_json,
)
from moireid.cli.registry.records import registry_group

if TYPE_CHECKING:
    from moireid.registry import Import


@registry_group.command("export")
@click.argument("path", type=click.Path(path_type=Path, dir_okay=False))
@registry_option
@overwrite_option
@json_option
@friendly
def registry_export(path: Path, registry_url: str | None, overwrite: bool, as_json: bool) -> None:
    """Write the records, the log and the public key to a JSON file."""
    from moireid.registry import open_registry

    with open_registry(registry_url, create=False) as registry, progress_bar("exporting") as progress:
        count = registry.export_json(path, overwrite=overwrite, progress=progress)
        if as_json:
            show_json({"registry": registry.shown_url, "badges": count, "file": str(path)})
        else:
            click.echo(f"{count} badges of {registry.shown_url} are in {path}")


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
    for note in done.notes:
        say(f"note: {note}")
    with open_registry(registry_url, create=False) as registry:
        if as_json:
            show_json(_import_json(done) | {"registry": registry.shown_url, "fingerprint": registry.fingerprint})
            return
        click.echo(
            f"{registry.shown_url}: {done.added} badges are new, {done.changed} changed, {done.unchanged} as before"
            + (f", {done.erased} erased" if done.erased else "")
        )
        if not registry.key_path.exists():
            click.echo(f"it can only be read here: the authority's private key is not at {registry.key_path}")


def _import_json(done: Import) -> dict[str, Any]:
    return {"added": done.added, "changed": done.changed, "unchanged": done.unchanged} | {
        "erased": done.erased,
        "notes": list(done.notes),
    }
