"""One-time links, without a browser.  Each test names what it would catch."""

from __future__ import annotations

import hashlib
import json
import re
import threading
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import cv2
import pytest
from starlette.testclient import TestClient

from kit.webbing import Visit, studio
from moireid.badge import Badge
from moireid.provenance import Provenance, Standing
from moireid.question import Question
from moireid.sandbox.process import ProcessEnd
from moireid.sandbox.seal import MEANS
from moireid.verifier.report.live_receipt import receipt_of
from moireid_lab.bench.live import portrait
from moireid_studio import links
from moireid_studio.http.server import _server_of
from moireid_studio.live.sockets import (
    ASK_S,
    CLOCK,
    IDLE_S,
    MOST_BYTES,
    SessionRequest,
    _headline,
    own_words,
)
from moireid_studio.receipts import with_live_checks
from moireid_studio.store.job import Job

ORIGIN = {"origin": "http://studio.test", "host": "studio.test"}
SECRET = re.compile(r"/check#([\w-]{43})")


@dataclass
class Asker:
    """Somebody with a verifier's token, at a studio that a client reaches."""

    visit: Visit
    client: TestClient
    role: str = "verifier"

    @property
    def headers(self) -> dict[str, str]:
        return {"authorization": f"Bearer {self.visit.tokens[self.role]}"}

    def make(self, **more: str) -> str:
        """The secret of a new link."""
        sent = {"claim": "Ada Lovelace", "asks": "Sam <b>of accounts</b>"} | more
        answer = self.client.post("/links", data=sent, headers=self.headers)
        assert answer.status_code == 200 and "<b>of" not in answer.text
        return SECRET.findall(answer.text)[0]

    def look(self, secret: str) -> tuple[int, dict[str, Any]]:
        answer = self.client.post("/check/look", data={"token": secret})
        return answer.status_code, answer.json()

    def page(self) -> str:
        """What the asker reads of the newest link."""
        first = re.findall(r"/links/([0-9a-f]{16})", self.client.get("/links", headers=self.headers).text)[0]
        return self.client.get(f"/links/{first}", headers=self.headers).text

    def newest(self) -> links.OneTimeLink:
        found = self.visit.studio.links.of_asker(self.visit.studio.tokens.find(self.visit.tokens[self.role]).id, 1)  # type: ignore[union-attr]
        return found[0]

    def check(self, secret: str, *, pictures: bool = False) -> dict[str, Any]:
        """The last event of a check of ten pictures."""
        with self.client.websocket_connect("/check/socket", headers=ORIGIN) as connection:
            connection.send_json({"token": secret, "pictures": pictures})
            event = connection.receive_json()
            if event["event"] == "ready":
                for _ in range(10):
                    jpeg = cv2.imencode(".jpg", portrait())[1].tobytes()
                    connection.send_bytes(CLOCK.pack(1000.0 * time.monotonic()) + jpeg)
                connection.send_json({"do": "end"})
                while event["event"] not in ("verdict", "error"):
                    event = connection.receive_json()
            return event


@pytest.fixture(scope="module")
def asker(tmp_path_factory: pytest.TempPathFactory, ada: Badge) -> Iterator[Asker]:
    folder = tmp_path_factory.mktemp("links")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("MOIREID_KEYS", str(folder / "keys"))
        with studio(folder, ada, work=False) as visit:
            yield Asker(visit, TestClient(visit.app, base_url="http://studio.test"))


def test_a_look_or_a_preview_uses_nothing_up_and_the_asker_sees_it(asker: Asker) -> None:
    """Catches: a link that a mail program's preview uses up; a page that shows anyone who fetches it whom it is for."""
    secret = asker.make()
    assert "not opened yet" in asker.page().lower()
    for method in ("GET", "HEAD"):
        answer = asker.client.request(method, "/check")
        assert answer.status_code in (200, 405) and "Ada" not in answer.text
    assert "not opened yet" in asker.page().lower()
    for _ in range(2):
        status, document = asker.look(secret)
        known = {"asks": "Sam <b>of accounts</b>", "name": "Ada Lovelace", "pictures": False, "film": None}
        assert status == 200 and document == known
    assert "opened, not begun" in asker.page().lower() and asker.newest().used_at is None


