"""Jobs that outlive their studio, their worker or a fault of their storage.  Each test names the wrong
implementation it catches."""

from __future__ import annotations

import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest

from kit.registries import running_server
from kit.spoilt_films import Spoilt, hang
from kit.webbing import Visit, film_form, studio, tiny_film
from moireid.badge import Badge
from moireid_studio.jobs.claims import PreparedJob
from moireid_studio.store import storage as storage_module
from moireid_studio.store.storage import Remote


@pytest.fixture(autouse=True)
def keys(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MOIREID_KEYS", str(tmp_path / "keys"))


@pytest.fixture
def form(tmp_path: Path, films: Path, ada: Badge) -> dict[str, Any]:
    return film_form(tiny_film(films / "genuine_1.0m.mp4", tmp_path / "tiny.mp4"), claim=ada.name)


def begun(visit: Visit, form: dict[str, Any]) -> str:
    """The id of a job that was begun by a verifier."""
    answer = visit.ask("POST", "/api/jobs", "verifier", **form)
    assert answer.status_code == 202, answer.text
    return str(answer.json()["id"])


def test_a_film_that_waits_is_judged_after_a_restart(tmp_path: Path, ada: Badge, form: dict[str, Any]) -> None:
    """Catches: jobs in one process's memory; a result that goes with it; a verdict that is written down twice."""
    with studio(tmp_path, ada, work=False) as visit:
        visit.studio.jobs._folder.mkdir(parents=True)
        job_id, tokens = begun(visit, form), visit.tokens
    with studio(tmp_path, ada) as visit:
        visit.tokens = tokens
        assert visit.wait(job_id, "verifier")["result"]["verdict"] == "inconclusive"
    with studio(tmp_path, ada, work=False) as visit:
        visit.tokens = tokens
        assert visit.ask("GET", f"/api/jobs/{job_id}/report", "verifier").status_code == 200
        assert len(visit.studio.verdicts.given(9)) == 1


#: A worker that takes a job, says so, and goes on until it is killed; its leases and pauses are short.
WORKER = """
import sys, time
from pathlib import Path
from moireid_studio.store import ledger
from moireid_studio.store.database import database_of
ledger.LEASE_S = ledger.PAUSE_S = 0.001
one = ledger.Ledger(database_of(Path(sys.argv[1]), "jobs.sqlite3", None, log=True), Path(sys.argv[1]) / "jobs")
while (job := one.take(("judge",))) is None:
    time.sleep(0.05)
print(job.id, flush=True)
time.sleep(1000)
"""


@pytest.mark.slow
def test_twelve_workers_that_are_killed_in_a_row_lose_no_film(tmp_path: Path, ada: Badge, form: dict[str, Any]) -> None:
    """Catches: a film that is given up, or judged unread, because workers were lost with it; a kill that is not shown;
    a verdict that is written down for each time that a film was begun.
    """
    with studio(tmp_path, ada, work=False) as visit:
        visit.studio.jobs._folder.mkdir(parents=True)
        ids = [begun(visit, form) for _ in range(3)]
        taken = []
        for _ in range(12):
            command = [sys.executable, "-c", WORKER, str(visit.folder)]
            with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as worker:
                assert worker.stdout is not None
                taken.append(worker.stdout.readline().strip())
                worker.kill()
        assert set(taken) <= set(ids) and max(taken.count(one) for one in ids) >= 4
        assert sum(visit.job(one).kills for one in ids) >= 12 - len(ids)
        assert "was lost" in visit.ask("GET", f"/verify/{ids[0]}", "verifier").text
        visit.studio.jobs.start()
        ended = [visit.wait(one, "verifier") for one in ids]
        assert [one["result"]["verdict"] for one in ended] == ["inconclusive"] * 3
        assert sum(one["lost_workers"] for one in ended) == 12
        assert len(visit.studio.verdicts.given(9)) == 3


@pytest.mark.slow
def test_a_film_that_is_removed_leaves_no_verdict(
    tmp_path: Path, ada: Badge, form: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Catches: a verdict on what was taken back; a process that goes on with it; files that come again."""
    monkeypatch.setattr("moireid_studio.store.ledger.AGAIN_S", 0.1)
    with studio(tmp_path, ada, work=False) as visit:
        visit.studio.jobs._folder.mkdir(parents=True)
        visit.studio.jobs.remove(visit.job(begun(visit, form)))
        waiting = begun(visit, form)
        # Its files alone are gone.
        visit.studio.jobs._storage.remove(waiting)
        visit.studio.jobs.doer.prepare = lambda job: PreparedJob({"found": Spoilt(hang)})
        visit.studio.jobs.start()
        assert visit.wait(waiting, "verifier")["problem"]["code"] == "storage"
        at_work = begun(visit, form)
        while visit.job(at_work).state != "working":
            time.sleep(0.02)
        visit.studio.jobs.remove(visit.job(at_work))
    assert visit.left() == [] and visit.studio.verdicts.given(9) == []


@pytest.mark.slow
def test_studios_that_share_database_and_storage_work_as_one(
    tmp_path: Path, ada: Badge, form: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Catches: a job, a report or a token that one studio alone knows; a film left in the storage; a studio that
    removes what others have there.
    """
    monkeypatch.setattr(storage_module, "WAIT_S", 0.01)
    films = tmp_path / "storage"
    with running_server() as server:
        shared: dict[str, Any] = {"state": server.fresh(), "storage": films.as_uri()}
        with studio(tmp_path, ada, work=False, data="one", workers=0, **shared) as one:
            one.studio.jobs.start()
            job_id = begun(one, form)
            assert [path.name for path in films.rglob("*") if path.is_file()] == ["film.mp4"] and one.left() == []
            with studio(tmp_path, ada, data="two", **shared) as two:
                two.tokens = one.tokens
                assert two.wait(job_id, "verifier")["state"] == "done"
                assert one.ask("GET", f"/api/jobs/{job_id}/report", "verifier").status_code == 200
                answer = one.ask("POST", "/api/verify", "verifier", **form)
                assert answer.status_code == 200 and answer.json()["verdict"] == "inconclusive"
                assert "event: end" in one.ask("GET", f"/api/jobs/{job_id}/events", "verifier").text
                assert len(one.studio.verdicts.given(9)) == 2
                failing(two, 4, monkeypatch)
                assert two.wait(begun(one, form), "verifier")["state"] == "done"
                failing(two, 1000, monkeypatch)
                job = two.wait(begun(one, form), "verifier")
                assert (job["state"], job["problem"]["code"]) == ("failed", "storage")
        names = {path.name for path in films.rglob("*") if path.is_file()}
        assert "film.mp4" not in names and "signals.csv" in names


def failing(visit: Visit, times: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Let a studio's storage fail so many times."""
    storage, left = visit.studio.jobs._storage, [times]
    assert isinstance(storage, Remote)
    monkeypatch.setattr("moireid_studio.store.ledger.AGAIN_S", 0.1)
    real = type(storage._system).get_file

    def get_file(*given: Any, **more: Any) -> None:
        left[0] -= 1
        if left[0] >= 0:
            raise OSError("the storage is away")
        real(storage._system, *given, **more)

    monkeypatch.setattr(storage._system, "get_file", get_file)
