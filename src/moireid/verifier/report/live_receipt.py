"""Receipts of live checks, which are attached to a film's report.

A film cannot show when it was made.  A person who is asked about it, and answers prompts with the badge, can: the
receipt says who was checked, when, about which film, and what came out.  It is a note, and no part of the film's
verdict: it is as good as the one who made the check.

Convention: times are UTC, ISO 8601; digests are SHA-256, 64 hex digits.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal

import msgspec
from msgspec import Meta

from moireid.models import check_format, read_model
from moireid.provenance import Standing
from moireid.verifier.reasons import Verdict
from moireid.version import __version__

FORMAT = 1
#: Letters of a line at most.
LONGEST = 500
# In Python's patterns `$` lets a line end pass.
Digest = Annotated[str, Meta(pattern=r"^[0-9a-f]{64}\Z")]
#: Without signs that steer a terminal or end a line.
Line = Annotated[str, Meta(max_length=LONGEST, pattern=r"^[^\x00-\x1f\x7f-\x9f\u2028\u2029]*\Z")]
Moment = Annotated[str, Meta(pattern=r"^[0-9]{4}-[0-9]{2}-[0-9]{2}T[0-9]{2}:[0-9]{2}[0-9:.+Z]{0,20}\Z")]
#: As in `sandbox.seal.MEANS`.
SealPart = Literal["no_new_privileges", "calls", "files"]
ADVICE = "take the receipt from the page of a one-time link"


class FilmAsked(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The film that a person was asked about; name: the asker's name for it."""

    name: Line
    sha256: Digest

    @classmethod
    def of(cls, name: str, sha256: str) -> FilmAsked:
        """A film whose name a stranger may have chosen."""
        return cls("".join(letter if letter.isprintable() else " " for letter in name)[:LONGEST], sha256)


class LiveReceipt(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What is kept of a live check.

    kind: where it was made; claim: whose badge was asked for; ended_at: when it was over; report_sha256: of its
    report, a JSON text; challenged: whether prompts were drawn; claim_id: the badge's id, None where the asker may not
    know it; film: None where the person was asked about none; registry: that was asked; asked_as: how the asker was
    named to the other person; link, made_at, opened_at, used_at, pictures_kept: of a one-time link; sealed: the parts
    of the seal that held for the process that read the pictures, as in a film's report, and decoder: the program that
    decoded them; None where that is not known.
    """

    kind: Literal["one-time link"]
    claim: Line
    ended_at: Moment
    verdict: Verdict
    report_sha256: Digest
    challenged: bool
    claim_id: Line | None = None
    format: int = FORMAT
    title: Line | None = None
    film: FilmAsked | None = None
    registry: Standing | None = None
    moireid: Line = __version__
    asked_as: Line | None = None
    link: Line | None = None
    made_at: Moment | None = None
    opened_at: Moment | None = None
    used_at: Moment | None = None
    pictures_kept: int = 0
    sealed: tuple[SealPart, ...] | None = None
    decoder: Line | None = None

    def to_json(self) -> dict[str, Any]:
        """As a JSON object."""
        # By its text, in which a tuple is an array.
        found: dict[str, Any] = msgspec.json.decode(msgspec.json.encode(self))
        return found

    @property
    def words(self) -> str:
        """What it says, in a sentence."""
        about = "about this film" if self.film else "about no film in particular"
        out = {"accept": "was passed", "reject": "failed"}.get(self.verdict, "stayed inconclusive")
        live = ", without prompts," if not self.challenged else ""
        ended = self.ended_at[:16].replace("T", " ")
        return f"A live check of {self.claim} {about}{live} {out}; it ended on {ended} UTC.{self._how_read}"

    @property
    def _how_read(self) -> str:
        """How its pictures were read, as a further sentence; nothing where that is not known."""
        if self.sealed is None:
            return ""
        seal = f"with these parts of a seal: {', '.join(self.sealed)}" if self.sealed else "without a seal"
        return f" Its pictures were read by {self.decoder or 'a decoder of its own'} in a process {seal}."


def receipt_of(document: object, source: str = "a receipt") -> LiveReceipt:
    """The receipt that a JSON object holds.  Raises: SpecError."""
    check_format(document, FORMAT, source)
    return read_model(document, LiveReceipt, source, ADVICE)


def attached(report: Mapping[str, Any], receipts: list[LiveReceipt]) -> dict[str, Any]:
    """A film's report, as `verify --json` prints it, with receipts of live checks."""
    return dict(report) | ({"live_checks": [one.to_json() for one in receipts]} if receipts else {})
