"""Uploads and what becomes of them.  Each test names the wrong implementation it catches."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

import httpx
import psutil
import pytest

from kit.spoilt_films import Spoilt, Thief, hang
from kit.webbing import OpenStudio, Visit, film_form, studio, task_of, tiny_film
from moireid.badge import Badge, load_badge
from moireid.errors import SpecError
from moireid.provenance import FROM_FILE
from moireid.sandbox.process import sealed_here
from moireid.verifier import Question, verify
from moireid_studio.app import create_app


@pytest.fixture(scope="module")
def visit(open_studio: OpenStudio, ada: Badge) -> Visit:
    return open_studio(ada, job_s=60.0, upload_bytes=1 << 20, memory_bytes=1 << 30, waiting=32)


@pytest.fixture(scope="module")
def tiny(tmp_path_factory: pytest.TempPathFactory, films: Path) -> Path:
    return tiny_film(films / "genuine_1.0m.mp4", tmp_path_factory.mktemp("tiny") / "tiny.mp4")


def spoil(visit: Visit, act: Callable[[], object], film: Path) -> str:
    """The id of a job whose process does that."""
    owner = visit.studio.tokens.find(visit.tokens["verifier"])
    assert owner is not None
    job = visit.studio.jobs.admit("verify", owner.id)
    video = job.folder / "film.mp4"
    video.write_bytes(film.read_bytes())
    doer = visit.studio.jobs.doer
    usual = doer.prepare
    doer.prepare = lambda one: task_of(one, Spoilt(act)) if one.id == job.id else usual(one)
    visit.studio.jobs.submit(job, video)
    return job.id


def ended(visit: Visit, job_id: str) -> dict:
    begun = time.monotonic()
    while (job := visit.ask("GET", f"/api/jobs/{job_id}", "verifier").json())["state"] not in ("done", "failed"):
        assert time.monotonic() - begun < 200
        time.sleep(0.05)
    return job


@pytest.mark.slow
def test_the_api_says_what_the_command_says(visit: Visit, tmp_path: Path, films: Path) -> None:
    """Catches: an API with a verdict of its own, figures left out, or the server's path in the report."""
    film = tiny_film(films / "genuine_1.0m.mp4", tmp_path / "film.mp4", frames=100, size=(960, 540))
    badge, asked = films / "badge.json", {"cover": "0.25"}
    answer = visit.ask("POST", "/api/verify", "verifier", **film_form(film, badge, name="../../x.mp4", **asked))
    assert answer.status_code == 200
    claim = Question(load_badge(badge), provenance=FROM_FILE, cover_share=0.25)
    said, own = answer.json(), verify(film, claim).to_json()
    assert said.pop("timing").keys() == own.pop("timing").keys()
    assert said["input"].pop("path") == "film.mp4" and own["input"].pop("path")
    # The studio has a registry, in which it looks for the badge of the file; the claim here has none.
    assert own.pop("registry") is None and said.pop("registry")["fingerprint"]
    # Read in a sealed process there, and in this one here.
    assert own.pop("sealed") == [] and said.pop("sealed") == list(sealed_here())
    assert said["verdict"] == "accept"
    assert said == own
    assert visit.left() == []


def test_a_job_reports_its_progress_and_keeps_its_report(visit: Visit, tiny: Path, films: Path) -> None:
    """Catches: a film that stays, a report of another, results that strangers read."""
    begun = visit.ask("POST", "/api/jobs", "verifier", **film_form(tiny, films / "badge.json"))
    assert begun.status_code == 202
    path = begun.headers["location"]
    events = visit.ask("GET", f"{path}/events", "verifier").text
    assert events.startswith("event: progress\ndata: {") and events.count("event: end") == 1
    answer = visit.ask("GET", path, "verifier").json()
    assert (answer["state"], answer["result"]["verdict"], answer["report"]) == ("done", "inconclusive", True)
    assert not any("film" in name or "upload" in name for name in visit.left())
    report = visit.ask("GET", f"{path}/report", "verifier")
    assert report.headers["content-disposition"].startswith("attachment")
    assert "sandbox" in report.headers["content-security-policy"]
    assert "<h1>? Cannot tell: " in report.text
    assert visit.ask("GET", f"{path}/report?format=zip", "verifier").content[:2] == b"PK"
    page = f"/verify/{answer['id']}"
    for other in (path, f"{path}/events", f"{path}/report", page, f"{page}/picture/badge.png"):
        assert visit.ask("GET", other, "admin").status_code == 404, other
    visit.studio.jobs.remove(visit.job(answer["id"]))
    assert visit.left() == []


