"""What a prompt shows of an object is one line with what matters."""

from __future__ import annotations

from dataclasses import replace

from moireid.designer import Order, design_badge
from moireid.registry import Record

BADGE = design_badge(Order("Ada Lovelace", lens="50lpi"), bytes(range(8)))


def test_a_record_is_one_line_with_its_state() -> None:
    """Catches: the badge's JSON in the line; a salt that a log would keep; a revoked badge that looks like others."""
    record = Record("00ff", "Ada", BADGE.to_json(), "2026-01-31T12:00:00Z", "key", salt="5a17")
    assert repr(record) == "Record('Ada', id='00ff', issued 2026-01-31)"
    later = replace(record, as_built="{}", as_built_at="2026-02-01T00:00:00Z", revoked_at="2026-03-01T00:00:00Z")
    assert repr(later) == "Record('Ada', id='00ff', issued 2026-01-31, measured 2026-02-01, revoked)"
    assert "expired" in repr(replace(record, expires="2026-02-01"))