@pytest.mark.claim("A one-time link works once")
@pytest.mark.slow
def test_a_check_is_told_once_to_the_asker_alone(asker: Asker, ada: Badge) -> None:
    """Catches: a link that works twice, or is passed without prompts; a result that another token reads, or that shows
    more than the verdict; a receipt of another report; a secret that is stored.
    """
    secret = asker.make()
    event = asker.check(secret)
    assert event["event"] == "verdict" and event["verdict"] == "inconclusive"
    # Who plays an old film would press Stop without the challenge.
    assert [one["level"] for one in event["reasons"] if one["code"] == "challenge"] == ["undecided"]
    for document in (asker.check(secret)["text"], asker.look(secret)[1]["text"]):
        assert document.startswith("This link was used on ") and document.count(".") == 1
    link = asker.newest()
    assert "Cannot tell" in asker.page() and "Ada Lovelace" in asker.page()
    report = asker.client.get(f"/links/{link.id}/report", headers=asker.headers)
    receipt = asker.client.get(f"/links/{link.id}/receipt", headers=asker.headers).json()
    assert receipt["report_sha256"] == hashlib.sha256(report.content).hexdigest()
    assert receipt["claim"] == "Ada Lovelace" and receipt["verdict"] == json.loads(report.text)["verdict"]
    assert ada.id is not None and ada.id not in report.text + asker.page() + json.dumps(receipt)
    for path in ("", "/report", "/receipt", "/picture/0"):
        other = {"authorization": f"Bearer {asker.visit.tokens['admin']}"}
        assert asker.client.get(f"/links/{link.id}{path}", headers=other).status_code == 404
    assert secret.encode() not in (asker.visit.studio.settings.data / links.FILE).read_bytes()


@pytest.mark.parametrize("enrolling", [True, False])
def test_a_session_s_process_says_only_what_it_has_seen(ada: Badge, enrolling: bool) -> None:
    """Catches: figures of a check without prompts, or that was not passed, which are kept as witnessed; a receipt that
    names another registry, prompts that no one drew, or a seal that did not hold; a verdict that no page can show."""
    found = Question(ada, provenance=Provenance("registry", standing=Standing("c0ffee", "3:ab")))
    asked = SessionRequest(found, found, "me", "enroll" if enrolling else "live", allowed=lambda: True)
    said = {
        "verdict": "accept",
        "challenged": True,
        "as_built": {"witnessed": True},
        "registry": [1],
        "claim_source": "me",
        "sealed": ["all"],
        "input": {"decoder": "none"},
    }
    parts = tuple(MEANS)
    own = own_words(said, asked, prompted=True, sealed=parts)
    assert own["sealed"] == list(parts) and own["input"] == {"decoder": f"OpenCV {cv2.__version__}"}
    assert own["registry"]["fingerprint"] == "c0ffee" and own["claim_source"] == "registry" and own["challenged"]
    assert ("as_built" in own) == enrolling
    assert own_words(said, asked, prompted=False, sealed=())["challenged"] is False
    for change, prompted in (({}, False), ({"challenged": False}, True), ({"verdict": "inconclusive"}, True)):
        assert "as_built" not in own_words(said | change, asked, prompted=prompted, sealed=())
    with pytest.raises(ProcessEnd):
        own_words(said | {"verdict": "original"}, asked, prompted=True, sealed=())


