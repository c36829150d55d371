"""What is the case, in one line by name.  Each test states the wrong implementation that it would catch.

The documents are as `verify --json` prints them, put together by hand.
"""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from kit.report_documents import ASKED, NOW, REGISTRY, document, finding
from moireid.provenance import BadgeHolder, Revocation
from moireid.verifier.report.circumstances import Circumstances, claimed_in
from moireid.verifier.report.finding_words import CAUSES, WEIGHTIEST, sorted_findings
from moireid.verifier.report.headline import headline_of
from moireid.verifier.report.report_page import SAYS_NOT

ROOT = Path(__file__).parents[3]


def title(said: dict[str, Any], known: Circumstances = ASKED) -> str:
    return headline_of(said, known).title


def test_a_genuine_badge_is_its_holder_s() -> None:
    """Catches: a verdict without a name; figures of enrolment of which the page says nothing, and the word original."""
    found = headline_of(document("accept"), ASKED)
    assert (found.colour, found.mark, found.title) == ("accept", "✓", "Genuine, and Sarah Example's")
    whole = document("accept")
    whole["identity"]["built"] = "agrees"
    assert "measured at enrolment" in headline_of(whole, ASKED).text and "copy" not in found.text
    whole["identity"]["built_since"] = "2026-05-03T10:00:00Z"
    assert "on record since 3 May; a copy" in headline_of(whole, ASKED).text


def test_no_page_says_that_a_film_shows_the_piece_that_was_issued() -> None:
    """Catches: a page that calls a film computed to agree the issued badge, or its fringes a real badge's alone."""
    whole = document("accept")
    whole["identity"]["built"] = "agrees"
    for one in (whole, document("accept"), document("reject", finding("built"))):
        words = " ".join(vars(headline_of(one, ASKED)).values())
        assert not re.search(r"only a real|original|the one that was issued|not the piece", words)
    assert "What it takes to pass" in SAYS_NOT and "## What it takes to pass" in (ROOT / "THREATS.md").read_text()


def test_nobody_vouches_for_a_name_in_a_file() -> None:
    """Catches: a headline that says of a file's name what only a registry's may be said of."""
    for verdict, reasons in (("accept", ()), ("reject", (finding("identity"),))):
        identity = "match" if verdict == "accept" else "mismatch"
        found = headline_of(document(verdict, *reasons, identity=identity, claim_source="file"), Circumstances(NOW))
        assert "Sarah" not in f"{found.title} {found.text} {found.advice}"
    bundle, until = document("accept", claim_source="bundle"), replace(REGISTRY, expires="2026-05-12T08:00:00Z")
    found = headline_of(bundle, Circumstances(NOW, standing=until))
    assert found.title == "Genuine, and Sarah Example's" and "a bundle that counts until 12 May." in found.text
    assert "bundle" not in headline_of(document("accept"), ASKED).text


def test_a_sealed_claim_is_told_as_sealed() -> None:
    """Catches: "no identity" of a claim that has one; a badge of which nobody looked whose it is, called nobody's."""
    other = document("reject", finding("identity"), identity="mismatch", claim_source="bundle")
    assert claimed_in(other).holder == "Sarah Example"
    other["identity"]["claimed_id"] = None
    assert claimed_in(other).holder == "Sarah Example (identity sealed)"
    known = Circumstances(NOW, standing=replace(REGISTRY, expires="2026-05-12T08:00:00Z"))
    assert title(other, known) == "Genuine, but held by no one in this bundle, and not Sarah Example's"


def test_another_s_badge_is_named_where_the_registry_knows_it() -> None:
    """Catches: the claimed name for the read one; "genuine" where the law is open; a revocation that is passed over."""
    other = document("reject", finding("identity"), identity="mismatch")
    ada = Circumstances(NOW, read=BadgeHolder("Ada Lovelace"), standing=REGISTRY)
    assert title(other, ada) == "Genuine, but Ada Lovelace's, not Sarah Example's"
    assert title(other) == "Genuine, but held by no one in this registry, and not Sarah Example's"
    assert title(other, Circumstances(NOW)) == "Genuine, but another badge, not Sarah Example's"
    vague = document("reject", finding("identity"), law="inconclusive", identity="mismatch")
    assert title(vague, ada) == "Another badge: Ada Lovelace's, not Sarah Example's"
    gone = Circumstances(
        NOW, read=BadgeHolder("Ada Lovelace", Revocation("2025-12-31T23:59:00Z", "stolen")), standing=REGISTRY
    )
    assert "revoked on 31 December 2025: stolen" in headline_of(other, gone).text


def test_a_badge_of_two_is_nobody_s() -> None:
    """Catches: a forger who glues Ada's code upon his own rows, and has the page say that the badge is Ada's."""
    glued = document("reject", finding("beats"), identity="mismatch")
    ada = Circumstances(NOW, read=BadgeHolder("Ada Lovelace"), standing=REGISTRY)
    assert title(glued, ada) == "Put together from two badges"
    assert "Ada" not in headline_of(glued, ada).text


@pytest.mark.parametrize("law", ["accept", "reject", "inconclusive"])
@pytest.mark.parametrize("identity", ["match", "mismatch", "unreadable"])
def test_a_revocation_is_told_before_all_else(law: str, identity: str) -> None:
    """Catches: a revoked badge whose page is about its fringes, or its name, with the revocation further down."""
    others = [finding("gain", measured=0.5), finding("identity"), finding("name")]
    known = Circumstances(NOW, barred=Revocation("2026-05-03T08:00:00Z", "lost on the train"), standing=REGISTRY)
    gone = document("reject", *others, finding("revoked", measured="lost on the train"), law=law, identity=identity)
    found = headline_of(gone, known)
    assert found.title == "Revoked on 3 May: lost on the train"
    assert ("genuine" in found.text) == (law == "accept" and identity == "match")
    assert ("follow the law" in found.text) == (law == "reject")
    assert sorted_findings(gone["reasons"]).first[0]["code"] == "revoked"


def test_what_bars_a_badge_is_the_headline_with_its_day() -> None:
    """Catches: a revoked badge whose page is about its fringes."""
    barred, words = Revocation("2026-05-03T08:00:00Z", "stolen"), "Revoked on 3 May: stolen"
    measured = finding("revoked", measured=barred.reason)
    claimed = document("reject", finding("gain", measured=0.5), measured, identity="match")
    found = headline_of(claimed, Circumstances(NOW, barred=barred, standing=REGISTRY))
    assert found.title == words and sorted_findings(claimed["reasons"]).first[0]["code"] == "revoked"
    nobody = document("accept", finding("enrolled"), identity="not_claimed") | {"finding": "nobody", "found_id": None}
    holder = Circumstances(NOW, read=BadgeHolder("Ada Lovelace", barred), standing=REGISTRY)
    assert title(nobody, holder) == words
    other = document("reject", finding("identity"), identity="mismatch")
    assert f"It was {words[0].lower()}{words[1:]}." in headline_of(other, holder).text


def test_each_finding_stands_in_one_group() -> None:
    """Catches: a finding lost or stated twice; a warning that is folded away."""
    levels = ("pass", "fail", "undecided", "note")
    reasons = [finding(code, level) for code in (*WEIGHTIEST, *CAUSES, "copyable", "unheard_of") for level in levels]
    found = sorted_findings(reasons)
    output = [*found.fail, *found.open, *found.warn, *found.hold, *found.rest]
    assert len(output) == len(reasons) and all(one in output for one in reasons)
    assert [one["code"] for one in found.warn] == ["tracks", "damaged", "covered", "copyable"]
    assert {one["level"] for one in found.first} == {"fail", "undecided", "note"}
