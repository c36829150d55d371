"""Each headline that the page of a report can have, from a report that has it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from kit.report_documents import ADA, ASKED, LAW_ROW, REGISTRY, document, finding, rival
from moireid.provenance import BadgeHolder, Revocation, Standing
from moireid.verifier.explanations.words import WORDS
from moireid.verifier.report.headline import BROKEN, headline_of


def read_by(name: str, **how: Any) -> Any:
    return replace(ASKED, read=BadgeHolder(name, **how))


def cases() -> Iterator[tuple[dict[str, Any], Any]]:
    """A report, and its circumstances, for each headline."""
    bundle = replace(ASKED, standing=Standing("c0ffee" * 5, REGISTRY.head, expires="2026-05-12T08:00:00Z"))
    yield document("accept") | {"finding": "found", "found_id": ADA, "found_name": "Ada"}, ASKED
    yield document("accept", identity="not_claimed"), ASKED
    yield document("accept", claim_source="file"), ASKED
    yield document("accept"), bundle
    yield document("inconclusive", finding("motion", "undecided"), law="inconclusive"), ASKED
    yield document("inconclusive"), ASKED
    yield document("reject", finding("revoked", measured="lost")), ASKED
    yield document("reject", finding("revoked")), replace(ASKED, barred=Revocation("2026-05-03", "lost"))
    for name in ("still", "drift", "late", "place"):
        table = [LAW_ROW, rival(name, -9.0)]
        yield document("reject", finding("residual"), law="reject", explanations=table), ASKED
    for code in BROKEN:
        yield document("reject", finding(code, measured=-4.0), law="reject"), ASKED
    for code in ("gain", "cells_move", "name", "enrolled", "identities", "beats", "identity", "built", "odd"):
        yield document("reject", finding(code, measured=0.5), identity="mismatch"), ASKED
    another = document("reject", finding("identity"), identity="mismatch")
    yield another, read_by("Ada Lovelace")
    yield another, read_by("Sarah Example", line="Editor")
    gone = read_by("Ada", barred=Revocation("2026-05-03", "lost"))
    yield document("accept", finding("enrolled")) | {"finding": "nobody", "found_id": None}, gone


def test_each_headline_is_a_title_with_advice() -> None:
    """Catches: a report on which the page ends in an error, or says nothing."""
    titles = set()
    for report, known in cases():
        found = headline_of(report, known)
        titles.add(found.title)
        assert found.title and found.advice.endswith((".", "?")) and found.text.endswith("."), found
    for words in (*(WORDS[name].does for name in ("still", "drift", "late", "place")), *BROKEN.values()):
        assert any(words in title for title in titles), words
