"""enroll and registry: who was issued which badge."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

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
    say,
    show_json,
)
from moireid.errors import SpecError

if TYPE_CHECKING:
    from moireid.badge import Badge
    from moireid.registry import Import

#: Findings that the audit prints for people; --json holds more.
SHOWN = 20


@click.command("enroll")
@click.argument("badge_json", type=click.Path(path_type=Path))
@registry_option
@click.option(
    "--capture",
    "captures",
    type=click.Path(path_type=Path),
    multiple=True,
    help="A film of the finished badge, moved sideways, to measure it by. May be given several times.",
)
@click.option(
    "--measured-scale",
    type=FiniteRange(0.9, 1.1),
    metavar="X",
    help="Length of the printed scale bar by a ruler, in mm, divided by 150; 0.9 to 1.1.",
)
@click.option(
    "--focal-px", type=FiniteRange(50, 100000), metavar="PX", help="The camera's focal length in pixels, if known."
)
@json_option
@friendly
def enroll_command(
    badge_json: Path,
    registry_url: str | None,
    captures: tuple[Path, ...],
    measured_scale: float | None,
    focal_px: float | None,
    as_json: bool,
) -> None:
    """Enter a badge into the registry of who holds which badge.

    BADGE_JSON is the badge.json that print-your-badge wrote. Entering the same badge again changes nothing.

    With --capture, the finished badge is also measured. The verifier can then tell it from a second badge that was
    printed from the same files, and it knows how far the fringes move under this very sheet: from 0.5 to 1.6 times as
    far as designed, as thin and thick sheets of one pitch are sold. Several films must agree on that.
    """
    from moireid.badge import load_badge
    from moireid.cli.issue_notes import derived_notes, look_alike_notes
    from moireid.registry import open_registry

    badge = load_badge(badge_json)
    _check_identity(badge, badge_json)
    as_built = None
    if measured_scale is not None and not captures:
        raise SpecError("--measured-scale is kept with the as-built figures; give a --capture too")
    if captures:
        from moireid.verifier.session.capture import capture_as_built

        with progress_bar("reading the captures") as progress:
            as_built = capture_as_built(
                list(captures), badge, focal_px=focal_px, measured_scale=measured_scale, progress=progress
            )
    with open_registry(registry_url, create=True) as registry:
        notes = derived_notes([badge]) + look_alike_notes([badge], registry)
        record = registry.enroll(badge)
        if as_built is not None:
            record = registry.store_as_built(record.id, as_built.to_json())
        if as_json:
            measured = {"as_built": json.loads(record.as_built)} if record.as_built else {}
            show_json(record.summary() | {"registry": registry.shown_url, "notes": notes} | measured)
        else:
            click.echo(f"{record.name} holds badge {record.id} since {record.issued_at} in {registry.shown_url}")
            if as_built is not None:
                beat = f"{as_built.beat_period_mm:.2f} mm"
                click.echo(
                    f"as built: beat {beat}, gain {as_built.gain_ratio:.3f}, measured in {as_built.captures} film(s)"
                )
        for note in notes:
            say(f"note: {note}")
        if record.revoked_at is not None:
            say(f"note: this badge was revoked on {record.revoked_at} ({record.revoked_reason}), and stays revoked")


def _check_identity(badge: Badge, source: Path) -> None:
    """Raise unless the badge has an identity, and its lines spell it."""
    from moireid.idcodes import spells_its_id

    if badge.id is None or not any(grating.code for grating in badge.gratings):
        raise SpecError(f"{source} is a board without an identity; print a badge with print-your-badge")
    if not spells_its_id(badge):
        raise SpecError(f"{source}: its lines do not spell its id {badge.id}; enroll the badge.json as it was printed")


@click.group("registry")
def registry_group() -> None:
    """Look after the registry of badges: list, show, revoke, audit."""


@registry_group.command("init")
@registry_option
@json_option
@friendly
def registry_init(registry_url: str | None, as_json: bool) -> None:
    """Make an empty registry and its signing key.

    A registry that already exists is left as it is.
    """
    from moireid.registry import open_registry

    with open_registry(registry_url, create=True) as registry:
        count, head, key = registry.count(), registry.head(), registry.key_path
        if as_json:
            document = {"registry": registry.shown_url, "badges": count, "fingerprint": registry.fingerprint}
            show_json(document | {"head": head, "key": str(key) if key.exists() else None})
            return
        click.echo(f"{registry.shown_url} is ready and holds {count} badges")
        if key.exists():
            click.echo(f"its private key is {key}: keep a copy, and show it to nobody")
        else:
            click.echo(f"its private key is not here ({key}), so it can only be read and not changed")


@registry_group.command("list")
@registry_option
@json_option
@friendly
def registry_list(registry_url: str | None, as_json: bool) -> None:
    """List all people who hold a badge."""
    from moireid.registry import open_registry

    with open_registry(registry_url, create=False) as registry:
        if as_json:
            show_json({"registry": registry.shown_url, "badges": [record.summary() for record in registry.records()]})
            return
        for record in registry.records():
            revoked = f"  revoked {record.revoked_at}" if record.revoked_at else ""
            click.echo(f"{record.id}  {record.issued_at}  {record.name}{revoked}")


@registry_group.command("show")
@click.argument("claim", metavar="NAME|ID")
@registry_option
@json_option
@friendly
def registry_show(claim: str, registry_url: str | None, as_json: bool) -> None:
    """Show one person's record.

    Give the name exactly as it was entered, or the badge's id.
    """
    import json

    from moireid.registry import open_registry

    with open_registry(registry_url, create=False) as registry:
        record, fingerprint = registry.find(claim), registry.fingerprint
    if as_json:
        document = record.summary() | {"fingerprint": fingerprint, "badge": json.loads(record.badge.to_json())}
        measured = None if record.as_built is None else json.loads(record.as_built)
        show_json(document | {"as_built_at": record.as_built_at, "as_built": measured})
        return
    click.echo(f"{record.name} holds badge {record.id} since {record.issued_at}")
    if record.revoked_at is not None:
        click.echo(f"revoked on {record.revoked_at}: {record.revoked_reason}")
    if record.as_built is not None:
        click.echo(f"measured as built on {record.as_built_at}")
    click.echo(f"signed by authority {fingerprint}")


@registry_group.command("revoke")
@click.argument("claim", metavar="NAME|ID")
@click.option(
    "--reason", required=True, metavar="TEXT", help="Why, on one line. Everyone who verifies the badge sees it."
)
@registry_option
@json_option
@friendly
def registry_revoke(claim: str, reason: str, registry_url: str | None, as_json: bool) -> None:
    """Revoke one person's badge, for good.

    Every later verification rejects it. Give the name exactly as it was entered, or the badge's id.
    """
    from moireid.registry import open_registry

    with open_registry(registry_url, create=False) as registry:
        record = registry.revoke(claim, reason)
        if as_json:
            show_json(record.summary() | {"registry": registry.shown_url})
        else:
            click.echo(f"badge {record.id} of {record.name} is revoked since {record.revoked_at}")


@registry_group.command("audit")
@click.option(
    "--expected-head", metavar="SEQ:HASH", help="The head that an earlier audit printed; the log must still contain it."
)
@registry_option
@json_option
@friendly
def registry_audit(expected_head: str | None, registry_url: str | None, as_json: bool) -> None:
    """Check every signature and the whole log.

    The audit ends with the log's head. Note it somewhere else, and give it as --expected-head next time: then nobody
    can have shortened or replaced the log in between.

    Exit code 0: sound; 1: something is wrong; 2: bad input.
    """
    from moireid.registry import open_registry

    with open_registry(registry_url, create=False) as registry, progress_bar("checking the registry") as progress:
        seen, shown = registry.audit(expected_head, progress), registry.shown_url
    if as_json:
        show_json(seen.to_json() | {"registry": shown})
    else:
        click.echo(f"{shown} is {'sound' if seen.sound else 'NOT SOUND'}")
        click.echo(
            f"{seen.records} badges, {seen.revoked} revoked, {seen.entries} entries, authority {seen.fingerprint}"
        )
        for finding in seen.findings[:SHOWN]:
            click.echo(f"  ✗ {finding.text}")
        if seen.found > SHOWN:
            click.echo(f"  and {seen.found - SHOWN} more")
        click.echo(f"head: {seen.head or 'none that can be trusted'}")
    sys.exit(ACCEPT if seen.sound else REJECT)


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
@registry_option
@json_option
@friendly
def registry_import(path: Path, registry_url: str | None, as_json: bool) -> None:
    """Read in a file that `registry export` wrote.

    Either everything is imported or nothing. The registry is made if there is none.
    """
    from moireid.registry import import_registry, open_registry

    done = import_registry(path, registry_url)
    with open_registry(registry_url, create=False) as registry:
        if as_json:
            show_json(_import_json(done) | {"registry": registry.shown_url, "fingerprint": registry.fingerprint})
            return
        click.echo(
            f"{registry.shown_url}: {done.added} badges are new, {done.changed} changed, {done.unchanged} as before"
        )
        if not registry.key_path.exists():
            click.echo(f"it can only be read here: the authority's private key is not at {registry.key_path}")


def _import_json(done: Import) -> dict[str, Any]:
    return {"added": done.added, "changed": done.changed, "unchanged": done.unchanged}
