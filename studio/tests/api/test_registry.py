"""The registry by API.  Each test names the wrong implementation it catches."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any
from urllib.parse import quote

import pytest

from kit.webbing import Visit, film_form, studio, tiny_film
from kit.witnesses import Witness
from moireid.badge import Badge
from moireid.cli.witness_options import WitnessCheck
from moireid.designer import Order, design_badge
from moireid.registry.checkpoints.cosignature import witness_keys


@pytest.fixture
def visit(tmp_path: Path, ada: Badge, monkeypatch: pytest.MonkeyPatch) -> Iterator[Visit]:
    monkeypatch.setenv("MOIREID_KEYS", str(tmp_path / "keys"))
    monkeypatch.setenv("MOIREID_SEEN", str(tmp_path / "seen.sqlite3"))
    with studio(tmp_path, ada, work=False) as made:
        yield made


def test_a_badge_is_revoked_once_and_for_everybody(visit: Visit, ada: Badge) -> None:
    """Catches: a revocation that is answered and not written; a second one that changes the first."""
    path = f"/api/registry/{ada.id}/revoke"
    for reason in ("", "two\nlines", "x" * 1001):
        assert visit.ask("POST", path, "issuer", json={"reason": reason}).status_code == 422
    result = visit.ask("POST", path, "issuer", json={"reason": "lost"})
    assert result.status_code == 200 and result.json()["revoked_reason"] == "lost"
    assert visit.ask("GET", f"/api/registry/{ada.id}", "verifier").json()["revoked_at"] == result.json()["revoked_at"]
    assert visit.ask("POST", path, "issuer", json={"reason": "found"}).status_code == 422
    assert visit.ask("GET", f"/api/registry/{ada.id}", "verifier").json()["revoked_reason"] == "lost"
    assert visit.ask("POST", "/api/registry/0000/revoke", "issuer", json={"reason": "lost"}).status_code == 404


def test_an_audit_says_which_witnesses_have_signed(visit: Visit, tmp_path: Path) -> None:
    """Catches: signatures that are checked once, when the studio starts; a missing one that is taken for none asked."""
    registry, kept = visit.studio.registry, tmp_path / "newest.checkpoint"
    made = [Witness(f"witness.example/w{number}") for number in (1, 2, 3)]
    keys = witness_keys([made[0].key, made[2].key])
    visit.studio.settings = replace(visit.studio.settings, witness_check=WitnessCheck(kept, keys))

    def audited() -> Any:
        return visit.ask("POST", "/api/registry/audit", "issuer", json={}).json()

    assert [one["code"] for one in audited()["findings"]] == ["not_witnessed"] and audited()["witnessed"] is None
    kept.write_text(registry.checkpoint()[0].note, encoding="utf-8")
    for one in (made[0], made[2]):
        one.sign(kept)
    part = audited()["witnessed"]
    assert part["size"] == 2 and audited()["sound"]
    assert set(part["signers"]) == {"witness.example/w1", "witness.example/w3"}
    page = visit.ask("POST", "/registry/audit", "issuer", data={"head": ""}).text
    assert "All witnesses" in page and "witness.example/w3: signed on" in page and "witness.example/w2" not in page


def test_a_verifier_gets_no_badge_file(visit: Visit, ada: Badge) -> None:
    """Catches: a token for checking films by which every badge can be printed."""
    path = f"/api/registry/{ada.id}"
    visit.studio.registry.store_as_built(str(ada.id), '{"tilt_rad": 0.01}')
    whole, part = visit.ask("GET", path, "issuer").json(), visit.ask("GET", path, "verifier").json()
    assert whole["badge"] == json.loads(ada.to_json()) and whole["as_built"] == {"tilt_rad": 0.01}
    assert part == whole | {"badge": None, "as_built": None}
    assert visit.ask("GET", path, "admin").json() == whole


@pytest.mark.slow
def test_a_verifier_learns_no_identity(
    ada: Badge, films: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Catches: a list, a search by beginnings, an answer or a report by which a token for checking films prints badges:
    name, identity and layout make the very lines.
    """
    monkeypatch.setenv("MOIREID_KEYS", str(tmp_path / "keys"))
    film = tiny_film(films / "genuine_1.0m.mp4", tmp_path / "film.mp4")
    twin, bo, look_alike = (
        design_badge(Order(name, lens="50lpi"), bytes([k]) * 8) for k, name in enumerate(("Bo", "Bo", "\u0412o"))
    )
    secret = {str(one.id) for one in (ada, twin, bo, look_alike)}
    with studio(tmp_path, ada, twin, bo, look_alike) as visit:
        result = []
        for role in ("issuer", "verifier"):
            listed = visit.ask("GET", "/api/registry", role).json()["badges"]
            assert [one["name"] for one in listed].count("Bo") == 2
            assert {one["id"] for one in listed} == (secret if role == "issuer" else {None})
            found = visit.ask("GET", f"/api/registry?search={str(ada.id)[:4]}", role).json()["badges"]
            assert len(found) == (role == "issuer")
        result.append(visit.ask("GET", "/registry", "verifier").text)
        assert (
            f"/verify?claim={quote(ada.name)}" in result[0]
            and str(ada.id) in visit.ask("GET", "/registry", "issuer").text
        )
        for claim, status in (("Bo", 409), ("B\u043e", 404), (ada.name, 202), ("\u0412o", 202)):
            answer = visit.ask("POST", "/api/jobs", "verifier", **film_form(film, kind="verify", claim=claim))
            assert answer.status_code == status, answer.text
            result.append(answer.text)
            if status == 202:
                job = answer.json()["id"]
                result.append(json.dumps(visit.wait(job, "verifier")))
                result.append(visit.ask("GET", f"/verify/{job}", "verifier").text)
                result.append(visit.ask("GET", f"/api/jobs/{job}/report", "verifier").text)
                assert "no identity" not in result[-1]
        assert not [one for one in secret for text in result if one in text]
        answer = visit.ask("POST", "/api/jobs", "admin", **film_form(film, kind="verify", claim=ada.name))
        assert visit.wait(answer.json()["id"])["result"]["identity"]["claimed_id"] == ada.id


def test_no_answer_shows_a_registry_that_was_put_back(visit: Visit, ada: Badge, tmp_path: Path) -> None:
    """Catches: a record, a list, a page or a readiness that calls a rolled-back registry sound while films are refused;
    an audit that does not name it.
    """
    database = tmp_path / "registry.sqlite3"
    before = database.read_bytes()
    visit.studio.registry.revoke(str(ada.id), "lost")
    database.write_bytes(before)
    asked = [f"/api/registry/{ada.id}", "/api/registry", "/api/registry?search=A"]
    for path in asked:
        answer = visit.ask("GET", path, "issuer")
        assert answer.status_code == 503 and answer.json()["code"] == "registry", path
        assert "rolled back" in answer.json()["text"] and "sqlite" not in answer.text
    assert visit.ask("POST", f"/api/registry/{ada.id}/revoke", "issuer", json={"reason": "x"}).status_code == 503
    for page in ("/registry", f"/registry/{ada.id}"):
        shown = visit.ask("GET", page, "issuer")
        assert shown.status_code in (404, 503) and ada.name not in shown.text, page
    ready = visit.ask("GET", "/readyz", None)
    assert ready.status_code == 503 and ready.json()["needs"]["registry"] is False
    assert visit.ask("GET", "/healthz", None).status_code == 200
    audit = visit.ask("POST", "/api/registry/audit", "issuer", json={})
    assert [one["code"] for one in audit.json()["findings"]] == ["rolled_back"] and "sqlite" not in audit.text
