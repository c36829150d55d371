"""The First badge pages without a browser: whose build it is, what is taken, and what a process may not do to them.

Next to each test: the wrong implementation it catches.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import msgspec
import pytest

from kit.webbing import Visit, film_form, studio
from moireid.bringup.bring_up import STEPS, Advance
from moireid.bringup.build_folder import BuildFolder, BuildState, Figure, Reading, Wish
from moireid_studio.jobs.build_round import in_page_words
from moireid_studio.pages.first_badge import FILES
from moireid_studio.store.build_store import Build, BuildRound

JPEG, MP4 = b"\xff\xd8\xff\xe0" + bytes(600), b"\0\0\0\x18ftypmp42" + bytes(600)
BEGUN = {"name": "Ada Lovelace", "lens": "50lpi", "printer_dpi": "1200", "paper": "a4", "thickness_mm": "1,02"}


@pytest.fixture
def visit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Visit]:
    """A studio in which no job is done, so that each round stays as it was begun."""
    monkeypatch.setenv("MOIREID_KEYS", str(tmp_path / "keys"))
    with studio(tmp_path, work=False, upload_bytes=1 << 20) as made:
        # As its start would make it.
        (made.folder / "jobs").mkdir()
        yield made


def begin(visit: Visit, role: str = "issuer") -> Build:
    """A new build, of which the first round waits."""
    answer = visit.ask("POST", "/first-badge", role, data=BEGUN)
    assert answer.status_code == 303, answer.text
    build_id = answer.headers["location"].rpartition("/")[2]
    return build_of(visit, build_id)


def build_of(visit: Visit, build_id: str) -> Build:
    found = visit.studio.builds._build(build_id)
    assert found is not None
    return found


def came(visit: Visit, build: Build, came_to: BuildRound, *readings: tuple[str, Reading]) -> None:
    """End the waiting round as its process would."""
    if (job := visit.studio.jobs.ledger.find(build_of(visit, build.id).note.job)) is not None:
        visit.studio.jobs.remove(job)
    state = BuildState(1, "first-badge", build.note.wish, {}, dict(readings))
    (build.media / "first-badge.json").write_bytes(msgspec.json.encode(state))
    (build.work / "round.json").write_bytes(msgspec.json.encode(came_to))


def send(build: Build, slot: str, content: bytes) -> tuple[str, str, str, dict[str, Any]]:
    return "POST", f"/first-badge/{build.id}/media/{slot}", "issuer", film_form(content)


def sent(build: Build) -> list[str]:
    return sorted(path.name for path in build.media.iterdir() if path.suffix != ".json")


SHEET = BuildRound(["charts"], "sheet", None)


def test_a_build_is_its_owner_s_alone(visit: Visit) -> None:
    """Catches: a route that finds a build by its id alone, for an admin too."""
    build = begin(visit)
    came(visit, build, SHEET)
    place = f"/first-badge/{build.id}"
    (build.media / "pitch-test.pdf").write_bytes(b"%PDF")
    gets = [place, f"{place}/report", *(f"{place}/files/{name}" for name in FILES)]
    posts = [(f"{place}/round", {}), (f"{place}/record", {"note": "x"}), (f"{place}/delete", {"sure": "true"})]
    for path in gets:
        assert visit.ask("GET", path, "admin").status_code == 404, path
    for path, data in posts:
        assert visit.ask("POST", path, "admin", data=data).status_code == 404, path
    path, form = f"{place}/media/sheet-photo", film_form(JPEG)
    assert visit.ask("POST", path, "admin", **form).status_code == 404
    assert visit.ask("POST", path, "verifier", **form).status_code == 403
    assert build.id not in visit.ask("GET", "/first-badge", "admin").text
    assert visit.ask("GET", f"{place}/files/pitch-test.pdf", "issuer").content == b"%PDF"
    assert sent(build) == ["pitch-test.pdf"] and visit.ask("GET", "/first-badge/../../etc", "issuer").status_code == 404


def test_what_cannot_be_used_changes_nothing(visit: Visit) -> None:
    """Catches: a text or a film taken for the photo; a file without end; an earlier photo that is lost to a bad one."""
    build = begin(visit)
    came(visit, build, SHEET)
    (build.media / "sheet-photo.png").write_bytes(b"the earlier one")
    for slot, content, status, words in (
        ("sheet-photo", b"hello" * 200, 415, "none of the photos"),
        ("sheet-photo", MP4, 415, "Export a HEIC photo"),
        ("badge-film-1", JPEG, 415, "none of the films"),
        ("badge-film-1", b"GGG".join([bytes(187)] * 5), 415, "none of the films"),
        ("sheet-photo", JPEG + bytes(2 << 20), 413, "larger than the 1 MB"),
        ("sheet-photo", b"", 422, "choose one"),
        ("sheet.json", JPEG, 404, "no such file"),
    ):
        answer = visit.ask(*send(build, slot, content)[:3], **film_form(content))
        assert (answer.status_code, words in answer.text) == (status, True), (slot, answer.text[-1500:])
    assert sent(build) == ["sheet-photo.png"] and visit.left() == []
    assert visit.ask(*send(build, "sheet-photo", JPEG)[:3], **film_form(JPEG)).status_code == 303
    # The new one is in the place of the earlier one, whatever its format.
    assert sent(build) == ["sheet-photo.jpg"]


def test_of_two_uploads_at_once_one_is_read_and_the_other_is_refused(visit: Visit) -> None:
    """Catches: two rounds that write one folder; a film that replaces the one that is being read."""
    build = begin(visit)
    came(visit, build, BuildRound(["badge"], "films", None))
    answers = visit.ask_all([send(build, "badge-film-1", MP4), send(build, "badge-film-1", MP4 + b"2")])
    assert sorted(answer.status_code for answer in answers) == [303, 409]
    refused = next(answer for answer in answers if answer.status_code == 409)
    assert "is being read just now" in refused.text and "Reading what you sent" in refused.text
    assert sent(build) == ["badge-film-1.mp4"]
    for path, data in (("round", {"thickness_mm": "1"}), ("record", {"note": ""})):
        assert visit.ask("POST", f"/first-badge/{build.id}/{path}", "issuer", data=data).status_code == 409
    assert visit.studio.jobs.ledger.counts()["waiting"] == 1


def test_what_a_process_leaves_is_read_no_further_than_is_meant(visit: Visit, tmp_path: Path) -> None:
    """Catches: a link out of the folder that is handed out; a report whose scripts run on the studio's own page; a
    state of any shape or size that is believed; a path or a sheet that the process names."""
    build = begin(visit)
    came(visit, build, SHEET)
    (tmp_path / "secret").write_text("a key")
    (build.media / "sheet.json").symlink_to(tmp_path / "secret")
    (build.media / "badge").symlink_to(tmp_path)
    (tmp_path / "badge.json").write_text("another's")
    place = f"/first-badge/{build.id}"
    for name in ("sheet.json", "badge.json"):
        assert visit.ask("GET", f"{place}/files/{name}", "issuer").status_code == 404
    (build.media / "report.html").write_text("<script>alert(1)</script>")
    policy = visit.ask("GET", f"{place}/report", "issuer").headers["content-security-policy"]
    assert "sandbox" in policy and "script-src" not in policy and "default-src 'none'" in policy
    state = BuildState(1, "first-badge", Wish("Mallory", "/etc/x.json"), {"sheet-photo": "/etc/passwd"})
    (build.media / "first-badge.json").write_bytes(msgspec.json.encode(state))
    page = visit.ask("GET", place, "issuer")
    assert page.status_code == 200 and "Mallory" not in page.text and "/etc" not in page.text
    for damaged in (b"{", b"[]", b'{"did": 1}', b" " * (5 << 20)):
        (build.work / "round.json").write_bytes(damaged)
        (build.media / "first-badge.json").write_bytes(damaged)
        assert "has not begun" in visit.ask("GET", place, "issuer").text
    (build.media / "badge").unlink()
    build.media.rename(build.work / "away")
    build.media.symlink_to(tmp_path)
    assert visit.ask(*send(build, "sheet-photo", JPEG)[:3], **film_form(JPEG)).status_code == 503
    assert not list(tmp_path.glob("sheet-photo*"))


@pytest.mark.slow
def test_a_photo_that_is_none_is_a_result_and_a_lost_build_a_problem(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Catches: a sealed process that cannot write the steps' files; a photo that cannot be decoded and ends the build;
    a record that is made of nothing."""
    monkeypatch.setenv("MOIREID_KEYS", str(tmp_path / "keys"))
    with studio(tmp_path) as visit:
        build = begin(visit)
        assert wait(visit, build).problem is None
        assert visit.ask("GET", f"/first-badge/{build.id}/files/pitch-test.pdf", "issuer").content[:4] == b"%PDF"
        assert visit.ask(*send(build, "sheet-photo", JPEG)[:3], **film_form(JPEG)).status_code == 303
        assert wait(visit, build).problem is None
        page = visit.ask("GET", f"/first-badge/{build.id}", "issuer").text
        assert "What you sent could not be used." in page and str(visit.folder) not in page
        assert visit.ask("POST", f"/first-badge/{build.id}/record", "issuer", data={"note": "x"}).status_code == 303
        assert wait(visit, build).problem is not None
        assert "has no films of a badge yet" in visit.ask("GET", f"/first-badge/{build.id}", "issuer").text
        assert sent(build) != []


