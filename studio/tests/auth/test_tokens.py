"""Tokens and sessions: how long they last, and how they end.  Each test names the wrong implementation it catches."""

from __future__ import annotations

from collections.abc import Iterator
from datetime import timedelta
from pathlib import Path

import httpx
import pytest

from kit.registries import badge_of
from kit.webbing import Visit, studio
from moireid_studio.auth import tokens as token_times
from moireid_studio.auth.guard import COOKIE


@pytest.fixture
def visit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Visit]:
    monkeypatch.setenv("MOIREID_KEYS", str(tmp_path / "keys"))
    with studio(tmp_path, work=False) as opened:
        yield opened


def cookie_of(answer: httpx.Response) -> dict[str, str]:
    return {"Cookie": answer.headers["set-cookie"].partition(";")[0]}


def test_signing_out_ends_the_session_of_that_browser_alone(visit: Visit) -> None:
    """Catches: a cookie that is only forgotten, so that a copy of it still opens; a cookie that is the token; signing
    out everybody who has the token."""
    secret = visit.tokens["issuer"]
    here, there = (cookie_of(visit.ask("POST", "/login", None, data={"token": secret})) for _ in range(2))
    assert secret not in here["Cookie"] and here != there
    assert visit.ask("GET", "/registry", None, headers=here).status_code == 200
    assert visit.ask("POST", "/logout", None, headers=here).status_code == 303
    assert visit.ask("GET", "/registry", None, headers=here).status_code == 401
    assert visit.ask("GET", "/registry", None, headers=there).status_code == 200
    assert visit.ask("GET", "/api/registry", "issuer").status_code == 200
    # Neither is the other: a session's secret is no token, and a token in a cookie no session.
    session = there["Cookie"].partition("=")[2]
    assert visit.ask("GET", "/registry", None, headers={"Authorization": f"Bearer {session}"}).status_code == 401
    assert visit.ask("GET", "/registry", None, headers={"Cookie": f"{COOKIE}={secret}"}).status_code == 401


def test_tokens_and_sessions_end_by_themselves(visit: Visit, monkeypatch: pytest.MonkeyPatch) -> None:
    """Catches: a lifetime that is stored and never looked at; a session that outlives its token; one without end."""
    tokens = visit.studio.tokens
    short, _ = tokens.create("verifier", "a day", 1.0)
    long, _ = tokens.create("verifier", "a month", 30.0)
    sessions = {secret: tokens.begin_session(secret) for secret in (short, long)}
    present = token_times.utc_text

    def in_days(days: float) -> None:
        monkeypatch.setattr(token_times, "utc_text", lambda wait=timedelta(): present(wait + timedelta(days=days)))

    in_days(0.4)
    assert tokens.find(short) and tokens.of_session(sessions[short] or "")
    in_days(0.6)
    assert tokens.find(short) and tokens.of_session(sessions[short] or "") is None
    in_days(1.1)
    assert tokens.find(short) is None and tokens.begin_session(short) is None and tokens.find(long)
    late = tokens.begin_session(long)
    in_days(1.2)
    assert late and tokens.of_session(late)
    tokens.revoke(tokens.find(long).id)
    assert tokens.of_session(late) is None


def test_what_a_visitor_does_is_logged_by_their_token(visit: Visit) -> None:
    """Catches: the server's account logged for everybody; a token in the log."""
    badge = badge_of("Ada")
    visit.studio.registry.enroll(badge)
    secret, token = visit.studio.tokens.create("issuer", "front desk")
    bearer = {"Authorization": f"Bearer {secret}"}
    done = visit.ask("POST", f"/api/registry/{badge.id}/revoke", None, headers=bearer, json={"reason": "lost"})
    assert done.status_code == 200
    assert visit.studio.registry.entries(limit=1)[0]["actor"] == f"token {token.id} (front desk)"
    shown = f"revoke, by token {token.id} (front desk)"
    assert shown in visit.ask("GET", f"/registry/{badge.id}", "issuer").text
    assert "front desk" not in visit.ask("GET", f"/registry/{badge.id}", "verifier").text
