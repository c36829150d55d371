"""Issuing and enrolling, asked without a browser.  Each test names the wrong implementation it catches."""

from __future__ import annotations

import csv
import html
import io
import json
import re
import time
import zipfile
from collections.abc import Collection
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import httpx
import pytest
from click.testing import CliRunner

from kit.payloads import payload_for_name
from kit.webbing import OpenStudio, Visit, studio
from moireid.asbuilt import AsBuilt
from moireid.badge import Badge, badge_from_json
from moireid.cli.main import moireid
from moireid.designer import Order, design_badge
from moireid.designer.formats import FORMATS
from moireid.profiles import PAPERS_MM
from moireid.sheets import DEFAULT_LENS, PRODUCTS
from moireid_studio.store.job import Job

#: Small boards are quickly made, and four are on a sheet.
SMALL = {"width_mm": "90", "height_mm": "110", "near_m": "0.5", "far_m": "0.9", "mount": "none"}
HOSTILE = [
    "../../x",
    "/etc/passwd",
    "<script>alert(1)</script>",
    '"><img src=x onerror=alert(1)>',
    "{{ 7*7 }}",
    "'; DROP TABLE badges--",
    "L" * 150,
    "عمر الخيام",
    "ليلى O'Brien",
    "🦊 Fox",
    "=1+1",
    "CON",
    "%2e%2e%2f",
]


@pytest.fixture(scope="module")
def visit(open_studio: OpenStudio) -> Visit:
    return open_studio(form_bytes=200_000)


