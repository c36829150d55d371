"""Queries of a registry: one record by claim or id, lists, searches, layouts, the log's entries."""

from __future__ import annotations

import difflib
import unicodedata
from collections.abc import Callable, Iterable, Iterator
from typing import Any

from sqlalchemy import or_, select, tuple_

from moireid.arguments import checked
from moireid.badge import Badge
from moireid.errors import RegistryError
from moireid.names import NAME_LIMIT, id_with_line
from moireid.registry.engine import chunks
from moireid.registry.ledger import Ledger
from moireid.registry.log import ERASE, check_signed
from moireid.registry.look_alikes import folded_skeleton, skeleton
from moireid.registry.record import Fault, Record, record_of, storable, tampered
from moireid.registry.schema import badges, log, select_layouts, select_records

#: Records fetched at a time: few enough for the memory, and no lock is held while the caller looks at them.
PAGE = 200
#: More matches than this are counted, not listed, in a message.
LISTED = 10
#: So many near names are suggested, found among so many records.
NEAR, MOST_COMPARED = 3, 2000
#: At most this many people whose names look alike are named.
MOST_ALIKE = 3


class RegistryQueries:
    """The methods of a registry that only read.

    Parameters
    ----------
    ledger : Ledger
        Tables and log.
    actor : str
        The person or account that uses it, as the log names them.
    """

    def __init__(self, ledger: Ledger, actor: str) -> None:
        self._ledger, self.shown_url, self.actor = ledger, ledger.shown, actor

    @checked()
    def find(self, claim: str) -> Record:
        """Find the one record that a claim means.

        Parameters
        ----------
        claim : str
            A name, matched exactly after Unicode NFC, or an id in hex digits of any case.

        Returns
        -------
        Record
            As the authority signed it.

        Raises
        ------
        RegistryError
            If there is none, or more than one; `error.details["ids"]` lists those.  The message names people whose
            names are near, or look alike.
        SpecError
            If the claim is no text.
        """
        name, own = unicodedata.normalize("NFC", claim), claim.lower()
        means = or_(badges.c.name_nfc == name, badges.c.id == own)
        matches = self._ledger.records(select_records().where(means).order_by(badges.c.id)) if storable(name) else []
        if len(matches) == 1:
            return matches[0]
        if not matches:
            raise self._no_one(claim, name)
        ids = [one.id for one in matches]
        listed = ", ".join(id_with_line(one.id, one.line) for one in matches[:LISTED])
        listed += f" and {len(ids) - LISTED} more" if len(ids) > LISTED else ""
        text = f"{len(ids)} people are named {name[:80]!r}, with ids {listed}; claim one of these ids"
        if (other := next((one for one in matches if one.name != name), None)) is not None:
            text = f"{name[:80]!r} is the id of {other.name!r} and also a name: {listed}; claim the other id"
        raise RegistryError(text, claim=claim, ids=ids)

    def _no_one(self, claim: str, name: str) -> RegistryError:
        """The error for a claim that means no one; name: the claim in NFC."""
        shown = self._ledger.shown
        if (when := self.erased_at(claim)) is not None:
            return RegistryError(
                f"the holder of badge {claim.lower()} was erased from registry {shown} on {when[:10]}, so "
                "it belongs to no one and nothing can be checked against it; ask the person for a badge issued since",
                code="erased",
                erased_at=when,
            )
        near, alike = "", tuple[str, ...]()
        if storable(name):
            near, alike = self._near(name) if len(name) <= NAME_LIMIT else "", self.alike(name)
        text = (
            f"no one named {name[:80]!r} and no such id is in registry {shown}{near}; `moireid registry list` shows "
            "who is"
        )
        if alike:
            text += f"; but it looks like {' and '.join(alike)}, whose name is written in other letters or case"
        return RegistryError(text, claim=claim, ids=[], alike=alike)

    def _near(self, name: str) -> str:
        """Names like this one, or that hold it, for a person who mistyped; empty where there are none or too many."""
        held = self._ledger.rows(select(badges.c.name_nfc).order_by(badges.c.id).limit(MOST_COMPARED))
        by_fold, folded = {row.name_nfc.casefold(): row.name_nfc for row in held}, name.casefold()
        near = difflib.get_close_matches(folded, by_fold, n=NEAR)
        near = near or [one for one in by_fold if folded in one.split()][:NEAR]
        return f" (did you mean {' or '.join(repr(by_fold[one][:40]) for one in near)}?)" if near else ""

    def named(self, name: str) -> list[Record]:
        """Find every record of exactly that name, revoked or not.

        Parameters
        ----------
        name : str
            Matched after Unicode NFC.

        Returns
        -------
        list of Record
            By id.

        Raises
        ------
        RegistryError
            If a record is not as the authority signed it.
        """
        whole = unicodedata.normalize("NFC", name)
        query = select_records().where(badges.c.name_nfc == whole).order_by(badges.c.id)
        return self._ledger.records(query) if storable(whole) else []

    def by_id(self, badge_id: str) -> Record | None:
        """Find the record of an id.

        Parameters
        ----------
        badge_id : str
            Hex digits of any case.

        Returns
        -------
        Record or None
            None if the id is not issued.
        """
        query = select_records().where(badges.c.id == badge_id.lower())
        found = self._ledger.records(query) if storable(badge_id) else []
        return found[0] if found else None

    def look_alikes(self, names: Iterable[str]) -> dict[str, list[Record]]:
        """Find people whose names look like these and are others.

        Parameters
        ----------
        names : iterable of str
            Any number; each is looked up by its skeletons, which have an index.

        Returns
        -------
        dict
            Name to the records, by id; names that look like no other are left out.
        """
        found: dict[str, dict[str, Record]] = {}
        for some in chunks(dict.fromkeys(names)):
            seen, plain = _by(skeleton, some), _by(folded_skeleton, some)
            alike = or_(badges.c.skeleton.in_(sorted(seen)), badges.c.folded.in_(sorted(plain)))
            for record in self._ledger.records(select_records().where(alike)):
                own, own_plain = skeleton(record.name), folded_skeleton(record.name)
                for name in {*seen.get(own, ()), *plain.get(own_plain, ())}:
                    if unicodedata.normalize("NFC", name) != record.name:
                        found.setdefault(name, {})[record.id] = record
        return {name: [ids[one] for one in sorted(ids)] for name, ids in found.items()}

    def alike(self, name: str) -> tuple[str, ...]:
        """Find people whose names look like this one and are others, for messages.

        Parameters
        ----------
        name : str
            Of a claim or a record.

        Returns
        -------
        tuple of str
            Name and id of three at most.
        """
        found = [one for alike in self.look_alikes([name]).values() for one in alike]
        return tuple(f"{one.name} ({one.id})" for one in found[:MOST_ALIKE])

    def erased_at(self, badge_id: str) -> str | None:
        """Find when the holder of a badge was erased.

        Parameters
        ----------
        badge_id : str
            Hex digits of any case.

        Returns
        -------
        str or None
            UTC, ISO 8601; None if the holder was not erased.

        Raises
        ------
        RegistryError
            If the entry that says so is not as the authority signed it.
        """
        if not storable(badge_id):
            return None
        newest = select(log).where(log.c.subject == badge_id.lower()).order_by(log.c.seq.desc()).limit(1)
        rows = self._ledger.rows(newest)
        if not rows or rows[0].action != ERASE:
            return None
        with self._ledger.reported():
            check_signed(dict(rows[0]._mapping), self._ledger.authority)
        return str(rows[0].time)

    def entries(self, claim: str | None = None, limit: int | None = None) -> list[dict[str, Any]]:
        """List what was done, newest first.

        Parameters
        ----------
        claim : str, optional
            Only what was done to this badge: a name or an id; an erased person's by id alone.
        limit : int, optional
            How many at most.

        Returns
        -------
        list of dict
            Each with `seq`, its number from 1 on; `time`, UTC, ISO 8601 to the second; `action`, such as "enroll",
            "revoke", "as_built", "as_built_replaced", "import", "erase"; `subject`, the badge's id, of the first entry
            the authority's fingerprint; and `actor`, who did it.  As the log holds them, not checked; `audit` checks.

        Raises
        ------
        RegistryError
            If the claim means no one, or several people.
        """
        subject = None if claim is None else claim.lower()
        if claim is not None and self.erased_at(claim) is None:
            subject = self.find(claim).id
        query = select(log.c.seq, log.c.time, log.c.action, log.c.subject, log.c.actor)
        if subject is not None:
            query = query.where(log.c.subject == subject)
        return [dict(row._mapping) for row in self._ledger.rows(query.order_by(log.c.seq.desc()).limit(limit))]

    def records(self) -> Iterator[Record]:
        """Go through all records by name, then id.

        Yields
        ------
        Record
            What is enrolled meanwhile may or may not be among them.

        Raises
        ------
        RegistryError
            After all others, if a record is not as the authority signed it.
        """
        page = select_records().order_by(badges.c.name_nfc, badges.c.id).limit(PAGE)
        ledger, fault, found = self._ledger, None, self._ledger.rows(page)
        while found:
            for row in found:
                try:
                    yield record_of(row, ledger.authority)
                except Fault as other:
                    fault = fault or other
            after = tuple_(badges.c.name_nfc, badges.c.id) > (found[-1].name_nfc, found[-1].id)
            found = ledger.rows(page.where(after)) if len(found) == PAGE else []
        if fault is not None:
            raise tampered(ledger.shown, fault)

    def search(self, text: str, limit: int, *, ids: bool = True) -> list[Record]:
        """Find records by a part of the name, or by the beginning of the id.

        Parameters
        ----------
        text : str
            If empty, all records are found.  SQLite folds the case of ASCII letters alone.
        limit : int
            How many at most.
        ids : bool
            If false, ids are not searched: a user who may try beginnings finds an id digit by digit.

        Returns
        -------
        list of Record
            By name, then id.
        """
        name = unicodedata.normalize("NFC", text.strip())
        if not storable(name):
            return []
        page = select_records().order_by(badges.c.name_nfc, badges.c.id).limit(limit)
        if name:
            named = badges.c.name_nfc.icontains(name, autoescape=True)
            page = page.where(or_(named, badges.c.id.startswith(name.lower(), autoescape=True)) if ids else named)
        return self._ledger.records(page)

    def layouts(self) -> list[Badge]:
        """List one badge of each distinct layout, which is enough for a reader to read any of them.

        Returns
        -------
        list of Badge
            Of each layout the badge of the lowest id.
        """
        return [record.badge for record in self._ledger.records(select_layouts())]

    def count(self) -> int:
        """Count the records.

        Returns
        -------
        int
            Revoked ones too.
        """
        return self._ledger.count()


def _by(look: Callable[[str], str], names: Iterable[str]) -> dict[str, list[str]]:
    """What names look like -> those names."""
    found: dict[str, list[str]] = {}
    for name in names:
        found.setdefault(look(name), []).append(name)
    return found
