"""Health, figures and the log.  Each test names the wrong implementation it catches."""

from __future__ import annotations

import json
import logging
from pathlib import Path

import pytest

from kit.webbing import OpenStudio, Visit, film_form, tiny_film
from moireid.badge import Badge
from moireid.errors import RegistryError
from moireid_studio.http import logs


@pytest.fixture(scope="module")
def visit(open_studio: OpenStudio, ada: Badge) -> Visit:
    return open_studio(ada)


@pytest.mark.slow
def test_figures_name_no_person_film_or_token(visit: Visit, tmp_path: Path, films: Path, ada: Badge) -> None:
    """Catches: labels made of what visitors send, which also grow without an end; work that is not counted."""
    tiny = tiny_film(films / "genuine_1.0m.mp4", tmp_path / "tiny.mp4")
    visit.ask("POST", "/api/verify", "verifier", **film_form(tiny, claim=ada.name))
    visit.ask("GET", f"/registry/{ada.id}", "verifier")
    visit.ask("GET", "/no-route/Ada%20Lovelace", None)
    visit.ask("GET", "/" + "0123456789abcdef" * 2, None)
    visit.ask("BREW", "/", None)
    figures = visit.ask("GET", "/metrics", "monitor").text
    assert 'moireid_requests_total{method="POST",route="/api/verify",status="200"} 1.0' in figures
    assert 'moireid_jobs_ended_total{kind="verify",outcome="done"} 1.0' in figures
    assert 'moireid_requests_total{method="other"' in figures and 'moireid_jobs{state="waiting"} 0.0' in figures
    for word in ("Lovelace", ada.id, "0123456789abcdef", "BREW", "moireid_session", *visit.tokens.values()):
        assert word not in figures
    token_ids = [token.id for token in visit.studio.tokens.all()]
    assert not any(one in figures for one in token_ids)


def test_ready_means_that_work_can_be_taken(visit: Visit, monkeypatch: pytest.MonkeyPatch) -> None:
    """Catches: a studio that is given work while its registry is away; one that is restarted for that."""
    assert visit.ask("GET", "/readyz", None).json()["ready"] is True

    def gone() -> int:
        raise RegistryError("away")

    monkeypatch.setattr(visit.studio.registry, "count", gone)
    monkeypatch.setattr("moireid_studio.studio.NEEDS_S", 0.0)
    answer = visit.ask("GET", "/readyz", None)
    assert answer.status_code == 503 and answer.json()["needs"]["registry"] is False
    assert visit.ask("GET", "/healthz", None).status_code == 200


def record(message: str, *args: object, error: BaseException | None = None) -> logging.LogRecord:
    info = (type(error), error, error.__traceback__) if error else None
    return logging.LogRecord("moireid_studio", logging.ERROR, "x.py", 1, message, args, info)


def test_the_log_holds_no_words_of_an_error() -> None:
    """Catches: a name in the log, since errors say whose badge it was."""
    try:
        raise RegistryError("badge of Ada Lovelace was revoked")
    except RegistryError as error:
        line = logs.Lines().format(record("%s", error, error=error))
    fields = json.loads(line)
    assert "Lovelace" not in line and fields["error"] == fields["event"] == "RegistryError" and fields["at_lines"]
    logs.note_request("GET", "/registry/{badge_id}", 200, 0.5)
