"""Rows of a collection: kept as they come, gone on with after a break, made anew where something changed."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import psutil
import pytest

import moireid
from kit.film_stubs import notes, score, score_as_sealed
from kit.places import TESTS
from moireid.badge import Badge
from moireid.errors import SpecError
from moireid.result_cache import kept_rows
from moireid.sandbox.process import sealed_here
from moireid_lab.archive.engine import Task
from moireid_lab.archive.isolated import Fault, Limits, LostJob
from moireid_lab.archive.worker import Done
from moireid_lab.evaluation import collect as collecting
from moireid_lab.evaluation.collect import ScoredFilm, collect
from moireid_lab.evaluation.film_rows import PASSING, Job, ScoredRow, failed_row, score_film
from moireid_lab.evaluation.manifest import read_manifest

QUICK = Limits(seconds=20.0, memory_mb=1500)
BOTH = ("moireid", "published")


def manifest_of(folder: Path, *films: tuple[str, str], label: str = "genuine") -> Path:
    """A manifest of films whose words say what the stub does with them (`film_stubs.score`)."""
    path = folder / "films.csv"
    lines = ["video,label,claim,group"]
    for name, words in films:
        if not (folder / name).exists() or (folder / name).read_text() != f"{folder / 'log'} {words}":
            (folder / name).write_text(f"{folder / 'log'} {words}")
        lines.append(f"{name},{label},,")
    path.write_text("\n".join(lines), encoding="utf-8")
    return path


@pytest.fixture
def lost(monkeypatch: pytest.MonkeyPatch) -> dict[str, Fault]:
    """The engine's place taken by this process, which loads the verifier once; what films are lost to, by name."""
    faults: dict[str, Fault] = {}

    def do(work: Callable[..., Any], tasks: Sequence[Task], **_: Any) -> Iterator[tuple[int, Done]]:
        for place, task in enumerate(tasks):
            fault = faults.get(Path(str(task.film)).name)
            found = tuple(work(job, task.film) for job in task.jobs)
            yield place, Done(tuple(LostJob("gone", 1.0, fault) if fault else one for one in found), "fake")

    monkeypatch.setattr(collecting, "run_tasks", do)
    return faults


def run(manifest: Path, badge: Badge, pipelines: tuple[Any, ...] = ("moireid",), **options: Any) -> list[ScoredFilm]:
    """Score by the stub, into `results` next to the manifest; one worker by default."""
    entries = read_manifest(manifest, badge=badge).entries
    given = {"workers": 1, "limits": QUICK, "work": score} | options
    return collect(entries, pipelines, kept=manifest.parent / "results.jsonl", **given)


def begun(folder: Path) -> list[str]:
    """Films with their pipelines as they were begun since the last call."""
    found = [f"{line[1]} {line[2]}" for line in notes(folder / "log")]
    (folder / "log").unlink(missing_ok=True)
    return sorted(found)


def table_of(folder: Path) -> list[dict[str, Any]]:
    """The rows that are kept."""
    return list(kept_rows(folder / "results.jsonl").values())


def test_a_run_goes_on_where_it_was_broken_off(tmp_path: Path, prototype: Badge, ada: Badge, lost: dict[str, Fault]):
    """Catches: films scored twice, another film's, claim's or program's row taken, a fault that is tried for ever or
    never, old rows next to new ones.
    """

    def stop(*steps: int) -> None:
        raise KeyboardInterrupt

    films = (("a.txt", "0 aa"), ("b.txt", "0 bb"), ("c.txt", "0 unreadable cc"))
    manifest = manifest_of(tmp_path, *films)
    lost["b.txt"] = "crash"
    with pytest.raises(KeyboardInterrupt):
        run(manifest, prototype, BOTH, progress=stop)
    assert begun(tmp_path) == ["a.txt moireid", "a.txt published"] and len(table_of(tmp_path)) == 2
    steps: list[tuple[int, ...]] = []
    scored = run(manifest, prototype, BOTH, progress=lambda *figures: steps.append(figures))
    assert begun(tmp_path) == [f"{name}.txt {pipeline}" for name in "bc" for pipeline in BOTH]
    assert steps == [(2, 3, 1, 1), (3, 3, 2, 1)]
    rows = {(one.entry.name, one.pipeline): one.row for one in scored}
    assert [rows[name, "moireid"]["fault"] for name in ("a.txt", "b.txt", "c.txt")] == [None, "crash", "film"]
    assert rows["a.txt", "published"]["score"] == 3.0 and rows["b.txt", "moireid"]["verdict"] == "failed"
    # Labelled anew, nothing is scored anew; asked to try again, only what the film's own content does not say.
    assert run(manifest_of(tmp_path, *films, label="forged"), prototype, BOTH)[0].row == rows["a.txt", "moireid"]
    assert begun(tmp_path) == []
    run(manifest, prototype, BOTH, retry=True)
    assert begun(tmp_path) == ["b.txt moireid", "b.txt published"]
    # A film that changed is scored anew, and so is one of another claim.
    run(manifest_of(tmp_path, ("a.txt", "0 more aaa"), *films[1:]), prototype, BOTH)
    assert begun(tmp_path) == ["a.txt moireid", "a.txt published"] and len(table_of(tmp_path)) == 8
    run(manifest, ada)
    assert begun(tmp_path) == ["a.txt moireid", "b.txt moireid", "c.txt moireid"] and len(table_of(tmp_path)) == 11


