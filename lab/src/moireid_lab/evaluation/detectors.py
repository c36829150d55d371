"""Scores of other detectors next to ours: read from a list, and compared with the same labels.

They are no part of any verdict.  A detector of generated faces, for example, examines what the badge cannot show.  So
the two are shown side by side, film by film, and a user who has both can require both.
Convention: `score` rises with genuineness, as ours does; `fake_score`, as many detectors give it, falls, and its sign
    is turned round here.
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from moireid.errors import SpecError
from moireid_lab.evaluation.collect import ScoredFilm
from moireid_lab.evaluation.csv_lists import read_list
from moireid_lab.evaluation.manifest import Entry
from moireid_lab.evaluation.summary import plain, scores_of, separation

Document = dict[str, Any]
EXAMPLE = (
    "give a CSV file whose first line is video,score (or video,fake_score, where high means fake), and detector as a "
    "third column if there are several"
)
#: The name of a detector that the list does not name.
UNNAMED = "detector"
#: By detector, and line of the manifest: the score.
Scores = dict[str, dict[int, float]]


def read_detectors(path: str | os.PathLike[str], entries: Sequence[Entry]) -> Scores:
    """Read scores of other detectors for the films of a manifest.

    Parameters: entries: films, which the list names as the manifest does.
    Raises: SpecError where the file is no such list, names a film that the manifest has not, or one twice.
    """
    name = Path(path)
    lines: dict[str, list[int]] = {}
    for entry in entries:
        lines.setdefault(entry.name, []).append(entry.line)
    found: Scores = {}
    for where, film, detector, score in _rows(name):
        if film not in lines:
            raise SpecError(f"{where} names film {film[:60]!r}, unknown to the manifest; write it as there")
        scores = found.setdefault(detector, {})
        if lines[film][0] in scores:
            raise SpecError(f"{where} gives film {film[:60]!r} a second score; leave one of them out")
        scores |= dict.fromkeys(lines[film], score)
    if not found:
        raise SpecError(f"detector scores {name} hold no score; {EXAMPLE}")
    return found


def with_detectors(document: Document, scored: Sequence[ScoredFilm], detectors: Scores, *, seed: int) -> Document:
    """The figures of a collection, with those of other detectors next to them.

    Parameters: document: as `summary.summarise` gives it; detectors: as `read_detectors`.
    Returns: a new document with `detectors`, and with the scores in each row.
    """
    rows = [row | {"detectors": _of_line(detectors, row["line"])} for row in document["rows"]]
    figures: Document = plain({name: _figures(scored, scores, seed) for name, scores in detectors.items()})
    return document | {"detectors": figures, "rows": rows}


def _figures(scored: Sequence[ScoredFilm], scores: Mapping[int, float], seed: int) -> Document:
    """One detector, and our pipelines on the very films that it scored."""
    films = {one.entry.line: one.entry for one in scored}
    genuine, forged = (
        np.array([scores[line] for line, entry in films.items() if line in scores and entry.genuine == kind], float)
        for kind in (True, False)
    )
    own = [one for one in scored if one.entry.line in scores]
    return {
        "films": len(films),
        "without_score": sum(line not in scores for line in films),
        "scored_films": separation(genuine, forged, seed, means=False),
        "ours_on_these": {name: _ours(own, name, seed) for name in dict.fromkeys(one.pipeline for one in own)},
    }


def _ours(own: list[ScoredFilm], pipeline: str, seed: int) -> Document:
    """A pipeline of ours on the same films; one without a score ranks lowest."""
    genuine, forged = (
        scores_of([one for one in own if one.pipeline == pipeline and one.entry.genuine == kind])
        for kind in (True, False)
    )
    return separation(genuine, forged, seed, means=False)


def _of_line(detectors: Scores, line: int) -> dict[str, float]:
    return {name: scores[line] for name, scores in detectors.items() if line in scores}


def _rows(path: Path) -> Iterator[tuple[str, str, str, float]]:
    """Where each line is, its film, its detector and its score, high for genuine.  Raises: SpecError."""
    columns, lines = read_list(path, "detector scores", ("video",), EXAMPLE)
    kinds = [column for column in ("score", "fake_score") if column in columns]
    if len(kinds) != 1:
        raise SpecError(f"detector scores {path} have the columns {','.join(columns)[:80]!r}; {EXAMPLE}")
    for line, row in lines:
        where = f"line {line} of {path}"
        score = _score(where, row[kinds[0]])
        yield where, row["video"], row.get("detector") or UNNAMED, score if kinds[0] == "score" else -score


def _score(where: str, text: str) -> float:
    try:
        score = float(text)
    except ValueError:
        score = math.nan
    if not math.isfinite(score):
        raise SpecError(f"{where} gives score {text[:40]!r}, which is no finite number; write one, or drop the line")
    return score
