"""registry log, erase: what was done and by whom, and a person's data taken out."""

from __future__ import annotations

import click

from moireid.cli.common import actor_option, friendly, json_option, registry_option, say, show_json
from moireid.cli.registry.records import registry_group
from moireid.errors import SpecError


@registry_group.command("log")
@click.argument("claim", metavar="[NAME|ID]", required=False)
@click.option(
    "--limit",
    type=click.IntRange(1),
    default=50,
    show_default=True,
    metavar="NUMBER",
    help="How many entries at most, the newest first.",
)
@registry_option
@json_option
@friendly
def registry_log(claim: str | None, limit: int, registry_url: str | None, as_json: bool) -> None:
    """Show what was done, when, and by whom.

    With NAME or ID only what was done to that badge. Whether the log is sound, `moireid registry audit` tells.
    """
    from moireid.registry import open_registry

    with open_registry(registry_url, create=False) as registry:
        entries, shown = registry.entries(claim, limit), registry.shown_url
    if as_json:
        show_json({"registry": shown, "entries": [entry.to_json() for entry in entries]})
        return
    for entry in entries:
        who = entry.actor or ("(erased)" if entry.actor_erased else "(not recorded)")
        click.echo(f"{entry.seq:>6}  {entry.time}  {entry.action:<11}  {entry.subject}  {who}")


@registry_group.command("erase")
@click.argument("claim", metavar="NAME|ID")
@click.option(
    "--from-log",
    is_flag=True,
    help="NAME is not a badge's holder, but somebody whom `moireid registry log` names as having done things.",
)
@click.option("--yes", "sure", is_flag=True, help="Do it. Without this nothing is erased, as it cannot be taken back.")
@actor_option
@registry_option
@json_option
@friendly
def registry_erase(
    claim: str, from_log: bool, sure: bool, actor: str | None, registry_url: str | None, as_json: bool
) -> None:
    """Erase a person's data on their wish, for good.

    Name, badge and figures go; their badge is valid no more, and its identity is never issued again. The log keeps that
    identity, which is a number of chance, and an entry that says when it was erased. It stays sound, and checkpoints of
    before still hold.

    What this cannot reach: copies, backups and exports of the registry, bundles that others fetched before, and files
    of the badge itself.
    """
    from moireid.registry import open_registry

    if not sure:
        raise SpecError(f"erasing {claim[:80]!r} cannot be taken back, so nothing was done; add --yes if you mean it")
    with open_registry(registry_url, create=False, actor=actor) as registry:
        registry.check_head()
        done = registry.erase_actor(claim) if from_log else registry.erase(claim)
        shown = registry.shown_url
    if as_json:
        show_json({"registry": shown} | done.to_json())
    else:
        what = f"the name behind {done.subject[:16]}" if from_log else f"the holder of badge {done.subject}"
        click.echo(f"{what} {'was' if done.again else 'is'} erased from {shown} since {done.erased_at}")
    if not done.cleaned:
        say(
            "note: the database could not be written anew, so parts of it that are not in use may still hold the data; "
            "close what else uses it, make room on the disk, and give the same command again with the id"
        )
    if done.guessable:
        say(
            "note: entries from before this version hold a hash of the record without a salt, and cannot be changed: "
            "whoever has the log and the badge's identity can still confirm a name that they guess"
        )
