"""registry revoke, suspend, reinstate: what is decided of a badge after its issue."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from moireid.cli.common import actor_option, friendly, json_option, registry_option, show_json
from moireid.cli.registry.records import registry_group

if TYPE_CHECKING:
    from moireid.registry import Record, Registry


@registry_group.command("revoke")
@click.argument("claim", metavar="NAME|ID")
@click.option(
    "--reason", required=True, metavar="TEXT", help="Why, on one line. Everyone who verifies the badge sees it."
)
@click.option(
    "--since",
    metavar="DATE",
    help="The day from which on it may have been in other hands, such as 2026-05-01, where you know it.",
)
@actor_option
@registry_option
@json_option
@friendly
def registry_revoke(
    claim: str, reason: str, since: str | None, actor: str | None, registry_url: str | None, as_json: bool
) -> None:
    """Revoke one person's badge, for good.

    Every later verification rejects it, of older films too, as a film's date can be forged; --since is told with it.
    Give the name exactly as it was entered, or the badge's id.
    """
    from moireid.registry import open_registry

    with open_registry(registry_url, create=False, actor=actor) as registry:
        registry.check_head()
        record = registry.revoke(claim, reason, since)
        _tell(registry, record, f"is revoked since {record.revoked_at}", as_json=as_json)


@registry_group.command("suspend")
@click.argument("claim", metavar="NAME|ID")
@click.option(
    "--reason", required=True, metavar="TEXT", help="Why, on one line. Everyone who verifies the badge sees it."
)
@actor_option
@registry_option
@json_option
@friendly
def registry_suspend(claim: str, reason: str, actor: str | None, registry_url: str | None, as_json: bool) -> None:
    """Suspend one person's badge, until it is reinstated.

    Every verification meanwhile rejects it, of older films too. Give the name exactly as it was entered, or the badge's
    id.
    """
    from moireid.registry import open_registry

    with open_registry(registry_url, create=False, actor=actor) as registry:
        registry.check_head()
        record = registry.suspend(claim, reason)
        _tell(registry, record, f"is suspended since {record.suspended_at}", as_json=as_json)


@registry_group.command("reinstate")
@click.argument("claim", metavar="NAME|ID")
@actor_option
@registry_option
@json_option
@friendly
def registry_reinstate(claim: str, actor: str | None, registry_url: str | None, as_json: bool) -> None:
    """End the suspension of one person's badge.

    A revoked badge stays revoked. Give the name exactly as it was entered, or the badge's id.
    """
    from moireid.registry import open_registry

    with open_registry(registry_url, create=False, actor=actor) as registry:
        registry.check_head()
        _tell(registry, registry.reinstate(claim), "is suspended no more", as_json=as_json)


def _tell(registry: Registry, record: Record, what: str, *, as_json: bool) -> None:
    """Say what became of a record."""
    if as_json:
        show_json(record.summary() | {"registry": registry.shown_url})
    else:
        click.echo(f"badge {record.id} of {record.name} {what}")
