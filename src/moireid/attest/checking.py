"""Checks whether a signed verdict is valid, and of which film it is, in numbered steps.

1. Open the envelope.
2. Is the signature the key's over the report?
3. Is it the key that was expected?
4. Is what was signed a report of this format, by that key?
5. Does the certificate name the expected signer, by the word of a trusted authority, and is it valid today?
6. Is the film the one that was judged?

Steps 4 to 6 are left out where step 2 fails, as nothing in the report can be believed then.
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from cryptography import x509

from moireid.attest.certificate_identity import identity_fault
from moireid.attest.envelope import Broken, EnvelopeParts, opened
from moireid.attest.signing_keys import (
    PublicKey,
    algorithm,
    certificate_digest,
    fingerprint,
)
from moireid.attest.statement import statement_fault, strict_object
from moireid.errors import SpecError
from moireid.files import open_regular

Expectation = Literal["key", "certificate", "registry"]
#: Parts of a fault that mean that another one signed than was expected.
SIGNER_PARTS = ("key", "identity")


@dataclass(frozen=True)
class CheckResult:
    """What a check found.

    Attributes
    ----------
    faults : tuple of Broken
        What does not hold; empty where all does.
    opened : EnvelopeParts or None
        The envelope; None where it cannot be opened.
    report : dict or None
        The report as it was signed; None where nothing in it can be believed.
    film_name : str
        The film's name where it was judged.
    expected : tuple of {"key", "certificate", "registry"}
        What the signer was compared with; empty where the key was only found in the envelope.
    film_same : bool or None
        Whether the given film is the judged one; None where none was given.
    badge_now : dict or None
        Whether the badge counts at present, and since when it is revoked; None where no registry was asked.
    """

    faults: tuple[Broken, ...]
    opened: EnvelopeParts | None = None
    report: dict[str, Any] | None = None
    film_name: str = ""
    expected: tuple[Expectation, ...] = ()
    film_same: bool | None = None
    badge_now: dict[str, Any] | None = None

    @property
    def holds(self) -> bool:
        """Whether nothing is wrong."""
        return not self.faults

    def to_json(self) -> dict[str, Any]:
        """Give the object that ``attest check --json`` prints.

        Returns
        -------
        dict
            `holds`, `faults`, `signer`; and if the report can be believed, what was judged, when and with what result.
        """
        document: dict[str, Any] = {
            "holds": self.holds,
            "faults": [{"part": fault.part, "text": fault.text} for fault in self.faults],
            "signer": self._signer(),
        }
        if self.report is None:
            return document
        report = self.report
        return document | {
            "verdict": report["verdict"],
            "film": {
                "name": self.film_name,
                "sha256": report["input"]["sha256"],
                "same": self.film_same,
                "tracks": report["input"].get("tracks", []),
            },
            "badge": report["badge"],
            "badge_now": self.badge_now,
            "claim_source": report["claim_source"],
            "registry": report["registry"],
            "moireid": report["moireid"],
            "time": report["attested"]["at"],
            "report": report,
        }

    def _signer(self) -> dict[str, Any] | None:
        if self.opened is None:
            return None
        return {
            "key_sha256": fingerprint(self.opened.key),
            "algorithm": algorithm(self.opened.key),
            "expected": all(fault.part not in SIGNER_PARTS for fault in self.faults) if self.expected else None,
            "expected_by": list(self.expected),
        }


def check(
    envelope: bytes,
    *,
    film: Path | None = None,
    key: PublicKey | None = None,
    identity: str | None = None,
    authorities: Sequence[x509.Certificate] = (),
) -> CheckResult:
    """Check a signed verdict.

    Parameters
    ----------
    envelope : bytes
        As `envelope.read_envelope` reads it.
    film : Path, optional
        The film that it should be of.
    key : PublicKey, optional
        The key by which it should be signed; None: the one in the envelope, which does not prove who its holder is.
    identity : str, optional
        Whom the signing certificate should name: its common name, or one of its alternative names (e-mail address,
        host, URI), letter by letter.
    authorities : sequence of x509.Certificate
        Of those who are trusted to give that name; by no one's word, none counts.

    Returns
    -------
    CheckResult
        With every fault that was found.

    Raises
    ------
    SpecError
        The film cannot be read.
    """
    wanted: dict[Expectation, object] = {"key": key, "certificate": identity}
    expected = tuple(name for name, given in wanted.items() if given is not None)
    digest = _digest(film) if film is not None else None
    faults: list[Broken] = []
    found: EnvelopeParts | None = None
    try:
        found = opened(envelope)  # 1
        if key is not None and fingerprint(key) != fingerprint(found.key):  # 3
            own, other = fingerprint(found.key)[:16], fingerprint(key)[:16]
            faults.append(Broken("key", f"It was signed by key {own}…, and not by the given {other}…."))
        if not found.signed_by(found.key):  # 2
            words = "The signature does not fit: the report, or the signature or its key, was changed."
            raise Broken("signature", words)
        document = _statement(found)  # 4
    except Broken as broken:
        return CheckResult((broken, *faults), found, expected=expected)
    report = document["predicate"]
    if identity is not None:  # 5
        fault = identity_fault(identity, authorities, found.certificates, found.key)
        faults += [Broken("identity", fault)] if fault else []
    judged = report["input"]["sha256"]
    same = None if digest is None else digest == judged  # 6
    if same is False:
        words = (
            f"The film is another one, or was changed: its SHA-256 begins {digest:.16}, the judged one's {judged:.16}."
        )
        faults.append(Broken("film", words))
    name = document["subject"][0]["name"]
    return CheckResult(tuple(faults), found, report, name, expected, same)


def _statement(found: EnvelopeParts) -> dict[str, Any]:
    """The statement that was signed.  Raises: Broken where it is none, or another key's."""
    try:
        document = strict_object(found.payload)
    except ValueError as error:
        raise Broken("report", f"What was signed is no report: {error}.") from error
    if fault := statement_fault(document):
        raise Broken("report", f"What was signed is no report of this format: {fault}.")
    signer = document["predicate"]["attested"]["signer"]
    if signer["key_sha256"] != fingerprint(found.key):
        raise Broken("report", "The report says that another key signs it.")
    own = certificate_digest(found.certificates[0]) if found.certificates else None
    if signer["certificate_sha256"] != own:
        raise Broken("certificate", "The certificate is not the one that the signer named in the report.")
    return document


def _digest(film: Path) -> str:
    try:
        with open_regular(film) as stream:
            return hashlib.file_digest(stream, "sha256").hexdigest()
    except OSError as error:
        raise SpecError(f"film {film} cannot be read ({error.strerror}); check its name and rights") from error
