"""Rows of a collection: kept as they come, gone on with after a break, made anew where something changed."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import pytest

from kit.film_stubs import notes, score, score_as_sealed
from moireid.badge import Badge
from moireid.result_cache import kept_rows
from moireid.sandbox.process import sealed_here
from moireid_lab.archive.engine import Task
from moireid_lab.archive.isolated import Fault, Limits, LostJob
from moireid_lab.archive.worker import Done
from moireid_lab.evaluation import collect as collecting
from moireid_lab.evaluation.collect import ScoredFilm, collect
from moireid_lab.evaluation.film_rows import failed_row
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
