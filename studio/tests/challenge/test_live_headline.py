"""The headline of a live check, by name.  Each test states the wrong implementation that it would catch."""

from __future__ import annotations

import pytest

from kit.live_verdicts import ADA, ASKED, SARAH, headline, said
from moireid.provenance import BadgeHolder
from moireid.verifier.report.circumstances import Circumstances
from moireid_studio.challenge.live_headline import LIVE, shown


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
    """Catches: advice to ask for another film of someone who is in front of the camera."""
    for code in ("motion", "motion_gaps", "drift", "challenge", "badge_absent", "fringes"):
        found = headline(said("inconclusive", code, level="undecided"))
        assert found.title.startswith("Cannot tell: ") and found.advice.startswith("Begin again")
        assert "film" not in found.text + found.advice
