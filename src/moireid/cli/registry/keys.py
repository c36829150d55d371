"""registry signer: the private key in a process of its own."""

from __future__ import annotations

import contextlib
import os
from pathlib import Path

import click

from moireid.cli.common import friendly, say
from moireid.cli.registry.records import registry_group
from moireid.errors import SpecError


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
