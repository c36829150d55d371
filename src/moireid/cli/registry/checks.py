"""registry audit: does everything hold?"""

from __future__ import annotations

import sys

import click

from moireid.cli.common import ACCEPT, REJECT, friendly, json_option, progress_bar, registry_option, show_json
from moireid.cli.registry.records import registry_group

#: Findings that the audit prints for people; --json holds more.
SHOWN = 20


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
