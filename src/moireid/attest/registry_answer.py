"""What a registry, or a bundle of it, says about a signed verdict: about its badge, and about its signer.

A registry vouches for names of badges, not for signers.  The one signer that it can vouch for is its own authority.  So
a verdict that another key signed needs that key, or the name in its certificate, from elsewhere.
"""

from __future__ import annotations

import unicodedata
from dataclasses import replace
from typing import Any

from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PublicKey

from moireid.attest.checking import CheckResult
from moireid.attest.envelope import Broken
from moireid.attest.signing_keys import fingerprint
from moireid.provenance import BadgeHolder


def badge_of(report: dict[str, Any]) -> str | None:
    """The identity by which a report's badge is looked up; None if it names none.

    A bundle keeps identities sealed, so a report by one has the identity only where it was read.
    """
    found: str | None = report["badge"]["id"] or report["identity"]["claimed_id"]
    return found


def held_against(found: CheckResult, holder: BadgeHolder, authority: str, public_hex: str) -> CheckResult:
    """Compare a verdict with what a registry says at present.

    Parameters
    ----------
    found : CheckResult
        What `check` found.
    holder : BadgeHolder
        Of its badge, by the registry or a bundle of it.
    authority, public_hex : str
        Fingerprint and key of the authority that says so, 32 and 64 hex digits.

    Returns
    -------
    CheckResult
        With a fault where name or authority are others, where the badge was revoked, and, if nothing else says
        whom to expect, where the authority's key did not sign it.

    Notes
    -----
    Source: a signer can set their own clock back, and a thief can film the badge; so no verdict by itself is older than
    a revocation.
    """
    if found.report is None or found.opened is None:
        return found
    faults = [*found.faults, *_record_faults(found.report, holder, authority)]
    expected = found.expected
    if not expected:
        expected = ("registry",)
        own, signed_by = Ed25519PublicKey.from_public_bytes(bytes.fromhex(public_hex)), found.opened.key
        if fingerprint(own) != fingerprint(signed_by):
            text = (
                f"Key {fingerprint(signed_by)[:16]}… signed it. A registry says who holds a badge, and not who signs, "
                "unless its own authority did; give the signer's key, or the name in its certificate."
            )
            faults.append(Broken("key", text))
    barred = holder.barred
    if barred is not None:
        text = f"The badge was revoked on {barred.at}, and the signer's own clock does not prove that this is older."
        faults.append(Broken("badge", text))
    now = {"counts": barred is None, "revoked_at": None if barred is None else barred.at}
    return replace(found, faults=tuple(faults), expected=expected, badge_now=now)


def _record_faults(report: dict[str, Any], holder: BadgeHolder, authority: str) -> list[Broken]:
    """Where a report says something else of its badge than the registry."""
    badge, faults = report["badge"], []
    if not holder.erased and not _same(badge["name"], holder.name):
        words = f"The registry says that this badge is {holder.name[:80]!r}'s, and not {badge['name'][:80]!r}'s."
        faults.append(Broken("badge", words))
    asked = report["registry"]
    if asked is None:
        words = (
            "No registry was asked when the film was judged, so the badge was what a file said; judge the film again "
            "by a claim, with a registry or its bundle."
        )
        faults.append(Broken("registry", words))
    elif asked["fingerprint"] != authority:
        words = f"The badge was looked up at authority {asked['fingerprint']}, and this is another registry."
        faults.append(Broken("registry", words))
    return faults


def _same(one: str, other: str) -> bool:
    return unicodedata.normalize("NFC", one).strip() == unicodedata.normalize("NFC", other).strip()
