"""Receipts of live checks on a film's report.  Each test names the wrong implementation it catches."""

from __future__ import annotations

import json
from typing import Any

import msgspec
import pytest

from moireid.errors import SpecError
from moireid.provenance import Standing
from moireid.sandbox.seal import MEANS
from moireid.verifier.report.live_receipt import (
    FilmAsked,
    LiveReceipt,
    attached,
    receipt_of,
)
from moireid.verifier.session.result import report_schema

FILM = FilmAsked("rally.mp4", "ab" * 32)
OURS = Standing("c0ffee" * 5 + "c0", "3:" + "cd" * 32)
PASSED = LiveReceipt("watch", "Ada Lovelace", "2026-05-07T14:05:00+00:00", "accept", "ef" * 32, True, film=FILM)
REPORT: dict[str, Any] = {"verdict": "accept"}


def test_a_receipt_is_read_as_it_was_written() -> None:
    """Catches: a receipt that loses what it is about, or when; one that changes the film's verdict."""
    known = msgspec.structs.replace(PASSED, registry=OURS)
    found = attached(REPORT, [known])
    assert found["verdict"] == "accept" and receipt_of(found["live_checks"][0]) == known
    assert known.words == ("A live check of Ada Lovelace about this film was passed; it ended on 2026-05-07 14:05 UTC.")
    assert "live_checks" not in attached(REPORT, [])


def test_a_receipt_says_how_the_pictures_were_read() -> None:
    """Catches: a receipt that loses the seal, so that a check whose decoder could reach everything looks like another;
    parts of a seal that the seal does not know; an older receipt said to be without a seal.
    """
    parts = tuple(MEANS)
    known = msgspec.structs.replace(PASSED, sealed=parts, decoder="FFmpeg 8")
    assert known.words.endswith(f"in a process with these parts of a seal: {', '.join(parts)}.")
    assert msgspec.structs.replace(known, sealed=()).words.endswith("by FFmpeg 8 in a process without a seal.")
    assert "seal" not in PASSED.words
    schema = json.loads(report_schema())["properties"]["live_checks"]["items"]["properties"]
    assert schema["sealed"]["items"]["enum"] == list(parts) and "decoder" in schema
    found = attached(REPORT, [known])["live_checks"][0]
    assert (found["sealed"], found["decoder"]) == (list(parts), "FFmpeg 8")


def test_a_receipt_says_whether_prompts_were_drawn() -> None:
    """Catches: words that make of what a receipt does not say that prompts were drawn."""
    silent = {name: value for name, value in PASSED.to_json().items() if name != "challenged"}
    with pytest.raises(SpecError, match="challenged"):
        receipt_of(silent)
    assert "prompts" not in PASSED.words
    assert "without prompts" in msgspec.structs.replace(PASSED, challenged=False).words


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
