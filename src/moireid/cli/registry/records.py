"""The group `moireid registry`, and its commands on the records and the log.

init, list, show, forget        the records, and the remembered state of each registry
log, erase                      what was done and by whom; a person's data erased
revoke                          a badge counts no more
"""

from __future__ import annotations

import functools
import sys
from collections.abc import Callable, Iterable
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
    from moireid.registry import Record, Registry


#: What a command prints: the JSON object, made if it is asked for, and the lines for people; and its exit code, if any.
Answer = tuple[Callable[[], dict[str, Any]], Iterable[str]] | tuple[Callable[[], dict[str, Any]], Iterable[str], int]


@click.group("registry")
def registry_group() -> None:
    """Look after the registry of badges: list, show, revoke, audit."""


def registry_command(
    name: str,
    *options: Callable[[click.Command], click.Command],
    create: bool = False,
) -> Callable[[Callable[..., Answer]], click.Command]:
    """Make a command of a function whose first argument is an open registry, and which returns what is to be printed.

    Parameters: options: those between --registry and --json in the help; create: make the registry if it is absent.
    """

    def decorate(function: Callable[..., Answer]) -> click.Command:
        @functools.wraps(function)
        def run(registry_url: str | None, *, as_json: bool, actor: str | None = None, **given: Any) -> None:
            from moireid.registry import open_registry

            with open_registry(registry_url, create=create, actor=actor) as registry:
                try:
                    document, lines, *code = function(registry, **given)
                    if as_json:
                        show_json(document())
                    else:
                        for line in lines:
                            echo(line)
                    if code:
                        sys.exit(code[0])
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
def registry_init(registry: Registry) -> Answer:
    """Make an empty registry and its signing key.

    A registry that already exists is left as it is.
    """
    count, head, key = registry.count(), registry.head(), registry.key_here
    document = {"registry": registry.shown_url, "badges": count, "fingerprint": registry.fingerprint}
    document |= {"log_key": registry.log_key, "head": head, "key": str(key) if key else None}
    there = f"{key}: keep a copy, and show it to no one"
    return lambda: document, [
        f"{registry.shown_url} is ready and holds {count} badges",
        f"the fingerprint of its authority is {registry.fingerprint}: give it to all who check badges",
        f"witnesses of its log are given the key {registry.log_key}",
        f"its private key is {there if key else 'not on this machine, so it can only be read and not changed'}",
    ]


@registry_command("list")
def registry_list(registry: Registry) -> Answer:
    """List all people who hold a badge."""

    def row(record: Record) -> str:
        state = f"  revoked {record.revoked_at}" if record.barred() else ""
        line = f", {record.line}" if record.line else ""
        return f"{record.id}  {record.issued_at}  {record.name}{line}{state}"

    records = registry.records()
    return lambda: {"registry": registry.shown_url, "badges": [one.summary() for one in records]}, map(row, records)


@registry_command("show")
@click.argument("claim", metavar="NAME|ID")
def registry_show(registry: Registry, claim: str) -> Answer:
    """Show one person's record.

    Give the name exactly as it was entered, or the badge's id.
    """
    import json

    record, fingerprint = registry.find(claim), registry.fingerprint
    registry.check_newest(record)
    measured = None if record.as_built is None else json.loads(record.as_built)
    document = record.summary() | {"fingerprint": fingerprint, "badge": json.loads(record.badge.to_json())}
    document |= {"as_built_at": record.as_built_at, "as_built_reason": record.as_built_reason, "as_built": measured}
    document |= {"as_built_earlier": record.earlier_figures}
    lines = [f"{record.name} holds badge {record.id} since {record.issued_at}"]
    if record.revoked_at is not None:
        lines.append(f"revoked on {record.revoked_at}: {record.revoked_reason}")
    if measured is not None:
        why = f": {record.as_built_reason}" if record.as_built_reason else ""
        how = ", seen in a live check" if measured.get("witnessed") else ""
        lines.append(f"measured as built on {record.as_built_at}{how}{why}")
    for one in reversed(record.earlier_figures):
        why = f": {one['as_built_reason']}" if one["as_built_reason"] else ""
        lines.append(f"earlier figures of {one['as_built_at']}, which count too{why}")
    return lambda: document, [*lines, f"signed by authority {fingerprint}"]


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
    from moireid.registry.seen import forget

    wanted = as_fingerprint(fingerprint)
    last = forget(wanted)
    if as_json:
        seen = None if last is None else str(last)
        show_json({"fingerprint": wanted, "forgotten": last is not None, "seen": seen})
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
    metavar="NUMBER",
    help="How many entries at most, the newest first.",
)
def registry_log(registry: Registry, claim: str | None, limit: int) -> Answer:
    """Show what was done, when, and by whom.

    With NAME or ID, only what was done to that badge. `moireid registry audit` checks whether the log is sound.
    """
    entries = registry.entries(claim, limit)
    lines = map("{seq:>6}  {time}  {action:<11}  {subject}  {actor}".format_map, entries)
    return lambda: {"registry": registry.shown_url, "entries": entries}, lines


@registry_command("erase", actor_option)
@click.argument("claim", metavar="NAME|ID")
@click.option("--yes", "sure", is_flag=True, help="Do it. Without this nothing is erased, as it cannot be taken back.")
def registry_erase(registry: Registry, claim: str, sure: bool) -> Answer:
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
    if not cleaned:
        say(
            "note: the database could not be written anew, so parts of it that are not in use may still hold the data; "
            "close what else uses it, make room on the disk, and give the same command again with the id"
        )
    shown, subject, at = registry.shown_url, entry["subject"], entry["time"]
    document = {"registry": shown, "subject": subject, "erased_at": at, "cleaned": cleaned}
    return lambda: document, [f"the holder of badge {subject} is erased from {shown} since {at}"]


@registry_command("revoke", actor_option)
@click.argument("claim", metavar="NAME|ID")
@click.option(
    "--reason", required=True, metavar="TEXT", help="Why, on one line. Everyone who verifies the badge sees it."
)
def registry_revoke(registry: Registry, claim: str, reason: str) -> Answer:
    """Revoke one person's badge, for good.

    Every later verification rejects it, of older films too, as a film's date can be forged. Give the name exactly as it
    was entered, or the badge's id.
    """
    record = registry.revoke(claim, reason)
    line = f"badge {record.id} of {record.name} is revoked since {record.revoked_at}"
    return lambda: record.summary() | {"registry": registry.shown_url}, [line]
