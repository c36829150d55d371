"""A job whose process is in a stranger's hands.  Each test names the wrong implementation it catches."""

from __future__ import annotations

import asyncio
import copy
import json
import threading
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from kit.webbing import jobs_of
from moireid.asbuilt import MODEL, AsBuilt
from moireid.badge import Badge, load_badge
from moireid.sandbox.process import ForkServer
from moireid.verifier import Claim, verify
from moireid.verifier.fringes.place_map import knots_mm
from moireid_studio.jobs import child, queue, workers
from moireid_studio.jobs.child import Unusable, check_capture, result_of
from moireid_studio.jobs.claims import PreparedJob
from moireid_studio.jobs.queue import Job, Jobs
from moireid_studio.settings import Limits


def ended(jobs: Jobs, job: Job) -> None:
    """Wait for the end of a job."""

    async def last() -> None:
        async with asyncio.timeout(120):
            assert [now async for now, _ in jobs.changes(job)][-1].over

    asyncio.run(last())


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[..., tuple[Job, Jobs]]]:
    """Does one job with a work of `kit.hostile_work`; the studio has two workers."""
    made: list[Jobs] = []

    def one(work: str, kind: str = "verify", questions: int = 0) -> tuple[Job, Jobs]:
        server = ForkServer(f"kit.hostile_work:{work}", sealed=True)
        for module in (child, queue):
            monkeypatch.setattr(module, "films", server)
        # Only what hangs is waited for to its end: on a busy machine others take longer than that to begin.
        limits = Limits(job_s=3.0 if work == "partial" else 100.0, stop_s=0.1)
        made.append(jobs_of(tmp_path / work, limits, lambda _: PreparedJob(questions=questions)))
        made[-1].start()
        job = made[-1].admit(kind, "somebody")
        (job.folder / "film.mp4").write_bytes(b"film")
        made[-1].submit(job, job.folder / "film.mp4")
        ended(made[-1], job)
        return made[-1].find(job.id, "somebody"), made[-1]

    yield one
    for jobs in made:
        stopping = threading.Thread(target=jobs.stop, daemon=True)
        stopping.start()
        stopping.join(20)
        assert not stopping.is_alive()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("work", "code"),
    [
        ("bad_progress", "crash"),
        ("bad_result", "crash"),
        ("bad_pictures", "crash"),
        ("large", "crash"),
        ("partial", "time"),
        ("folder_for_film", "crash"),
    ],
)
def test_it_loses_its_own_job_alone(run: Callable[..., tuple[Job, Jobs]], work: str, code: str) -> None:
    """Catches: a worker that dies of what one process says, a job that stays "working", a stop that hangs."""
    job, jobs = run(work)
    assert job.state == "failed" and job.problem is not None and job.problem[0] == code
    assert job.problem[1].endswith((".", "here.")) and not job.folder.exists()
    assert all(thread.is_alive() for thread in jobs.workers.threads)


def test_it_cannot_have_itself_done_again(run: Callable[..., tuple[Job, Jobs]]) -> None:
    """Catches: a process's word for why it ended taken for the studio's own: "stopped" has a job begun again at once,
    before all that came later, without end."""
    job, _ = run("says_stopped")
    assert (job.state, job.taken) == ("failed", 1) and job.problem is not None and job.problem[0] == "crash"


def test_it_may_ask_as_often_as_a_film_needs(
    run: Callable[..., tuple[Job, Jobs]], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Catches: a process that lists the registry's identities by asking for each of them."""
    asked: list[object] = []
    monkeypatch.setattr(workers, "answer_to", lambda question, people: asked.append(question) or [])
    job, _ = run("questions", "identify", questions=6)
    assert len(asked) == 6 and job.problem is not None and job.problem[0] == "crash"


@pytest.mark.slow
def test_a_result_is_a_report(films: Path) -> None:
    """Catches: an honest report refused; a hostile one that a page or a table would fall over."""
    badge = load_badge(films / "badge.json")
    honest = json.loads(json.dumps(verify(films / "genuine_1.0m.mp4", Claim(badge)).to_json()))
    assert result_of("verify", copy.deepcopy(honest)) == honest
    finding = {"finding": "nobody", "found_id": None, "reasons": [honest["reasons"][0] | {"level": "fail"}]}
    assert result_of("identify", honest | finding) and result_of("identify", dict(finding))
    for wrong in (
        None,
        [],
        {},
        honest | {"verdict": ["accept"]},
        honest | {"input": 5},
        honest | {"reasons": ["x"]},
        honest | {"new": float("inf")},
        honest | {"level": "live"},
    ):
        with pytest.raises(Unusable):
            result_of("verify", wrong)
    with pytest.raises(Unusable):
        result_of("identify", honest | finding | {"found_id": 5})


def test_a_capture_is_of_the_badge_that_was_asked_about(ada: Badge) -> None:
    """Catches: figures that are kept with another person's badge; figures of another model;
    a map or a deviation that a comparison falls over; a film that calls itself a live check."""
    maps = tuple((0.1,) * len(knots_mm(grating)) for grating in ada.gratings)
    true = AsBuilt(str(ada.id), -0.04, 2e-5, 3.0, 0.04, 0.03, 3e-4, 0.99, 0.01)
    mapped = replace(true, place_maps=maps, place_map_sd=0.02)

    def said(figures: AsBuilt, badge_id: str | None = ada.id) -> dict[str, Any]:
        return {"kind": "capture", "id": badge_id, "as_built": json.loads(figures.to_json())}

    for honest in (true, mapped):
        check_capture(said(honest), ada)
    other = replace(true, badge_id="0123456789abcdef")
    wrong = [said(other), said(other, other.badge_id), said(true, other.badge_id), said(true) | {"as_built": [1]}]
    wrong.append(said(true) | {"as_built": json.loads(true.to_json()) | {"model": MODEL + 1}})
    changes = ({"gain_ratio": 0.0}, {"offset_sd": -9}, {"witnessed": True})
    wrong += [said(replace(true, **change)) for change in changes]
    for figures in (*wrong, said(replace(mapped, place_maps=maps[:1] * 9)), {"kind": "capture", "id": ada.id}):
        with pytest.raises(Unusable):
            check_capture(figures, ada)
