"""Whom a signing certificate must name, and by whose word.

Anybody can make a certificate with any name in it, so a name counts only where a chain of certificates leads to an
authority that the user trusts.
"""

from __future__ import annotations

import unicodedata
from collections.abc import Sequence

from cryptography import x509
from cryptography.x509.oid import NameOID
from cryptography.x509.verification import Criticality, ExtensionPolicy, PolicyBuilder, Store, VerificationError

from moireid.attest.signing_keys import PublicKey, fingerprint, fingerprint_of, holder

#: Names of the alternative subject that are texts.
_TEXTS = (x509.RFC822Name, x509.DNSName, x509.UniformResourceIdentifier)


def identity_fault(
    name: str, authorities: Sequence[x509.Certificate], chain: Sequence[x509.Certificate], key: PublicKey
) -> str | None:
    """Why a chain of certificates does not show that a signer has a name, in a sentence; None where it does.

    Parameters: name: as in `checking.check`; authorities: certificates of those who are trusted to give it; chain: the
        signer's own certificate first; key: by which was signed.
    Convention: the certificate's purpose (extended key usage) may be any, as the name is what is asked for.
    Source: path validation of RFC 5280, section 6, by `cryptography.x509.verification`.
    """
    if not chain:
        return f"No certificate names the signer, and one of {name!r} is expected."
    own = chain[0]
    if unicodedata.normalize("NFC", name) not in names_of(own):
        return f"The signer's certificate names {holder(own)!r}, and not {name!r}."
    if fingerprint_of(own) != fingerprint(key):
        return "The signer's certificate is of another key."
    try:
        policy = PolicyBuilder().store(Store(list(authorities)))
        policy = policy.extension_policies(ca_policy=_authority_policy(), ee_policy=_signer_policy())
        policy.build_client_verifier().verify(own, list(chain[1:]))
    except (VerificationError, ValueError) as error:
        reason = " ".join(str(error).split())[:200]
        return f"No authority that you trust gave {name!r} this certificate ({reason})."
    return None


def names_of(certificate: x509.Certificate) -> set[str]:
    """The names that a certificate has for its holder, in Unicode NFC: its one common name, and alternative names."""
    common = certificate.subject.get_attributes_for_oid(NameOID.COMMON_NAME)
    # Of two common names, one program would show the first, and another the last.
    found = {str(common[0].value)} if len(common) == 1 else set()
    try:
        others = certificate.extensions.get_extension_for_class(x509.SubjectAlternativeName).value
    except (x509.ExtensionNotFound, x509.DuplicateExtension, ValueError):
        others = None
    if others is not None:
        found |= {name for kind in _TEXTS for name in others.get_values_for_type(kind)}
    return {unicodedata.normalize("NFC", name) for name in found}


def _authority_policy() -> ExtensionPolicy:
    """Of certificates that issue others.  One that limits names is refused, as a common name escapes such a limit."""
    return (
        ExtensionPolicy.permit_all()
        .require_present(x509.BasicConstraints, Criticality.AGNOSTIC, _issues)
        .require_not_present(x509.NameConstraints)
    )


def _signer_policy() -> ExtensionPolicy:
    """Of the signer's own certificate."""
    return ExtensionPolicy.permit_all().may_be_present(x509.BasicConstraints, Criticality.AGNOSTIC, _does_not_issue)


def _issues(policy: object, certificate: x509.Certificate, found: x509.BasicConstraints) -> None:
    if not found.ca:
        raise ValueError(f"{holder(certificate)} may not issue certificates")


def _does_not_issue(policy: object, certificate: x509.Certificate, found: x509.BasicConstraints | None) -> None:
    if found is not None and found.ca:
        raise ValueError("it is an authority's own certificate")