class Markup(HTMLParser):
    """The elements of a page, and the values of its fields."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.fields: dict[str, str | None] = {}
        self.seen = ""
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = dict(attrs)
        self.tags.append(tag)
        self.seen = (given.get("src") or "") if tag == "img" else self.seen
        if tag == "input" and given.get("name"):
            self.fields[given["name"] or ""] = given.get("value")


@pytest.mark.parametrize(("field", "known"), [("paper", PAPERS_MM), ("format", FORMATS), ("lens", set(PRODUCTS))])
def test_the_page_offers_all_that_the_library_has(visit: Visit, field: str, known: Collection[str]) -> None:
    """Catches: papers, formats or sheets that the command prints on and the page does not offer."""
    page = visit.ask("GET", "/issue", "issuer").text
    (menu,) = re.findall(rf'<select id="{field}".*?</select>', page, re.DOTALL)
    assert set(re.findall(r'<option value="([^"]+)"', menu)) == set(known)


def order(name: str, **more: str) -> dict[str, Any]:
    """The JSON of an order for a small badge."""
    return {"name": name, "mount": "none", "size_mm": [90, 110], "range_m": [0.5, 0.9]} | more


def done(visit: Visit, job: str, role: str = "issuer") -> dict[str, Any]:
    """The job of issuing or enrolling once it is over."""
    begun = time.monotonic()
    while (outcome := visit.ask("GET", f"/api/badges/jobs/{job}", role).json())["state"] not in ("done", "failed"):
        assert time.monotonic() - begun < 200
        time.sleep(0.1)
    return outcome


def packed(visit: Visit, job: str) -> dict[str, bytes]:
    """The files of a package by name."""
    answer = visit.ask("GET", f"/api/badges/jobs/{job}/package.zip", "issuer")
    assert answer.status_code == 200 and answer.headers["content-type"] == "application/zip"
    with zipfile.ZipFile(io.BytesIO(answer.content)) as archive:
        assert archive.testzip() is None
        return {name: archive.read(name) for name in archive.namelist()}


@pytest.mark.parametrize(
    ("fields", "arguments"),
    [
        ({"far_m": "9"}, ["--range", "0.8-9"]),
        ({"near_m": "3"}, ["--range", "3-2.5"]),
        ({"width_mm": "4"}, ["--size", "4x160"]),
        ({"payload": "xyz"}, ["--payload", "xyz"]),
        ({"printer_dpi": "150"}, ["--printer-dpi", "150"]),
        ({"name": "a\u202eb"}, []),
        ({"name": "L" * 201}, []),
        ({"width_mm": "900", "height_mm": "900"}, ["--size", "900x900"]),
    ],
)
def test_the_page_refuses_in_the_command_s_own_sentence(
    visit: Visit, fields: dict[str, str], arguments: list[str], tmp_path: Path
) -> None:
    """Catches: a page with rules or words of its own, and one that loses what was typed."""
    sent = {"name": "Ada", "do": "issue"} | fields
    answer = visit.ask("POST", "/issue", "issuer", data=sent)
    outcome = CliRunner().invoke(moireid, ["print", sent["name"], "--out", str(tmp_path / "out"), *arguments])
    assert outcome.exit_code == 2 and outcome.stderr.startswith("error: ")
    assert answer.status_code == 422
    problem = re.search(r'role="alert" id="problem">(.*?)</p>', answer.text, re.S)
    # Only the command has options.
    said = re.sub(r"--(size|paper|lens) ", r"\1 ", outcome.stderr.removeprefix("error: ").strip())
    assert problem is not None and html.unescape(problem.group(1)) == said
    assert Markup(answer.text).fields | fields == Markup(answer.text).fields
    body: dict[str, Any] = {
        key: value for key, value in sent.items() if key != "do" and not key.endswith(("_m", "_mm"))
    }
    pairs = {"range_m": {"near_m": 0.8, "far_m": 2.5}, "size_mm": {"width_mm": 146.0, "height_mm": 160.0}}
    for what, usual in pairs.items():
        if set(usual) & set(sent):
            body[what] = [float(sent.get(name, value)) for name, value in usual.items()]
    by_api = visit.ask("POST", "/api/badges/check", "issuer", json=body)
    assert by_api.status_code == 422 and by_api.json()["text"] == html.unescape(problem.group(1))


def test_issuing_makes_one_archive_and_the_record_together(visit: Visit) -> None:
    """Catches: a package without its record, a record of another badge, files next to the archive, a job shared."""
    begun = visit.ask("POST", "/api/badges", "issuer", json=order("Grace Hopper"))
    assert begun.status_code == 202
    job = begun.json()["id"]
    assert visit.ask("GET", f"/api/badges/jobs/{job}/package.zip", "issuer").status_code in (200, 404)
    outcome = done(visit, job)
    assert outcome["state"] == "done" and outcome["result"]["name"] == "Grace Hopper"
    files = packed(visit, job)
    badge_id = outcome["result"]["id"]
    top = f"badge-{badge_id}/"
    assert sorted(files) == [
        top + name for name in ("assembly.pdf", "badge.json", "badge.pdf", "fringes.webp", "preview.png")
    ]
    record = visit.studio.registry.by_id(badge_id)
    assert record is not None and record.badge == badge_from_json(files[top + "badge.json"].decode())
    assert [one for one in visit.left() if job in one] == [f"jobs/{job}", f"jobs/{job}/package.zip"]
    # What one visitor has made is nobody else's, not even an admin's.
    assert visit.ask("GET", f"/api/badges/jobs/{job}", "admin").status_code == 404
    own = visit.ask("POST", "/api/badges", "admin", json=order("Grace Hopper")).json()["id"]
    # An admin may also verify, and a package is no verdict.
    assert done(visit, own, "admin")["state"] == "done" and visit.ask("GET", f"/verify/{own}").status_code == 404
    same = order("Grace Hopper") | {"payload": badge_id}
    again = done(visit, visit.ask("POST", "/api/badges", "issuer", json=same).json()["id"])
    assert again["result"]["already_issued"] and not outcome["result"]["already_issued"]
    another = done(visit, visit.ask("POST", "/api/badges", "issuer", json=order("Grace Hopper")).json()["id"])
    assert another["result"]["id"] not in (badge_id, None)


@pytest.fixture(scope="module")
def calm(visit: Visit) -> httpx.Response:
    return visit.ask("POST", "/issue", "issuer", data={"name": "Calm", "do": "check"})


@pytest.mark.parametrize("name", HOSTILE)
def test_a_hostile_name_is_a_name_and_nothing_else(visit: Visit, calm: httpx.Response, name: str) -> None:
    """Catches: names as markup, as template, and a form that changes them."""
    answer = visit.ask("POST", "/issue", "issuer", data={"name": name, "do": "check"})
    assert answer.status_code == 200
    assert Markup(answer.text).fields["name"] == name
    # Notes on missing fonts apart, the page has the same elements whatever the name.
    found, plain = ([tag for tag in Markup(page.text).tags if tag != "p"] for page in (answer, calm))
    assert found == plain


@pytest.mark.slow
def test_an_event_is_understood_row_by_row_and_issued_as_one_archive(visit: Visit) -> None:
    """Catches: faults without rows, a list issued in part, names as paths in the archive, people without a record."""

    def page(text: str, do: str = "issue") -> httpx.Response:
        fields = {"people": text, "do": do} | SMALL
        return visit.ask("POST", "/issue/event", "issuer", data=fields, files={"people_file": ("", b"")})

    count = visit.studio.registry.count()
    twice = "One,0123456789abcdee\nOther,0123456789abcdee\n"
    faulty = page(f"name,payload\nGood One,\n,0123\n\n{twice}Hex,xyz\n" + "L" * 201 + ",\n")
    assert faulty.status_code == 422 and "4 of 6 rows" in faulty.text
    for words in ("row 3 of", "row 6 of", "row 7 of", "row 8 of"):
        assert words in faulty.text
    assert "Good One" in faulty.text and visit.studio.registry.count() == count
    assert "has no column name" in page("nom\nAda\n").text
    assert "put quotes about a name" in html.unescape(page("name\nDoe, Jane\n").text)
    assert "1 to 300 can be printed" in page("name\n" + "".join(f"Person {k}\n" for k in range(301))).text
    listed = "name\n" + "".join('"' + name.replace('"', '""') + '"\n' for name in HOSTILE[:5])
    sound = page(listed, do="check")
    assert sound.status_code == 200 and "5 badges can be issued" in sound.text
    moved = page(listed)
    assert moved.status_code == 303
    job = moved.headers["location"].rsplit("/", 1)[1]
    assert done(visit, job)["state"] == "done"
    files = packed(visit, job)
    assert all(re.fullmatch(r"event/([a-z0-9-]+/)?[a-z]+\.(pdf|png|webp|json|csv)", name) for name in files), list(
        files
    )
    rows = list(csv.DictReader(io.StringIO(files["event/summary.csv"].decode("utf-8-sig"))))
    assert [row["name"] for row in rows] == HOSTILE[:5]
    for row in rows:
        record = visit.studio.registry.by_id(row["id"])
        assert record is not None and record.name == row["name"]
        assert f"event/{row['folder']}/badge.json" in files
    assert visit.ask("GET", f"/issue/jobs/{job}", "issuer").text.count("<bdi>") == 5
    # That these are the very same badges is said, and nothing new is issued.
    known = "name,payload\n" + "".join('"' + row["name"].replace('"', '""') + f'",{row["id"]}\n' for row in rows)
    assert page(known, do="check").text.count("issued already on") == 5
    assert "drawn when it is issued" in page(listed, do="check").text


def test_an_issuer_cannot_turn_an_enrolment_against_its_holder(
    visit: Visit, ada: Badge, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Catches: a page or the API that replaces known figures for anyone who may film; a reason that is not recorded."""
    registry = visit.studio.registry
    record = registry.enroll(ada)
    true = AsBuilt(record.id, -0.0402, 2e-5, 3.0, 0.04, 0.031, 3e-4, 0.995, 0.01)
    poison = replace(true, offset_rad=-1.28, gain_ratio=0.63)
    measured = [true]

    def measure(job_id: str, owner: str, *kinds: str) -> Job:
        result = {"kind": "capture", "id": record.id, "as_built": json.loads(measured[0].to_json())}
        return Job(job_id, "capture", owner, Path(), state="done", result=result)

    monkeypatch.setattr(visit.studio.jobs, "find", measure)
    page, api = f"/enroll/{'0' * 32}", f"/api/badges/{record.id}/captures/{'0' * 32}/keep"
    kept = visit.ask("POST", api, "issuer")
    assert kept.status_code == 200 and kept.json()["as_built"] == json.loads(true.to_json())
    assert "which stay in use" in visit.ask("GET", page, "issuer").text
    measured[0] = poison
    shown = visit.ask("GET", page, "issuer").text
    assert "side by side" in shown and "0.63" in shown and "0.995" in shown and 'name="reason"' not in shown
    assert 'name="reason"' in visit.ask("GET", page, "admin").text
    for answer in (visit.ask("POST", api, "issuer"), visit.ask("POST", f"{page}/keep", "issuer")):
        assert answer.status_code == 409 and "differ from the known ones" in answer.text
    why = {"replace_reason": "another sheet"}
    assert visit.ask("POST", api, "issuer", json=why).status_code == 403
    assert visit.ask("POST", f"{page}/keep", "issuer", data={"reason": "another sheet"}).status_code == 403
    assert json.loads(registry.find(record.id).as_built)["gain_ratio"] == 0.995
    replaced = visit.ask("POST", api, "admin", json=why).json()
    assert (replaced["as_built"]["gain_ratio"], replaced["earlier"]) == (0.63, 1)
    assert "another sheet" in visit.ask("GET", f"/registry/{record.id}", "issuer").text


