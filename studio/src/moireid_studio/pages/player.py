"""The law beneath the film as it plays: what the page's script draws, made of the signals that a job's process left.

The studio keeps no film.  The visitor's own copy is played, on the visitor's machine; it is not sent again.
"""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import islice
from typing import Any

import numpy as np

from moireid.verifier.camera.stretches import longest_step_s
from moireid.verifier.report.seconds import Seconds
from moireid_studio.jobs.task import SIGNALS
from moireid_studio.problems import Refusal
from moireid_studio.reports import kept_file
from moireid_studio.store.job import Job

#: Frames that are drawn at most, and digits of their times and places.
MOST_FRAMES, DIGITS = 5000, 4
Row = tuple[float, float, float]


@dataclass(frozen=True)
class Course:
    """What is drawn; times in s of the film's own clock, which begins at `from_s`.

    sha256: of the film as the server received it; frames: time, and where the law puts the fringes and where they
    were seen, in fringe widths; None where they were not seen, and in all three where frames are missing.
    """

    sha256: str
    from_s: float
    to_s: float
    frames: list[list[float | None]]

    def to_json(self) -> dict[str, Any]:
        return {"from_s": self.from_s, "to_s": self.to_s, "frames": self.frames}


def course_of(job: Job, seconds: Seconds | None) -> Course | None:
    """The course of a job's film; None where there is none, or where its process left what is no course."""
    result: dict[str, Any] = job.result or {}
    if seconds is None or not job.kept or job.film_sha256 is None:
        return None
    try:
        rows = list(islice(_rows(kept_file(job, SIGNALS).decode()), MOST_FRAMES))
        film = result["cover"]["film_s"]
        first, last = float(film[0]), float(film[1])
    except (Refusal, ValueError, KeyError, TypeError, csv.Error):
        return None
    return Course(job.film_sha256, first, last, _with_gaps(rows)) if len(rows) > 1 else None


def _rows(text: str) -> Iterator[Row]:
    """Time, law and fringes as seen (NaN where nobody saw them) of each line.  Raises: ValueError, KeyError."""
    for line in csv.DictReader(io.StringIO(text)):
        row = (float(line["time_s"]), float(line["predicted_rad_0"]), float(line["measured_rad_0"]))
        if not (math.isfinite(row[0]) and math.isfinite(row[1])):
            raise ValueError("a frame has no time, or no place")
        known = math.isfinite(float(line["phase_sd_rad_0"]))
        yield row if known else (row[0], row[1], math.nan)


def _with_gaps(rows: list[Row]) -> list[list[float | None]]:
    """The rows in fringe widths, with an empty one wherever frames are missing."""
    longest, found, before = longest_step_s(np.array([row[0] for row in rows])), list[list[float | None]](), rows[0][0]
    for time_s, law, seen in rows:
        if time_s - before > longest:
            found.append([None, None, None])
        before = time_s
        widths = [round(value / (2 * math.pi), DIGITS) if math.isfinite(value) else None for value in (law, seen)]
        found.append([round(time_s, DIGITS), *widths])
    return found
