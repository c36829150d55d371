"""What a film is checked against, and findings on the claim itself."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from moireid.asbuilt import AsBuilt, DatedFigures
from moireid.badge import Badge
from moireid.errors import SpecError
from moireid.names import hidden_letters, hidden_words
from moireid.provenance import ClaimedBadge, Provenance, Seal
from moireid.verifier.camera.known_camera import KnownCamera
from moireid.verifier.decision.sheet_gain import SheetGain, as_built, designed, to_measure
from moireid.verifier.identity.decode import Identity
from moireid.verifier.limits import LEAST_STRENGTH, MIN_COVER_SHARE, MOST_STRENGTH
from moireid.verifier.reasons import Reason
from moireid.verifier.session.check_level import CheckLevel


@dataclass(frozen=True)
class Claim:
    """What a film is checked against.

    Parameters
    ----------
    badge : Badge
        The claimed badge, or any badge of the same layout.
    badge_id : str, optional
        The id that must be read, hex digits; None if no identity is claimed.
    focal_px : float, optional
        Focal length of the film's camera, px; None if it is not known, and it is then estimated.
    camera : KnownCamera, optional
        A calibration of the film's camera, in place of its focal length.
    as_built : AsBuilt, optional
        Figures of the badge as it was measured when it was enrolled.
    as_built_at : str, optional
        Since when these are on record, ISO 8601.
    earlier : tuple of DatedFigures
        Figures that were in use before those, oldest first: a film that agrees with one of these sets agrees, whenever
        it was made.
    replaced_at : str, optional
        Since when other figures are in use, if `as_built` is an earlier set.
    require_original : bool, optional
        Reject a film whose figures differ from those of enrolment; one that does not show them is inconclusive.  None
        requires this if `as_built` is known.
    provenance : Provenance, optional
        Where the claim comes from; None if a program makes it by itself.
    seal : Seal, optional
        Of the identity that must be read, instead of `badge_id`, if a bundle keeps the identity sealed.
    cover_share : float
        Least share of the film, 0 to 1, that must be judged; with less the verdict is inconclusive.
    level : {"record", "enrolled", "live"}
        Least level that must be reached (`check_level`); below it the verdict is inconclusive.
    strength : int
        An acceptance needs that at most 1 in so many forgeries that know nothing of the law would look as the film does
        (`explanations.strength`); from the default to `MOST_STRENGTH`.
    enrolling : bool
        Measure the gain of the badge's sheet: accept any gain with which a badge can be enrolled.
    """

    badge: Badge
    badge_id: str | None = None
    focal_px: float | None = None
    as_built: AsBuilt | None = None
    as_built_at: str | None = None
    earlier: tuple[DatedFigures, ...] = ()
    replaced_at: str | None = None
    require_original: bool | None = None
    provenance: Provenance | None = None
    cover_share: float = MIN_COVER_SHARE
    level: CheckLevel = "record"
    strength: int = LEAST_STRENGTH
    enrolling: bool = False
    seal: Seal | None = None
    camera: KnownCamera | None = None

    @classmethod
    def of(cls, found: ClaimedBadge, **asked: Any) -> Claim:
        """The claim of a badge, with what else is asked for, by the names of the fields.

        Raises: SpecError if a strength below the default is asked for, or one that so many draws cannot show.
        """
        strength = asked.get("strength", LEAST_STRENGTH)
        if not LEAST_STRENGTH <= strength <= MOST_STRENGTH:
            raise SpecError(f"strength is {LEAST_STRENGTH} to {MOST_STRENGTH}, not {strength:g}; give one of these")
        return cls(
            found.badge,
            found.badge.id,
            as_built=found.as_built,
            as_built_at=found.as_built_at,
            earlier=found.earlier,
            provenance=found.provenance,
            seal=found.seal,
            **asked,
        )

    def earlier_claims(self) -> list[Claim]:
        """The claim by each earlier set of figures, the newest first."""
        dates = [*(one.at for one in self.earlier[1:]), self.as_built_at] if self.earlier else []
        dated = [
            replace(self, as_built=one.as_built, as_built_at=one.at, earlier=(), replaced_at=until)
            for one, until in zip(self.earlier, dates, strict=True)
        ]
        return dated[::-1]

    @property
    def names_someone(self) -> bool:
        """Whether an identity is claimed, in the clear or sealed."""
        return self.badge_id is not None or self.seal is not None

    def id_if_read(self, found: str | None) -> str | None:
        """The claimed identity, as far as it is known once `found` was read: a seal opens only for the right one."""
        if self.seal is None:
            return self.badge_id
        return found if found is not None and self.seal.holds(found) else None

    @property
    def sheet(self) -> SheetGain:
        """The gain that the badge's sheet is expected to have; that of the design if copies may pass."""
        if self.enrolling:
            return to_measure()
        built = self.as_built if self.original_required else None
        return designed(self.badge) if built is None else as_built(self.badge, built)

    @property
    def original_required(self) -> bool:
        """Whether the figures must be those of enrolment."""
        return self.as_built is not None if self.require_original is None else self.require_original


