"""The scoreboard: rows, versions of sources, tables.  Each test states the wrong implementation that it catches."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

from kit.in_place import in_place
from moireid.cli.main import moireid
from moireid_lab.archive.isolated import LostJob
from moireid_lab.bench import bench_rows, scoreboard, sources
from moireid_lab.bench.bench_rows import Where
from moireid_lab.bench.part import INCONCLUSIVE, RIGHT, WRONG, Asked, Part, interleaved
from moireid_lab.bench.scoreboard import ROWS, document_of, judged, newest, plan, run
from moireid_lab.bench.scoreboard_tables import PAGES, SCOREBOARD, with_tables, written
from moireid_lab.evaluation.statistics import interval

ANSWERS = {"a": RIGHT, "b": RIGHT, "c": INCONCLUSIVE, "d": WRONG}


@pytest.fixture
def made(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """One part of four cases, in this process; what is made, in order.  Its version is the last of them."""
    names: list[str] = []

    def judge(case: str, folder: Path) -> dict[str, Any]:
        names.append(case)
        return {"kind": "letters", "answers": {"q": ANSWERS[case]}, "why": ["x"], "size": len(names)}

    part = Part({"q": "Is it right?"}, "nobody", lambda asked: {case: case for case in ANSWERS}, judge, short=1)
    monkeypatch.setattr(scoreboard, "PARTS", ("letters",))
    monkeypatch.setattr(scoreboard, "part_of", lambda name: part)
    monkeypatch.setattr(scoreboard, "module_of", lambda name: name)
    monkeypatch.setattr(scoreboard, "current_version", lambda name: "first")
    monkeypatch.setattr(bench_rows, "run_tasks", in_place)
    return names


def run_here(folder: Path, cases: list[scoreboard.PlannedCase]) -> list[str]:
    return run(cases, Asked(), folder / ROWS, folder, where=Where(), progress=lambda *_: None)


def test_rows_are_kept_by_the_version_of_their_sources(made: list[str], tmp_path: Path, monkeypatch):
    """Catches: a case that is made again, or is not once its sources have changed; older rows counted with the new."""
    assert run_here(tmp_path, plan(Asked())) == [] and made == list("abcd")
    assert run_here(tmp_path, plan(Asked())) == [] and len(made) == 4
    (entry,) = document_of(plan(Asked()), newest(plan(Asked()), tmp_path / ROWS))["questions"]
    assert [entry[name] for name in ("films", "right", "inconclusive", "wrong")] == [4, 2, 1, 1]
    assert entry["interval"] == pytest.approx(interval(2, 4), abs=1e-4) and entry["version"] == "first"
    assert entry["kinds"][0]["figures"]["size"] == [1, 2.5, 4]
    monkeypatch.setattr(scoreboard, "current_version", lambda name: "second")
    short = plan(Asked(), short=True)
    assert [case.name for case in short] == ["a"] and run_here(tmp_path, short) == [] and made[4:] == ["a"]
    rows = newest(plan(Asked()), tmp_path / ROWS)
    found = {one["version"]: one["films"] for one in document_of(plan(Asked()), rows)["questions"]}
    assert found == {"second": 1, "first": 3} and len((tmp_path / ROWS).read_text().splitlines()) == 4


def test_a_case_that_is_lost_is_named_and_made_again(made: list[str], tmp_path: Path, monkeypatch):
    """Catches: a run that ends with its first failure, or counts it as an answer."""

    def failing(job: Any) -> Any:
        return LostJob("it crashed", 1.0, "crash") if job[1] == "b" else judged(job)

    monkeypatch.setattr(scoreboard, "judged", failing)
    assert run_here(tmp_path, plan(Asked())) == ["first letters b: it crashed"] and made == list("acd")
    monkeypatch.setattr(scoreboard, "judged", judged)
    assert run_here(tmp_path, plan(Asked())) == [] and made == list("acdb")


def test_cases_of_all_kinds_take_turns():
    """Catches: all of one kind before the others, so that an hour has none of these; a kind of one case at the end."""
    found = list(interleaved({f"a{k}": k for k in range(4)}, {"b": 0}, {f"c{k}": k for k in range(2)}))
    assert found == ["a0", "b", "c0", "a1", "a2", "c1", "a3"]


def test_a_version_follows_what_is_imported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """Catches: an import within a function, or data next to a module, that changes no version; any change that does."""
    folder = tmp_path / "src" / "pack"
    folder.mkdir(parents=True)
    files = {"one.py": "def f():\n    from pack import two\n", "two.py": "x = 1\n", "other.py": "", "data.toml": ""}
    for name, text in files.items():
        (folder / name).write_text(text)
    monkeypatch.setattr(sources, "ROOT", tmp_path)

    def version() -> str:
        for cached in (sources.version_of, sources._file_of, sources._imports):
            cached.cache_clear()
        return sources.version_of("pack.one")

    before = version()
    (folder / "other.py").write_text("y = 2\n")
    assert version() == before
    for name in ("two.py", "data.toml", "one.py"):
        (folder / name).write_text(f"{(folder / name).read_text()}\n# more\n")
        now = version()
        assert now != before, name
        before = now
    for cached in (sources.version_of, sources._file_of, sources._imports):
        cached.cache_clear()


def test_readme_has_no_older_figure_and_the_other_page_says_which_are(made: list[str], tmp_path: Path, monkeypatch):
    """Catches: a figure of other sources in README; one that is not called older elsewhere."""
    run_here(tmp_path, plan(Asked()))
    document = document_of(plan(Asked()), newest(plan(Asked()), tmp_path / ROWS))
    document["questions"][0] |= {"part": "outside", "question": "genuine"}
    page = "<!-- scoreboard: readme -->\n<!-- end -->\n<!-- scoreboard: all -->\n<!-- end -->\n"
    now, later = (with_tables(page, document, {"outside": version}) for version in ("first", "second"))
    assert now.count("| Is it right? | nobody | 4 | 2 | 1 | 1 | 7 to 93 % |") == 2 and "older" not in now
    assert later.count("Is it right?") == 1 and "older, first" in later
    assert with_tables(later, document, {"outside": "first"}) == now


@pytest.mark.claim("Tables of README and accuracy are those of the scoreboard")
@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_pages_have_the_tables_of_the_scoreboard(page: Path):
    """Catches: a figure changed by hand, or left from older sources; the remedy is `make docs`."""
    assert page.read_text(encoding="utf-8") == written(page)


@pytest.mark.slow
@pytest.mark.timeout(3600)
@pytest.mark.claim("A few cases of the scoreboard come out as often right, and as often wrong, as it says")
def test_the_short_scoreboard_agrees_with_the_whole(tmp_path: Path):
    """Catches: a change by which films come out otherwise than the scoreboard says."""
    done = CliRunner().invoke(moireid, ["lab", "scoreboard", "--short", "--out", str(tmp_path), "--json"])
    assert done.exit_code == 0, done.stderr
    whole = {(one["part"], one["question"]): one for one in json.loads(SCOREBOARD.read_text())["questions"]}
    found = json.loads(done.stdout)["questions"]
    assert len(found) > 10
    for entry in found:
        known = whole.get((entry["part"], entry["question"]))
        for name in ("right", "wrong") if known else ():
            low, high = interval(known[name], known["films"])
            least, most = interval(entry[name], entry["films"])
            assert least <= high and most >= low, (entry["part"], entry["question"], name)