def test_a_studio_asks_for_a_level_that_no_visitor_lowers(
    tmp_path: Path, tiny: Path, films: Path, ada: Badge, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Catches: a policy that is a default alone; a visitor who cannot ask for more."""
    form = partial(film_form, tiny, films / "badge.json")
    # No one waits for these jobs, and they are left behind: so this studio is the test's own.
    with studio(tmp_path, ada) as own:

        def asked(policy: str | None, **more: str) -> str | None:
            monkeypatch.setattr(own.studio, "settings", replace(own.studio.settings, level=policy))
            answer = own.ask("POST", "/api/jobs", "verifier", **form(**more))
            level: str | None = own.job(answer.json()["id"]).wish["level"]
            return level

        assert asked(None) is None and asked("record") == "record" and asked("record", level="live") == "live"
        assert asked(None, level="record") == "record"
        assert asked("enrolled") == asked("enrolled", level="record") == "enrolled"
        assert asked("enrolled", level="live") == "live"
        assert own.ask("POST", "/api/jobs", "verifier", **form(level="original")).status_code == 422


@pytest.mark.slow
def test_identify_and_claims(visit: Visit, tiny: Path, ada: Badge) -> None:
    """Catches: a claim that is not looked up, or that reaches a page or a query as it is; an identity shown to a
    verifier.
    """
    answer = visit.ask("POST", "/api/identify", "verifier", **film_form(tiny)).json()
    assert (answer["finding"], answer["found_id"], answer["found_name"]) == ("inconclusive", None, None)
    answer = visit.ask("POST", "/api/verify", "verifier", **film_form(tiny, claim="Ada Lovelace"))
    assert answer.status_code == 200 and answer.json()["badge"] == {"id": None, "name": ada.name, "line": None}
    answer = visit.ask("POST", "/api/verify", "admin", **film_form(tiny, claim="Ada Lovelace"))
    assert answer.status_code == 200 and answer.json()["badge"]["id"] == ada.id
    for claim in ("no one", "' OR 1=1 --", "%", "<b>"):
        refused = visit.ask("POST", "/api/verify", "verifier", **film_form(tiny, claim=claim))
        assert (refused.status_code, refused.json()["code"]) == (404, "no_claim")
        assert "sqlite" not in refused.text
    assert visit.left() == []


@pytest.mark.claim("A film that takes over its reader in the studio gets nothing")
@pytest.mark.skipif(sys.platform != "linux", reason="other systems cannot close this")
def test_a_film_that_takes_over_its_reader_gets_nothing(visit: Visit, tiny: Path) -> None:
    """Catches: a key, the registry, another visitor's film, the tokens or the network within a stranger's reach."""
    other = visit.studio.jobs.admit("verify", "somebody")
    (other.folder / "film.mp4").write_bytes(b"another film")
    registry, tokens = visit.folder.parent / "registry.sqlite3", visit.folder / "tokens.sqlite3"
    paths = (visit.studio.registry.key_path, other.folder / "film.mp4", registry, tokens)
    assert all(path.stat().st_size for path in paths)
    with socket.create_server(("127.0.0.1", 0)) as server:
        thief = Thief(paths, server.getsockname()[1])
        job = ended(visit, spoil(visit, thief, tiny))
    text = f"the thief has [], and its own film of {tiny.stat().st_size} bytes"
    assert job["problem"] == {"code": "MediaError", "text": text}
    visit.studio.jobs.remove(other)


@pytest.mark.slow
def test_a_film_that_hangs_is_ended(tmp_path: Path, tiny: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Catches: a time limit that is not kept, and a stop that waits for ever."""
    monkeypatch.setenv("MOIREID_KEYS", str(tmp_path / "keys"))
    with studio(tmp_path, job_s=1.0) as visit:
        hung = ended(visit, spoil(visit, hang, tiny))
        assert (hung["state"], hung["problem"]["code"]) == ("failed", "time")
    with studio(tmp_path) as visit:
        left = spoil(visit, hang, tiny)
        time.sleep(0.5)
    # It was given back: the studio that starts next has it, and its film.
    with studio(tmp_path, work=False) as visit:
        job = visit.job(left)
        assert (job.state, job.taken) == ("waiting", 0) and (job.folder / "film.mp4").is_file()


def test_no_more_films_are_taken_than_the_queue_has_places(visit: Visit, tiny: Path, films: Path) -> None:
    """Catches: a queue, and a disk, that grow without a bound; one that stays full."""
    held = [visit.studio.jobs.admit("verify", f"somebody {k % 4}") for k in range(96)]
    refused = visit.ask("POST", "/api/verify", "verifier", **film_form(tiny, films / "badge.json"))
    assert (refused.status_code, refused.json()["code"]) == (503, "busy") and "retry-after" in refused.headers
    visit.studio.jobs.remove(held.pop())
    assert visit.ask("POST", "/api/verify", "verifier", **film_form(tiny, films / "badge.json")).status_code == 200
    for job in held:
        visit.studio.jobs.remove(job)
    assert visit.left() == []


@pytest.mark.parametrize(
    ("video", "fields", "status", "code"),
    [
        (b"", {"claim": "Ada Lovelace"}, 422, "fields"),
        (b"#EXTM3U\n/etc/passwd\n", {"claim": "Ada Lovelace"}, 415, "no_film"),
        (b"\x89PNG\r\n\x1a\n" + bytes(600), {"claim": "Ada Lovelace"}, 415, "no_film"),
        (bytes(4) + b"ftypisom" + bytes(600), {"claim": "Ada Lovelace"}, 422, "MediaError"),
        (bytes(4) + b"ftypisom" + bytes(1 << 20), {"claim": "Ada Lovelace"}, 413, "too_large"),
        (bytes(4) + b"ftypisom" + bytes(600), {}, 422, "fields"),
        (bytes(4) + b"ftypisom" + bytes(600), {"claim": "Ada Lovelace", "badge": "{}"}, 422, "fields"),
        (bytes(4) + b"ftypisom" + bytes(600), {"badge": "[" * 100_000}, 422, "SpecError"),
        (bytes(4) + b"ftypisom" + bytes(600), {"claim": "Ada Lovelace", "require_original": "yes!"}, 422, "fields"),
        (bytes(4) + b"ftypisom" + bytes(600), {"claim": "Ada Lovelace", "path": "/etc/passwd"}, 422, "fields"),
        (bytes(4) + b"ftypisom" + bytes(600), {"claim": "x" * (2 << 20)}, 413, "too_large"),
    ],
)
def test_what_is_no_film_or_no_form_is_refused(
    visit: Visit, video: bytes, fields: dict[str, str], status: int, code: str
) -> None:
    """Catches: a file believed by its name, a playlist handed to FFmpeg, limits that are not kept, leavings."""
    answer = visit.ask("POST", "/api/verify", "verifier", **film_form(video, **fields))
    assert (answer.status_code, answer.json()["code"]) == (status, code), answer.text
    assert visit.left() == []


@pytest.mark.slow
def test_leavings_go_at_the_start_and_results_after_their_time(
    tmp_path: Path, tiny: Path, films: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Catches: films of a killed server that stay for ever, results that are kept longer than stated."""
    monkeypatch.setenv("MOIREID_KEYS", str(tmp_path / "keys"))
    monkeypatch.setattr("moireid_studio.jobs.workers.SWEEP_S", 0.2)
    left = tmp_path / "studio" / "jobs" / ("dead" * 8) / "film.mp4"
    left.parent.mkdir(parents=True)
    left.write_bytes(b"of a killed server")
    with studio(tmp_path, keep_s=1.0) as visit:
        assert visit.left() == []
        begun = visit.ask("POST", "/api/jobs", "verifier", **film_form(tiny, films / "badge.json")).json()
        ended(visit, begun["id"])
        time.sleep(2.0)
        assert visit.ask("GET", f"/api/jobs/{begun['id']}", "verifier").status_code == 404
        assert visit.left() == []
        with pytest.raises(SpecError, match="another studio runs"):
            create_app(visit.studio.settings)


@pytest.mark.slow
def test_a_server_that_is_killed_leaves_no_process(tmp_path: Path, films: Path) -> None:
    """Catches: processes that go on with a film when no one waits for it any more."""
    environment = os.environ | {"MOIREID_KEYS": str(tmp_path / "keys")}
    program = [sys.executable, "-c", "import sys; from moireid.cli.main import main; sys.argv[0] = 'moireid'; main()"]
    url = f"sqlite:///{tmp_path}/registry.sqlite3"
    subprocess.run([*program, "registry", "init", "--registry", url], env=environment, check=True, capture_output=True)
    serve = [*program, "serve", "--port", "0", "--no-auth", "--registry", url, "--data", str(tmp_path / "studio")]
    with subprocess.Popen(serve, env=environment, stderr=subprocess.PIPE, text=True) as server:
        assert server.stderr is not None
        home = server.stderr.readline().split()[4]
        form = film_form(films / "genuine_1.0m.mp4", films / "badge.json")
        job = httpx.post(f"{home}api/jobs", timeout=100, **form).json()["id"]
        while not httpx.get(f"{home}api/jobs/{job}", timeout=100).json()["frames"]["read"]:
            time.sleep(0.1)
        theirs = psutil.Process(server.pid).children(recursive=True)
        assert len(theirs) >= 2
        server.kill()
    _, alive = psutil.wait_procs(theirs, timeout=60)
    assert alive == []
