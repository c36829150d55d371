"""Receipts of live checks, which are attached to a film's report.

A film cannot show when it was made.  A person who is asked about it, and answers prompts with the badge, can: the
receipt says who was checked, when, about which film, and what came out.  It is a note, and no part of the film's
verdict: it is as good as the one who made the check.

Convention: times are UTC, ISO 8601; digests are SHA-256, 64 hex digits.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

import msgspec
from msgspec import Meta

from moireid import __version__
from moireid.errors import SpecError
from moireid.models import check_format, parse_json, read_model
from moireid.provenance import Standing
from moireid.verifier.reasons import Verdict

FORMAT = 1
Digest = Annotated[str, Meta(pattern="^[0-9a-f]{64}$")]
Line = Annotated[str, Meta(max_length=500, pattern=r"^[^\x00-\x1f\x7f]*$")]
ADVICE = "take the receipt from the page of a one-time link, or of moireid watch --challenge --receipt"


class FilmAsked(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The film that a person was asked about; name: the asker's name for it."""

    name: Line
    sha256: Digest


class LiveReceipt(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What is kept of a live check.

    kind: where it was made; claim: whose badge was asked for; ended_at: when it was over; report_sha256: of its report,
    a JSON text; film: None where the person was asked about none; registry: that was asked; asked_as: how the asker was
    named to the other person; link, made_at, opened_at, used_at, pictures_kept: of a one-time link.
    """

    kind: Literal["one-time link", "watch"]
    claim: Line
    ended_at: Line
    verdict: Verdict
    challenged: bool
    report_sha256: Digest
    format: int = FORMAT
    title: Line | None = None
    film: FilmAsked | None = None
    registry: Standing | None = None
    moireid: Line = __version__
    asked_as: Line | None = None
    link: Line | None = None
    made_at: Line | None = None
    opened_at: Line | None = None
    used_at: Line | None = None
    pictures_kept: int = 0

    def to_json(self) -> dict[str, Any]:
        """As a JSON object."""
        found: dict[str, Any] = msgspec.to_builtins(self)
        return found

    @property
    def words(self) -> str:
        """What it says, in a sentence."""
        about = "about this film" if self.film else "about no film in particular"
        out = {"accept": "was passed", "reject": "failed"}.get(self.verdict, "stayed inconclusive")
        live = "" if self.challenged else ", without prompts"
        return (
            f"A live check of {self.claim} {about}{live} {out}; it ended on {self.ended_at[:16].replace('T', ' ')} UTC."
        )


def load_receipt(path: Path) -> LiveReceipt:
    """Read a receipt.  Raises: SpecError where it is none of this format."""
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise SpecError(f"receipt {path} cannot be read; {ADVICE}") from error
    return receipt_of(parse_json(text, f"receipt {path}", ADVICE), f"receipt {path}")


def receipt_of(document: object, source: str = "a receipt") -> LiveReceipt:
    """The receipt that a JSON object holds.  Raises: SpecError."""
    check_format(document, FORMAT, source)
    return read_model(document, LiveReceipt, source, ADVICE)


def attached(report: Mapping[str, Any], receipts: list[LiveReceipt]) -> dict[str, Any]:
    """A film's report, as `verify --json` prints it, with receipts of live checks."""
    return dict(report) | ({"live_checks": [one.to_json() for one in receipts]} if receipts else {})


def check_belongs(receipt: LiveReceipt, report: Mapping[str, Any]) -> None:
    """Raise SpecError unless a receipt is of a report's claim and registry, and about its film or none."""
    name, film = report["badge"]["name"], report["input"]["sha256"]
    if receipt.claim != name:
        raise SpecError(f"the receipt is of a live check of {receipt.claim!r}, and the film is said to show {name!r}")
    if receipt.film is not None and receipt.film.sha256 != film:
        raise SpecError(f"the receipt is about the film {receipt.film.name!r}, which is another; attach it to that one")
    asked = report.get("registry") or {}
    if receipt.registry is not None and asked and receipt.registry.fingerprint != asked["fingerprint"]:
        raise SpecError("the receipt is of a live check by another registry than the film's; check both by one")
