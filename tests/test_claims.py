"""The ledger of claims (tests/claims.md)."""

from __future__ import annotations

from kit.claims import LEDGER, claims, ledger


def test_the_ledger_is_that_of_the_tests() -> None:
    """Catches: a claim whose test is gone or marked anew since `make claims`; one claim that two tests hold."""
    texts = [text for text, _, _ in claims()]
    assert texts and len(set(texts)) == len(texts)
    assert LEDGER.read_text(encoding="utf-8") == ledger()