def test_of_two_at_once_one_alone_gets_in(asker: Asker) -> None:
    """Catches: a look and then a use, between which another slips in."""
    store = asker.visit.studio.links
    asker.make()
    link, won = asker.newest(), list[bool]()
    threads = [threading.Thread(target=lambda: won.append(store.use(link, agreed=False))) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert sorted(won) == [False] * 7 + [True]


def test_a_late_a_guessed_and_an_orphaned_link_are_told_in_a_sentence(
    asker: Asker, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Catches: a link without an end; one that outlives the token that made it; a secret that signs somebody in."""
    with monkeypatch.context() as patch:
        patch.setattr(links, "LASTS_MIN", -1.0)
        late = asker.make()
    assert asker.look(late)[1]["text"].startswith("This link could be used until ")
    assert asker.check(late)["text"].startswith("This link could be used until ")
    for guess in ("", "x" * 43, late[:-1], asker.newest().id):
        assert asker.look(guess)[0] in (404, 422) and "none of this studio" in asker.check(guess)["text"]
    secret = asker.make()
    assert asker.client.get("/links", headers={"authorization": f"Bearer {secret}"}).status_code == 401
    held = asker.visit.studio.tokens
    secret_of, token = held.create("verifier", "Sam")
    asker.visit.tokens["sam"] = secret_of
    orphan = Asker(asker.visit, asker.client, "sam").make()
    held.revoke(token.id)
    assert "may ask no more" in asker.look(orphan)[1]["text"] and "may ask no more" in asker.check(orphan)["text"]


@pytest.mark.parametrize("wants", [False, True])
@pytest.mark.parametrize("agrees", [False, True])
def test_pictures_are_kept_only_if_both_agree(asker: Asker, *, wants: bool, agrees: bool) -> None:
    """Catches: pictures that one alone wanted; pictures that are left when the link is removed."""
    secret = asker.make(**({"pictures": "true"} if wants else {}))
    link, store = asker.newest(), asker.visit.studio.links
    from moireid_studio.live.link_routes import _asked

    asked: SessionRequest = _asked(asker.visit.studio, {"token": secret, "pictures": agrees})
    asked.begun()
    for jpeg in (b"\xff\xd8 one", b"\xff\xd8 two"):
        if asked.picture is not None:
            asked.picture(jpeg)
        asked.on_event({"event": "prompted"})
    asked.on_event({"event": "verdict", "verdict": "accept", "reasons": [], "headline": {"title": "Ada"}})
    asked.ended()
    kept = [b"\xff\xd8 one", b"\xff\xd8 two"] if wants and agrees else []
    assert store.pictures(link) == kept and asker.newest().state == "done"
    shown = asker.client.get(f"/links/{link.id}/picture/0", headers=asker.headers)
    assert shown.status_code == (200 if kept else 404)
    if kept:
        assert shown.headers["content-security-policy"] == "sandbox" and shown.headers["content-type"] == "image/jpeg"
    removed = asker.client.post(f"/links/{link.id}/remove", headers=asker.headers, follow_redirects=False)
    assert removed.status_code == 303 and store.pictures(link) == []
    assert asker.look(secret)[0] == 404


def test_who_has_a_link_learns_nobody_else_s_badge(asker: Asker, monkeypatch: pytest.MonkeyPatch) -> None:
    """Catches: a link by which somebody without an account learns whose a badge is that they found."""
    from moireid.provenance import BadgeHolder
    from moireid_studio.live.link_routes import _asked

    monkeypatch.setattr("moireid_studio.live.sockets.holder_of", lambda *given: BadgeHolder("Grace Hopper"))
    asked = _asked(asker.visit.studio, {"token": asker.make()})
    reason = {"code": "identity", "level": "fail", "measured": None, "limit": None, "unit": "", "text": "Another."}
    identity = {"verdict": "mismatch", "decoded_id": "bb" * 8}
    event = {"verdict": "reject", "reasons": [reason], "claim_source": "registry", "identity": identity}
    event |= {"invariant": {"verdict": "accept"}}
    document = {kind: _headline(asker.visit.studio, event, replace(asked, kind=kind)) for kind in ("live", "link")}
    assert "Grace Hopper" in document["live"]["title"] and "Grace" not in json.dumps(document["link"])
    assert document["link"]["title"] == "Genuine, but another badge, not Ada Lovelace's"


def test_strangers_do_not_fill_the_memory(asker: Asker, monkeypatch: pytest.MonkeyPatch) -> None:
    """Catches: messages of 16 MB, as servers take unasked; sockets without a word that no one ends."""
    assert MOST_BYTES + CLOCK.size < _server_of(asker.visit.app).config.ws_max_size < 4 * MOST_BYTES
    monkeypatch.setattr("moireid_studio.live.sockets.ASK_S", 0.5)
    with asker.client.websocket_connect("/check/socket", headers=ORIGIN) as silent:
        assert "come to its end" in silent.receive_json()["text"]
    assert "none of this studio" in asker.check("")["text"]
    assert ASK_S < IDLE_S


def test_neither_links_nor_tokens_take_all_places(asker: Asker, monkeypatch: pytest.MonkeyPatch) -> None:
    """Catches: one number of sessions for all, which people with links, or those with tokens, take whole."""
    monkeypatch.setattr("moireid_studio.live.sockets.MOST_SESSIONS", 0)
    with asker.client.websocket_connect("/check/socket", headers=ORIGIN) as connection:
        connection.send_json({"token": asker.make()})
        assert connection.receive_json()["event"] == "ready"


def test_a_film_of_any_name_can_be_asked_about(asker: Asker, ada: Badge, monkeypatch: pytest.MonkeyPatch) -> None:
    """Catches: a report that can be shown no more once a live check of a film with a tab or 900 letters is done."""
    owner = asker.visit.studio.tokens.find(asker.visit.tokens["verifier"]).id  # type: ignore[union-attr]
    job = Job("cd" * 16, "verify", owner, Path(), state="done", result={}, film_name="a\t\u202e" + "x" * 900)
    job.film_sha256, job.claimed_id = "ba" * 32, ada.id
    monkeypatch.setattr(asker.visit.studio.jobs, "find", lambda *_: job)
    assert "\t" not in asker.look(asker.make(about=job.id))[1]["film"]["name"]
    reason = {"code": "motion", "level": "fail", "measured": 1.0, "limit": 1.0, "unit": "rad", "text": "No."}
    event = {"verdict": "reject", "challenged": True, "reasons": [reason], "identity": {"verdict": "match"}}
    asker.visit.studio.links.note_end(asker.newest(), event, [])
    assert " failed; " in receipt_of(with_live_checks(asker.visit.studio, job)["live_checks"][0]).words
