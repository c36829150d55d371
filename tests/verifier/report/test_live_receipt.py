"""Receipts of live checks on a film's report.  Each test names the wrong implementation it catches."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

import msgspec
import pytest

from moireid.errors import SpecError
from moireid.provenance import Standing
from moireid.verifier.report.live_receipt import (
    FilmAsked,
    LiveReceipt,
    attached,
    check_belongs,
    load_receipt,
    receipt_of,
)

FILM = FilmAsked("rally.mp4", "ab" * 32)
OURS = Standing("c0ffee" * 5 + "c0", "3:" + "cd" * 32)
PASSED = LiveReceipt("watch", "Ada Lovelace", "2026-05-07T14:05:00+00:00", "accept", True, "ef" * 32, film=FILM)
REPORT: dict[str, Any] = {
    "verdict": "accept",
    "badge": {"id": "0123456789abcdef", "name": "Ada Lovelace"},
    "input": {"sha256": FILM.sha256},
    "registry": asdict(OURS),
}


def test_a_receipt_is_read_as_it_was_written(tmp_path: Path) -> None:
    """Catches: a receipt that loses what it is about, or when; one that changes the film's verdict."""
    path = tmp_path / "receipt.json"
    known = msgspec.structs.replace(PASSED, registry=OURS)
    path.write_text(json.dumps(known.to_json()))
    assert load_receipt(path) == known
    found = attached(REPORT, [known])
    assert found["verdict"] == "accept" and receipt_of(found["live_checks"][0]) == known
    assert known.words == ("A live check of Ada Lovelace about this film was passed; it ended on 2026-05-07 14:05 UTC.")
    assert "live_checks" not in attached(REPORT, [])


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"claim": "Grace Hopper"}, "Grace Hopper"),
        ({"film": FilmAsked("other.mp4", "cd" * 32)}, "other.mp4"),
        ({"registry": Standing("beef" * 8, "3:" + "cd" * 32)}, "another registry"),
    ],
)
def test_a_receipt_of_another_matter_is_not_attached(change: dict[str, Any], words: str) -> None:
    """Catches: another person's live check, or one about another film, that makes a forged film look confirmed."""
    check_belongs(PASSED, REPORT)
    check_belongs(msgspec.structs.replace(PASSED, film=None, registry=OURS), REPORT)
    with pytest.raises(SpecError, match=words):
        check_belongs(msgspec.structs.replace(PASSED, **change), REPORT)


@pytest.mark.parametrize(
    "change",
    [
        {"verdict": "original"},
        {"report_sha256": "short"},
        {"claim": "Ada\u001b[2J"},
        {"film": {"name": "a"}},
        {"format": 2},
        {"more": 1},
        {"challenged": "yes"},
    ],
)
def test_a_damaged_receipt_is_a_sentence(change: dict[str, Any], tmp_path: Path) -> None:
    """Catches: a traceback; words that steer a terminal; a verdict that no live check gives."""
    path = tmp_path / "receipt.json"
    path.write_text(json.dumps(PASSED.to_json() | change))
    with pytest.raises(SpecError) as refused:
        load_receipt(path)
    assert str(path) in str(refused.value) and "\n" not in str(refused.value)
    path.write_text("[1")
    with pytest.raises(SpecError, match="not JSON"):
        load_receipt(path)
    with pytest.raises(SpecError, match="cannot be read"):
        load_receipt(tmp_path / "none.json")
