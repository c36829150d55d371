"""What a process that read a film may answer, and how that is checked: it may be in a stranger's hands.

An honest answer always passes.  One that does not ends the check, and nothing of it is used.
"""

from __future__ import annotations

import json
from functools import cache
from typing import Annotated, Any, TypeVar

import msgspec
from msgspec import Meta

from moireid.errors import MediaError
from moireid.json_schema import report_schema, schema_fault
from moireid.provenance import Revocation
from moireid.verifier.report.report_page import Pictures

Model = TypeVar("Model")
#: Frames read, and the number expected.
Count = Annotated[int, Meta(ge=0, le=1_000_000_000)]
#: What identification adds to a report, or answers without one; its reasons are as in a report.
IDENTIFIED = {
    "type": "object",
    "required": ["finding", "found_id", "reasons"],
    "properties": {
        "finding": {"enum": ["found", "nobody", "inconclusive"]},
        "found_id": {"type": ["string", "null"], "pattern": "^[0-9a-f]{1,32}$"},
    },
    "if": {"properties": {"finding": {"const": "found"}}},
    "then": {"properties": {"found_id": {"type": "string"}}},
}


class FilmAnswer(msgspec.Struct, forbid_unknown_fields=True):
    """What was found, as JSON; and the pictures of its page, where they were asked for."""

    result: dict[str, Any]
    pictures: Pictures = Pictures()


class MalformedAnswer(MediaError):
    """A process answered what no honest one answers."""


def malformed(film: object, what: str) -> MalformedAnswer:
    """The error of an answer that no honest process gives."""
    return MalformedAnswer(
        f"the process that read {film} answers what no film shows ({what}); it may be in a stranger's hands, so do not "
        "trust this film"
    )


def checked(value: object, model: type[Model], film: object) -> Model:
    """An answer, or a part of it, as it must be.  Raises: MediaError."""
    try:
        return msgspec.convert(value, model, str_keys=True)
    except (msgspec.ValidationError, ValueError, TypeError, RecursionError) as error:
        raise malformed(film, str(error)[:200]) from error


def checked_report(report: dict[str, Any], film: object, barred: Revocation | None) -> None:
    """Raise MediaError where a report breaks a rule of its schema, or accepts a badge that does not count."""
    # Who has receipts of live checks adds them afterwards; they are no finding of the film.
    report.pop("live_checks", None)
    _check(report, "report", film)
    if barred is not None and report["verdict"] == "accept":
        raise malformed(film, "a badge that no longer counts")


def checked_identification(found: dict[str, Any], film: object) -> None:
    """Raise MediaError where what `identify` found breaks a rule of its schema, or of a report's if it has one."""
    found.pop("live_checks", None)
    _check(found, "identified", film)
    if "verdict" in found:
        _check(found, "identification", film)


def _check(document: dict[str, Any], name: str, film: object) -> None:
    """Raise MediaError where a rule is broken, or a film is called a live check."""
    if document.get("level") == "live":
        raise malformed(film, "a live check")
    if (fault := schema_fault(document, _schemas()[name])) is not None:
        raise malformed(film, fault)


@cache
def _schemas() -> dict[str, str]:
    report = json.loads(report_schema())
    of_report = {"allOf": [{"properties": {"reasons": report["properties"]["reasons"]}}], "$defs": report["$defs"]}
    # Here the reasons are of the finding, and not of the report's verdict.
    identification = {name: rule for name, rule in report.items() if name not in ("if", "then")}
    made = {"report": report, "identified": IDENTIFIED | of_report, "identification": identification}
    return {name: json.dumps(schema) for name, schema in made.items()}
