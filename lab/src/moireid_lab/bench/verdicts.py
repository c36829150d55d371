"""What a row keeps of a report, and how verdicts are called and coloured in tables and plots."""

from __future__ import annotations

from typing import Any

from moireid.verifier import Report

VERDICTS = {"accept": "accept", "inconclusive": "open", "reject": "reject"}
#: None looks like praise or alarm: an accepted forgery is a failure, an accepted badge none.
COLOURS = {"accept": "#22577a", "inconclusive": "#d3dae2", "reject": "#d98a3d"}


def verdict_row(report: Report) -> dict[str, Any]:
    """What a row keeps of a report."""
    motion = report.invariant
    return {
        "verdict": report.verdict,
        "why": [reason.code for reason in report.reasons if reason.level in ("fail", "undecided")],
        "gain": motion.gain_ratio,
        "score": motion.score,
        "correlation": motion.correlation,
        "excitation_rad": motion.excitation_rad,
    }
