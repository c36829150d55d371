"""A studio whose database is away.  Each test names the wrong implementation it catches."""

from __future__ import annotations

import pytest

from kit.webbing import OpenStudio, Visit
from moireid.badge import Badge
from moireid_studio.store.database import Away


@pytest.fixture(scope="module")
def visit(open_studio: OpenStudio, ada: Badge) -> Visit:
    return open_studio(ada, work=False)


@pytest.fixture
def away(visit: Visit, monkeypatch: pytest.MonkeyPatch) -> Visit:
    """A visitor with a token, which is looked up in a database that does not answer."""

    def gone(*_: object) -> None:
        raise Away("the database cannot be reached")

    for name in ("find", "of_session"):
        monkeypatch.setattr(visit.studio.tokens, name, gone)
    return visit


@pytest.mark.parametrize("path", ["/healthz", "/", "/help", "/login", "/check", "/static/report.css"])
def test_what_is_open_to_all_answers_while_the_database_is_away(away: Visit, path: str) -> None:
    """Catches: a probe, a page or a style sheet that looks up who asks, so that Kubernetes restarts every studio."""
    assert away.ask("GET", path).status_code == 200


@pytest.mark.parametrize("path", ["/verify", "/api/registry", "/metrics"])
def test_what_needs_a_token_says_that_the_database_is_away(away: Visit, path: str) -> None:
    """Catches: an error page that asks the database again, and ends in a bare 500."""
    answer = away.ask("GET", path)
    assert answer.status_code == 503 and "database cannot be reached" in answer.text
    assert answer.headers["Retry-After"] == "10"
