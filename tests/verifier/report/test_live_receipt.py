"""Receipts of live checks on a film's report.  Each test names the wrong implementation it catches."""

from __future__ import annotations

import json
from typing import Any

import msgspec
import pytest

from moireid.errors import SpecError
from moireid.provenance import Standing
from moireid.verifier.report.live_receipt import (
    FilmAsked,
    LiveReceipt,
    attached,
    receipt_of,
)

FILM = FilmAsked("rally.mp4", "ab" * 32)
OURS = Standing("c0ffee" * 5 + "c0", "3:" + "cd" * 32)
PASSED = LiveReceipt("one-time link", "Ada Lovelace", "2026-05-07T14:05:00+00:00", "accept", "ef" * 32, True, film=FILM)
REPORT: dict[str, Any] = {"verdict": "accept"}


def test_a_receipt_is_read_as_it_was_written() -> None:
    """Catches: a receipt that loses what it is about, or when; one that changes the film's verdict."""
    known = msgspec.structs.replace(PASSED, registry=OURS)
    found = attached(REPORT, [known])
    assert found["verdict"] == "accept" and receipt_of(found["live_checks"][0]) == known
    assert known.words == ("A live check of Ada Lovelace about this film was passed; it ended on 2026-05-07 14:05 UTC.")
    assert "live_checks" not in attached(REPORT, [])


def test_a_film_s_name_is_a_line_that_can_be_read_again() -> None:
    """Catches: a name, which a stranger chose, by which a report cannot be shown, or a receipt not read again."""
    for name in ("a\tb\x1b[2J\u202e.mp4", "x" * 900, "\udcff.mp4", ""):
        film = FilmAsked.of(name, FILM.sha256)
        assert film.name.isprintable()
        json.dumps(film.name, ensure_ascii=False).encode()
        assert receipt_of(msgspec.structs.replace(PASSED, film=film).to_json()).film == film


@pytest.mark.parametrize(
    "change",
    [
        {"verdict": "original"},
        {"report_sha256": "short"},
        {"claim": "Ada\u001b[2J"},
        {"claim": "Ada\n"},
        {"claim": "Ada\u009b2J"},
        {"claim": "Ada\u2028"},
        {"report_sha256": "ef" * 32 + "\n"},
        {"ended_at": "all agree"},
        {"title": "x" * 501},
        {"film": {"name": "a"}},
        {"format": 2},
        {"more": 1},
        {"challenged": "yes"},
        {"sealed": ["all"]},
        {"decoder": "FFmpeg\u001b[2J"},
    ],
)
def test_a_damaged_receipt_is_a_sentence(change: dict[str, Any]) -> None:
    """Catches: a traceback; words that steer a terminal; a verdict that no live check gives."""
    with pytest.raises(SpecError) as refused:
        receipt_of(PASSED.to_json() | change)
    assert "a receipt" in str(refused.value) and "\n" not in str(refused.value)
