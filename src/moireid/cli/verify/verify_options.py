"""Whose badge is claimed: options that several commands share, with their meaning."""

from __future__ import annotations

import functools
from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

from moireid.cli.common import bundle_option, registry_option, report_standing, trust_option
from moireid.cli.witness_options import WitnessCheck

#: Whose badge is claimed, in the order of the help.
CLAIM_OPTIONS = (
    click.option("--claim", metavar="NAME|ID", help="Whose badge it should be; looked up in the registry."),
    registry_option,
    click.option(
        "--badge",
        "badge_json",
        type=click.Path(path_type=Path),
        help="The badge.json of the claimed badge, instead of --claim. No one vouches for the name in it, unless "
        "--registry is given too and holds the badge.",
    ),
    bundle_option,
    trust_option,
)
level_option = click.option(
    "--level",
    type=click.Choice(["record", "enrolled", "live"]),
    help="What must be shown: record, the film agrees with the badge's design, and also with its figures where it was "
    "enrolled with --capture; enrolled, it was enrolled so, and the film agrees with its figures; live, a live check "
    "with prompts was passed, which no film made before shows. With less the film is inconclusive.  [default: record]",
)


def claim_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Give a command the options of a claim, and hand it `claimed`, where the badge is looked up, and `claim_files`,
    the files that are read for it, which no output may replace.
    """

    @functools.wraps(command)
    def wrapped(
        *args: Any,
        claim: str | None,
        registry_url: str | None,
        badge_json: Path | None,
        bundle_path: Path | None,
        trust: str | None,
        witness_check: WitnessCheck | None = None,
        **given: Any,
    ) -> Any:
        from moireid.api.asking import claim_context

        require = witness_check.require if witness_check else None
        claimed = claim_context(claim, badge_json, registry_url, bundle_path, trust, report_standing, require)
        files = [bundle_path, badge_json]
        if registry_url is not None or (claim is not None and bundle_path is None):
            from moireid.registry.engine import own_file

            files.append(own_file(registry_url))
        return command(*args, claimed=claimed, claim_files=files, **given)

    for option in reversed(CLAIM_OPTIONS):
        wrapped = option(wrapped)
    return wrapped
