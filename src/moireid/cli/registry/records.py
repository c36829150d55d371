"""The group `moireid registry`, and its commands on the records and the log.

init, list, show, forget        the records, and the remembered state of each registry
log, erase                      what was done and by whom; a person's data erased
revoke                          a badge counts no more
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import click

from moireid.cli.common import (
    actor_option,
    echo,
    friendly,
    json_option,
    registry_option,
    say,
    show_json,
)
from moireid.errors import SpecError
from moireid.provenance import FORGETFUL

if TYPE_CHECKING:
    from moireid.registry import Registry


@click.group("registry")
def registry_group() -> None:
    """Look after the registry of badges: list, show, revoke, audit."""


def registry_command(
    name: str,
    *options: Callable[[click.Command], click.Command],
    create: bool = False,
) -> Callable[[Callable[..., None]], click.Command]:
    """Make a command of a function whose first argument is an open registry.

    Parameters: options: those between --registry and --json in the help; create: make the registry if it is absent.
    """

    def decorate(function: Callable[..., None]) -> click.Command:
        @functools.wraps(function)
        def run(registry_url: str | None, actor: str | None = None, **given: Any) -> None:
            from moireid.registry import open_registry

            with open_registry(registry_url, create=create, actor=actor) as registry:
                try:
                    function(registry, **given)
                finally:
                    if not registry.remembered:
                        say(f"note: {FORGETFUL}")

        command = registry_group.command(name)(friendly(run))
        shared: list[Callable[[click.Command], click.Command]] = [registry_option, *options, json_option]
        for add_to in shared:
            add_to(command)
        return command

    return decorate


@registry_command("init", actor_option, create=True)
def registry_init(registry: Registry, as_json: bool) -> None:
    """Make an empty registry and its signing key.

    A registry that already exists is left as it is.
    """
    count, head, key = registry.count(), registry.head(), registry.key_here
    if as_json:
        document = {"registry": registry.shown_url, "badges": count, "fingerprint": registry.fingerprint}
        document |= {"log_key": registry.log_key}
        show_json(document | {"head": head, "key": str(key) if key else None})
        return
    echo(f"{registry.shown_url} is ready and holds {count} badges")
    echo(f"the fingerprint of its authority is {registry.fingerprint}: give it to all who check badges")
    echo(f"witnesses of its log are given the key {registry.log_key}")
    if key is not None:
        echo(f"its private key is {key}: keep a copy, and show it to no one")
    else:
        echo("its private key is not on this machine, so it can only be read and not changed")


@registry_command("list")
def registry_list(registry: Registry, as_json: bool) -> None:
    """List all people who hold a badge."""
    if as_json:
        show_json({"registry": registry.shown_url, "badges": [record.summary() for record in registry.records()]})
        return
    for record in registry.records():
        barred = record.barred()
        state = f"  revoked {barred.at}" if barred else ""
        line = f", {record.line}" if record.line else ""
        echo(f"{record.id}  {record.issued_at}  {record.name}{line}{state}")


@registry_command("show")
@click.argument("claim", metavar="NAME|ID")
def registry_show(registry: Registry, claim: str, as_json: bool) -> None:
    """Show one person's record.

    Give the name exactly as it was entered, or the badge's id.
    """
    import json

    record, fingerprint = registry.find(claim), registry.fingerprint
    if as_json:
        document = record.summary() | {"fingerprint": fingerprint, "badge": json.loads(record.badge.to_json())}
        measured = None if record.as_built is None else json.loads(record.as_built)
        figures = {"as_built_at": record.as_built_at, "as_built_reason": record.as_built_reason, "as_built": measured}
        show_json(document | figures | {"as_built_earlier": record.earlier_figures})
        return
    echo(f"{record.name} holds badge {record.id} since {record.issued_at}")
    if record.revoked_at is not None:
        echo(f"revoked on {record.revoked_at}: {record.revoked_reason}")
    if record.as_built is not None:
        why = f": {record.as_built_reason}" if record.as_built_reason else ""
        how = ", seen in a live check" if json.loads(record.as_built).get("witnessed") else ""
        echo(f"measured as built on {record.as_built_at}{how}{why}")
    for one in reversed(record.earlier_figures):
        why = f": {one['as_built_reason']}" if one["as_built_reason"] else ""
        echo(f"earlier figures of {one['as_built_at']}, which count too{why}")
    echo(f"signed by authority {fingerprint}")


@registry_group.command("forget")
@click.argument("fingerprint", metavar="FINGERPRINT")
@json_option
@friendly
def registry_forget(fingerprint: str, as_json: bool) -> None:
    """Forget how far a registry had grown.

    Moireid remembers the last state of each registry that it has seen, and refuses an older one. If those who run the
    registry had to put an older state back, for example after a broken disk, this accepts the next state that is seen.

    What was done after that state is lost, above all revocations: enter it again.
    """
    from moireid.registry.keys import as_fingerprint
    from moireid.registry.seen import forget, recall

    wanted = as_fingerprint(fingerprint)
    last = recall()[1].get(wanted)
    gone = forget(wanted)
    if as_json:
        show_json({"fingerprint": wanted, "forgotten": gone, "seen": None if last is None else str(last)})
    elif last is None:
        echo(f"authority {wanted} was never seen")
    else:
        echo(
            f"what was seen of authority {wanted}, {last.seq} entries, is forgotten; what an older state lacks of them "
            "is lost, above all each revocation: enter it again"
        )


@registry_command("log")
@click.argument("claim", metavar="[NAME|ID]", required=False)
@click.option(
    "--limit",
    type=click.IntRange(1),
    default=50,
    show_default=True,
    metavar="NUMBER",
    help="How many entries at most, the newest first.",
)
def registry_log(registry: Registry, claim: str | None, limit: int, as_json: bool) -> None:
    """Show what was done, when, and by whom.

    With NAME or ID, only what was done to that badge. `moireid registry audit` checks whether the log is sound.
    """
    entries, shown = registry.entries(claim, limit), registry.shown_url
    if as_json:
        show_json({"registry": shown, "entries": entries})
        return
    for entry in entries:
        echo("{seq:>6}  {time}  {action:<11}  {subject}  {actor}".format_map(entry))


@registry_command("erase", actor_option)
@click.argument("claim", metavar="NAME|ID")
@click.option("--yes", "sure", is_flag=True, help="Do it. Without this nothing is erased, as it cannot be taken back.")
def registry_erase(registry: Registry, claim: str, sure: bool, as_json: bool) -> None:
    """Erase a person's data on their wish, for good.

    Name, badge and figures are deleted; the badge is no longer valid, and its identity is never issued again. The log
    keeps that identity, which is a random number, and an entry that says when it was erased. It stays sound, and
    earlier checkpoints still hold.

    What this cannot reach: copies, backups and exports of the registry, bundles that others fetched before, and files
    of the badge itself.
    """
    if not sure:
        raise SpecError(f"erasing {claim[:80]!r} cannot be taken back, so nothing was done; add --yes if you mean it")
    entry, cleaned = registry.erase(claim)
    shown = registry.shown_url
    if as_json:
        show_json({"registry": shown, "subject": entry["subject"], "erased_at": entry["time"], "cleaned": cleaned})
    else:
        echo(f"the holder of badge {entry['subject']} is erased from {shown} since {entry['time']}")
    if not cleaned:
        say(
            "note: the database could not be written anew, so parts of it that are not in use may still hold the data; "
            "close what else uses it, make room on the disk, and give the same command again with the id"
        )


@registry_command("revoke", actor_option)
@click.argument("claim", metavar="NAME|ID")
@click.option(
    "--reason", required=True, metavar="TEXT", help="Why, on one line. Everyone who verifies the badge sees it."
)
def registry_revoke(registry: Registry, claim: str, reason: str, as_json: bool) -> None:
    """Revoke one person's badge, for good.

    Every later verification rejects it, of older films too, as a film's date can be forged. Give the name exactly as it
    was entered, or the badge's id.
    """
    record = registry.revoke(claim, reason)
    if as_json:
        show_json(record.summary() | {"registry": registry.shown_url})
    else:
        echo(f"badge {record.id} of {record.name} is revoked since {record.revoked_at}")
