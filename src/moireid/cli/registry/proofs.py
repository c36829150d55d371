"""registry prove, check-proof: a badge in the log, for somebody without the registry."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import NoReturn

import click

from moireid.cli.common import (
    REJECT,
    fail,
    friendly,
    json_option,
    overwrite_option,
    registry_option,
    show_json,
)
from moireid.cli.registry.records import registry_group

#: A proof holds a record without its badge file, and one hash for each doubling of the log.
LONGEST = 1 << 20


@registry_group.command("prove")
@click.argument("claim", metavar="NAME|ID")
@click.option(
    "--out", "path", required=True, type=click.Path(path_type=Path, dir_okay=False), help="Write the proof here."
)
@registry_option
@overwrite_option
@json_option
@friendly
def registry_prove(claim: str, path: Path, registry_url: str | None, overwrite: bool, as_json: bool) -> None:
    """Prove to others that a badge is in the log.

    The proof holds the newest record of one badge, and leads from it to a checkpoint that is signed now. Whoever keeps
    the checkpoint can show later what the registry said on that day.

    It names the badge's identity, by which the badge can be printed: give it to those only who may know it.
    """
    from moireid.files import planned, whole_file
    from moireid.registry import open_registry
    from moireid.registry.url import own_file

    planned([path], overwrite=overwrite, kept=[own_file(registry_url)])
    with open_registry(registry_url, create=False) as registry:
        registry.standing(registry.fingerprint)
        record = registry.find(claim)
        proof, fingerprint = registry.prove(record), registry.fingerprint
    with whole_file(path, private=True) as temporary:
        temporary.write_text(proof, encoding="utf-8")
    if as_json:
        show_json({"file": str(path), "id": record.id, "name": record.name, "fingerprint": fingerprint})
    else:
        click.echo(f"{path}: badge {record.id} of {record.name}, signed by {fingerprint}")


@registry_group.command("check-proof")
@click.argument("path", metavar="FILE", type=click.Path(path_type=Path))
@click.option(
    "--trust",
    metavar="FINGERPRINT",
    help="The fingerprint of the registry's authority, as those who run it told you. Without it, nobody says whose "
    "registry it is.",
)
@json_option
@friendly
def registry_check_proof(path: Path, trust: str | None, as_json: bool) -> None:
    """Check a proof: was this badge in the log?

    FILE is what `moireid registry prove` wrote. No registry and no network are needed.

    A proof says what was entered. It cannot say that nothing came later, such as a revocation.

    Exit code 0: it holds; 1: it does not; 2: bad input.
    """
    from moireid.registry.checkpoints.proof import check_proof
    from moireid.registry.checkpoints.standing import as_fingerprint
    from moireid.registry.record import Fault

    wanted = None if trust is None else as_fingerprint(trust)
    try:
        with path.open("rb") as stream:
            text = stream.read(LONGEST).decode("utf-8", errors="replace")
    except OSError as error:
        fail(f"proof {path} cannot be read ({error.strerror}); check its name and rights")
    try:
        found = check_proof(text, str(path))
        signed_by = found.checkpoint.fingerprint
        if wanted is not None and wanted != signed_by:
            raise Fault("authority", f"it is signed by authority {signed_by}, and not by {wanted}, the trusted one")
    except Fault as fault:
        _tell_fault(fault.code, fault.text, as_json=as_json)
    revoked = None if found.revoked_at is None else {"at": found.revoked_at, "reason": found.revoked_reason}
    suspended = None if found.suspended_at is None else {"at": found.suspended_at, "reason": found.suspended_reason}
    if as_json:
        badge = {
            "id": found.badge_id,
            "name": found.name,
            "revoked": revoked,
            "suspended": suspended,
            "expires": found.expires,
        }
        log = {"entry": found.entry, "at": found.at, "size": found.checkpoint.size, "checkpoint": found.checkpoint.date}
        show_json({"holds": True, "badge": badge, "log": log, "fingerprint": signed_by, "trusted": wanted is not None})
        return
    state = "" if revoked is None else f"; it was revoked on {found.revoked_at}: {found.revoked_reason}"
    if revoked is None and suspended is not None:
        state = f"; it was suspended on {found.suspended_at}: {found.suspended_reason}"
    if found.expires is not None:
        state += f"; it counts until the end of {found.expires}"
    click.echo(f"HOLDS: badge {found.badge_id} of {found.name} was in the log on {found.checkpoint.date}{state}")
    click.echo(f"  log: entry {found.entry} of {found.checkpoint.size}, made on {found.at}")
    told = "the one that you trust" if wanted else "whose that is, only those who run it can tell you (--trust)"
    click.echo(f"  authority: {signed_by}, {told}")
    click.echo("  What came later, such as a revocation, is not in it.")


def _tell_fault(code: str, text: str, *, as_json: bool) -> NoReturn:
    """Say what does not hold, and leave."""
    if as_json:
        show_json({"holds": False, "code": code, "text": text})
    else:
        click.echo(f"DOES NOT HOLD: {text}")
    sys.exit(REJECT)
