"""enroll: enter a finished badge into the registry."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import click

from moireid.cli.common import (
    FiniteRange,
    actor_option,
    camera_held,
    camera_option,
    expires_option,
    friendly,
    json_option,
    progress_bar,
    registry_option,
    say,
    show_json,
)
from moireid.errors import SpecError

if TYPE_CHECKING:
    from moireid.badge import Badge


@click.command("enroll")
@click.argument("badge_json", type=click.Path(path_type=Path))
@registry_option
@click.option(
    "--capture",
    "captures",
    type=click.Path(path_type=Path),
    multiple=True,
    help="A film of the finished badge, moved sideways, to measure it by. May be given several times.",
)
@click.option(
    "--measured-scale",
    type=FiniteRange(0.9, 1.1),
    metavar="X",
    help="Length of the printed scale bar by a ruler, in mm, divided by 150; 0.9 to 1.1.",
)
@click.option(
    "--focal-px", type=FiniteRange(50, 100000), metavar="PX", help="The camera's focal length in pixels, if known."
)
@camera_option
@expires_option
@actor_option
@json_option
@friendly
def enroll_command(
    badge_json: Path,
    registry_url: str | None,
    captures: tuple[Path, ...],
    measured_scale: float | None,
    focal_px: float | None,
    camera_file: Path | None,
    expires: str | None,
    actor: str | None,
    as_json: bool,
) -> None:
    """Enter a badge into the registry of who holds which badge.

    BADGE_JSON is the badge.json that print-your-badge wrote. Entering the same badge again changes nothing.

    With --capture, the finished badge is also measured. The verifier can then distinguish it from a second badge that
    was printed from the same files. It also knows how far the fringes move under this sheet: from 0.5 to 1.6 times as
    far as designed, as thin and thick sheets of one pitch are sold. Several films must agree on that.
    """
    from moireid.badge import load_badge
    from moireid.cli.issue_notes import derived_notes, look_alike_notes
    from moireid.registry import open_registry
    from moireid.registry.changes import expiry_day

    if expires is not None:
        # Before a registry is made for it, or films are read.
        expiry_day(expires)
    badge = load_badge(badge_json)
    _check_identity(badge, badge_json)
    as_built = None
    if measured_scale is not None and not captures:
        raise SpecError("--measured-scale is kept with the as-built figures; give a --capture too")
    if captures:
        from moireid.verifier.session.capture import capture_as_built

        with progress_bar("reading the captures") as progress:
            as_built = capture_as_built(
                list(captures),
                badge,
                focal_px=focal_px,
                camera=camera_held(camera_file, focal_px),
                measured_scale=measured_scale,
                progress=progress,
            )
    with open_registry(registry_url, create=True, actor=actor) as registry:
        registry.check_head()
        notes = derived_notes([badge]) + look_alike_notes([badge], registry)
        record = registry.enroll(badge, warned=True, expires=expires)
        if as_built is not None:
            record = registry.store_as_built(record.id, as_built.to_json())
        if as_json:
            measured = {"as_built": json.loads(record.as_built)} if record.as_built else {}
            show_json(record.summary() | {"registry": registry.shown_url, "notes": notes} | measured)
        else:
            click.echo(f"{record.name} holds badge {record.id} since {record.issued_at} in {registry.shown_url}")
            if record.expires is not None:
                click.echo(f"it counts until the end of {record.expires}")
            if as_built is not None:
                beat = f"{as_built.beat_period_mm:.2f} mm"
                click.echo(
                    f"as built: beat {beat}, gain {as_built.gain_ratio:.3f}, measured in {as_built.captures} film(s)"
                )
        for note in notes:
            say(f"note: {note}")
        if record.revoked_at is not None:
            say(f"note: this badge was revoked on {record.revoked_at} ({record.revoked_reason}), and stays revoked")
        elif (barred := record.barred()) is not None and barred.code == "expired":
            say(f"note: this badge expired on {record.expires}, and stays so")
        elif record.suspended_at is not None:
            say(f"note: this badge is suspended since {record.suspended_at} ({record.suspended_reason})")


def _check_identity(badge: Badge, source: Path) -> None:
    """Raise unless the badge has an identity, and its lines spell it."""
    from moireid.idcodes import spells_its_id

    if badge.id is None or not any(grating.code for grating in badge.gratings):
        raise SpecError(f"{source} is a board without an identity; print a badge with print-your-badge")
    if not spells_its_id(badge):
        raise SpecError(f"{source}: its lines do not spell its id {badge.id}; enroll the badge.json as it was printed")
