"""The scoreboard: rows, versions of sources, tables.  Each test states the wrong implementation that it catches."""

from __future__ import annotations

import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from click.testing import CliRunner

from kit.in_place import in_place
from moireid.cli.main import moireid
from moireid.result_cache import kept_rows
from moireid_lab.archive.isolated import LostJob
from moireid_lab.bench import bench_rows, scoreboard, sources
from moireid_lab.bench.bench_rows import Where
from moireid_lab.bench.part import INCONCLUSIVE, RIGHT, WRONG, Asked, Part, interleaved
from moireid_lab.bench.scoreboard import ROWS, document_of, newest_rows, plan, run, tidy
from moireid_lab.bench.scoreboard_tables import PAGES, SCOREBOARD, with_tables, written
from moireid_lab.bench.sources import judged
from moireid_lab.evaluation.statistics import interval

ANSWERS = {"a": RIGHT, "b": RIGHT, "c": INCONCLUSIVE, "d": WRONG}


@pytest.fixture
def made(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """One part of four cases, in this process; what is made, in order.  Its rows depend on this file."""
    names: list[str] = []

    def judge(case: str, folder: Path) -> dict[str, Any]:
        names.append(case)
        return {"kind": f"{case}: letters", "answers": {"q": ANSWERS[case]}, "why": ["x"], "size": len(names)}

    part = Part({"q": "Is it right?"}, "nobody", lambda asked: {case: case for case in ANSWERS}, judge, short=1)
    monkeypatch.setattr(scoreboard, "PARTS", ("letters",))
    for module in (scoreboard, sources):
        monkeypatch.setattr(module, "part_of", lambda name: part)
    monkeypatch.setattr(sources, "loaded_files", lambda more: ["lab/tests/bench/test_scoreboard.py"])
    monkeypatch.setattr(bench_rows, "run_tasks", in_place)
    return names


def change(monkeypatch: pytest.MonkeyPatch) -> None:
    """As if each file had changed."""
    monkeypatch.setattr(sources, "_content", lambda name: "changed")


def run_here(folder: Path, cases: dict[str, tuple[str, str]]) -> list[str]:
    return run(cases, Asked(), folder / ROWS, folder, where=Where(), progress=lambda *_: None)


def documented(folder: Path) -> dict[str, Any]:
    return document_of(plan(Asked()), newest_rows(plan(Asked()), folder / ROWS))


def test_a_row_is_made_again_once_a_file_that_it_depends_on_has_changed(made: list[str], tmp_path: Path, monkeypatch):
    """Catches: a case that is made again, or is not once its sources have changed; older rows counted with the new; a
    kind of its own for each badge.
    """
    assert run_here(tmp_path, plan(Asked())) == [] and made == list("abcd")
    assert run_here(tmp_path, plan(Asked())) == [] and len(made) == 4
    (entry,) = documented(tmp_path)["questions"]
    assert [entry[name] for name in ("films", "right", "inconclusive", "wrong")] == [4, 2, 1, 1]
    assert entry["interval"] == pytest.approx(interval(2, 4), abs=1e-4) and not entry["older"]
    assert entry["kinds"][0]["figures"]["size"] == [1, 2.5, 4]
    change(monkeypatch)
    short = plan(Asked(), short=True)
    assert list(short) == ["letters a"] and run_here(tmp_path, short) == [] and made[4:] == ["a"]
    assert {one["older"]: one["films"] for one in documented(tmp_path)["questions"]} == {False: 1, True: 3}
    before = newest_rows(plan(Asked()), tmp_path / ROWS)
    tidy(plan(Asked()), tmp_path / ROWS)
    # Four rows, and the files of two versions.
    assert newest_rows(plan(Asked()), tmp_path / ROWS) == before and len(kept_rows(tmp_path / ROWS)) == 6
    assert len((tmp_path / ROWS).read_text().splitlines()) == 6


def test_words_about_the_code_change_no_row():
    """Catches: a row that is older for a comment; one that is not for a string, or for lines that moved inside one."""
    plain = 'def f(x):\n    return g(\n        """a\n\n# b""", x\n    )'
    wordy = '"""Page."""\n\n# Why.\n' + plain.replace("(x):", '(x):  # so\n    """Say.\n\n    More."""  # here\n')
    assert sources.code_of(wordy) == sources.code_of(plain) == plain
    assert sources.code_of(plain.replace("\n\n# b", "\n# b")) != plain


def test_a_case_that_is_lost_is_named_and_made_again(made: list[str], tmp_path: Path, monkeypatch):
    """Catches: a run that ends with its first failure, or counts it as an answer."""

    def failing(job: Any) -> Any:
        return LostJob("it crashed", 1.0, "crash") if job[1] == "b" else judged(job)

    monkeypatch.setattr(bench_rows, "judged", failing)
    assert run_here(tmp_path, plan(Asked())) == ["letters b: it crashed"] and made == list("acd")
    monkeypatch.setattr(bench_rows, "judged", judged)
    assert run_here(tmp_path, plan(Asked())) == [] and made == list("acdb")


def test_parts_take_turns(made: list[str], monkeypatch: pytest.MonkeyPatch):
    """Catches: all cases of one part before another's, so that an hour has none of these."""
    monkeypatch.setattr(scoreboard, "PARTS", ("one", "two"))
    monkeypatch.setattr(scoreboard, "TURN", 3)
    assert "".join(key[0] for key in plan(Asked())) == "oootttot"


def test_cases_of_all_kinds_take_turns():
    """Catches: all of one kind before the others, so that an hour has none of these; a kind of one case at the end."""
    found = list(interleaved({f"a{k}": k for k in range(4)}, {"b": 0}, {f"c{k}": k for k in range(2)}))
    assert found == ["a0", "b", "c0", "a1", "a2", "c1", "a3"]


def test_a_row_depends_on_what_its_process_has_loaded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """Catches: a module, or the data next to it, that no version follows; one that was not loaded; any other's file."""
    folder = tmp_path / "src" / "pack"
    folder.mkdir(parents=True)
    for name in ("one.py", "other.py", "data.toml", "notes.txt"):
        (folder / name).write_text("")
    monkeypatch.setattr(sources, "ROOT", tmp_path)
    loaded = {"pack.one": SimpleNamespace(__file__=str(folder / "one.py")), "json": json, "built": SimpleNamespace()}
    monkeypatch.setattr(sources, "sys", SimpleNamespace(modules=loaded))
    files = sources.loaded_files(["src/pack/notes.txt"])
    assert files == [f"src/pack/{name}" for name in ("data.toml", "notes.txt", "one.py")]
    before = sources.version_of(files)
    (folder / "one.py").write_text("x = 1")
    sources._content.cache_clear()
    assert sources.version_of(files) != before


def test_readme_has_no_older_figure_and_the_other_page_says_which_are(made: list[str], tmp_path: Path, monkeypatch):
    """Catches: a figure of other sources in README; one that is not called older elsewhere."""
    run_here(tmp_path, plan(Asked()))
    page = "<!-- scoreboard: readme -->\n<!-- end -->\n<!-- scoreboard: all -->\n<!-- end -->\n"
    pages = []
    for _ in range(2):
        document = documented(tmp_path)
        document["questions"][0] |= {"part": "outside", "question": "genuine"}
        pages.append(with_tables(page, document))
        change(monkeypatch)
    now, later = pages
    assert now.count("| Is it right? | nobody | 4 | 2 | 1 | 1 | 7 to 93 % |") == 2 and "older" not in now
    assert later.count("Is it right?") == 1 and "which is older" in later


def test_a_few_inconclusive_kinds_of_one_film_are_named():
    """Catches: a table that hides which effects leave a film inconclusive; a wrong kind that is hidden among others."""
    outcomes = {"zoom": "inconclusive", "eis": "inconclusive", "mix": "inconclusive", "call": "wrong"}
    kinds = [
        {"kind": kind, "films": 1, "right": 0, "inconclusive": 0, "wrong": 0, "why": "gain", "figures": {}}
        | {outcome: 1}
        for kind, outcome in outcomes.items()
    ]
    entry = {
        "part": "reality",
        "question": "q",
        "text": "Is it?",
        "older": False,
        "films": 4,
        "right": 0,
        "kinds": kinds,
    }
    table = with_tables("<!-- scoreboard: kinds reality -->\n<!-- end -->\n", {"questions": [entry]})
    assert "| kinds of one film each: zoom; eis; mix | 3 | 0 | 3 | 0 | gain |" in table
    assert "| call | 1 | 0 | 0 | 1 | gain |" in table


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
    whole = {(one["part"], one["question"]): one for one in documented(SCOREBOARD)["questions"]}
    found = json.loads(done.stdout)["questions"]
    assert len(found) > 10
    for entry in found:
        known = whole.get((entry["part"], entry["question"]))
        for name in ("right", "wrong") if known else ():
            low, high = interval(known[name], known["films"])
            least, most = interval(entry[name], entry["films"])
            assert least <= high and most >= low, (entry["part"], entry["question"], name)
