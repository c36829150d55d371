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


def bars(found: Seconds, label: str) -> list[tuple[float, float, str]]:
    return [(bar.at, bar.width, bar.kind) for bar in dict(found.rows)[label]]


def test_bars_lie_where_the_badge_was() -> None:
    """Catches: a bar over the track's time and not the film's, so that 2 s of badge fill it; seen taken for judged."""
    found = output([[10.0, 16.0]], [[12.0, 13.5]], (0.0, 30.0))
    assert bars(found, "badge seen") == [(pytest.approx(100 / 3), pytest.approx(20.0), "seen")]
    assert bars(found, "judged") == [(pytest.approx(40.0), pytest.approx(5.0), "judged")]
    late = output([[12.0, 13.0]], [[12.0, 13.0]], (10.0, 20.0))
    assert bars(late, "judged") == [(pytest.approx(20.0), pytest.approx(10.0), "judged")] and late.end == "10.0 s"


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


def test_the_law_is_shown_only_where_the_badge_was_seen() -> None:
    """Catches: a green bar across seconds in which nobody saw a badge."""
    part = {"start_s": 4.0, "end_s": 8.0, "tracked": 30, "verdict": "accept"}
    unseen = {"start_s": 8.0, "end_s": 12.0, "tracked": 0, "verdict": "inconclusive"}
    found = output([[4.0, 5.0], [7.0, 8.0]], [], (0.0, 20.0), (part, unseen))
    assert [(at, width) for at, width, _ in bars(found, "the law")] == [(20.0, 5.0), (35.0, 5.0)]
    assert found.kinds == (("accept", "the law holds"),)


def test_seen_spans_break_where_frames_are_missing() -> None:
    """Catches: one span from the first to the last frame; a film's own rate taken for a gap."""
    times = np.concatenate([np.arange(60) / 30, 5 + np.arange(30) / 30])
    assert seen_spans(times) == ((0.0, pytest.approx(59 / 30)), (5.0, pytest.approx(5 + 29 / 30)))
    assert seen_spans(np.zeros(0)) == ()
    cover = cover_of([], 0.0, 10.0, 301, [(2.0, 3.0), (0.0, 1.0), (1.02, 2.0)])
    assert cover.seen_s == ((0.0, 3.0),) and cover.film_s == (0.0, 10.0) and cover.share == 0.0
