"""The Record, its signed text, and the check of its signature on reading.

The signed text contains badge and measured figures as the SHA-256 of their canonical JSON.  So a record has only one
signed text, however its documents are written, and no document can be taken for another field of the record.
"""

from __future__ import annotations

import json
import unicodedata
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

from moireid.arguments import checked
from moireid.badge import Badge, badge_from_json
from moireid.errors import RegistryError, SpecError
from moireid.names import MOST_LINES, hidden_words, line_fault, line_of
from moireid.provenance import Revocation
from moireid.registry.canonical import canonical_json, pack, sha256_hex, unpack
from moireid.registry.engine import AnyRow
from moireid.registry.keys import RECORD, Authority, Signer
from moireid.registry.look_alikes import folded_skeleton, skeleton

#: Documents that are signed by their SHA-256, and stored packed.
DOCUMENTS = ("as_built", "as_built_earlier")
#: Fields that are stored and signed as they are.
PLAIN = (
    *("id", "issued_at", "layout_key", "as_built_at", "as_built_reason", "salt"),
    *("revoked_at", "revoked_reason"),
)
#: Fields that lists show.
SHOWN = ("id", "name", "line", "issued_at", "revoked_at", "revoked_reason")


@dataclass(frozen=True)
class Record:
    """One issued badge, as the authority signed it.

    Attributes
    ----------
    id : str
        Lower-case hex digits.
    name : str
        As it is matched, in Unicode NFC.
    badge_json : str
        The badge's canonical JSON.
    issued_at : str
        When it was issued.
    layout_key : str
        `Badge.layout_key()` at the time of issue.
    as_built : str or None
        Canonical JSON of the newest measured figures; None if it was never measured.
    as_built_at : str or None
        When these were stored.
    as_built_reason : str or None
        Why they took the place of others; None if they were the first, or only added to those.
    as_built_earlier : str or None
        Canonical JSON of the sets of figures that were in use before, oldest first, each with `as_built`,
        `as_built_at` and `as_built_reason`; None if there are none.  None is ever taken out.
    salt : str or None
        Random hex digits: without them no one can test a name against the log's hash of the record.  None before it
        is signed.
    revoked_at, revoked_reason : str or None
        When and why it was revoked; None if it was not.

    Notes
    -----
    Convention: times are UTC, ISO 8601 to the second, such as 2026-01-31T12:00:00Z.
    """

    id: str
    name: str
    badge_json: str = field(repr=False)
    issued_at: str
    layout_key: str
    as_built: str | None = field(default=None, repr=False)
    as_built_at: str | None = None
    as_built_reason: str | None = None
    as_built_earlier: str | None = field(default=None, repr=False)
    salt: str | None = field(default=None, repr=False)
    revoked_at: str | None = None
    revoked_reason: str | None = None

    def barred(self) -> Revocation | None:
        """Why the badge does not count; None if it does."""
        return None if self.revoked_at is None else Revocation(self.revoked_at, self.revoked_reason or "")

    @cached_property
    def badge(self) -> Badge:
        """The badge, read from its JSON on first use, so that a look-up among many records stays fast."""
        try:
            return badge_from_json(self.badge_json, source=f"the badge of id {self.id}")
        except SpecError as error:
            # Only a valid badge is ever signed, so another version of moireid signed this one, by other rules.
            raise RegistryError(
                f"{error}, although the registry's authority signed it; read it with the moireid that issued it",
                id=self.id,
            ) from error

    @cached_property
    def line(self) -> str | None:
        """The line below the name on the badge, which distinguishes people of one name; None if there is none."""
        # Few records have one, and reading each document of a long list would take minutes.
        return line_of(json.loads(self.badge_json).get("print")) if '"lines"' in self.badge_json else None

    @property
    def earlier_figures(self) -> list[dict[str, Any]]:
        """The sets of measured figures that were in use before, oldest first, as JSON objects."""
        return list(json.loads(self.as_built_earlier)) if self.as_built_earlier else []

    @property
    def figure_sets(self) -> list[dict[str, Any]]:
        """All sets of measured figures, as `earlier_figures`; the last one is in use."""
        if self.as_built is None:
            return []
        figures = {"as_built": json.loads(self.as_built)}
        own = figures | {"as_built_at": self.as_built_at, "as_built_reason": self.as_built_reason}
        return [*self.earlier_figures, own]

    def with_figure_sets(self, sets: list[dict[str, Any]]) -> Record:
        """The record with these sets of measured figures, at least one, of which the last one is in use."""
        *earlier, own = sets
        return replace(
            self,
            as_built=canonical_json(own["as_built"]),
            as_built_at=own["as_built_at"],
            as_built_reason=own["as_built_reason"],
            as_built_earlier=canonical_json(earlier) if earlier else None,
        )

    def summary(self) -> dict[str, Any]:
        """Make the JSON object that lists and answers show of a record.

        Returns
        -------
        dict
            Id, name, the line below it, and the times of issue and revocation.
        """
        return {name: getattr(self, name) for name in SHOWN}

    @cached_property
    def signed_text(self) -> bytes:
        """What the authority signs: canonical JSON of all fields, documents by their SHA-256."""
        fields = {name: getattr(self, name) for name in ("name", *PLAIN)}
        for name in ("badge_json", *DOCUMENTS):
            text = getattr(self, name)
            fields[f"{name}_sha256"] = None if text is None else sha256_hex(text.encode())
        return canonical_json(fields).encode()

    def digest(self) -> str:
        """Hash the signed text, as the log holds it.

        Returns
        -------
        str
            SHA-256, hex digits.
        """
        return sha256_hex(self.signed_text)

    def row(self, signer: Signer) -> dict[str, Any]:
        """Make the signed row of table `badges`.

        Parameters
        ----------
        signer : Signer
            Of the authority.

        Returns
        -------
        dict
            Value by column.
        """
        return {name: getattr(self, name) for name in PLAIN} | {
            "name_nfc": self.name,
            "badge": pack(self.badge_json),
            **{name: None if (text := getattr(self, name)) is None else pack(text) for name in DOCUMENTS},
            "skeleton": skeleton(self.name),
            "folded": folded_skeleton(self.name),
            "signature": signer.sign(RECORD, self.signed_text),
        }


