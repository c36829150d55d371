"""The scoreboard: every part's questions, answered by this version of the sources.

A row is one case.  It is kept by the version of the sources that it depends on (`sources`), its part and its name, from
which all chance follows.  Rows are added to a file whole or not at all, so an interrupted run loses the cases that were
being made.  Parts and cases are mixed, so that a run of limited time has the same share of each part.
"""

from __future__ import annotations

import json
import math
import os
import time
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np

from moireid import __version__
from moireid.files import write_text
from moireid.result_cache import kept_rows
from moireid_lab.bench.bench_rows import Where, make_rows
from moireid_lab.bench.part import Asked, Row, interleaved
from moireid_lab.bench.sources import version_of
from moireid_lab.bench.suites import PARTS, module_of, part_of
from moireid_lab.evaluation.statistics import interval

ROWS, DOCUMENT = "rows.jsonl", "scoreboard.json"
OUTCOMES = ("right", "inconclusive", "wrong")
#: What a row has besides figures.
NOT_FIGURES = ("part", "case", "kind", "answers", "verdict", "why", "version", "date", "s")


@dataclass(frozen=True)
class PlannedCase:
    """One case of the scoreboard; version: of its sources."""

    part: str
    name: str
    version: str

    @property
    def key(self) -> str:
        """Names all that the row depends on."""
        return f"{self.version} {self.part} {self.name}"


def current_version(part: str) -> str:
    """The version of the sources of a part's rows."""
    return version_of(module_of(part), *part_of(part).sources)


def plan(asked: Asked, *, short: bool = False) -> list[PlannedCase]:
    """All cases in the order in which they are made; short: those of the short scoreboard."""
    parts = []
    for name in PARTS:
        cases = list(part_of(name).cases(asked))
        version = current_version(name)
        wanted = cases[: part_of(name).short] if short else cases
        parts.append({f"{name} {case}": PlannedCase(name, case, version) for case in wanted})
    return list(interleaved(*parts).values())


def judged(job: tuple[str, str, str, Asked, Path]) -> Row:
    """The row of one case; runs in a process of the engine."""
    part, name, version, asked, folder = job
    begun, own = _processor_s(), folder / part
    own.mkdir(parents=True, exist_ok=True)
    row = part_of(part).judge(part_of(part).cases(asked)[name], own)
    about = {"part": part, "case": name, "version": version, "date": datetime.now(UTC).date().isoformat()}
    return about | {"s": round(_processor_s() - begun, 2)} | row


def _processor_s() -> float:
    """Processor time of this process and of those that it waited for."""
    times = os.times()
    return times.user + times.system + times.children_user + times.children_system


def run(
    cases: Sequence[PlannedCase],
    asked: Asked,
    kept: Path,
    folder: Path,
    *,
    where: Where,
    hours: float | None = None,
    progress: Callable[[int, int], None],
) -> list[str]:
    """Make the rows that are not kept yet, until the time is over.

    Parameters: kept: file of rows; folder: for films; hours: after which no case is begun.
    Returns: why cases gave no row.
    """
    end = time.monotonic() + 3600 * (math.inf if hours is None else hours)
    jobs = {
        case.key: (case.part, case.name, case.version, asked, folder)
        for case in cases
        if asked.data or not part_of(case.part).needs_data
    }
    stop = lambda: time.monotonic() > end  # noqa: E731
    return make_rows(judged, jobs, kept=kept, where=where, progress=progress, stop=stop)[1]


def newest(cases: Iterable[PlannedCase], kept: Path) -> list[Row]:
    """The newest row of each case, of this version where there is one; the file is left with no other."""
    by_case: dict[tuple[str, str], tuple[str, Row]] = {}
    rows = kept_rows(kept)
    for key, row in rows.items():
        by_case[row["part"], row["case"]] = key, row
    found = []
    for case in cases:
        if case.key in rows:
            found.append((case.key, rows[case.key]))
        elif (case.part, case.name) in by_case:
            found.append(by_case[case.part, case.name])
    write_text(kept, "".join(json.dumps({"key": key, "row": row}) + "\n" for key, row in found))
    return [row for _, row in found]


def document_of(cases: Sequence[PlannedCase], rows: Sequence[Row]) -> dict[str, Any]:
    """The scoreboard: an entry for each question and version of its sources, and what each part takes."""
    planned = Counter(case.part for case in cases)
    entries = []
    for name in planned:
        own = [row for row in rows if row["part"] == name]
        for version in dict.fromkeys(row["version"] for row in own):
            of_version = [row for row in own if row["version"] == version]
            entries += [_entry(name, question, version, of_version) for question in part_of(name).questions]
    taken = [
        {"part": name, "cases": count, "s_a_case": round(float(np.mean(seconds)), 2)}
        for name, count in planned.items()
        if (seconds := [row["s"] for row in rows if row["part"] == name])
    ]
    questions = [entry for entry in entries if entry["films"]]
    return {"moireid": __version__, "questions": questions, "parts": taken}


def _entry(part: str, question: str, version: str, rows: Sequence[Row]) -> dict[str, Any]:
    """One question, answered by the rows of one version."""
    answering = [row for row in rows if question in row["answers"]]
    kinds = {row["kind"]: [one for one in answering if one["kind"] == row["kind"]] for row in answering}
    counts = counted(answering, question)
    films_by = part_of(part).films_by
    return {
        "part": part,
        "question": question,
        "text": part_of(part).questions[question],
        "films_by": films_by if isinstance(films_by, str) else films_by[question],
        **counts,
        "interval": [round(end, 4) for end in interval(counts["right"], counts["films"])],
        "command": f"moireid lab bench {part}",
        "version": version,
        "date": max((row["date"] for row in answering), default=""),
        "kinds": [{"kind": kind, **counted(own, question), **described(own)} for kind, own in kinds.items()],
    }


def counted(rows: Sequence[Row], question: str) -> dict[str, int]:
    """How many judgements there are, and how many are right, inconclusive and wrong."""
    counts = [sum(row["answers"][question][place] for row in rows) for place in range(3)]
    return {"films": sum(counts)} | dict(zip(OUTCOMES, counts, strict=True))


def described(rows: Sequence[Row]) -> dict[str, Any]:
    """The most frequent findings against acceptance; and of each figure the least, the median and the greatest."""
    why = Counter(code for row in rows for code in row.get("why", ())).most_common(3)
    figures = {name: [row[name] for row in rows if _is_number(row.get(name))] for row in rows for name in row}
    shown = {
        name: [float(f"{one:.4g}") for one in (min(values), float(np.median(values)), max(values))]
        for name, values in figures.items()
        if values and name not in NOT_FIGURES
    }
    return {"why": ", ".join(code for code, _ in why), "figures": shown}


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)
