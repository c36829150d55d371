"""registry init, list, show, forget: the records, and what was seen of registries."""

from __future__ import annotations

import click

from moireid.cli.common import actor_option, friendly, json_option, registry_option, show_json


@click.group("registry")
def registry_group() -> None:
    """Look after the registry of badges: list, show, suspend, revoke, audit."""


@registry_group.command("init")
@actor_option
@registry_option
@json_option
@friendly
def registry_init(actor: str | None, registry_url: str | None, as_json: bool) -> None:
    """Make an empty registry and its signing key.

    A registry that already exists is left as it is.
    """
    from moireid.registry import open_registry
    from moireid.registry.signing.client import signer_address

    with open_registry(registry_url, create=True, actor=actor) as registry:
        count, head, key = registry.count(), registry.head(), registry.key_path
        if as_json:
            document = {"registry": registry.shown_url, "badges": count, "fingerprint": registry.fingerprint}
            show_json(document | {"head": head, "key": str(key) if key.exists() else None, "signer": signer_address()})
            return
        click.echo(f"{registry.shown_url} is ready and holds {count} badges")
        click.echo(f"the fingerprint of its authority is {registry.fingerprint}: tell it to whoever checks badges")
        if (signer := signer_address()) is not None:
            click.echo(f"its private key is with the signer at {signer}: have a copy kept there")
        elif key.exists():
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
            barred = record.barred()
            state = f"  {barred.code} {barred.at}" if barred else ""
            line = f", {record.line}" if record.line else ""
            click.echo(f"{record.id}  {record.issued_at}  {record.name}{line}{state}")


@registry_group.command("show")
@click.argument("claim", metavar="NAME|ID")
@registry_option
@json_option
@friendly
def registry_show(claim: str, registry_url: str | None, as_json: bool) -> None:
    """Show one person's record.

    Give the name exactly as it was entered, or the badge's id. Of people of one name, give "NAME, LINE" with the line
    below it.
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
        since = f", compromised since {record.compromised_since}" if record.compromised_since else ""
        click.echo(f"revoked on {record.revoked_at}{since}: {record.revoked_reason}")
    elif record.suspended_at is not None:
        click.echo(f"suspended on {record.suspended_at}: {record.suspended_reason}")
    if record.expires is not None:
        over = (barred := record.barred()) is not None and barred.code == "expired"
        click.echo(f"expired on {record.expires}" if over else f"counts until the end of {record.expires}")
    if record.as_built is not None:
        click.echo(f"measured as built on {record.as_built_at}")
    click.echo(f"signed by authority {fingerprint}")


@registry_group.command("forget")
@click.argument("fingerprint", metavar="FINGERPRINT")
@json_option
@friendly
def registry_forget(fingerprint: str, as_json: bool) -> None:
    """Forget how far a registry had grown.

    Moireid remembers the last state of each registry that it has seen, and refuses an older one. If those who run the
    registry had to put an older state back, for example after a broken disk, this accepts it once.
    """
    from moireid.registry.checkpoints.seen import forget
    from moireid.registry.checkpoints.standing import as_fingerprint

    wanted = as_fingerprint(fingerprint)
    gone = forget(wanted)
    if as_json:
        show_json({"fingerprint": wanted, "forgotten": gone})
    else:
        click.echo(
            f"what was seen of authority {wanted} is forgotten" if gone else f"authority {wanted} was never seen"
        )
