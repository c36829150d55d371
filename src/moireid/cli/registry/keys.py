"""registry rotate-key, signer: a new key, and the key in a process of its own."""

from __future__ import annotations

import contextlib
import os
from pathlib import Path

import click

from moireid.cli.common import friendly, json_option, progress_bar, registry_option, say, show_json
from moireid.cli.registry.records import registry_group
from moireid.errors import SpecError


@registry_group.command("rotate-key")
@registry_option
@json_option
@friendly
def registry_rotate_key(registry_url: str | None, as_json: bool) -> None:
    """Give the registry a new signing key.

    The old key signs one last log entry, and the new one signs it too. Whoever has trusted the old fingerprint, or has
    seen it here, follows to the new one by that. All records are signed anew.

    Do it when those who could reach the key leave, or by a calendar. If the old key was stolen, its thief could do the
    same: then tell everybody the new fingerprint yourself, and the checkpoint of the change.
    """
    from moireid.registry import open_registry

    with open_registry(registry_url, create=False) as registry:
        registry.check_head()
        with progress_bar("signing all records anew") as progress:
            done = registry.rotate_key(progress)
        key, shown = registry.key_path, registry.shown_url
    if as_json:
        document = {"registry": shown, "old_fingerprint": done.old, "fingerprint": done.new}
        show_json(document | {"records": done.records, "head": done.head, "key": str(key) if key.exists() else None})
        return
    click.echo(f"{shown} is signed by {done.new} from now on, and no longer by {done.old}")
    click.echo(f"{done.records} records are signed anew; the change is log entry {done.head.split(':')[0]}")
    click.echo("make a checkpoint and give it to others: it shows that the change was yours")
    if key.exists():
        click.echo(f"the new private key is {key}: keep a copy; that of {done.old} signs nothing here any more")


@registry_group.command("signer")
@click.option(
    "--socket",
    "path",
    required=True,
    type=click.Path(path_type=Path),
    help="Listen here; other programs find it by MOIREID_SIGNER.",
)
@click.option("--group", metavar="NAME", help="Members of this group of the system may ask, too; default: you alone.")
@friendly
def registry_signer(path: Path, group: str | None) -> None:
    """Sign for other programs, so that only this one reads the private key.

    Run it as a user of its own who alone can read the keys folder (MOIREID_KEYS). Give the others, such as the studio,
    MOIREID_SIGNER=SOCKET: they ask for each signature, and never see the key. It signs records, log entries,
    checkpoints and bundles, and nothing else.

    Stop it with Ctrl-C.
    """
    if os.name == "nt":
        raise SpecError("no signer runs on Windows, which lacks its kind of sockets; run it on Linux or macOS")
    from moireid.registry.signing.process import serve

    with contextlib.suppress(KeyboardInterrupt):
        serve(path.absolute(), group, ready=lambda: say(f"signing for those who ask at {path}  (stop it with Ctrl-C)"))
