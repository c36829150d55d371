"""A verdict as a terminal shows it: the headline by name, what speaks against the badge, and what holds in one line."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from datetime import UTC, datetime
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from moireid.registry import Registry
    from moireid.verifier.report.circumstances import Circumstances

#: From a report's JSON to what a registry knows of it.
LookUp = Callable[[Mapping[str, Any]], "Circumstances"]
MARKS = {"pass": "✓", "fail": "✗", "undecided": "?", "note": "·"}
#: Findings tell no options, as pages show them too; here is where each is said.
OPTIONS = {
    "focal": "--focal-px",
    "gain": "--focal-px, or enroll --capture",
    "built": "--no-require-original, or enroll --capture",
    "copyable": "enroll --capture",
    "cover": "--cover",
    "photographs": "--photographs",
    "corners": "--pipeline published",
}


def unknown(document: Mapping[str, Any]) -> Circumstances:
    """What is known where no registry is asked: the present time."""
    from moireid.verifier.report.circumstances import Circumstances

    return Circumstances(datetime.now(UTC))


def known_by(registry: Registry, document: Mapping[str, Any]) -> Circumstances:
    """What a registry knows of a report: who holds the badge that was read, and whose word that is."""
    from moireid.registry import holder_of
    from moireid.verifier.report.circumstances import Circumstances, read_id

    read = holder_of(registry, read_id(document))
    return Circumstances(datetime.now(UTC), read=read, authority=registry.fingerprint, registry=registry.shown_url)


def show_verdict(word: str, document: Mapping[str, Any], known: Circumstances) -> None:
    """Print the headline, what it means and what to do; then failures first, and what holds in one line."""
    from moireid.verifier.report.findings import sorted_findings
    from moireid.verifier.report.headline import headline_of

    headline, found = headline_of(document, known), sorted_findings(document["reasons"])
    click.echo(f"{word}: {headline.title}")
    click.echo(headline.text)
    click.echo(f"What to do: {headline.advice}")
    for finding in found.first:
        option = OPTIONS.get(finding["code"], "") if finding["level"] in ("undecided", "note") else ""
        click.echo(f"  {MARKS[finding['level']]} {finding['text']}{f' ({option})' if option else ''}")
    if found.hold:
        click.echo(f"  ✓ holds: {', '.join(dict.fromkeys(finding['code'] for finding in found.hold))}")