def test_no_figures_are_kept_in_a_registry_that_was_put_back(
    tmp_path: Path, ada: Badge, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Catches: a drawn capture that comes first, as the registry is of a day before the true one."""
    monkeypatch.setenv("MOIREID_KEYS", str(tmp_path / "keys"))
    monkeypatch.setenv("MOIREID_SEEN", str(tmp_path / "seen.sqlite3"))
    with studio(tmp_path) as visit:
        registry = visit.studio.registry
        file = Path(registry.shown_url.removeprefix("sqlite:///"))
        record, before = registry.enroll(ada), file.read_bytes()
        true = AsBuilt(record.id, -0.0402, 2e-5, 3.0, 0.04, 0.031, 3e-4, 0.995, 0.01)
        poison = replace(true, offset_rad=-1.28)
        result = {"kind": "capture", "id": record.id, "as_built": json.loads(true.to_json())}
        job = Job("0" * 32, "capture", "somebody", Path(), state="done", result=result)
        monkeypatch.setattr(visit.studio.jobs, "find", lambda *_: job)
        keep = f"/api/badges/{record.id}/captures/{job.id}/keep"
        assert visit.ask("POST", keep, "issuer").status_code == 200
        visit.studio.standing()
        file.write_bytes(before)
        job.result = result | {"as_built": json.loads(poison.to_json())}
        refused = visit.ask("POST", keep, "issuer")
        assert refused.status_code == 503 and "ends at log entry" in refused.text
        monkeypatch.setenv("MOIREID_SEEN", str(tmp_path / "another person's"))
        assert registry.find(record.id).as_built is None


def test_a_name_that_exists_is_told_before_anything_is_issued(visit: Visit) -> None:
    """Catches: a second badge of a name issued without a word; a badge whose id another holds; a revoked one."""
    registry = visit.studio.registry
    first = design_badge(Order("Two Of Us", lens=DEFAULT_LENS), payload_for_name("Two Of Us"))
    registry.enroll(first)
    count = registry.count()
    wish = {"name": "Two Of Us", "do": "issue"}
    same = visit.ask("POST", "/issue", "issuer", data=wish | {"payload": first.id or ""})
    assert same.status_code == 200 and "This same badge was already issued" in same.text
    twin = visit.ask("POST", "/issue", "issuer", data=wish)
    assert twin.status_code == 200 and "Another badge has this name already" in twin.text
    assert "Not issued yet." in twin.text
    cyrillic = visit.ask("POST", "/issue", "issuer", data=wish | {"name": "Two \u041ef Us"})
    assert cyrillic.status_code == 200 and "This name looks like that of" in cyrillic.text and first.id in cyrillic.text
    other = visit.ask("POST", "/issue", "issuer", data=wish | {"payload": "0123456789abcdef"})
    assert other.status_code == 200 and "Another badge has this name already" in other.text and first.id in other.text
    assert registry.count() == count
    outcome = visit.ask(
        "POST", "/api/badges/check", "issuer", json={"name": "Two Of Us", "payload": "0123456789abcdef"}
    )
    assert outcome.json()["namesakes"] == [first.id]
    taken = visit.ask("POST", "/api/badges", "issuer", json={"name": "Somebody Else", "payload": first.id})
    assert taken.status_code == 422 and "Two Of Us" in taken.json()["text"]
    registry.revoke(first.id or "", "lost")
    gone = visit.ask("POST", "/api/badges", "issuer", json={"name": "Two Of Us", "payload": first.id})
    assert gone.status_code == 422 and "revoked (lost)" in gone.json()["text"]


def test_a_list_comes_as_a_file_too_and_a_large_one_is_refused(visit: Visit) -> None:
    """Catches: a file that is passed over or read in another coding, and a form that fills the memory."""

    def send(data: bytes) -> httpx.Response:
        fields = {"people": "", "do": "check"} | SMALL
        return visit.ask("POST", "/issue/event", "issuer", data=fields, files={"people_file": ("x.csv", data)})

    outcome = send("\ufeffname\r\nZoë\r\n".encode())
    assert outcome.status_code == 200 and "<bdi>Zoë</bdi>" in outcome.text
    assert "row 2 is not UTF-8" in send("name;line\nZoë;Édition\n".encode("cp1252")).text
    assert send(b"name\n" + b"x" * 300_000).status_code == 413
    pieces = (b"name=" + b"x" * 1000 for _ in range(400))
    kind = {"Content-Type": "application/x-www-form-urlencoded"}
    assert visit.ask("POST", "/issue", "issuer", content=b"".join(pieces), headers=kind).status_code == 413
    assert visit.ask("POST", "/api/badges", "issuer", json=order("x" * 300_000)).status_code == 413
