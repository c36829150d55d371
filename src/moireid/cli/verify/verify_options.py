"""Whose badge is claimed: options that several commands share, with their meaning."""

from __future__ import annotations

import functools
from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from moireid.cli.common import bundle_option, registry_option, report_standing, trust_option
from moireid.cli.witness_options import WitnessCheck, witness_check

if TYPE_CHECKING:
    from moireid.api.asking import ClaimContext

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


@dataclass(frozen=True)
class ClaimWish:
    """Whose badge is claimed, and where it is looked up; the names are those of the options."""

    claim: str | None
    registry_url: str | None
    badge_json: Path | None
    bundle_path: Path | None
    trust: str | None
    witness_check: WitnessCheck | None = None

    @property
    def files(self) -> list[Path | None]:
        """The files that are read of the claim, which no output may replace."""
        found = [self.bundle_path, self.badge_json]
        if self.registry_url is None and (self.claim is None or self.bundle_path is not None):
            return found
        from moireid.registry.engine import own_file

        return [*found, own_file(self.registry_url)]

    def asked(self) -> AbstractContextManager[ClaimContext]:
        """The claimed badge, from a bundle, a registry or a file alone; a bundle stays open for the look-up.

        Raises: SpecError unless there is one claim and one place to look it up.
        """
        from moireid.api.asking import claim_context

        require = self.witness_check.require if self.witness_check else None
        place = self.registry_url, self.bundle_path, self.trust
        return claim_context(self.claim, self.badge_json, *place, report_standing, require)


def claim_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Give a command the options of a claim, and hand it their meaning as `wish`."""

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
        wish = ClaimWish(claim, registry_url, badge_json, bundle_path, trust, witness_check)
        return command(*args, wish=wish, **given)

    for option in reversed(CLAIM_OPTIONS):
        wrapped = option(wrapped)
    return wrapped


def witnessed_claim_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """As `claim_options`, with those by which witnesses are asked for."""
    return witness_check(claim_options(command))
