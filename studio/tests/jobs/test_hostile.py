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
from moireid.reading.answers import MalformedAnswer
from moireid.sandbox.process import ForkServer
from moireid.verifier import Question, verify
from moireid.verifier.fringes.place_map import knots_mm
from moireid_studio.jobs import child, queue, workers
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

    def one(work: str) -> tuple[Job, Jobs]:
        server = ForkServer(f"kit.hostile_work:{work}", sealed=True)
        for module in (child, queue):
            monkeypatch.setattr(module, "films", server)
        # Only what hangs is waited for to its end: on a busy machine others take longer than that to begin.
        limits = Limits(job_s=3.0 if work == "partial" else 100.0, stop_s=0.1)
        made.append(jobs_of(tmp_path / work, limits))
        made[-1].start()
        job = made[-1].admit("verify", "somebody")
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


def judged_as(kind: str, result: Any, **wish: Any) -> dict[str, Any]:
    """What the studio makes of a result."""
    return workers.checked_result(Job("0" * 32, kind, "somebody", Path("jobs"), wish=wish), result)


@pytest.mark.slow
def test_a_result_is_a_report(films: Path) -> None:
    """Catches: an honest report refused; a hostile one that a page or a table would fall over."""
    badge = load_badge(films / "badge.json")
    honest = json.loads(json.dumps(verify(films / "genuine_1.0m.mp4", Question(badge)).to_json()))
    assert judged_as("verify", copy.deepcopy(honest)) == honest
    finding = {"finding": "nobody", "found_id": None, "reasons": [honest["reasons"][0] | {"level": "fail"}]}
    assert judged_as("identify", honest | finding) and judged_as("identify", dict(finding))
    wrong: tuple[dict[str, Any], ...] = (
        {},
        {"verdict": ["accept"]},
        {"input": 5},
        {"reasons": ["x"]},
        {"level": "live"},
    )
    for change in wrong:
        with pytest.raises(MalformedAnswer):
            judged_as("verify", honest | change if change else {})
    for change in ({"found_id": 5}, {"level": "live"}):
        with pytest.raises(MalformedAnswer):
            judged_as("identify", honest | finding | change)


def test_a_capture_is_of_the_badge_that_was_asked_about(ada: Badge) -> None:
    """Catches: figures that are kept with another person's badge; figures of another model;
    a map or a deviation that a comparison falls over; a film that calls itself a live check."""
    maps = tuple((0.1,) * len(knots_mm(grating)) for grating in ada.gratings)
    true = AsBuilt(str(ada.id), -0.04, 2e-5, 3.0, 0.04, 0.03, 3e-4, 0.99, 0.01)
    mapped = replace(true, place_maps=maps, place_map_sd=0.02)
    wish = {"badge_json": ada.to_json()}
    for honest in (true, mapped):
        said = json.loads(honest.to_json())
        assert judged_as("capture", said, **wish) == {"kind": "capture", "id": ada.id, "as_built": said}
    changes = ({"badge_id": "0123456789abcdef"}, {"gain_ratio": 0.0}, {"offset_sd": -9}, {"witnessed": True})
    wrong = [json.loads(replace(true, **change).to_json()) for change in changes]
    wrong += [{}, json.loads(true.to_json()) | {"model": MODEL + 1}]
    for figures in (*wrong, json.loads(replace(mapped, place_maps=maps[:1] * 9).to_json())):
        with pytest.raises(MalformedAnswer):
            judged_as("capture", figures, **wish)
