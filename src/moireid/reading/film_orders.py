"""What is read of films: functions that a process carries out which may do nothing else.

An order is one of them with its arguments (`functools.partial`), pickled for that process.
Convention: an order holds no key, no registry and no address.  The parts of its answer are sent as JSON, as
    `Child.hear` reads them.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import msgspec

from moireid.badge import Badge
from moireid.extras import missing_extra
from moireid.question import Question

#: Called with frames read, and the number expected.
Progress = Callable[[int, int | None], None]
#: The parts of an answer: "result", and for a page then "pictures".
Parts = Iterator[dict[str, Any]]
Order = Callable[[Progress], Parts]


def judge_film(progress: Progress, *, film: Path, question: Question, pictures: bool = False) -> Parts:
    """The report on a film, as `verifier.verify` makes it; then, if asked for, the pictures of its page."""
    if question.published:
        report = published_method().verify_published(film, question, progress=progress)
    else:
        from moireid.verifier.session.film import verify

        report = verify(film, question, progress=progress)
    yield {"result": report.to_json()}
    if pictures:
        from moireid.verifier.report.report_page import pictures_of

        yield {"pictures": msgspec.to_builtins(pictures_of(report))}


def published_method() -> Any:
    """The published method, which is in the lab.  Raises: MissingExtraError where that is not installed."""
    from importlib.metadata import entry_points

    for point in entry_points(group="moireid.pipelines", name="published"):
        return point.load()
    raise missing_extra("the published method", "moireid-lab", "", "moireid-lab")


def identify_film(progress: Progress, *, film: Path, layouts: Sequence[Badge], **known: Any) -> Parts:
    """Whose badge a film shows if it is enrolled, as `verifier.identify` finds it; known: as there."""
    from moireid.verifier.session.identify import identify

    yield {"result": identify(film, layouts, progress=progress, **known).to_json()}


def measure_captures(progress: Progress, *, films: Sequence[Path], badge: Badge, **known: Any) -> Parts:
    """The as-built figures that films of a badge show, as `capture_as_built` measures them; known: as there."""
    from moireid.verifier.session.capture import capture_as_built

    yield {"result": json.loads(capture_as_built(films, badge, progress=progress, **known).to_json())}