def wait(visit: Visit, build: Build) -> Any:
    """The last round, once it is over."""
    for _ in range(600):
        job = visit.studio.jobs.ledger.find(build_of(visit, build.id).note.job)
        if job is not None and job.over:
            return job
        time.sleep(0.1)
    raise AssertionError("the round does not end")


def test_a_page_says_what_is_next_in_its_own_words(visit: Visit) -> None:
    """Catches: a path of this machine, or an option of the command, on a page; a refusal or an advice left out; a
    name or a finding that is run as HTML."""
    for step in STEPS:
        folder = BuildFolder(Path("first-badge"), BuildState(1, "first-badge"))
        words = " ".join(in_page_words(Advance(folder, STEPS, (), step)).ask)
        assert not any(left in words for left in ("first-badge", "Save it", "--", ".mp4", ".jpg", "/")), words
    build = begin(visit)
    advice = "Give the camera's distance by a tape measure (--distance), or its --focal-px."
    reading = Reading(figures=[Figure("Sheet <b>", 0.508, 0.0003, "mm", "look", "words", advice)])
    came(visit, build, BuildRound(["sheet"], "sheet", "first-badge/sheet-photo.jpg <i>is dark"), ("sheet", reading))
    page = visit.ask("GET", f"/first-badge/{build.id}", "issuer").text
    assert "Next: photograph the pitch test" in page and "> sheet-photo.jpg &lt;i&gt;is dark" in page
    assert "0.50800 ± 0.00030 mm" in page and "Sheet &lt;b&gt;" in page and str(visit.folder) not in page
    assert "by a tape measure, or its focal length." in page and 'name="video"' in page
