"""Reports as `verify --json` prints them, put together by hand."""

from __future__ import annotations

from datetime import UTC, datetime
from typing import Any

from moireid.provenance import Standing
from moireid.verifier.report.circumstances import Circumstances

NOW = datetime(2026, 5, 7, 12, 0, tzinfo=UTC)
REGISTRY = Standing("c0ffee" * 5, "3:" + "ab" * 32)
ASKED = Circumstances(NOW, standing=REGISTRY)
ADA, SARAH = "aa" * 8, "bb" * 8


def finding(code: str, level: str = "fail", measured: Any = None, unit: str = "") -> dict[str, Any]:
    return {"code": code, "level": level, "measured": measured, "limit": None, "unit": unit, "text": f"About {code}."}


LAW_ROW = {"name": "law", "log10_odds": 0.0, "share": None, "fits": False, "parameters": {"gain": 0.1}}


def rival(name: str, log10_odds: float | None, **parameters: float) -> dict[str, Any]:
    """One explanation of a report's table, which leaves little of the film if nothing else is said."""
    fits = log10_odds is not None and log10_odds < -1
    parameters = {"deviation_rad": 0.01, "explains_below_rad": 0.1} | parameters
    return {"name": name, "log10_odds": log10_odds, "share": None, "fits": fits, "parameters": parameters}


def document(verdict: str, *reasons: dict[str, Any], law="accept", identity="match", **more: Any) -> dict[str, Any]:
    """A report on a film that was claimed to show Sarah's badge."""
    figures = {"excitation_rad": 0.8, "phase_residual_rad": 0.01, "gain_ratio": 1.0, "gain_expected": 1.0}
    return {
        "verdict": verdict,
        "reasons": list(reasons),
        "claim_source": "registry",
        "badge": {"name": "Sarah Example"},
        "invariant": {"verdict": law, **figures, **more.pop("figures", {})},
        "identity": {"verdict": identity, "decoded_id": ADA, "claimed_id": SARAH, "built": "not_known"},
    } | more
