"""enroll: enter a finished badge into the registry."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from moireid.cli.common import (
    FiniteRange,
    actor_option,
    camera_options,
    counted,
    echo,
    friendly,
    json_option,
    progress_bar,
    registry_option,
    say,
    show_json,
    track_option,
)
from moireid.cli.sealed_reader import sealed_reader, unsealed_option
from moireid.errors import SpecError

if TYPE_CHECKING:
    from moireid.asbuilt import AsBuilt
    from moireid.badge import Badge
    from moireid.registry import Record, Registry
    from moireid.verifier.session.known_figures import CaptureComparison


replace_option = click.option(
    "--replace",
    is_flag=True,
    help="Keep what the capture shows although it differs from known figures, no lens sheet explains it, or it is too "
    "vague. The registry signs and logs it; the figures of before stay on record and count too.",
)
reason_option = click.option("--reason", metavar="TEXT", help="Why, with --replace; it is shown with the record.")


@click.command("enroll")
@click.argument("badge_json", type=click.Path(path_type=Path))
@friendly
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
@camera_options
@track_option
@unsealed_option
@replace_option
@reason_option
@actor_option
@json_option
def enroll_command(
    badge_json: Path,
    registry_url: str | None,
    captures: tuple[Path, ...],
    measured_scale: float | None,
    unsealed: bool,
    replace: bool,
    reason: str | None,
    actor: str | None,
    as_json: bool,
    **film: Any,
) -> None:
    """Enter a badge into the registry of who holds which badge.

    BADGE_JSON is the badge.json that print-your-badge wrote. Entering the same badge again changes nothing.

    With --capture, the finished badge is also measured. The verifier can then distinguish it from a second badge that
    was printed from the same files. It also knows how far the fringes move under this sheet: from 0.5 to 1.6 times as
    far as designed, as thin and thick sheets of one pitch are sold. Several films must agree on that.

    A capture whose figures differ from those known of the badge, that no lens sheet as sold explains, or that is too
    vague to distinguish copies is refused and shown next to them. Give --replace with a --reason where it is right.
    Equal figures measured again change nothing.

    Figures that a forger cannot draw beforehand are measured in a live check, on the studio's page Live.
    """
    from moireid.badge import load_badge
    from moireid.cli.issue_notes import look_alike_notes
    from moireid.enrolment import keep_figures
    from moireid.registry import open_registry
    from moireid.registry.changes import checked_reason

    # Before a registry is made for it, or films are read.
    if replace != (reason is not None) or (replace and not captures):
        raise SpecError("--replace, --reason TEXT and --capture FILM go together; give all of them, or a capture alone")
    reason = None if reason is None else checked_reason(reason)
    badge = load_badge(badge_json)
    _check_identity(badge, badge_json)
    if measured_scale is not None and not captures:
        raise SpecError("--measured-scale is kept with the as-built figures; give a --capture too")
    as_built = None
    if captures:
        as_built = _measured(badge, captures, unsealed=unsealed, measured_scale=measured_scale, **film)
    with open_registry(registry_url, create=True, actor=actor) as registry:
        registry.standing()
        compared = None if as_built is None else _show_compared(registry, badge, as_built, reason)
        notes = look_alike_notes([badge], registry)
        record = registry.enroll(badge)
        if as_built is not None:
            record = keep_figures(registry, record, as_built, reason)
        if as_json:
            measured = _figures_json(record, as_built, compared)
            show_json(record.summary() | {"registry": registry.shown_url, "notes": notes} | measured)
        else:
            echo(f"{record.name} holds badge {record.id} since {record.issued_at} in {registry.shown_url}")
            if as_built is not None:
                echo(_figures_words(record, as_built))
        if record.revoked_at is not None:
            notes.append(f"this badge was revoked on {record.revoked_at} ({record.revoked_reason}), and stays revoked")
        for note in notes:
            say(f"note: {note}")


def _measured(badge: Badge, captures: tuple[Path, ...], *, unsealed: bool, **how: Any) -> AsBuilt:
    """The as-built figures that the captures show; how: as `measure_captures`."""
    from functools import partial

    from moireid.reading.film_orders import measure_captures
    from moireid.verifier.session.known_figures import checked_figures

    order = partial(measure_captures, films=captures, badge=badge, **how)
    with sealed_reader(captures, unsealed=unsealed) as reader, progress_bar("reading the captures") as progress:
        return checked_figures(reader.read(order, progress).result, badge)


def _show_compared(registry: Registry, badge: Badge, found: AsBuilt, reason: str | None) -> CaptureComparison:
    """The capture next to the figures in use, shown where they differ.  Raises: RegistryError if it is refused."""
    from moireid.enrolment import check_figures, compare_with_record
    from moireid.verifier.session.known_figures import side_by_side

    compared = compare_with_record(registry.by_id(badge.id or ""), found, badge)
    if compared.refused:
        for line in side_by_side(compared.pairs):
            say(line)
    check_figures(compared, badge, reason)
    return compared


def _figures_json(record: Record, found: AsBuilt | None, compared: CaptureComparison | None) -> dict[str, Any]:
    """The figures in use; with a capture also what it shows, and how that compares."""
    in_use = {"as_built": json.loads(record.as_built), "as_built_at": record.as_built_at} if record.as_built else {}
    if found is None or compared is None:
        return in_use
    return in_use | {"capture": json.loads(found.to_json()), "capture_outcome": compared.outcome}


def _figures_words(record: Record, found: AsBuilt) -> str:
    """What a capture showed, and what became of it."""
    films = counted(found.captures, "film")
    shown = f"as built: beat {found.beat_period_mm:.2f} mm, gain {found.gain_ratio:.3f}, measured in {films}"
    if record.as_built_at is not None and json.loads(record.as_built or "{}") != json.loads(found.to_json()):
        return f"{shown}; these agree with the figures known since {record.as_built_at[:10]}, which stay in use"
    count = len(record.earlier_figures)
    return f"{shown}; {counted(count, 'earlier set')} of figures stay on record" if count else shown


def _check_identity(badge: Badge, source: Path) -> None:
    """Raise unless the badge has an identity, and its lines spell it."""
    from moireid.idcodes import spells_its_id

    if badge.id is None or not any(grating.code for grating in badge.gratings):
        raise SpecError(f"{source} is a board without an identity; print a badge with print-your-badge")
    if not spells_its_id(badge):
        raise SpecError(f"{source}: its lines do not spell its id {badge.id}; enroll the badge.json as it was printed")
