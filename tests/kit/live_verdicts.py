"""Verdicts of a live check in which Sarah was claimed, and their headlines."""

from __future__ import annotations

from datetime import UTC, datetime
from typing import Any

from moireid.provenance import Standing
from moireid.verifier.report.circumstances import Circumstances
from moireid.verifier.report.headline import Headline
from moireid_studio.challenge.live_headline import live_headline_of

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
    """Its headline; known: what is known around the check."""
    return live_headline_of(event, "Sarah Example", known)
