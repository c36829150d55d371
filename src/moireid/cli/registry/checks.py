"""registry audit, checkpoint, publish: checks of the registry, and files for others to check.

audit checks signatures and log, checkpoint signs their present state, and publish writes a bundle for verifying
offline.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import click

from moireid.cli.common import (
    ACCEPT,
    REJECT,
    FiniteRange,
    overwrite_option,
    progress_bar,
)
from moireid.cli.registry.records import Answer, registry_command
from moireid.cli.witness_options import witness_option
from moireid.errors import SpecError

if TYPE_CHECKING:
    from moireid.registry import Registry

#: The most findings that the audit prints for people; --json holds more.
SHOWN = 20


def _out_option(what: str) -> Callable[[Callable[..., Answer]], Callable[..., Answer]]:
    path = click.Path(path_type=Path, dir_okay=False)
    return click.option("--out", "path", required=True, type=path, help=f"Write the {what} here.")


@registry_command("audit")
@click.option(
    "--since",
    "kept",
    type=click.Path(path_type=Path),
    multiple=True,
    help="A checkpoint that somebody else kept. The log must still begin as it says. May be given several times.",
)
@witness_option
def registry_audit(
    registry: Registry,
    kept: tuple[Path, ...],
    witness_keys: tuple[str, ...],
) -> Answer:
    """Check every signature and the whole log.

    The log must go on from the last state of it that you have seen here. Of what you have not seen, a registry cannot
    show by itself that an earlier state was put back: that state was sound too. Somebody else must have kept a
    checkpoint (`moireid registry checkpoint`). Give it as --since: this proves that the log was not shortened, replaced
    or rewritten since then.

    With --witness-key, all witnesses must have signed one of the checkpoints of --since.

    Exit code 0: sound; 1: something is wrong; 2: bad input.
    """
    from moireid.registry.checkpoints.checkpoint import read_checkpoint
    from moireid.registry.checkpoints.cosignature import witness_keys as read_keys

    witnesses = read_keys(witness_keys)
    if witnesses and not kept:
        raise SpecError("--witness-key needs what the witnesses signed; add --since FILE")
    with progress_bar("checking the registry") as progress:
        seen, shown = registry.audit(progress, list(map(read_checkpoint, kept)), witnesses), registry.shown_url
    lines = [
        f"{shown} is {'sound' if seen.sound else 'NOT SOUND'}",
        f"{seen.records} badges, {seen.revoked} revoked, {seen.entries} entries, authority {seen.fingerprint}"
        + (f", {seen.erased} erased" if seen.erased else ""),
        *(f"  ✗ {finding.text}" for finding in seen.findings[:SHOWN]),
    ]
    if seen.found > SHOWN:
        lines.append(f"  and {seen.found - SHOWN} more")
    if seen.witnessed is not None:
        signers = ", ".join(f"{name} on {at}" for name, at in seen.witnessed["signers"].items())
        lines.append(f"witnesses have seen {seen.witnessed['size']} of {seen.entries} entries: {signers}")
    lines.append(f"head: {seen.head or 'none that can be trusted'}")
    return lambda: seen.to_json() | {"registry": shown}, lines, ACCEPT if seen.sound else REJECT


@registry_command("checkpoint", overwrite_option)
@_out_option("checkpoint")
@click.option(
    "--since",
    "earlier",
    type=click.Path(path_type=Path),
    help="An earlier checkpoint: --json then also proves that the new one only adds to it.",
)
def registry_checkpoint(registry: Registry, path: Path, earlier: Path | None, overwrite: bool) -> Answer:
    """Write a signed checkpoint of the log for others to keep.

    It is the length of the log and one hash of all in it, and holds no names. Give it to others, as often as you can:
    to a partner, to a web server, to a folder that you cannot change. `moireid registry audit --since FILE` then shows
    whether anything was taken back.

    The format is that of transparency logs (C2SP tlog-checkpoint), so their witnesses can sign it too: each adds a line
    to the file, and readers ask for these by --witness-key.
    """
    from moireid.files import planned, write_text
    from moireid.registry.checkpoints.checkpoint import read_checkpoint

    planned([path], overwrite=overwrite, kept=[registry.file, earlier])
    older = read_checkpoint(earlier) if earlier else None
    made, proof = registry.checkpoint(older)
    write_text(path, made.note)
    document = {"registry": registry.shown_url, "file": str(path), "fingerprint": made.fingerprint}
    state = {"size": made.head.seq, "root": made.head.hash, "date": made.date}
    steps = [{"size": older.head.seq, "proof": [step.hex() for step in proof]}] if older else []
    line = f"{path}: {made.head.seq} entries, signed by {made.fingerprint} on {made.date}"
    return lambda: document | state | {"consistent_with": steps}, [line]


@registry_command("publish", overwrite_option)
@_out_option("bundle")
@click.option(
    "--days",
    type=FiniteRange(0.01, 400),
    default=7.0,
    metavar="NUMBER",
    help="After so many days it counts no more: so long a revocation may stay unknown to those who fetch it.",
)
@click.option(
    "--checkpoint",
    "source",
    type=click.Path(path_type=Path),
    help="The checkpoint of the log as it is now, with the lines that witnesses added; without it, one is signed now.",
)
def registry_publish(registry: Registry, path: Path, days: float, source: Path | None, overwrite: bool) -> Answer:
    """Write a trust bundle, for verifying offline.

    It is one signed file for any web server. It holds names and the lines below them, such as what each person
    does, revocations with their reasons, layouts, and a checkpoint. It holds no badge files, and identities only
    sealed: no badge can be printed from it.

    Those who fetch it run `moireid verify FILM --claim NAME --bundle FILE --trust FINGERPRINT`. If witnesses signed the
    checkpoint in it, they can ask for that by --witness-key.
    """
    from moireid.idcodes import specimen_of
    from moireid.registry.checkpoints.checkpoint import read_checkpoint

    kept = None if source is None else read_checkpoint(source)
    with progress_bar("sealing identities") as progress:
        people, expires = registry.publish(
            path, specimen_of, days=days, overwrite=overwrite, progress=progress, checkpoint=kept
        )
    own = registry.fingerprint
    document = {"file": str(path), "people": people, "head": registry.head(), "expires": expires, "fingerprint": own}
    held = "1 person" if people == 1 else f"{people} people"
    return lambda: document, [f"{path}: {held}, counts until {expires}, signed by {own}"]
