"""What is signed: an in-toto statement (v1) whose subject is the film and whose predicate is the report.

Also its strict reading: text that readers could understand in different ways is refused.

Convention: the predicate is what `verify --json` prints, with the object `attested`: when, and by which key.  So a
    program that reads reports can read this one too.
Source: in-toto attestation framework, Statement v1 (https://in-toto.io/Statement/v1).
"""

from __future__ import annotations

import json
from datetime import UTC, datetime
from functools import cache
from importlib import resources
from typing import Any

from moireid.attest.signing_keys import SigningKey, certificate_digest, fingerprint
from moireid.errors import SpecError
from moireid.json_schema import schema_fault


def strict_object(content: bytes) -> dict[str, Any]:
    """The JSON object that `content` holds.

    Raises: ValueError, with a few words for people, where it is none, or is spelled otherwise than `statement` spells
        it: of a key that is named twice, or a number beyond what JSON has, two people could read two reports.
    """
    try:
        document = json.loads(content)
        if isinstance(document, dict) and json.dumps(document, allow_nan=False).encode() == content:
            return document
    except (ValueError, RecursionError):
        pass
    raise ValueError("it is no JSON object, or not spelled as moireid spells one")


STATEMENT_TYPE = "https://in-toto.io/Statement/v1"
#: With the number of the report's format.
PREDICATE_TYPE = "urn:moireid:predicate:verify-report:2"


def attested(report: dict[str, Any], key: SigningKey) -> dict[str, Any]:
    """A report with the object `attested`: the time of signing, and the signer's key and certificate.

    Parameters: report: as `Report.to_json` gives it, with the `registry` that was asked.
    """
    own = certificate_digest(key.chain[0]) if key.chain else None
    # Both are signed, so that no one can put another certificate of the same key next to the signature.
    signer = {"key_sha256": fingerprint(key.public), "certificate_sha256": own}
    return report | {"attested": {"at": utc(datetime.now(UTC)), "signer": signer}}


def statement(report: dict[str, Any], film_name: str) -> bytes:
    """The statement about a film, as it is signed.

    Parameters: report: as `attested` gives it; film_name: without folders, which are private.
    Raises: SpecError where the report is not as the schema says.
    """
    document = {
        "_type": STATEMENT_TYPE,
        "subject": [{"name": film_name, "digest": {"sha256": report["input"]["sha256"]}}],
        "predicateType": PREDICATE_TYPE,
        "predicate": report,
    }
    if fault := statement_fault(document):
        raise SpecError(f"this report cannot be signed: {fault}; that is an error of moireid, please report it")
    return json.dumps(document, allow_nan=False).encode("ascii")


def statement_fault(document: dict[str, Any]) -> str | None:
    """The first way in which a statement breaks its schema, in words; None where it breaks none of its rules."""
    if (fault := schema_fault(document, _schema_text("attestation.schema"), _schema_text("report.schema"))) is not None:
        return fault
    subject, judged = document["subject"][0]["digest"]["sha256"], document["predicate"]["input"]["sha256"]
    return None if subject == judged else "its report is of another film than its subject"


def utc(moment: datetime) -> str:
    """A moment as reports write it, such as 2026-01-31T12:00:00Z."""
    return moment.astimezone(UTC).strftime("%Y-%m-%dT%H:%M:%SZ")


@cache
def _schema_text(name: str) -> str:
    return resources.files("moireid").joinpath(f"schema/{name}.json").read_text(encoding="utf-8")