def claim_reasons(claim: Claim, identity: Identity) -> tuple[Reason, ...]:
    """Findings on the claim, whatever the film shows: who vouches for it, and who else could have this badge."""
    if not claim.names_someone:
        return ()
    if claim.seal is not None:
        claim = replace(claim, badge=replace(claim.badge, id=identity.claimed_id), badge_id=identity.claimed_id)
    found = [_source(claim), _name(claim), _look_alike(claim), _chosen(claim), _hidden(claim)]
    found.append(_copyable() if claim.as_built is None and identity.verdict == "match" else None)
    return tuple(reason for reason in found if reason is not None)


def with_badge_notes(document: dict[str, Any], *, measured: bool) -> dict[str, Any]:
    """Add to the output of ``identify --json`` who else could have the badge that was found, as in ``verify``.

    Parameters
    ----------
    document : dict
        Of a badge that was found; it is not changed.
    measured : bool
        Whether it was enrolled with a film of it.

    Returns
    -------
    dict
        With the finding `copyable` if it was not.
    """
    return document if measured else document | {"reasons": [*document["reasons"], _copyable().to_json()]}


def _source(claim: Claim) -> Reason | None:
    if claim.provenance is None or claim.provenance.source != "file":
        return None
    text = f"The claim is from a file, not from a registry: no one vouches for the name in it, {claim.badge.name!r}."
    return Reason("claim_source", "note", "file", "registry", "", text)


def _name(claim: Claim) -> Reason | None:
    other, name = claim.provenance.file_name if claim.provenance else None, claim.badge.name
    if other is None:
        return None
    text = f"The file gives this badge the name {other!r}; the registry holds it under the name {name!r}."
    return Reason("name", "fail", other, name, "", text)


def _look_alike(claim: Claim) -> Reason | None:
    alike = claim.provenance.alike if claim.provenance else ()
    if not alike:
        return None
    text = (
        f"The name {claim.badge.name!r} looks like that of {' and '.join(alike)}, who is enrolled too and written in "
        "other letters or case; compare the identities."
    )
    return Reason("look_alike", "note", float(len(alike)), 0.0, "people", text)


def _chosen(claim: Claim) -> Reason | None:
    known = claim.provenance
    if known is None or known.line is None:
        return None
    bear = "1 other badge bears" if known.others == 1 else f"{known.others} other badges bear"
    text = f"The claim chose the person named {claim.badge.name!r} with the line {known.line!r}; {bear} that name."
    return Reason("chosen_line", "note", float(known.others), 0.0, "badges", text)


def _hidden(claim: Claim) -> Reason | None:
    words = hidden_words(claim.badge.name)
    if words is None:
        return None
    text = f"The name {claim.badge.name!r} {words}, so it can pass for another; compare the identities."
    return Reason("hidden_letters", "note", float(len(hidden_letters(claim.badge.name))), 0.0, "letters", text)


def _copyable() -> Reason:
    text = (
        "This badge is copyable: it was not enrolled with a film of it, so anybody who has its files can print the "
        "same badge, and no film can show the difference."
    )
    return Reason("copyable", "note", None, None, "", text)
