"""The options of `verify`, their values, and which of them exclude each other."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from moireid.cli.common import (
    FiniteRange,
    bundle_option,
    camera_option,
    json_option,
    overwrite_option,
    registry_option,
    track_option,
    trust_option,
)
from moireid.cli.sealed_reader import unsealed_option
from moireid.cli.witness_options import WitnessCheck
from moireid.errors import SpecError

if TYPE_CHECKING:
    from moireid.attest.credentials import Form
    from moireid.verifier.session.check_level import CheckLevel

focal_option = click.option(
    "--focal-px",
    type=FiniteRange(50, 100000),
    metavar="PX",
    help="The camera's focal length in pixels, if known; else it is estimated from the film.",
)


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
original_option = click.option(
    "--require-original/--no-require-original",
    default=None,
    help="Accept only a film whose figures are those measured at enrolment, which a copy that was built anew does not "
    "have; or any. Default: only such a film where the badge was enrolled with --capture.",
)
level_option = click.option(
    "--level",
    type=click.Choice(["record", "enrolled", "live"]),
    default="record",
    show_default=True,
    help="What must be shown: record, the film by itself agrees with the badge's design; enrolled, its figures are "
    "also those of enrolment; live, a live check with prompts was passed, which no film made before shows. With "
    "less the film is inconclusive.",
)
#: In the order of the help.
OPTIONS = (
    *CLAIM_OPTIONS,
    focal_option,
    camera_option,
    track_option,
    click.option(
        "--report",
        "report_folder",
        type=click.Path(path_type=Path, file_okay=False),
        help="Write a report here: report.html, with plots, and its figures.",
    ),
    original_option,
    click.option(
        "--overlap",
        is_flag=True,
        help="Also require that the badge passes in front of the face for a second; needs moireid[face].",
    ),
    click.option(
        "--cover",
        "cover_share",
        type=click.FloatRange(0, 1),
        help="Least share of the film that must be judged, 0 to 1; below it the film is inconclusive.  [default: 0.5]",
    ),
    level_option,
    click.option(
        "--strength",
        type=click.IntRange(50, 500),
        metavar="N",
        help="Accept only if at most 1 in N forgeries that know nothing of the law would look as the film does; with "
        "more the film is inconclusive.  [default: 50]",
    ),
    click.option(
        "--live-check",
        "receipt_files",
        type=click.Path(path_type=Path),
        multiple=True,
        help="Attach the receipt of a live check of the same person to the report, best one about this film; from a "
        "one-time link of the studio. It is no part of the verdict. May be repeated.",
    ),
    click.option(
        "--pipeline",
        type=click.Choice(["moireid", "published"]),
        default="moireid",
        show_default=True,
        help="Our method, or the published one (Qing et al. 2026) for comparison: correlation only, and no identity.",
    ),
    unsealed_option,
    overwrite_option,
    json_option,
)


def verify_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Give a command the options of `verify`."""
    for option in reversed(OPTIONS):
        command = option(command)
    return command


@dataclass(frozen=True)
class ClaimWish:
    """Whose badge is claimed, and where it is looked up; the names are those of the options."""

    claim: str | None
    registry_url: str | None
    badge_json: Path | None
    bundle_path: Path | None
    trust: str | None
    witness_check: WitnessCheck | None = field(default=None, kw_only=True)


@dataclass(frozen=True)
class VerifyOptions(ClaimWish):
    """The options as they were typed; the names are those of the options."""

    video: Path
    focal_px: float | None
    camera_file: Path | None
    track: int | None
    report_folder: Path | None
    require_original: bool | None
    overlap: bool
    cover_share: float | None
    level: CheckLevel
    strength: int | None
    receipt_files: tuple[Path, ...]
    pipeline: str
    key_file: Path | None
    attest_file: Path | None
    timestamp_url: str | None
    form: Form | None
    unsealed: bool
    overwrite: bool
    as_json: bool

    @property
    def published(self) -> bool:
        """Whether the published method judges."""
        return self.pipeline == "published"


def check_wish(wish: VerifyOptions) -> None:
    """Raise SpecError if options exclude each other, before anything is opened."""
    _check_pipeline(wish)
    check_claim(wish)


def _check_pipeline(wish: VerifyOptions) -> None:
    """Raise SpecError for what the published method cannot do; only verdicts of our own are signed."""
    if wish.published and wish.require_original is not None:
        raise SpecError("--pipeline published cannot do what --require-original asks for; leave one of them out")
    if wish.published and wish.camera_file is not None:
        raise SpecError("--pipeline published takes no distortion from a picture; leave --camera out")
    wanted: dict[str, object] = {
        "--overlap": wish.overlap or None,
        "--cover": wish.cover_share,
        "--track": wish.track,
        "--strength": wish.strength,
    }
    wanted["--level"] = None if wish.level == "record" else wish.level
    for name, value in wanted.items():
        if wish.published and value is not None:
            raise SpecError(f"--pipeline published cannot check {name}; leave one of them out")
    if wish.key_file is not None and wish.unsealed:
        raise SpecError("--sign reads the film apart from the key, and --unsealed does not; leave one of them out")
    if wish.key_file is not None and wish.published:
        raise SpecError("--sign is for verdicts of moireid's own pipeline; leave --pipeline published out")


def check_claim(wish: ClaimWish) -> None:
    """Raise SpecError unless there is one claim and one place to look it up."""
    if (wish.claim is None) == (wish.badge_json is None):
        raise SpecError("give either --claim NAME|ID (with --registry) or --badge badge.json")
    if wish.bundle_path is not None and (wish.registry_url is not None or wish.claim is None):
        raise SpecError("--bundle replaces --registry, and needs --claim; leave the other one out")
    for name, value in (("--trust", wish.trust), ("--witness-key", wish.witness_check)):
        if value is not None and wish.badge_json is not None and wish.registry_url is None:
            raise SpecError(
                f"{name} is of a registry, and none is asked with --badge alone; add --registry, or leave it out"
            )
