"""identify: whose badge a film shows, of all in a registry."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from moireid.cli.common import (
    ACCEPT,
    INCONCLUSIVE,
    REJECT,
    friendly,
    json_option,
    progress_bar,
    registry_option,
    show_json,
    tell_standing,
    trust_option,
)
from moireid.cli.verify.asked import known_by
from moireid.cli.verify.options import focal_option
from moireid.cli.verify.showing import show_verdict


@click.command("identify")
@click.argument("video", type=click.Path(path_type=Path))
@registry_option
@trust_option
@focal_option
@json_option
@friendly
def identify_command(
    video: Path, registry_url: str | None, trust: str | None, focal_px: float | None, as_json: bool
) -> None:
    """Find out whose badge a film shows.

    Everyone in the registry is considered, and no claim is needed.

    Exit code 0: found; 1: nobody enrolled; 2: bad input; 3: inconclusive.
    """
    from moireid.registry import People, open_registry
    from moireid.verifier.session.claim import with_badge_notes
    from moireid.verifier.session.identify import identify
    from moireid.verifier.video import Film

    Film(video)
    with open_registry(registry_url, create=False) as registry, progress_bar("reading the film") as progress:
        standing, people = registry.standing(trust), People(registry)
        tell_standing(standing)
        outcome = identify(video, registry.layouts(), people, focal_px=focal_px, progress=progress)
        document = outcome.to_json() | {"found_name": people.name(outcome.found_id), "registry": standing.to_json()}
        if (record := registry.by_id(outcome.found_id or "")) is not None:
            document = with_badge_notes(document, record.badge, measured=record.as_built is not None)
        known = known_by(registry, standing, document)
    if as_json:
        show_json(document)
    else:
        show_verdict(outcome.finding.upper(), document, known)
    sys.exit({"found": ACCEPT, "nobody": REJECT, "inconclusive": INCONCLUSIVE}[outcome.finding])
