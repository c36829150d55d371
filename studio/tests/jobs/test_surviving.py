"""Jobs that outlive their studio or their worker.  Each test names the wrong implementation it catches."""

from __future__ import annotations

import socket
import threading
import time
from collections.abc import Iterator
from concurrent.futures import CancelledError
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from urllib.error import URLError

import pytest
import uvicorn
from click.testing import CliRunner
from distributed import KilledWorker

from kit.spoilt_films import Spoilt, hang
from kit.webbing import Visit, film_form, studio, task_of, tiny_film
from moireid.badge import Badge
from moireid.cli.main import moireid
from moireid.errors import SpecError
from moireid.reading.answers import MalformedAnswer, malformed
from moireid.scheduler import scheduler_client
from moireid_studio.api.work_api import taken
from moireid_studio.jobs.child import JobFailure
from moireid_studio.jobs.cluster import Cluster, Run
from moireid_studio.problems import Refusal
from moireid_studio.settings import listening


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
        # As it was taken by a studio that was killed.
        assert visit.studio.jobs.ledger.take(("judge",)) is not None
    with studio(tmp_path, ada) as visit:
        visit.tokens = tokens
        assert visit.wait(job_id, "verifier")["result"]["verdict"] == "inconclusive"
    with studio(tmp_path, ada, work=False) as visit:
        visit.tokens = tokens
        assert visit.ask("GET", f"/api/jobs/{job_id}/report", "verifier").status_code == 200


@pytest.mark.slow
def test_a_film_that_is_removed_leaves_nothing(tmp_path: Path, ada: Badge, form: dict[str, Any]) -> None:
    """Catches: a process that goes on with it; files that come again."""
    with studio(tmp_path, ada, work=False) as visit:
        visit.studio.jobs._folder.mkdir(parents=True)
        visit.studio.jobs.remove(visit.job(begun(visit, form)))
        waiting = begun(visit, form)
        (visit.job(waiting).folder / "film.mp4").unlink()
        visit.studio.jobs.doer.prepare = lambda job: task_of(job, Spoilt(hang))
        visit.studio.jobs.start()
        assert visit.wait(waiting, "verifier")["problem"]["code"] == "storage"
        at_work = begun(visit, form)
        while visit.job(at_work).state != "working":
            time.sleep(0.02)
        visit.studio.jobs.remove(visit.job(at_work))
    assert visit.left() == []


@contextmanager
def served(visit: Visit, bound: socket.socket) -> Iterator[None]:
    """Serve a studio, for workers that ask it over HTTP."""
    server = uvicorn.Server(uvicorn.Config(visit.app, lifespan="off", log_config=None))
    thread = threading.Thread(target=server.run, kwargs={"sockets": [bound]})
    thread.start()
    try:
        yield
    finally:
        server.should_exit = True
        thread.join()


def test_workers_of_a_scheduler_judge_the_films(tmp_path: Path, ada: Badge, form: dict[str, Any]) -> None:
    """Catches: a worker that needs the registry; a film, a report or questions that do not get through; a token that
    opens anything once its job is over, or without one; a job that a lost scheduler fails.
    """
    from distributed import LocalCluster

    bound = listening("127.0.0.1", 0)
    url, tokens = f"http://127.0.0.1:{bound.getsockname()[1]}", list[str]()
    with (
        LocalCluster(1, threads_per_worker=1, processes=False, protocol="tcp", dashboard_address=None) as cluster,
        studio(tmp_path, ada, scheduler=cluster.scheduler_address, worker_url=url) as visit,
        served(visit, bound),
    ):
        kept = visit.studio.jobs.doer.cluster
        assert kept is not None and kept.there
        usual = kept.run_of
        kept.run_of = lambda token: tokens.append(token) or usual(token)  # type: ignore[method-assign,func-returns-value]
        job = visit.wait(begun(visit, form), "verifier")
        assert job["result"]["verdict"] == "inconclusive" and job["frames"]["read"] and job["report"]
        assert visit.ask("GET", f"/api/jobs/{job['id']}/report?format=zip", "verifier").content[:2] == b"PK"
        answer = visit.ask("POST", "/api/identify", "verifier", files=form["files"]).json()
        assert answer["finding"] == "inconclusive" and answer["sealed"] is not None
        assert not any("film" in name for name in visit.left())
        for token in (tokens[0], "", visit.tokens["admin"]):
            given = {"Authorization": f"Bearer {token}"}
            assert visit.ask("GET", "/work/film", None, headers=given).status_code == 404
            assert visit.ask("POST", "/work/message", None, headers=given, json={}).status_code == 404


class Ended:
    """A future of Dask that has ended, with an error or with what a worker returned."""

    def __init__(self, came: Exception | None) -> None:
        self._came = came

    def done(self) -> bool:
        return True

    def result(self) -> None:
        if isinstance(self._came, Exception):
            raise self._came


@pytest.mark.parametrize(
    ("came", "code"),
    [
        (KilledWorker("film", None, 3), "crash"),
        # The scheduler went away: the job waits again.
        (CancelledError(), "stopped"),
        (URLError("refused"), "system"),
    ],
)
def test_what_is_lost_with_a_cluster_has_its_own_end(came: Exception, code: str, tmp_path: Path) -> None:
    """Catches: a film that is given up with its scheduler; one that kills workers and is sent out for ever."""
    cluster, run = object.__new__(Cluster), Run(tmp_path, lambda: None, lambda message: None)
    with pytest.raises(JobFailure) as lost:
        cluster._end(Ended(came), run, lambda: False)
    assert lost.value.code == code
    with pytest.raises(JobFailure, match="stopped"):
        cluster._end(Ended(None), run, lambda: True)


def test_a_worker_s_message_is_checked_as_any_other(tmp_path: Path) -> None:
    """Catches: a worker whose word counts unchecked; one that goes on with a job that was ended by what it said."""

    def handle(message: dict[str, Any]) -> None:
        raise malformed("film.mp4", "no report")

    cluster, run = object.__new__(Cluster), Run(tmp_path, lambda: None, handle)
    with pytest.raises(Refusal) as refused:
        taken(run, b'{"result": {}}')
    assert refused.value.status == 410
    with pytest.raises(MalformedAnswer):
        cluster._end(Ended(None), run, lambda: False)


@pytest.mark.claim("A scheduler beyond loopback needs certificates")
@pytest.mark.parametrize("address", ["tcp://192.0.2.7:8786", "tcp://example.org:8786", "ucx://192.0.2.7:1"])
def test_a_scheduler_that_others_reach_needs_certificates(address: str, tmp_path: Path) -> None:
    """Catches: a studio that sends films, and takes code, over a line that anyone may join."""
    with pytest.raises(SpecError, match="tls://"):
        scheduler_client(address, ("", "moireid-lab"))
    done = CliRunner().invoke(moireid, ["serve", "--scheduler", address, "--port", "0", "--data", str(tmp_path)])
    assert done.exit_code == 2 and "--worker-url" in done.stderr
