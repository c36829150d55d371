"""Findings on a question itself, and what it asks of sheet and strength."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from moireid.errors import SpecError
from moireid.names import hidden_letters, hidden_words
from moireid.provenance import Revocation
from moireid.question import Question
from moireid.verifier.decision.sheet_gain import SheetGain, as_built, designed, to_measure
from moireid.verifier.identity.decode import Identity
from moireid.verifier.limits import LEAST_STRENGTH, MOST_STRENGTH
from moireid.verifier.reasons import Reason


def sheet_of(question: Question) -> SheetGain:
    """The gain that the badge's sheet is expected to have; that of the design if copies may pass."""
    if question.enrolling:
        return to_measure()
    built = question.as_built if question.original_required else None
    return designed(question.badge) if built is None else as_built(question.badge, built)


def least_strength(question: Question) -> int:
    """The strength that an acceptance needs.  Raises: SpecError for one that is too low, or that no draws can show."""
    strength = LEAST_STRENGTH if question.strength is None else question.strength
    if not LEAST_STRENGTH <= strength <= MOST_STRENGTH:
        raise SpecError(f"strength is {LEAST_STRENGTH} to {MOST_STRENGTH}, not {strength:g}; give one of these")
    return strength


def claim_reasons(question: Question, identity: Identity) -> tuple[Reason, ...]:
    """Findings on the claim, whatever the film shows: who vouches for it, and who else could have this badge."""
    if not question.names_someone:
        return ()
    if question.seal is not None:
        question = replace(
            question, badge=replace(question.badge, id=identity.claimed_id), badge_id=identity.claimed_id
        )
    found = [_source(question), _name(question), _look_alike(question), _hidden(question)]
    found.append(_copyable() if question.as_built is None and identity.verdict == "match" else None)
    return tuple(reason for reason in found if reason is not None)


def barred_finding(barred: Revocation) -> Reason:
    """The finding on a badge that does not count."""
    return Reason("revoked", "fail", barred.reason, None, "", barred.text)


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


def _source(question: Question) -> Reason | None:
    if question.provenance.source != "file":
        return None
    text = f"The claim is from a file, not from a registry: no one vouches for the name in it, {question.badge.name!r}."
    return Reason("claim_source", "note", "file", "registry", "", text)


def _name(question: Question) -> Reason | None:
    other, name = question.provenance.file_name, question.badge.name
    if other is None:
        return None
    text = f"The file gives this badge the name {other!r}; the registry holds it under the name {name!r}."
    return Reason("name", "fail", other, name, "", text)


def _look_alike(question: Question) -> Reason | None:
    alike = question.provenance.alike
    if not alike:
        return None
    text = (
        f"The name {question.badge.name!r} looks like that of {' and '.join(alike)}, who is enrolled too and written "
        "in other letters or case; compare the identities."
    )
    return Reason("look_alike", "note", float(len(alike)), 0.0, "people", text)


def _hidden(question: Question) -> Reason | None:
    words = hidden_words(question.badge.name)
    if words is None:
        return None
    text = f"The name {question.badge.name!r} {words}, so it can pass for another; compare the identities."
    return Reason("hidden_letters", "note", float(len(hidden_letters(question.badge.name))), 0.0, "letters", text)


def _copyable() -> Reason:
    text = (
        "This badge is copyable: it was not enrolled with a film of it, so anybody who has its files can print the "
        "same badge, and no film can show the difference."
    )
    return Reason("copyable", "note", None, None, "", text)
