"""The headline of a live check, by name.  Each test states the wrong implementation that it would catch."""

from __future__ import annotations

from datetime import UTC, datetime
from typing import Any

import pytest

from moireid.provenance import BadgeHolder, Standing
from moireid.verifier.report.circumstances import Circumstances
from moireid.verifier.report.headline import Headline
from moireid_studio.challenge.live_headline import LIVE, live_headline_of, shown

ASKED = Circumstances(datetime(2026, 5, 7, tzinfo=UTC), standing=Standing("c0ffee" * 5, "3:" + "ab" * 32))
ADA, SARAH = "aa" * 8, "bb" * 8


def said(verdict: str, *fails: str, challenged: bool = True, level: str = "fail", **more: Any) -> dict[str, Any]:
    """A verdict's event, of a check in which Sarah was claimed."""
    reasons = [
        {"code": code, "level": level, "measured": 0.0, "limit": None, "unit": "", "text": f"About {code}."}
        for code in fails
    ]
    return {
        "event": "verdict",
        "verdict": verdict,
        "challenged": challenged,
        "reasons": reasons,
        "claim_source": "registry",
        "invariant": {"verdict": "accept", "excitation_rad": 0.8, "gain_ratio": 1.0, "gain_expected": 1.0},
        "identity": {"verdict": "match", "decoded_id": SARAH, "claimed_id": SARAH, "built": "not_known"},
    } | more


def headline(event: dict[str, Any], known: Circumstances = ASKED) -> Headline:
    return live_headline_of(event, "Sarah Example", known)


def test_only_a_challenge_makes_it_live() -> None:
    """Catches: "live" said of a check without prompts, in which an old film passes."""
    assert headline(said("accept")).title == "Genuine, live, and Sarah Example's"
    unasked = headline(said("accept", challenged=False))
    assert unasked.title.endswith("but perhaps not live") and "may be an old film" in unasked.text
    assert shown(unasked)["mark"] == "✓" and set(shown(unasked)) == {"mark", "colour", "title", "text", "advice"}


@pytest.mark.parametrize("code", LIVE)
def test_what_fails_of_the_challenge_alone_is_named(code: str) -> None:
    """Catches: "Not accepted" for a replay; a film's advice where people can begin again."""
    found = headline(said("reject", code))
    assert found.title == LIVE[code][0] and f"About {code}." in found.text and "film as" not in found.advice
    assert found.colour == "reject"


def test_the_law_and_the_name_come_before_the_challenge() -> None:
    """Catches: a broken law, or another's badge, hidden behind a prompt that was not followed either."""
    broken = headline(said("reject", "gain", "prompt", invariant={"verdict": "reject", "gain_ratio": 0.0}))
    assert broken.title.startswith("The fringes do not follow the law")
    identity = {"verdict": "mismatch", "decoded_id": ADA, "claimed_id": SARAH}
    known = Circumstances(ASKED.checked_at, standing=ASKED.standing, read=BadgeHolder("Ada Lovelace"))
    other = headline(said("reject", "identity", "clock", identity=identity), known)
    assert other.title == "Genuine, but Ada Lovelace's, not Sarah Example's"


def test_an_open_check_says_how_to_begin_again() -> None:
    """Catches: advice to ask for another film of somebody who stands before the camera."""
    for code in ("motion", "motion_gaps", "drift", "challenge", "badge_absent", "fringes"):
        found = headline(said("inconclusive", code, level="undecided"))
        assert found.title.startswith("Cannot tell: ") and found.advice.startswith("Begin again")
        assert "film" not in found.text + found.advice