class Fault(Exception):
    """Why a stored record or log entry is not valid: `code` for programs, `text` for people.

    subject: the id or the log entry that it is about; None if it is about the whole registry, or not known.
    """

    def __init__(self, code: str, text: str, subject: object = None) -> None:
        super().__init__(text)
        self.code, self.text, self.subject = code, text, None if subject is None else str(subject)


def record_of(row: AnyRow, authority: Authority) -> Record:
    """The record of a row that holds the columns of `badges`, and as `newest` the digest in the log's newest entry.

    Raises: Fault if the row is damaged, not signed by the authority, or not the newest version in the log.
    """
    try:
        plain: dict[str, Any] = {name: getattr(row, name) for name in PLAIN}
        plain |= {name: None if (got := getattr(row, name)) is None else unpack(got) for name in DOCUMENTS}
        record = Record(name=row.name_nfc, badge_json=unpack(row.badge), **plain)
        text = record.signed_text
    except (TypeError, ValueError) as error:
        raise Fault("record_damaged", f"the record of id {row.id} is damaged ({error})") from error
    if not authority.signed(RECORD, text, row.signature):
        raise Fault(
            "record_signature", f"the record of id {record.id} was changed: the authority's signature does not fit it"
        )
    if row.newest is None:
        raise Fault("record_unlogged", f"the log has no entry for the record of id {record.id}")
    if row.newest != sha256_hex(text):
        raise Fault("record_stale", f"the record of id {record.id} is not the version that the log has last")
    return record


def tampered(shown: str, fault: Fault) -> RegistryError:
    """The error for a fault in a registry."""
    return RegistryError(
        f"registry {shown} was tampered with or is damaged: {fault.text}; restore it from a copy, and look at the rest "
        "with `moireid registry audit`",
        code=fault.code,
    )


@checked()
def new_record(badge: Badge, shown: str, issued_at: str) -> Record:
    """The record of a badge that is about to be issued, its JSON as it will be read back.

    Raises: RegistryError if the badge has no id, or text that cannot be claimed or stored; SpecError if it breaks its
        own schema.
    """
    name = claimable_name(badge, shown)
    # JSON has one kind of number, Python has two: only a document read from JSON compares with a stored one.
    read_back = badge_from_json(badge.to_json(), source=f"the badge of {name[:80]!r}")
    text = storable_json(json.loads(read_back.to_json()), f"the badge of {name[:80]!r}", "print it anew")
    assert read_back.id is not None
    return Record(read_back.id, name, text, issued_at, read_back.layout_key())


def storable_json(document: object, what: str, remedy: str) -> str:
    """Canonical JSON that every reader takes.  Raises: RegistryError if it holds surrogates, NaN or infinity."""
    try:
        text = canonical_json(document)
        text.encode()
    except ValueError as error:
        raise RegistryError(f"{what} holds a number that is not finite, or no Unicode; {remedy}") from error
    return text


def claimable_name(badge: Badge, shown: str) -> str:
    """The name of a badge as claims are compared with it.

    Raises: RegistryError if it cannot be typed, or the lines below it are not plain text.
    """
    if badge.id is None:
        raise RegistryError(
            f"the badge of {badge.name[:80]!r} has no id, so registry {shown} cannot hold it; enroll one that "
            "print-your-badge made"
        )
    name = unicodedata.normalize("NFC", badge.name)
    if not name.strip() or not storable(name):
        raise RegistryError(
            f"the badge of id {badge.id[:40]} bears the name {name[:80]!r}, which no one can type as a claim; "
            "print it with a plain name"
        )
    if (hidden := hidden_words(name)) is not None:
        raise RegistryError(
            f"the name {name[:80]!r} {hidden}, so it passes for another; print the badge with the name without them",
            code="hidden_letters",
        )
    _check_lines(badge)
    return name


def _check_lines(badge: Badge) -> None:
    """Raise RegistryError unless the lines below a badge's name are a few lines of plain text: lists show them."""
    lines = (badge.print or {}).get("lines", [])
    many = not isinstance(lines, list | tuple) or len(lines) > MOST_LINES
    fault = f"are no list of at most {MOST_LINES}" if many else next(filter(None, map(line_fault, lines)), None)
    if fault is not None:
        what = "the lines" if many else "a line"
        raise RegistryError(
            f"{what} below the name {badge.name[:80]!r} {fault}; print the badge with plain lines", code="lines"
        )


def storable(text: str) -> bool:
    """Whether every database can store `text`, and a person can type it: no control characters, no lone surrogates."""
    return not any(unicodedata.category(letter) in ("Cc", "Cs") for letter in text)
