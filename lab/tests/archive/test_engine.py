"""The engine of collections: jobs by themselves, several at a time, schedulers started apart."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import ExitStack, closing, contextmanager
from pathlib import Path

import pytest

import moireid
from kit.film_stubs import Stub, act, notes
from kit.film_taken_over import HostileOrder, take_over
from kit.places import TESTS
from moireid.errors import MoireIdError, SpecError
from moireid.sandbox.process import sealed_here
from moireid.sandbox.seal import FILES
from moireid_lab.archive import engine
from moireid_lab.archive.engine import Task, run_tasks
from moireid_lab.archive.isolated import Limits, LostJob
from moireid_lab.archive.worker import Done

QUICK = Limits(seconds=20.0, memory_mb=1000)


def stubs(log: Path, count: int, seconds: float) -> list[Task]:
    return [Task((Stub(f"f{k}", log, seconds),)) for k in range(count)]


def begun(log: Path) -> Counter[str]:
    """How often each film was begun."""
    return Counter(line[1] for line in notes(log) if line[0] == "begun")


@pytest.mark.slow
def test_a_job_that_crashes_hangs_or_eats_memory_loses_itself_alone(tmp_path: Path):
    """Catches: a fault that ends the run or takes another's row, a reason that names the wrong fault, a job tried
    again, a child left behind.
    """
    log = tmp_path / "log"
    faults = ("", "crash", "leave", "memory", "raise", "hang", "")
    tasks = [Task(tuple(Stub(f"{fault}{k}", log, fault=fault) for k, fault in enumerate(faults)))]
    ((_, done),) = run_tasks(act, tasks, workers=1, limits=Limits(seconds=2.0, memory_mb=1000))
    assert (done.outcomes[0], done.outcomes[-1], done.worker) == ("0", "6", "here")
    lost = [one for one in done.outcomes if isinstance(one, LostJob)]
    assert [one.fault for one in lost] == ["crash", "crash", "memory", "program", "time"]
    words = " / ".join(one.why for one in lost)
    for part in ("SIGSEGV", "exit code 7", "than the 1000 MB", "LookupError: nothing there", "than the 2 s"):
        assert part in words
    assert set(begun(log).values()) == {1} and len(begun(log)) == len(faults)
    for line in notes(log):
        with pytest.raises(ProcessLookupError):
            os.kill(int(line[-2]), 0)


def test_a_film_that_took_over_its_process_reads_no_other_film(tmp_path: Path):
    """Catches: a process that may read more than its own film, such as all files but keys, or that reads one film after
    another, so that a former film's code sees the next; a reader that may write.
    """
    if FILES not in sealed_here():
        pytest.skip("this system closes no files")
    films = [tmp_path / "a.mp4", tmp_path / "b.mp4"]
    for film in films:
        film.write_text(f"content of {film.name}")
    acts = [HostileOrder("steal", str(film)) for film in films] + [HostileOrder("write"), HostileOrder("number")]
    tasks = [Task(tuple(acts), str(film)) for film in films]
    found = [done.outcomes for _, done in run_tasks(take_over, tasks, workers=1, limits=QUICK)]
    for own in (0, 1):
        assert found[own][own] == f"content of {films[own].name}"
        assert isinstance(lost := found[own][1 - own], LostJob) and "PermissionError" in lost.why
        assert isinstance(found[own][2], LostJob)
    assert found[0][3] != found[1][3]


@contextmanager
def started(*command: str, folder: Path) -> Iterator[subprocess.Popen[bytes]]:
    """A Dask program as somebody starts it, where ours and the stubs can be imported."""
    path = os.pathsep.join([str(Path(moireid.__file__).parent.parent), str(TESTS)])
    process = subprocess.Popen(
        [sys.executable, "-m", "distributed.cli.dask_" + command[0], *command[1:]],
        cwd=folder,
        env=os.environ | {"PYTHONPATH": path},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    try:
        yield process
    finally:
        process.kill()
        process.wait()


@contextmanager
def deployment(folder: Path) -> Iterator[tuple[str, subprocess.Popen[bytes]]]:
    """A scheduler started apart: its address and process."""
    note = folder / "scheduler.json"
    with started("scheduler", "--port", "0", *near(folder), folder=folder) as scheduler:
        last = time.monotonic() + 60
        while not note.exists() or not note.read_text():
            assert time.monotonic() < last
            time.sleep(0.05)
        yield json.loads(note.read_text())["address"], scheduler


def near(folder: Path) -> tuple[str, ...]:
    return "--host", "127.0.0.1", "--scheduler-file", str(folder / "scheduler.json"), "--no-dashboard"


@pytest.mark.slow
def test_a_scheduler_started_apart_gives_the_same_and_its_end_is_reported(tmp_path: Path, monkeypatch):
    """Catches: work that only this program's own processes can import, a run that waits for ever for a scheduler that
    has gone or for workers that do not come, processes of a broken-off run left at work.
    """
    log, film = tmp_path / "log", tmp_path / "film.txt"
    film.write_text("shown")
    tasks = [Task((Stub(f"f{k}", log), Stub(f"g{k}", log, fault="leave" if k == 1 else "")), str(film)) for k in (0, 1)]

    def plain(done: Done) -> list[str]:
        return [one.fault if isinstance(one, LostJob) else one for one in done.outcomes]

    here = {place: plain(done) for place, done in run_tasks(act, tasks, workers=1, limits=QUICK)}
    with deployment(tmp_path) as (address, scheduler), monkeypatch.context() as patch, ExitStack() as stack:
        patch.setattr(engine, "NO_WORKER_S", 0.5)
        with pytest.raises(MoireIdError, match=r"no worker has been alive for 0.5 s; run the same command again"):
            list(run_tasks(act, tasks, scheduler=address, limits=QUICK))
        patch.undo()
        one = ("worker", "--nthreads", "2", "--nworkers", "1", "--no-nanny", *near(tmp_path))
        stack.enter_context(started(*one, folder=tmp_path))
        found = dict(run_tasks(act, tasks, scheduler=address, limits=QUICK))
        assert {place: plain(done) for place, done in found.items()} == here
        assert here == {0: ["f0 shown", "g0 shown"], 1: ["f1 shown", "crash"]}
        with pytest.raises(SpecError, match="leave out --workers"):
            list(run_tasks(act, tasks, scheduler=address, workers=2))
        with closing(run_tasks(act, stubs(log, 3, 0.01) + stubs(log, 9, 60.0), scheduler=address, limits=QUICK)) as run:
            next(run)
        gone = time.monotonic() + 15
        children = {int(line[-2]) for line in notes(log)}
        while any(Path(f"/proc/{child}").exists() for child in children):
            assert time.monotonic() < gone
            time.sleep(0.05)
        running = run_tasks(act, stubs(log, 2, 0.01) + stubs(log, 4, 60.0), scheduler=address, limits=Limits())
        next(running)
        scheduler.kill()
        with pytest.raises(MoireIdError, match=r"scheduler went away; run the same command again"):
            list(running)


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:1", "gopher://localhost:1", "tls://localhost:x"])
def test_an_address_where_no_scheduler_answers_is_reported_in_one_sentence(tmp_path: Path, address: str, monkeypatch):
    """Catches: a traceback of another package, a wait without end."""
    monkeypatch.setattr("moireid.scheduler.CONNECT_S", 0.5)
    with pytest.raises(SpecError, match="no Dask scheduler answers at") as refused:
        list(run_tasks(act, stubs(tmp_path / "log", 2, 0), scheduler=address))
    assert re.match(
        rf"no Dask scheduler answers at '{re.escape(address)}' \(.+\); give tls://HOST:PORT", str(refused.value)
    )
