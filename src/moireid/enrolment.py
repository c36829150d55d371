"""Measured figures into a registry: compared with those known of the badge, then kept, or refused.

The command and the studio call it.  Figures that differ from the known ones, or that no sheet explains, take their
place only for a reason, which the registry's authority signs with the record and the log keeps.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from moireid.asbuilt import AsBuilt, as_built_from_json
from moireid.errors import RegistryError

if TYPE_CHECKING:
    from moireid.badge import Badge
    from moireid.registry import Record, Registry
    from moireid.verifier.session.known_figures import CaptureComparison


def compare_with_record(record: Record | None, found: AsBuilt, badge: Badge) -> CaptureComparison:
    """Compare what a capture shows with the figures that a record has in use; record: None if it is not issued yet."""
    from moireid.verifier.session.known_figures import compare_capture

    known = as_built_from_json(record.as_built) if record is not None and record.as_built else None
    return compare_capture(found, known, badge)


def check_figures(compared: CaptureComparison, badge: Badge, reason: str | None) -> None:
    """Raise RegistryError if figures are refused that no reason was given for."""
    if compared.refused and reason is None:
        raise RegistryError(
            f"the capture of badge {badge.id} of {badge.name!r} is refused: {compared.text}; film the badge again, or "
            "say why these figures hold (replace= and reason=)",
            code="figures_differ",
        )


def keep_figures(registry: Registry, record: Record, found: AsBuilt, reason: str | None) -> Record:
    """Compare what a capture shows of a badge with the figures in use, and keep it.

    Parameters
    ----------
    registry : Registry
        An open registry.
    record : Record
        Of the badge; if others change its figures meanwhile, nothing is kept.
    found : AsBuilt
        Of the capture.
    reason : str or None
        Why the figures take the place of those in use; None to leave agreeing ones in use.

    Returns
    -------
    Record
        The record, unchanged if its figures stay in use.

    Raises
    ------
    RegistryError
        As `check_figures` and `Registry.store_as_built`.
    """
    # By this very record: what was compared before may be of figures that are in use no longer.
    compared = compare_with_record(record, found, record.badge)
    check_figures(compared, record.badge, reason)
    if compared.outcome == "same" and reason is None:
        return record
    if compared.outcome == "confirms" and reason is None and record.as_built is not None:
        found = replace(as_built_from_json(record.as_built), witnessed=True)
    return registry.store_as_built(record.id, found.to_json(), reason=reason, refines=record.as_built)
