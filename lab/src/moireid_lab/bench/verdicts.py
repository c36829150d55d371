"""What a row keeps of a report."""

from __future__ import annotations

from typing import Any

from moireid.verifier import Report
from moireid_lab.bench.part import why_not


def verdict_row(report: Report) -> dict[str, Any]:
    """What a row keeps of a report."""
    motion = report.invariant
    return {
        "verdict": report.verdict,
        "why": why_not(report),
        "gain": motion.gain_ratio,
        "score": motion.score,
        "correlation": motion.correlation,
        "excitation_rad": motion.excitation_rad,
    }
