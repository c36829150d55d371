"""The scoreboard: every part's questions, answered by this version of the sources.

A row is one case, of whose part and name all chance follows.  It is kept with the version of the files that it depends
on (`sources`), and made again once they have changed.  Rows are added to a file whole or not at all, so an interrupted
run loses the cases that were being made.  Parts take turns, so that a run of limited time has as many cases of each.
"""

from __future__ import annotations

import json
import math
import time
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from moireid import __version__
from moireid.files import write_text
from moireid.result_cache import kept_rows
from moireid_lab.bench.bench_rows import Where, make_rows
from moireid_lab.bench.part import Asked, Row
from moireid_lab.bench.sources import is_older, version_of
from moireid_lab.bench.suites import PARTS, part_of
from moireid_lab.evaluation.statistics import interval

ROWS, DOCUMENT = "rows.jsonl", "scoreboard.json"
OUTCOMES = ("right", "inconclusive", "wrong")
#: What a row has besides figures.
NOT_FIGURES = ("part", "case", "kind", "answers", "verdict", "why", "version", "date", "s", "files")
#: So many cases of a part are made before another one's turn: a process of a part takes seconds to start.
TURN = 12
#: A case: its part and its name there.
Case = tuple[str, str]


def plan(asked: Asked, *, short: bool = False) -> dict[str, Case]:
    """All cases by the key of their row, in the order in which they are made; short: those of the short scoreboard."""
    turns: dict[int, dict[str, Case]] = {}
    for part in PARTS:
        cases = list(part_of(part).cases(asked))
        for k, case in enumerate(cases[: part_of(part).short] if short else cases):
            turns.setdefault(k // TURN, {})[f"{part} {case}"] = part, case
    return {key: case for turn in sorted(turns) for key, case in turns[turn].items()}


def run(
    cases: Mapping[str, Case],
    asked: Asked,
    kept: Path,
    folder: Path,
    *,
    where: Where,
    hours: float | None = None,
    progress: Callable[[int, int], None],
) -> list[str]:
    """Make the rows that are not kept yet, or older, until the time is over.

    Parameters: kept: file of rows; folder: for films; hours: after which no case is begun.
    Returns: why cases gave no row.
    """
    end = time.monotonic() + 3600 * (math.inf if hours is None else hours)
    jobs = {
        key: (part, case, asked, folder)
        for key, (part, case) in cases.items()
        if asked.data or not part_of(part).needs_data
    }
    stop = lambda: time.monotonic() > end  # noqa: E731
    return make_rows(jobs, kept=kept, where=where, progress=progress, stop=stop)[1]


def newest_rows(cases: Iterable[str], kept: Path) -> list[Row]:
    """The newest row of each case that has one, with the files that it depends on."""
    lines = kept_rows(kept)
    return [row | lines.get(row["version"], {"files": []}) for key in cases if (row := lines.get(key))]


def tidy(cases: Iterable[str], kept: Path) -> None:
    """Leave a file with the newest rows of cases, and the lists of files that they depend on, alone."""
    lines = kept_rows(kept)
    rows = {key: lines[key] for key in cases if key in lines}
    files = {row["version"]: lines[row["version"]] for row in rows.values() if row["version"] in lines}
    write_text(kept, "".join(json.dumps({"key": key, "row": row}) + "\n" for key, row in (files | rows).items()))


def document_of(cases: Mapping[str, Case], rows: Sequence[Row]) -> dict[str, Any]:
    """The scoreboard: an entry for each question, another one for its older rows, and what each part takes."""
    planned = Counter(part for part, _ in cases.values())
    entries = []
    for name in planned:
        own = [row for row in rows if row["part"] == name]
        for older in (False, True):
            some = [row for row in own if is_older(row) == older]
            entries += [_entry(name, question, some, older) for question in part_of(name).questions]
    taken = [
        {"part": name, "cases": count, "s_a_case": round(float(np.mean(seconds)), 2)}
        for name, count in planned.items()
        if (seconds := [row["s"] for row in rows if row["part"] == name])
    ]
    return {"moireid": __version__, "questions": [entry for entry in entries if entry["films"]], "parts": taken}


def _entry(part: str, question: str, rows: Sequence[Row], older: bool) -> dict[str, Any]:
    """One question, answered by rows; its version is that of all their files, and of older ones the newest row's."""
    answering = [row for row in rows if question in row["answers"]]
    newest = max(answering, key=lambda row: row["date"], default={"date": "", "version": ""})
    kinds: dict[str, list[Row]] = {}
    for row in answering:
        # What is before a colon names the badge, or the scene: all of them are one kind.
        kinds.setdefault(row["kind"].split(": ")[-1], []).append(row)
    counts, files = counted(answering, question), sorted({one for row in answering for one in row["files"]})
    films_by = part_of(part).films_by
    return {
        "part": part,
        "question": question,
        "text": part_of(part).questions[question],
        "films_by": films_by if isinstance(films_by, str) else films_by[question],
        **counts,
        "interval": [round(end, 4) for end in interval(counts["right"], counts["films"])],
        "command": f"moireid lab bench {part}",
        "older": older,
        "version": newest["version"] if older else version_of(files),
        "date": newest["date"],
        "kinds": [{"kind": kind, **counted(own, question), **described(own)} for kind, own in kinds.items()],
    }


def counted(rows: Sequence[Row], question: str) -> dict[str, int]:
    """How many judgements there are, and how many are right, inconclusive and wrong."""
    counts = [sum(row["answers"][question][place] for row in rows) for place in range(3)]
    return {"films": sum(counts)} | dict(zip(OUTCOMES, counts, strict=True))


def described(rows: Sequence[Row]) -> dict[str, Any]:
    """The most frequent findings against acceptance; and of each figure the least, the median and the greatest."""
    why = Counter(code for row in rows for code in row.get("why", ())).most_common(3)
    figures = {name: [row[name] for row in rows if type(row.get(name)) in (int, float)] for row in rows for name in row}
    shown = {
        name: [float(f"{one:.4g}") for one in (min(values), float(np.median(values)), max(values))]
        for name, values in figures.items()
        if values and name not in NOT_FIGURES
    }
    return {"why": ", ".join(code for code, _ in why), "figures": shown}
