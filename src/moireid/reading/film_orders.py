"""What is read of films: functions that a process carries out which may do nothing else.

An order is one of them with its arguments (`functools.partial`), pickled for that process.
Convention: an order holds no key, no registry and no address.  Results are sent as JSON, as `Child.hear` reads them.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import msgspec

from moireid.badge import Badge
from moireid.extras import missing_extra
from moireid.question import KnownCamera, Question

#: Callbacks of the process that reads: a part of the result; a question to the process that ordered; frames read.
Send = Callable[[dict[str, Any]], None]
Ask = Callable[[dict[str, Any]], Any]
Progress = Callable[[int, int | None], None]
Order = Callable[[Send, Ask, Progress], None]


def judge_film(
    send: Send, ask: Ask, progress: Progress, *, film: Path, question: Question, pictures: bool = False
) -> None:
    """Send the report on a film, as `verifier.verify` makes it; then, if asked for, the pictures of its page."""
    if question.published:
        report = published_method().verify_published(film, question, progress=progress)
    else:
        from moireid.verifier.session.film import verify

        report = verify(film, question, progress=progress)
    send({"result": report.to_json()})
    if pictures:
        from moireid.verifier.report.report_page import pictures_of

        send({"pictures": msgspec.to_builtins(pictures_of(report))})


def published_method() -> Any:
    """The published method, which is in the lab.  Raises: MissingExtraError where that is not installed."""
    from importlib.metadata import entry_points

    for point in entry_points(group="moireid.pipelines", name="published"):
        return point.load()
    raise missing_extra("the published method", "moireid-lab", "", "moireid-lab")


def identify_film(
    send: Send,
    ask: Ask,
    progress: Progress,
    *,
    film: Path,
    layouts: Sequence[Badge],
    camera: KnownCamera | None = None,
    track: int | None = None,
) -> None:
    """Send whose badge a film shows, as `verifier.identify` finds it."""
    from moireid.verifier.session.identify import identify

    # The process that has the registry answers.
    found = identify(
        film, layouts, lambda read: bool(ask({"holds": read})), camera=camera, track=track, progress=progress
    )
    send({"result": found.to_json()})


def measure_captures(
    send: Send,
    ask: Ask,
    progress: Progress,
    *,
    films: Sequence[Path],
    badge: Badge,
    camera: KnownCamera | None = None,
    measured_scale: float | None = None,
    track: int | None = None,
) -> None:
    """Send the as-built figures that films of a badge show, as `capture_as_built` measures them."""
    from moireid.verifier.session.capture import capture_as_built

    found = capture_as_built(films, badge, camera=camera, measured_scale=measured_scale, track=track, progress=progress)
    send({"result": json.loads(found.to_json())})
