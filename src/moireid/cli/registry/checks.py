"""registry audit, checkpoint, publish: does everything hold, and did it before?"""

from __future__ import annotations

import sys
from pathlib import Path

import click

from moireid.cli.common import (
    ACCEPT,
    REJECT,
    FiniteRange,
    friendly,
    json_option,
    overwrite_option,
    progress_bar,
    registry_option,
    show_json,
)
from moireid.cli.registry.records import registry_group

#: Findings that the audit prints for people; --json holds more.
SHOWN = 20


@registry_group.command("audit")
@click.option(
    "--expected-head", metavar="SEQ:HASH", help="The head that an earlier audit printed; the log must still contain it."
)
@click.option(
    "--since",
    "witnesses",
    metavar="FILE",
    multiple=True,
    help="A checkpoint that somebody else kept: a file, a folder of them, or a web address. The log must still begin "
    "as it says. May be given several times.",
)
@registry_option
@json_option
@friendly
def registry_audit(
    expected_head: str | None, witnesses: tuple[str, ...], registry_url: str | None, as_json: bool
) -> None:
    """Check every signature and the whole log.

    By itself a registry cannot show that an earlier state of it was put back: that state was sound too. Somebody else
    must have kept a checkpoint (`moireid registry checkpoint`). Give it as --since: then nobody can have shortened,
    replaced or rewritten the log in between.

    The head that the audit ends with does the same, noted somewhere else and given as --expected-head.

    Exit code 0: sound; 1: something is wrong; 2: bad input.
    """
    from moireid.registry import open_registry
    from moireid.registry.checkpoints.witness import checkpoints_from

    with open_registry(registry_url, create=False) as registry, progress_bar("checking the registry") as progress:
        since = [one for source in witnesses for one in checkpoints_from(source)]
        seen, shown = registry.audit(expected_head, progress, since), registry.shown_url
    if as_json:
        show_json(seen.to_json() | {"registry": shown})
    else:
        click.echo(f"{shown} is {'sound' if seen.sound else 'NOT SOUND'}")
        click.echo(
            f"{seen.records} badges, {seen.revoked} revoked, {seen.entries} entries, authority {seen.fingerprint}"
            + (f", {seen.erased} erased" if seen.erased else "")
        )
        for name, entries in sorted(seen.actors.items(), key=lambda pair: -pair[1])[:SHOWN]:
            click.echo(f"  {entries} entries by {name}")
        if seen.unnamed:
            click.echo(f"  {seen.unnamed} entries by nobody who is named (erased, or of an older version)")
        for finding in seen.findings[:SHOWN]:
            click.echo(f"  ✗ {finding.text}")
        if seen.found > SHOWN:
            click.echo(f"  and {seen.found - SHOWN} more")
        click.echo(f"head: {seen.head or 'none that can be trusted'}")
    sys.exit(ACCEPT if seen.sound else REJECT)


@registry_group.command("checkpoint")
@click.option(
    "--out", "path", required=True, type=click.Path(path_type=Path, dir_okay=False), help="Write the checkpoint here."
)
@click.option(
    "--since",
    "witness",
    metavar="FILE",
    help="An earlier checkpoint: --json then also proves that the new one only adds to it.",
)
@registry_option
@overwrite_option
@json_option
@friendly
def registry_checkpoint(
    path: Path, witness: str | None, registry_url: str | None, overwrite: bool, as_json: bool
) -> None:
    """Write a signed checkpoint of the log for others to keep.

    It is the length of the log and one hash of all in it, and holds no names. Give it to others, as often as you can:
    to a partner, to a web server, to a folder that you cannot change. `moireid registry audit --since FILE` then shows
    whether anything was taken back.

    The format is that of transparency logs (C2SP tlog-checkpoint), so their witnesses can sign it too.
    """
    from moireid.files import planned, write_text
    from moireid.registry import open_registry
    from moireid.registry.checkpoints.witness import checkpoints_from
    from moireid.registry.url import own_file

    planned([path], overwrite=overwrite, kept=[own_file(registry_url), Path(witness) if witness else None])
    with open_registry(registry_url, create=False) as registry:
        older = checkpoints_from(witness) if witness else []
        made, proofs = registry.checkpoint(older)
        write_text(path, made.note)
        if as_json:
            document = {"registry": registry.shown_url, "file": str(path), "fingerprint": made.fingerprint}
            state = {"size": made.size, "root": made.root.hex(), "date": made.date}
            steps = [{"size": size, "proof": [step.hex() for step in proof]} for size, proof in proofs]
            show_json(document | state | {"consistent_with": steps})
        else:
            click.echo(f"{path}: {made.size} entries, signed by {made.fingerprint} on {made.date}")


@registry_group.command("publish")
@click.option(
    "--out", "path", required=True, type=click.Path(path_type=Path, dir_okay=False), help="Write the bundle here."
)
@click.option(
    "--days",
    type=FiniteRange(0.01, 400),
    default=7.0,
    show_default=True,
    metavar="NUMBER",
    help="After so many days it counts no more: so long a revocation may stay unknown to those who fetch it.",
)
@registry_option
@overwrite_option
@json_option
@friendly
def registry_publish(path: Path, days: float, registry_url: str | None, overwrite: bool, as_json: bool) -> None:
    """Write a trust bundle, for verifying offline.

    It is one signed file for any web server. It holds names and the lines below them, such as what each person
    does, revocations with their reasons, layouts, and a checkpoint. It holds no badge files, and identities only
    sealed: nobody can print a badge from it.

    Whoever fetches it runs `moireid verify FILM --claim NAME --bundle FILE --trust FINGERPRINT`.
    """
    from moireid.idcodes import specimen_of
    from moireid.registry import open_registry

    with open_registry(registry_url, create=False) as registry, progress_bar("sealing identities") as progress:
        made = registry.publish(path, specimen_of, days=days, overwrite=overwrite, progress=progress)
        fingerprint = registry.fingerprint
    if as_json:
        document = {"file": str(path), "people": made.people, "head": made.head, "expires": made.expires}
        show_json(document | {"fingerprint": fingerprint})
    else:
        click.echo(f"{path}: {made.people} people, counts until {made.expires}, signed by {fingerprint}")
