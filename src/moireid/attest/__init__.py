"""Signed verdicts: the verifier's user signs a report, and anyone can check it later.

signing_keys.py      private keys with certificates, public keys, their fingerprints
statement.py         what is signed: an in-toto statement about a film, with the report in it; strict reading of JSON
envelope.py          the signed statement as a DSSE envelope
checking.py          checks of an envelope: signature, key, report, certificates and film
certificate_identity.py  whom the signer's certificate must name, by the word of an authority that is trusted
registry_answer.py   what a registry says about a verdict's badge and signer
credentials.py       the verdict as content credentials (C2PA), written by a process without the key
credentials_work.py  the process that reads and writes content credentials, without the key

The process that has the key never decodes a film.
"""

from typing import TYPE_CHECKING

from moireid.lazy import lazy

if TYPE_CHECKING:
    from moireid.attest.certificate_identity import CertificateIdentity
    from moireid.attest.checking import CheckResult, check
    from moireid.attest.envelope import signed_envelope
    from moireid.attest.registry_answer import held_against
    from moireid.attest.signing_keys import SigningKey, load_public_key, load_signing_key

__all__ = [
    "CertificateIdentity",
    "CheckResult",
    "SigningKey",
    "check",
    "held_against",
    "load_public_key",
    "load_signing_key",
    "signed_envelope",
]

__getattr__ = lazy(
    __name__,
    {
        "CheckResult": "checking",
        "check": "checking",
        "CertificateIdentity": "certificate_identity",
        "held_against": "registry_answer",
        "SigningKey": "signing_keys",
        "load_public_key": "signing_keys",
        "load_signing_key": "signing_keys",
        "signed_envelope": "envelope",
    },
)
