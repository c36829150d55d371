"""The pages of a film and its verdict, as they come without script.  Each test names what it would catch."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from kit.payloads import payload_for_name
from kit.webbing import Visit, badge_film, film_form, studio, tiny_film
from moireid.badge import Badge
from moireid.designer import Order, design_badge


def judged(visit: Visit, film: Path, **fields: str) -> str:
    """The page of the verdict on a film that was sent by the form."""
    begun = visit.ask("POST", "/verify", "verifier", **film_form(film, **fields))
    assert begun.status_code == 303, begun.text
    path = begun.headers["location"]
    visit.wait(path.rpartition("/")[2], "verifier")
    page = visit.ask("GET", path, "verifier")
    assert page.status_code == 200, page.text
    return page.text


@pytest.mark.slow
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
        assert "<h1>✓ Genuine, and Ada Lovelace&#39;s</h1>" in page and f"<code>{ada.id}</code>" in page
        assert "<dt>claim" not in page and visit.studio.registry.fingerprint in page
        assert "<h1>? Cannot tell: " in judged(visit, other, kind="identify")
        visit.studio.registry.revoke("Ada Lovelace", "lost <b>on the train</b>")
        page = judged(visit, hers, kind="identify")
        assert re.search(r"<h1>✗ Revoked on \d+ [A-Z][a-z]+: lost &lt;b&gt;on the train&lt;/b&gt;</h1>", page)


@pytest.mark.slow
def test_another_s_badge_is_named_by_the_server_alone(
    ada: Badge, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Catches: the claimed name for that of the badge that was read; a process of a film that is given that name."""
    monkeypatch.setenv("MOIREID_KEYS", str(tmp_path / "keys"))
    sarah = design_badge(Order("Sarah Example", lens="50lpi"), payload_for_name("Sarah Example"))
    film = badge_film(ada, tmp_path / "ada.mp4")
    with studio(tmp_path, ada, sarah) as visit:
        page = judged(visit, film, claim="Sarah Example")
        assert "<h1>✗ Genuine, but Ada Lovelace&#39;s, not Sarah Example&#39;s</h1>" in page
        assert "film.mp4" in page and ">claim</dt><dd>Sarah Example" in page
        job_id = page.split("/api/jobs/")[1][:32]
        kept = visit.ask("GET", f"/api/jobs/{job_id}/report", "verifier").text
        assert "<h1>✗ Genuine, but Ada Lovelace&#39;s, not Sarah Example&#39;s</h1>" in kept
        job = visit.job(job_id)
        output = json.dumps([job.result, job.kept]).encode() + b"".join(p.read_bytes() for p in job.folder.iterdir())
        assert b"Ada Lovelace" not in output and b"Sarah Example" in output
        picture = visit.ask("GET", f"/verify/{job_id}/picture/frame.jpg", "verifier")
        assert picture.status_code == 200 and picture.content[:2] == b"\xff\xd8"


def test_a_registry_of_nobody_still_answers(films: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Catches: a page that takes the film's figures for granted, which nobody measured where nobody is enrolled."""
    monkeypatch.setenv("MOIREID_KEYS", str(tmp_path / "keys"))
    film = tiny_film(films / "genuine_1.0m.mp4", tmp_path / "film.mp4")
    with studio(tmp_path, work=False) as visit:
        (visit.folder / "jobs").mkdir()
        path = visit.ask("POST", "/verify", "verifier", **film_form(film, kind="identify")).headers["location"]
        waiting = visit.ask("GET", path, "verifier").text
        assert "Judging the film" in waiting and 'http-equiv="refresh"' in waiting
        visit.studio.jobs.start()
        visit.wait(path.rpartition("/")[2], "verifier")
        assert "<h1>✗ Held by no one in this registry</h1>" in visit.ask("GET", path, "verifier").text
