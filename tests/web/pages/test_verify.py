"""The pages of a film and its verdict, as they come without script.  Beside each test: what it would catch."""

from __future__ import annotations

from pathlib import Path

import pytest

from kit.webbing import Visit, badge_film, film_form, studio, tiny_film
from moireid.badge import Badge


def judged(visit: Visit, film: Path, **fields: str) -> str:
    """The page of the verdict on a film that was sent by the form."""
    begun = visit.ask("POST", "/verify", "verifier", **film_form(film, **fields))
    assert begun.status_code == 303, begun.text
    path = begun.headers["location"]
    waiting = visit.ask("GET", path, "verifier").text
    assert "Judging the film" in waiting and 'http-equiv="refresh"' in waiting
    visit.wait(path.rpartition("/")[2], "verifier")
    page = visit.ask("GET", path, "verifier")
    assert page.status_code == 200, page.text
    return page.text


def test_whose_badge_it_is_ends_in_a_page(
    ada: Badge, films: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Catches: a page that asks for the picture of the badge, which only a verification keeps; a badge that was revoked
    and is still found.
    """
    monkeypatch.setenv("MOIREID_KEYS", str(tmp_path / "keys"))
    hers, other = badge_film(ada, tmp_path / "ada.mp4"), tiny_film(films / "genuine_1.0m.mp4", tmp_path / "other.mp4")
    with studio(tmp_path, ada) as visit:
        page = judged(visit, hers, kind="identify")
        assert "<h1>✓ Ada Lovelace</h1>" in page and f"<code>{ada.id}</code>" in page and "claimed" not in page
        assert "<h1>? Inconclusive</h1>" in judged(visit, other, kind="identify")
        visit.studio.registry.revoke("Ada Lovelace", "lost")
        assert "<h1>✗ Nobody</h1>" in judged(visit, hers, kind="identify")


def test_a_registry_of_nobody_still_answers(films: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Catches: a page that takes the film's figures for granted, which nobody measured where nobody is enrolled."""
    monkeypatch.setenv("MOIREID_KEYS", str(tmp_path / "keys"))
    film = tiny_film(films / "genuine_1.0m.mp4", tmp_path / "film.mp4")
    with studio(tmp_path) as visit:
        assert "<h1>✗ Nobody</h1>" in judged(visit, film, kind="identify")


def test_a_verdict_whose_report_was_not_drawn_is_shown(
    ada: Badge, films: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Catches: a page that fails where the report's plots are not there; a link to a report that is not."""
    monkeypatch.setenv("MOIREID_KEYS", str(tmp_path / "keys"))
    film = tiny_film(films / "genuine_1.0m.mp4", tmp_path / "film.mp4")
    with studio(tmp_path, ada) as visit:
        begun = visit.ask("POST", "/verify", "verifier", **film_form(film, claim="Ada Lovelace"))
        job_id = begun.headers["location"].rpartition("/")[2]
        visit.wait(job_id, "verifier")
        visit.studio.jobs._jobs[job_id].kept = {}
        page = visit.ask("GET", f"/verify/{job_id}", "verifier")
    assert page.status_code == 200 and "? Inconclusive" in page.text and "/report" not in page.text
