"""A verdict in the terminal: the result, what to do, failures first."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from moireid.verifier.report.circumstances import Circumstances
    from moireid.verifier.report.headline import Headline

MARKS = {"pass": "✓", "fail": "✗", "undecided": "?", "note": "·"}
#: Findings name no options, as pages show them too; these are the options that help, by code.
OPTIONS = {
    "focal": "--focal-px",
    "gain": "--focal-px, or enroll --capture",
    "built": "--no-require-original, or enroll --capture",
    "copyable": "enroll --capture",
    "cover": "--cover",
    "photographs": "--photographs",
    "corners": "--pipeline published",
}


def show_verdict(
    word: str, document: Mapping[str, Any], known: Circumstances, headline: Headline | None = None
) -> None:
    """Print the headline, what it means and what to do; then failures first, and what holds in one line.

    headline: None for that of a film.
    """
    from moireid.verifier.report.findings import sorted_findings
    from moireid.verifier.report.headline import headline_of
    from moireid.verifier.report.rival_table import odds_line
    from moireid.verifier.report.seconds import seconds_of

    headline, found = headline or headline_of(document, known), sorted_findings(document["reasons"])
    click.echo(f"{word}: {headline.title}")
    click.echo(headline.text)
    click.echo(f"What to do: {headline.advice}")
    if (seconds := seconds_of(document)) is not None:
        click.echo(f"Seconds: {seconds.text}")
    if odds := odds_line(document):
        click.echo(f"Odds: {odds}")
    for finding in found.first:
        option = OPTIONS.get(finding["code"], "") if finding["level"] in ("undecided", "note") else ""
        click.echo(f"  {MARKS[finding['level']]} {finding['text']}{f' ({option})' if option else ''}")
    if found.hold:
        click.echo(f"  ✓ holds: {', '.join(dict.fromkeys(finding['code'] for finding in found.hold))}")
    for one in document.get("detectors", []):
        click.echo(f"  · Detector {one['name']} gives {one['score']:g}; that is no part of the verdict.")
