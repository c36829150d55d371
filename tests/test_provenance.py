"""Seals of identities.  Each test names the wrong implementation it catches."""

from __future__ import annotations

import hashlib

from moireid.provenance import SEAL_ROUNDS, Seal


def test_a_seal_opens_for_its_identity_alone():
    """Catches: a seal of the digits, which depends on their case; one without its salt; one that is quickly guessed."""
    seal = Seal.of("0011223344556677", b"s" * 16)
    assert seal.holds("0011223344556677") and not seal.holds("0011223344556678")
    assert Seal.of("aabb", b"s" * 16).holds("AABB")
    assert seal != Seal.of("0011223344556677", b"t" * 16)
    assert seal.digest == hashlib.pbkdf2_hmac("sha256", bytes.fromhex("0011223344556677"), b"s" * 16, SEAL_ROUNDS)
    assert SEAL_ROUNDS >= 1000 and len(seal.digest) == 32
