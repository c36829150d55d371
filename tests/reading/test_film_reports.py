"""What a process answers that a film has taken over.  Each test names the wrong implementation it catches."""

from __future__ import annotations

import hashlib
from pathlib import Path

import pytest

from moireid import __version__
from moireid.badge import Badge
from moireid.errors import MediaError
from moireid.provenance import Exclusion
from moireid.reading.film_orders import JudgingOrder
from moireid.reading.film_reports import judged_film
from moireid.verifier import Claim


class TakenOver:
    """A reader that answers what the attacker likes."""

    sealed = ("network",)

    def __init__(self, report: dict[str, object]) -> None:
        self.report = report

    def read(self, order, progress, answer=None):
        return {"result": self.report}


@pytest.fixture
def film(tmp_path: Path) -> Path:
    path = tmp_path / "film.mp4"
    path.write_bytes(b"a film")
    return path


def report_of(film: Path, **more: object) -> dict[str, object]:
    return {"verdict": "accept", "input": {"sha256": hashlib.sha256(film.read_bytes()).hexdigest()}} | more


def test_what_a_film_cannot_show_is_stated_by_this_process(film: Path, ada: Badge) -> None:
    """Catches: a signed report with a live check, a detector or a version that a film has made up."""
    lies = {"live_checks": [{"verdict": "accept"}], "detectors": [{"name": "lips", "score": 0.9}], "moireid": "99.9"}
    order = JudgingOrder(film, Claim(ada, ada.id), detectors=(("ours", 0.25),))
    found = judged_film(order, TakenOver(report_of(film, **lies)), lambda *_: None).report
    assert "live_checks" not in found and found["moireid"] == __version__
    assert found["detectors"] == [{"name": "ours", "score": 0.25}]


def test_a_badge_that_no_longer_counts_is_never_accepted(film: Path, ada: Badge) -> None:
    """Catches: a revocation that only the process knows of that reads the film."""
    barred = Exclusion("revoked", "2026-01-01T00:00:00Z", "lost")
    with pytest.raises(MediaError, match="no longer counts"):
        judged_film(JudgingOrder(film, Claim(ada, ada.id), barred), TakenOver(report_of(film)), lambda *_: None)