@pytest.mark.parametrize(
    "change",
    [
        {"verdict": "original"},
        {"score": "high"},
        {"more": 1},
        {"sha256": "x"},
        {"fault": "worker"},
        {"codes": None},
        None,
    ],
)
def test_an_answer_that_is_no_row_counts_as_a_film_that_failed(
    tmp_path: Path, prototype: Badge, monkeypatch: pytest.MonkeyPatch, change: dict[str, Any] | None
):
    """Catches: a film that took over its process, and ends the run of all films by what it answers."""
    row = failed_row(LostJob("no film", 0.0, "film"))

    def do(work: Callable[..., Any], tasks: Sequence[Task], **_: Any) -> Iterator[tuple[int, Done]]:
        yield 0, Done((row,), "fake")
        yield 1, Done((None if change is None else row | change,), "fake")

    monkeypatch.setattr(collecting, "run_tasks", do)
    one, other = run(manifest_of(tmp_path, ("a.txt", "0 aa"), ("b.txt", "0 bb")), prototype)
    assert one.row["fault"] == "film" and one.row["error"] == "no film"
    assert (other.row["verdict"], other.row["fault"]) == ("failed", "crash")
    assert "answers what no film shows" in other.row["error"]


def test_a_row_says_how_its_film_was_read(tmp_path: Path, prototype: Badge):
    """Catches: a collection whose rows do not say what a film could reach; the word of the process that read it."""
    (one,) = run(manifest_of(tmp_path, ("a.txt", "0 aa")), prototype, work=score_as_sealed)
    assert one.row["sealed"] == list(sealed_here()) and one.row["verdict"] == "accept"
    assert [row["sealed"] for row in table_of(tmp_path)] == [one.row["sealed"]]


def test_a_fault_that_may_pass_is_tried_by_the_next_run(tmp_path: Path, prototype: Badge, lost: dict[str, Fault]):
    """Catches: a film whose worker was lost for an hour left out for ever, a fault of ours kept for good."""
    manifest = manifest_of(tmp_path, *((f"{fault}.txt", f"0 {fault}") for fault in PASSING))
    lost |= {f"{fault}.txt": fault for fault in PASSING}
    assert all(one.row["again"] and one.row["error"] == "gone" for one in run(manifest, prototype))
    lost.clear()
    assert [one.row["score"] for one in run(manifest, prototype)] == [3.0] * 2
    assert [row["fault"] for row in table_of(tmp_path)] == [None] * 2


def test_one_film_under_two_names_is_refused(tmp_path: Path, prototype: Badge, lost: dict[str, Fault]):
    """Catches: a film that counts twice, rows thrown away with the refusal."""
    manifest = manifest_of(tmp_path, ("a.txt", "0 aa"), ("b.txt", "0 aa"))
    with pytest.raises(SpecError, match=r"lines 2 and 3 list one film with one claim \('a.txt' and 'b.txt'\)"):
        run(manifest, prototype)
    assert len(begun(tmp_path)) == 2 == len(table_of(tmp_path))
    manifest.write_text("video,label,claim,group\na.txt,genuine,,\n./a.txt,forged,,\na.txt,forged,,\n")
    with pytest.raises(SpecError, match="lines 2 and 3 list one film"):
        run(manifest, prototype)
    assert begun(tmp_path) == []


@pytest.mark.slow
def test_a_run_that_is_killed_loses_no_finished_row(tmp_path: Path, prototype: Badge):
    """Catches: rows held back in memory, a run that begins anew, children that outlive it and work on."""
    manifest = manifest_of(tmp_path, *((f"f{k}.txt", f"0.15 {k}") for k in range(12)))
    (tmp_path / "badge.json").write_text(prototype.to_json())
    code = (
        "import sys; sys.path[:0] = sys.argv[3:]\n"
        "from pathlib import Path\n"
        "from test_collect import run\n"
        "from moireid.badge import load_badge\n"
        "if __name__ == '__main__': run(Path(sys.argv[1]), load_badge(Path(sys.argv[2])))"
    )
    paths = [str(Path(moireid.__file__).parent.parent), str(TESTS), str(Path(__file__).parent)]
    process = subprocess.Popen([sys.executable, "-c", code, str(manifest), str(tmp_path / "badge.json"), *paths])
    last = time.monotonic() + 90
    while len(table_of(tmp_path)) < 4:
        assert process.poll() is None and time.monotonic() < last
        time.sleep(0.01)
    children = psutil.Process(process.pid).children(recursive=True)
    process.send_signal(signal.SIGKILL)
    process.wait()
    assert children and psutil.wait_procs(children, timeout=last - time.monotonic())[1] == []
    finished = len(table_of(tmp_path))
    steps: list[tuple[int, ...]] = []
    assert len(run(manifest, prototype, progress=lambda *now: steps.append(now))) == 12
    # The last number says how many films were reused from the run before.
    assert 4 <= finished < 12 and steps[-1] == (12, 12, 0, finished)


def test_the_film_is_scored_where_it_was_fetched_to(films: Path, prototype: Badge, tmp_path: Path):
    """Catches: an error that names a folder drawn anew each time, a fetched film's digest left out."""
    broken = tmp_path / "film.mp4"
    broken.write_bytes(b"no film at all")
    (entry,) = read_manifest(manifest_of(tmp_path, ("film.mp4", "")), badge=prototype).entries
    row = score_film(Job(entry, "moireid"), str(films / "README.md"))
    assert row["fault"] == "film" and str(films) not in row["error"] and entry.video in row["error"]
    assert len(row["sha256"]) == 64 and set(row) == set(ScoredRow.__struct_fields__)
    assert failed_row(LostJob("gone", 1.0, "worker"))["again"]
