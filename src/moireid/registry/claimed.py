"""A registry as checks use it: the badge that a claim means, and the people that identification may find.

The command line and the studio both use this, so that a claim has the same meaning in both.
"""

from __future__ import annotations

import unicodedata
from collections.abc import Callable

from moireid.asbuilt import dated_figures
from moireid.badge import Badge
from moireid.provenance import FROM_FILE, BadgeHolder, Provenance, Revocation
from moireid.question import Question
from moireid.registry.bundle.held import with_figures
from moireid.registry.record import Record
from moireid.registry.store import Registry

#: The reason and the holder's name for an erased person's badge: no one may use it, and its holder is no longer known.
ERASED, SOMEBODY = "its holder was erased from the registry on their wish", "somebody who was erased"


def claimed(registry: Registry, claim: str) -> Question:
    """Look up the badge that a claim means.

    Parameters
    ----------
    registry : Registry
        An open registry.
    claim : str
        A name, matched exactly after Unicode NFC, or an id in hex digits.

    Returns
    -------
    Question
        The badge, its measured figures, and why it does not count, if it does not.

    Raises
    ------
    RegistryError
        As `Registry.find`: the claim means no one, or several people.  The message names people whose names look like
        the claimed one.  Also if the log was changed since the record was entered, as `Registry.check_newest` finds.
    """
    record = registry.find(claim)
    registry.check_newest(record)
    return _of_record(record, Provenance("registry", alike=registry.alike(record.name)))


def claimed_by_file(registry: Registry, badge: Badge) -> Question:
    """The badge of a file; if its id is enrolled, the registry's badge instead, so that the registry's name counts.

    Parameters
    ----------
    registry : Registry
        An open registry.
    badge : Badge
        As the file has it; no one vouches for its name.

    Returns
    -------
    Question
        Its provenance says which of the two it is, and keeps a name in the file that differs from the registry's.

    Raises
    ------
    RegistryError
        If the record is not as the authority signed it, or not the newest one.
    """
    record = registry.by_id(badge.id) if badge.id else None
    if record is None:
        gone = registry.erased_at(badge.id) if badge.id else None
        barred = None if gone is None else Revocation(gone, ERASED)
        return Question(badge, badge.id, barred=barred, provenance=FROM_FILE)
    registry.check_newest(record)
    name = unicodedata.normalize("NFC", badge.name).strip()
    other = badge.name if name != record.name.strip() else None
    return _of_record(record, Provenance("registry", other, registry.alike(record.name)))


def _of_record(record: Record, provenance: Provenance) -> Question:
    own = Question(record.badge, record.badge.id, barred=record.barred(), provenance=provenance)
    return with_figures(own, dated_figures(record.figure_sets))


def holder_of(registry: Registry, badge_id: object) -> BadgeHolder | None:
    """Look up the holder of a badge that was read in a film.

    Parameters
    ----------
    registry : Registry
        An open registry.
    badge_id : object
        Hex digits, or any other value that the process which reads untrusted films returns instead.

    Returns
    -------
    BadgeHolder or None
        None if it is no text, or no one holds such a badge.  For an erased person it says so, and gives no name.

    Raises
    ------
    RegistryError
        If the record, or the entry of an erasure, is not as the authority signed it, or not the newest one.

    Notes
    -----
    The process that reads the film never learns the answer and cannot ask: it only receives the claimed badge.
    """
    if not isinstance(badge_id, str):
        return None
    record = registry.by_id(badge_id)
    if record is not None:
        registry.check_newest(record)
        return BadgeHolder(record.name, record.barred(), record.line)
    gone = registry.erased_at(badge_id)
    return None if gone is None else BadgeHolder(SOMEBODY, Revocation(gone, ERASED), erased=True)


def holds(holder: Callable[[str], BadgeHolder | None], badge_id: str) -> bool:
    """Whether an id is enrolled, and its badge counts at present.

    Parameters: holder: as `holder_of`, of a registry or a bundle; badge_id: hex digits of any case.
    Raises: RegistryError as `holder_of`.
    """
    found = holder(badge_id)
    return found is not None and found.barred is None
