"""The list of verdicts that a studio gave.  Each test names the wrong implementation it catches."""

from __future__ import annotations

import hashlib
from datetime import timedelta
from pathlib import Path

import pytest

from kit.webbing import film_form, studio, tiny_film
from moireid import __version__
from moireid.badge import Badge
from moireid_studio.store import verdict_store as module
from moireid_studio.store.verdict_store import Verdicts, said

ONE = {"token": "abc", "kind": "verify", "film_sha256": "0" * 64, "claim": "0" * 16, "claim_source": "registry"}
ONE |= {"verdict": "accept", "read": None, "registry": "f 1:0", "moireid": "1"}


@pytest.fixture(autouse=True)
def keys(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MOIREID_KEYS", str(tmp_path / "keys"))


@pytest.mark.slow
def test_each_verdict_is_written_down_without_names(ada: Badge, films: Path, tmp_path: Path) -> None:
    """Catches: a verdict of one way in that is not noted; the decoder's word for the film; names of film or person."""
    film = tiny_film(films / "genuine_1.0m.mp4", tmp_path / "film.mp4")
    with studio(tmp_path, ada) as visit:
        form = film_form(film, name="secret meeting.mp4", claim=ada.name)
        answer = visit.ask("POST", "/api/verify", "verifier", **form).json()
        visit.ask("POST", "/api/identify", "admin", **film_form(film))
        ids = {role: visit.studio.tokens.find(secret).id for role, secret in visit.tokens.items()}
        found = visit.ask("GET", "/api/verdicts", "admin").json()
        assert found["keep_days"] == 365
        identified, verified = found["verdicts"]
        assert (verified["token"], verified["kind"], verified["verdict"]) == (
            ids["verifier"],
            "verify",
            answer["verdict"],
        )
        assert verified["film_sha256"] == hashlib.sha256(film.read_bytes()).hexdigest() == answer["input"]["sha256"]
        assert (verified["claim"], verified["claim_source"], verified["moireid"]) == (ada.id, "registry", __version__)
        assert verified["registry"] == f"{visit.studio.registry.fingerprint} {visit.studio.registry.head()}"
        assert (identified["token"], identified["kind"], identified["claim"]) == (ids["admin"], "identify", None)
        content = (tmp_path / "studio" / "verdicts.sqlite3").read_bytes()
        assert b"secret meeting" not in content and b"Lovelace" not in content
        page = visit.ask("GET", "/verdicts", "admin").text
        assert "Ada Lovelace" in page and verified["film_sha256"][:12] in page and "365 days" in page
        visit.studio.registry.erase(ada.name)
        page = visit.ask("GET", "/verdicts", "admin").text
        assert "Ada Lovelace" not in page and "somebody who was erased" in page


def test_only_what_can_be_a_verdict_is_taken() -> None:
    """Catches: a decoder that was taken over and writes what it likes into the list."""
    assert said({"verdict": "accept", "identity": {"decoded_id": "0" * 16}}) == {"verdict": "accept", "read": "0" * 16}
    for wrong in ({"verdict": ["x"] and "<b>"}, {"finding": "found it", "found_id": "Ada"}, {"found_id": ["x"]}, {}):
        assert said(wrong) == {"verdict": "unknown", "read": None}


def test_they_go_after_their_time(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Catches: a retention that is stated and not kept; one that starts anew at each opening; rows left behind."""
    store = Verdicts(tmp_path, 30.0)
    store.note(**ONE | {"film_sha256": "old" * 20})
    shown = module.utc_text

    def in_days(days: float) -> None:
        monkeypatch.setattr(module, "utc_text", lambda wait=timedelta(): shown(wait + timedelta(days=days)))

    in_days(29.0)
    store.note(**ONE)
    assert len(store.given(9)) == 2
    in_days(31.0)
    assert [one.film_sha256 for one in Verdicts(tmp_path, 30.0).given(9)] == ["0" * 64]
    assert b"oldold" not in store.path.read_bytes() and store.given(9)[0].at > shown(timedelta(days=28))
    Verdicts(tmp_path, 0).note(**ONE)
    assert Verdicts(tmp_path, None).given(9) == []
