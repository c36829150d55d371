"""Of which seconds the verdict speaks.  Each test states the wrong implementation that it would catch."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from moireid.verifier.report.seconds import Seconds, seconds_of
from moireid.verifier.session.cover import cover_of, seen_spans


def output(seen: Any, judged: Any, film: Any = (0.0, 30.0), segments: Any = (), share: float = 0.1) -> Seconds:
    cover = {"share": share, "spans_s": judged, "longest_gap_s": 1.0, "film_s": film, "seen_s": seen}
    found = seconds_of({"cover": cover, "segments": list(segments)})
    assert found is not None
    return found


def test_what_is_not_judged_is_said() -> None:
    """Catches: 2 s of badge taken as a proof of 30 s of film; a gap before the first span or after the last lost."""
    text = output([[10.0, 12.0]], [[10.0, 12.0]]).text
    assert "10 % of the film's 30.0 s" in text and "not cover 0.0 to 10.0 s, 12.0 to 30.0 s." in text
    assert "No part of it is left out" in output([[0.0, 30.0]], [[0.0, 30.0]], share=1.0).text
    assert "No more than a moment of it" in output([[0.1, 29.9]], [[0.1, 29.9]], share=0.99).text
    assert "none of them could be judged" in output([[1.0, 3.0]], []).text
    assert "not followed anywhere" in output([], []).text
    many = [[float(k), k + 0.4] for k in range(0, 30, 2)]
    assert output(many, many).text.endswith("and more.")


def test_seen_spans_break_where_frames_are_missing() -> None:
    """Catches: one span from the first to the last frame; a film's own rate taken for a gap."""
    times = np.concatenate([np.arange(60) / 30, 5 + np.arange(30) / 30])
    assert seen_spans(times) == ((0.0, pytest.approx(59 / 30)), (5.0, pytest.approx(5 + 29 / 30)))
    assert seen_spans(np.zeros(0)) == ()
    cover = cover_of([], 0.0, 10.0, 301, [(2.0, 3.0), (0.0, 1.0), (1.02, 2.0)])
    assert cover.seen_s == ((0.0, 3.0),) and cover.film_s == (0.0, 10.0) and cover.share == 0.0
